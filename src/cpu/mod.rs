//! CPU twins of the compute stages: same names, same arithmetic, compared stage by stage in the tests; and what
//! is decided on the CPU before the first frame.

pub mod choose_levels;
