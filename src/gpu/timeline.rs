//! Submissions to the queue, each with a number that the timeline reaches when it has completed.

use std::cell::Cell;
use std::sync::Arc;

use ash::vk;

use super::check;
use super::device::Device;
use crate::error::Result;

/// Numbered submissions of one executor.
pub(super) struct Timeline {
    semaphore: vk::Semaphore,
    last: Cell<u64>,
    gpu: Arc<Device>,
}

impl Timeline {
    pub fn new(gpu: &Arc<Device>) -> Result<Self> {
        let mut kind = vk::SemaphoreTypeCreateInfo::default().semaphore_type(vk::SemaphoreType::TIMELINE);
        let info = vk::SemaphoreCreateInfo::default().push_next(&mut kind);
        // SAFETY: timeline semaphores are required by the baseline; destroyed in `drop`.
        let semaphore = check("the timeline", unsafe { gpu.device.create_semaphore(&info, None) })?;
        gpu.set_name(semaphore, "submissions");
        Ok(Self { semaphore, last: Cell::new(0), gpu: Arc::clone(gpu) })
    }

    /// Number of the last submission; 0 before the first.
    pub fn last(&self) -> u64 {
        self.last.get()
    }

    /// Submits recorded commands; the number of the submission.
    pub fn submit(
        &self,
        commands: vk::CommandBuffer,
        waits: &[vk::SemaphoreSubmitInfo<'_>],
        signals: &[vk::SemaphoreSubmitInfo<'_>],
    ) -> Result<u64> {
        let number = self.last.get() + 1;
        let commands = [vk::CommandBufferSubmitInfo::default().command_buffer(commands)];
        let completed = vk::SemaphoreSubmitInfo::default()
            .semaphore(self.semaphore)
            .value(number)
            .stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS);
        let signals = [&[completed], signals].concat();
        let info = [vk::SubmitInfo2::default()
            .wait_semaphore_infos(waits)
            .command_buffer_infos(&commands)
            .signal_semaphore_infos(&signals)];
        let _queue = self.gpu.lock_queue();
        // SAFETY: the command buffer is recorded and not in use; nobody else uses the queue meanwhile.
        let result = unsafe { self.gpu.device.queue_submit2(self.gpu.queue, &info, vk::Fence::null()) };
        check("vkQueueSubmit2", result)?;
        self.last.set(number);
        Ok(number)
    }

    /// Whether a submission has completed.
    pub fn has_reached(&self, number: u64) -> Result<bool> {
        // SAFETY: the semaphore is a timeline of this device.
        let value = unsafe { self.gpu.device.get_semaphore_counter_value(self.semaphore) };
        Ok(check("vkGetSemaphoreCounterValue", value)? >= number)
    }

    /// Waits for a submission to complete.
    pub fn wait(&self, number: u64) -> Result<()> {
        let semaphores = [self.semaphore];
        let values = [number];
        let info = vk::SemaphoreWaitInfo::default().semaphores(&semaphores).values(&values);
        // SAFETY: the semaphore is a timeline of this device.
        check("vkWaitSemaphores", unsafe { self.gpu.device.wait_semaphores(&info, u64::MAX) })
    }
}

impl Drop for Timeline {
    fn drop(&mut self) {
        // SAFETY: the executor waits for the GPU before it drops its timeline.
        unsafe { self.gpu.device.destroy_semaphore(self.semaphore, None) };
    }
}
