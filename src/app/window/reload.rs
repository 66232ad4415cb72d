//! Shaders compiled anew while the window runs, when it is asked for or when a source changes.

use std::path::Path;
use std::sync::mpsc::{self, Receiver};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use notify::{Event, RecommendedWatcher, RecursiveMode, Watcher};

use crate::shader::compile::{Reload, reload};
use crate::{Error, Result};

/// The sources that this program was built from.
const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/shaders");
/// Editors write a file in several steps: a change counts once nothing has changed for this long.
const SETTLE: Duration = Duration::from_millis(200);

/// Watches the sources and compiles them on a thread.
pub struct ShaderReload {
    changes: Receiver<notify::Result<Event>>,
    /// Ends with this.
    _watcher: Option<RecommendedWatcher>,
    running: Option<JoinHandle<Result<Reload>>>,
    /// When to compile next.
    due: Option<Instant>,
}

impl ShaderReload {
    /// Starts to watch; where that cannot be done the sources are compiled only when it is asked for.
    pub fn start() -> Self {
        let (sender, changes) = mpsc::channel();
        let watcher = notify::recommended_watcher(sender).and_then(|mut watcher| {
            watcher.watch(Path::new(FOLDER), RecursiveMode::Recursive)?;
            Ok(watcher)
        });
        let watcher = watcher.map_err(|error| log::warn!("shaders are not watched: {error}")).ok();
        Self { changes, _watcher: watcher, running: None, due: None }
    }

    /// Compiles what differs from the shaders in use.
    pub fn ask(&mut self) {
        self.due = Some(Instant::now());
    }

    /// What has been compiled since the last call, if anything has been.
    pub fn take(&mut self) -> Option<Result<Reload>> {
        while let Ok(event) = self.changes.try_recv() {
            if event.is_ok_and(|event| changes_source(&event)) {
                self.due = Some(Instant::now() + SETTLE);
            }
        }
        if self.running.is_none() && self.due.take_if(|due| *due <= Instant::now()).is_some() {
            self.running = Some(std::thread::spawn(|| reload(Path::new(FOLDER))));
        }
        let finished = self.running.take_if(|thread| thread.is_finished())?;
        Some(finished.join().unwrap_or_else(|_| Err(Error::Failure("compiling the shaders failed".to_owned()))))
    }
}

/// Reading a source is an event too.
fn changes_source(event: &Event) -> bool {
    let is_source = |path: &std::path::PathBuf| path.extension().is_some_and(|extension| extension == "glsl");
    !event.kind.is_access() && event.paths.iter().any(is_source)
}
