//! The window: the same renderer and frames as in headless runs, moved through and changed while they run.

mod action;
mod app;
mod camera;
mod drag;
mod keys;
mod loader;
mod measuring;
mod panel;
mod presenter;
mod presets;
mod quality;
mod recent;
mod refinement;
#[cfg(feature = "shader-compiler")]
mod reload;
mod scale;
mod screenshot;
mod script;
mod session;
mod stage;
mod sun;

use std::path::Path;

use winit::error::EventLoopError;
use winit::event_loop::EventLoop;

use crate::settings::Settings;
use crate::{Error, Result, interrupt};
use app::App;
pub use script::Script;

/// Opens the window and stays until it is closed.
///
/// # Errors
/// [`Error::Usage`] without a display, and whatever ends the window.
pub fn run(settings: Settings, script: Option<&Path>) -> Result<()> {
    let script = script.map(Script::read).transpose()?.unwrap_or_default();
    let event_loop = EventLoop::new().map_err(|error| no_display(&error))?;
    interrupt::listen()?;
    let mut app = App::new(settings, script);
    let ran = event_loop.run_app(&mut app);
    app.finish()?;
    ran.map_err(|error| Error::Failure(format!("the window system failed: {error}")))
}

fn no_display(error: &EventLoopError) -> Error {
    log::info!("{error}");
    Error::Usage("there is no display to open a window on: add --headless to render without one".to_owned())
}
