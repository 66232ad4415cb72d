//! Where a frame goes when it is shown: an image acquired from a swapchain, and what is drawn over the picture.

use ash::vk;

use crate::error::Result;

/// Frames that may be on the GPU at once.
pub const FRAMES_IN_FLIGHT: usize = 2;

/// Where a frame's pictures go.
pub struct WindowTarget<'a> {
    /// The acquired image.
    pub target: &'a Target,
    /// Part of the image that this frame draws to: x, y, width, height; `None` is all of it.
    pub part_px: Option<[u32; 4]>,
    /// What is drawn over the picture, in the pass that the graph has for it.
    pub overlay: &'a mut Overlay<'a>,
}

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
    /// Width and height.
    #[must_use]
    pub fn size_px(&self) -> [u32; 2] {
        [self.extent.width, self.extent.height]
    }

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
