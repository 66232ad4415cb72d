//! Rendering without a window.

use crate::progress::Progress;
use crate::report::files::Outputs;
use crate::settings::Settings;
use crate::{Error, Result};

/// Renders the frames that the settings ask for, writes the outputs and prints the table unless `quiet`.
///
/// # Errors
/// Whatever stands in the way; the outputs are then as they were.
pub fn render(settings: &Settings, _progress: Progress, _quiet: bool) -> Result<()> {
    let _outputs = Outputs::prepare(settings)?;
    Err(Error::Failure("this version cannot render yet".to_owned()))
}

/// Prints the frame graph of the settings as Graphviz.
///
/// # Errors
/// When the graph cannot be planned.
pub fn print_graph(_settings: &Settings) -> Result<()> {
    Err(Error::Failure("this version has no frame graph to print yet".to_owned()))
}
