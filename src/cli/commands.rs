//! The commands beside rendering, and their options.

use std::path::PathBuf;

use clap::ArgAction;

use crate::{Error, Result};

/// The commands beside rendering.
#[derive(Debug, clap::Subcommand)]
pub(super) enum Subcommand {
    /// Compare two dumps pass by pass and name the first pass that differs (exit 3 when one does)
    DiffDumps(DiffDumpsArgs),
}

/// Two dumps to compare.
#[derive(Clone, Debug, Default, PartialEq, clap::Args)]
#[command(next_help_heading = "Diff dumps")]
pub struct DiffDumpsArgs {
    /// Folder of a dump
    #[arg(value_name = "A")]
    pub a: PathBuf,
    /// Folder of another dump of the same settings
    #[arg(value_name = "B")]
    pub b: PathBuf,
    /// Largest relative difference of numbers that count as equal; 0 compares bits
    #[arg(long, value_name = "REL", default_value_t = 0.0, allow_negative_numbers = true)]
    pub tolerance: f64,
    /// Compare dumps of different settings
    #[arg(long)]
    pub ignore_settings: bool,
    /// Print this help
    #[arg(short, long, action = ArgAction::Help)]
    pub help: Option<bool>,
}

impl DiffDumpsArgs {
    /// Everything that can be found wrong without reading the dumps.
    pub(super) fn check(&self) -> Result<()> {
        if self.tolerance.is_finite() && self.tolerance >= 0.0 {
            return Ok(());
        }
        Err(Error::Usage(format!("tolerance must be a finite number, 0 or above, not {}", self.tolerance)))
    }
}
