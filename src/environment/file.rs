//! Environments from image files: OpenEXR and Radiance RGBE.

use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::Path;

use glam::DVec3;
use image::ImageDecoder;
use image::codecs::hdr::HdrDecoder;

use super::Environment;
use super::resample::Resampled;
use crate::files::exr_texels::{Texels, read_texels};
use crate::files::guard::{could_hold, guarded};
use crate::files::open_regular;
use crate::{Error, Result};

/// Larger images are averaged down to this, along each edge for itself: its texels are a sixth as wide as the
/// sun's disc seen from the earth, and a device needs 64 MiB for it.
pub const MOST_TEXELS: [u32; 2] = [4096, 2048];
/// The longest edge of a file.
const LONGEST_EDGE: u32 = 65_536;
/// The most texels of a Radiance file, which is decoded as a whole: 3 GiB of them.
const MOST_RADIANCE_TEXELS: u64 = 1 << 28;

/// Reads an equirectangular image: `.hdr` as Radiance RGBE, all else as OpenEXR. What is NaN, infinite or negative
/// counts as 0, and a warning says how much that was.
///
/// # Errors
/// [`Error::File`] when it cannot be read or is no such image.
pub fn read(path: &Path) -> Result<Environment> {
    let file = open_regular(path).map_err(|error| unreadable(path, error))?;
    let is_radiance = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("hdr"));
    let image = if is_radiance { read_radiance(path, file) } else { read_exr(path, file) }?;
    if image.size_used != image.size {
        let [[width, height], [wide, high]] = [image.size, image.size_used];
        log::info!("{}: {width}x{height} texels are averaged down to {wide}x{high}", path.display());
    }
    if image.unusable > 0 {
        let Canvas { unusable, size: [width, height], .. } = image;
        let all = 3 * u64::from(width) * u64::from(height);
        log::warn!("{}: {unusable} of {all} values are NaN, infinite or negative; they count as 0", path.display());
    }
    Ok(image.into_environment())
}

fn unreadable(path: &Path, reason: impl std::fmt::Display) -> Error {
    Error::file(path, format_args!("the environment cannot be read: {reason}"))
}

/// The image while it is read: as it will be used, so that large files take no more memory than small ones.
struct Canvas {
    /// Size of the file's image.
    size: [u32; 2],
    size_used: [u32; 2],
    image: Resampled<DVec3>,
    /// Values that are no radiance.
    unusable: u64,
}

impl Canvas {
    /// For a file's image of a size that [`size_fault`] lets pass.
    fn of_size(size: [u32; 2]) -> Self {
        let size_used = [size[0].min(MOST_TEXELS[0]), size[1].min(MOST_TEXELS[1])];
        Self { size, size_used, image: Resampled::new(size, size_used), unusable: 0 }
    }

    fn put_texel(&mut self, x: usize, y: usize, radiance: [f32; 3]) {
        let usable = radiance.map(|value| if value.is_finite() && value >= 0.0 { f64::from(value) } else { 0.0 });
        self.unusable += radiance.iter().filter(|value| !(value.is_finite() && **value >= 0.0)).count() as u64;
        self.image.add(x, y, DVec3::from_array(usable));
    }

    fn into_environment(self) -> Environment {
        let radiance = self.image.into_texels().iter().map(|texel| texel.as_vec3().to_array()).collect();
        Environment { size: self.size_used, radiance, suns: Vec::new() }
    }
}

impl Texels for Canvas {
    const ANY_CHANNEL: bool = false;

    fn new(size: [u32; 2]) -> Self {
        Self::of_size(size)
    }

    fn put(&mut self, [x, y]: [usize; 2], radiance: [f32; 3]) {
        self.put_texel(x, y, radiance);
    }
}

/// What is wrong with the size of a file's image that has no texels or absurdly many.
fn size_fault([width, height]: [u32; 2]) -> Option<String> {
    let edges = 1..=LONGEST_EDGE;
    (!edges.contains(&width) || !edges.contains(&height))
        .then(|| format!("its size is {width}x{height}, and edges must be from 1 to {LONGEST_EDGE}"))
}

fn read_radiance(path: &Path, file: File) -> Result<Canvas> {
    guarded(|| decode_radiance(file)).map_err(|reason| unreadable(path, reason))
}

fn decode_radiance(mut file: File) -> std::result::Result<Canvas, String> {
    let told = |error: &dyn std::fmt::Display| error.to_string();
    let mut start = [0; 2];
    let known = file.read_exact(&mut start).is_ok() && start == *b"#?";
    if !known || file.rewind().is_err() {
        return Err("it is not a Radiance RGBE image".to_owned());
    }
    let file_bytes = file.metadata().map_err(|error| told(&error))?.len();
    // The strict reader takes one of the two usual first lines alone.
    let decoder = HdrDecoder::new_nonstrict(BufReader::new(file)).map_err(|error| told(&error))?;
    let meta = decoder.metadata();
    let size = [meta.width, meta.height];
    if let Some(fault) = size_fault(size) {
        return Err(fault);
    }
    let [wide, high] = size.map(u64::from);
    if wide * high > MOST_RADIANCE_TEXELS {
        return Err(format!("its size is {wide}x{high}, and {MOST_RADIANCE_TEXELS} texels are the most that are read"));
    }
    if !could_hold(file_bytes, 4 * wide * high) {
        return Err(format!("it cannot have the {wide}x{high} texels that it announces in {file_bytes} bytes"));
    }
    let mut canvas = Canvas::of_size(size);
    let mut bytes = vec![0; usize::try_from(decoder.total_bytes()).map_err(|error| told(&error))?];
    decoder.read_image(&mut bytes).map_err(|error| told(&error))?;
    // The file says by what the values were multiplied.
    let exposure = meta.exposure.filter(|exposure| exposure.is_finite() && *exposure > 0.0).unwrap_or(1.0);
    let value = |bytes: &[u8]| f32::from_ne_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]) / exposure;
    let width = meta.width as usize;
    for (index, texel) in bytes.chunks_exact(12).enumerate() {
        canvas.put_texel(index % width, index / width, [value(&texel[..4]), value(&texel[4..8]), value(&texel[8..])]);
    }
    Ok(canvas)
}

fn read_exr(path: &Path, file: File) -> Result<Canvas> {
    read_texels(file, |size| size_fault(size).map_or(Ok(()), Err)).map_err(|reason| unreadable(path, reason))
}

#[cfg(test)]
#[path = "file_tests.rs"]
mod tests;
