//! A frame in several submissions, so that none takes as long as a watchdog allows: passes go together as long as their
//! times in the last frame stay below the limit.

use std::ops::Range;

use ash::vk;

use super::check;
use super::executor::Executor;
use super::target::Shown;
use crate::error::Result;
use crate::graph::Use;

impl Executor {
    /// Frames are split into submissions of about this long at most; a pass that takes longer is one of its own. The
    /// first frame, whose times are not known, has a submission for each pass.
    pub fn set_max_submit_ms(&mut self, max_submit_ms: f64) {
        self.max_submit_ms = Some(max_submit_ms);
    }

    /// Passes of the next frame by submission.
    pub(super) fn next_batches(&self) -> Vec<Range<usize>> {
        match self.max_submit_ms {
            Some(limit) => batches(&self.last_ms, self.frame.passes.len(), self.first_in_window(), limit),
            None => std::iter::once(0..self.frame.passes.len()).collect(),
        }
    }

    /// The first pass that uses the acquired image. It and those after it are submitted together: that submission waits
    /// for the image and is what presentation waits for.
    fn first_in_window(&self) -> usize {
        let in_window = |used: &Use| self.frame.graph.resources()[used.resource.index()].lifetime.is_acquired();
        let first = self.frame.graph.passes().iter().position(|pass| pass.uses.iter().any(in_window));
        first.unwrap_or(self.frame.passes.len())
    }

    /// Records the frame and submits all of it but the last batch, which is left in the slot's own command buffer.
    pub(super) fn record_batches(
        &mut self,
        slot: usize,
        stamp: u32,
        frame_data: &[u8],
        mut shown: Option<&mut Shown<'_>>,
    ) -> Result<()> {
        let batches = self.next_batches();
        let buffers = self.batch_buffers(slot, batches.len())?;
        for (index, (batch, commands)) in batches.iter().zip(&buffers).enumerate() {
            self.record_passes(slot, *commands, stamp, batch.clone(), frame_data, &mut shown)?;
            if index + 1 < batches.len() {
                let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(*commands)];
                let info = [vk::SubmitInfo2::default().command_buffer_infos(&buffers)];
                // SAFETY: recorded, and not in use, as the slot is idle; the queue is used from this thread only. Barriers
                // reach back over submissions to the same queue.
                let result = unsafe { self.gpu.device.queue_submit2(self.gpu.queue, &info, vk::Fence::null()) };
                self.explain(slot, u64::from(stamp), check("vkQueueSubmit2", result))?;
            }
        }
        Ok(())
    }

    /// So many command buffers, the slot's own one last.
    fn batch_buffers(&mut self, slot: usize, count: usize) -> Result<Vec<vk::CommandBuffer>> {
        let missing = (count - 1).saturating_sub(self.slots[slot].more_commands.len());
        if missing > 0 {
            let info = vk::CommandBufferAllocateInfo::default()
                .command_pool(self.command_pool)
                .command_buffer_count(missing as u32);
            // SAFETY: the pool is alive, and frees its command buffers.
            let allocated = check("command buffers", unsafe { self.gpu.device.allocate_command_buffers(&info) })?;
            self.slots[slot].more_commands.extend(allocated);
        }
        let slot = &self.slots[slot];
        Ok(slot.more_commands[..count - 1].iter().chain([&slot.commands]).copied().collect())
    }
}

/// Splits `pass_count` passes into runs whose times add up to no more than the limit, where they can; without times, one
/// each. Passes from `together_from` on stay together.
fn batches(pass_ms: &[f64], pass_count: usize, together_from: usize, limit_ms: f64) -> Vec<Range<usize>> {
    let mut batches: Vec<Range<usize>> = Vec::new();
    let mut sum_ms = f64::INFINITY;
    for pass in 0..pass_count {
        let ms = pass_ms.get(pass).copied().unwrap_or(f64::INFINITY);
        match batches.last_mut() {
            Some(batch) if sum_ms + ms <= limit_ms || pass > together_from => {
                batch.end = pass + 1;
                sum_ms += ms;
            }
            _ => {
                batches.push(pass..pass + 1);
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

    #[test]
    fn passes_go_together_up_to_the_limit() {
        assert_eq!(batches(&[1.0, 2.0, 3.0, 4.0], 4, 4, 6.0), [0..3, 3..4]);
        assert_eq!(batches(&[1.0, 2.0, 3.0, 4.0], 4, 4, 100.0), std::slice::from_ref(&(0..4)));
        assert_eq!(batches(&[1.0, 9.0, 1.0, 1.0], 4, 4, 6.0), [0..1, 1..2, 2..4], "a long pass is alone");
    }

    #[test]
    fn passes_in_the_window_stay_together() {
        assert_eq!(batches(&[9.0, 9.0, 1.0, 9.0], 4, 1, 6.0), [0..1, 1..4]);
        assert_eq!(batches(&[], 4, 2, 6.0), [0..1, 1..2, 2..4]);
        assert_eq!(batches(&[1.0, 1.0, 1.0, 9.0], 4, 2, 6.0), std::slice::from_ref(&(0..4)));
    }

    #[test]
    fn without_times_every_pass_is_alone() {
        assert_eq!(batches(&[], 3, 3, 100.0), [0..1, 1..2, 2..3]);
    }

    #[test]
    fn a_frame_without_passes_is_one_submission() {
        assert_eq!(batches(&[], 0, 0, 1.0), std::slice::from_ref(&(0..0)));
    }
}
