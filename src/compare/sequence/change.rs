//! What changes from a frame to the next.

use super::ShownFrame;

/// A frame and the one after it.
pub type Pair<'a> = (&'a ShownFrame, &'a ShownFrame);

/// Frames whose numbers follow each other.
pub fn consecutive(frames: &[ShownFrame]) -> impl Iterator<Item = Pair<'_>> {
    let pairs = frames.windows(2).map(|pair| (&pair[0], &pair[1]));
    pairs.filter(|(before, now)| before.frame + 1 == now.frame)
}

/// What is known of a pixel, by each of the two truths.
#[derive(Clone, Copy, Debug, Default)]
pub struct Change {
    /// E_t - E_{t-1}.
    pub of_error: [f64; 2],
    /// P_{t-1} - P_t.
    pub back: [f64; 2],
    /// E_t.
    pub error: [f64; 2],
}

impl Change {
    /// Of a pixel from frame `before` to frame `now`.
    pub fn of((before, now): Pair, pixel: usize) -> Self {
        let truth = |frame: &ShownFrame| frame.truths().map(|truth| f64::from(truth[pixel]));
        let error = |frame: &ShownFrame| truth(frame).map(|truth| f64::from(frame.test[pixel]) - truth);
        let (e, before_e, p, before_p) = (error(now), error(before), truth(now), truth(before));
        Self {
            of_error: std::array::from_fn(|half| e[half] - before_e[half]),
            back: std::array::from_fn(|half| before_p[half] - p[half]),
            error: e,
        }
    }

    /// Each pixel that counts in both frames.
    pub fn of_all(pair: Pair) -> impl Iterator<Item = Self> {
        let counts = pair.0.counts.iter().zip(&pair.1.counts).map(|(before, now)| *before && *now);
        counts.enumerate().filter(|(_, counts)| *counts).map(move |(pixel, _)| Self::of(pair, pixel))
    }
}

/// The mean of `a` from one truth times `b` from the other, of both ways.
pub fn product(a: [f64; 2], b: [f64; 2]) -> f64 {
    0.5 * (a[0] * b[1] + a[1] * b[0])
}
