//! Frames with repeated passes, submitted in steps: for references that take seconds to hours. Every step is waited
//! for, so that it can be timed, shown and followed by a stop; the frames of the window never come here.

use std::ops::ControlFlow;
use std::time::Instant;

use super::check;
use super::executor::{Executor, FrameResult};
use super::recorder;
use super::work::{ComputeWork, Repeat, Work};
use crate::error::Result;

/// Parts of the picture differ in cost, so the costliest repetition lately counts: this much of it after every step.
const FORGETTING: f64 = 0.97;
/// Most repetitions of a step in the first round.
const FIRST_ROUND_BATCH: u32 = 2;
/// Part of the longest submission that a step aims at, so that few exceed it.
const AIM: f64 = 0.75;

/// What became of a frame in steps.
#[derive(Clone, Debug, PartialEq)]
pub struct SteppedFrame {
    /// Times of the passes; a repeated one includes the gaps between its steps.
    pub times: FrameResult,
    /// Rounds of the repeated pass that were finished.
    pub rounds_done: u32,
    /// Rounds it has in all; 0 when no pass repeats.
    pub rounds: u32,
}

/// Called after every step with the repetitions done and all of them; `Break` ends the pass with its round.
pub type OnStep<'a> = dyn FnMut(u32, u32) -> ControlFlow<()> + 'a;

impl Executor {
    /// Runs one frame and waits for it, in submissions of about `max_submit_ms` at most where passes repeat.
    ///
    /// # Errors
    /// When the device is lost; names the last pass reached.
    pub fn run_in_steps(
        &mut self,
        frame_data: &[u8],
        max_submit_ms: f64,
        on_step: &mut OnStep,
    ) -> Result<SteppedFrame> {
        if self.split_submits {
            let ticket = self.submit(frame_data)?;
            return Ok(SteppedFrame { times: self.wait(ticket)?, rounds_done: 0, rounds: 0 });
        }
        let slot = self.submitted as usize % self.slots.len();
        self.wait_value(self.slots[slot].busy_until)?;
        let stamp = self.submitted as u32 + 1;
        let result = self.run_passes(slot, stamp, frame_data, max_submit_ms, on_step);
        self.explain(slot, u64::from(stamp), result)
    }

    fn run_passes(
        &mut self,
        slot: usize,
        stamp: u32,
        frame_data: &[u8],
        max_submit_ms: f64,
        on_step: &mut OnStep,
    ) -> Result<SteppedFrame> {
        let start = Instant::now();
        let commands = self.slots[slot].commands;
        let (mut rounds_done, mut rounds) = (0, 0);
        self.begin_commands(commands)?;
        self.slots[slot].timers.begin(commands);
        for index in 0..self.frame.passes.len() {
            self.slots[slot].markers.reach(commands, index, stamp);
            if let Some(repeat) = self.repeat_of(index) {
                self.submit_step(slot)?;
                self.begin_commands(commands)?;
                rounds_done += self.run_repetitions(slot, index, repeat, max_submit_ms, on_step)?;
                rounds += repeat.rounds;
            } else {
                recorder::record_pass(&self.frame, commands, index, frame_data);
            }
            self.slots[slot].timers.after_pass(commands, index);
        }
        self.submit_step(slot)?;
        let pass_ms = self.slots[slot].timers.read_ms()?;
        let times = FrameResult { pass_ms, cpu_ms: start.elapsed().as_secs_f64() * 1e3, readback: Vec::new() };
        Ok(SteppedFrame { times, rounds_done, rounds })
    }

    /// How often the pass repeats, if it does.
    pub(super) fn repeat_of(&self, index: usize) -> Option<Repeat> {
        match self.frame.graph.passes()[index].payload {
            Work::Compute(ComputeWork { repeat, .. }) => repeat,
            _ => None,
        }
    }

    /// Rounds finished. The command buffer is recording before and after.
    fn run_repetitions(
        &mut self,
        slot: usize,
        index: usize,
        repeat: Repeat,
        max_submit_ms: f64,
        on_step: &mut OnStep,
    ) -> Result<u32> {
        let commands = self.slots[slot].commands;
        let (mut done, mut end, mut batch) = (0, repeat.count(), 1);
        let (mut longest_ms, mut steps, mut repetition_ms) = (0.0_f64, 0, 0.0_f64);
        while done < end {
            let next = (done + batch).min(end);
            recorder::record_repetitions(&self.frame, commands, index, done..next);
            let start = Instant::now();
            self.submit_step(slot)?;
            let ms = start.elapsed().as_secs_f64() * 1e3;
            self.begin_commands(commands)?;
            (longest_ms, steps) = (longest_ms.max(ms), steps + 1);
            let ran = next - done;
            done = next;
            if on_step(done, repeat.count()).is_break() {
                end = end.min(done.next_multiple_of(repeat.parts));
            }
            repetition_ms = (ms / f64::from(ran)).max(FORGETTING * repetition_ms);
            batch = next_batch(batch, repetition_ms, max_submit_ms);
            if done < repeat.parts {
                // The costly parts may still come.
                batch = batch.min(FIRST_ROUND_BATCH);
            }
        }
        let name = &self.frame.graph.passes()[index].name;
        log::debug!("{name}: {done} repetitions in {steps} submissions, the longest {longest_ms:.1} ms");
        Ok(done / repeat.parts)
    }

    /// Ends, submits and waits for what has been recorded.
    fn submit_step(&mut self, slot: usize) -> Result<()> {
        // SAFETY: the command buffer is recording, outside a rendering scope.
        check("vkEndCommandBuffer", unsafe { self.gpu.device.end_command_buffer(self.slots[slot].commands) })?;
        let value = self.submitted + 1;
        self.queue(slot, value)?;
        self.wait_value(value)
    }
}

/// Repetitions of the step after one of `batch`. Grows slowly: the first steps warm caches.
fn next_batch(batch: u32, repetition_ms: f64, max_submit_ms: f64) -> u32 {
    let fitting = AIM * max_submit_ms / repetition_ms.max(1e-9);
    (fitting as u32).clamp(1, batch.saturating_mul(2))
}

#[cfg(test)]
mod tests {
    use super::next_batch;

    #[test]
    fn steps_grow_slowly_and_shrink_at_once() {
        assert_eq!(next_batch(1, 1.0, 200.0), 2);
        assert_eq!(next_batch(64, 100.0 / 64.0, 200.0), 96);
        assert_eq!(next_batch(64, 600.0 / 64.0, 200.0), 16);
        assert_eq!(next_batch(1, 900.0, 200.0), 1, "a step is never empty");
        assert_eq!(next_batch(u32::MAX, 0.0, 1.0), 750_000_000, "nothing takes no time at all");
    }
}
