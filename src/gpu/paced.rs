//! Frames that are given to the device piece by piece: each piece is short, so that other work of the queue, such as what a
//! window shows meanwhile, comes soon after it. Nobody waits: the next piece is submitted once the last one is seen to be
//! done. A frame can be abandoned between two pieces.

use std::ops::{ControlFlow, Range};
use std::time::Instant;

use ash::vk;

use super::check;
use super::executor::{Executor, FrameResult, SteppedFrame};
use super::recorder::{self, Begins};
use super::slot::Slot;
use super::steps::Steps;
use super::work::{ComputeWork, Repeat, Work};
use crate::error::Result;

/// A pass of which nothing is known goes in rows when it has at least so many workgroups.
const MANY_GROUPS: u32 = 1024;

/// A frame of which some pieces have been submitted. Give it to [`Executor::advance`] until that has its result, or to
/// [`Executor::abandon`].
#[derive(Debug)]
#[must_use = "a frame that is begun goes on until it is done or abandoned"]
pub struct PacedFrame {
    slot: usize,
    begun: Instant,
    frame_data: Vec<u8>,
    /// Round that a repeated pass begins with.
    first_round: u32,
    /// The pass to go on with.
    next: usize,
    /// How far that pass has come, when it goes in several pieces and has begun.
    steps: Option<Steps>,
    under_way: Option<Piece>,
    /// Of the passes so far.
    pass_ms: Vec<f64>,
    submissions: u32,
    rounds_done: u32,
    rounds: u32,
    /// Whether the end of its last pass is submitted, and what the frame ends with.
    is_ended: bool,
}

/// What one submission has of a frame.
#[derive(Debug)]
struct Piece {
    /// Number of the submission.
    number: u64,
    /// Its passes, or the one of which it has a part.
    passes: Range<usize>,
}

/// What a pass is divided into, when it goes in several pieces.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Division {
    Repetitions(Repeat),
    Rows(u32),
}

impl Division {
    fn count(self) -> u32 {
        match self {
            Self::Repetitions(repeat) => repeat.count(),
            Self::Rows(rows) => rows,
        }
    }
}

impl Executor {
    /// Begins a frame of which nothing is submitted yet. A repeated pass begins with `first_round`: the rounds before it
    /// have been done by the frame before this one, of which this one must be a repetition.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn begin_paced(&mut self, frame_data: &[u8], first_round: u32) -> Result<PacedFrame> {
        let slot = self.take_slot()?;
        self.begin_kept();
        self.slots[slot].stamp.set((self.timeline.last() + 1) as u32);
        let count = self.frame.passes.len();
        Ok(PacedFrame {
            slot,
            begun: Instant::now(),
            frame_data: frame_data.to_vec(),
            first_round,
            next: 0,
            steps: None,
            under_way: None,
            pass_ms: vec![0.0; count],
            submissions: 0,
            rounds_done: 0,
            rounds: 0,
            is_ended: false,
        })
    }

    /// Submits the next piece of a frame if the one before is done, of about `longest_ms` at most; gives the result of the
    /// frame when all are. With `Break` a repeated pass ends with the round that it is in.
    ///
    /// # Errors
    /// When the device is lost; names the last pass reached.
    pub fn advance(
        &mut self,
        frame: &mut PacedFrame,
        longest_ms: f64,
        flow: ControlFlow<()>,
    ) -> Result<Option<SteppedFrame>> {
        if let Some(piece) = &frame.under_way {
            if !self.explain(self.timeline.has_reached(piece.number))? {
                return Ok(None);
            }
            self.finish_piece(frame, flow)?;
        }
        if frame.next == self.frame.passes.len() {
            return self.finish_paced(frame).map(Some);
        }
        let submitted = self.submit_piece(frame, longest_ms);
        self.explain(submitted)?;
        Ok(None)
    }

    /// Ends a frame that is not done. What it leaves is of no use, but for images that graphs share, which it has not
    /// written yet; the next frame has no history.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn abandon(&mut self, mut frame: PacedFrame) -> Result<()> {
        // What is under way has had its barriers, and so has a pass that goes in pieces.
        let submitted = frame.under_way.as_ref().map_or(frame.next, |piece| piece.passes.end);
        let first = submitted.max(frame.next + usize::from(frame.steps.is_some()));
        if !frame.is_ended {
            let commands = self.begin_piece(&frame)?;
            recorder::record_without_work(&self.frame, commands, first);
            let submitted = self.end_piece(&mut frame, commands, first..first);
            self.explain(submitted)?;
        }
        self.note_times(&frame.pass_ms[..frame.next]);
        self.leave_slot(frame.slot);
        self.invalidate_history();
        Ok(())
    }

    fn submit_piece(&self, frame: &mut PacedFrame, longest_ms: f64) -> Result<()> {
        if frame.steps.is_none() {
            frame.steps = self.steps_of(frame, longest_ms);
        }
        let commands = self.begin_piece(frame)?;
        let Slot { timers, markers, stamp, .. } = &self.slots[frame.slot];
        let first = frame.next;
        let passes = match &frame.steps {
            Some(_) => first..first + 1,
            None => self.whole_passes(first, longest_ms),
        };
        timers.begin_piece(commands, &passes);
        for index in passes.clone() {
            let part = frame.steps.as_ref().and_then(Steps::next);
            if part.as_ref().is_none_or(|_| frame.begins()) {
                markers.enter(commands, index, stamp.get());
            }
            let division = self.division(index);
            let is_whole = part.as_ref().is_none_or(|part| division.is_some_and(|all| all.count() == part.end));
            frame.is_ended = is_whole && index + 1 == self.frame.passes.len();
            match (part, division) {
                (Some(part), Some(Division::Repetitions(_))) => {
                    let begins = if frame.begins() { Begins::Yes } else { Begins::No };
                    recorder::record_repetitions(&self.frame, commands, index, part, begins);
                }
                _ if self.is_skipped(index) => recorder::record_kept(&self.frame, commands, index),
                (Some(part), _) => recorder::record_rows(&self.frame, commands, index, part),
                (None, _) => recorder::record_pass(&self.frame, commands, index, &frame.frame_data),
            }
            timers.after_pass(commands, index);
            markers.leave(commands, index, stamp.get());
        }
        self.end_piece(frame, commands, passes)
    }

    /// Passes from `first` on that go together; one that goes in pieces ends them.
    fn whole_passes(&self, first: usize, longest_ms: f64) -> Range<usize> {
        let mut sum_ms = 0.0;
        let fits = |index: &usize| {
            if self.is_skipped(*index) {
                return true;
            }
            sum_ms += self.last_ms.get(*index).copied().unwrap_or(f64::INFINITY);
            sum_ms <= longest_ms && !self.goes_in_pieces(*index, longest_ms)
        };
        let more = (first..self.frame.passes.len()).skip_while(|index| *index == first).take_while(fits).count();
        first..first + 1 + more
    }

    fn division(&self, index: usize) -> Option<Division> {
        match &self.frame.graph.passes()[index].payload {
            Work::Compute(ComputeWork { repeat: Some(repeat), .. }) => Some(Division::Repetitions(*repeat)),
            Work::Compute(work) => work.rows().map(Division::Rows),
            _ => None,
        }
    }

    fn goes_in_pieces(&self, index: usize, longest_ms: f64) -> bool {
        if self.is_skipped(index) {
            return false;
        }
        let is_long = |rows: u32| match (self.last_ms.get(index), &self.frame.graph.passes()[index].payload) {
            (Some(ms), _) => *ms > longest_ms,
            (None, Work::Compute(work)) => rows * work.row_groups() >= MANY_GROUPS,
            (None, _) => false,
        };
        match self.division(index) {
            Some(Division::Repetitions(_)) => true,
            Some(Division::Rows(rows)) => is_long(rows),
            None => false,
        }
    }

    /// The steps of the pass that comes next, when it goes in pieces.
    fn steps_of(&self, frame: &PacedFrame, longest_ms: f64) -> Option<Steps> {
        let index = frame.next;
        let division = self.division(index).filter(|_| self.goes_in_pieces(index, longest_ms))?;
        Some(match division {
            Division::Repetitions(repeat) => Steps::new(repeat, longest_ms).starting_at(frame.first_round),
            Division::Rows(rows) => Steps::of_rows(rows, longest_ms, self.last_ms.get(index).copied()),
        })
    }

    fn begin_piece(&self, frame: &PacedFrame) -> Result<vk::CommandBuffer> {
        let commands = &self.slots[frame.slot].commands;
        // The piece before may be under way when a frame is abandoned.
        let commands = commands[frame.submissions as usize % commands.len()];
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: what was last recorded has completed: of the pieces of a frame the last one alone may be under way, and
        // a slot has more than one command buffer; the pool allows resetting.
        check("vkBeginCommandBuffer", unsafe { self.gpu.device.begin_command_buffer(commands, &begin) })?;
        Ok(commands)
    }

    fn end_piece(&self, frame: &mut PacedFrame, commands: vk::CommandBuffer, passes: Range<usize>) -> Result<()> {
        // SAFETY: recorded, outside a rendering scope.
        check("vkEndCommandBuffer", unsafe { self.gpu.device.end_command_buffer(commands) })?;
        frame.under_way = Some(Piece { number: self.timeline.submit(commands, &[], &[])?, passes });
        frame.submissions += 1;
        Ok(())
    }

    /// Takes note of a piece that is done.
    fn finish_piece(&self, frame: &mut PacedFrame, flow: ControlFlow<()>) -> Result<()> {
        let Some(Piece { passes, .. }) = frame.under_way.take() else { return Ok(()) };
        let piece_ms = self.slots[frame.slot].timers.read_piece_ms(&passes)?;
        passes.clone().zip(&piece_ms).for_each(|(index, ms)| frame.pass_ms[index] += ms);
        let Some(steps) = &mut frame.steps else {
            frame.next = passes.end;
            return Ok(());
        };
        let division = self.division(frame.next);
        let flow = if matches!(division, Some(Division::Repetitions(_))) { flow } else { ControlFlow::Continue(()) };
        steps.took(piece_ms.iter().sum(), flow);
        if steps.next().is_none() {
            if let Some(Division::Repetitions(repeat)) = division {
                frame.rounds_done += steps.rounds_done();
                frame.rounds += repeat.rounds;
            }
            frame.steps = None;
            frame.next += 1;
        }
        Ok(())
    }

    fn finish_paced(&mut self, frame: &mut PacedFrame) -> Result<SteppedFrame> {
        self.note_times(&frame.pass_ms);
        self.leave_slot(frame.slot);
        self.kept_is_there = true;
        let times = FrameResult {
            pass_ms: std::mem::take(&mut frame.pass_ms),
            cpu_ms: frame.begun.elapsed().as_secs_f64() * 1e3,
            readback: self.frame.resources.read_back(frame.slot),
            submissions: frame.submissions,
            crash_markers: self.crash_markers(frame.slot),
        };
        Ok(SteppedFrame { times, rounds_done: frame.rounds_done, rounds: frame.rounds })
    }

    /// Times of the first passes, for the next frame; of the others, and of those that were not run again, they stay.
    fn note_times(&mut self, pass_ms: &[f64]) {
        for (index, ms) in pass_ms.iter().enumerate() {
            if index == self.last_ms.len() {
                self.last_ms.push(*ms);
            } else if !self.is_skipped(index) {
                self.last_ms[index] = *ms;
            }
        }
    }
}

impl PacedFrame {
    /// Pieces that have been submitted.
    #[must_use]
    pub fn submissions(&self) -> u32 {
        self.submissions
    }

    /// Whether the pass that goes in pieces has its first one now.
    fn begins(&self) -> bool {
        self.steps.as_ref().is_some_and(Steps::is_at_start)
    }
}
