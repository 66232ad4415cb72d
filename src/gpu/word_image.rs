//! Words that shaders read four at a time, as an image of one word per channel.

use std::sync::Arc;

use ash::vk;

use super::descriptors::Bound;
use super::device::Device;
use super::image::Image;
use super::physical::Physical;
use super::transfer::{Subresource, download_image, upload_image};
use crate::error::{Error, Result};
use crate::graph::ImageInfo;
use crate::shared::WORD_ROW_TEXELS;

/// Four words.
const FORMAT: vk::Format = vk::Format::R32G32B32A32_UINT;
/// Four words of four bytes.
const TEXEL_BYTES: usize = 16;

/// Bytes in rows of [`WORD_ROW_TEXELS`] texels. Why not a buffer: `docs/bvh.md`.
pub(super) struct WordImage {
    image: Image,
    info: ImageInfo,
    size_bytes: usize,
}

impl WordImage {
    /// Uploads `bytes`, a multiple of 16, into an image with room for `capacity_bytes`.
    ///
    /// # Errors
    /// [`Error::Failure`] when they take more rows than the device's images have; [`Error::Memory`].
    pub fn new(gpu: &Arc<Device>, name: &str, bytes: &[u8], capacity_bytes: usize) -> Result<Self> {
        let most = gpu.report().limits.image_rows;
        let rows = rows(name, bytes.len().max(capacity_bytes), most)?;
        // Read back for dumps, and written by passes; every device can store this format.
        let usage = vk::ImageUsageFlags::TRANSFER_SRC | vk::ImageUsageFlags::STORAGE;
        let info = ImageInfo::new(FORMAT, WORD_ROW_TEXELS, rows);
        let image = Image::texture(gpu, name, &info, usage)?;
        let words = Self { image, info, size_bytes: bytes.len() };
        words.replace(gpu, bytes)?;
        Ok(words)
    }

    /// Uploads other bytes that fit; waits.
    ///
    /// # Errors
    /// [`Error::Failure`] when they do not fit; when the device is lost.
    pub fn replace(&self, gpu: &Arc<Device>, bytes: &[u8]) -> Result<()> {
        let [width_px, height_px, _] = self.info.level_size_px(0);
        let room = width_px as usize * height_px as usize * TEXEL_BYTES;
        if bytes.len() > room {
            return Err(Error::Failure(format!("{} bytes do not fit an image of {room}", bytes.len())));
        }
        let mut texels = bytes.to_vec();
        texels.resize(room, 0);
        let all = Subresource { mip: 0, layer: 0, width_px, height_px, texels: &texels };
        upload_image(gpu, &self.image, &[all])
    }

    pub fn bound(&self) -> Bound {
        Bound::SampledImage { view: self.image.view, layout: vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL }
    }

    /// As a resource of a frame.
    pub fn physical(&self) -> Physical {
        Physical::Image { raw: self.image.raw, view: self.image.view, info: self.info }
    }

    /// As many bytes as were uploaded first; waits.
    pub fn read_back(&self, gpu: &Arc<Device>) -> Result<Vec<u8>> {
        let layout = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;
        let mut bytes = download_image(gpu, self.image.raw, &self.info, 0, layout)?;
        bytes.truncate(self.size_bytes);
        Ok(bytes)
    }
}

/// Rows that so many bytes take, at least one.
fn rows(name: &str, size_bytes: usize, most: u32) -> Result<u32> {
    let row_bytes = WORD_ROW_TEXELS as usize * TEXEL_BYTES;
    let rows = size_bytes.div_ceil(row_bytes).max(1);
    if rows > most as usize {
        let mib = |bytes: usize| bytes >> 20;
        return Err(Error::Failure(format!(
            "the scene is too large for this device: {name} take {} MiB, an image of this kind holds {} MiB",
            mib(size_bytes),
            mib(most as usize * row_bytes)
        )));
    }
    Ok(rows as u32)
}

#[cfg(test)]
mod tests {
    use super::rows;

    #[test]
    fn rows_are_filled_one_by_one_up_to_the_limit() {
        assert_eq!(rows("nodes", 0, 4096).unwrap(), 1);
        assert_eq!(rows("nodes", 65536, 4096).unwrap(), 1);
        assert_eq!(rows("nodes", 65552, 4096).unwrap(), 2);
        assert_eq!(rows("nodes", 256 << 20, 4096).unwrap(), 4096);
        let error = rows("BVH nodes", (256 << 20) + 16, 4096).unwrap_err();
        let sentence =
            "the scene is too large for this device: BVH nodes take 256 MiB, an image of this kind holds 256 MiB";
        assert!(error.to_string().contains(sentence), "{error}");
    }
}
