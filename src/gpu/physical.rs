//! What stands for a resource of the graph on the device.

use ash::vk;

use crate::graph::ImageInfo;

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
