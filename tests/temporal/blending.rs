//! What a frame adds to what is known (`shaders/temporal/blend.comp.glsl`, `blend_lighting.comp.glsl`), against the formulas.

use gridlight::settings::{Settings, ShadowEstimate, Size, Temporal};

use crate::area_lights::{AREA_LIGHTS, AreaLight, area_settings, lit_scene};
use crate::common::compare::Verdict;
use crate::common::picture::{Frame, SIZES, Texel, compare_texels};
use crate::common::rooms::furnished_room;
use crate::common::{GpuTest, gpu};
use crate::run::{Run, settings};

/// Products and sums of a few floats.
const TOLERANCE: [f64; 2] = [1e-5, 1e-7];

/// How frames are blended.
#[derive(Clone, Copy)]
struct Blend {
    /// Of the newest frame.
    least_weight: f64,
    least_variance_weight: f64,
    known_frames: f64,
    least_deviation: f64,
    /// Of light by itself that is a share of what arrives without shadow.
    least_is_relative: bool,
    /// Of a known deviation what the filter is told.
    told_deviation: f64,
    max_outlier: f64,
    /// Weight of the unshadowed estimate over that of the shadowed one.
    unshadowed_share: f64,
}

const BLEND: Blend = Blend {
    least_weight: 0.05,
    least_variance_weight: 0.1,
    known_frames: 4.0,
    least_deviation: 0.02 / 6.0,
    least_is_relative: true,
    told_deviation: 0.5,
    max_outlier: 64.0,
    unshadowed_share: 1.0,
};

/// A frame with what went before it.
struct Blended {
    frame: Frame,
    mode: Temporal,
    estimate: ShadowEstimate,
    /// Begins the names of passes and images.
    label: &'static str,
}

/// What a pixel leaves.
struct Pixel {
    history: [Texel; 2],
    estimates: [Texel; 2],
    lighting: Texel,
}

fn luminance(color: Texel) -> f64 {
    0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2]
}

fn mix(a: Texel, b: Texel, weight: f64) -> Texel {
    [0, 1, 2, 3].map(|channel| a[channel] + weight * (b[channel] - a[channel]))
}

fn with_alpha([r, g, b, _]: Texel, alpha: f64) -> Texel {
    [r, g, b, alpha]
}

fn scaled([r, g, b, a]: Texel, by: f64) -> Texel {
    [r * by, g * by, b * by, a]
}

impl Blended {
    /// The sixth frame after the camera has moved a little before it, so that pixels have all numbers of frames.
    fn of(test: &GpuTest, settings: &Settings) -> Self {
        let mut run = Run::new(&test.gpu, &furnished_room(), settings);
        for frame in 0..6 {
            if frame == 2 || frame == 5 {
                run.step_right(0.05);
            }
            run.next();
        }
        let lgh = &settings.lgh;
        let estimate = lgh.shadow_estimate.unwrap();
        Self { frame: run.last(), mode: lgh.temporal.unwrap(), estimate, label: "" }
    }

    /// The same of the light that comes straight from the environment, or from surfaces that shine.
    fn of_area_light(test: &GpuTest, size: Size, light: AreaLight) -> Self {
        let mut run = Run::new(&test.gpu, &lit_scene(), &area_settings(size, Temporal::Shadows));
        for frame in 0..6 {
            if frame == 2 || frame == 5 {
                run.step_right(0.05);
            }
            run.next();
        }
        let (mode, estimate) = (Temporal::Shadows, ShadowEstimate::Unbiased);
        Self { frame: run.last(), mode, estimate, label: light.label }
    }

    fn pass(&self, name: &str) -> String {
        format!("temporal/{}{name}", self.label)
    }

    /// Whether estimates are light by themselves.
    fn is_radiance(&self) -> bool {
        !self.label.is_empty()
    }

    /// What goes in: both estimates and the lighting.
    fn inputs(&self) -> [Vec<Texel>; 3] {
        let frame = &self.frame;
        if self.is_radiance() {
            let pass = format!("{}light", self.label);
            let [shadowed, unshadowed] =
                ["shadowed", "unshadowed"].map(|what| frame.floats(&pass, &format!("{}{what}", self.label)));
            return [shadowed, unshadowed.clone(), unshadowed];
        }
        let input = |what: &str, pass: &str| match frame.n {
            1 => frame.floats(pass, what),
            _ => frame.floats(&format!("interleave/blur_{what}_y"), &format!("{what}_blurred_y")),
        };
        [input("shadowed", "shadow_rays"), input("unshadowed", "shadow_rays"), input("lighting", "light_gather")]
    }

    fn reprojected(&self, what: &str) -> Vec<Texel> {
        self.frame.floats(&self.pass("reproject"), &format!("{}reprojected_{what}", self.label))
    }

    /// How much of a pixel's history tiles give up, bilinear between their middles.
    fn given_up(&self, x: i32, y: i32) -> f64 {
        let tiles: Option<Vec<[f32; 4]>> =
            self.frame.written.get(&self.pass("compare_tiles"), &format!("{}given_up", self.label));
        let Some(tiles) = tiles else { return 0.0 };
        let [columns, rows] = [self.frame.size.width, self.frame.size.height].map(|edge| edge.div_ceil(8) as i32);
        let at = [x, y].map(|at| (f64::from(at) + 0.5) / 8.0 - 0.5);
        let tap = |corner: [i32; 2]| {
            let [column, row] = [0, 1].map(|axis| at[axis].floor() as i32 + corner[axis]);
            let share = |axis: usize| {
                let share = at[axis] - at[axis].floor();
                if corner[axis] == 0 { 1.0 - share } else { share }
            };
            let index = row.clamp(0, rows - 1) * columns + column.clamp(0, columns - 1);
            share(0) * share(1) * f64::from(tiles[index as usize][0])
        };
        [[0, 0], [1, 0], [0, 1], [1, 1]].map(tap).iter().sum()
    }

    /// The share of a pixel's estimates that does not stand out from those around it.
    fn kept_share(&self, by: Blend, unshadowed: &[Texel], x: i32, y: i32) -> f64 {
        let index = self.frame.surfaces.index(x, y).unwrap();
        if self.estimate == ShadowEstimate::Unbiased || self.frame.surfaces.surface(x, y).is_none() {
            return 1.0;
        }
        let taps = (-2..=2).flat_map(|dy| (-2..=2).map(move |dx| (dx, dy)));
        let around: Vec<Texel> = taps
            .filter_map(|(dx, dy)| self.frame.surfaces.index(x + dx * self.frame.n, y + dy * self.frame.n))
            .map(|index| unshadowed[index])
            .collect();
        let carried: Vec<f64> = around.iter().map(|texel| luminance(*texel)).collect();
        let others = carried.iter().sum::<f64>() - carried.iter().fold(0.0, |most: f64, one| most.max(*one));
        let count = around.iter().filter(|texel| texel[3] > 0.0).count() as f64;
        let greatest = by.max_outlier * others / (count - 1.0).max(1.0);
        if others > 0.0 { (greatest / luminance(unshadowed[index]).max(1e-30)).min(1.0) } else { 1.0 }
    }

    fn twin(&self, by: Blend) -> Vec<Pixel> {
        let [shadowed, unshadowed, lighting] = self.inputs();
        let before = ["shadowed", "unshadowed"].map(|what| self.reprojected(what));
        let keeps_light = self.mode == Temporal::Indirect;
        let before_lighting = if keeps_light { self.reprojected("lighting") } else { before[0].clone() };
        let pixel = |(x, y): (i32, i32)| {
            let i = self.frame.surfaces.index(x, y).unwrap();
            let unit = unshadowed[i][3];
            let kept = self.kept_share(by, &unshadowed, x, y) * if keeps_light { unit } else { 1.0 };
            let new = [shadowed[i], unshadowed[i]].map(|estimate| scaled(estimate, kept));
            let new_lighting = with_alpha(lighting[i], unit);
            let frames = before[0][i][3] + 1.0;
            if frames <= 1.0 {
                let has_surface = f64::from(u8::from(self.frame.surfaces.surface(x, y).is_some()));
                return Pixel {
                    history: [with_alpha(new[0], has_surface), with_alpha(new[1], 0.0)],
                    estimates: [with_alpha(shadowed[i], -1.0), unshadowed[i]],
                    lighting: new_lighting,
                };
            }
            let weight = (1.0 / frames).max(by.least_weight).max(self.given_up(x, y));
            let lighting = mix(before_lighting[i], new_lighting, weight);
            let unit = if keeps_light { lighting[3] } else { unit };
            let residual = luminance(new[0]) - luminance(before[0][i]);
            let variance_weight = (1.0 / (frames - 1.0)).max(by.least_variance_weight).min(1.0);
            let variance = before[1][i][3] + variance_weight * (residual.powi(2) - before[1][i][3]);
            let scale = if keeps_light { 1.0 / unit } else { 1.0 };
            let frames = frames.min(1.0 / weight);
            let of_mean = (1.0 / frames).max(by.least_weight / (2.0 - by.least_weight));
            let means = [mix(before[0][i], new[0], weight), mix(before[1][i], new[1], weight * by.unshadowed_share)];
            let least_unit = if self.is_radiance() && by.least_is_relative { luminance(means[1]) } else { 1.0 };
            let least = by.least_deviation * least_unit;
            let deviation = (by.told_deviation * (variance * of_mean).sqrt() * scale).max(least);
            let known = if frames >= by.known_frames { deviation } else { -1.0 };
            Pixel {
                history: [with_alpha(means[0], frames), with_alpha(means[1], variance)],
                estimates: [with_alpha(scaled(means[0], scale), known), with_alpha(scaled(means[1], scale), unit)],
                lighting,
            }
        };
        self.frame.pixels().map(pixel).collect()
    }

    fn check(&self, by: Blend) -> Verdict {
        let twin = self.twin(by);
        for (side, what) in ["shadowed", "unshadowed"].into_iter().enumerate() {
            let compare = |name: &str, twin: Vec<Texel>| {
                let name = format!("{}{name}", self.label);
                compare_texels(&name, &self.frame.floats(&self.pass("blend"), &name), &twin, 4, TOLERANCE)
            };
            compare(&format!("temporal_{what}"), twin.iter().map(|pixel| pixel.history[side]).collect())?;
            compare(&format!("{what}_blended"), twin.iter().map(|pixel| pixel.estimates[side]).collect())?;
        }
        if self.mode != Temporal::Indirect {
            return Ok(());
        }
        let lighting = self.frame.floats("temporal/blend_lighting", "temporal_lighting");
        let twin: Vec<Texel> = twin.iter().map(|pixel| pixel.lighting).collect();
        compare_texels("temporal_lighting", &lighting, &twin, 4, TOLERANCE)
    }
}

/// What is planted, and how.
type Fault = (&'static str, fn(&mut Blend));

#[test]
fn frames_are_blended_by_the_formula() {
    let test = gpu();
    let modes = [(Temporal::Shadows, ShadowEstimate::Corrected), (Temporal::Indirect, ShadowEstimate::Ratio)];
    let sizes = SIZES.into_iter().flat_map(|size| modes.map(|mode| (size, 1, mode)));
    let others = [(2, Temporal::Indirect, ShadowEstimate::Corrected), (4, Temporal::Shadows, ShadowEstimate::Unbiased)];
    let others = others.map(|(interleave, mode, estimate)| (SIZES[4], interleave, (mode, estimate)));
    for (size, interleave, (mode, estimate)) in sizes.chain(others) {
        let settings = settings(size, mode, estimate).changed(|s| s.lgh.interleave = interleave);
        let verdict = Blended::of(&test, &settings).check(BLEND);
        verdict.unwrap_or_else(|e| panic!("{size}, interleave {interleave}, {mode:?}, {estimate:?}: {e}"));
    }
}

#[test]
fn light_by_itself_is_blended_by_the_formula() {
    let test = gpu();
    for light in AREA_LIGHTS {
        for size in SIZES {
            let blended = Blended::of_area_light(&test, size, light);
            blended.check(BLEND).unwrap_or_else(|e| panic!("{size}, {}: {e}", light.label));
        }
        let blended = Blended::of_area_light(&test, SIZES[4], light);
        let absolute = blended.check(Blend { least_is_relative: false, ..BLEND });
        assert!(absolute.is_err(), "{}: a least deviation that does not follow the light was not noticed", light.label);
    }
}

#[test]
fn the_newest_frame_has_the_weight_that_is_asked_for() {
    let test = gpu();
    for weight in [0.2, 1.0] {
        let settings = settings(SIZES[4], Temporal::Indirect, ShadowEstimate::Corrected)
            .changed(|s| s.lgh.temporal_weight = Some(weight));
        let blended = Blended::of(&test, &settings);
        blended.check(Blend { least_weight: f64::from(weight), ..BLEND }).unwrap();
        assert!(blended.check(BLEND).is_err(), "{weight} is not told from the default");
    }
}

#[test]
fn other_blends_are_noticed() {
    let test = gpu();
    // Long enough for the least weight to count.
    let settings = settings(SIZES[4], Temporal::Indirect, ShadowEstimate::Corrected);
    let mut run = Run::new(&test.gpu, &furnished_room(), &settings);
    (0..24).for_each(|_| run.next());
    let (mode, estimate) = (Temporal::Indirect, ShadowEstimate::Corrected);
    let blended = Blended { frame: run.last(), mode, estimate, label: "" };
    blended.check(BLEND).unwrap();
    let faults: [Fault; 6] = [
        ("deviations told in full", |by| by.told_deviation = 1.0),
        ("both estimates with different weights", |by| by.unshadowed_share = 1.02),
        ("a longer memory", |by| by.least_weight = 0.049),
        ("a longer memory of the variance", |by| by.least_variance_weight = 0.098),
        ("noise that is known later", |by| by.known_frames = 22.0),
        ("outliers cut at a sixteenth", |by| by.max_outlier /= 16.0),
    ];
    for (what, plant) in faults {
        let mut blend = BLEND;
        plant(&mut blend);
        assert!(blended.check(blend).is_err(), "{what} were not noticed");
    }
}
