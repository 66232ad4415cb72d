//! Draws the panel's triangles: egui on the device of the renderer, with memory from the same allocator.

use std::mem::ManuallyDrop;
use std::sync::Arc;

use ash::vk;
use egui_ash_renderer::allocator::GpuAllocator;
use egui_ash_renderer::{DynamicRendering, Options, RenderMode, Renderer, RendererError};

use super::check;
use super::device::Device;
use super::swapchain::is_srgb;
use super::target::FRAMES_IN_FLIGHT;
use crate::error::{Error, Result};

/// What the panel looks like in one frame.
#[derive(Default)]
pub struct PanelPicture {
    /// Triangles in the order in which they are drawn.
    pub primitives: Vec<egui::ClippedPrimitive>,
    /// Textures that are new or changed, and those no longer used.
    pub textures: egui::TexturesDelta,
    /// Physical pixels in a point of the panel.
    pub pixels_per_point: f32,
}

/// Pipeline, textures and vertex buffers of the panel.
pub struct PanelPainter {
    renderer: ManuallyDrop<Renderer<GpuAllocator>>,
    command_pool: vk::CommandPool,
    /// Textures that the last picture may still have used.
    retired: Vec<egui::TextureId>,
    gpu: Arc<Device>,
}

impl PanelPainter {
    /// For images of a swapchain's format.
    ///
    /// # Errors
    /// When the device has no memory.
    pub fn new(gpu: &Arc<Device>, format: vk::Format) -> Result<Self> {
        let info = vk::CommandPoolCreateInfo::default()
            .flags(vk::CommandPoolCreateFlags::TRANSIENT)
            .queue_family_index(gpu.queue_family);
        let mode = RenderMode::DynamicRendering(DynamicRendering {
            color_attachment_format: format,
            depth_attachment_format: None,
            stencil_attachment_format: None,
        });
        let options =
            Options { in_flight_frames: FRAMES_IN_FLIGHT, srgb_framebuffer: is_srgb(format), ..Options::default() };
        let renderer = Renderer::with_gpu_allocator(Arc::clone(&gpu.allocator), gpu.device.clone(), mode, options);
        let renderer = ManuallyDrop::new(renderer.map_err(|error| explain(&error))?);
        // SAFETY: valid create info; destroyed in `drop`.
        let command_pool = unsafe { gpu.device.create_command_pool(&info, None) };
        let mut painter =
            Self { renderer, command_pool: vk::CommandPool::null(), retired: Vec::new(), gpu: Arc::clone(gpu) };
        painter.command_pool = check("the panel's command pool", command_pool)?;
        Ok(painter)
    }

    /// Takes over textures that are new or changed. Waits for the GPU when there are any, which is when the panel
    /// first shows a character.
    ///
    /// # Errors
    /// When the device is lost or has no memory.
    pub fn update_textures(&mut self, textures: &egui::TexturesDelta) -> Result<()> {
        if textures.is_empty() && self.retired.is_empty() {
            return Ok(());
        }
        self.gpu.wait_idle()?;
        for id in self.retired.drain(..) {
            self.renderer.free_texture(id).map_err(|error| explain(&error))?;
        }
        let _queue = self.gpu.lock_queue();
        for (id, deltas) in &textures.set {
            for delta in deltas {
                let set = self.renderer.set_texture(self.gpu.queue, self.command_pool, *id, delta);
                set.map_err(|error| explain(&error))?;
            }
        }
        self.retired.extend(&textures.free);
        Ok(())
    }

    /// Draws inside a rendering scope.
    ///
    /// # Errors
    /// When the device has no memory for the vertices.
    pub fn draw(&mut self, commands: vk::CommandBuffer, extent: vk::Extent2D, picture: &PanelPicture) -> Result<()> {
        let drawn = self.renderer.cmd_draw(commands, extent, picture.pixels_per_point, &picture.primitives);
        drawn.map_err(|error| explain(&error))
    }
}

fn explain(error: &RendererError) -> Error {
    match error {
        RendererError::Vulkan(result) => Error::Vulkan { what: "the panel".to_owned(), result: *result },
        error => Error::Failure(format!("the panel cannot be drawn: {error}")),
    }
}

impl Drop for PanelPainter {
    fn drop(&mut self) {
        if let Err(error) = self.gpu.wait_idle() {
            log::error!("waiting for the GPU: {error}");
        }
        // SAFETY: the GPU is idle; the renderer is dropped once, before the device and its allocator.
        unsafe {
            ManuallyDrop::drop(&mut self.renderer);
            self.gpu.device.destroy_command_pool(self.command_pool, None);
        }
    }
}
