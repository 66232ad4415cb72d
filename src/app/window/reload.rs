//! Shaders compiled anew while the window runs, when it is asked for or when a source changes.

use std::path::Path;
use std::sync::mpsc::{self, Receiver};
use std::thread::JoinHandle;
use std::time::Duration;

use notify_debouncer_mini::notify::{RecommendedWatcher, RecursiveMode};
use notify_debouncer_mini::{DebounceEventResult, Debouncer, new_debouncer};

use crate::shader::compile::{Reload, reload};
use crate::{Error, Result};

/// The sources that this program was built from.
const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/shaders");
/// Editors write a file in several steps: changes within this time are one.
const SETTLE: Duration = Duration::from_millis(200);

/// Watches the sources and compiles them on a thread.
pub struct ShaderReload {
    changes: Receiver<DebounceEventResult>,
    /// Ends with this.
    _watcher: Option<Debouncer<RecommendedWatcher>>,
    running: Option<JoinHandle<Result<Reload>>>,
    /// Something changed since the thread began.
    again: bool,
}

impl ShaderReload {
    /// Starts to watch; where that cannot be done the sources are compiled only when it is asked for.
    pub fn start() -> Self {
        let (sender, changes) = mpsc::channel();
        let watcher = new_debouncer(SETTLE, sender).and_then(|mut debouncer| {
            debouncer.watcher().watch(Path::new(FOLDER), RecursiveMode::Recursive)?;
            Ok(debouncer)
        });
        let watcher = watcher.map_err(|error| log::warn!("shaders are not watched: {error}")).ok();
        Self { changes, _watcher: watcher, running: None, again: false }
    }

    /// Compiles what differs from the shaders in use.
    pub fn ask(&mut self) {
        self.again = true;
    }

    /// What has been compiled since the last call, if anything has been.
    pub fn take(&mut self) -> Option<Result<Reload>> {
        while let Ok(Ok(events)) = self.changes.try_recv() {
            self.again |= events.iter().any(|event| event.path.extension().is_some_and(|e| e == "glsl"));
        }
        if self.again && self.running.is_none() {
            self.again = false;
            self.running = Some(std::thread::spawn(|| reload(Path::new(FOLDER))));
        }
        let finished = self.running.take_if(|thread| thread.is_finished())?;
        Some(finished.join().unwrap_or_else(|_| Err(Error::Failure("compiling the shaders failed".to_owned()))))
    }
}
