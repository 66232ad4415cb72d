//! Ctrl-C: the first asks the run to stop and keep what it has, the second stops at once.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::INTERRUPTED_EXIT_CODE;
use crate::{Error, Result};

static REQUESTED: AtomicBool = AtomicBool::new(false);

/// Starts listening. Once per process.
///
/// # Errors
/// [`Error::Failure`] when the system does not let it.
pub fn listen() -> Result<()> {
    let on_signal = || {
        if REQUESTED.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(INTERRUPTED_EXIT_CODE));
        }
    };
    ctrlc::set_handler(on_signal).map_err(|error| Error::Failure(format!("cannot listen for Ctrl-C: {error}")))
}

/// What a loop does next: `Break` once the run has been asked to stop.
pub fn control_flow() -> ControlFlow<()> {
    if requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
}

/// Whether the run has been asked to stop.
#[must_use]
pub fn requested() -> bool {
    REQUESTED.load(Ordering::Relaxed)
}
