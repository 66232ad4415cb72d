//! Runs of frames that follow each other.

use std::sync::Arc;

use glam::Vec3;
use gridlight::gpu::Gpu;
use gridlight::renderer::{Fresh, Job, Renderer, UploadedScene};
use gridlight::scene::{Camera, Scene};
use gridlight::settings::{Settings, ShadowEstimate, Size, Switch, Temporal};

use crate::common::picture::Frame;

/// A run and what it needs.
pub struct Run<'a> {
    pub gpu: &'a Arc<Gpu>,
    pub uploaded: UploadedScene,
    pub camera: Camera,
    pub settings: Settings,
    pub renderer: Renderer,
    /// Frames so far.
    pub frames: u32,
}

impl<'a> Run<'a> {
    pub fn new(gpu: &'a Arc<Gpu>, scene: &Scene, settings: &Settings) -> Self {
        let (camera, uploaded) = (scene.cameras[0].clone(), UploadedScene::new(gpu, scene).unwrap());
        let renderer = Renderer::new(&Job::new(gpu, &uploaded, &camera, settings)).unwrap();
        Self { gpu, uploaded, camera, settings: settings.clone(), renderer, frames: 0 }
    }

    /// The next frame, with shadow samples of its own over the light paths of the first.
    pub fn next(&mut self) {
        self.next_with(Fresh::Shadows);
    }

    pub fn next_with(&mut self, fresh: Fresh) {
        self.renderer.update(&Job::new(self.gpu, &self.uploaded, &self.camera, &self.settings));
        self.renderer.set_accumulated_frame(self.frames, fresh);
        let ticket = self.renderer.submit().unwrap();
        self.renderer.wait(ticket).unwrap();
        self.frames += 1;
    }

    pub fn radiance(&self) -> Vec<f32> {
        self.renderer.read_radiance().unwrap()
    }

    /// What every pass of the last frame left.
    pub fn last(&self) -> Frame {
        Frame::by(&self.renderer, &self.camera, &self.settings)
    }

    /// Moves the camera to its right, by metres.
    pub fn step_right(&mut self, by: f32) {
        self.camera.position_ws += self.camera.right_ws * by;
    }
}

/// Frames without direct light, with few samples.
pub fn settings(size: Size, temporal: Temporal, estimate: ShadowEstimate) -> Settings {
    Settings::default().changed(|s| {
        s.picture.size = size;
        s.render.direct = Switch::Off;
        s.many_lights.vpls = 500;
        s.many_lights.shadow_samples = 1;
        s.lgh.temporal = Some(temporal);
        s.lgh.shadow_estimate = Some(estimate);
    })
}

/// Pixels of a frame without alpha.
pub fn colors(radiance: &[f32]) -> Vec<Vec3> {
    radiance.chunks_exact(3).map(Vec3::from_slice).collect()
}
