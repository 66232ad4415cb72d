//! Pictures of a scene.

use std::ops::ControlFlow;

use glam::Vec3;
use gridlight::renderer::{Fresh, Job, Renderer, UploadedScene};
use gridlight::scene::Scene;
use gridlight::settings::Settings;

/// The mean of the settings' frames, per pixel.
pub fn render(scene: &Scene, settings: &Settings) -> Vec<Vec3> {
    let test = super::gpu();
    let uploaded = UploadedScene::new(&test.gpu, scene).unwrap();
    let mut renderer = Renderer::new(&Job::new(&test.gpu, &uploaded, &scene.cameras[0], settings)).unwrap();
    for number in 0..settings.render.accumulate {
        if settings.render.accumulate > 1 {
            renderer.set_accumulated_frame(number, Fresh::All);
        }
        renderer.run_in_steps(200.0, &mut |_, _| ControlFlow::Continue(())).unwrap();
    }
    renderer.read_radiance().unwrap().chunks_exact(3).map(Vec3::from_slice).collect()
}
