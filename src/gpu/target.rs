//! Where a frame goes when it is shown: an image acquired from a swapchain, and what is drawn over the picture.

use ash::vk;

use super::executor::Executor;
use super::resources::{Physical, Resources};
use super::transfer;
use super::work::Work;
use crate::error::Result;
use crate::graph::{Graph, ImageInfo, Lifetime, ResourceInfo};

/// Frames that may be on the GPU at once.
pub const FRAMES_IN_FLIGHT: usize = 2;

/// Bytes that one command may write to a buffer.
const UPDATE_BYTES: usize = 65_536;

/// Draws into the image that is about to be shown, inside a rendering scope of the size given.
pub type Overlay<'a> = dyn FnMut(vk::CommandBuffer, vk::Extent2D) -> Result<()> + 'a;

/// An image acquired from a swapchain.
#[derive(Debug)]
pub struct Target {
    #[cfg_attr(not(feature = "window"), expect(dead_code, reason = "only a window asks for it"))]
    pub(super) index: u32,
    pub(super) image: vk::Image,
    pub(super) view: vk::ImageView,
    pub(super) extent: vk::Extent2D,
    /// Signalled when the image may be drawn to.
    pub(super) acquired: vk::Semaphore,
    /// To be signalled when it is drawn.
    pub(super) drawn: vk::Semaphore,
}

impl Target {
    /// The stage is that of `Lifetime::Acquired`.
    pub(super) fn wait_info(&self) -> vk::SemaphoreSubmitInfo<'static> {
        vk::SemaphoreSubmitInfo::default()
            .semaphore(self.acquired)
            .stage_mask(vk::PipelineStageFlags2::COLOR_ATTACHMENT_OUTPUT)
    }

    pub(super) fn signal_info(&self) -> vk::SemaphoreSubmitInfo<'static> {
        vk::SemaphoreSubmitInfo::default().semaphore(self.drawn).stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
    }
}

impl Resources {
    /// Puts the image of this frame in the place of the graph's acquired one, or takes it out again.
    pub(super) fn acquired(&mut self, graph: &Graph<Work>, target: Option<&Target>) {
        for (physical, resource) in self.list.iter_mut().zip(graph.resources()) {
            if let (Lifetime::Acquired, ResourceInfo::Image(info)) = (resource.lifetime, resource.info) {
                *physical = target.map_or_else(
                    || Physical::unacquired(info),
                    |target| Physical::Image {
                        raw: target.image,
                        view: target.view,
                        info: ImageInfo { width_px: target.extent.width, height_px: target.extent.height, ..info },
                    },
                );
            }
        }
    }
}

impl Executor {
    /// Writes the start of the scene's lights with the next frame, after what earlier frames read of them. No more
    /// than [`UPDATE_BYTES`] are taken.
    pub fn update_lights(&mut self, mut bytes: Vec<u8>) {
        bytes.truncate(UPDATE_BYTES);
        self.light_update = Some(bytes);
    }

    pub(super) fn record_scene_update(&self, commands: vk::CommandBuffer) {
        let (Some(bytes), Some(scene)) = (&self.light_update, &self.scene) else { return };
        transfer::full_barrier(&self.gpu, commands);
        // SAFETY: the lights' buffer is a transfer destination and larger than what is written to it.
        unsafe { self.gpu.device.cmd_update_buffer(commands, scene.lights().raw, 0, bytes) };
        transfer::full_barrier(&self.gpu, commands);
    }
}
