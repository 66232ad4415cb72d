//! Estimates of the light in shadow. The unbiased one comes, over frames with fresh shadow samples, to what every light sends
//! to every pixel, whatever the grid lights stand for, and as fast as independent samples do.

mod common;

use std::path::Path;

use common::GpuTest;
use common::rooms::{add_quad, camera, lamp_room};
use glam::Vec3;
use gridlight::renderer::{Fresh, Job, Renderer, UploadedScene};
use gridlight::scene::testing::shared_dir;
use gridlight::scene::{Scene, gltf};
use gridlight::settings::{Settings, ShadowEstimate, ShadowFilter, Size, Switch, Technique};

/// Frames of a mean, and how many parts it is taken in, whose differences say how far to trust it.
const FRAMES: u32 = 128;
const PARTS: u32 = 8;
/// Light that a mean may miss, as a fraction; or where the tests' own noise is larger, so many times its standard error.
const MAX_ENERGY_ERROR: f64 = 0.005;
const MAX_DEVIATIONS: f64 = 4.0;
/// The error of a mean of four times as many frames is a quarter; of the few bright samples that make it up, many frames
/// have none.
const MIN_FALL: f64 = 2.0;

fn settings(technique: Technique) -> Settings {
    Settings::default().changed(|s| {
        s.render.technique = technique;
        s.render.direct = Switch::Off;
        s.picture.size = Size { width: 24, height: 14 };
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

/// The dark side of the wall between them alone.
fn dark_side() -> Scene {
    let mut scene = thin_walls();
    scene.cameras = vec![camera(Vec3::new(-0.9, 0.0, -0.5), Vec3::X, 0.8)];
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

/// What a mean is allowed.
#[derive(Clone, Copy)]
struct Limits {
    relmse: f64,
    /// Standard error of the energy, as a fraction: beyond it the mean says nothing.
    standard_error: f64,
}

/// Standard error of the energy of the last of these means, taken at even distances.
fn standard_error(means: &[Vec<f64>]) -> f64 {
    let energies: Vec<f64> = means.iter().map(|picture| mean(picture)).collect();
    let n = energies.len() as f64;
    let before = |i: usize| if i == 0 { 0.0 } else { i as f64 * energies[i - 1] };
    let parts: Vec<f64> = (0..energies.len()).map(|i| (i + 1) as f64 * energies[i] - before(i)).collect();
    let all = energies[energies.len() - 1];
    (parts.iter().map(|part| (part - all).powi(2)).sum::<f64>() / (n * (n - 1.0))).sqrt()
}

/// Whether means of more and more frames come to the truth as they should.
fn check(means: &[Vec<f64>], truth: &[f64], limits: Limits) -> Result<(), String> {
    let (few, many) = (&means[means.len() / 4 - 1], &means[means.len() - 1]);
    let energy = mean(many) / mean(truth) - 1.0;
    let error = standard_error(means) / mean(truth);
    let (before, after) = (relmse(few, truth), relmse(many, truth));
    let holds = after <= limits.relmse
        && error <= limits.standard_error
        && energy.abs() <= MAX_ENERGY_ERROR.max(MAX_DEVIATIONS * error)
        && before >= MIN_FALL * after;
    let (energy, error) = (100.0 * energy, 100.0 * error);
    let says = format!("relMSE {before:.2e}, then {after:.2e}; energy {energy:+.2} %, standard error {error:.2} %");
    if holds { Ok(()) } else { Err(says) }
}

/// Numbers of frames after which a mean is looked at.
fn counts() -> Vec<u32> {
    (1..=PARTS).map(|part| part * FRAMES / PARTS).collect()
}

/// The estimate against brute force over the same lights, for each alpha.
fn converges(name: &str, scene: &Scene, modes: &[(f32, Limits)]) {
    let test = common::gpu();
    let uploaded = UploadedScene::new(&test.gpu, scene).unwrap();
    let truth = means(&test, &uploaded, scene, &settings(Technique::BruteForce), &[1]).remove(0);
    for (alpha, limits) in modes {
        let settings = settings(Technique::Lgh).changed(|s| s.lgh.alpha = *alpha);
        let found = means(&test, &uploaded, scene, &settings, &counts());
        check(&found, &truth, *limits).unwrap_or_else(|e| panic!("{name}, alpha {alpha}: {e}"));
    }
}

/// Where light is spread evenly.
const STEADY: Limits = Limits { relmse: 2e-3, standard_error: 5e-3 };

#[test]
fn it_comes_to_every_light_where_walls_are_thin() {
    // At alpha 0.5 coarse lights begin within the receiver's cell: a few samples of near lights are very bright.
    let half = Limits { relmse: 0.3, standard_error: 0.01 };
    converges("thin walls", &thin_walls(), &[(0.5, half), (1.0, STEADY), (2.0, STEADY)]);
}

#[test]
fn it_comes_to_every_light_in_the_cornell_box() {
    let Some(shared) = shared_dir() else {
        eprintln!("skipped: no shared assets");
        return;
    };
    let scene = file(&shared.join("assets/cornell/cornell.gltf"));
    converges("cornell box", &scene, &[(0.5, STEADY), (1.0, STEADY), (2.0, STEADY)]);
}

#[test]
fn it_comes_to_every_light_in_the_courtyard() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/courtyard.glb");
    // Under the open sky 2,000 lights are few: a light of S1 has many, and each frame only four of them.
    converges("courtyard", &file(&path), &[(1.0, Limits { relmse: 0.03, standard_error: 0.02 })]);
}

#[test]
fn interleaving_loses_no_light() {
    // One wall alone: across edges the blur moves light.
    let (test, scene) = (common::gpu(), dark_side());
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    let truth = means(&test, &uploaded, &scene, &settings(Technique::BruteForce), &[1]).remove(0);
    for interleave in [2, 4] {
        let settings = settings(Technique::Lgh).changed(|s| s.lgh.interleave = interleave);
        let found = means(&test, &uploaded, &scene, &settings, &[FRAMES]).remove(0);
        let (energy, error) = (mean(&found) / mean(&truth) - 1.0, relmse(&found, &truth));
        assert!(energy.abs() <= 0.01 && error <= 1e-3, "{interleave}: energy {energy:+}, relMSE {error}");
    }
}

/// Whether a filter took this share of the noise, and how much light it may have lost or made with it.
fn takes_noise(raw: &[f64], filtered: &[f64], truth: &[f64]) -> Result<(), String> {
    let (before, after) = (relmse(raw, truth), relmse(filtered, truth));
    let energy = mean(filtered) / mean(truth) - 1.0;
    let holds = after <= 0.25 * before && energy.abs() <= 0.03;
    if holds { Ok(()) } else { Err(format!("relMSE {before:.2e}, filtered {after:.2e}; energy {energy:+.3}")) }
}

#[test]
fn the_filter_takes_the_noise_and_keeps_the_light() {
    let (test, scene) = (common::gpu(), thin_walls());
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    let one_frame = |technique, estimate, filter| {
        let settings = settings(technique).changed(|s| {
            s.picture.size = Size { width: 120, height: 72 };
            s.many_lights.shadow_samples = 4;
            s.lgh.shadow_estimate = Some(estimate);
            s.lgh.filter = filter;
        });
        means(&test, &uploaded, &scene, &settings, &[1]).remove(0)
    };
    let truth = one_frame(Technique::BruteForce, ShadowEstimate::Unbiased, ShadowFilter::None);
    let [raw, filtered] = [ShadowFilter::None, ShadowFilter::Atrous]
        .map(|filter| one_frame(Technique::Lgh, ShadowEstimate::Corrected, filter));
    takes_noise(&raw, &filtered, &truth).unwrap_or_else(|e| panic!("{e}"));
    assert!(takes_noise(&raw, &raw, &truth).is_err());
    let darker: Vec<f64> = filtered.iter().map(|value| 0.95 * value).collect();
    assert!(takes_noise(&raw, &darker, &truth).is_err());
}

#[test]
fn behind_thin_walls_the_ratio_is_wrong_and_the_corrected_estimate_right() {
    let (test, scene) = (common::gpu(), dark_side());
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    let truth = means(&test, &uploaded, &scene, &settings(Technique::BruteForce), &[1]).remove(0);
    let energy_of = |estimate| {
        let settings = settings(Technique::Lgh).changed(|s| {
            s.lgh.shadow_estimate = Some(estimate);
            s.lgh.filter = ShadowFilter::Atrous;
        });
        mean(&means(&test, &uploaded, &scene, &settings, &[32]).remove(0)) / mean(&truth) - 1.0
    };
    let [corrected, ratio] = [ShadowEstimate::Corrected, ShadowEstimate::Ratio].map(energy_of);
    assert!(corrected.abs() <= 0.03, "{corrected:+}");
    assert!(ratio.abs() > 0.15, "{ratio:+}");
}

/// At this alpha the hierarchy has no light for some pixels, and next to none for those beside them.
#[test]
fn pixels_whose_lights_are_lost_do_not_light_others() {
    let Some(shared) = shared_dir() else {
        eprintln!("skipped: no shared assets");
        return;
    };
    let (test, scene) = (common::gpu(), file(&shared.join("assets/cornell/cornell.gltf")));
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    let [raw, filtered] = [ShadowFilter::None, ShadowFilter::Atrous].map(|filter| {
        let settings = settings(Technique::Lgh).changed(|s| {
            s.picture.size = Size { width: 160, height: 90 };
            s.many_lights.shadow_samples = 4;
            s.lgh.shadow_estimate = Some(ShadowEstimate::Corrected);
            s.lgh.filter = filter;
            s.lgh.alpha = 0.5;
        });
        means(&test, &uploaded, &scene, &settings, &[1]).remove(0)
    });
    let gained = mean(&filtered) / mean(&raw) - 1.0;
    assert!(gained.abs() <= 0.05, "the filter changes the light by {gained:+}");
}

#[test]
fn planted_faults_are_noticed() {
    let truth = vec![1.0, 2.0, 3.0];
    let off = |by: f64| truth.iter().map(|value| value * (1.0 + by)).collect::<Vec<_>>();
    // Means at even distances whose errors fall, up to the last, which is off by so much.
    let falling = |last: Vec<f64>| [off(0.02), off(0.01), off(0.005), last].to_vec();
    let verdict = |means: &[Vec<f64>]| check(means, &truth, Limits { relmse: 1e-3, standard_error: 0.02 });
    verdict(&falling(off(0.003))).unwrap();
    verdict(&falling(off(0.006))).unwrap();
    assert!(verdict(&[off(0.1), off(0.1), off(0.1), off(0.1)]).is_err(), "energy");
    assert!(verdict(&[off(0.003), off(0.003), off(0.003), off(0.003)]).is_err(), "an error that does not fall");
    assert!(verdict(&falling(vec![0.9, 2.2, 2.9])).is_err(), "noise");
    assert!(verdict(&[off(0.5), off(-0.2), off(0.1), off(0.0)]).is_err(), "a mean that says nothing");
    assert!(verdict(&falling(vec![1.0, f64::NAN, 3.0])).is_err(), "no number");
}
