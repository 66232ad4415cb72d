//! Images in DDS files, also of the BC formats, decoded to RGBA8.

use image_dds::ddsfile::Dds;
use image_dds::{ImageFormat as DdsFormat, Surface};

use super::Texture;
use crate::files::guard::MAX_IMAGE_EDGE;

/// The first and largest level of a file. Panics where the decoder does: callers guard it.
pub(super) fn decode(name: &str, bytes: &[u8]) -> std::result::Result<Texture, String> {
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
