//! Images of the frame as OpenEXR: uncompressed scan lines, so that a reader of a page suffices.

use std::fmt::Display;
use std::io::{BufReader, Cursor};
use std::path::Path;

use ash::vk;
use exr::prelude::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, SmallVec, f16};

use exr::prelude::traits::*;

use crate::dump::Scalar;
use crate::files::exr_texels::read_meta;
use crate::files::guard::guarded;
use crate::files::open_regular;
use crate::{Error, Result};

/// The channels of an image, each with one number per pixel, row 0 at the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width.
    pub width_px: u32,
    /// Height.
    pub height_px: u32,
    /// Kind of number in all channels: `F16`, `F32` or `U32`.
    pub scalar: Scalar,
    /// Name and little-endian numbers of each channel.
    pub channels: Vec<(String, Vec<u8>)>,
}

impl Picture {
    /// Takes the texels of a flat image apart. `names` are the channels' names in the order of the texel.
    ///
    /// # Errors
    /// [`Error::Failure`] for a format that no image of the frame has.
    pub fn from_texels(format: vk::Format, size_px: [u32; 2], names: &[&str], texels: &[u8]) -> Result<Self> {
        let (scalar, stored_bytes, count) = match format {
            vk::Format::R16G16B16A16_SFLOAT => (Scalar::F16, 2, 4),
            vk::Format::R32G32B32A32_SFLOAT => (Scalar::F32, 4, 4),
            vk::Format::R32G32B32A32_UINT => (Scalar::U32, 4, 4),
            vk::Format::R32G32_UINT => (Scalar::U32, 4, 2),
            vk::Format::R32_UINT => (Scalar::U32, 4, 1),
            vk::Format::D32_SFLOAT | vk::Format::R32_SFLOAT => (Scalar::F32, 4, 1),
            vk::Format::R8G8B8A8_UNORM => (Scalar::U32, 1, 4),
            other => return Err(Error::Failure(format!("images of format {other:?} cannot be dumped"))),
        };
        let channel = |index: usize| -> Vec<u8> {
            let numbers = texels.chunks_exact(stored_bytes).skip(index).step_by(count);
            // Eight bits have no type of their own in OpenEXR.
            let padding = scalar.bytes() - stored_bytes;
            numbers.flat_map(|number| number.iter().copied().chain(std::iter::repeat_n(0, padding))).collect()
        };
        let channels = names.iter().take(count).enumerate().map(|(i, name)| ((*name).to_owned(), channel(i))).collect();
        let [width_px, height_px] = size_px;
        Ok(Self { width_px, height_px, scalar, channels })
    }

    /// Writes an `.exr` file.
    ///
    /// # Errors
    /// [`Error::File`] when that fails.
    pub fn write(&self, path: &Path) -> Result<()> {
        let channels: SmallVec<[AnyChannel<FlatSamples>; 4]> =
            self.channels.iter().map(|(name, bytes)| self.channel(name, bytes)).collect();
        let layer = Layer::new(
            (self.width_px as usize, self.height_px as usize),
            LayerAttributes::default(),
            Encoding::UNCOMPRESSED,
            AnyChannels::sort(channels),
        );
        let unwritable = |reason: &dyn Display| Error::file(path, format!("cannot be written: {reason}"));
        let mut bytes = Cursor::new(Vec::new());
        Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).map_err(|error| unwritable(&error))?;
        std::fs::write(path, bytes.get_ref()).map_err(|error| unwritable(&error))
    }

    fn channel(&self, name: &str, bytes: &[u8]) -> AnyChannel<FlatSamples> {
        let samples = match self.scalar {
            Scalar::F16 => {
                let bits = bytes.chunks_exact(2).map(|b| u16::from_le_bytes([b[0], b[1]]));
                FlatSamples::F16(bits.map(f16::from_bits).collect())
            }
            Scalar::F32 => FlatSamples::F32(words(bytes).map(f32::from_bits).collect()),
            _ => FlatSamples::U32(words(bytes).collect()),
        };
        AnyChannel::new(name, samples)
    }

    /// Reads an `.exr` file; the channels come sorted by name.
    ///
    /// # Errors
    /// [`Error::File`] when it cannot be read, is cut short, or mixes kinds of numbers.
    pub fn read(path: &Path) -> Result<Self> {
        let layer = guarded(|| {
            let mut file = open_regular(path).map_err(|e| e.to_string())?;
            read_meta(&mut file)?;
            let reader = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels();
            let image = reader.first_valid_layer().all_attributes().from_buffered(BufReader::new(file));
            image.map(|image| image.layer_data).map_err(|e| e.to_string())
        })
        .map_err(|reason| Error::file(path, format!("cannot be read as OpenEXR: {reason}")))?;
        let mut scalar = None;
        let mut channels = Vec::new();
        for channel in &layer.channel_data.list {
            let (kind, bytes) = match &channel.sample_data {
                FlatSamples::F16(v) => (Scalar::F16, v.iter().flat_map(|v| v.to_bits().to_le_bytes()).collect()),
                FlatSamples::F32(v) => (Scalar::F32, v.iter().flat_map(|v| v.to_le_bytes()).collect()),
                FlatSamples::U32(v) => (Scalar::U32, v.iter().flat_map(|v| v.to_le_bytes()).collect()),
            };
            if *scalar.get_or_insert(kind) != kind {
                return Err(Error::file(path, "has channels of different types, which no dump has"));
            }
            channels.push((channel.name.to_string(), bytes));
        }
        let (width_px, height_px) = (layer.size.0 as u32, layer.size.1 as u32);
        Ok(Self { width_px, height_px, scalar: scalar.unwrap_or(Scalar::F32), channels })
    }
}

fn words(bytes: &[u8]) -> impl Iterator<Item = u32> {
    bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every format of the frame, every channel, half floats with NaN included, bit for bit.
    #[test]
    fn pictures_round_trip() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        for (format, names, bytes) in [
            (vk::Format::R16G16B16A16_SFLOAT, &["R", "G", "B", "A"][..], 8),
            (vk::Format::R32G32B32A32_SFLOAT, &["R", "G", "B", "A"], 16),
            (vk::Format::R32G32_UINT, &["geometric", "shading"], 8),
            (vk::Format::D32_SFLOAT, &["Z"], 4),
            (vk::Format::R8G8B8A8_UNORM, &["R", "G", "B", "A"], 4),
        ] {
            let texels: Vec<u8> = (0..15 * bytes).map(|i: u32| (i * 89 % 251) as u8).collect();
            let mut picture = Picture::from_texels(format, [5, 3], names, &texels).unwrap();
            picture.write(&path).unwrap();
            picture.channels.sort();
            assert_eq!(Picture::read(&path).unwrap(), picture, "{format:?}");
        }
    }
}
