//! Crash markers: what the device leaves on its way through a frame, so that after its loss the passes it was at can be
//! named. There are three kinds ([`MarkerScheme`]), chosen by what the device offers.
//!
//! On any driver there is a host-visible word for each group of passes, that is for each batch of barriers of the plan:
//! passes between two batches do not depend on each other and may overlap. A group's word is written when everything
//! before it has completed, and nothing of the group begins before. The extensions need no such order: they tell of each
//! pass by itself whether it has begun and whether it is done.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU16, Ordering};

use ash::vk;

use super::buffer::Buffer;
use super::device::Device;
use super::loss::{self, MarkerScheme};
use crate::error::Result;
use crate::graph::Plan;

/// The markers of one frame in flight.
pub(super) struct Markers {
    scheme: MarkerScheme,
    /// Fills: a word for each group. Buffer markers: a word for each pass that has begun, then one for each that is done.
    buffer: Buffer,
    word_count: usize,
    /// First pass of each group.
    groups: Vec<usize>,
    pass_count: usize,
    /// Unlike that of others, whose checkpoints are on the same queue.
    id: u16,
    gpu: Arc<Device>,
}

impl Markers {
    pub fn new(gpu: &Arc<Device>, plan: &Plan, scheme: MarkerScheme) -> Result<Self> {
        static NEXT_ID: AtomicU16 = AtomicU16::new(0);
        let groups = first_passes(plan);
        let pass_count = plan.passes.len();
        let word_count = match scheme {
            MarkerScheme::Fills => groups.len(),
            MarkerScheme::BufferMarkers => 2 * pass_count,
            MarkerScheme::Checkpoints => 0,
        };
        let size_bytes = 4 * word_count.max(1) as u64;
        let mut buffer = Buffer::host(gpu, "crash markers", size_bytes, vk::BufferUsageFlags::TRANSFER_DST)?;
        buffer.mapped_mut().fill(0);
        let id = NEXT_ID.fetch_add(1, Ordering::Relaxed);
        Ok(Self { scheme, buffer, word_count, groups, pass_count, id, gpu: Arc::clone(gpu) })
    }

    /// To be recorded before pass `index` and its barriers, once in a frame of this `stamp`, which is never 0.
    pub fn enter(&self, commands: vk::CommandBuffer, index: usize, stamp: u32) {
        match self.scheme {
            MarkerScheme::Fills => self.fill(commands, index, stamp),
            MarkerScheme::BufferMarkers => {
                self.write(commands, vk::PipelineStageFlags::TOP_OF_PIPE, index, stamp);
            }
            MarkerScheme::Checkpoints => {
                self.gpu.diagnostics.set_checkpoint(commands, self.checkpoint(index, stamp));
            }
        }
    }

    /// To be recorded after pass `index`, once in a frame.
    pub fn leave(&self, commands: vk::CommandBuffer, index: usize, stamp: u32) {
        if self.scheme == MarkerScheme::BufferMarkers {
            self.write(commands, vk::PipelineStageFlags::BOTTOM_OF_PIPE, self.pass_count + index, stamp);
        }
    }

    /// Writes the word of the group that begins with a pass, if one does.
    fn fill(&self, commands: vk::CommandBuffer, index: usize, stamp: u32) {
        let Ok(group) = self.groups.binary_search(&index) else { return };
        let (everything, fill) = (vk::PipelineStageFlags2::ALL_COMMANDS, vk::PipelineStageFlags2::ALL_TRANSFER);
        self.order(commands, everything, fill);
        // SAFETY: recording outside a rendering scope; the word was last written by a frame that has completed.
        unsafe { self.gpu.device.cmd_fill_buffer(commands, self.buffer.raw, 4 * group as u64, 4, stamp) };
        self.order(commands, fill, everything);
    }

    /// An order of execution; nothing is made visible.
    fn order(&self, commands: vk::CommandBuffer, from: vk::PipelineStageFlags2, to: vk::PipelineStageFlags2) {
        let barrier = [vk::MemoryBarrier2::default().src_stage_mask(from).dst_stage_mask(to)];
        let info = vk::DependencyInfo::default().memory_barriers(&barrier);
        // SAFETY: recording outside a rendering scope.
        unsafe { self.gpu.device.cmd_pipeline_barrier2(commands, &info) };
    }

    /// Writes a word once all commands before have passed a stage.
    fn write(&self, commands: vk::CommandBuffer, stage: vk::PipelineStageFlags, word: usize, stamp: u32) {
        let Some(functions) = &self.gpu.diagnostics.buffer_marker else { return };
        // SAFETY: the command buffer records; the word lies within the buffer, which may be a target of transfers, and was
        // last written by a frame that has completed.
        unsafe { functions.cmd_write_buffer_marker(commands, stage, self.buffer.raw, 4 * word as u64, stamp) };
    }

    /// A number for a pass of a frame, unlike all others on the queue. Where pointers have 32 bits, less of it remains.
    fn checkpoint(&self, index: usize, stamp: u32) -> usize {
        ((u64::from(self.id) << 48) | (u64::from(stamp) << 16) | index as u64) as usize
    }

    /// Words of frame `stamp` that have been written.
    pub fn written(&self, stamp: u32) -> usize {
        self.words().filter(|word| *word == stamp).count()
    }

    /// The pass that the first marker stands before.
    pub fn first_marked(&self) -> usize {
        match self.scheme {
            MarkerScheme::Fills => self.groups.first().copied().unwrap_or(self.pass_count),
            MarkerScheme::BufferMarkers | MarkerScheme::Checkpoints => 0,
        }
    }

    /// Passes that the device may have been at in frame `stamp` when it was lost; `None` when it left no marker of it.
    pub fn suspects(&self, stamp: u32) -> Option<Range<usize>> {
        match self.scheme {
            MarkerScheme::Fills => loss::suspects_of_fills(self.words(), stamp, &self.groups, self.pass_count),
            MarkerScheme::BufferMarkers => {
                let words: Vec<u32> = self.words().collect();
                let (begun, done) = words.split_at(self.pass_count);
                loss::suspects_of_buffer_markers(begun, done, stamp)
            }
            MarkerScheme::Checkpoints => {
                let pass_of = |number| (0..self.pass_count).find(|pass| self.checkpoint(*pass, stamp) == number);
                let reached = self.gpu.diagnostics.checkpoints(self.gpu.queue);
                let reached: Vec<_> = reached.into_iter().map(|(stage, number)| (stage, pass_of(number))).collect();
                loss::suspects_of_checkpoints(&reached)
            }
        }
    }

    fn words(&self) -> impl Iterator<Item = u32> {
        let words = self.buffer.mapped().chunks_exact(4).map(|c| u32::from_le_bytes([c[0], c[1], c[2], c[3]]));
        words.take(self.word_count)
    }
}

/// The first pass of each group.
fn first_passes(plan: &Plan) -> Vec<usize> {
    (0..plan.passes.len()).filter(|&index| plan.passes[index].has_batch()).collect()
}
