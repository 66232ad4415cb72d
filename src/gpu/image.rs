//! Images with their memory: the scene's textures (the frame's images belong to the executor).

use std::sync::Arc;

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};

use super::check;
use super::device::Device;
use super::physical::{image_create_info, view_create_info};
use crate::error::{Error, Result};
use crate::graph::ImageInfo;

/// A sampled image that owns its memory, with a view of all of it.
pub struct Image {
    pub(super) raw: vk::Image,
    pub(super) view: vk::ImageView,
    allocation: Option<Allocation>,
    gpu: Arc<Device>,
}

impl Image {
    /// Creates a texture: transfer destination, sampled, and what else it is used for.
    ///
    /// # Errors
    /// [`Error::Memory`] when there is no memory for it.
    pub fn texture(gpu: &Arc<Device>, name: &str, info: &ImageInfo, other_usage: vk::ImageUsageFlags) -> Result<Self> {
        let usage = vk::ImageUsageFlags::TRANSFER_DST | vk::ImageUsageFlags::SAMPLED | other_usage;
        let create = image_create_info(info, usage);
        // SAFETY: valid create info within the device's limits; destroyed in `drop`.
        let raw = check(name, unsafe { gpu.device.create_image(&create, None) })?;
        gpu.set_name(raw, name);
        let mut image = Self { raw, view: vk::ImageView::null(), allocation: None, gpu: Arc::clone(gpu) };
        image.bind(name)?;
        let view = view_create_info(raw, info, 0..info.level_count);
        // SAFETY: the image is alive and bound; the view is destroyed before it.
        image.view = check(name, unsafe { gpu.device.create_image_view(&view, None) })?;
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
