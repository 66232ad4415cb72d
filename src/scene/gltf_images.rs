//! Images of glTF files, decoded to RGBA8.

use image::ImageFormat;

use super::gltf_extensions::NEEDS_CODECS;
use super::{Texture, gltf_dds, ktx2};
use crate::files::guard::{self, guarded};
use crate::files::mistaken;

/// Decodes a file: PNG, JPEG, WebP, DDS or KTX2 by its first bytes, whatever the glTF says it is.
pub(super) fn decode_image(name: &str, bytes: &[u8]) -> std::result::Result<Texture, String> {
    if bytes.starts_with(b"DDS ") {
        return guarded(|| gltf_dds::decode(name, bytes));
    }
    if bytes.starts_with(ktx2::MAGIC) {
        let ([width, height], rgba) = guarded(|| ktx2::decode(bytes))?;
        return Ok(Texture { name: name.to_owned(), width, height, rgba });
    }
    let unknown = |_| mistaken(bytes).unwrap_or("it is neither png nor jpeg, webp, dds or ktx2").to_owned();
    let format = image::guess_format(bytes).map_err(unknown)?;
    if !matches!(format, ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP) {
        return Err(format!("{format:?} images are not supported"));
    }
    if format == ImageFormat::WebP && cfg!(not(feature = "codecs")) {
        return Err(format!("it is a WebP image, and {NEEDS_CODECS}"));
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
