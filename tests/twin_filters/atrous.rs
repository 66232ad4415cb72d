//! The à-trous wavelet (`shaders/atrous`).

use gridlight::renderer::{Fresh, Job, Renderer, UploadedScene};
use gridlight::scene::Scene;
use gridlight::settings::{Settings, ShadowEstimate, Temporal};

use crate::common;
use crate::common::compare::Verdict;
use crate::common::picture::{Frame, SIZES, Texel, compare_texels};
use crate::common::rooms::{folding_screen, furnished_room};

/// For powers and exponentials, whose precision is the device's.
const TOLERANCE: [f64; 2] = [1e-3, 1e-7];

/// One iteration.
#[derive(Clone, Copy, Debug)]
struct Iteration {
    /// The first one cuts outliers, unless the estimate is unbiased, and takes the deviations from the pixels around.
    is_first: bool,
    cuts: bool,
    /// With a history the first one is told the deviations of pixels that have been seen for a while; others are below 0.
    is_told: bool,
    /// Distance of neighbours.
    step_px: i32,
    /// Weights of the taps along an axis, from the middle.
    kernel: [f64; 3],
    /// Power of the cosine between normals.
    normal_power: i32,
    /// Distance from the tangent plane in footprints, and difference in deviations, at which a weight falls to 1/e.
    plane_sigma: f64,
    noise_sigma: f64,
    /// What a pixel may carry, as a multiple of what those around it do.
    max_outlier: f64,
    /// Weight of neighbours alike below which others count too, and within what distance in footprints and steps.
    min_support: f64,
    nearness_sigma: f64,
    /// Widest step at which they do.
    last_relaxed_step: i32,
}

impl Iteration {
    /// Iteration `number`, from 1, of a frame with this estimate.
    fn of(frame: &Frame, estimate: ShadowEstimate, number: usize) -> Self {
        Self {
            is_told: number == 1 && has_history(frame),
            is_first: number == 1,
            cuts: estimate != ShadowEstimate::Unbiased,
            step_px: frame.n << (number - 1),
            kernel: [3.0 / 8.0, 1.0 / 4.0, 1.0 / 16.0],
            normal_power: 32,
            plane_sigma: 4.0,
            noise_sigma: 3.0,
            max_outlier: 64.0,
            min_support: 0.4,
            nearness_sigma: 4.0,
            last_relaxed_step: 8,
        }
    }
}

fn has_history(frame: &Frame) -> bool {
    frame.written.get::<f32>("temporal/blend", "shadowed_blended").is_some()
}

/// How many iterations there are: steps double up to 4, or up to 16 where the shadowed estimate itself is the picture.
fn iterations(frame: &Frame, estimate: ShadowEstimate) -> usize {
    let last_step: i32 = if estimate == ShadowEstimate::Ratio { 4 } else { 16 };
    (last_step / frame.n).ilog2() as usize + 1
}

/// The images of an iteration: shadowed and unshadowed estimate, and the deviation of the former.
struct Images {
    shadowed: Vec<Texel>,
    unshadowed: Vec<Texel>,
}

impl Images {
    /// What goes into an iteration of a frame.
    fn before(frame: &Frame, estimate: ShadowEstimate, number: usize) -> Self {
        let image = |what: &str, number: usize| match number {
            1 if has_history(frame) => frame.floats("temporal/blend", &format!("{what}_blended")),
            1 if frame.n > 1 => frame.floats(&format!("interleave/blur_{what}_y"), &format!("{what}_blurred_y")),
            1 => frame.floats("shadow_rays", what),
            _ => output(frame, what, number - 1),
        };
        // Where only the shadowed one is filtered, the other stays as it was.
        let unshadowed = image("unshadowed", if estimate == ShadowEstimate::Ratio { number } else { 1 });
        Self { shadowed: image("shadowed", number), unshadowed }
    }

    /// Both estimates of a pixel, cut to the greatest luminance that the unshadowed one may have.
    fn estimates(&self, index: usize, greatest: f64) -> [Texel; 2] {
        let kept = (greatest / luminance(self.unshadowed[index]).max(1e-30)).min(1.0);
        [self.shadowed[index], self.unshadowed[index]].map(|[r, g, b, a]| [r * kept, g * kept, b * kept, a])
    }

    /// The most that a pixel around this one may carry.
    fn greatest_plausible(&self, frame: &Frame, by: &Iteration, x: i32, y: i32) -> f64 {
        if !by.is_first || !by.cuts {
            return f64::INFINITY;
        }
        let around = taps().filter_map(|(dx, dy)| frame.surfaces.index(x + dx * by.step_px, y + dy * by.step_px));
        let (mut carried, mut count) = (Vec::new(), 0);
        for index in around {
            carried.push(luminance(self.unshadowed[index]));
            count += i32::from(self.unshadowed[index][3] > 0.0);
        }
        carried.sort_by(f64::total_cmp);
        carried.pop();
        let others: f64 = carried.iter().sum();
        if others > 0.0 { by.max_outlier * others / f64::from((count - 1).max(1)) } else { f64::INFINITY }
    }
}

fn taps() -> impl Iterator<Item = (i32, i32)> {
    (-2..=2).flat_map(|dy| (-2..=2).map(move |dx: i32| (dx, dy)))
}

fn output(frame: &Frame, what: &str, iteration: usize) -> Vec<Texel> {
    frame.floats(&format!("atrous/{iteration}"), &format!("{what}_{iteration}"))
}

fn luminance(color: Texel) -> f64 {
    0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2]
}

/// Sums of both estimates, of the shadowed luminance and its square, and of squared deviations.
#[derive(Clone, Copy, Default)]
struct Sums {
    estimates: [[f64; 3]; 2],
    moments: [f64; 2],
    variance: f64,
    weight: f64,
}

impl Sums {
    fn add(&mut self, estimates: [Texel; 2], difference: f64, deviation: f64, weight: f64) {
        for (sum, value) in self.estimates.iter_mut().zip(estimates) {
            sum.iter_mut().zip(value).for_each(|(sum, value)| *sum += weight * value);
        }
        self.moments[0] += weight * difference;
        self.moments[1] += weight * difference * difference;
        self.variance += (weight * deviation).powi(2);
        self.weight += weight;
    }
}

/// Both estimates of a pixel after an iteration, with the deviation of the shadowed one, and how much those that are only
/// near count.
fn filtered(frame: &Frame, images: &Images, by: &Iteration, x: i32, y: i32) -> ([Texel; 2], f64) {
    let surfaces = &frame.surfaces;
    let Some(center) = surfaces.surface(x, y) else { return ([[0.0; 4]; 2], 0.0) };
    let (position, normal) = (surfaces.position_ws(x, y, center), surfaces.normal(center));
    let footprint = surfaces.footprint(center);
    let nearness = by.nearness_sigma * footprint * f64::from(by.step_px);
    let greatest = images.greatest_plausible(frame, by, x, y);
    let is_blind = by.is_first && !(by.is_told && images.shadowed[center][3] >= 0.0);
    let deviation = |index: usize| match images.shadowed[index][3] {
        _ if is_blind => 1.0,
        unknown if unknown < 0.0 => images.shadowed[center][3],
        known => known,
    };
    let center_luminance = luminance(images.estimates(center, greatest)[0]);
    let (mut strict, mut relaxed, mut alike) = (Sums::default(), Sums::default(), 0.0);
    for (dx, dy) in taps() {
        let (px, py) = (x + dx * by.step_px, y + dy * by.step_px);
        let Some(index) = surfaces.surface(px, py) else { continue };
        let offset = surfaces.position_ws(px, py, index) - position;
        let tap = by.kernel[dx.unsigned_abs() as usize] * by.kernel[i32::unsigned_abs(dy) as usize];
        let mut weight = tap * normal.dot(surfaces.normal(index)).max(0.0).powi(by.normal_power);
        weight *= (-offset.dot(normal).abs() / (by.plane_sigma * footprint)).exp();
        alike += weight;
        let estimates = images.estimates(index, greatest);
        let difference = luminance(estimates[0]) - center_luminance;
        let deviations = by.noise_sigma * (deviation(center) + deviation(index));
        let likeness = if is_blind { 1.0 } else { (-difference.abs() / deviations.max(1e-30)).exp() };
        strict.add(estimates, difference, deviation(index), weight * likeness);
        let near = tap * likeness * (-offset.length_squared() / (nearness * nearness)).exp();
        relaxed.add(estimates, difference, deviation(index), near);
    }
    let support = alike - by.kernel[0] * by.kernel[0];
    let may_relax = by.step_px <= by.last_relaxed_step;
    let lack = if may_relax { (1.0 - support / by.min_support).clamp(0.0, 1.0) } else { 0.0 };
    let total = strict.weight + lack * relaxed.weight;
    let [m1, m2] = [0, 1].map(|i| (strict.moments[i] + lack * relaxed.moments[i]) / total);
    let own_variance = if is_blind { (m2 - m1 * m1).max(0.0) } else { 1.0 };
    let variance = own_variance * (strict.variance + lack * lack * relaxed.variance) / (total * total);
    let mean = |side: usize, alpha: f64| -> Texel {
        let [r, g, b] = [0, 1, 2].map(|i| (strict.estimates[side][i] + lack * relaxed.estimates[side][i]) / total);
        [r, g, b, alpha]
    };
    ([mean(0, variance.sqrt()), mean(1, images.unshadowed[center][3])], lack)
}

/// Iteration `number` (from 1) of a frame against the formula; how many pixels take from what is only near.
fn check(frame: &Frame, estimate: ShadowEstimate, number: usize, by: &Iteration) -> (Verdict, usize) {
    let images = Images::before(frame, estimate, number);
    let all: Vec<([Texel; 2], f64)> = frame.pixels().map(|(x, y)| filtered(frame, &images, by, x, y)).collect();
    let sides = if estimate == ShadowEstimate::Ratio { 0..2 } else { 0..1 };
    let verdict = sides.into_iter().try_for_each(|side| {
        let what = ["shadowed", "unshadowed"][side];
        let twin: Vec<Texel> = all.iter().map(|(estimates, _)| estimates[side]).collect();
        compare_texels(&format!("{what} of iteration {number}"), &output(frame, what, number), &twin, 4, TOLERANCE)
    });
    (verdict, all.iter().filter(|(_, lack)| *lack > 0.0).count())
}

fn settings(estimate: ShadowEstimate) -> Settings {
    Settings::default().changed(|s| {
        s.many_lights.vpls = 500;
        s.many_lights.shadow_samples = 2;
        s.lgh.shadow_estimate = Some(estimate);
    })
}

/// What is planted, in which iteration, and how.
type Fault = (&'static str, usize, fn(&mut Iteration));

const ESTIMATES: [ShadowEstimate; 3] = [ShadowEstimate::Ratio, ShadowEstimate::Corrected, ShadowEstimate::Unbiased];

#[test]
fn every_iteration_is_its_formula() {
    let test = common::gpu();
    let mut relaxed = 0;
    let scenes: [(&str, Scene); 2] = [("room", furnished_room()), ("screen", folding_screen())];
    for (name, scene) in &scenes {
        let whole = SIZES.map(|size| (size, 1, ShadowEstimate::Corrected));
        let other = ESTIMATES.map(|estimate| (SIZES[4], 2, estimate));
        for (size, interleave, estimate) in whole.into_iter().chain(other) {
            let settings = settings(estimate).changed(|s| {
                s.picture.size = size;
                s.lgh.interleave = interleave;
            });
            let frame = Frame::of(&test, scene, &settings);
            for number in 1..=iterations(&frame, estimate) {
                let (verdict, lacking) = check(&frame, estimate, number, &Iteration::of(&frame, estimate, number));
                verdict.unwrap_or_else(|e| panic!("{name}, {size}, interleave {interleave}, {estimate:?}: {e}"));
                relaxed += lacking;
            }
        }
    }
    assert!(relaxed > 20, "only {relaxed} pixels stand alone: the slats are of no use");
}

/// The last of so many frames with history.
fn after(test: &common::GpuTest, scene: &Scene, settings: &Settings, frames: u32) -> Frame {
    let uploaded = UploadedScene::new(&test.gpu, scene).unwrap();
    let camera = &scene.cameras[0];
    let mut renderer = Renderer::new(&Job::new(&test.gpu, &uploaded, camera, settings)).unwrap();
    for frame in 0..frames {
        renderer.set_accumulated_frame(frame, Fresh::Shadows);
        let ticket = renderer.submit().unwrap();
        renderer.wait(ticket).unwrap();
    }
    Frame::by(&renderer, camera, settings)
}

#[test]
fn with_history_the_first_iteration_is_told_the_noise() {
    let test = common::gpu();
    for (estimate, interleave) in ESTIMATES.map(|estimate| (estimate, 1)).into_iter().chain([(ESTIMATES[0], 2)]) {
        let settings = settings(estimate).changed(|s| {
            (s.picture.size, s.lgh.interleave) = (SIZES[4], interleave);
            s.many_lights.shadow_samples = 1;
            s.lgh.temporal = Some(Temporal::Shadows);
        });
        // Before the fourth frame the noise is not known.
        for (frames, is_known) in [(2, false), (7, true)] {
            let frame = after(&test, &folding_screen(), &settings, frames);
            for number in 1..=iterations(&frame, estimate) {
                let verdict = check(&frame, estimate, number, &Iteration::of(&frame, estimate, number)).0;
                verdict.unwrap_or_else(|e| panic!("{frames} frames, interleave {interleave}, {estimate:?}: {e}"));
            }
            let first = Iteration::of(&frame, estimate, 1);
            let untold = check(&frame, estimate, 1, &Iteration { is_told: false, ..first }).0;
            assert_eq!(untold.is_err(), is_known, "{frames} frames: noise from the pixels around");
            let stops_less = Iteration { noise_sigma: 1.05 * first.noise_sigma, ..first };
            assert_eq!(check(&frame, estimate, 1, &stops_less).0.is_err(), is_known, "{frames} frames");
        }
    }
}

#[test]
fn other_filters_are_noticed() {
    let test = common::gpu();
    let estimate = ShadowEstimate::Corrected;
    // Few samples of lights that the hierarchy knows little of.
    let settings = settings(estimate).changed(|s| {
        s.picture.size = SIZES[4];
        s.many_lights.shadow_samples = 1;
        s.lgh.alpha = 0.5;
    });
    let frame = Frame::of(&test, &folding_screen(), &settings);
    let faults: [Fault; 12] = [
        ("a wider step", 1, |by| by.step_px = 2),
        ("a narrower step", 3, |by| by.step_px = 3),
        ("a middle tap 2 % heavier", 1, |by| by.kernel[0] *= 1.02),
        ("outer taps 5 % lighter", 2, |by| by.kernel[2] *= 0.95),
        ("a lower power of the cosine", 1, |by| by.normal_power = 31),
        ("a plane 3 % thicker", 1, |by| by.plane_sigma *= 1.03),
        ("noise that stops less", 2, |by| by.noise_sigma *= 1.05),
        ("noise that stops more in the last iteration", 5, |by| by.noise_sigma *= 0.95),
        ("outliers cut at a quarter", 1, |by| by.max_outlier *= 0.25),
        ("less that is near", 1, |by| by.nearness_sigma *= 0.98),
        ("other support", 2, |by| by.min_support *= 0.97),
        ("a wide step that takes what is near", 5, |by| by.last_relaxed_step = 16),
    ];
    for (what, number, plant) in faults {
        let mut iteration = Iteration::of(&frame, estimate, number);
        plant(&mut iteration);
        assert!(check(&frame, estimate, number, &iteration).0.is_err(), "{what} was not noticed");
    }
    let twin = output(&frame, "shadowed", 1);
    for value in [f64::NAN, f64::INFINITY] {
        let mut wrong = twin.clone();
        wrong[40][1] = value;
        assert!(compare_texels("one texel", &wrong, &twin, 4, TOLERANCE).is_err(), "{value}");
        assert!(compare_texels("one texel", &twin, &wrong, 4, TOLERANCE).is_err(), "{value} in the twin");
    }
}
