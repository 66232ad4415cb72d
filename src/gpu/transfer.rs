//! Uploads and downloads outside frames: scene data before the first frame, results after the last.

use std::sync::Arc;

use ash::vk;

use super::buffer::Buffer;
use super::check;
use super::device::Device;
use super::image::Image;
use super::physical::{image_levels, texel_bytes};
use crate::error::{Error, Result};
use crate::graph::ImageInfo;

/// Bytes staged at a time when a buffer is uploaded.
const STAGING_BYTES: usize = 32 << 20;

/// All levels and layers of an image with colours.
const WHOLE_COLOR_IMAGE: vk::ImageSubresourceRange = vk::ImageSubresourceRange {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    base_mip_level: 0,
    level_count: vk::REMAINING_MIP_LEVELS,
    base_array_layer: 0,
    layer_count: vk::REMAINING_ARRAY_LAYERS,
};

/// Records commands with `record`, submits them and waits.
pub(super) fn submit_once(gpu: &Arc<Device>, record: impl FnOnce(vk::CommandBuffer)) -> Result<()> {
    let info = vk::CommandPoolCreateInfo::default()
        .flags(vk::CommandPoolCreateFlags::TRANSIENT)
        .queue_family_index(gpu.queue_family);
    // SAFETY: valid create info; destroyed below after the wait.
    let pool = check("a command pool", unsafe { gpu.device.create_command_pool(&info, None) })?;
    let result = submit_from(gpu, pool, record);
    // SAFETY: `submit_from` has waited for the queue, or submission failed.
    unsafe { gpu.device.destroy_command_pool(pool, None) };
    result
}

fn submit_from(gpu: &Arc<Device>, pool: vk::CommandPool, record: impl FnOnce(vk::CommandBuffer)) -> Result<()> {
    let info = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
    let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
    // SAFETY: the pool belongs to this device and this thread, and nobody else uses the queue meanwhile; the wait keeps
    // everything alive.
    unsafe {
        let commands = check("a command buffer", gpu.device.allocate_command_buffers(&info))?[0];
        check("vkBeginCommandBuffer", gpu.device.begin_command_buffer(commands, &begin))?;
        record(commands);
        check("vkEndCommandBuffer", gpu.device.end_command_buffer(commands))?;
        let commands = [vk::CommandBufferSubmitInfo::default().command_buffer(commands)];
        let submit = [vk::SubmitInfo2::default().command_buffer_infos(&commands)];
        let _queue = gpu.lock_queue();
        check("vkQueueSubmit2", gpu.device.queue_submit2(gpu.queue, &submit, vk::Fence::null()))?;
        check("vkQueueWaitIdle", gpu.device.queue_wait_idle(gpu.queue))
    }
}

/// A barrier that makes everything before visible to everything after.
pub(super) fn full_barrier(gpu: &Device, commands: vk::CommandBuffer) {
    let barrier = [vk::MemoryBarrier2::default()
        .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
        .src_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE)
        .dst_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS | vk::PipelineStageFlags2::HOST)
        .dst_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE | vk::AccessFlags2::HOST_READ)];
    let info = vk::DependencyInfo::default().memory_barriers(&barrier);
    // SAFETY: recording outside a rendering scope.
    unsafe { gpu.device.cmd_pipeline_barrier2(commands, &info) };
}

/// Changes the layout of a part of an image, waiting for everything before.
pub(super) fn image_layout(
    gpu: &Device,
    commands: vk::CommandBuffer,
    image: vk::Image,
    part: vk::ImageSubresourceRange,
    old: vk::ImageLayout,
    new: vk::ImageLayout,
) {
    let barrier = [vk::ImageMemoryBarrier2::default()
        .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
        .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
        .dst_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
        .dst_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE)
        .old_layout(old)
        .new_layout(new)
        .image(image)
        .subresource_range(part)];
    let info = vk::DependencyInfo::default().image_memory_barriers(&barrier);
    // SAFETY: recording outside a rendering scope; the image is alive.
    unsafe { gpu.device.cmd_pipeline_barrier2(commands, &info) };
}

/// Copies `bytes` to the start of `target`.
pub(super) fn upload_buffer(gpu: &Arc<Device>, target: &Buffer, bytes: &[u8]) -> Result<()> {
    upload_raw(gpu, target.raw, bytes)
}

/// Copies `bytes` to the start of a buffer that is at least that large and a transfer destination.
pub(super) fn upload_raw(gpu: &Arc<Device>, target: vk::Buffer, bytes: &[u8]) -> Result<()> {
    let size = bytes.len().clamp(4, STAGING_BYTES);
    let mut staging = Buffer::host(gpu, "staging", size as u64, vk::BufferUsageFlags::TRANSFER_SRC)?;
    for (index, chunk) in bytes.chunks(STAGING_BYTES).enumerate() {
        staging.mapped_mut()[..chunk.len()].copy_from_slice(chunk);
        let region =
            [vk::BufferCopy { src_offset: 0, dst_offset: (index * STAGING_BYTES) as u64, size: chunk.len() as u64 }];
        submit_once(gpu, |commands| {
            // Frames before this one may have read what is replaced.
            full_barrier(gpu, commands);
            // SAFETY: both buffers are alive and large enough.
            unsafe { gpu.device.cmd_copy_buffer(commands, staging.raw, target, &region) };
            full_barrier(gpu, commands);
        })?;
    }
    Ok(())
}

/// Copies a buffer to another one of its size, both with the usages of [`storage_buffer`].
pub(super) fn copy_buffer(gpu: &Arc<Device>, source: &Buffer, target: &Buffer) -> Result<()> {
    let region = [vk::BufferCopy { src_offset: 0, dst_offset: 0, size: source.size_bytes.min(target.size_bytes) }];
    submit_once(gpu, |commands| {
        // Frames before this one may have read what is replaced.
        full_barrier(gpu, commands);
        // SAFETY: both buffers are alive and large enough.
        unsafe { gpu.device.cmd_copy_buffer(commands, source.raw, target.raw, &region) };
        full_barrier(gpu, commands);
    })
}

/// Every storage buffer holds at least so much.
const LEAST_BYTES: usize = 64;

/// A storage buffer of the scene with these contents.
///
/// # Errors
/// [`Error::Failure`] when they exceed the device's storage buffer range; [`Error::Memory`].
pub(super) fn storage_buffer(
    gpu: &Arc<Device>,
    name: &str,
    bytes: &[u8],
    usage: vk::BufferUsageFlags,
) -> Result<Buffer> {
    let limit = gpu.report().limits.storage_range_bytes;
    if bytes.len() as u64 > limit {
        return Err(Error::Failure(format!(
            "the scene is too large for this device: {name} take {} MiB, a storage buffer holds {} MiB",
            bytes.len() >> 20,
            limit >> 20
        )));
    }
    // Any of them may be read back for a dump.
    let usage = usage | vk::BufferUsageFlags::TRANSFER_SRC | vk::BufferUsageFlags::TRANSFER_DST;
    let buffer = Buffer::new(gpu, name, bytes.len().max(LEAST_BYTES) as u64, usage)?;
    if bytes.len() < LEAST_BYTES {
        // The rest reads as zeros: a scene without lights has one that is black.
        upload_buffer(gpu, &buffer, &[bytes, &[0; LEAST_BYTES][bytes.len()..]].concat())?;
    } else {
        upload_buffer(gpu, &buffer, bytes)?;
    }
    Ok(buffer)
}

/// One subresource of an image upload: mip level, array layer, width, height, texels.
pub(super) struct Subresource<'a> {
    pub mip: u32,
    pub layer: u32,
    pub width_px: u32,
    pub height_px: u32,
    pub texels: &'a [u8],
}

/// Fills a texture and leaves it in `SHADER_READ_ONLY_OPTIMAL`.
pub(super) fn upload_image(gpu: &Arc<Device>, image: &Image, parts: &[Subresource<'_>]) -> Result<()> {
    upload_raw_image(gpu, image.raw, parts, vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL)
}

/// Fills an image that is a transfer destination, whatever it holds, and leaves it in this layout.
pub(super) fn upload_raw_image(
    gpu: &Arc<Device>,
    image: vk::Image,
    parts: &[Subresource<'_>],
    left_in: vk::ImageLayout,
) -> Result<()> {
    let size: usize = parts.iter().map(|p| p.texels.len()).sum();
    let mut staging = Buffer::host(gpu, "staging", size as u64, vk::BufferUsageFlags::TRANSFER_SRC)?;
    let mut offset = 0;
    let mut regions = Vec::with_capacity(parts.len());
    for part in parts {
        staging.mapped_mut()[offset..offset + part.texels.len()].copy_from_slice(part.texels);
        regions.push(
            vk::BufferImageCopy::default()
                .buffer_offset(offset as u64)
                .image_subresource(vk::ImageSubresourceLayers {
                    aspect_mask: vk::ImageAspectFlags::COLOR,
                    mip_level: part.mip,
                    base_array_layer: part.layer,
                    layer_count: 1,
                })
                .image_extent(vk::Extent3D { width: part.width_px, height: part.height_px, depth: 1 }),
        );
        offset += part.texels.len();
    }
    submit_once(gpu, |commands| {
        let layout = |old, new| {
            image_layout(gpu, commands, image, WHOLE_COLOR_IMAGE, old, new);
        };
        layout(vk::ImageLayout::UNDEFINED, vk::ImageLayout::TRANSFER_DST_OPTIMAL);
        // SAFETY: the staging buffer holds every region; the image is in the layout named.
        unsafe {
            gpu.device.cmd_copy_buffer_to_image(
                commands,
                staging.raw,
                image,
                vk::ImageLayout::TRANSFER_DST_OPTIMAL,
                &regions,
            );
        }
        layout(vk::ImageLayout::TRANSFER_DST_OPTIMAL, left_in);
    })
}

/// Reads `size_bytes` from the start of a buffer.
pub(super) fn download_buffer(gpu: &Arc<Device>, source: vk::Buffer, size_bytes: u64) -> Result<Vec<u8>> {
    let staging = Buffer::host(gpu, "readback", size_bytes, vk::BufferUsageFlags::TRANSFER_DST)?;
    let region = [vk::BufferCopy { src_offset: 0, dst_offset: 0, size: size_bytes }];
    submit_once(gpu, |commands| {
        full_barrier(gpu, commands);
        // SAFETY: both buffers are alive and large enough.
        unsafe { gpu.device.cmd_copy_buffer(commands, source, staging.raw, &region) };
        full_barrier(gpu, commands);
    })?;
    Ok(staging.mapped()[..size_bytes as usize].to_vec())
}

/// Reads one level of an image, which is in `layout` and stays in it: rows, slices and layers packed.
pub(super) fn download_image(
    gpu: &Arc<Device>,
    source: vk::Image,
    info: &ImageInfo,
    level: u32,
    layout: vk::ImageLayout,
) -> Result<Vec<u8>> {
    let [width, height, depth] = info.level_size_px(level);
    let texels = [width, height, depth, info.layer_count()].map(u64::from).iter().product::<u64>();
    let size = texels * texel_bytes(info.format);
    let staging = Buffer::host(gpu, "readback", size, vk::BufferUsageFlags::TRANSFER_DST)?;
    let part = image_levels(info, level..level + 1);
    let region = [vk::BufferImageCopy::default()
        .image_subresource(vk::ImageSubresourceLayers {
            aspect_mask: part.aspect_mask,
            mip_level: level,
            base_array_layer: 0,
            layer_count: part.layer_count,
        })
        .image_extent(vk::Extent3D { width, height, depth })];
    let copy_layout = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
    submit_once(gpu, |commands| {
        image_layout(gpu, commands, source, part, layout, copy_layout);
        // SAFETY: the staging buffer is large enough; the level is in the layout named.
        unsafe { gpu.device.cmd_copy_image_to_buffer(commands, source, copy_layout, staging.raw, &region) };
        image_layout(gpu, commands, source, part, copy_layout, layout);
        full_barrier(gpu, commands);
    })?;
    Ok(staging.mapped()[..size as usize].to_vec())
}
