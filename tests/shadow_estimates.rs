//! The unbiased estimate: over frames with fresh shadow samples it comes to what every light sends to every pixel, whatever
//! the grid lights stand for, and as fast as independent samples do.

mod common;

use std::path::Path;

use common::GpuTest;
use common::rooms::{add_quad, camera, lamp_room};
use glam::Vec3;
use gridlight::renderer::{Fresh, Job, Renderer, UploadedScene};
use gridlight::scene::testing::shared_dir;
use gridlight::scene::{Scene, gltf};
use gridlight::settings::{Settings, ShadowEstimate, ShadowFilter, Size, Switch, Technique};

/// Frames of a mean.
const FRAMES: u32 = 128;
/// The tests' own noise decides how much light a mean may miss.
const MAX_ENERGY_ERROR: f64 = 0.005;
/// The error of a mean of four times as many frames is a quarter; of the few bright samples that make it up, many frames
/// have none.
const MIN_FALL: f64 = 2.0;

fn settings(technique: Technique) -> Settings {
    Settings::default().changed(|s| {
        s.render.technique = technique;
        s.render.direct = Switch::Off;
        s.picture.size = Size { width: 40, height: 24 };
        s.many_lights.vpls = 2000;
        s.many_lights.shadow_samples = 16;
        s.lgh.shadow_estimate = Some(ShadowEstimate::Unbiased);
        s.lgh.filter = ShadowFilter::None;
    })
}

/// Two rooms with a wall without thickness between them and a door in it, seen from the one without the lamp. Lights on the
/// lit side of the wall lie as near to the dark side.
fn thin_walls() -> Scene {
    let mut scene = lamp_room(Vec3::new(0.7, 0.6, 0.5));
    let wall = |z: [f32; 2], y: [f32; 2]| {
        [Vec3::new(0.0, y[0], z[0]), Vec3::new(0.0, y[0], z[1]), Vec3::new(0.0, y[1], z[1]), Vec3::new(0.0, y[1], z[0])]
    };
    add_quad(&mut scene, wall([-2.0, 1.0], [-2.0, 2.0]));
    add_quad(&mut scene, wall([1.0, 2.0], [0.5, 2.0]));
    scene.cameras = vec![camera(Vec3::new(-1.7, 0.1, -1.2), Vec3::new(0.9, -0.1, 0.6).normalize(), 1.3)];
    scene
}

fn file(path: &Path) -> Scene {
    gltf::load(path, &|_: &str, _, _| ()).unwrap()
}

/// Sum of the radiance of so many frames over the same lights, at each of these numbers of frames.
fn means(
    test: &GpuTest,
    uploaded: &UploadedScene,
    scene: &Scene,
    settings: &Settings,
    counts: &[u32],
) -> Vec<Vec<f64>> {
    let mut renderer = Renderer::new(&Job::new(&test.gpu, uploaded, &scene.cameras[0], settings)).unwrap();
    let (mut sum, mut means) = (Vec::new(), Vec::new());
    for number in 0..*counts.last().unwrap() {
        renderer.set_accumulated_frame(number, Fresh::Shadows);
        let ticket = renderer.submit().unwrap();
        renderer.wait(ticket).unwrap();
        let frame = renderer.read_radiance().unwrap();
        sum.resize(frame.len(), 0.0);
        sum.iter_mut().zip(&frame).for_each(|(sum, value)| *sum += f64::from(*value));
        if counts.contains(&(number + 1)) {
            means.push(sum.iter().map(|sum| sum / f64::from(number + 1)).collect());
        }
    }
    means
}

fn mean(picture: &[f64]) -> f64 {
    picture.iter().sum::<f64>() / picture.len() as f64
}

fn relmse(found: &[f64], truth: &[f64]) -> f64 {
    let floor = 0.01 * mean(truth).powi(2);
    let errors = found.iter().zip(truth).map(|(a, b)| (a - b).powi(2) / (b * b + floor));
    errors.sum::<f64>() / truth.len() as f64
}

/// Whether the means of N and of 4 N frames come to the truth as they should, the latter to this error.
fn check(few: &[f64], many: &[f64], truth: &[f64], max_relmse: f64) -> Result<(), String> {
    let energy = mean(many) / mean(truth) - 1.0;
    let (before, after) = (relmse(few, truth), relmse(many, truth));
    let says = format!("relMSE {before:.2e}, then {after:.2e}; energy {:+.2} %", 100.0 * energy);
    let holds = after <= max_relmse && energy.abs() <= MAX_ENERGY_ERROR && before >= MIN_FALL * after;
    if holds { Ok(()) } else { Err(says) }
}

/// The estimate against brute force over the same lights, for each alpha, to an error.
fn converges(name: &str, scene: &Scene, modes: &[(f32, f64)]) {
    let test = common::gpu();
    let uploaded = UploadedScene::new(&test.gpu, scene).unwrap();
    let truth = means(&test, &uploaded, scene, &settings(Technique::BruteForce), &[1]).remove(0);
    for (alpha, max_relmse) in modes {
        let settings = settings(Technique::Lgh).changed(|s| s.lgh.alpha = *alpha);
        let found = means(&test, &uploaded, scene, &settings, &[FRAMES / 4, FRAMES]);
        check(&found[0], &found[1], &truth, *max_relmse).unwrap_or_else(|e| panic!("{name}, alpha {alpha}: {e}"));
    }
}

#[test]
fn it_comes_to_every_light_where_walls_are_thin() {
    converges("thin walls", &thin_walls(), &[(1.0, 2e-3), (2.0, 2e-3)]);
}

#[test]
fn it_comes_to_every_light_in_the_cornell_box() {
    let Some(shared) = shared_dir() else {
        eprintln!("skipped: no shared assets");
        return;
    };
    let scene = file(&shared.join("assets/cornell/cornell.gltf"));
    converges("cornell box", &scene, &[(0.5, 5e-3), (1.0, 5e-3), (2.0, 1e-3)]);
}

#[test]
fn interleaving_loses_no_light() {
    let (test, scene) = (common::gpu(), thin_walls());
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    let truth = means(&test, &uploaded, &scene, &settings(Technique::BruteForce), &[1]).remove(0);
    for interleave in [2, 4] {
        let settings = settings(Technique::Lgh).changed(|s| s.lgh.interleave = interleave);
        let found = means(&test, &uploaded, &scene, &settings, &[FRAMES]).remove(0);
        // The blur moves light across edges: of a picture so small they are much.
        let energy = mean(&found) / mean(&truth) - 1.0;
        assert!(energy.abs() <= 0.03, "{interleave}: {energy}");
    }
}

#[test]
fn the_ratio_leaks_through_thin_walls() {
    let (test, scene) = (common::gpu(), thin_walls());
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    let truth = means(&test, &uploaded, &scene, &settings(Technique::BruteForce), &[1]).remove(0);
    let ratio = settings(Technique::Lgh).changed(|s| s.lgh.shadow_estimate = Some(ShadowEstimate::Ratio));
    let found = means(&test, &uploaded, &scene, &ratio, &[16]).remove(0);
    let error = relmse(&found, &truth);
    assert!(error > 0.02, "{error}");
}

#[test]
fn planted_faults_are_noticed() {
    let truth = vec![1.0, 2.0, 3.0];
    let off = |by: f64| truth.iter().map(|value| value * (1.0 + by)).collect::<Vec<_>>();
    assert!(check(&off(0.01), &off(0.003), &truth, 1e-3).is_ok());
    assert!(check(&off(0.1), &off(0.006), &truth, 1e-3).is_err(), "energy");
    assert!(check(&off(0.003), &off(0.003), &truth, 1e-3).is_err(), "an error that does not fall");
    assert!(check(&off(1.0), &[0.9, 2.2, 2.9], &truth, 1e-3).is_err(), "noise");
    assert!(check(&off(0.01), &[1.0, f64::NAN, 3.0], &truth, 1e-3).is_err(), "no number");
}
