//! A planned frame graph on a device: its resources, pipelines and descriptor sets are created once, and frames of it
//! are run, waited for and read back.

use std::cmp::Reverse;
use std::sync::Arc;
use std::time::Instant;

use ash::vk;

use super::check;
use super::compiled::CompiledFrame;
use super::context::Gpu;
use super::device::Device;
use super::loss::{self, MarkerScheme};
use super::resources::{Imports, MemoryUse};
use super::runner::{self, Given, OnStep, Policy, Ran};
use super::scene_set::SceneSet;
use super::shared_image::SharedImage;
use super::slot::Slot;
use super::target::{FRAMES_IN_FLIGHT, WindowTarget};
use super::timeline::Timeline;
use super::transfer;
use super::work::Work;
use crate::error::{Error, Result};
use crate::graph::{BufferHandle, Graph, ImageLevel, Plan, ResourceInfo};

/// Set to 1, every pass is submitted and waited for by itself, and its time is the wall clock of that: what
/// `tools/bench honesty` compares the timestamps with.
const SPLIT_SUBMITS: &str = "GRIDLIGHT_SPLIT_SUBMITS";

/// Name of a pass before which every frame stops and the device is taken for lost, for tests.
const LOSE_DEVICE: &str = "GRIDLIGHT_LOSE_DEVICE";

/// What the GPU said about one finished frame.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameResult {
    /// Milliseconds of each pass, in graph order.
    pub pass_ms: Vec<f64>,
    /// Milliseconds from submission to the observed completion.
    pub cpu_ms: f64,
    /// Contents of the graph's readback buffers, in the order of their declaration.
    pub readback: Vec<u8>,
    /// Submissions that the frame was given to the device in.
    pub submissions: u32,
    /// Words of crash markers that it has written ([`MarkerScheme`]): one for each batch of barriers, or two for each pass;
    /// checkpoints have none.
    pub crash_markers: u32,
}

impl FrameResult {
    /// Milliseconds of all passes together.
    #[must_use]
    pub fn gpu_ms(&self) -> f64 {
        self.pass_ms.iter().sum()
    }
}

/// A frame with repeated passes that has completed.
#[derive(Clone, Debug, PartialEq)]
pub struct SteppedFrame {
    /// Times of the passes; a repeated one includes the gaps between its steps.
    pub times: FrameResult,
    /// Rounds of the repeated pass that were finished.
    pub rounds_done: u32,
    /// Rounds it has in all; 0 when no pass repeats.
    pub rounds: u32,
}

/// A submitted frame; give it back to [`Executor::wait`].
#[derive(Debug)]
#[must_use = "wait for the frame to learn its times"]
pub struct FrameTicket {
    slot: usize,
    submitted: Instant,
    ran: Ran,
}

/// A compiled frame graph.
pub struct Executor {
    pub(super) frame: CompiledFrame,
    pub(super) slots: Vec<Slot>,
    command_pool: vk::CommandPool,
    pub(super) timeline: Timeline,
    /// About the longest submission of a frame; infinite is a frame in one.
    max_submit_ms: f64,
    /// Times of the passes of the last frame that was waited for.
    pub(super) last_ms: Vec<f64>,
    /// Whether the next paced frame may use what kept passes have left, whether they have left it, and whether the frame under
    /// way does so.
    may_reuse_kept: bool,
    pub(super) kept_is_there: bool,
    skips_kept: bool,
    /// Frames submitted so far.
    frames: u64,
    split_submits: bool,
    /// The pass before which the device is taken for lost.
    planted_loss: Option<usize>,
    pub(super) gpu: Arc<Device>,
}

impl Executor {
    /// Plans the graph and creates everything it needs.
    ///
    /// # Errors
    /// When the graph is wrong (a bug of ours), or the device runs out of memory.
    pub fn new(gpu: &Arc<Gpu>, graph: Graph<Work>, scene: Option<Arc<SceneSet>>) -> Result<Self> {
        Self::with_images(gpu, graph, scene, Vec::new())
    }

    /// The same for a graph that imports these images as well.
    ///
    /// # Errors
    /// Those of [`Self::new`].
    pub fn with_images(
        gpu: &Arc<Gpu>,
        graph: Graph<Work>,
        scene: Option<Arc<SceneSet>>,
        images: Vec<Arc<SharedImage>>,
    ) -> Result<Self> {
        let frame = CompiledFrame::new(gpu, graph, Imports { scene, images })?;
        let info = vk::CommandPoolCreateInfo::default()
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER)
            .queue_family_index(gpu.queue_family);
        // SAFETY: valid create info; destroyed in `drop`.
        let command_pool = check("the command pool", unsafe { gpu.device.create_command_pool(&info, None) })?;
        let mut executor = Self {
            planted_loss: planted_loss(&frame),
            frame,
            slots: Vec::new(),
            command_pool,
            timeline: Timeline::new(gpu)?,
            max_submit_ms: f64::INFINITY,
            last_ms: Vec::new(),
            may_reuse_kept: false,
            kept_is_there: false,
            skips_kept: false,
            frames: 0,
            split_submits: std::env::var_os(SPLIT_SUBMITS).is_some_and(|v| v == "1"),
            gpu: Arc::clone(gpu),
        };
        let markers = MarkerScheme::of(gpu.features(), executor.planted_loss.is_some());
        let slot = |_| Slot::new(gpu, command_pool, &executor.frame.plan, markers);
        executor.slots = (0..FRAMES_IN_FLIGHT).map(slot).collect::<Result<_>>()?;
        executor.fill_buffers()?;
        Ok(executor)
    }

    /// Writes what buffers hold before the first frame.
    fn fill_buffers(&self) -> Result<()> {
        for (index, resource) in self.frame.graph.resources().iter().enumerate() {
            if let (Some(contents), ResourceInfo::Buffer(_)) = (&resource.contents, resource.info) {
                transfer::upload_raw(&self.gpu, self.frame.resources.buffer_at(index).0, contents)?;
            }
        }
        Ok(())
    }

    /// Frames are split into submissions of about this long at most; a pass that takes longer is one of its own. The
    /// first frame, whose times are not known, has a submission for each pass. Without a limit a frame is one submission.
    pub fn set_max_submit_ms(&mut self, max_submit_ms: f64) {
        self.max_submit_ms = max_submit_ms;
    }

    /// The graph as built.
    #[must_use]
    pub fn graph(&self) -> &Graph<Work> {
        &self.frame.graph
    }

    /// The barrier plan in use.
    #[must_use]
    pub fn plan(&self) -> &Plan {
        &self.frame.plan
    }

    /// Memory of the frame's resources.
    #[must_use]
    pub fn memory(&self) -> MemoryUse {
        self.frame.resources.memory
    }

    /// Whether the next frame finds, in what its history has of the frame before, something that belongs there:
    /// neither in the first frame nor after a cut, and never in a frame that keeps no history.
    #[must_use]
    pub fn history_is_valid(&self) -> bool {
        self.frame.history_is_valid && self.frame.resources.keeps_history()
    }

    /// What comes next has nothing to do with what was before: the next frame's history is not valid.
    pub fn invalidate_history(&mut self) {
        self.frame.history_is_valid = false;
    }

    /// Whether the next frame that goes in pieces may use again what kept passes ([`crate::graph::Graph::keep_from`]) have left:
    /// everything that they read is then as it was.
    pub fn set_reuses_kept(&mut self, reuses: bool) {
        self.may_reuse_kept = reuses;
    }

    /// Begins a frame that uses what kept passes have left, if it may and that is there.
    pub(super) fn begin_kept(&mut self) {
        self.skips_kept = self.may_reuse_kept && self.kept_is_there;
        self.kept_is_there = self.skips_kept;
    }

    /// Whether the frame under way has the results of a pass already.
    pub(super) fn is_skipped(&self, index: usize) -> bool {
        self.skips_kept && self.frame.graph.passes()[index].is_kept
    }

    /// Records and submits one frame. Blocks only when both frames in flight are still busy.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn submit(&mut self, frame_data: &[u8]) -> Result<FrameTicket> {
        self.submit_frame(frame_data, Policy::Batched { max_submit_ms: self.max_submit_ms, shown: None })
    }

    /// Records and submits one frame into an acquired image. Blocks only when both frames in flight are still busy.
    ///
    /// # Errors
    /// When the device is lost, and those of the overlay.
    pub fn submit_to(&mut self, frame_data: &[u8], shown: &mut WindowTarget<'_>) -> Result<FrameTicket> {
        self.frame.resources.acquired(&self.frame.graph, Some(shown));
        let policy = Policy::Batched { max_submit_ms: self.max_submit_ms, shown: Some(shown) };
        let submitted = self.submit_frame(frame_data, policy);
        self.frame.resources.acquired(&self.frame.graph, None);
        submitted
    }

    /// Runs one frame and waits for it, in submissions of about `max_submit_ms` at most: whole passes, and steps of
    /// repeated ones.
    ///
    /// # Errors
    /// When the device is lost; names the last pass reached.
    pub fn run_in_steps(
        &mut self,
        frame_data: &[u8],
        max_submit_ms: f64,
        on_step: &mut OnStep,
    ) -> Result<SteppedFrame> {
        let ticket = self.submit_frame(frame_data, Policy::Stepped { max_submit_ms, on_step: &mut *on_step })?;
        let Ran { rounds_done, rounds, .. } = ticket.ran;
        if rounds == 0 {
            self.follow(&ticket.ran, on_step)?;
        }
        Ok(SteppedFrame { times: self.wait(ticket)?, rounds_done, rounds })
    }

    /// Waits for one submission after the other, and tells how many passes are done.
    fn follow(&self, ran: &Ran, on_step: &mut OnStep) -> Result<()> {
        let passes = self.frame.graph.passes().len() as u32;
        for (number, done) in &ran.milestones {
            self.explain(self.timeline.wait(*number))?;
            // All has been submitted: the frame cannot be ended any more.
            let _ = on_step(*done, passes);
        }
        Ok(())
    }

    fn submit_frame(&mut self, frame_data: &[u8], policy: Policy<'_, '_>) -> Result<FrameTicket> {
        let slot = self.take_slot()?;
        self.kept_is_there = false;
        let submitted = Instant::now();
        let ran = if self.split_submits && !matches!(policy, Policy::Batched { shown: Some(_), .. }) {
            self.run(slot, frame_data, Policy::PassByPass { visit: &mut |_| Ok(()) })
        } else {
            self.run(slot, frame_data, policy)
        };
        // A frame that failed may have submitted a part.
        self.leave_slot(slot);
        Ok(FrameTicket { slot, submitted, ran: ran? })
    }

    /// Begins a frame with what is free; waits when both frames in flight are still busy.
    pub(super) fn take_slot(&mut self) -> Result<usize> {
        let slot = self.frames as usize % self.slots.len();
        self.explain(self.timeline.wait(self.slots[slot].busy_until))?;
        self.frame.begin();
        self.frame.resources.use_slot(slot);
        Ok(slot)
    }

    /// All of a frame has been submitted.
    pub(super) fn leave_slot(&mut self, slot: usize) {
        self.frame.light_update = None;
        self.frames += 1;
        self.slots[slot].busy_until = self.timeline.last();
    }

    /// Writes the start of the scene's lights with the next frame, in the pass that has
    /// [`TransferOp::SceneLights`](super::TransferOp::SceneLights).
    ///
    /// # Errors
    /// [`Error::Failure`] when there are more than the scene has room for, or no pass writes them.
    pub fn update_lights(&mut self, bytes: Vec<u8>) -> Result<()> {
        let room_bytes = self.frame.lights_target().map_or(0, |(_, size_bytes)| size_bytes);
        if bytes.len() as u64 > room_bytes {
            let what = format!("{} bytes of lights do not fit into the scene's {room_bytes}", bytes.len());
            return Err(Error::Failure(what));
        }
        self.frame.light_update = Some(bytes);
        Ok(())
    }

    /// Whether a frame has completed.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn is_done(&self, ticket: &FrameTicket) -> Result<bool> {
        self.timeline.has_reached(ticket.ran.last)
    }

    /// Waits for a frame and reads its timestamps. Call it before the same slot is submitted again, that is
    /// within two frames.
    ///
    /// # Errors
    /// When the device is lost; names the last pass reached.
    pub fn wait(&mut self, ticket: FrameTicket) -> Result<FrameResult> {
        let FrameTicket { slot, submitted, ran } = ticket;
        self.explain(self.timeline.wait(ran.last))?;
        let cpu_ms = submitted.elapsed().as_secs_f64() * 1e3;
        let pass_ms = if ran.wall_ms.is_empty() { self.slots[slot].timers.read_ms()? } else { ran.wall_ms };
        let readback = self.frame.resources.read_back(slot);
        self.last_ms.clone_from(&pass_ms);
        let crash_markers = self.crash_markers(slot);
        Ok(FrameResult { pass_ms, cpu_ms, readback, submissions: ran.submissions, crash_markers })
    }

    /// Words of crash markers that the last frame of a slot has written.
    pub(super) fn crash_markers(&self, slot: usize) -> u32 {
        let Slot { markers, stamp, .. } = &self.slots[slot];
        markers.written(stamp.get()) as u32
    }

    /// Writes the start of a persistent buffer outside frames; waits.
    ///
    /// # Errors
    /// When the device is lost or has no memory.
    pub fn write_buffer(&self, buffer: BufferHandle, bytes: &[u8]) -> Result<()> {
        self.gpu.wait_idle()?;
        transfer::upload_raw(&self.gpu, self.frame.resources.buffer(buffer).0, bytes)
    }

    /// Contents of a buffer after the last frame; waits. Transient contents survive only until their memory is
    /// reused within the frame, so ask for persistent buffers.
    ///
    /// # Errors
    /// When the device is lost or has no memory.
    pub fn read_buffer(&self, buffer: BufferHandle) -> Result<Vec<u8>> {
        let (raw, size) = self.frame.resources.buffer(buffer);
        transfer::download_buffer(&self.gpu, raw, size)
    }

    /// Texels of a persistent image, or of one of its levels, after the last frame: rows, slices and layers packed;
    /// waits.
    ///
    /// # Errors
    /// When the device is lost or has no memory.
    pub fn read_image(&self, image: impl Into<ImageLevel>) -> Result<Vec<u8>> {
        let level = image.into();
        let (raw, _, info) = self.frame.resources.image(level.image);
        transfer::download_image(&self.gpu, raw, &info, level.level, self.frame.final_layout(level))
    }

    /// Runs one frame with the command buffers of a slot whose last frame has completed.
    pub(super) fn run(&self, slot: usize, frame_data: &[u8], policy: Policy<'_, '_>) -> Result<Ran> {
        let given = Given {
            frame: &self.frame,
            timeline: &self.timeline,
            slot: &self.slots[slot],
            last_ms: &self.last_ms,
            frame_data,
            planted_loss: self.planted_loss,
        };
        self.explain(runner::run(given, policy))
    }

    /// Says in which passes the device was lost, where that is what a result says.
    pub(super) fn explain<T>(&self, result: Result<T>) -> Result<T> {
        result.map_err(|error| match error {
            Error::DeviceLost { .. } => Error::DeviceLost { place: self.report_of_loss() },
            other => other,
        })
    }

    /// Where the device was lost, and what its driver says of it. Of a device that is only taken for lost it must not be
    /// asked.
    fn report_of_loss(&self) -> String {
        let place = self.place_of_loss();
        let fault = if self.planted_loss.is_some() { None } else { self.gpu.diagnostics.fault() };
        match fault.and_then(|fault| fault.sentence()) {
            Some(sentence) => format!("{place}; {sentence}"),
            None => place,
        }
    }

    /// Where the newest frame is that has begun.
    fn place_of_loss(&self) -> String {
        let mut slots: Vec<&Slot> = self.slots.iter().filter(|slot| slot.stamp.get() > 0).collect();
        slots.sort_by_key(|slot| Reverse(slot.stamp.get()));
        let names: Vec<&str> = self.frame.graph.passes().iter().map(|pass| pass.name.as_str()).collect();
        let begun = slots.iter().find_map(|slot| slot.markers.suspects(slot.stamp.get()));
        loss::place(&names, begun.unwrap_or(0..slots.first().map_or(0, |slot| slot.markers.first_marked())))
    }
}

fn planted_loss(frame: &CompiledFrame) -> Option<usize> {
    let name = std::env::var(LOSE_DEVICE).ok()?;
    frame.graph.passes().iter().position(|pass| pass.name == name)
}

impl Drop for Executor {
    fn drop(&mut self) {
        if let Err(error) = self.gpu.wait_idle() {
            log::error!("waiting for the GPU: {error}");
        }
        // SAFETY: the GPU is idle; the pool frees its command buffers.
        unsafe { self.gpu.device.destroy_command_pool(self.command_pool, None) };
    }
}
