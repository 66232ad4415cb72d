//! What a run leaves behind: pictures, timings and the table on stdout.

pub mod dump;
pub mod files;
pub mod image_files;
pub mod machine;
pub mod statistics;
pub mod stats;
pub mod table;
pub mod timings;

pub use files::{FileKind, OutputFile};
pub use stats::Stats;
pub use timings::{FrameTimes, RunReport};
