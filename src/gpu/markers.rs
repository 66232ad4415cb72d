//! Crash markers: host-visible words that the device writes on its way through a frame, so that after its loss the passes
//! it was at can be named, on any driver.
//!
//! There is a word for each group of passes, that is for each batch of barriers of the plan: passes between two batches do
//! not depend on each other and may overlap. A group's word is written when everything before it has completed, and nothing
//! of the group begins before.

use std::ops::Range;
use std::sync::Arc;

use ash::vk;

use super::buffer::Buffer;
use super::device::Device;
use crate::error::Result;
use crate::graph::Plan;

/// The marker words of one frame in flight.
pub(super) struct Markers {
    buffer: Buffer,
    /// First pass of each group that has a word.
    groups: Vec<usize>,
    pass_count: usize,
    gpu: Arc<Device>,
}

impl Markers {
    pub fn new(gpu: &Arc<Device>, plan: &Plan) -> Result<Self> {
        let groups = first_passes(plan);
        let size_bytes = 4 * groups.len() as u64;
        let mut buffer = Buffer::host(gpu, "crash markers", size_bytes, vk::BufferUsageFlags::TRANSFER_DST)?;
        buffer.mapped_mut().fill(0);
        Ok(Self { buffer, groups, pass_count: plan.passes.len(), gpu: Arc::clone(gpu) })
    }

    /// To be recorded before pass `index` and its barriers, once in a frame: writes `stamp`, which is never 0, to the word
    /// of the group that begins with it.
    pub fn enter(&self, commands: vk::CommandBuffer, index: usize, stamp: u32) {
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

    /// Groups of frame `stamp` whose words have been written.
    pub fn written(&self, stamp: u32) -> usize {
        self.words().filter(|word| *word == stamp).count()
    }

    /// The pass that the first word is written before.
    pub fn first_group(&self) -> usize {
        self.groups.first().copied().unwrap_or(self.pass_count)
    }

    /// Passes that the device may have been at in frame `stamp`; `None` when it wrote no word of it.
    pub fn suspects(&self, stamp: u32) -> Option<Range<usize>> {
        suspects(self.words(), stamp, &self.groups, self.pass_count)
    }

    fn words(&self) -> impl Iterator<Item = u32> {
        let words = self.buffer.mapped().chunks_exact(4).map(|c| u32::from_le_bytes([c[0], c[1], c[2], c[3]]));
        words.take(self.groups.len())
    }
}

/// The first pass of each group.
fn first_passes(plan: &Plan) -> Vec<usize> {
    (0..plan.passes.len()).filter(|&index| plan.passes[index].has_batch()).collect()
}

/// The passes of the last group that has begun. Words are written in order, each when all before it is done.
fn suspects(words: impl Iterator<Item = u32>, stamp: u32, groups: &[usize], pass_count: usize) -> Option<Range<usize>> {
    let begun = words.take_while(|word| *word == stamp).count();
    let first = *groups[..begun].last()?;
    Some(first..groups.get(begun).copied().unwrap_or(pass_count))
}

/// Where the device was lost, as it reads after "the device was lost". Once the last passes have begun, nothing tells
/// whether they are over.
pub(super) fn place(names: &[&str], suspects: Range<usize>) -> String {
    let quoted: Vec<String> = names[suspects.clone()].iter().map(|name| format!("`{name}`")).collect();
    let place = match quoted.as_slice() {
        [] => return "before the first pass of a frame".to_owned(),
        [one] => format!("in pass {one}"),
        several => format!("in one of the passes {}", several.join(", ")),
    };
    if suspects.end == names.len() { format!("{place} or after the frame") } else { place }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Groups of the passes 1, 2 to 4, and 5; nothing waits before pass 0.
    const GROUPS: [usize; 3] = [1, 2, 5];
    const NAMES: [&str; 6] = ["a", "b", "c", "d", "e", "f"];

    fn lost(words: [u32; 3]) -> Option<String> {
        Some(place(&NAMES, suspects(words.into_iter(), 7, &GROUPS, NAMES.len())?))
    }

    #[test]
    fn the_last_group_that_began_is_named() {
        assert_eq!(lost([7, 0, 0]).unwrap(), "in pass `b`");
        assert_eq!(lost([7, 7, 0]).unwrap(), "in one of the passes `c`, `d`, `e`");
        assert_eq!(lost([7, 7, 7]).unwrap(), "in pass `f` or after the frame");
    }

    #[test]
    fn words_of_other_frames_say_nothing() {
        assert_eq!(lost([5, 5, 5]), None);
        assert_eq!(lost([7, 5, 5]).unwrap(), "in pass `b`");
        assert_eq!(lost([5, 7, 7]), None, "words are written in order");
    }

    #[test]
    fn passes_before_the_first_word_can_be_named_too() {
        assert_eq!(place(&NAMES, 0..1), "in pass `a`");
        assert_eq!(place(&NAMES, 0..0), "before the first pass of a frame");
    }
}
