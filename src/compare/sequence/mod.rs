//! How a sequence of pictures moves beside the true one: flicker, lag, and how soon it answers to a step.
//!
//! Everything is measured in luma as shown, with one exposure for all frames. P is the truth, T the test, E = T - P. A noisy
//! truth can be given twice, with independent noise: every product below then takes its factors from different truths, so
//! that their noise cancels on average instead of adding up. Pixels are compared where they are, so a still camera is assumed.

mod change;
pub mod limits;
mod measures;
pub mod table;

use serde::Serialize;

pub use limits::SequenceLimits;

use super::image::Image;
use super::metrics::{ImageMetrics, compare_images};
use super::ssim::luma;
use super::tone::{Tone, tone_map};
use crate::{Error, Result};
use change::consecutive;
use measures::{answer, flicker, lag_frames};

/// Luma of a frame as shown.
pub(super) struct ShownFrame {
    /// Its number in the sequence.
    pub frame: u32,
    pub width: usize,
    truth: Vec<f32>,
    /// Another truth with other noise; empty where there is none.
    second_truth: Vec<f32>,
    pub test: Vec<f32>,
    /// Which pixels are finite in all of them.
    pub counts: Vec<bool>,
}

impl ShownFrame {
    /// The two truths, or the same twice.
    pub fn truths(&self) -> [&[f32]; 2] {
        [&self.truth, if self.second_truth.is_empty() { &self.truth } else { &self.second_truth }]
    }
}

/// What is found of a sequence. `None` (`null`) is what is undefined: a change where no frame of the truth follows another,
/// anything relative to a black truth.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SequenceMetrics {
    /// Width of all pictures.
    pub width_px: usize,
    /// Height of all pictures.
    pub height_px: usize,
    /// Factor on the radiance before tone mapping; `None` for display-ready pictures.
    pub exposure: Option<f64>,
    /// Mean luma of the truth, 0 to 1.
    pub mean_luma: f64,
    /// Frames whose predecessor is there as well.
    pub pairs: usize,
    /// RMS over pixels of E_t - E_{t-1}, over the mean luma.
    pub flicker: Option<f64>,
    /// The same of the means of 16x16 blocks: noise that the eye cannot average away. `None` below 16x16 pixels.
    pub block_flicker: Option<f64>,
    /// How many frames the test is behind: Σ E_t (P_{t-1} - P_t) / Σ (P_{t-1} - P_t)². `None` where the truth stands still.
    pub lag_frames: Option<f64>,
    /// How the test answers to a step of the truth; `None` without one.
    pub answer: Option<Answer>,
    /// Mean of the frames' relMSE.
    pub relmse: Option<f64>,
    /// Mean of the frames' FLIP.
    pub flip: f64,
    /// Mean of all frames of the test over that of the truth.
    pub energy_ratio: Option<f64>,
    /// Pixels of the truth with a NaN or an infinity, in all frames.
    pub nonfinite_truth_pixels: usize,
    /// Pixels of the test with a NaN or an infinity, in all frames.
    pub nonfinite_test_pixels: usize,
    /// Each frame by itself.
    pub frames: Vec<FrameMetrics>,
}

/// The answer to the largest step of the truth.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Answer {
    /// The first frame after the step.
    pub frame: u32,
    /// Frames from the step on until no more than a tenth of it is left, and stays so; 0 where the frame of the step is
    /// right already, `None` where the sequence ends first.
    pub frames: Option<u32>,
    /// The part of the step that is left in each frame from `frame` on.
    pub left: Vec<f64>,
}

/// What is found of one frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrameMetrics {
    /// Its number.
    pub frame: u32,
    /// [`ImageMetrics::relmse`].
    pub relmse: Option<f64>,
    /// [`ImageMetrics::flip`].
    pub flip: f64,
    /// [`ImageMetrics::energy_ratio`].
    pub energy_ratio: Option<f64>,
    /// [`SequenceMetrics::flicker`] of this frame and the one before; `None` where that is not there.
    pub flicker: Option<f64>,
    /// [`SequenceMetrics::block_flicker`] of the same two.
    pub block_flicker: Option<f64>,
}

/// Takes the frames of a sequence in their order, and measures them.
pub struct SequenceMeter {
    tone: Tone,
    frames: Vec<ShownFrame>,
    pictures: Vec<ImageMetrics>,
}

impl SequenceMeter {
    /// For frames that are shown with this tone.
    #[must_use]
    pub fn new(tone: Tone) -> Self {
        Self { tone, frames: Vec::new(), pictures: Vec::new() }
    }

    /// Adds a frame: its truth, perhaps another one with other noise, and the test. Returns what is found of it alone, where
    /// the truth is the mean of both.
    ///
    /// # Errors
    /// [`Error::Usage`] when sizes differ, from those of other frames too, or frames are not in order;
    /// [`Error::Failure`] when no pixel is finite in all pictures.
    pub fn add(
        &mut self,
        frame: u32,
        truth: &Image,
        second_truth: Option<&Image>,
        test: &Image,
    ) -> Result<&ImageMetrics> {
        self.check(frame, truth, second_truth)?;
        let mean = second_truth.map(|second| mean_of(truth, second));
        let metrics = compare_images(mean.as_ref().unwrap_or(truth), test, self.tone, None)?.metrics;
        let shown = |image: &Image| -> Vec<f32> {
            luma(&tone_map(image, self.tone)).into_iter().map(|value| value as f32).collect()
        };
        let all = [Some(truth), second_truth, Some(test)];
        let counts = (0..truth.pixels().len())
            .map(|i| all.iter().flatten().all(|image| image.pixels()[i].iter().all(|value| value.is_finite())));
        self.frames.push(ShownFrame {
            frame,
            width: truth.width,
            truth: shown(truth),
            second_truth: second_truth.map(shown).unwrap_or_default(),
            test: shown(test),
            counts: counts.collect(),
        });
        self.pictures.push(metrics);
        Ok(&self.pictures[self.pictures.len() - 1])
    }

    fn check(&self, frame: u32, truth: &Image, second_truth: Option<&Image>) -> Result<()> {
        let size = |image: &ImageMetrics| (image.width_px, image.height_px);
        let sizes = [self.pictures.first().map(size), second_truth.map(Image::size)];
        if let Some((width, height)) = sizes.into_iter().flatten().find(|size| *size != truth.size()) {
            let (a, b) = truth.size();
            return Err(Error::Usage(format!("the pictures' sizes differ: {a}x{b} and {width}x{height}")));
        }
        match self.frames.last() {
            Some(last) if last.frame >= frame => {
                Err(Error::Usage(format!("the frame {frame} does not follow the frame {}", last.frame)))
            }
            _ => Ok(()),
        }
    }

    /// Everything that is found.
    ///
    /// # Errors
    /// [`Error::Failure`] without a frame.
    pub fn finish(self) -> Result<SequenceMetrics> {
        let Some(first) = self.pictures.first() else {
            return Err(Error::Failure("a sequence without frames cannot be measured".to_owned()));
        };
        let mean_luma = mean_luma(&self.frames);
        let relative = |value: Option<f64>| value.filter(|_| mean_luma > 0.0).map(|value| value / mean_luma);
        let pairs: Vec<_> = consecutive(&self.frames).collect();
        let of_frame = |frame: &ShownFrame, side: usize| {
            let pair: Vec<_> = pairs.iter().filter(|(_, now)| now.frame == frame.frame).copied().collect();
            relative(flicker(&pair, side))
        };
        let count = self.pictures.len() as f64;
        let sum = |value: fn(&ImageMetrics) -> f64| self.pictures.iter().map(value).sum::<f64>();
        let relmse: Option<f64> = self.pictures.iter().map(|picture| picture.relmse).sum();
        let (truth, test) = (sum(|picture| picture.reference_mean), sum(|picture| picture.test_mean));
        let frame = |(shown, picture): (&ShownFrame, &ImageMetrics)| FrameMetrics {
            frame: shown.frame,
            relmse: picture.relmse,
            flip: picture.flip,
            energy_ratio: picture.energy_ratio,
            flicker: of_frame(shown, 1),
            block_flicker: of_frame(shown, measures::BLOCK_PX),
        };
        Ok(SequenceMetrics {
            width_px: first.width_px,
            height_px: first.height_px,
            exposure: first.exposure,
            mean_luma,
            pairs: pairs.len(),
            flicker: relative(flicker(&pairs, 1)),
            block_flicker: relative(flicker(&pairs, measures::BLOCK_PX)),
            lag_frames: lag_frames(&pairs, mean_luma),
            answer: answer(&self.frames, mean_luma),
            relmse: relmse.map(|sum| sum / count),
            flip: sum(|picture| picture.flip) / count,
            energy_ratio: (truth > 0.0).then(|| test / truth),
            nonfinite_truth_pixels: self.pictures.iter().map(|picture| picture.nonfinite_reference_pixels).sum(),
            nonfinite_test_pixels: self.pictures.iter().map(|picture| picture.nonfinite_test_pixels).sum(),
            frames: self.frames.iter().zip(&self.pictures).map(frame).collect(),
        })
    }
}

fn mean_of(a: &Image, b: &Image) -> Image {
    let rgb = a.rgb.iter().zip(&b.rgb).map(|(a, b)| 0.5 * (a + b)).collect();
    Image { rgb, ..a.clone() }
}

/// Of the truth.
fn mean_luma(frames: &[ShownFrame]) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for frame in frames {
        for (i, _) in frame.counts.iter().enumerate().filter(|(_, counts)| **counts) {
            sum += frame.truths().iter().map(|truth| f64::from(truth[i])).sum::<f64>();
            count += 2.0;
        }
    }
    if count > 0.0 { sum / count } else { 0.0 }
}

#[cfg(test)]
mod tests;
