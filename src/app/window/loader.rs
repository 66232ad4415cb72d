//! Scenes loaded on a thread while the window goes on.

use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;

use crate::app::setup::read_scene;
use crate::gpu::Limits;
use crate::renderer::ReadyScene;
use crate::scene::Scene;
use crate::settings::{EnvironmentSettings, MotionSettings, SunPlace};
use crate::{Error, Result};

/// What is to be loaded.
#[derive(Clone)]
pub struct Wanted {
    /// The file, `None` for the built-in scene.
    pub path: Option<PathBuf>,
    /// Which of the file's scenes, when it is not the default one.
    pub scene_name: Option<String>,
    /// Where its sun stands, when that is not left to the scene.
    pub sun: Option<SunPlace>,
    /// Which moment of it is shown.
    pub motion: MotionSettings,
    /// What is around it.
    pub environment: EnvironmentSettings,
    /// It is the scene that is shown, in other light: camera and sun stay.
    pub is_again: bool,
}

/// A scene that is ready for upload.
pub struct Loaded {
    /// The scene.
    pub scene: Scene,
    /// What is computed from it.
    pub ready: ReadyScene,
}

/// A scene that is being loaded.
pub struct Loading {
    wanted: Wanted,
    step: Arc<Mutex<String>>,
    thread: JoinHandle<Result<Loaded>>,
}

impl Loading {
    /// Starts to load a scene, for a device with these limits.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn start(wanted: Wanted, limits: Limits) -> Result<Self> {
        let step = Arc::new(Mutex::new("reading".to_owned()));
        let (shared, asked) = (Arc::clone(&step), wanted.clone());
        let load = move || {
            let say = |text: String| {
                if let Ok(mut step) = shared.lock() {
                    *step = text;
                }
            };
            let report = |step: &str, done: u64, total: u64| say(format!("{step} {} %", 100 * done / total.max(1)));
            let file = asked.path.as_deref().map(|path| (path, asked.scene_name.as_deref()));
            let scene = (file, asked.motion.is_asked_for(false));
            let scene = read_scene(scene, asked.sun, &asked.motion, &asked.environment, &report)?;
            say("BVH".to_owned());
            let ready = ReadyScene::new(&scene, &limits)?;
            Ok(Loaded { scene, ready })
        };
        let thread = std::thread::Builder::new().name("scene loader".to_owned()).spawn(load);
        let thread = thread.map_err(|error| Error::Failure(format!("no thread to load the scene with: {error}")))?;
        Ok(Self { wanted, step, thread })
    }

    /// What is being done, in a few words.
    pub fn progress(&self) -> String {
        let name =
            self.wanted.path.as_ref().and_then(|path| path.file_name()).map(|name| name.to_string_lossy().into_owned());
        let step = self.step.lock().map(|step| step.clone()).unwrap_or_default();
        format!("loading {}: {step}", name.as_deref().unwrap_or("the built-in scene"))
    }

    /// Whether [`Self::finish`] would not wait.
    pub fn is_finished(&self) -> bool {
        self.thread.is_finished()
    }

    /// What was to be loaded, and the scene, or why there is none.
    pub fn finish(self) -> (Wanted, Result<Loaded>) {
        let failed = |_| Err(Error::Failure("loading the scene failed".to_owned()));
        (self.wanted, self.thread.join().unwrap_or_else(failed))
    }
}
