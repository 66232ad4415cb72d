//! An image that several graphs use: one leaves a picture in it, another shows it.

use std::sync::Arc;

use ash::vk;

use super::device::Device;
use super::image::Image;
use super::physical::{Physical, image_levels};
use super::transfer;
use crate::error::Result;
use crate::graph::{IMPORTED_LAYOUT, ImageInfo};

/// A flat image of one level, imported by graphs under its name.
pub struct SharedImage {
    pub(super) name: String,
    info: ImageInfo,
    image: Image,
}

impl SharedImage {
    /// Creates the image, which holds nothing yet; waits.
    ///
    /// # Errors
    /// [`Error::Memory`](crate::Error::Memory) when there is no memory for it.
    pub fn new(
        gpu: &Arc<Device>,
        name: &str,
        format: vk::Format,
        [width_px, height_px]: [u32; 2],
    ) -> Result<Arc<Self>> {
        let info = ImageInfo::new(format, width_px, height_px);
        let image = Image::texture(gpu, name, &info, vk::ImageUsageFlags::empty())?;
        transfer::submit_once(gpu, |commands| {
            let levels = image_levels(&info, 0..1);
            transfer::image_layout(gpu, commands, image.raw, levels, vk::ImageLayout::UNDEFINED, IMPORTED_LAYOUT);
        })?;
        Ok(Arc::new(Self { name: name.to_owned(), info, image }))
    }

    pub(super) fn physical(&self) -> Physical {
        Physical::Image { raw: self.image.raw, view: self.image.view, info: self.info }
    }
}
