//! What techniques need of a scene before they can render it, its points and what they measure, on a thread of its own: the
//! window goes on meanwhile.

use std::sync::Arc;
use std::thread::JoinHandle;

use crate::gpu::Gpu;
use crate::points::PointCloud;
use crate::renderer::{Job, UploadedScene, holds_for, measure};
use crate::scene::{Camera, Scene};
use crate::settings::Settings;
use crate::techniques::{self, TechniqueShape};
use crate::{Error, Result};

/// Something measured, and the settings that it was measured with.
pub struct Measured {
    /// With what.
    pub settings: Settings,
    /// The result.
    pub shape: Box<dyn TechniqueShape>,
    /// The points that it needs.
    pub points: Option<Arc<PointCloud>>,
}

/// A measurement under way. Dropped, it is waited for.
pub struct Measuring {
    settings: Settings,
    thread: Option<JoinHandle<Result<Measured>>>,
    /// The lights have changed since.
    is_stale: bool,
}

impl Measuring {
    /// Begins to measure.
    ///
    /// # Errors
    /// When there is no thread to be had.
    pub fn start(
        gpu: &Arc<Gpu>,
        scene: &Arc<Scene>,
        uploaded: &UploadedScene,
        camera: &Camera,
        settings: &Settings,
    ) -> Result<Self> {
        let (gpu, scene, uploaded) = (Arc::clone(gpu), Arc::clone(scene), uploaded.clone());
        let (camera, own) = (camera.clone(), settings.clone());
        let run = move || Measured::new(&gpu, &scene, uploaded, &camera, own);
        let thread = std::thread::Builder::new().name("measuring".to_owned()).spawn(run);
        let thread = thread.map_err(|error| Error::Failure(format!("no thread could be started: {error}")))?;
        Ok(Self { settings: settings.clone(), thread: Some(thread), is_stale: false })
    }

    /// Whether it is over.
    pub fn is_done(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// What it measures counts no longer.
    pub fn disregard(&mut self) {
        self.is_stale = true;
    }

    /// Whether what it measures of the lights counts no longer; its points do.
    pub fn is_stale(&self) -> bool {
        self.is_stale
    }

    /// What has been measured; waits for it. `None` where it has failed and that no longer matters, because the lights or the
    /// settings are others.
    ///
    /// # Errors
    /// Those of [`measure`] with these settings.
    pub fn finish(mut self, wanted: &Settings) -> Result<Option<Measured>> {
        let settings = self.settings.clone();
        let joined = self.thread.take().map(JoinHandle::join);
        let measured = joined.unwrap_or_else(|| Ok(Err(stopped()))).unwrap_or_else(|_| Err(stopped()));
        match measured {
            Ok(measured) => Ok(Some(measured)),
            Err(_) if self.is_stale => Ok(None),
            Err(error) if settings == *wanted || matches!(error, Error::DeviceLost { .. }) => Err(error),
            Err(_) => Ok(None),
        }
    }
}

fn stopped() -> Error {
    Error::Failure("measuring the light paths has stopped".to_owned())
}

impl Drop for Measuring {
    fn drop(&mut self) {
        // It uses the device, which may be about to end.
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

impl Measured {
    fn new(
        gpu: &Arc<Gpu>,
        scene: &Scene,
        mut uploaded: UploadedScene,
        camera: &Camera,
        settings: Settings,
    ) -> Result<Self> {
        let points = uploaded.spread_points(scene, techniques::of(&settings)?.point_count_log2(&settings))?;
        let shape = measure(&Job::new(gpu, &uploaded, camera, &settings))?;
        Ok(Self { settings, shape, points })
    }

    /// Whether it holds for other settings as well.
    ///
    /// # Errors
    /// [`Error::Usage`] when there is no such technique.
    pub fn holds_for(&self, settings: &Settings) -> Result<bool> {
        holds_for(&*self.shape, settings, &self.settings)
    }
}
