//! What stands for a resource of the graph on the device, and the parts of an image that Vulkan asks for.

use std::ops::Range;

use ash::vk;

use crate::graph::{ImageDepth, ImageInfo};

/// A buffer or an image of the frame.
#[derive(Clone, Copy, Debug)]
pub(super) enum Physical {
    Buffer { raw: vk::Buffer, size_bytes: u64 },
    Image { raw: vk::Image, view: vk::ImageView, info: ImageInfo },
}

impl Physical {
    /// Stands for an image that the frame does not have now.
    pub(super) fn unacquired(info: ImageInfo) -> Self {
        Self::Image { raw: vk::Image::null(), view: vk::ImageView::null(), info }
    }
}

/// Aspect of a frame image.
pub(super) fn aspect(info: &ImageInfo) -> vk::ImageAspectFlags {
    if info.is_depth() { vk::ImageAspectFlags::DEPTH } else { vk::ImageAspectFlags::COLOR }
}

/// Some mip levels of a frame image with all their layers.
pub(super) fn image_levels(info: &ImageInfo, levels: Range<u32>) -> vk::ImageSubresourceRange {
    vk::ImageSubresourceRange {
        aspect_mask: aspect(info),
        base_mip_level: levels.start,
        level_count: levels.end - levels.start,
        base_array_layer: 0,
        layer_count: info.layer_count(),
    }
}

/// How a frame image is created for these uses.
pub(super) fn image_create_info(info: &ImageInfo, usage: vk::ImageUsageFlags) -> vk::ImageCreateInfo<'static> {
    let volume = matches!(info.depth, ImageDepth::Texels(_));
    let [width, height, depth] = info.level_size_px(0);
    vk::ImageCreateInfo::default()
        .image_type(if volume { vk::ImageType::TYPE_3D } else { vk::ImageType::TYPE_2D })
        .format(info.format)
        .extent(vk::Extent3D { width, height, depth })
        .mip_levels(info.level_count)
        .array_layers(info.layer_count())
        .samples(vk::SampleCountFlags::TYPE_1)
        .tiling(vk::ImageTiling::OPTIMAL)
        .usage(usage)
}

/// How a view of some levels is created, with all their layers.
pub(super) fn view_create_info(
    raw: vk::Image,
    info: &ImageInfo,
    levels: Range<u32>,
) -> vk::ImageViewCreateInfo<'static> {
    let view_type = match info.depth {
        ImageDepth::Flat => vk::ImageViewType::TYPE_2D,
        ImageDepth::Layers(_) => vk::ImageViewType::TYPE_2D_ARRAY,
        ImageDepth::Texels(_) => vk::ImageViewType::TYPE_3D,
    };
    vk::ImageViewCreateInfo::default()
        .image(raw)
        .view_type(view_type)
        .format(info.format)
        .subresource_range(image_levels(info, levels))
}

/// Bytes per texel of the formats the frame uses.
pub(super) fn texel_bytes(format: vk::Format) -> u64 {
    match format {
        vk::Format::R32G32B32A32_SFLOAT | vk::Format::R32G32B32A32_UINT => 16,
        vk::Format::R16G16B16A16_SFLOAT | vk::Format::R32G32_UINT => 8,
        _ => 4,
    }
}
