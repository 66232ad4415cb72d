//! Environments from image files: OpenEXR and Radiance RGBE.

use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::Path;

use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::header::Header;
use exr::prelude::traits::*;
use glam::DVec3;
use image::ImageDecoder;
use image::codecs::hdr::HdrDecoder;

use super::Environment;
use super::resample::Resampled;
use crate::{Error, Result};

/// Larger images are averaged down to this, along each edge for itself: its texels are a sixth as wide as the
/// sun's disc seen from the earth, and a device needs 64 MiB for it.
pub const MOST_TEXELS: [u32; 2] = [4096, 2048];
/// The longest edge of a file.
const LONGEST_EDGE: u32 = 65_536;

/// Reads an equirectangular image: `.hdr` as Radiance RGBE, all else as OpenEXR. What is NaN, infinite or negative
/// counts as 0, and a warning says how much that was.
///
/// # Errors
/// [`Error::File`] when it cannot be read or is no such image.
pub fn read(path: &Path) -> Result<Environment> {
    let file = File::open(path).map_err(|error| unreadable(path, error))?;
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
    /// For a file's image of a size that [`check_size`] lets pass.
    fn new(size: [u32; 2]) -> Self {
        let size_used = [size[0].min(MOST_TEXELS[0]), size[1].min(MOST_TEXELS[1])];
        Self { size, size_used, image: Resampled::new(size, size_used), unusable: 0 }
    }

    /// Takes a texel over if it lies within the image.
    fn put_inside(&mut self, [x, y]: [i64; 2], radiance: [f32; 3]) {
        let [width, height] = self.size.map(i64::from);
        if (0..width).contains(&x) && (0..height).contains(&y) {
            self.put(x as usize, y as usize, radiance);
        }
    }

    fn put(&mut self, x: usize, y: usize, radiance: [f32; 3]) {
        let usable = radiance.map(|value| if value.is_finite() && value >= 0.0 { f64::from(value) } else { 0.0 });
        self.unusable += radiance.iter().filter(|value| !(value.is_finite() && **value >= 0.0)).count() as u64;
        self.image.add(x, y, DVec3::from_array(usable));
    }

    fn into_environment(self) -> Environment {
        let radiance = self.image.texels.iter().map(|texel| texel.as_vec3().to_array()).collect();
        Environment { size: self.size_used, radiance, suns: Vec::new() }
    }
}

/// Fails where a file's image has no texels or absurdly many.
fn check_size(path: &Path, [width, height]: [u32; 2]) -> Result<()> {
    if width == 0 || height == 0 || width > LONGEST_EDGE || height > LONGEST_EDGE {
        let reason = format!("its size is {width}x{height}, and edges must be from 1 to {LONGEST_EDGE}");
        return Err(unreadable(path, reason));
    }
    Ok(())
}

fn read_radiance(path: &Path, mut file: File) -> Result<Canvas> {
    let mut start = [0; 2];
    let known = file.read_exact(&mut start).is_ok() && start == *b"#?";
    if !known || file.rewind().is_err() {
        return Err(unreadable(path, "it is not a Radiance RGBE image"));
    }
    // The strict reader takes one of the two usual first lines alone.
    let decoder = HdrDecoder::new_nonstrict(BufReader::new(file)).map_err(|error| unreadable(path, error))?;
    let meta = decoder.metadata();
    let size = [meta.width, meta.height];
    check_size(path, size)?;
    let mut canvas = Canvas::new(size);
    let mut bytes = Vec::new();
    let length = usize::try_from(decoder.total_bytes()).map_err(|error| unreadable(path, error))?;
    bytes.try_reserve_exact(length).map_err(|error| unreadable(path, error))?;
    bytes.resize(length, 0);
    decoder.read_image(&mut bytes).map_err(|error| unreadable(path, error))?;
    // The file says by what the values were multiplied.
    let exposure = meta.exposure.filter(|exposure| exposure.is_finite() && *exposure > 0.0).unwrap_or(1.0);
    let value = |bytes: &[u8]| f32::from_ne_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]) / exposure;
    let width = meta.width as usize;
    for (index, texel) in bytes.chunks_exact(12).enumerate() {
        canvas.put(index % width, index / width, [value(&texel[..4]), value(&texel[4..8]), value(&texel[8..])]);
    }
    Ok(canvas)
}

/// The channels of an OpenEXR file that say what its radiance is.
enum Colors {
    Rgb([String; 3]),
    Luminance(String),
}

fn read_exr(path: &Path, mut file: File) -> Result<Canvas> {
    let not_understood = |error: exr::error::Error| unreadable(path, error);
    let meta = MetaData::read_from_buffered(BufReader::new(&file), false).map_err(not_understood)?;
    let (header, colors) = find_colors(path, &meta.headers)?;
    // The picture is the display window; the file may have less of it or more.
    let display = header.shared_attributes.display_window;
    let size = [display.size.0, display.size.1].map(|edge| u32::try_from(edge).unwrap_or(u32::MAX));
    let offset = header.own_attributes.layer_position - display.position;
    check_size(path, size)?;
    let place = move |at: Vec2<usize>| [at.0 as i64 + i64::from(offset.0), at.1 as i64 + i64::from(offset.1)];
    file.rewind().map_err(|error| unreadable(path, error))?;
    let (buffered, levels) = (BufReader::new(file), exr::prelude::read().no_deep_data().largest_resolution_level());
    let canvas = match colors {
        Colors::Rgb([r, g, b]) => levels
            .specific_channels()
            .required(r.as_str())
            .required(g.as_str())
            .required(b.as_str())
            .collect_pixels(
                move |_, _| Canvas::new(size),
                move |canvas: &mut Canvas, at, (r, g, b): (f32, f32, f32)| canvas.put_inside(place(at), [r, g, b]),
            )
            .first_valid_layer()
            .all_attributes()
            .from_buffered(buffered)
            .map(|image| image.layer_data.channel_data.pixels),
        Colors::Luminance(y) => levels
            .specific_channels()
            .required(y.as_str())
            .collect_pixels(
                move |_, _| Canvas::new(size),
                move |canvas: &mut Canvas, at, (y,): (f32,)| canvas.put_inside(place(at), [y; 3]),
            )
            .first_valid_layer()
            .all_attributes()
            .from_buffered(buffered)
            .map(|image| image.layer_data.channel_data.pixels),
    };
    canvas.map_err(not_understood)
}

/// The first part of the file that has red, green and blue, else the first that has luminance. Names may have a layer's
/// name before them.
fn find_colors<'a>(path: &Path, headers: &'a [Header]) -> Result<(&'a Header, Colors)> {
    let names = |header: &Header| -> Vec<String> {
        header.channels.list.iter().filter(|c| c.sampling == Vec2(1, 1)).map(|c| c.name.to_string()).collect()
    };
    let prefix =
        |name: &str, base: &str| name.strip_suffix(base).filter(|p| p.is_empty() || p.ends_with('.')).map(String::from);
    for header in headers.iter().filter(|header| !header.deep) {
        let names = names(header);
        let red = names.iter().filter_map(|name| prefix(name, "R"));
        let complete = |layer: &String| ["G", "B"].iter().all(|base| names.contains(&format!("{layer}{base}")));
        // The layer without a name comes first.
        if let Some(layer) = red.filter(complete).min() {
            return Ok((header, Colors::Rgb(["R", "G", "B"].map(|base| format!("{layer}{base}")))));
        }
    }
    for header in headers.iter().filter(|header| !header.deep) {
        if let Some(layer) = names(header).iter().filter_map(|name| prefix(name, "Y")).min() {
            return Ok((header, Colors::Luminance(format!("{layer}Y"))));
        }
    }
    let all: Vec<String> = headers.iter().flat_map(|h| h.channels.list.iter().map(|c| c.name.to_string())).collect();
    let reason = format!("it has the channels {}, and neither R, G and B nor Y at full resolution", all.join(", "));
    Err(unreadable(path, reason))
}

#[cfg(test)]
#[path = "file_tests.rs"]
mod tests;
