//! The steps of a pass: how many of its repetitions, or of its rows of workgroups, go into a submission, from how long those
//! before took.

use std::ops::{ControlFlow, Range};

use super::work::Repeat;

/// Parts of the picture differ in cost, so the costliest repetition lately counts: this much of it after every step.
const FORGETTING: f64 = 0.97;
/// Most repetitions of a step in the first round.
const FIRST_ROUND_BATCH: u32 = 2;
/// Part of the longest submission that a step aims at, so that few exceed it.
const AIM: f64 = 0.75;

/// How far a pass has come.
#[derive(Debug)]
pub(super) struct Steps {
    repeat: Repeat,
    max_submit_ms: f64,
    /// Repetitions done, and all that will be.
    done: u32,
    end: u32,
    /// Repetitions of the next step.
    batch: u32,
    repetition_ms: f64,
    longest_ms: f64,
    count: u32,
    /// Most repetitions of a step in the first round: the costly parts may still come.
    most_at_first: u32,
}

impl Steps {
    /// Steps that take about `max_submit_ms` at most; with 0 each is one repetition.
    pub fn new(repeat: Repeat, max_submit_ms: f64) -> Self {
        Self {
            repeat,
            max_submit_ms,
            done: 0,
            end: repeat.count(),
            batch: 1,
            repetition_ms: 0.0,
            longest_ms: 0.0,
            count: 0,
            most_at_first: FIRST_ROUND_BATCH,
        }
    }

    /// The same from a later round on; the ones before it have been done in an earlier frame.
    pub fn starting_at(self, round: u32) -> Self {
        let done = (round * self.repeat.parts).min(self.end);
        Self { done, ..self }
    }

    /// Steps through the rows of one dispatch that took `expected_ms` in the frame before, where that is known.
    pub fn of_rows(rows: u32, max_submit_ms: f64, expected_ms: Option<f64>) -> Self {
        let steps = Self::new(Repeat { rounds: 1, parts: rows }, max_submit_ms);
        let batch = expected_ms.map_or(1, |ms| next_batch(rows, ms / f64::from(rows), max_submit_ms));
        Self { batch, most_at_first: u32::MAX, ..steps }
    }

    /// The repetitions to run next; `None` at the end.
    pub fn next(&self) -> Option<Range<u32>> {
        (self.done < self.end).then(|| self.done..(self.done + self.batch).min(self.end))
    }

    /// The repetitions given last took so long. `Break` ends the pass with the round that it is in.
    pub fn took(&mut self, ms: f64, flow: ControlFlow<()>) {
        let Some(range) = self.next() else { return };
        let ran = range.end - range.start;
        self.done = range.end;
        if flow.is_break() {
            self.end = self.end.min(self.done.next_multiple_of(self.repeat.parts));
        }
        (self.longest_ms, self.count) = (self.longest_ms.max(ms), self.count + 1);
        self.repetition_ms = (ms / f64::from(ran)).max(FORGETTING * self.repetition_ms);
        self.batch = next_batch(self.batch, self.repetition_ms, self.max_submit_ms);
        if self.done < self.repeat.parts {
            self.batch = self.batch.min(self.most_at_first);
        }
    }

    /// Whether no step of this frame is done.
    pub fn is_at_start(&self) -> bool {
        self.count == 0
    }

    /// Rounds that are finished.
    pub fn rounds_done(&self) -> u32 {
        self.done / self.repeat.parts
    }

    /// What a log says of them.
    pub fn summary(&self) -> String {
        format!("{} repetitions in {} submissions, the longest {:.1} ms", self.done, self.count, self.longest_ms)
    }
}

/// Repetitions of the step after one of `batch`. Grows slowly: the first steps warm caches.
fn next_batch(batch: u32, repetition_ms: f64, max_submit_ms: f64) -> u32 {
    let fitting = AIM * max_submit_ms / repetition_ms.max(1e-9);
    (fitting as u32).clamp(1, batch.saturating_mul(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_grow_slowly_and_shrink_at_once() {
        assert_eq!(next_batch(1, 1.0, 200.0), 2);
        assert_eq!(next_batch(64, 100.0 / 64.0, 200.0), 96);
        assert_eq!(next_batch(64, 600.0 / 64.0, 200.0), 16);
        assert_eq!(next_batch(1, 900.0, 200.0), 1, "a step is never empty");
        assert_eq!(next_batch(u32::MAX, 0.0, 1.0), 750_000_000, "nothing takes no time at all");
    }

    /// The steps of a pass whose every step takes 1 ms, stopped after so many.
    fn run(repeat: Repeat, max_submit_ms: f64, stop_after: usize) -> (Vec<Range<u32>>, u32) {
        let mut steps = Steps::new(repeat, max_submit_ms);
        let mut ran = Vec::new();
        while let Some(range) = steps.next() {
            ran.push(range);
            steps.took(1.0, if ran.len() == stop_after { ControlFlow::Break(()) } else { ControlFlow::Continue(()) });
        }
        (ran, steps.rounds_done())
    }

    #[test]
    fn every_repetition_runs_once() {
        let repeat = Repeat { rounds: 5, parts: 3 };
        assert_eq!(run(repeat, 100.0, 99), (vec![0..1, 1..3, 3..7, 7..15], 5));
        assert_eq!(run(repeat, 0.0, 99), ((0..15).map(|i| i..i + 1).collect(), 5), "one by one");
    }

    #[test]
    fn rows_begin_with_what_is_known_of_them() {
        let ranges = |expected_ms| {
            let mut steps = Steps::of_rows(10, 4.0, expected_ms);
            let mut ranges = Vec::new();
            while let Some(range) = steps.next() {
                steps.took(f64::from(range.end - range.start), ControlFlow::Continue(()));
                ranges.push(range);
            }
            ranges
        };
        assert_eq!(ranges(None), [0..1, 1..3, 3..6, 6..9, 9..10]);
        assert_eq!(ranges(Some(10.0)), [0..3, 3..6, 6..9, 9..10]);
    }

    #[test]
    fn a_later_frame_goes_on_with_its_round() {
        let steps = Steps::new(Repeat { rounds: 5, parts: 3 }, 0.0).starting_at(2);
        assert_eq!((steps.next(), steps.rounds_done()), (Some(6..7), 2));
    }

    #[test]
    fn a_stop_finishes_the_round() {
        let repeat = Repeat { rounds: 5, parts: 3 };
        assert_eq!(run(repeat, 0.0, 4), ((0..6).map(|i| i..i + 1).collect(), 2));
        assert_eq!(run(repeat, 100.0, 2), (vec![0..1, 1..3], 1), "it was at an end");
    }
}
