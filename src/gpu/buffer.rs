//! Buffers with their memory.

use std::sync::Arc;

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};

use super::check;
use super::device::Device;
use crate::error::{Error, Result};

/// A buffer that owns its memory.
pub struct Buffer {
    pub(super) raw: vk::Buffer,
    /// Size in bytes.
    pub size_bytes: u64,
    allocation: Option<Allocation>,
    gpu: Arc<Device>,
}

impl Buffer {
    /// Creates a device-local buffer.
    ///
    /// # Errors
    /// [`Error::Memory`] when there is no memory for it.
    pub fn new(gpu: &Arc<Device>, name: &str, size_bytes: u64, usage: vk::BufferUsageFlags) -> Result<Self> {
        Self::with_location(gpu, name, size_bytes, usage, MemoryLocation::GpuOnly)
    }

    /// Creates a buffer the host can read and write through [`Buffer::mapped`].
    ///
    /// # Errors
    /// [`Error::Memory`] when there is no memory for it.
    pub(super) fn host(gpu: &Arc<Device>, name: &str, size_bytes: u64, usage: vk::BufferUsageFlags) -> Result<Self> {
        Self::with_location(gpu, name, size_bytes, usage, MemoryLocation::GpuToCpu)
    }

    fn with_location(
        gpu: &Arc<Device>,
        name: &str,
        size_bytes: u64,
        usage: vk::BufferUsageFlags,
        location: MemoryLocation,
    ) -> Result<Self> {
        let info = vk::BufferCreateInfo::default().size(size_bytes.max(4)).usage(usage);
        // SAFETY: valid create info; the buffer is destroyed in `drop`.
        let raw = check(name, unsafe { gpu.device.create_buffer(&info, None) })?;
        gpu.set_name(raw, name);
        // SAFETY: `raw` was just created on this device.
        let requirements = unsafe { gpu.device.get_buffer_memory_requirements(raw) };
        let mut buffer = Self { raw, size_bytes: size_bytes.max(4), allocation: None, gpu: Arc::clone(gpu) };
        let allocation = gpu
            .allocator()
            .allocate(&AllocationCreateDesc {
                name,
                requirements,
                location,
                linear: true,
                allocation_scheme: AllocationScheme::GpuAllocatorManaged,
            })
            .map_err(|e| Error::Memory { name: format!("{name} ({size_bytes} bytes)"), reason: e.to_string() })?;
        // SAFETY: the allocation fits the requirements queried above and lives as long as the buffer.
        let bound = unsafe { gpu.device.bind_buffer_memory(raw, allocation.memory(), allocation.offset()) };
        buffer.allocation = Some(allocation);
        check(name, bound)?;
        Ok(buffer)
    }

    /// The contents, for host buffers.
    #[must_use]
    pub fn mapped(&self) -> &[u8] {
        let size = usize::try_from(self.size_bytes).unwrap_or(usize::MAX);
        self.allocation.as_ref().and_then(Allocation::mapped_slice).map_or(&[], |s| &s[..size.min(s.len())])
    }

    /// The contents, for host buffers.
    pub fn mapped_mut(&mut self) -> &mut [u8] {
        self.allocation.as_mut().and_then(Allocation::mapped_slice_mut).unwrap_or(&mut [])
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        // SAFETY: owners wait for the GPU before they drop buffers in use.
        unsafe { self.gpu.device.destroy_buffer(self.raw, None) };
        if let Some(allocation) = self.allocation.take()
            && let Err(error) = self.gpu.allocator().free(allocation)
        {
            log::error!("freeing a buffer's memory: {error}");
        }
    }
}
