//! Files that the program reads and writes, whatever is in them: they appear whole or not at all.

mod output;
pub mod pictures;

pub use output::{FileKind, OutputFile};
pub use pictures::Picture;

/// The version of a timings file's layout.
pub const TIMINGS_SCHEMA: &str = "gridlight-timings/1";
