//! Images in KTX2 files: level 0 of a 2D texture, decoded to RGBA8.
//!
//! The transfer function of such a file changes nothing. Whether texels are sRGB or linear follows from what a material
//! uses them for, as with every other format of glTF.

mod basis;
mod level;
#[cfg(test)]
mod tests;
mod texels;

use std::io::Read;

use ktx2::dfd::DataFormatFlags;
use ktx2::{ColorModel, Header, ParseError, Reader, SupercompressionScheme};

use crate::files::guard::MAX_IMAGE_EDGE;
use texels::Texels;

/// What every KTX file begins with, of whatever version.
pub(super) const MAGIC: &[u8] = b"\xabKTX ";

/// Texels, in bytes, for which memory is taken without looking first whether a compressed level holds them: beyond, the
/// level is decoded twice. Together with what `level` allows a decoder this is 64 MiB.
const UNPROVEN_BYTES: u64 = 16 << 20;
/// Longest data format descriptor that is read, in bytes: that of a format with six channels has 124.
const MOST_DESCRIPTOR_BYTES: u32 = 1 << 16;
/// Rows that are decoded at a time: whole blocks.
const STRIP_ROWS: u32 = 64;

/// Width and height that a KTX2 file announces.
pub(super) fn announced_size(file: &[u8]) -> Option<[u32; 2]> {
    let header = Header::from_bytes(file.first_chunk()?).ok()?;
    Some([header.pixel_width, header.pixel_height])
}

/// Width, height and RGBA8 texels of a file. Panics where a decoder does: callers guard it.
pub(super) fn decode(file: &[u8]) -> Result<([u32; 2], Vec<u8>), String> {
    let head = file.first_chunk().ok_or(ParseError::UnexpectedEnd);
    let header = head.and_then(Header::from_bytes).map_err(|error| broken(&error))?;
    check_shape(&header)?;
    let reader = Reader::new(file).map_err(|error| broken(&error))?;
    check_metadata(&reader)?;
    let size = [header.pixel_width, header.pixel_height];
    let rgba_bytes = 4 * u64::from(size[0]) * u64::from(size[1]);
    let is_proven = header.supercompression_scheme.is_none() || rgba_bytes <= UNPROVEN_BYTES;
    let texels = match content(&reader)? {
        Content::Etc1s => return Ok((size, basis::decode_etc1s(file, is_proven)?)),
        Content::Texels(texels) => texels,
    };
    let decode = |rgba| {
        let mut source = level::open(&reader, texels.byte_count(size))?;
        decode_strips(&mut source, texels, size, rgba)
    };
    if !is_proven {
        decode(None)?;
    }
    let mut rgba = Vec::with_capacity(rgba_bytes as usize);
    decode(Some(&mut rgba))?;
    Ok((size, rgba))
}

/// Decodes all rows of a level, into `rgba` if there is one, and checks that the level ends after them.
fn decode_strips(
    source: &mut dyn Read,
    texels: Texels,
    [width, height]: [u32; 2],
    mut rgba: Option<&mut Vec<u8>>,
) -> Result<(), String> {
    let damaged = |error: std::io::Error| format!("its texels are damaged: {error}");
    let mut strip = Vec::new();
    for row in (0..height).step_by(STRIP_ROWS as usize) {
        let size = [width, STRIP_ROWS.min(height - row)];
        strip.resize(texels.byte_count(size) as usize, 0);
        source.read_exact(&mut strip).map_err(damaged)?;
        let decoded = texels.decode(&strip, size)?;
        if let Some(rgba) = &mut rgba {
            rgba.extend_from_slice(&decoded);
        }
    }
    match source.read(&mut [0]).map_err(damaged)? {
        0 => Ok(()),
        _ => Err("its first level holds more than it announces".to_owned()),
    }
}

fn broken(error: &ParseError) -> String {
    match error {
        ParseError::BadMagic => "it is a KTX file of another version than 2".to_owned(),
        ParseError::UnexpectedEnd => "it ends before what its header and its list of levels announce".to_owned(),
        ParseError::ZeroWidth => "it has no pixels".to_owned(),
        error => format!("its header is damaged: {error}"),
    }
}

/// Refuses all but one 2D image of a size that is read. A descriptor takes more memory than space in the file.
fn check_shape(header: &Header) -> Result<(), String> {
    let descriptor_bytes = header.index.dfd_byte_length;
    if descriptor_bytes > MOST_DESCRIPTOR_BYTES {
        return Err(format!("its data format descriptor of {descriptor_bytes} bytes is too long"));
    }
    let kind = match header {
        Header { pixel_height: 0, .. } => "a 1D texture",
        Header { pixel_depth: 1.., .. } => "a 3D texture",
        Header { layer_count: 2.., .. } => "an array of textures",
        Header { face_count: 2.., .. } => "a cube map",
        _ => {
            let [width, height] = [header.pixel_width, header.pixel_height];
            if width > MAX_IMAGE_EDGE || height > MAX_IMAGE_EDGE {
                return Err(format!("it has {width}x{height} pixels, and {MAX_IMAGE_EDGE} are the most on a side"));
            }
            return Ok(());
        }
    };
    Err(format!("it is {kind}, and only single 2D images are read"))
}

/// Refuses what `KHR_texture_basisu` forbids: texels in another order, and colours multiplied by their alpha.
fn check_metadata(reader: &Reader<&[u8]>) -> Result<(), String> {
    for (key, value) in reader.key_value_data() {
        let value = String::from_utf8_lossy(value);
        let value = value.trim_end_matches('\0');
        let wanted = match key {
            "KTXorientation" => "rd",
            "KTXswizzle" => "rgba",
            _ => continue,
        };
        if value != wanted {
            let value: String = value.chars().take(20).collect();
            return Err(format!("its {key} is {value:?}, and only {wanted} is read"));
        }
    }
    let flags = reader.basic_dfd().map(|dfd| dfd.flags);
    if flags.is_some_and(|flags| flags.contains(DataFormatFlags::ALPHA_PREMULTIPLIED)) {
        return Err("its colours are multiplied by their alpha, which glTF does not allow".to_owned());
    }
    Ok(())
}

/// What a file's level holds.
enum Content {
    /// Which only all of the file together makes sense of.
    Etc1s,
    Texels(Texels),
}

fn content(reader: &Reader<&[u8]>) -> Result<Content, String> {
    let header = reader.header();
    let (name, content) = match (header.format, reader.color_model()) {
        (Some(format), _) => (format!("{format:?}"), Texels::of_format(format).map(Content::Texels)),
        (None, Some(ColorModel::ETC1S)) => ("ETC1S".to_owned(), Some(Content::Etc1s)),
        (None, Some(ColorModel::UASTC)) => ("UASTC".to_owned(), Some(Content::Texels(Texels::UASTC))),
        (None, Some(model)) => (format!("{model:?} without a Vulkan format"), None),
        (None, None) => return Err("it names no format".to_owned()),
    };
    let content = content.ok_or_else(|| format!("its format {name} is not read"))?;
    let is_basis_lz = header.supercompression_scheme == Some(SupercompressionScheme::BasisLZ);
    match content {
        Content::Etc1s if !is_basis_lz => Err("its ETC1S is not supercompressed by BasisLZ".to_owned()),
        Content::Texels(_) if is_basis_lz => {
            Err(format!("its {name} is supercompressed by BasisLZ, which is for ETC1S"))
        }
        content => Ok(content),
    }
}
