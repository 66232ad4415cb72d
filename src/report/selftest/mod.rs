//! `gridlight selftest`: what the passes of small frames leave, told in numbers that rounding hardly changes, against what
//! another device left.

mod digest;
mod record;
mod scorecard;

pub use digest::{Digest, FileDigest};
pub use record::{Case, Record};
pub use scorecard::{LARGEST_DEVIATION, Scorecard};
