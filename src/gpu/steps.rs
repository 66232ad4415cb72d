//! The steps of a repeated pass: how many repetitions go into a submission, from how long those before took.

use std::ops::{ControlFlow, Range};

use super::work::Repeat;

/// Parts of the picture differ in cost, so the costliest repetition lately counts: this much of it after every step.
const FORGETTING: f64 = 0.97;
/// Most repetitions of a step in the first round.
const FIRST_ROUND_BATCH: u32 = 2;
/// Part of the longest submission that a step aims at, so that few exceed it.
const AIM: f64 = 0.75;

/// How far a repeated pass has come.
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
}

impl Steps {
    /// Steps that take about `max_submit_ms` at most; with 0 each is one repetition.
    pub fn new(repeat: Repeat, max_submit_ms: f64) -> Self {
        let (repetition_ms, longest_ms) = (0.0, 0.0);
        Self { repeat, max_submit_ms, done: 0, end: repeat.count(), batch: 1, repetition_ms, longest_ms, count: 0 }
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
            // The costly parts may still come.
            self.batch = self.batch.min(FIRST_ROUND_BATCH);
        }
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
    fn a_stop_finishes_the_round() {
        let repeat = Repeat { rounds: 5, parts: 3 };
        assert_eq!(run(repeat, 0.0, 4), ((0..6).map(|i| i..i + 1).collect(), 2));
        assert_eq!(run(repeat, 100.0, 2), (vec![0..1, 1..3], 1), "it was at an end");
    }
}
