//! The measures of how far a picture is from a reference.

use serde::Serialize;

use super::flip::flip_map;
use super::image::Image;
use super::pair::{Pair, counted};
use super::ssim::ssim;
use super::tone::{Tone, tone_map};
use crate::{Error, Result};

/// Side of the blocks that the smooth measures average over.
const BLOCK_PX: usize = 8;
/// Side of the blocks whose brightness is compared: large enough that a spot in one is seen, and noise is not.
const BRIGHT_BLOCK_PX: usize = 20;
/// Blocks of the reference that are darker than this fraction of its mean count as being so bright.
const DARKEST_BLOCK: f64 = 0.01;
/// The part of the reference's mean, squared, that keeps relative errors of black pixels finite.
const RELATIVE_FLOOR: f64 = 0.01;

/// How far a test picture is from a reference. Means are over the pixels that are finite in both.
///
/// Relative measures are `None` (`null`) where the reference is black.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ImageMetrics {
    /// Width of both pictures.
    pub width_px: usize,
    /// Height of both pictures.
    pub height_px: usize,
    /// Pixels of the reference with a NaN or an infinity.
    pub nonfinite_reference_pixels: usize,
    /// Pixels of the test with a NaN or an infinity.
    pub nonfinite_test_pixels: usize,
    /// Factor on the radiance before tone mapping; `None` for display-ready pictures.
    pub exposure: Option<f64>,
    /// Mean of the reference's linear values.
    pub reference_mean: f64,
    /// Mean of the test's linear values.
    pub test_mean: f64,
    /// Mean of (t - r)² / (r² + 0.01 mean(r)²) over pixels and channels.
    pub relmse: Option<f64>,
    /// Root of the mean squared difference of linear values.
    pub rmse: f64,
    /// The test's mean over the reference's.
    pub energy_ratio: Option<f64>,
    /// The same for red, green and blue.
    pub energy_ratio_rgb: [Option<f64>; 3],
    /// Peak signal-to-noise ratio of the display pictures in dB; `None` when they are equal.
    pub psnr_db: Option<f64>,
    /// Structural similarity of the display pictures' luma; `None` below 11x11 pixels.
    pub ssim: Option<f64>,
    /// Mean LDR-FLIP error of the display pictures, 0 to 1.
    pub flip: f64,
    /// [`Self::relmse`] of the averages of 8x8 blocks: hardly sees noise, so it shows bias. `None` below 8x8 pixels.
    pub smooth_relmse: Option<f64>,
    /// The largest ratio of the test's mean over a 20x20 block to the reference's there, the latter at least a hundredth of
    /// the reference's mean. `None` below 20x20 pixels.
    pub highest_block_ratio: Option<f64>,
    /// Where only indirect light arrives; `None` without a reference of the direct light.
    #[serde(flatten)]
    pub indirect: Option<IndirectMetrics>,
}

/// Measures over the pixels that direct light does not reach and that are not black in the reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct IndirectMetrics {
    /// The test's mean over the reference's; `None` when there are no such pixels.
    pub indirect_ratio: Option<f64>,
    /// [`ImageMetrics::smooth_relmse`] over the blocks that lie wholly there; `None` when there are none.
    pub indirect_smooth_relmse: Option<f64>,
    /// Number of such pixels.
    pub indirect_pixels: usize,
}

/// The measures, and where FLIP sees a difference.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// The measures.
    pub metrics: ImageMetrics,
    /// The FLIP error of each pixel, 0 to 1, row by row; 0 where a picture is not finite.
    pub flip_map: Vec<f32>,
}

/// Measures how far `test` is from `reference`, shown with `tone`; `direct` is the reference's direct light alone.
///
/// # Errors
/// [`Error::Usage`] when sizes differ, [`Error::Failure`] when no pixel is finite in both pictures.
pub fn metrics(reference: &Image, test: &Image, tone: Tone, direct: Option<&Image>) -> Result<ImageMetrics> {
    Ok(compare_images(reference, test, tone, direct)?.metrics)
}

/// [`metrics`] together with the FLIP map.
///
/// # Errors
/// Those of [`metrics`].
pub fn compare_images(reference: &Image, test: &Image, tone: Tone, direct: Option<&Image>) -> Result<Comparison> {
    if let Some(direct) = direct.filter(|direct| direct.size() != reference.size()) {
        let ((a, b), (c, d)) = (reference.size(), direct.size());
        return Err(Error::Usage(format!("the sizes of picture and direct light differ: {a}x{b} and {c}x{d}")));
    }
    let pair = Pair::new(reference, test)?;
    let (shown_reference, shown_test) = (tone_map(&pair.reference, tone), tone_map(&pair.test, tone));
    let flip_map = flip_map(&shown_reference, &shown_test);
    let energy = Energy::of(&pair);
    let blocks = blocks(&pair, &pair.counts, BLOCK_PX);
    let metrics = ImageMetrics {
        width_px: reference.width,
        height_px: reference.height,
        nonfinite_reference_pixels: pair.nonfinite_reference,
        nonfinite_test_pixels: pair.nonfinite_test,
        exposure: tone.exposure(),
        reference_mean: energy.reference_mean(),
        test_mean: energy.test_mean(),
        relmse: relative_mse(pair.values(), energy.reference_mean()),
        rmse: mse(pair.values()).sqrt(),
        energy_ratio: ratio(energy.test_mean(), energy.reference_mean()),
        energy_ratio_rgb: std::array::from_fn(|c| ratio(energy.test[c], energy.reference[c])),
        psnr_db: psnr_db(mse(counted(&shown_reference, &shown_test, &pair.counts))),
        ssim: ssim(&shown_reference, &shown_test, &pair.counts),
        flip: mean_where(&flip_map, &pair.counts),
        smooth_relmse: relative_mse(blocks.iter().copied(), energy.reference_mean()),
        highest_block_ratio: highest_block_ratio(&pair, energy.reference_mean()),
        indirect: direct.map(|direct| indirect(&pair, direct)),
    };
    Ok(Comparison { metrics, flip_map })
}

/// Means of each channel.
struct Energy {
    reference: [f64; 3],
    test: [f64; 3],
}

impl Energy {
    fn of(pair: &Pair) -> Self {
        let (reference, test) = mean(pair.values()).unwrap_or_default();
        Self { reference, test }
    }

    fn reference_mean(&self) -> f64 {
        average(self.reference)
    }

    fn test_mean(&self) -> f64 {
        average(self.test)
    }
}

type Values = ([f64; 3], [f64; 3]);

/// The channels' means of reference and test; `None` of nothing.
fn mean(values: impl Iterator<Item = Values>) -> Option<Values> {
    let (mut sums, mut count) = (Values::default(), 0.0);
    for (r, t) in values {
        for c in 0..3 {
            sums.0[c] += r[c];
            sums.1[c] += t[c];
        }
        count += 1.0;
    }
    (count > 0.0).then(|| (sums.0.map(|sum| sum / count), sums.1.map(|sum| sum / count)))
}

fn mse(values: impl Iterator<Item = Values>) -> f64 {
    mean_of(values, |r, t| (t - r).powi(2)).unwrap_or(0.0)
}

/// `None` of nothing, and against black.
fn relative_mse(values: impl Iterator<Item = Values>, reference_mean: f64) -> Option<f64> {
    let floor = RELATIVE_FLOOR * reference_mean * reference_mean;
    (reference_mean > 0.0).then(|| mean_of(values, |r, t| (t - r).powi(2) / (r * r + floor)))?
}

/// The mean of `error` over pixels and channels; `None` of nothing.
fn mean_of(values: impl Iterator<Item = Values>, error: impl Fn(f64, f64) -> f64) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0.0);
    for (r, t) in values {
        sum += (0..3).map(|c| error(r[c], t[c])).sum::<f64>();
        count += 3.0;
    }
    (count > 0.0).then(|| sum / count)
}

fn ratio(test: f64, reference: f64) -> Option<f64> {
    (reference > 0.0).then(|| test / reference)
}

fn psnr_db(mse: f64) -> Option<f64> {
    (mse > 0.0).then(|| -10.0 * mse.log10())
}

fn mean_where(values: &[f32], counts: &[bool]) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for (value, _) in values.iter().zip(counts).filter(|(_, counts)| **counts) {
        sum += f64::from(*value);
        count += 1.0;
    }
    sum / count
}

/// `None` without blocks, and against black.
fn highest_block_ratio(pair: &Pair, reference_mean: f64) -> Option<f64> {
    let blocks = blocks(pair, &pair.counts, BRIGHT_BLOCK_PX);
    let ratio = |(r, t): Values| average(t) / average(r).max(DARKEST_BLOCK * reference_mean);
    (reference_mean > 0.0).then(|| blocks.into_iter().map(ratio).reduce(f64::max))?
}

fn average(rgb: [f64; 3]) -> f64 {
    rgb.iter().sum::<f64>() / 3.0
}

/// The means of the blocks of a side that lie within the pictures, over their pixels that count; blocks with none are left
/// out, and so are those where not every countable pixel is `wanted`.
fn blocks(pair: &Pair, wanted: &[bool], side: usize) -> Vec<Values> {
    let (width, height) = pair.reference.size();
    let (reference, test) = (pair.reference.pixels(), pair.test.pixels());
    let mut means = Vec::new();
    for top in (0..height / side).map(|block| block * side) {
        for left in (0..width / side).map(|block| block * side) {
            let pixels = (top..top + side).flat_map(|y| (left..left + side).map(move |x| y * width + x));
            let counting = pixels.filter(|&i| pair.counts[i]);
            if counting.clone().all(|i| wanted[i]) {
                means.extend(mean(counting.map(|i| (reference[i].map(f64::from), test[i].map(f64::from)))));
            }
        }
    }
    means
}

fn indirect(pair: &Pair, direct: &Image) -> IndirectMetrics {
    let unlit = |(i, direct): (usize, &[f32; 3])| {
        let seen = pair.reference.pixels()[i].iter().sum::<f32>() > 0.0;
        pair.counts[i] && seen && direct.iter().all(|v| *v <= 0.0)
    };
    let unlit: Vec<bool> = direct.pixels().iter().enumerate().map(unlit).collect();
    let means = mean(counted(&pair.reference, &pair.test, &unlit));
    let blocks = blocks(pair, &unlit, BLOCK_PX);
    let block_mean = mean(blocks.iter().copied()).map_or(0.0, |(reference, _)| average(reference));
    IndirectMetrics {
        indirect_ratio: means.and_then(|(reference, test)| ratio(average(test), average(reference))),
        indirect_smooth_relmse: relative_mse(blocks.into_iter(), block_mean),
        indirect_pixels: unlit.iter().filter(|unlit| **unlit).count(),
    }
}

#[cfg(test)]
mod tests;
