//! What a run leaves behind beside pictures: timings, dumps, error reports and what it says on stdout.

pub mod answer;
pub mod dump;
pub mod emptiness;
pub mod error_report;
pub mod inspected;
pub mod machine;
pub mod selftest;
pub mod summary;
pub mod table;
pub mod timings;

use serde::Serialize;

use crate::{Error, Result};

pub use error_report::ErrorReport;
pub use summary::Summary;
pub use timings::{FrameTimes, RunReport};

/// A report as an indented JSON document with a line break at its end.
///
/// # Errors
/// [`Error::Failure`] when a value cannot be expressed.
pub fn to_json(report: &impl Serialize) -> Result<Vec<u8>> {
    let mut text = serde_json::to_vec_pretty(report)
        .map_err(|error| Error::Failure(format!("cannot express the report as JSON: {error}")))?;
    text.push(b'\n');
    Ok(text)
}
