//! The frame loop: passes recorded and submitted in order, in as many submissions as the policy says.

use std::ops::{ControlFlow, Range};
use std::time::Instant;

use ash::vk;

use super::batches::{PassBefore, batches};
use super::check;
use super::compiled::CompiledFrame;
use super::recorder::{self, Begins};
use super::slot::Slot;
use super::steps::Steps;
use super::target::WindowTarget;
use super::timeline::Timeline;
use super::work::{ComputeWork, Repeat, Work};
use crate::error::Result;
use crate::graph::{Access, Graph, Lifetime, Use};

/// Called with the parts of a frame that are done and all of them: after every step of a repeated pass, where `Break` ends
/// the pass with its round; in frames without one whenever passes have completed.
pub type OnStep<'a> = dyn FnMut(u32, u32) -> ControlFlow<()> + 'a;

/// How a frame is given to the device.
pub(super) enum Policy<'a, 'b> {
    /// Passes go together as long as their last times allow; nothing is waited for. Those from the first that uses the
    /// acquired image on are one submission: it waits for the image, and presentation for it.
    Batched { max_submit_ms: f64, shown: Option<&'a mut WindowTarget<'b>> },
    /// The same, but a repeated pass runs in steps, each waited for, so that it can be timed, shown and followed by a
    /// stop.
    Stepped { max_submit_ms: f64, on_step: &'a mut OnStep<'b> },
    /// Every pass, and every repetition, is a submission that is waited for; then the pass is visited.
    PassByPass { visit: &'a mut Visit<'b> },
}

/// Called with the index of a pass that has completed.
pub(super) type Visit<'a> = dyn FnMut(usize) -> Result<()> + 'a;

impl<'b> Policy<'_, 'b> {
    fn shown(&mut self) -> Option<&mut WindowTarget<'b>> {
        match self {
            Self::Batched { shown, .. } => shown.as_deref_mut(),
            _ => None,
        }
    }

    /// About the longest submission; 0 where each is as short as can be.
    fn max_submit_ms(&self) -> f64 {
        match self {
            Self::Batched { max_submit_ms, .. } | Self::Stepped { max_submit_ms, .. } => *max_submit_ms,
            Self::PassByPass { .. } => 0.0,
        }
    }
}

/// What became of a frame that has been submitted.
#[derive(Debug, Default)]
pub(super) struct Ran {
    /// The submission that completes last.
    pub last: u64,
    /// Submissions in all.
    pub submissions: u32,
    /// Every submission of whole passes, with the passes of the frame that are done when it completes.
    pub milestones: Vec<(u64, u32)>,
    /// Rounds of the repeated passes that were finished, and all; 0 where they are not run in steps.
    pub rounds_done: u32,
    pub rounds: u32,
    /// Wall clock of each pass that was waited for by itself, from submission to completion.
    pub wall_ms: Vec<f64>,
}

/// What a frame is run with.
pub(super) struct Given<'a> {
    pub frame: &'a CompiledFrame,
    pub timeline: &'a Timeline,
    /// Its last frame has completed.
    pub slot: &'a Slot,
    /// Times of the passes in the last frame; none before the first.
    pub last_ms: &'a [f64],
    /// The frame's constants.
    pub frame_data: &'a [u8],
    /// The pass before which the device is taken for lost.
    pub planted_loss: Option<usize>,
}

/// Records and submits one frame.
pub(super) fn run(given: Given<'_>, policy: Policy<'_, '_>) -> Result<Ran> {
    let last = given.timeline.last();
    given.slot.stamp.set((last + 1) as u32);
    let ran = Ran { last, ..Ran::default() };
    Runner { given, ran, in_flight: 0, submitted: Instant::now(), untimed: None, waited_ms: 0.0 }.run(policy)
}

/// A frame while it is recorded and submitted.
struct Runner<'a> {
    given: Given<'a>,
    ran: Ran,
    /// Submissions not yet waited for: the slot's first command buffers.
    in_flight: usize,
    /// When the last of them was submitted.
    submitted: Instant,
    /// A pass that has run in steps; its timestamp goes into the next submission.
    untimed: Option<usize>,
    /// Milliseconds of the pass so far, where its submissions are waited for.
    waited_ms: f64,
}

impl Runner<'_> {
    /// How often the pass repeats, if it does.
    fn repeat_of(&self, index: usize) -> Option<Repeat> {
        match self.given.frame.graph.passes().get(index)?.payload {
            Work::Compute(ComputeWork { repeat, .. }) => repeat,
            _ => None,
        }
    }

    /// Passes by submission; one in steps is alone.
    fn batches(&self, policy: &Policy<'_, '_>) -> Vec<Range<usize>> {
        let graph = &self.given.frame.graph;
        let count = graph.passes().len();
        let in_window = |used: &Use| graph.resources()[used.resource.index()].lifetime.is_acquired();
        let mut passes = graph.passes().iter();
        let first_in_window = passes.position(|pass| pass.uses.iter().any(in_window)).unwrap_or(count);
        let known = |index| PassBefore {
            ms: self.given.last_ms.get(index).copied(),
            is_alone: match policy {
                Policy::Batched { .. } => false,
                Policy::Stepped { .. } => self.repeat_of(index).is_some(),
                Policy::PassByPass { .. } => true,
            },
            goes_with_last: matches!(policy, Policy::Batched { .. }) && index > first_in_window,
        };
        batches(&(0..count).map(known).collect::<Vec<_>>(), policy.max_submit_ms())
    }

    fn run(mut self, mut policy: Policy<'_, '_>) -> Result<Ran> {
        let batches = self.batches(&policy);
        for (number, batch) in batches.iter().enumerate() {
            match (&policy, self.repeat_of(batch.start)) {
                (Policy::Stepped { .. } | Policy::PassByPass { .. }, Some(repeat)) => {
                    self.run_in_steps(batch.start, repeat, &mut policy)?;
                }
                _ => self.run_batch(batch.clone(), number + 1 == batches.len(), &mut policy)?,
            }
            if let (Policy::PassByPass { visit }, false) = (&mut policy, batch.is_empty()) {
                self.wait()?;
                self.ran.wall_ms.push(std::mem::take(&mut self.waited_ms));
                visit(batch.start)?;
            }
        }
        if self.untimed.is_some() {
            let commands = self.begin()?;
            self.submit(commands, &[], &[])?;
        }
        Ok(self.ran)
    }

    /// Passes in one submission; the last of a frame has the window's semaphores.
    fn run_batch(&mut self, batch: Range<usize>, is_last: bool, policy: &mut Policy<'_, '_>) -> Result<()> {
        let frame = self.given.frame;
        let commands = self.begin()?;
        let end = batch.end as u32;
        for index in batch {
            self.enter(commands, index)?;
            match (&frame.graph.passes()[index].payload, policy.shown()) {
                (Work::Overlay, Some(shown)) => recorder::record_overlay(frame, commands, index, shown)?,
                _ => recorder::record_pass(frame, commands, index, self.given.frame_data),
            }
            self.leave(commands, index);
        }
        let shown = policy.shown().filter(|_| is_last);
        let (waits, signals) = shown.map_or_else(Default::default, |shown| window_semaphores(&frame.graph, shown));
        self.submit(commands, &waits, &signals)?;
        self.ran.milestones.push((self.ran.last, end));
        Ok(())
    }

    /// A repeated pass in submissions that are waited for.
    fn run_in_steps(&mut self, index: usize, repeat: Repeat, policy: &mut Policy<'_, '_>) -> Result<()> {
        // The steps are timed by the wall clock: nothing else may be under way.
        self.wait()?;
        self.waited_ms = 0.0;
        let mut steps = Steps::new(repeat, policy.max_submit_ms());
        while let Some(range) = steps.next() {
            let commands = self.begin()?;
            let begins = if range.start == 0 { Begins::Yes } else { Begins::No };
            if begins == Begins::Yes {
                self.enter(commands, index)?;
            }
            let done = range.end;
            recorder::record_repetitions(self.given.frame, commands, index, range, begins);
            self.submit(commands, &[], &[])?;
            let ms = self.wait()?;
            let flow = match policy {
                Policy::Stepped { on_step, .. } => on_step(done, repeat.count()),
                _ => ControlFlow::Continue(()),
            };
            steps.took(ms, flow);
        }
        self.untimed = Some(index);
        self.ran.rounds_done += steps.rounds_done();
        self.ran.rounds += repeat.rounds;
        log::debug!("{}: {}", self.given.frame.graph.passes()[index].name, steps.summary());
        Ok(())
    }

    /// What comes before a pass.
    fn enter(&mut self, commands: vk::CommandBuffer, index: usize) -> Result<()> {
        self.given.slot.markers.enter(commands, index, self.given.slot.stamp.get());
        if self.given.planted_loss != Some(index) {
            return Ok(());
        }
        self.submit(commands, &[], &[])?;
        self.wait()?;
        check("vkQueueSubmit2", Err(vk::Result::ERROR_DEVICE_LOST))
    }

    /// What comes after a pass.
    fn leave(&self, commands: vk::CommandBuffer, index: usize) {
        let Slot { timers, markers, stamp, .. } = self.given.slot;
        timers.after_pass(commands, index);
        markers.leave(commands, index, stamp.get());
    }

    /// A command buffer that records. The first of a frame has what the frame begins with.
    fn begin(&mut self) -> Result<vk::CommandBuffer> {
        let commands = self.given.slot.commands[self.in_flight];
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: what was last recorded has completed; the pool allows resetting.
        let begun = unsafe { self.given.frame.gpu.device.begin_command_buffer(commands, &begin) };
        check("vkBeginCommandBuffer", begun)?;
        if self.ran.submissions == 0 {
            self.given.slot.timers.begin(commands);
        }
        if let Some(index) = self.untimed.take() {
            self.leave(commands, index);
        }
        Ok(commands)
    }

    /// Barriers reach back over submissions to the same queue, so that those of a frame need no semaphores between them.
    fn submit(
        &mut self,
        commands: vk::CommandBuffer,
        waits: &[vk::SemaphoreSubmitInfo<'_>],
        signals: &[vk::SemaphoreSubmitInfo<'_>],
    ) -> Result<()> {
        // SAFETY: recorded, outside a rendering scope.
        check("vkEndCommandBuffer", unsafe { self.given.frame.gpu.device.end_command_buffer(commands) })?;
        self.submitted = Instant::now();
        self.ran.last = self.given.timeline.submit(commands, waits, signals)?;
        self.ran.submissions += 1;
        self.in_flight += 1;
        Ok(())
    }

    /// Waits for all that has been submitted; milliseconds from the last submission to its completion.
    fn wait(&mut self) -> Result<f64> {
        if self.in_flight == 0 {
            return Ok(0.0);
        }
        self.given.timeline.wait(self.ran.last)?;
        self.in_flight = 0;
        let ms = self.submitted.elapsed().as_secs_f64() * 1e3;
        self.waited_ms += ms;
        Ok(ms)
    }
}

/// Semaphores of a submission.
type Semaphores = Vec<vk::SemaphoreSubmitInfo<'static>>;

/// What a frame waits for and what it signals: the graph that takes the image first waits for it, and the one that
/// leaves it ready to be shown says so.
fn window_semaphores(graph: &Graph<Work>, shown: &WindowTarget<'_>) -> (Semaphores, Semaphores) {
    let begins = graph.resources().iter().any(|resource| resource.lifetime == Lifetime::Acquired);
    let mut uses = graph.passes().iter().flat_map(|pass| &pass.uses);
    let ends = uses.any(|used| used.access == Access::Present);
    let waits = begins.then(|| shown.target.wait_info()).into_iter().collect();
    (waits, ends.then(|| shown.target.signal_info()).into_iter().collect())
}
