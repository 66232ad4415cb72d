//! `gridlight diff-dumps A B`.

use super::say;
use crate::cli::DiffDumpsArgs;
use crate::report::dump::diff::{Options, compare};
use crate::{Error, Result};

/// Prints how two dumps compare, file by file, and the first pass that differs.
///
/// # Errors
/// [`Error::Threshold`] when they differ, [`Error::Usage`] when their settings do, [`Error::File`].
pub fn diff(args: &DiffDumpsArgs) -> Result<()> {
    let options = Options { tolerance: args.tolerance, ignore_settings: args.ignore_settings };
    let comparison = compare(&args.a, &args.b, options)?;
    say(&format!("{}\n\n{}", comparison.table(), comparison.sentence()))?;
    match comparison.first() {
        None => Ok(()),
        Some(row) => Err(Error::Threshold(format!("the dumps differ, first in {}", row.place()))),
    }
}
