//! Histogram, exposure and tone curves on the GPU against their twins, over painted pictures.

mod common;

use ash::vk;
use bytemuck::Zeroable;
use common::hierarchy::frame_shape;
use common::light_sets::Random;
use common::{GpuTest, compare, written::Written};
use glam::Vec3;
use gridlight::cpu::exposure::{count_luminances, measure_exposure};
use gridlight::cpu::tone_map::{srgb_encode, tone_map};
use gridlight::gpu::Executor;
use gridlight::graph::Access;
use gridlight::passes::gbuffer::GBuffer;
use gridlight::passes::tone_map::{self as pass, sample_step_px};
use gridlight::passes::{Frame, FrameShape, shader};
use gridlight::settings::ToneMap;
use gridlight::shared::{EXPOSURE_BINS, EXPOSURE_STOPS, FrameData};

const CURVES: [ToneMap; 3] = [ToneMap::Reinhard, ToneMap::Agx, ToneMap::Neutral];
/// Rounding to 8 bits, and a little.
const PICTURE_TOLERANCE: f32 = 0.6 / 255.0;
/// Logarithms and sums in single precision.
const EXPOSURE_TOLERANCE: f64 = 1e-4;

/// What is to be shown.
struct Painted {
    size_px: [u32; 2],
    radiance: Vec<Vec3>,
    /// 0 where there is no surface.
    depth: Vec<f32>,
}

/// What the passes left.
struct Shown {
    histogram: Vec<u32>,
    exposure: f32,
    picture: Vec<[u8; 4]>,
}

impl Painted {
    /// Pixel by pixel: radiance and depth.
    fn new(size_px: [u32; 2], mut pixel: impl FnMut(usize) -> (Vec3, f32)) -> Self {
        let (radiance, depth) = (0..size_px.iter().product::<u32>() as usize).map(&mut pixel).unzip();
        Self { size_px, radiance, depth }
    }

    fn show(&self, test: &GpuTest, change: impl FnOnce(&mut FrameData)) -> Shown {
        let [width_px, height_px] = self.size_px;
        let mut frame = Frame::without_scene(FrameShape { width_px, height_px, ..frame_shape() });
        let pixels = frame.graph.persistent_buffer("pixels", 16 * self.radiance.len() as u64);
        let radiance = frame.image("radiance", vk::Format::R32G32B32A32_SFLOAT);
        let depth = frame.image("gbuffer_depth", vk::Format::R32_SFLOAT);
        let paint = frame
            .compute("paint", shader("tests/paint_picture", frame.per_pixel()))
            .bind("pixels", pixels, Access::ComputeRead)
            .bind("out_radiance", radiance, Access::ComputeWrite)
            .bind("out_depth", depth, Access::ComputeWrite);
        frame.graph.add_pass(paint);
        pass::add(
            &mut frame,
            &GBuffer { albedo: radiance, normals: radiance, depth, motion: None, emission: None },
            radiance,
        );
        let mut data = FrameData { size_px: self.size_px, exposure_compensation: 1.0, ..FrameData::zeroed() };
        change(&mut data);
        let executor = Executor::new(&test.gpu, frame.graph, None).unwrap();
        let texels: Vec<_> = self.radiance.iter().zip(&self.depth).map(|(rgb, depth)| rgb.extend(*depth)).collect();
        executor.write_buffer(pixels, bytemuck::cast_slice(&texels)).unwrap();
        let written = Written::by_graph(&executor, &data);
        Shown {
            histogram: written.last("exposure_histogram"),
            exposure: written.last::<f32>("exposure")[0],
            picture: written.last("picture"),
        }
    }

    fn histogram(&self) -> Vec<u32> {
        let step = sample_step_px(self.size_px) as usize;
        count_luminances(self.size_px.map(|edge| edge as usize), step, &self.radiance, &self.depth)
    }
}

/// A grey in the middle of a bin, where no rounding moves it to the next.
fn grey_of_bin(bin: u32) -> Vec3 {
    let stops = EXPOSURE_STOPS as f32;
    Vec3::splat(((bin as f32 + 0.5) * stops / EXPOSURE_BINS as f32 - 0.5 * stops).exp2())
}

/// Random greys of all bins, a third of them without a surface, a tenth black.
fn noise(size_px: [u32; 2]) -> Painted {
    let mut random = Random::new(size_px[0] * 7 + size_px[1]);
    Painted::new(size_px, |_| {
        let (is_black, is_behind) = (random.bits().is_multiple_of(10), random.bits().is_multiple_of(3));
        let radiance = if is_black { Vec3::ZERO } else { grey_of_bin(random.bits() % EXPOSURE_BINS) };
        (radiance, if is_behind { 0.0 } else { 0.5 })
    })
}

fn same_exposure(found: f32, expected: f64) -> compare::Verdict {
    let error = (f64::from(found) / expected - 1.0).abs();
    if error <= EXPOSURE_TOLERANCE {
        Ok(())
    } else {
        Err(format!("exposure {found} on the GPU, {expected} in the twin"))
    }
}

fn same_picture(found: &[[u8; 4]], expected: &[Vec3]) -> compare::Verdict {
    assert_eq!(found.len(), expected.len());
    for (index, (texel, color)) in found.iter().zip(expected).enumerate() {
        let shown = Vec3::from_array([0, 1, 2].map(|channel| f32::from(texel[channel]) / 255.0));
        if !compare::near(shown, *color, PICTURE_TOLERANCE) {
            return Err(format!("pixel {index}: {shown} on the GPU, {color} in the twin"));
        }
    }
    Ok(())
}

#[test]
fn histogram_and_exposure_at_awkward_sizes() {
    let test = common::gpu();
    for size_px in [[1, 1], [7, 7], [8, 8], [9, 9], [65, 3], [257, 131], [1100, 1001]] {
        let painted = noise(size_px);
        let (shown, twin) = (painted.show(&test, |_| ()), painted.histogram());
        compare::exact(&format!("histogram of {size_px:?}"), &shown.histogram, &twin).unwrap();
        same_exposure(shown.exposure, measure_exposure(&twin, f64::INFINITY)).unwrap();
    }
}

#[test]
fn pictures_that_leave_little_to_measure() {
    let test = common::gpu();
    let grey = |bin: u32| Painted::new([5, 3], |_| (grey_of_bin(bin), 1.0));
    let black = Painted::new([5, 3], |_| (Vec3::ZERO, 1.0));
    let sky = Painted::new([5, 3], |_| (grey_of_bin(600), 0.0));
    let one = |value: f32| Painted::new([5, 3], move |i| (if i == 7 { Vec3::splat(value) } else { Vec3::ZERO }, 1.0));
    let no_number = Painted::new([5, 3], |i| (if i < 4 { grey_of_bin(500) } else { Vec3::NAN }, 1.0));
    for painted in [grey(0), grey(EXPOSURE_BINS - 1), black, sky, one(1e30), one(f32::INFINITY), one(1e-30), no_number]
    {
        let (shown, twin) = (painted.show(&test, |_| ()), painted.histogram());
        compare::exact("histogram", &shown.histogram, &twin).unwrap();
        same_exposure(shown.exposure, measure_exposure(&twin, f64::INFINITY)).unwrap();
    }
}

#[test]
fn given_exposures_and_compensation() {
    let test = common::gpu();
    let painted = noise([16, 9]);
    let at_most = |most: f64| measure_exposure(&painted.histogram(), most);
    let automatic = at_most(f64::INFINITY);
    // Below 0 it is the most that the automatic one may be.
    let (loose, tight) = (2.0 * automatic as f32, 0.5 * automatic as f32);
    assert!(at_most(tight.into()) == f64::from(tight) && at_most(loose.into()) == automatic);
    for (given, factor, expected) in [
        (0.0, 1.0, automatic),
        (0.0, 4.0, 4.0 * automatic),
        (3.0, 1.0, 3.0),
        (3.0, 0.5, 1.5),
        (-loose, 1.0, at_most(loose.into())),
        (-tight, 1.0, at_most(tight.into())),
        (-tight, 4.0, 4.0 * at_most(tight.into())),
    ] {
        let shown = painted.show(&test, |data| (data.exposure, data.exposure_compensation) = (given, factor));
        same_exposure(shown.exposure, expected).unwrap();
    }
}

#[test]
fn a_black_picture_is_bounded_as_well() {
    let test = common::gpu();
    let black = Painted::new([5, 3], |_| (Vec3::ZERO, 1.0));
    for (most, expected) in [(0.25, 0.25), (4.0, 1.0)] {
        let shown = black.show(&test, |data| data.exposure = -most);
        assert_eq!(measure_exposure(&black.histogram(), most.into()), expected);
        same_exposure(shown.exposure, expected).unwrap();
    }
}

/// Greys and colours from far below black to far above white.
fn colors() -> Painted {
    let hues = [
        Vec3::ONE,
        Vec3::X,
        Vec3::Y,
        Vec3::Z,
        Vec3::new(1.0, 0.9, 0.1),
        Vec3::new(0.3, 0.5, 1.0),
        Vec3::new(1.0, 0.5, 0.45),
    ];
    Painted::new([71, hues.len() as u32], |i| ((0.25 * (i % 71) as f32 - 11.0).exp2() * hues[i / 71], 1.0))
}

fn as_shown(painted: &Painted, curve: ToneMap, exposure: f32) -> Vec<Vec3> {
    painted.radiance.iter().map(|radiance| srgb_encode(tone_map(curve, *radiance * exposure))).collect()
}

#[test]
fn tone_curves() {
    let test = common::gpu();
    let painted = colors();
    for curve in CURVES {
        for exposure in [1.0, 8.0] {
            let shown = painted.show(&test, |data| (data.exposure, data.tone_map) = (exposure, curve.code()));
            same_picture(&shown.picture, &as_shown(&painted, curve, exposure)).unwrap();
            for other in CURVES.into_iter().filter(|other| *other != curve) {
                same_picture(&shown.picture, &as_shown(&painted, other, exposure)).unwrap_err();
            }
        }
    }
}

#[test]
fn planted_faults() {
    let painted = noise([64, 36]);
    let histogram = painted.histogram();
    let mut moved = histogram.clone();
    let bin = histogram.iter().position(|count| *count > 0).unwrap();
    (moved[bin], moved[bin + 1]) = (moved[bin] - 1, moved[bin + 1] + 1);
    compare::exact("histogram", &moved, &histogram).unwrap_err();
    let exposure = measure_exposure(&histogram, f64::INFINITY);
    for wrong in [1.001 * exposure as f32, -(exposure as f32), f32::NAN] {
        same_exposure(wrong, exposure).unwrap_err();
    }
    // What is behind the surfaces counts less.
    let flat = Painted { depth: vec![1.0; painted.depth.len()], ..painted };
    same_exposure(measure_exposure(&flat.histogram(), f64::INFINITY) as f32, exposure).unwrap_err();
    let color = Vec3::new(0.5, 0.2, 0.7);
    let texel = (color * 255.0).round().as_u8vec3().extend(255).to_array();
    same_picture(&[texel], &[color]).unwrap();
    same_picture(&[texel], &[color + Vec3::new(0.0, 0.01, 0.0)]).unwrap_err();
    same_picture(&[texel], &[Vec3::NAN]).unwrap_err();
}
