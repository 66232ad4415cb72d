//! Flicker, lag and answer.

use super::change::{Change, Pair, consecutive, product};
use super::{Answer, ShownFrame};

/// Side of the blocks whose flicker is measured.
pub const BLOCK_PX: usize = 16;
/// A truth whose RMS change is less than this part of its mean luma stands still.
const STANDS_STILL: f64 = 1e-4;
/// So many standard errors must a change stand out of the noise of two truths.
const STANDS_OUT: f64 = 4.0;
/// A step is so many times the median change of the truth.
const STEP_OVER_MEDIAN: f64 = 4.0;
/// A change of the truth by this part of a step ends what can be said about the answer to it.
const NEXT_STEP: f64 = 0.25;
/// The part of a step that may be left in an answer.
const LEFT: f64 = 0.1;

/// RMS of E_t - E_{t-1} of blocks of a side; 1 is pixels. Blocks lie within the picture, and a block's mean is over the pixels
/// that count. `None` without blocks.
pub fn flicker(pairs: &[Pair], side: usize) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0.0);
    for pair in pairs {
        for mean in block_means(*pair, side) {
            sum += mean[0] * mean[1];
            count += 1.0;
        }
    }
    // The noise of two truths may leave less than nothing.
    (count > 0.0).then(|| f64::max(sum / count, 0.0).sqrt())
}

fn block_means(pair: Pair, side: usize) -> Vec<[f64; 2]> {
    let width = pair.0.width;
    let (columns, rows) = (width / side, pair.0.counts.len() / width / side);
    let mut sums = vec![[0.0, 0.0, 0.0]; columns * rows];
    for y in 0..rows * side {
        for x in 0..columns * side {
            let pixel = y * width + x;
            if pair.0.counts[pixel] && pair.1.counts[pixel] {
                let [a, b] = Change::of(pair, pixel).of_error;
                let sum = &mut sums[y / side * columns + x / side];
                *sum = [sum[0] + a, sum[1] + b, sum[2] + 1.0];
            }
        }
    }
    sums.into_iter().filter(|sum| sum[2] > 0.0).map(|[a, b, count]| [a / count, b / count]).collect()
}

/// How the truth changes.
#[derive(Default)]
struct TruthChange {
    squares: f64,
    fourth_powers: f64,
    pixels: f64,
    has_noise: bool,
}

impl TruthChange {
    fn add(&mut self, pixel: &Change) {
        let square = product(pixel.back, pixel.back);
        self.squares += square;
        self.fourth_powers += square * square;
        self.pixels += 1.0;
        self.has_noise |= pixel.back[0] != pixel.back[1];
    }

    /// The mean square, or `None` where the truth stands still as far as its noise tells.
    fn mean_square(&self, mean_luma: f64) -> Option<f64> {
        let moves = self.squares > (STANDS_STILL * mean_luma).powi(2) * self.pixels;
        let stands_out = !self.has_noise || self.squares > STANDS_OUT * self.fourth_powers.sqrt();
        (moves && stands_out).then(|| self.squares / self.pixels)
    }
}

/// How many frames the test is behind, by the regression of its error on how the truth was a frame ago. `None` where the
/// truth stands still.
pub fn lag_frames(pairs: &[Pair], mean_luma: f64) -> Option<f64> {
    let (mut behind, mut change) = (0.0, TruthChange::default());
    for pixel in pairs.iter().flat_map(|pair| Change::of_all(*pair)) {
        behind += product(pixel.error, pixel.back);
        change.add(&pixel);
    }
    change.mean_square(mean_luma).map(|mean| behind / change.pixels / mean)
}

/// RMS change of the truth from a frame to the next.
fn change_of_truth(pair: Pair, mean_luma: f64) -> f64 {
    let mut change = TruthChange::default();
    Change::of_all(pair).for_each(|pixel| change.add(&pixel));
    change.mean_square(mean_luma).unwrap_or(0.0).sqrt()
}

/// The answer to the largest step: what is left is the part of it that the test has not made yet, by the regression of how
/// the test's error has grown since before the step. So an error that was there before is no part of it.
pub fn answer(frames: &[ShownFrame], mean_luma: f64) -> Option<Answer> {
    let changes: Vec<(Pair, f64)> = consecutive(frames).map(|pair| (pair, change_of_truth(pair, mean_luma))).collect();
    let mut sorted: Vec<f64> = changes.iter().map(|(_, change)| *change).collect();
    sorted.sort_by(f64::total_cmp);
    let median = *sorted.get(sorted.len().checked_sub(1)? / 2)?;
    let (at, (step, height)) = changes.iter().enumerate().max_by(|(_, a), (_, b)| a.1.total_cmp(&b.1))?;
    if changes.len() < 2 || *height <= STEP_OVER_MEDIAN * median {
        return None;
    }
    let mut left = vec![left_of(*step, step.1)?];
    let mut last = step.1.frame;
    for (pair, change) in &changes[at + 1..] {
        if pair.0.frame != last || *change >= NEXT_STEP * height {
            break;
        }
        left.push(left_of(*step, pair.1)?);
        last = pair.1.frame;
    }
    let is_little = |left: &f64| left.abs() <= LEFT;
    let answered = left.iter().rposition(|left| !is_little(left)).map_or(0, |index| index + 1);
    let frames = (answered < left.len()).then_some(answered as u32);
    Some(Answer { frame: step.1.frame, frames, left })
}

/// The part of a step that is left in a frame after it.
fn left_of(step: Pair, frame: &ShownFrame) -> Option<f64> {
    let (mut sum, mut squares) = (0.0, 0.0);
    for pixel in (0..frame.counts.len()).filter(|pixel| frame.counts[*pixel]) {
        if step.0.counts[pixel] && step.1.counts[pixel] {
            let back = Change::of(step, pixel).back;
            sum += product(Change::of((step.0, frame), pixel).of_error, back);
            squares += product(back, back);
        }
    }
    (squares > 0.0).then(|| sum / squares)
}
