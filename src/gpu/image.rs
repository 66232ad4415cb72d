//! Images with their memory: the scene's textures (the frame's images belong to the executor).

use std::sync::Arc;

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};

use super::check;
use super::device::Device;
use crate::error::{Error, Result};

/// A sampled image that owns its memory, with a view of all of it.
pub struct Image {
    pub(super) raw: vk::Image,
    pub(super) view: vk::ImageView,
    allocation: Option<Allocation>,
    gpu: Arc<Device>,
}

/// Shape of a sampled image.
#[derive(Clone, Copy, Debug)]
pub struct TextureInfo {
    /// Texel format.
    pub format: vk::Format,
    /// Width in texels.
    pub width_px: u32,
    /// Height in texels.
    pub height_px: u32,
    /// Mip levels.
    pub mips: u32,
    /// Array layers.
    pub layers: u32,
    /// Whether the view is an array view.
    pub array: bool,
    /// Usage besides being uploaded and sampled.
    pub other_usage: vk::ImageUsageFlags,
}

impl Image {
    /// Creates a texture: transfer destination and sampled.
    ///
    /// # Errors
    /// [`Error::Memory`] when there is no memory for it.
    pub fn texture(gpu: &Arc<Device>, name: &str, info: TextureInfo) -> Result<Self> {
        let create = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(info.format)
            .extent(vk::Extent3D { width: info.width_px, height: info.height_px, depth: 1 })
            .mip_levels(info.mips)
            .array_layers(info.layers)
            .samples(vk::SampleCountFlags::TYPE_1)
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(vk::ImageUsageFlags::TRANSFER_DST | vk::ImageUsageFlags::SAMPLED | info.other_usage);
        // SAFETY: valid create info within the device's limits; destroyed in `drop`.
        let raw = check(name, unsafe { gpu.device.create_image(&create, None) })?;
        gpu.set_name(raw, name);
        let mut image = Self { raw, view: vk::ImageView::null(), allocation: None, gpu: Arc::clone(gpu) };
        image.bind(name)?;
        image.view = create_view(gpu, name, raw, &info)?;
        Ok(image)
    }

    fn bind(&mut self, name: &str) -> Result<()> {
        // SAFETY: the image belongs to this device.
        let requirements = unsafe { self.gpu.device.get_image_memory_requirements(self.raw) };
        let desc = AllocationCreateDesc {
            name,
            requirements,
            location: MemoryLocation::GpuOnly,
            linear: false,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        };
        let allocation = self
            .gpu
            .allocator()
            .allocate(&desc)
            .map_err(|e| Error::Memory { name: name.to_owned(), reason: e.to_string() })?;
        // SAFETY: the allocation fits the requirements and lives as long as the image.
        let bound = unsafe { self.gpu.device.bind_image_memory(self.raw, allocation.memory(), allocation.offset()) };
        self.allocation = Some(allocation);
        check(name, bound)
    }
}

fn create_view(gpu: &Device, name: &str, raw: vk::Image, info: &TextureInfo) -> Result<vk::ImageView> {
    let view = vk::ImageViewCreateInfo::default()
        .image(raw)
        .view_type(if info.array { vk::ImageViewType::TYPE_2D_ARRAY } else { vk::ImageViewType::TYPE_2D })
        .format(info.format)
        .subresource_range(vk::ImageSubresourceRange {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            base_mip_level: 0,
            level_count: info.mips,
            base_array_layer: 0,
            layer_count: info.layers,
        });
    // SAFETY: the image is alive and bound; the view is destroyed before it.
    check(name, unsafe { gpu.device.create_image_view(&view, None) })
}

impl Drop for Image {
    fn drop(&mut self) {
        // SAFETY: owners wait for the GPU before they drop images in use; a null view is ignored.
        unsafe {
            self.gpu.device.destroy_image_view(self.view, None);
            self.gpu.device.destroy_image(self.raw, None);
        }
        if let Some(allocation) = self.allocation.take()
            && let Err(error) = self.gpu.allocator().free(allocation)
        {
            log::error!("freeing an image's memory: {error}");
        }
    }
}
