//! Shadow samples: selection frequencies on the twin, agreement of the update modes and determinism on the GPU.

mod common;

use common::compare::chi_square;
use common::rooms::roofed_floor;
use gridlight::cpu::reservoir::{Stream, select_exact, select_streaming};
use gridlight::renderer::{Job, Renderer, UploadedScene};
use gridlight::scene::Scene;
use gridlight::settings::{Reservoir, Settings, ShadowFilter, ShadowPoints, Size};

const PIXELS: u32 = 1 << 20;
const SAMPLES: u32 = 4;
/// 11 degrees of freedom: exceeded once in ten thousand times. The draws are fixed by the seed.
const CHI_SQUARE_LIMIT: f64 = 37.4;

/// Twelve lights over three decades.
fn lights() -> Vec<(u32, f32)> {
    (0..12_u32).map(|i| (1000 + 17 * i, 10.0_f32.powf(f32::from(i as u16) * 3.0 / 11.0 - 2.0))).collect()
}

type Select = fn(Stream, &[(u32, f32)]) -> u32;

/// How often each light is chosen.
fn count(select: Select, seed: u32, samples: std::ops::Range<u32>) -> Vec<u64> {
    let lights = lights();
    let mut counts = vec![0; lights.len()];
    for pixel_index in 0..PIXELS {
        for sample in samples.clone() {
            let light = select(Stream { pixel_index, sample, seed }, &lights);
            counts[lights.iter().position(|(l, _)| *l == light).unwrap()] += 1;
        }
    }
    counts
}

fn weights() -> Vec<f64> {
    lights().iter().map(|(_, f)| f64::from(*f)).collect()
}

#[test]
fn lights_are_chosen_in_proportion_to_their_weights() {
    for (name, select) in [("exact", select_exact as Select), ("streaming", select_streaming)] {
        for seed in [1, 2] {
            let chi = chi_square(&count(select, seed, 0..SAMPLES), &weights());
            assert!(chi < CHI_SQUARE_LIMIT, "{name}, seed {seed}: chi-square {chi}");
        }
    }
}

#[test]
fn a_weight_wrong_by_a_hundredth_is_noticed() {
    let counts = count(select_exact, 1, 0..SAMPLES);
    let mut wrong = weights();
    wrong[11] *= 1.01;
    assert!(chi_square(&counts, &wrong) > CHI_SQUARE_LIMIT);
    let mut swapped = weights();
    swapped.swap(3, 4);
    assert!(chi_square(&counts, &swapped) > CHI_SQUARE_LIMIT);
}

#[test]
fn samples_of_a_pixel_are_independent() {
    // Both samples choose the brightest light as often as independent ones would.
    let lights = lights();
    let total: f64 = weights().iter().sum();
    let p = weights()[11] / total;
    let hits =
        |sample: u32, pixel_index: u32| select_exact(Stream { pixel_index, sample, seed: 5 }, &lights) == lights[11].0;
    let both = (0..PIXELS).filter(|pixel| hits(0, *pixel) && hits(1, *pixel)).count() as f64;
    let deviation = (f64::from(PIXELS) * p * p * (1.0 - p * p)).sqrt();
    assert!((both - f64::from(PIXELS) * p * p).abs() < 4.0 * deviation, "{both}");
}

fn settings(reservoir: Reservoir, seed: u32) -> Settings {
    Settings::default().changed(|s| {
        s.picture.size = Size { width: 64, height: 48 };
        s.many_lights.vpls = 1000;
        s.many_lights.shadow_samples = 8;
        s.lgh.reservoir = Some(reservoir);
        s.lgh.filter = ShadowFilter::None;
        s.tracing.seed = seed;
    })
}

fn render(test: &common::GpuTest, scene: &Scene, settings: &Settings) -> Vec<f32> {
    let uploaded = UploadedScene::new(&test.gpu, scene).unwrap();
    let mut renderer = Renderer::new(&Job::new(&test.gpu, &uploaded, &scene.cameras[0], settings)).unwrap();
    let ticket = renderer.submit().unwrap();
    renderer.wait(ticket).unwrap();
    renderer.read_radiance().unwrap()
}

fn mean(values: &[f32]) -> f64 {
    values.iter().map(|v| f64::from(*v)).sum::<f64>() / values.len() as f64
}

/// Shadow rays that end about the chosen light itself: what a reservoir chose shows most, and counts the same
/// wherever the ray ends.
fn deviation(reservoir: Reservoir) -> Settings {
    settings(reservoir, 3).changed(|s| s.lgh.shadow_points = ShadowPoints::Deviation)
}

#[test]
fn every_mode_gives_the_same_mean_shadow() {
    let test = common::gpu();
    if !test.gpu.features().int64_atomics {
        eprintln!("skipped: no 64-bit atomics");
        return;
    }
    let scene = roofed_floor();
    let lit = |reservoir| mean(&render(&test, &scene, &deviation(reservoir)));
    let unshadowed =
        mean(&render(&test, &scene, &deviation(Reservoir::Lock).changed(|s| s.many_lights.shadow_samples = 0)));
    let [exact, lock, race] = [Reservoir::Exact, Reservoir::Lock, Reservoir::Race].map(lit);
    assert!(exact < 0.999 * unshadowed, "nothing is in shadow: {exact}, {unshadowed} without shadows");
    let shadow = unshadowed - exact;
    // 3072 pixels of 8 samples each: the mean shadow's deviation is below a hundredth; races lose a few updates.
    for (name, other, tolerance) in [("lock", lock, 0.05), ("race", race, 0.1)] {
        same_shadow(shadow, unshadowed - other, tolerance).unwrap_or_else(|e| panic!("{name}: {e}"));
    }
}

/// Whether two mean shadows agree within a relative tolerance.
fn same_shadow(expected: f64, shadow: f64, tolerance: f64) -> Result<(), String> {
    let difference = (shadow - expected).abs() / expected;
    if difference < tolerance { Ok(()) } else { Err(format!("mean shadow differs by {difference}")) }
}

#[test]
fn a_mode_that_loses_a_tenth_of_the_shadow_is_noticed() {
    assert!(same_shadow(0.2, 0.2 * 0.97, 0.05).is_ok());
    assert!(same_shadow(0.2, 0.2 * 0.9, 0.05).is_err());
    assert!(same_shadow(0.2, 0.2 * 1.1, 0.05).is_err());
    assert!(same_shadow(0.2, f64::NAN, 0.05).is_err());
}

#[test]
fn exact_is_deterministic_and_follows_the_seed() {
    let test = common::gpu();
    if !test.gpu.features().int64_atomics {
        eprintln!("skipped: no 64-bit atomics");
        return;
    }
    let scene = roofed_floor();
    let bits = |seed| -> Vec<u32> {
        render(&test, &scene, &settings(Reservoir::Exact, seed)).iter().map(|v| v.to_bits()).collect()
    };
    let first = bits(7);
    assert_eq!(first.iter().zip(&bits(7)).position(|(a, b)| a != b), None, "first differing value");
    assert_ne!(first, bits(8));
}
