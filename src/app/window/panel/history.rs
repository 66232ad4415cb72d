//! Times of the last frames.

use std::collections::VecDeque;
use std::time::Instant;

use crate::gpu::FrameResult;

/// Frames that are kept.
pub const KEPT: usize = 120;
/// Frames that a mean is of.
const MEAN_OF: usize = 10;

/// Times of the last frames, oldest first.
#[derive(Default)]
pub struct History {
    frames: VecDeque<FrameResult>,
    /// When the last frames were seen to be done.
    seen: VecDeque<Instant>,
}

impl History {
    /// Takes note of a frame.
    pub fn add(&mut self, times: FrameResult) {
        if self.frames.len() == KEPT {
            self.frames.pop_front();
        }
        self.frames.push_back(times);
        if self.seen.len() > MEAN_OF {
            self.seen.pop_front();
        }
        self.seen.push_back(Instant::now());
    }

    /// The frame has other passes from now on.
    pub fn forget(&mut self) {
        self.frames.clear();
    }

    /// The frames, oldest first.
    pub fn frames(&self) -> impl ExactSizeIterator<Item = &FrameResult> {
        self.frames.iter()
    }

    /// Frames per second on the wall clock, of the last few.
    pub fn frames_per_second(&self) -> f64 {
        match (self.seen.front(), self.seen.back()) {
            (Some(first), Some(last)) if last > first => {
                (self.seen.len() - 1) as f64 / last.duration_since(*first).as_secs_f64()
            }
            _ => 0.0,
        }
    }

    /// Mean milliseconds of each pass in the last few frames.
    pub fn mean_ms(&self) -> Vec<f64> {
        let last: Vec<_> = self.frames.iter().rev().take(MEAN_OF).collect();
        let passes = last.first().map_or(0, |frame| frame.pass_ms.len());
        let mean = |pass: usize| last.iter().map(|f| f.pass_ms[pass]).sum::<f64>() / last.len() as f64;
        (0..passes).map(mean).collect()
    }
}
