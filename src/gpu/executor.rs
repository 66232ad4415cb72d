//! Runs a planned frame graph: creates its resources, pipelines and descriptor sets once, records and submits
//! its passes every frame with label, timestamp and crash marker.

use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use ash::vk;

use super::check;
use super::compiled::{CompiledFrame, texel_bytes};
use super::context::Gpu;
use super::device::Device;
use super::markers::Markers;
use super::recorder;
use super::resources::{MemoryUse, aspect};
use super::scene_set::SceneSet;
use super::target::{FRAMES_IN_FLIGHT, Shown};
use super::timers::Timers;
use super::transfer;
use super::work::Work;
use crate::error::Result;
use crate::graph::{Access, BufferHandle, Graph, ImageHandle, Lifetime, Plan};

/// Bytes that one command may write to a buffer.
const UPDATE_BYTES: usize = 65_536;

/// Set to 1, every pass is submitted and waited for by itself, and its time is the wall clock of that: what
/// `tools/bench honesty` compares the timestamps with.
const SPLIT_SUBMITS: &str = "GRIDLIGHT_SPLIT_SUBMITS";

/// What the GPU said about one finished frame.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameResult {
    /// Milliseconds of each pass, in graph order.
    pub pass_ms: Vec<f64>,
    /// Milliseconds from submission to the observed completion.
    pub cpu_ms: f64,
    /// Contents of the graph's readback buffers, in the order of their declaration.
    pub readback: Vec<u8>,
}

impl FrameResult {
    /// Milliseconds of all passes together.
    #[must_use]
    pub fn gpu_ms(&self) -> f64 {
        self.pass_ms.iter().sum()
    }
}

/// A submitted frame; give it back to [`Executor::wait`].
#[derive(Debug)]
#[must_use = "wait for the frame to learn its times"]
pub struct FrameTicket {
    value: u64,
    submitted: Instant,
}

/// Command buffer and queries of one frame in flight.
pub(super) struct Slot {
    pub(super) commands: vk::CommandBuffer,
    pub(super) timers: Timers,
    pub(super) markers: Markers,
    /// Timeline value that its last frame signals.
    pub(super) busy_until: u64,
    /// Wall clock of each pass of the last frame, when passes are submitted one by one.
    split_ms: Vec<f64>,
    /// Command buffers of the submissions before the last.
    pub(super) more_commands: Vec<vk::CommandBuffer>,
}

/// Semaphores of a submission.
pub(super) type Semaphores = Vec<vk::SemaphoreSubmitInfo<'static>>;

/// A compiled frame graph.
pub struct Executor {
    pub(super) frame: CompiledFrame,
    pub(super) slots: Vec<Slot>,
    pub(super) command_pool: vk::CommandPool,
    timeline: vk::Semaphore,
    /// About the longest submission of a frame; `None` is a frame in one.
    pub(super) max_submit_ms: Option<f64>,
    /// Times of the passes of the last frame that was waited for.
    pub(super) last_ms: Vec<f64>,
    /// New contents of the scene's lights, for the next frame.
    pub(super) light_update: Option<Vec<u8>>,
    pub(super) submitted: u64,
    pub(super) split_submits: bool,
    pub(super) gpu: Arc<Device>,
}

impl Executor {
    /// Plans the graph and creates everything it needs.
    ///
    /// # Errors
    /// When the graph is wrong (a bug of ours), or the device runs out of memory.
    pub fn new(gpu: &Arc<Gpu>, graph: Graph<Work>, scene: Option<Arc<SceneSet>>) -> Result<Self> {
        let frame = CompiledFrame::new(gpu, graph, scene)?;
        let info = vk::CommandPoolCreateInfo::default()
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER)
            .queue_family_index(gpu.queue_family);
        // SAFETY: valid create info; destroyed in `drop`.
        let command_pool = check("the command pool", unsafe { gpu.device.create_command_pool(&info, None) })?;
        let mut executor = Self {
            frame,
            slots: Vec::new(),
            command_pool,
            timeline: vk::Semaphore::null(),
            max_submit_ms: None,
            last_ms: Vec::new(),
            light_update: None,
            submitted: 0,
            split_submits: std::env::var_os(SPLIT_SUBMITS).is_some_and(|v| v == "1"),
            gpu: Arc::clone(gpu),
        };
        executor.timeline = create_timeline(gpu)?;
        executor.create_slots()?;
        Ok(executor)
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

    /// Records and submits one frame. Blocks only when both frames in flight are still busy.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn submit(&mut self, frame_data: &[u8]) -> Result<FrameTicket> {
        self.submit_frame(frame_data, None)
    }

    /// The same, with the acquired image where its pictures go.
    pub(super) fn submit_frame(&mut self, frame_data: &[u8], shown: Option<&mut Shown<'_>>) -> Result<FrameTicket> {
        let slot = self.submitted as usize % self.slots.len();
        let value = self.submitted + 1;
        self.wait_value(self.slots[slot].busy_until)?;
        let submitted = Instant::now();
        self.frame.resources.use_slot(slot);
        self.slots[slot].split_ms = Vec::new();
        let (waits, signals) = shown.as_ref().map_or_else(Default::default, |shown| self.window_semaphores(shown));
        if self.split_submits && shown.is_none() {
            self.slots[slot].split_ms = self.run_split(slot, value as u32, frame_data)?;
            self.record_nothing(slot)?;
        } else {
            self.record_batches(slot, value as u32, frame_data, shown)?;
        }
        self.light_update = None;
        self.queue_with(slot, value, &waits, &signals)?;
        Ok(FrameTicket { value, submitted })
    }

    /// Records and submits one frame into an acquired image. Blocks only when both frames in flight are still busy.
    ///
    /// # Errors
    /// When the device is lost, and those of the overlay.
    pub fn submit_to(&mut self, frame_data: &[u8], shown: &mut Shown<'_>) -> Result<FrameTicket> {
        self.frame.resources.acquired(&self.frame.graph, Some(shown));
        let submitted = self.submit_frame(frame_data, Some(shown));
        self.frame.resources.acquired(&self.frame.graph, None);
        submitted
    }

    /// What a frame waits for and what it signals: the graph that takes the image first waits for it, and the one that
    /// leaves it ready to be shown says so.
    pub(super) fn window_semaphores(&self, shown: &Shown<'_>) -> (Semaphores, Semaphores) {
        let begins = self.frame.graph.resources().iter().any(|resource| resource.lifetime == Lifetime::Acquired);
        let mut uses = self.frame.graph.passes().iter().flat_map(|pass| &pass.uses);
        let ends = uses.any(|used| used.access == Access::Present);
        let waits = begins.then(|| shown.target.wait_info()).into_iter().collect();
        (waits, ends.then(|| shown.target.signal_info()).into_iter().collect())
    }

    /// Writes the start of the scene's lights with the next frame, after what earlier frames read of them. No more
    /// than [`UPDATE_BYTES`] are taken.
    pub fn update_lights(&mut self, mut bytes: Vec<u8>) {
        bytes.truncate(UPDATE_BYTES);
        self.light_update = Some(bytes);
    }

    pub(super) fn record_scene_update(&self, commands: vk::CommandBuffer) {
        let (Some(bytes), Some(scene)) = (&self.light_update, &self.frame.scene) else { return };
        transfer::full_barrier(&self.gpu, commands);
        // SAFETY: the lights' buffer is a transfer destination and larger than what is written to it.
        unsafe { self.gpu.device.cmd_update_buffer(commands, scene.lights().raw, 0, bytes) };
        transfer::full_barrier(&self.gpu, commands);
    }

    /// Whether a frame has completed.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn is_done(&self, ticket: &FrameTicket) -> Result<bool> {
        // SAFETY: the semaphore is a timeline of this device.
        let value = unsafe { self.gpu.device.get_semaphore_counter_value(self.timeline) };
        Ok(check("the frame's timeline", value)? >= ticket.value)
    }

    /// Submits the slot's command buffer; its completion brings the timeline to `value`.
    pub(super) fn queue(&mut self, slot: usize, value: u64) -> Result<()> {
        self.queue_with(slot, value, &[], &[])
    }

    fn queue_with(
        &mut self,
        slot: usize,
        value: u64,
        waits: &[vk::SemaphoreSubmitInfo<'_>],
        signals: &[vk::SemaphoreSubmitInfo<'_>],
    ) -> Result<()> {
        let commands = [vk::CommandBufferSubmitInfo::default().command_buffer(self.slots[slot].commands)];
        let completed = vk::SemaphoreSubmitInfo::default()
            .semaphore(self.timeline)
            .value(value)
            .stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS);
        let signals = [&[completed], signals].concat();
        let info = [vk::SubmitInfo2::default()
            .wait_semaphore_infos(waits)
            .command_buffer_infos(&commands)
            .signal_semaphore_infos(&signals)];
        // SAFETY: the command buffer is recorded and its slot idle; the queue is used from this thread only.
        let result = unsafe { self.gpu.device.queue_submit2(self.gpu.queue, &info, vk::Fence::null()) };
        self.explain(slot, value, check("vkQueueSubmit2", result))?;
        self.slots[slot].busy_until = value;
        self.submitted = value;
        Ok(())
    }

    /// Waits for a frame and reads its timestamps. Call it before the same slot is submitted again, that is
    /// within two frames.
    ///
    /// # Errors
    /// When the device is lost; names the last pass reached.
    #[expect(clippy::needless_pass_by_value, reason = "a ticket is good for one wait")]
    pub fn wait(&mut self, ticket: FrameTicket) -> Result<FrameResult> {
        self.wait_value(ticket.value)?;
        let cpu_ms = ticket.submitted.elapsed().as_secs_f64() * 1e3;
        let slot = &self.slots[(ticket.value - 1) as usize % self.slots.len()];
        let pass_ms = if slot.split_ms.is_empty() { slot.timers.read_ms()? } else { slot.split_ms.clone() };
        let readback = self.frame.resources.read_back((ticket.value - 1) as usize % self.slots.len());
        self.last_ms.clone_from(&pass_ms);
        Ok(FrameResult { pass_ms, cpu_ms, readback })
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

    /// Texels of a persistent image after the last frame, rows packed; waits.
    ///
    /// # Errors
    /// When the device is lost or has no memory.
    pub fn read_image(&self, image: ImageHandle) -> Result<Vec<u8>> {
        let (raw, _, info) = self.frame.resources.image(image);
        let layout = self.frame.final_layout(image);
        let extent = [info.width_px, info.height_px];
        transfer::download_image(&self.gpu, raw, aspect(&info), layout, extent, texel_bytes(info.format))
    }

    pub(super) fn wait_value(&self, value: u64) -> Result<()> {
        let semaphores = [self.timeline];
        let values = [value];
        let info = vk::SemaphoreWaitInfo::default().semaphores(&semaphores).values(&values);
        // SAFETY: the semaphore is a timeline of this device.
        let result = unsafe { self.gpu.device.wait_semaphores(&info, u64::MAX) };
        let slot = (value.max(1) - 1) as usize % self.slots.len();
        self.explain(slot, value, check("vkWaitSemaphores", result))
    }

    pub(super) fn explain<T>(&self, slot: usize, value: u64, result: Result<T>) -> Result<T> {
        let names: Vec<&str> = self.frame.graph.passes().iter().map(|p| p.name.as_str()).collect();
        self.slots[slot].markers.explain(result, &names, value as u32)
    }

    /// Leaves an empty command buffer to submit: the passes have run one by one.
    fn record_nothing(&self, slot: usize) -> Result<()> {
        let slot = &self.slots[slot];
        self.begin_commands(slot.commands)?;
        // SAFETY: recording is complete.
        check("vkEndCommandBuffer", unsafe { self.gpu.device.end_command_buffer(slot.commands) })
    }

    /// Records some of the passes in a command buffer of their own; before the first of all, what the frame begins with.
    /// `shown` is where a frame of a window goes.
    pub(super) fn record_passes(
        &self,
        slot: usize,
        commands: vk::CommandBuffer,
        stamp: u32,
        passes: Range<usize>,
        frame_data: &[u8],
        shown: &mut Option<&mut Shown<'_>>,
    ) -> Result<()> {
        let slot = &self.slots[slot];
        self.begin_commands(commands)?;
        if passes.start == 0 {
            self.record_scene_update(commands);
            slot.timers.begin(commands);
        }
        for index in passes {
            slot.markers.reach(commands, index, stamp);
            match (&self.frame.graph.passes()[index].payload, shown.as_mut()) {
                (Work::Overlay, Some(shown)) => recorder::record_overlay(&self.frame, commands, index, shown)?,
                _ => recorder::record_pass(&self.frame, commands, index, frame_data),
            }
            slot.timers.after_pass(commands, index);
        }
        // SAFETY: recording is complete.
        check("vkEndCommandBuffer", unsafe { self.gpu.device.end_command_buffer(commands) })
    }

    pub(super) fn begin_commands(&self, commands: vk::CommandBuffer) -> Result<()> {
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: what was last recorded has completed; the pool allows resetting.
        check("vkBeginCommandBuffer", unsafe { self.gpu.device.begin_command_buffer(commands, &begin) })
    }

    /// Submits and waits for one pass after the other; the milliseconds of each from submission to completion.
    fn run_split(&self, slot: usize, stamp: u32, frame_data: &[u8]) -> Result<Vec<f64>> {
        let run = |index| {
            self.submit_and_wait(slot, |commands| {
                self.slots[slot].markers.reach(commands, index, stamp);
                recorder::record_pass(&self.frame, commands, index, frame_data);
            })
        };
        (0..self.frame.passes.len()).map(run).collect()
    }

    /// Submits what `record` puts into the slot's command buffer and waits; milliseconds from submission to completion.
    pub(super) fn submit_and_wait(&self, slot: usize, record: impl FnOnce(vk::CommandBuffer)) -> Result<f64> {
        let device = &self.gpu.device;
        let commands = self.slots[slot].commands;
        let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(commands)];
        let info = [vk::SubmitInfo2::default().command_buffer_infos(&buffers)];
        self.begin_commands(commands)?;
        record(commands);
        // SAFETY: recording is complete; the queue is used from this thread only, and is idle afterwards.
        unsafe {
            check("vkEndCommandBuffer", device.end_command_buffer(commands))?;
            let start = Instant::now();
            check("vkQueueSubmit2", device.queue_submit2(self.gpu.queue, &info, vk::Fence::null()))?;
            check("vkQueueWaitIdle", device.queue_wait_idle(self.gpu.queue))?;
            Ok(start.elapsed().as_secs_f64() * 1e3)
        }
    }

    fn create_slots(&mut self) -> Result<()> {
        let info = vk::CommandBufferAllocateInfo::default()
            .command_pool(self.command_pool)
            .command_buffer_count(FRAMES_IN_FLIGHT as u32);
        // SAFETY: the pool is alive.
        let commands = check("command buffers", unsafe { self.gpu.device.allocate_command_buffers(&info) })?;
        let pass_count = self.frame.graph.passes().len();
        for commands in commands {
            let timers = Timers::new(&self.gpu, pass_count)?;
            let markers = Markers::new(&self.gpu, pass_count)?;
            self.slots.push(Slot {
                commands,
                timers,
                markers,
                busy_until: 0,
                split_ms: Vec::new(),
                more_commands: Vec::new(),
            });
        }
        Ok(())
    }
}

fn create_timeline(gpu: &Device) -> Result<vk::Semaphore> {
    let mut kind = vk::SemaphoreTypeCreateInfo::default().semaphore_type(vk::SemaphoreType::TIMELINE);
    let info = vk::SemaphoreCreateInfo::default().push_next(&mut kind);
    // SAFETY: timeline semaphores are required by the baseline; destroyed with the executor.
    let semaphore = check("the timeline", unsafe { gpu.device.create_semaphore(&info, None) })?;
    gpu.set_name(semaphore, "frame timeline");
    Ok(semaphore)
}

impl Drop for Executor {
    fn drop(&mut self) {
        if let Err(error) = self.gpu.wait_idle() {
            log::error!("waiting for the GPU: {error}");
        }
        // SAFETY: the GPU is idle; the pool frees its command buffers.
        unsafe {
            self.gpu.device.destroy_command_pool(self.command_pool, None);
            self.gpu.device.destroy_semaphore(self.timeline, None);
        }
    }
}
