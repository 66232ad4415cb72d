//! What is to be rendered.

use std::sync::Arc;

use crate::gpu::Gpu;
use crate::scene::Camera;
use crate::settings::Settings;
use crate::uploaded_scene::UploadedScene;

/// What is rendered, from where, how, and on which device.
#[derive(Clone, Copy)]
pub struct Job<'a> {
    /// The device.
    pub gpu: &'a Arc<Gpu>,
    /// The scene on this device.
    pub scene: &'a UploadedScene,
    /// Where it is seen from.
    pub camera: &'a Camera,
    /// How it is rendered.
    pub settings: &'a Settings,
}

impl<'a> Job<'a> {
    /// All of it together.
    #[must_use]
    pub fn new(gpu: &'a Arc<Gpu>, scene: &'a UploadedScene, camera: &'a Camera, settings: &'a Settings) -> Self {
        Self { gpu, scene, camera, settings }
    }

    /// The same with other settings.
    #[must_use]
    pub fn with<'b>(&self, settings: &'b Settings) -> Job<'b>
    where
        'a: 'b,
    {
        Job { settings, ..*self }
    }
}
