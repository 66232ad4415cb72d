//! Which passes of a frame go into one submission, so that none takes as long as a watchdog allows: passes go together as
//! long as their times in the last frame stay below the limit.

use std::ops::Range;

/// What is known of a pass before a frame.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PassBefore {
    /// Its time in the last frame; `None` before the first.
    pub ms: Option<f64>,
    /// Has submissions of its own.
    pub is_alone: bool,
    /// Stays in one submission with the pass before it, however long that takes.
    pub goes_with_last: bool,
}

/// Splits passes into runs whose times add up to no more than the limit, where they can; without times, one each.
pub(super) fn batches(passes: &[PassBefore], limit_ms: f64) -> Vec<Range<usize>> {
    let mut batches: Vec<Range<usize>> = Vec::new();
    let mut sum_ms = 0.0;
    for (index, pass) in passes.iter().enumerate() {
        let ms = pass.ms.unwrap_or(f64::INFINITY);
        let fits = !pass.is_alone && !passes[index.saturating_sub(1)].is_alone && sum_ms + ms <= limit_ms;
        match batches.last_mut() {
            Some(batch) if fits || pass.goes_with_last => {
                batch.end = index + 1;
                sum_ms += ms;
            }
            _ => {
                batches.push(index..index + 1);
                sum_ms = ms;
            }
        }
    }
    if batches.is_empty() {
        batches.push(0..0);
    }
    batches
}

#[cfg(test)]
mod tests {
    use super::*;

    fn timed(ms: &[f64]) -> Vec<PassBefore> {
        ms.iter().map(|ms| PassBefore { ms: Some(*ms), ..PassBefore::default() }).collect()
    }

    /// The same with all that follow `from` in its submission.
    fn together(mut passes: Vec<PassBefore>, from: usize) -> Vec<PassBefore> {
        passes[from + 1..].iter_mut().for_each(|pass| pass.goes_with_last = true);
        passes
    }

    #[test]
    fn passes_go_together_up_to_the_limit() {
        let passes = timed(&[1.0, 2.0, 3.0, 4.0]);
        assert_eq!(batches(&passes, 6.0), [0..3, 3..4]);
        assert_eq!(batches(&passes, 100.0), std::slice::from_ref(&(0..4)));
        assert_eq!(batches(&timed(&[1.0, 9.0, 1.0, 1.0]), 6.0), [0..1, 1..2, 2..4], "a long pass is alone");
    }

    #[test]
    fn passes_in_the_window_stay_together() {
        assert_eq!(batches(&together(timed(&[9.0, 9.0, 1.0, 9.0]), 1), 6.0), [0..1, 1..4]);
        assert_eq!(batches(&together(vec![PassBefore::default(); 4], 2), 6.0), [0..1, 1..2, 2..4]);
        let short = together(timed(&[1.0, 1.0, 1.0, 9.0]), 2);
        assert_eq!(batches(&short, 6.0), std::slice::from_ref(&(0..4)));
    }

    #[test]
    fn without_times_every_pass_is_alone_where_there_is_a_limit() {
        let unknown = vec![PassBefore::default(); 3];
        assert_eq!(batches(&unknown, 100.0), [0..1, 1..2, 2..3]);
        assert_eq!(batches(&unknown, f64::INFINITY), std::slice::from_ref(&(0..3)));
    }

    #[test]
    fn a_pass_in_steps_is_alone() {
        let mut passes = timed(&[1.0, 1.0, 1.0, 1.0, 1.0]);
        passes[2].is_alone = true;
        assert_eq!(batches(&passes, f64::INFINITY), [0..2, 2..3, 3..5]);
    }

    #[test]
    fn a_frame_without_passes_is_one_submission() {
        assert_eq!(batches(&[], 1.0), std::slice::from_ref(&(0..0)));
    }
}
