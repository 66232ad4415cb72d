//! Limits on the measures of sequences, and sentences about those exceeded.

use serde::Serialize;

use super::SequenceMetrics;
use crate::compare::limits::{ImageLimits, not_finite};
use crate::compare::table::number;

/// What a sequence must keep to. Every limit is finite and at least 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct SequenceLimits {
    /// Most flicker of pixels.
    pub max_flicker: Option<f64>,
    /// Most flicker of blocks.
    pub max_block_flicker: Option<f64>,
    /// Most frames of lag, whether behind or ahead.
    pub max_lag_frames: Option<f64>,
    /// Most frames until a step is answered.
    pub max_answer_frames: Option<f64>,
    /// For every frame.
    #[serde(flatten)]
    pub pictures: ImageLimits,
}

impl SequenceLimits {
    /// Whether there is any limit.
    #[must_use]
    pub fn any(&self) -> bool {
        *self != Self::default()
    }

    /// A clause for each limit on the whole sequence that is exceeded or cannot be checked. With any limit, pixels of the test
    /// that are not finite are a fault themselves. Limits on frames are checked as frames are added: [`FrameFaults`].
    #[must_use]
    pub fn exceeded(&self, metrics: &SequenceMetrics) -> Vec<String> {
        let finite = not_finite(metrics.nonfinite_test_pixels).filter(|_| self.any());
        let limits = [self.flicker(metrics), self.block_flicker(metrics), self.lag(metrics), self.answer(metrics)];
        finite.into_iter().chain(limits.into_iter().flatten()).collect()
    }

    pub(super) fn flicker(&self, metrics: &SequenceMetrics) -> Option<String> {
        over("flicker", metrics.flicker, self.max_flicker, NO_PAIRS)
    }

    pub(super) fn block_flicker(&self, metrics: &SequenceMetrics) -> Option<String> {
        over("block flicker", metrics.block_flicker, self.max_block_flicker, NO_BLOCKS)
    }

    pub(super) fn lag(&self, metrics: &SequenceMetrics) -> Option<String> {
        over("lag", metrics.lag_frames.map(f64::abs), self.max_lag_frames, "the truth does not move")
    }

    pub(super) fn answer(&self, metrics: &SequenceMetrics) -> Option<String> {
        let limit = self.max_answer_frames?;
        let Some(answer) = &metrics.answer else { return Some(undefined("answer", limit, "the truth has no step")) };
        match answer.frames {
            Some(frames) => over("answer", Some(f64::from(frames)), Some(limit), ""),
            None => {
                let left = answer.left.last().map_or(f64::NAN, |left| 100.0 * left);
                let last = u64::from(answer.frame) + answer.left.len() as u64 - 1;
                Some(format!(
                    "the step at frame {} is not answered within {limit} frames: at frame {last} {} % of it are left",
                    answer.frame,
                    number(left)
                ))
            }
        }
    }
}

const NO_PAIRS: &str = "no two frames follow each other or the truth is black";
const NO_BLOCKS: &str =
    "no two frames follow each other, the truth is black or the pictures are smaller than 16x16 pixels";

fn over(name: &str, value: Option<f64>, limit: Option<f64>, why: &str) -> Option<String> {
    let limit = limit?;
    let Some(value) = value else { return Some(undefined(name, limit, why)) };
    let holds = value <= limit;
    (!holds).then(|| format!("{name} {} is over the limit {limit}", number(value)))
}

fn undefined(name: &str, limit: f64, why: &str) -> String {
    format!("{name} is undefined as {why}, and cannot be held to the limit {limit}")
}

/// Limits that single frames exceed, gathered while they are added.
#[derive(Clone, Debug, Default)]
pub struct FrameFaults {
    first: Option<String>,
    frames: usize,
}

impl FrameFaults {
    /// Notes the clauses about a frame.
    pub fn add(&mut self, frame: u32, clauses: &[String]) {
        if clauses.is_empty() {
            return;
        }
        self.first.get_or_insert_with(|| format!("frame {frame}: {}", clauses.join(", ")));
        self.frames += 1;
    }

    /// The first such frame, and how many others there are.
    #[must_use]
    pub fn clause(self) -> Option<String> {
        let others = match self.frames.saturating_sub(1) {
            0 => String::new(),
            1 => " (and 1 other frame)".to_owned(),
            others => format!(" (and {others} other frames)"),
        };
        self.first.map(|first| first + &others)
    }
}
