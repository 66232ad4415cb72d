//! Images of glTF files, decoded to RGBA8.

use image::ImageFormat;
use image_dds::ddsfile::Dds;
use image_dds::{ImageFormat as DdsFormat, Surface};

use super::Texture;
use crate::files::guard::{self, MAX_IMAGE_EDGE, guarded};

/// Decodes a file: PNG, JPEG, WebP or DDS by its first bytes.
pub(super) fn decode_image(name: &str, bytes: &[u8]) -> std::result::Result<Texture, String> {
    if bytes.starts_with(b"DDS ") {
        return guarded(|| decode_dds(name, bytes));
    }
    if bytes.starts_with(b"\xabKTX 20") {
        return Err("KTX2 images are not supported".to_owned());
    }
    let format = image::guess_format(bytes).map_err(|_| "it is neither png nor jpeg, webp or dds".to_owned())?;
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
    let pixels = match bytes.get(12..20).filter(|_| bytes.starts_with(b"DDS ")) {
        Some(size) => size.chunks_exact(4).map(|e| u64::from(u32::from_le_bytes([e[0], e[1], e[2], e[3]]))).product(),
        None => guard::image_size(bytes).map_or(0, |[width, height]| u64::from(width) * u64::from(height)),
    };
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
    let mut rgba = surface.decode_layers_mipmaps_rgba8(0..1, 0..1).map_err(|e| e.to_string())?.data;
    if matches!(surface.image_format, DdsFormat::BC5RgUnorm | DdsFormat::BC5RgSnorm) {
        // Normals without z.
        for texel in rgba.chunks_exact_mut(4) {
            let [x, y] = [texel[0], texel[1]].map(|c| f32::from(c) / 127.5 - 1.0);
            texel[2] = (127.5 * (1.0 + (1.0 - x * x - y * y).max(0.0).sqrt())).round() as u8;
        }
    }
    rgba.truncate(4 * width as usize * height as usize);
    Ok(Texture { name: name.to_owned(), width, height, rgba })
}
