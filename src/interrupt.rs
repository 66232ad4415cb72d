//! Signals. Ctrl-C: the first asks the run to stop and keep what it has, the second stops at once.

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

/// Has a write beyond the limit of a file's size fail like any other, instead of ending the process and leaving what it had
/// written. Once per process, at its start.
///
/// # Errors
/// [`Error::Failure`] when the system does not let it.
#[cfg(unix)]
pub fn outlive_file_limits() -> Result<()> {
    // Nobody reads the flag: what counts is that the signal is handled.
    static ARRIVED: AtomicBool = AtomicBool::new(false);
    signal_hook::flag::register(signal_hook::consts::SIGXFSZ, &ARRIVED)
        .map(drop)
        .map_err(|error| Error::Failure(format!("cannot handle SIGXFSZ: {error}")))
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
