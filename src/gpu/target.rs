//! Where a frame goes when it is shown: an image acquired from a swapchain, and what is drawn over the picture.

use ash::vk;

use super::executor::{Executor, FrameTicket};
use super::resources::{Physical, Resources};
use super::transfer;
use super::work::Work;
use crate::error::Result;
use crate::graph::{Access, Graph, ImageInfo, Lifetime, ResourceInfo};

/// Frames that may be on the GPU at once.
pub const FRAMES_IN_FLIGHT: usize = 2;

/// Bytes that one command may write to a buffer.
const UPDATE_BYTES: usize = 65_536;

/// Where a frame's pictures go.
pub struct Shown<'a> {
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

impl Resources {
    /// Puts the image of this frame in the place of the graph's acquired one, or takes it out again.
    pub(super) fn acquired(&mut self, graph: &Graph<Work>, shown: Option<&Shown<'_>>) {
        self.shown_part_px = shown.and_then(|shown| shown.part_px);
        for (physical, resource) in self.list.iter_mut().zip(graph.resources()) {
            if let (true, ResourceInfo::Image(info)) = (resource.lifetime.is_acquired(), resource.info) {
                *physical = shown.map_or_else(
                    || Physical::unacquired(info),
                    |Shown { target, .. }| Physical::Image {
                        raw: target.image,
                        view: target.view,
                        info: ImageInfo { width_px: target.extent.width, height_px: target.extent.height, ..info },
                    },
                );
            }
        }
    }
}

/// Semaphores of a submission.
pub(super) type Semaphores = Vec<vk::SemaphoreSubmitInfo<'static>>;

impl Executor {
    /// Records and submits one frame into an acquired image. Blocks only when both frames in flight are still busy.
    ///
    /// # Errors
    /// When the device is lost, and those of the overlay.
    pub fn submit_to(&mut self, frame_data: &[u8], shown: &mut Shown<'_>) -> Result<FrameTicket> {
        self.resources.acquired(&self.graph, Some(shown));
        let submitted = self.submit_frame(frame_data, Some(shown));
        self.resources.acquired(&self.graph, None);
        submitted
    }

    /// What a frame waits for and what it signals: the graph that takes the image first waits for it, and the one that
    /// leaves it ready to be shown says so.
    pub(super) fn window_semaphores(&self, shown: &Shown<'_>) -> (Semaphores, Semaphores) {
        let begins = self.graph.resources().iter().any(|resource| resource.lifetime == Lifetime::Acquired);
        let mut uses = self.graph.passes().iter().flat_map(|pass| &pass.uses);
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
        let (Some(bytes), Some(scene)) = (&self.light_update, &self.scene) else { return };
        transfer::full_barrier(&self.gpu, commands);
        // SAFETY: the lights' buffer is a transfer destination and larger than what is written to it.
        unsafe { self.gpu.device.cmd_update_buffer(commands, scene.lights().raw, 0, bytes) };
        transfer::full_barrier(&self.gpu, commands);
    }
}
