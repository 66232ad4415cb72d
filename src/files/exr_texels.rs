//! The colours of OpenEXR files, of whatever layers, channels and windows they are made.

use std::fs::File;
use std::io::{BufReader, Read, Seek};

use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::header::Header;
use exr::prelude::traits::*;

use super::guard::{could_hold, guarded};
use super::mistaken;

/// Takes the texels of an image one by one, in any order.
pub trait Texels: 'static {
    /// Whether a single channel of any name, such as depth, is a picture too.
    const ANY_CHANNEL: bool;
    /// For an image of this width and height, in which all is black. It should take no memory before the first texel.
    fn new(size: [u32; 2]) -> Self;
    /// A texel within the image.
    fn put(&mut self, at: [usize; 2], color: [f32; 3]);
}

/// What every OpenEXR file begins with.
const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
/// The most pixels of a display window, in those of the data window, whose data are not read twice.
const ROOM: usize = 4;
/// And the most whatever the data window.
const SMALL: usize = 1 << 20;

/// Takes no texels: for a file that is read to see whether it can be.
struct Nothing;

impl Texels for Nothing {
    const ANY_CHANNEL: bool = true;

    fn new(_: [u32; 2]) -> Self {
        Self
    }

    fn put(&mut self, _: [usize; 2], _: [f32; 3]) {}
}

/// The channels that say what the colour is.
enum Colors {
    Rgb([String; 3]),
    Gray(String),
}

/// Reads the display window of a file, black where the file has less of it. `check` may refuse its size.
///
/// # Errors
/// What is wrong, as a sentence about the file.
pub fn read_texels<T: Texels>(file: File, check: impl Fn([u32; 2]) -> Result<(), String>) -> Result<T, String> {
    guarded(|| read(file, check))
}

/// What a file says of itself, which it may hold in its bytes; the file is at its beginning again.
///
/// # Errors
/// What is wrong, as a sentence about the file.
pub fn read_meta(file: &mut File) -> Result<MetaData, String> {
    let mut start = Vec::new();
    (&*file).take(512).read_to_end(&mut start).map_err(|e| e.to_string())?;
    if !start.starts_with(&MAGIC) {
        return Err(mistaken(&start).unwrap_or("it is no OpenEXR file").to_owned());
    }
    file.rewind().map_err(|e| e.to_string())?;
    let meta = MetaData::read_from_buffered(BufReader::new(&*file), false).map_err(|e| told(&e))?;
    check_stored(&meta.headers, file.metadata().map_err(|e| e.to_string())?.len())?;
    file.rewind().map_err(|e| e.to_string())?;
    Ok(meta)
}

/// What is wrong with a file, in our words where the decoder's say little.
fn told(error: &exr::error::Error) -> String {
    let said = error.to_string();
    if said.contains("reference to missing bytes") { "it ends before its texels do".to_owned() } else { said }
}

fn read<T: Texels>(mut file: File, check: impl Fn([u32; 2]) -> Result<(), String>) -> Result<T, String> {
    let meta = read_meta(&mut file)?;
    let (header, colors) = find_colors(&meta.headers, T::ANY_CHANNEL)?;
    let display = header.shared_attributes.display_window;
    let size = [display.size.0, display.size.1].map(|edge| u32::try_from(edge).unwrap_or(u32::MAX));
    let offset = header.own_attributes.layer_position - display.position;
    check(size)?;
    let [shown, stored] = [display.size, header.layer_size].map(|size| size.0.saturating_mul(size.1));
    if shown > ROOM.saturating_mul(stored).max(SMALL) {
        // Little is stored and much asked for: first it is seen whether the little is whole.
        collect::<Nothing>(file.try_clone().map_err(|e| e.to_string())?, &colors, size, offset)?;
        file.rewind().map_err(|e| e.to_string())?;
    }
    collect(file, &colors, size, offset)
}

/// Reads the texels that lie within a picture of this size, into which the data are moved by `offset`.
fn collect<T: Texels>(file: File, colors: &Colors, size: [u32; 2], offset: Vec2<i32>) -> Result<T, String> {
    let put = move |texels: &mut T, at: Vec2<usize>, color: [f32; 3]| {
        let at = [at.0 as i64 + i64::from(offset.0), at.1 as i64 + i64::from(offset.1)];
        if (0..i64::from(size[0])).contains(&at[0]) && (0..i64::from(size[1])).contains(&at[1]) {
            texels.put(at.map(|c| c as usize), color);
        }
    };
    let (buffered, levels) = (BufReader::new(file), exr::prelude::read().no_deep_data().largest_resolution_level());
    let texels = match colors {
        Colors::Rgb([r, g, b]) => levels
            .specific_channels()
            .required(r.as_str())
            .required(g.as_str())
            .required(b.as_str())
            .collect_pixels(
                move |_, _| T::new(size),
                move |texels: &mut T, at, (r, g, b): (f32, f32, f32)| put(texels, at, [r, g, b]),
            )
            .first_valid_layer()
            .all_attributes()
            .from_buffered(buffered)
            .map(|image| image.layer_data.channel_data.pixels),
        Colors::Gray(y) => levels
            .specific_channels()
            .required(y.as_str())
            .collect_pixels(move |_, _| T::new(size), move |texels: &mut T, at, (y,): (f32,)| put(texels, at, [y; 3]))
            .first_valid_layer()
            .all_attributes()
            .from_buffered(buffered)
            .map(|image| image.layer_data.channel_data.pixels),
    };
    texels.map_err(|e| told(&e))
}

/// Whether the file may have what its parts announce: at least two bytes for each number.
fn check_stored(headers: &[Header], file_bytes: u64) -> Result<(), String> {
    for header in headers {
        let [width, height] = [header.layer_size.0, header.layer_size.1].map(|edge| edge as u64);
        let numbers = width.saturating_mul(height).saturating_mul(header.channels.list.len() as u64);
        if !could_hold(file_bytes, numbers.saturating_mul(2)) {
            return Err(format!("it cannot have the {width}x{height} pixels that it announces in {file_bytes} bytes"));
        }
    }
    Ok(())
}

/// The first part of the file that has red, green and blue, else the first that has luminance, else where
/// that is enough the first that has one channel of any name. Names may have a layer's name before them.
fn find_colors(headers: &[Header], any_channel: bool) -> Result<(&Header, Colors), String> {
    let names = |header: &Header| -> Vec<String> {
        header.channels.list.iter().filter(|c| c.sampling == Vec2(1, 1)).map(|c| c.name.to_string()).collect()
    };
    let prefix =
        |name: &str, base: &str| name.strip_suffix(base).filter(|p| p.is_empty() || p.ends_with('.')).map(String::from);
    let flat: Vec<&Header> = headers.iter().filter(|header| !header.deep).collect();
    if flat.is_empty() {
        return Err("it holds deep data alone, which are not read".into());
    }
    for header in &flat {
        let names = names(header);
        let red = names.iter().filter_map(|name| prefix(name, "R"));
        let complete = |layer: &String| ["G", "B"].iter().all(|base| names.contains(&format!("{layer}{base}")));
        // The layer without a name comes first.
        if let Some(layer) = red.filter(complete).min() {
            return Ok((header, Colors::Rgb(["R", "G", "B"].map(|base| format!("{layer}{base}")))));
        }
    }
    for header in &flat {
        if let Some(layer) = names(header).iter().filter_map(|name| prefix(name, "Y")).min() {
            return Ok((header, Colors::Gray(format!("{layer}Y"))));
        }
    }
    for header in flat.iter().filter(|_| any_channel) {
        if let [name] = names(header).as_slice() {
            return Ok((header, Colors::Gray(name.clone())));
        }
    }
    let all: Vec<String> = headers.iter().flat_map(|h| h.channels.list.iter().map(|c| c.name.to_string())).collect();
    Err(format!("it has the channels {}, and neither R, G and B nor Y at full resolution", all.join(", ")))
}
