//! Images of glTF files, decoded to RGBA8.

use image::ImageFormat;
use image_dds::ddsfile::Dds;
use image_dds::{ImageFormat as DdsFormat, Surface};

use super::{Texture, ktx2};
use crate::files::guard::{self, MAX_IMAGE_EDGE, guarded};

/// Decodes a file: PNG, JPEG, WebP, DDS or KTX2 by its first bytes, whatever the glTF says it is.
pub(super) fn decode_image(name: &str, bytes: &[u8]) -> std::result::Result<Texture, String> {
    if bytes.starts_with(b"DDS ") {
        return guarded(|| decode_dds(name, bytes));
    }
    if bytes.starts_with(ktx2::MAGIC) {
        let ([width, height], rgba) = guarded(|| ktx2::decode(bytes))?;
        return Ok(Texture { name: name.to_owned(), width, height, rgba });
    }
    let format = image::guess_format(bytes).map_err(|_| "it is neither png nor jpeg, webp, dds or ktx2".to_owned())?;
    if !matches!(format, ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP) {
        return Err(format!("{format:?} images are not supported"));
    }
    let pixels = guard::decode_image(bytes, format)?.into_rgba8();
    let (width, height) = pixels.dimensions();
    if width == 0 || height == 0 {
        return Err("it has no pixels".into());
    }
    Ok(Texture { name: name.to_owned(), width, height, rgba: pixels.into_raw() })
}

/// Bytes of an image as texels, as its file announces it.
pub(super) fn announced_bytes(bytes: &[u8]) -> u64 {
    let size = match bytes {
        [b'D', b'D', b'S', b' ', ..] => bytes.get(12..20).map(|size| {
            // Height stands before width.
            [0, 4].map(|at| u32::from_le_bytes([size[at], size[at + 1], size[at + 2], size[at + 3]]))
        }),
        _ if bytes.starts_with(ktx2::MAGIC) => ktx2::announced_size(bytes),
        _ => guard::image_size(bytes).ok(),
    };
    let pixels = size.map_or(0, |edges| edges.map(u64::from).iter().product());
    4_u64.saturating_mul(pixels)
}

/// The first and largest level of a DDS file, of any of the BC formats.
fn decode_dds(name: &str, bytes: &[u8]) -> std::result::Result<Texture, String> {
    let dds = Dds::read(bytes).map_err(|e| e.to_string())?;
    let surface = Surface::from_dds(&dds).map_err(|e| e.to_string())?;
    let (width, height) = (surface.width, surface.height);
    if width == 0 || height == 0 || width > MAX_IMAGE_EDGE || height > MAX_IMAGE_EDGE {
        return Err(format!("it has {width}x{height} pixels, and {MAX_IMAGE_EDGE} are the most on a side"));
    }
    Ok(Texture { name: name.to_owned(), width, height, rgba: decode_surface(&surface)? })
}

/// RGBA8 of the first and largest level of a surface. A single channel is grey, and two are a normal without its z.
pub(super) fn decode_surface(surface: &Surface<&[u8]>) -> std::result::Result<Vec<u8>, String> {
    let mut rgba = surface.decode_layers_mipmaps_rgba8(0..1, 0..1).map_err(|e| e.to_string())?.data;
    if matches!(surface.image_format, DdsFormat::Rg8Unorm | DdsFormat::BC5RgUnorm | DdsFormat::BC5RgSnorm) {
        for texel in rgba.chunks_exact_mut(4) {
            let [x, y] = [texel[0], texel[1]].map(|c| f32::from(c) / 127.5 - 1.0);
            texel[2] = (127.5 * (1.0 + (1.0 - x * x - y * y).max(0.0).sqrt())).round() as u8;
        }
    }
    rgba.truncate(4 * surface.width as usize * surface.height as usize);
    Ok(rgba)
}
