//! The à-trous wavelet (`shaders/atrous`).

use gridlight::scene::Scene;
use gridlight::settings::Settings;

use crate::common;
use crate::common::compare::Verdict;
use crate::common::rooms::{folding_screen, furnished_room};
use crate::picture::{Frame, SIZES, Texel, compare_texels};

/// For powers and exponentials, whose precision is the device's.
const TOLERANCE: [f64; 2] = [1e-3, 1e-7];

/// One iteration.
#[derive(Clone, Copy, Debug)]
struct Iteration {
    /// Distance of neighbours.
    step_px: i32,
    /// Difference of shadow ratios at which a weight falls to 1/e.
    ratio_sigma: f64,
    /// Weights of the taps along an axis, from the middle.
    kernel: [f64; 3],
    /// Power of the cosine between normals.
    normal_power: i32,
    /// Distance from the tangent plane in footprints, and ratio of luminances, at which a weight falls to 1/e.
    plane_sigma: f64,
    color_sigma: f64,
    /// Weight of neighbours alike below which others count too, and within what distance in footprints and steps.
    min_support: f64,
    nearness_sigma: f64,
    /// Widest step at which they do.
    last_relaxed_step: i32,
}

const ITERATIONS: [Iteration; 3] = {
    let first = Iteration {
        step_px: 1,
        ratio_sigma: 1e6,
        kernel: [3.0 / 8.0, 1.0 / 4.0, 1.0 / 16.0],
        normal_power: 32,
        plane_sigma: 4.0,
        color_sigma: 1.5,
        min_support: 0.15,
        nearness_sigma: 4.0,
        last_relaxed_step: 2,
    };
    [first, Iteration { step_px: 2, ratio_sigma: 1.0, ..first }, Iteration { step_px: 4, ratio_sigma: 0.5, ..first }]
};

/// The images of an iteration: analytic lighting, shadowed and unshadowed estimate.
struct Images {
    lighting: Vec<Texel>,
    shadowed: Vec<Texel>,
    unshadowed: Vec<Texel>,
}

impl Images {
    /// What goes into iteration 1, 2 or 3 of a frame.
    fn before(frame: &Frame, iteration: usize) -> Self {
        let interleaved = frame.n > 1;
        let lighting = if interleaved {
            frame.floats("interleave/blur_lighting_y", "lighting_blurred_y")
        } else {
            frame.floats("light_gather", "lighting")
        };
        let estimate = |what: &str| match iteration {
            1 if interleaved => frame.floats(&format!("interleave/blur_{what}_y"), &format!("{what}_blurred_y")),
            1 => frame.floats("shadow_rays", what),
            _ => output(frame, what, iteration - 1),
        };
        Self { lighting, shadowed: estimate("shadowed"), unshadowed: estimate("unshadowed") }
    }

    fn brightness(&self, index: usize) -> f64 {
        luminance(self.lighting[index]).max(1e-20).log2()
    }

    fn shadow_ratio(&self, index: usize) -> f64 {
        let unshadowed = luminance(self.unshadowed[index]);
        if unshadowed > 0.0 { luminance(self.shadowed[index]) / unshadowed } else { 1.0 }
    }
}

fn output(frame: &Frame, what: &str, iteration: usize) -> Vec<Texel> {
    frame.floats(&format!("atrous/{iteration}"), &format!("{what}_{iteration}"))
}

fn luminance(color: Texel) -> f64 {
    0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2]
}

/// Sums of both estimates with their weight.
#[derive(Default)]
struct Sums {
    shadowed: [f64; 3],
    unshadowed: [f64; 3],
    weight: f64,
}

impl Sums {
    fn add(&mut self, images: &Images, index: usize, weight: f64) {
        for channel in 0..3 {
            self.shadowed[channel] += weight * images.shadowed[index][channel];
            self.unshadowed[channel] += weight * images.unshadowed[index][channel];
        }
        self.weight += weight;
    }
}

/// Both estimates of a pixel after an iteration, and how much those that are only near count.
fn filtered(frame: &Frame, images: &Images, by: &Iteration, x: i32, y: i32) -> ([Texel; 2], f64) {
    let surfaces = &frame.surfaces;
    let Some(center) = surfaces.surface(x, y) else { return ([[0.0; 4]; 2], 0.0) };
    let (position, normal) = (surfaces.position_ws(x, y, center), surfaces.normal(center));
    let footprint = surfaces.footprint(center);
    let nearness = by.nearness_sigma * footprint * f64::from(by.step_px);
    let (mut strict, mut relaxed, mut alike) = (Sums::default(), Sums::default(), 0.0);
    for (dx, dy) in (-2..=2).flat_map(|dy| (-2..=2).map(move |dx: i32| (dx, dy))) {
        let (px, py) = (x + dx * by.step_px, y + dy * by.step_px);
        let Some(index) = surfaces.surface(px, py) else { continue };
        let offset = surfaces.position_ws(px, py, index) - position;
        let tap = by.kernel[dx.unsigned_abs() as usize] * by.kernel[i32::unsigned_abs(dy) as usize];
        let mut weight = tap * normal.dot(surfaces.normal(index)).max(0.0).powi(by.normal_power);
        weight *= (-offset.dot(normal).abs() / (by.plane_sigma * footprint)).exp();
        alike += weight;
        weight *= (-(images.brightness(index) - images.brightness(center)).abs() / by.color_sigma).exp();
        weight *= (-(images.shadow_ratio(index) - images.shadow_ratio(center)).abs() / by.ratio_sigma).exp();
        strict.add(images, index, weight);
        relaxed.add(images, index, tap * (-offset.length_squared() / (nearness * nearness)).exp());
    }
    let support = alike - by.kernel[0] * by.kernel[0];
    let may_relax = by.step_px <= by.last_relaxed_step;
    let lack = if may_relax { (1.0 - support / by.min_support).clamp(0.0, 1.0) } else { 0.0 };
    let unit = images.shadowed[center][3];
    let mean = |strict: [f64; 3], relaxed: [f64; 3], total: f64| -> Texel {
        let [r, g, b] = std::array::from_fn(|i| (strict[i] + lack * relaxed[i]) / total);
        [r, g, b, unit]
    };
    let total = strict.weight + lack * relaxed.weight;
    let shadowed = mean(strict.shadowed, relaxed.shadowed, total);
    ([shadowed, mean(strict.unshadowed, relaxed.unshadowed, total)], lack)
}

/// Iteration `number` (from 1) of a frame against the formula; how many pixels take from what is only near.
fn check(frame: &Frame, number: usize, by: &Iteration) -> (Verdict, usize) {
    let images = Images::before(frame, number);
    let all: Vec<([Texel; 2], f64)> = frame.pixels().map(|(x, y)| filtered(frame, &images, by, x, y)).collect();
    let verdict = ["shadowed", "unshadowed"].into_iter().enumerate().try_for_each(|(side, what)| {
        let twin: Vec<Texel> = all.iter().map(|(estimates, _)| estimates[side]).collect();
        compare_texels(&format!("{what} of iteration {number}"), &output(frame, what, number), &twin, 4, TOLERANCE)
    });
    (verdict, all.iter().filter(|(_, lack)| *lack > 0.0).count())
}

fn settings() -> Settings {
    Settings::default().changed(|s| {
        s.many_lights.vpls = 500;
        s.many_lights.shadow_samples = 2;
    })
}

/// What is planted, in which iteration, and how.
type Fault = (&'static str, usize, fn(&mut Iteration));

#[test]
fn every_iteration_is_its_formula() {
    let test = common::gpu();
    let mut relaxed = 0;
    let scenes: [(&str, Scene); 2] = [("room", furnished_room()), ("screen", folding_screen())];
    for (name, scene) in &scenes {
        for (size, interleave) in SIZES.map(|size| (size, 1)).into_iter().chain([(SIZES[4], 2)]) {
            let settings = settings().changed(|s| {
                s.picture.size = size;
                s.lgh.interleave = interleave;
            });
            let frame = Frame::of(&test, scene, &settings);
            for (index, iteration) in ITERATIONS.iter().enumerate() {
                let (verdict, lacking) = check(&frame, index + 1, iteration);
                verdict.unwrap_or_else(|e| panic!("{name}, {size}, interleave {interleave}: {e}"));
                relaxed += lacking;
            }
        }
    }
    assert!(relaxed > 20, "only {relaxed} pixels stand alone: the slats are of no use");
}

#[test]
fn other_filters_are_noticed() {
    let test = common::gpu();
    let frame = Frame::of(&test, &folding_screen(), &settings().changed(|s| s.picture.size = SIZES[4]));
    let faults: [Fault; 11] = [
        ("a wider step", 1, |by| by.step_px = 2),
        ("a narrower step", 3, |by| by.step_px = 3),
        ("a middle tap 2 % heavier", 1, |by| by.kernel[0] *= 1.02),
        ("outer taps 5 % lighter", 2, |by| by.kernel[2] *= 0.95),
        ("a lower power of the cosine", 1, |by| by.normal_power = 31),
        ("a plane 3 % thicker", 1, |by| by.plane_sigma *= 1.03),
        ("colours that stop less", 1, |by| by.color_sigma *= 1.03),
        ("shadows that stop less", 2, |by| by.ratio_sigma *= 1.05),
        ("less that is near", 1, |by| by.nearness_sigma *= 0.98),
        ("other support", 2, |by| by.min_support *= 0.97),
        ("a wide step that takes what is near", 3, |by| by.last_relaxed_step = 4),
    ];
    for (what, number, plant) in faults {
        let mut iteration = ITERATIONS[number - 1];
        plant(&mut iteration);
        assert!(check(&frame, number, &iteration).0.is_err(), "{what} was not noticed");
    }
    let twin = output(&frame, "shadowed", 1);
    for value in [f64::NAN, f64::INFINITY] {
        let mut wrong = twin.clone();
        wrong[40][1] = value;
        assert!(compare_texels("one texel", &wrong, &twin, 4, TOLERANCE).is_err(), "{value}");
        assert!(compare_texels("one texel", &twin, &wrong, 4, TOLERANCE).is_err(), "{value} in the twin");
    }
}
