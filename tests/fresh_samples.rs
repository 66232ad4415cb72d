//! Means of frames: what they share with `Fresh::Shadows`, and what with `Fresh::All`.

mod common;

use std::sync::Arc;

use common::gpu;
use common::rooms::courtyard;
use gridlight::gpu::Gpu;
use gridlight::renderer::{Fresh, Job, Renderer, UploadedScene};
use gridlight::scene::Scene;
use gridlight::settings::{Settings, Size, Switch};

/// Radiance after each of the frames `numbers`, rendered one after the other.
fn frames(gpu: &Arc<Gpu>, scene: &Scene, settings: &Settings, fresh: Fresh, numbers: &[u32]) -> Vec<Vec<f32>> {
    let uploaded = UploadedScene::new(gpu, scene).unwrap();
    let mut renderer = Renderer::new(&Job::new(gpu, &uploaded, &scene.cameras[0], settings)).unwrap();
    let render = |number: &u32| {
        renderer.set_accumulated_frame(*number, fresh);
        let ticket = renderer.submit().unwrap();
        renderer.wait(ticket).unwrap();
        renderer.read_radiance().unwrap()
    };
    numbers.iter().map(render).collect()
}

/// Mean difference as a fraction of the mean.
fn difference(a: &[f32], b: &[f32]) -> f32 {
    let sum: f32 = a.iter().sum();
    assert!(sum > 0.0);
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f32>() / sum
}

fn small() -> Settings {
    Settings::default().changed(|s| {
        s.picture.size = Size { width: 64, height: 36 };
        s.many_lights.vpls = 500;
        s.render.direct = Switch::Off;
    })
}

#[test]
fn fresh_shadows_keep_light_paths_and_sampling_points() {
    let test = gpu();
    let scene = courtyard();
    let unshadowed = small().changed(|s| {
        s.many_lights.shadows = Switch::Off;
        s.render.accumulate = 3;
    });
    let means = frames(&test.gpu, &scene, &unshadowed, Fresh::Shadows, &[0, 1, 2]);
    for mean in &means[1..] {
        let difference = difference(&means[0], mean);
        assert!(difference < 1e-6, "frames without shadow samples differ by {difference}");
    }
    let means = frames(&test.gpu, &scene, &unshadowed, Fresh::All, &[0, 1]);
    assert!(difference(&means[0], &means[1]) > 0.01, "another seed and jitter change nothing");
}

#[test]
fn fresh_shadows_are_fresh() {
    let test = gpu();
    let scene = courtyard();
    // Nothing accumulates: each frame stands alone.
    let shots = frames(&test.gpu, &scene, &small(), Fresh::Shadows, &[0, 1, 0]);
    assert!(difference(&shots[0], &shots[1]) > 0.01, "other shadow samples change nothing");
    assert_eq!(shots[0], shots[2], "the same frame gave two pictures");
    // The first frame is that of a run that accumulates nothing.
    let plain = frames(&test.gpu, &scene, &small(), Fresh::All, &[0]);
    assert_eq!(plain[0], shots[0]);
}
