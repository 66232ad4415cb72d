//! The environment on the GPU: its image and the table that directions are drawn from.

use std::sync::Arc;

use ash::vk;

use super::buffer::Buffer;
use super::descriptors::Bound;
use super::device::Device;
use super::image::Image;
use super::physical::Physical;
use super::transfer::{Subresource, storage_buffer, upload_buffer, upload_image};
use crate::environment::upload::PreparedEnvironment;
use crate::error::{Error, Result};
use crate::graph::ImageInfo;

/// Half floats, which every device can sample.
pub const FORMAT: vk::Format = vk::Format::R16G16B16A16_SFLOAT;

/// Both parts.
pub(super) struct EnvironmentParts {
    image: Image,
    info: ImageInfo,
    table: Buffer,
}

impl EnvironmentParts {
    /// Uploads an environment.
    ///
    /// # Errors
    /// [`Error::Failure`] when its image is larger than the device's images are; [`Error::Memory`].
    pub fn new(gpu: &Arc<Device>, environment: &PreparedEnvironment) -> Result<Self> {
        let [width_px, height_px] = environment.size_px;
        let limit = gpu.report().limits.image_edge_px;
        if width_px > limit || height_px > limit {
            return Err(Error::Failure(format!(
                "the environment is {width_px}x{height_px}, this device's images end at {limit}x{limit}"
            )));
        }
        let info = ImageInfo::new(FORMAT, width_px, height_px);
        let image = Image::texture(gpu, "environment map", &info, vk::ImageUsageFlags::empty())?;
        let texels = bytemuck::cast_slice(&environment.texels);
        upload_image(gpu, &image, &[Subresource { mip: 0, layer: 0, width_px, height_px, texels }])?;
        let table = bytemuck::cast_slice(&environment.table);
        let table = storage_buffer(gpu, "environment table", table, vk::BufferUsageFlags::STORAGE_BUFFER)?;
        Ok(Self { image, info, table })
    }

    /// Replaces the contents between frames by those of an environment of the same size; waits.
    ///
    /// # Errors
    /// [`Error::Failure`] when it has another size; when the device is lost.
    pub fn replace(&self, gpu: &Arc<Device>, environment: &PreparedEnvironment) -> Result<()> {
        let [width_px, height_px] = environment.size_px;
        let table: &[u8] = bytemuck::cast_slice(&environment.table);
        if [self.info.width_px, self.info.height_px] != environment.size_px
            || table.len() as u64 > self.table.size_bytes
        {
            return Err(Error::Failure(format!(
                "another environment, {width_px}x{height_px}, does not fit the one before"
            )));
        }
        let texels = bytemuck::cast_slice(&environment.texels);
        upload_image(gpu, &self.image, &[Subresource { mip: 0, layer: 0, width_px, height_px, texels }])?;
        upload_buffer(gpu, &self.table, table)
    }

    /// Bindings of the scene's set.
    pub fn bound(&self) -> [(u32, Bound); 2] {
        let layout = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;
        let map = Bound::SampledImage { view: self.image.view, layout };
        let table = Bound::Storage { buffer: self.table.raw, size_bytes: self.table.size_bytes };
        [(9, map), (10, table)]
    }

    /// As resources of a frame: the image, then the table.
    pub fn physical(&self) -> [Physical; 2] {
        let map = Physical::Image { raw: self.image.raw, view: self.image.view, info: self.info };
        [map, Physical::Buffer { raw: self.table.raw, size_bytes: self.table.size_bytes }]
    }
}
