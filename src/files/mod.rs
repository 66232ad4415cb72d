//! Files that the program reads and writes, whatever is in them: they appear whole or not at all.

pub mod exr_texels;
pub mod guard;
mod mistaken;
mod output;
pub mod pictures;
pub mod sequence;
mod whole;

pub use mistaken::mistaken;
pub use output::{FileKind, OutputFile};
pub use pictures::Picture;
pub use whole::{open_regular, read_text, read_whole};

/// The version of a timings file's layout.
pub const TIMINGS_SCHEMA: &str = "gridlight-timings/1";
