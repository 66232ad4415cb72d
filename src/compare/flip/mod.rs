//! LDR-FLIP: the difference seen when flipping between two pictures (Andersson, Nilsson, Akenine-Möller, Oskarsson,
//! Åström, Fairchild: "FLIP: A Difference Evaluator for Alternating Images", PACMCGIT 3(2), 2020).

mod color;
mod filters;

use std::f64::consts::PI;

use glam::Vec3;

use super::image::Image;
use super::tone::decode_srgb;
use color::{from_opponent, hyab, to_hunt_lab, to_opponent};
use filters::{Plane, convolve};

/// Pixels for each degree of the visual field: a monitor 3840 pixels and 0.7 m wide, seen from 0.7 m.
pub const PIXELS_PER_DEGREE: f64 = 0.7 * (3840.0 / 0.7) * (PI / 180.0);

/// The exponent on colour differences.
const COLOR_EXPONENT: f32 = 0.7;
/// Where the colour difference, a fraction of the largest, meets the error [`KNEE_ERROR`].
const KNEE: f32 = 0.4;
/// The error at the knee.
const KNEE_ERROR: f32 = 0.95;
/// The exponent on feature differences.
const FEATURE_EXPONENT: f32 = 0.5;
/// Width in degrees of the features that edge and point detection look for.
const FEATURE_DEGREES: f64 = 0.082;

/// The FLIP error of each pixel, 0 to 1, of two display-ready pictures (sRGB, 0 to 1, all finite) of one size.
///
/// # Panics
/// When the sizes differ.
#[must_use]
pub fn flip_map(reference: &Image, test: &Image) -> Vec<f32> {
    assert_eq!(reference.size(), test.size(), "FLIP compares pictures of one size");
    let filters = Filters::new(PIXELS_PER_DEGREE);
    let (a, b) = std::thread::scope(|scope| {
        let other = scope.spawn(|| FilteredImage::new(test, &filters));
        let a = FilteredImage::new(reference, &filters);
        (a, other.join().expect("FLIP does not panic on pictures of one size"))
    });
    let largest = largest_color_difference();
    let pixel = |i: usize| {
        let color = color_error(hyab(a.color[i], b.color[i]).powf(COLOR_EXPONENT), largest);
        let feature = f32::max((a.edge[i] - b.edge[i]).abs(), (a.point[i] - b.point[i]).abs());
        let feature = (feature / std::f32::consts::SQRT_2).powf(FEATURE_EXPONENT);
        color.powf(1.0 - feature)
    };
    (0..a.color.len()).map(pixel).collect()
}

/// The distance of the two most different colours, green and blue.
fn largest_color_difference() -> f32 {
    hyab(to_hunt_lab(Vec3::Y), to_hunt_lab(Vec3::Z)).powf(COLOR_EXPONENT)
}

/// Small differences take most of the range: linear up to the knee, then flat to 1.
fn color_error(difference: f32, largest: f32) -> f32 {
    let knee = KNEE * largest;
    if difference < knee {
        difference * KNEE_ERROR / knee
    } else {
        KNEE_ERROR + (difference - knee) / (largest - knee) * (1.0 - KNEE_ERROR)
    }
}

/// What the eye gets of one picture.
struct FilteredImage {
    /// Filtered by contrast sensitivity, in Hunt-adjusted L*a*b*.
    color: Vec<Vec3>,
    /// Strength of edges, from luminance.
    edge: Vec<f32>,
    /// Strength of points, from luminance.
    point: Vec<f32>,
}

impl FilteredImage {
    fn new(image: &Image, filters: &Filters) -> Self {
        let linear = |pixel: &[f32; 3]| to_opponent(Vec3::from(pixel.map(|v| decode_srgb(v.clamp(0.0, 1.0)))));
        let opponent: Vec<Vec3> = image.pixels().iter().map(linear).collect();
        let plane = |channel: usize| opponent.iter().map(|v| v[channel]).collect::<Vec<f32>>();
        let filtered = [0, 1, 2].map(|channel| filters.contrast(&plane(channel), image.width, channel));
        let color = |i: usize| {
            let rgb = from_opponent(Vec3::new(filtered[0][i], filtered[1][i], filtered[2][i]));
            to_hunt_lab(rgb.clamp(Vec3::ZERO, Vec3::ONE))
        };
        let luminance: Vec<f32> = opponent.iter().map(|v| (v.x + 16.0) / 116.0).collect();
        Self {
            color: (0..opponent.len()).map(color).collect(),
            edge: filters.magnitude(&luminance, image.width, &filters.edge),
            point: filters.magnitude(&luminance, image.width, &filters.point),
        }
    }
}

/// Separable kernels for a viewing distance.
struct Filters {
    /// For each opponent channel, the kernels whose squares add up to its contrast sensitivity.
    contrast: [Vec<Vec<f32>>; 3],
    /// The Gaussian that smooths across a feature's direction.
    smooth: Vec<f32>,
    /// Its first derivative.
    edge: Vec<f32>,
    /// Its second derivative.
    point: Vec<f32>,
}

impl Filters {
    fn new(pixels_per_degree: f64) -> Self {
        // (a, b) of the terms a sqrt(pi / b) exp(-pi^2 x^2 / b), x in degrees, of each channel (table 1 of the paper).
        let terms: [&[(f64, f64)]; 3] = [&[(1.0, 0.0047)], &[(1.0, 0.0053)], &[(34.1, 0.04), (13.5, 0.025)]];
        let radius = (3.0 * (0.04 / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i32;
        let deviation = 0.5 * FEATURE_DEGREES * pixels_per_degree;
        let reach = (3.0 * deviation).ceil() as i32;
        let gaussian = |x: f64| (-x * x / (2.0 * deviation * deviation)).exp();
        Self {
            contrast: terms.map(|terms| contrast_kernels(terms, radius, pixels_per_degree)),
            smooth: signed_unit(reach, gaussian),
            edge: signed_unit(reach, |x| -x * gaussian(x)),
            point: signed_unit(reach, |x| (x * x / (deviation * deviation) - 1.0) * gaussian(x)),
        }
    }

    fn contrast(&self, values: &[f32], width: usize, channel: usize) -> Vec<f32> {
        let plane = Plane { values, width };
        let terms = self.contrast[channel].iter().map(|kernel| convolve(plane, kernel, kernel));
        terms.reduce(|sum, term| sum.iter().zip(term).map(|(a, b)| a + b).collect()).unwrap_or_default()
    }

    /// The length of the gradient that `derivative` along x and along y makes.
    fn magnitude(&self, values: &[f32], width: usize, derivative: &[f32]) -> Vec<f32> {
        let plane = Plane { values, width };
        let along_x = convolve(plane, derivative, &self.smooth);
        let along_y = convolve(plane, &self.smooth, derivative);
        along_x.iter().zip(along_y).map(|(x, y)| x.hypot(y)).collect()
    }
}

/// One kernel for each Gaussian term; applied along x and y and summed, they have weight 1.
fn contrast_kernels(terms: &[(f64, f64)], radius: i32, pixels_per_degree: f64) -> Vec<Vec<f32>> {
    let kernel = |&(a, b): &(f64, f64)| -> Vec<f64> {
        let scale = (a * (PI / b).sqrt()).sqrt();
        let degrees = |x: i32| f64::from(x) / pixels_per_degree;
        (-radius..=radius).map(|x| scale * (-(PI * degrees(x)).powi(2) / b).exp()).collect()
    };
    let kernels: Vec<Vec<f64>> = terms.iter().map(kernel).collect();
    let total: f64 = kernels.iter().map(|kernel| kernel.iter().sum::<f64>().powi(2)).sum();
    let unit = |kernel: Vec<f64>| kernel.iter().map(|v| (v / total.sqrt()) as f32).collect();
    kernels.into_iter().map(unit).collect()
}

/// The kernel of `weight`, its positive weights scaled to a sum of 1 and its negative ones to -1.
fn signed_unit(reach: i32, weight: impl Fn(f64) -> f64) -> Vec<f32> {
    let weights: Vec<f64> = (-reach..=reach).map(|x| weight(f64::from(x))).collect();
    let positive: f64 = weights.iter().filter(|v| **v > 0.0).sum();
    let negative: f64 = weights.iter().filter(|v| **v < 0.0).sum();
    weights
        .iter()
        .map(|&v| (if v > 0.0 { v / positive } else { v / negative.abs().max(f64::MIN_POSITIVE) }) as f32)
        .collect()
}

#[cfg(test)]
mod tests;
