//! Images of glTF files, decoded to RGBA8.

use std::io::Cursor;

use image::{ImageFormat, ImageReader, Limits};
use image_dds::ddsfile::Dds;
use image_dds::{ImageFormat as DdsFormat, Surface};

use super::Texture;

/// The largest width and height of an image.
const MAX_IMAGE_SIZE: u32 = 16_384;
/// The most memory a decoder may take for one image, in bytes.
const MAX_IMAGE_MEMORY: u64 = 2 << 30;

/// Decodes a file: PNG, JPEG, WebP or DDS by its first bytes.
pub(super) fn decode_image(name: &str, bytes: &[u8]) -> std::result::Result<Texture, String> {
    if bytes.starts_with(b"DDS ") {
        return decode_dds(name, bytes);
    }
    if bytes.starts_with(b"\xabKTX 20") {
        return Err("KTX2 images are not supported".to_owned());
    }
    let format = image::guess_format(bytes).map_err(|_| "it is neither png nor jpeg, webp or dds".to_owned())?;
    if !matches!(format, ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP) {
        return Err(format!("{format:?} images are not supported"));
    }
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_IMAGE_SIZE);
    limits.max_image_height = Some(MAX_IMAGE_SIZE);
    limits.max_alloc = Some(MAX_IMAGE_MEMORY);
    reader.limits(limits);
    let pixels = reader.decode().map_err(|e| e.to_string())?.into_rgba8();
    let (width, height) = pixels.dimensions();
    if width == 0 || height == 0 {
        return Err("it has no pixels".into());
    }
    Ok(Texture { name: name.to_owned(), width, height, rgba: pixels.into_raw() })
}

/// The first and largest level of a DDS file, of any of the BC formats.
fn decode_dds(name: &str, bytes: &[u8]) -> std::result::Result<Texture, String> {
    let dds = Dds::read(bytes).map_err(|e| e.to_string())?;
    let surface = Surface::from_dds(&dds).map_err(|e| e.to_string())?;
    let (width, height) = (surface.width, surface.height);
    if width == 0 || height == 0 || width > MAX_IMAGE_SIZE || height > MAX_IMAGE_SIZE {
        return Err(format!("it has {width}x{height} pixels, and {MAX_IMAGE_SIZE} are the most on a side"));
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
