//! Texels by their format, decoded to RGBA8.

use image_dds::{ImageFormat, Surface};
use ktx2::Format;

use super::super::gltf_dds::decode_surface;
use super::basis::{UASTC_BLOCK_BYTES, decode_uastc};

/// What a level consists of.
#[derive(Clone, Copy)]
pub(super) struct Texels {
    coding: Coding,
    /// Width and height of a block, in texels.
    block_edge: u32,
    block_bytes: u64,
    /// Red and blue are the other way round.
    is_reversed: bool,
    is_opaque: bool,
}

#[derive(Clone, Copy)]
enum Coding {
    /// A format of DDS files that has the same bytes.
    Surface(ImageFormat),
    Uastc,
}

impl Texels {
    /// Blocks of UASTC.
    pub const UASTC: Self = Self {
        coding: Coding::Uastc,
        block_edge: 4,
        block_bytes: UASTC_BLOCK_BYTES,
        is_reversed: false,
        is_opaque: false,
    };

    /// Texels of a format of Vulkan, if it is read. One of sRGB has the same bytes as the linear one.
    pub fn of_format(format: Format) -> Option<Self> {
        use ImageFormat as To;
        let (to, block_edge, block_bytes) = match format {
            Format::R8_UNORM | Format::R8_SRGB => (To::R8Unorm, 1, 1),
            Format::R8G8_UNORM | Format::R8G8_SRGB => (To::Rg8Unorm, 1, 2),
            Format::R8G8B8_UNORM | Format::R8G8B8_SRGB => (To::Bgr8Unorm, 1, 3),
            Format::B8G8R8_UNORM | Format::B8G8R8_SRGB => (To::Bgr8Unorm, 1, 3),
            Format::R8G8B8A8_UNORM | Format::R8G8B8A8_SRGB => (To::Rgba8Unorm, 1, 4),
            Format::B8G8R8A8_UNORM | Format::B8G8R8A8_SRGB => (To::Bgra8Unorm, 1, 4),
            Format::BC1_RGB_UNORM_BLOCK | Format::BC1_RGB_SRGB_BLOCK => (To::BC1RgbaUnorm, 4, 8),
            Format::BC1_RGBA_UNORM_BLOCK | Format::BC1_RGBA_SRGB_BLOCK => (To::BC1RgbaUnorm, 4, 8),
            Format::BC2_UNORM_BLOCK | Format::BC2_SRGB_BLOCK => (To::BC2RgbaUnorm, 4, 16),
            Format::BC3_UNORM_BLOCK | Format::BC3_SRGB_BLOCK => (To::BC3RgbaUnorm, 4, 16),
            Format::BC4_UNORM_BLOCK => (To::BC4RUnorm, 4, 8),
            Format::BC4_SNORM_BLOCK => (To::BC4RSnorm, 4, 8),
            Format::BC5_UNORM_BLOCK => (To::BC5RgUnorm, 4, 16),
            Format::BC5_SNORM_BLOCK => (To::BC5RgSnorm, 4, 16),
            Format::BC6H_UFLOAT_BLOCK => (To::BC6hRgbUfloat, 4, 16),
            Format::BC6H_SFLOAT_BLOCK => (To::BC6hRgbSfloat, 4, 16),
            Format::BC7_UNORM_BLOCK | Format::BC7_SRGB_BLOCK => (To::BC7RgbaUnorm, 4, 16),
            _ => return None,
        };
        let is_reversed = matches!(format, Format::R8G8B8_UNORM | Format::R8G8B8_SRGB);
        let is_opaque = matches!(format, Format::BC1_RGB_UNORM_BLOCK | Format::BC1_RGB_SRGB_BLOCK);
        Some(Self { coding: Coding::Surface(to), block_edge, block_bytes, is_reversed, is_opaque })
    }

    /// Bytes of an image of so many texels.
    pub fn byte_count(self, size: [u32; 2]) -> u64 {
        let [across, down] = size.map(|edge| u64::from(edge.div_ceil(self.block_edge)));
        across * down * self.block_bytes
    }

    /// RGBA8 of an image.
    pub fn decode(self, data: &[u8], [width, height]: [u32; 2]) -> Result<Vec<u8>, String> {
        let mut rgba = match self.coding {
            Coding::Surface(image_format) => {
                decode_surface(&Surface { width, height, depth: 1, layers: 1, mipmaps: 1, image_format, data })?
            }
            Coding::Uastc => decode_uastc(data, [width, height])?,
        };
        for texel in rgba.chunks_exact_mut(4) {
            if self.is_reversed {
                texel.swap(0, 2);
            }
            if self.is_opaque {
                texel[3] = u8::MAX;
            }
        }
        Ok(rgba)
    }
}
