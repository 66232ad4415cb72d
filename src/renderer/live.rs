//! Frames that a window shows: camera, lights and settings change while they run, and only what has another shape is
//! compiled anew.

use std::sync::Arc;

use super::shape::{base_shape, check_lights, is_measured, measured_shape};
use super::{Renderer, UploadedScene, frame_data};
use crate::error::Result;
use crate::gpu::{FrameTicket, Gpu, Overlay, Target};
use crate::passes::FrameShape;
use crate::passes::present::WindowFormat;
use crate::scene::Camera;
use crate::settings::Settings;
use crate::shared::PunctualLight;

impl UploadedScene {
    /// Directional and spot lights, as uploaded.
    #[must_use]
    pub fn other_lights(&self) -> &[PunctualLight] {
        &self.other_lights
    }
}

impl Renderer {
    /// A frame for a window. What `before` measured of the same scene is used again where `settings` leave it as it
    /// was; `measured_with` are the settings that it was measured with.
    ///
    /// # Errors
    /// Those of [`Renderer::new`].
    pub fn for_window(
        gpu: &Arc<Gpu>,
        scene: &UploadedScene,
        camera: &Camera,
        settings: &Settings,
        window: WindowFormat,
        before: Option<(&Self, &Settings)>,
    ) -> Result<Self> {
        let known = before.filter(|(_, measured_with)| same_lights(settings, measured_with));
        let shape = match known {
            Some((before, _)) if is_measured(settings) => {
                settings.validate_view()?;
                check_lights(scene, settings)?;
                with_measures(&base_shape(gpu, scene, settings)?, &before.shape)
            }
            _ => measured_shape(gpu, scene, camera, settings)?,
        };
        Self::compile(gpu, scene, camera, settings, shape, Some(window))
    }

    /// Whether frames of these settings are the ones compiled, but for their constants. `measured_with` are the
    /// settings that the renderer was made with.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] when the settings do not fit the device.
    pub fn fits(
        &self,
        gpu: &Gpu,
        scene: &UploadedScene,
        settings: &Settings,
        measured_with: &Settings,
    ) -> Result<bool> {
        let base = base_shape(gpu, scene, settings)?;
        let shape = if is_measured(settings) { with_measures(&base, &self.shape) } else { base };
        let same_kind = self.technique == settings.technique && is_measured(settings) == is_measured(measured_with);
        Ok(same_kind && shape == self.shape && (!is_measured(settings) || same_lights(settings, measured_with)))
    }

    /// Takes over the camera and whatever of the settings are constants of the frame.
    pub fn update(&mut self, gpu: &Gpu, scene: &UploadedScene, camera: &Camera, settings: &Settings) {
        self.camera = camera.clone();
        self.seed = settings.seed;
        self.data = frame_data(gpu, scene, camera, settings, &self.shape);
    }

    /// Replaces the scene's directional and spot lights with the next frame.
    pub fn update_lights(&mut self, lights: &[PunctualLight]) {
        self.executor.update_lights(bytemuck::cast_slice(lights).to_vec());
    }

    /// Submits one frame into an image of the window, with `overlay` drawn over the picture.
    ///
    /// # Errors
    /// When the device is lost, and those of `overlay`.
    pub fn submit_to(&mut self, target: &Target, overlay: &mut Overlay) -> Result<FrameTicket> {
        self.executor.submit_to(bytemuck::bytes_of(&self.data), target, overlay)
    }
}

/// Whether two settings trace the same lights and build the same levels over them.
fn same_lights(a: &Settings, b: &Settings) -> bool {
    is_measured(a) == is_measured(b)
        && (a.lights, a.vpls, a.bounces, a.levels) == (b.lights, b.vpls, b.bounces, b.levels)
        && (a.build, a.scatter) == (b.build, b.scatter)
}

/// A shape with what another of the same lights was measured to need.
fn with_measures(shape: &FrameShape, measured: &FrameShape) -> FrameShape {
    FrameShape {
        levels: measured.levels,
        path_count: measured.path_count,
        vpl_capacity: measured.vpl_capacity,
        grid_capacity: measured.grid_capacity,
        upper_capacity: measured.upper_capacity,
        scatter: measured.scatter,
        ..shape.clone()
    }
}
