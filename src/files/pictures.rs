//! Pictures as files: OpenEXR for linear radiance, PNG for looking at. Row 0 is at the top.

use std::io::{Cursor, Seek, Write};
use std::path::Path;

use exr::image::SpecificChannels;
use exr::image::write::WritableImage;
use exr::math::Vec2;
use exr::meta::attribute::Text;
use image::ImageFormat;

use super::exr_texels::{Texels, read_texels};
use super::guard::decode_image;
use super::{FileKind, OutputFile, open_regular, read_whole};
use crate::{Error, Result};

/// A finished picture in both forms.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Width.
    pub width_px: u32,
    /// Height.
    pub height_px: u32,
    /// Linear radiance, RGB.
    pub radiance: Vec<f32>,
    /// Ready for display, sRGB, RGB.
    pub srgb: Vec<u8>,
    /// What made it; goes into the file.
    pub note: String,
}

/// Writes linear RGB radiance as 32-bit float OpenEXR, untouched; the note becomes the attribute `comments`.
///
/// # Errors
/// [`Error::Failure`] when `rgb` is not `3 * width * height` long, there are no pixels, or writing fails.
pub fn write_exr(writer: impl Write + Seek, width: u32, height: u32, rgb: &[f32], note: &str) -> Result<()> {
    check_length(width, height, rgb.len())?;
    let size = Vec2(width as usize, height as usize);
    let texel = |at: Vec2<usize>| {
        let i = 3 * (at.1 * size.0 + at.0);
        (rgb[i], rgb[i + 1], rgb[i + 2])
    };
    let mut picture = exr::image::Image::from_channels(size, SpecificChannels::rgb(texel));
    picture.layer_data.attributes.comments = Text::new_or_none(note);
    // In order, so that equal pictures are equal files.
    picture.write().non_parallel().to_buffered(writer).map_err(|error| failed(&error))
}

/// Writes display-ready sRGB as 8-bit RGB PNG; the note becomes the text chunk `Comment`.
///
/// # Errors
/// [`Error::Failure`] when `rgb` is not `3 * width * height` long, there are no pixels, or writing fails.
pub fn write_png(writer: impl Write, width: u32, height: u32, rgb: &[u8], note: &str) -> Result<()> {
    check_length(width, height, rgb.len())?;
    let mut encoder = png::Encoder::new(writer, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let write = || {
        encoder.add_itxt_chunk("Comment".to_owned(), note.to_owned())?;
        encoder.write_header()?.write_image_data(rgb)
    };
    write().map_err(|error| failed(&error))
}

/// Width, height and linear RGB of an OpenEXR file; grey where it has one channel, of the first layer where it has several.
///
/// # Errors
/// [`Error::File`] when it cannot be read or understood.
pub fn read_exr(path: impl AsRef<Path>) -> Result<(u32, u32, Vec<f32>)> {
    let path = path.as_ref();
    let file = open_regular(path).map_err(|error| Error::file(path, error))?;
    let picture: Rgb = read_texels(file, |[width, height]| {
        let count = u64::from(width) * u64::from(height);
        if (1..=MAX_TEXELS).contains(&count) {
            return Ok(());
        }
        Err(format!("its size is {width}x{height}, and {MAX_TEXELS} pixels are the most that are read"))
    })
    .map_err(|reason| Error::file(path, reason))?;
    let Rgb { width, height, mut values } = picture;
    values.resize(3 * width as usize * height as usize, 0.0);
    Ok((width, height, values))
}

/// The most pixels of an OpenEXR file.
const MAX_TEXELS: u64 = 1 << 28;

/// A picture while it is read.
struct Rgb {
    width: u32,
    height: u32,
    /// Empty before the first texel: a file that has none may be of any size.
    values: Vec<f32>,
}

impl Texels for Rgb {
    const ANY_CHANNEL: bool = true;

    fn new([width, height]: [u32; 2]) -> Self {
        Self { width, height, values: Vec::new() }
    }

    fn put(&mut self, [x, y]: [usize; 2], color: [f32; 3]) {
        if self.values.is_empty() {
            self.values = vec![0.0; 3 * self.width as usize * self.height as usize];
        }
        let first = 3 * (y * self.width as usize + x);
        self.values[first..first + 3].copy_from_slice(&color);
    }
}

/// Width, height and 8-bit RGB of a PNG file.
///
/// # Errors
/// [`Error::File`] when it cannot be read or understood.
pub fn read_png(path: impl AsRef<Path>) -> Result<(u32, u32, Vec<u8>)> {
    let path = path.as_ref();
    let bytes = read_whole(path, || false).map_err(|error| Error::file(path, error))?;
    let rgb = decode_image(&bytes, ImageFormat::Png).map_err(|error| Error::file(path, error))?.into_rgb8();
    Ok((rgb.width(), rgb.height(), rgb.into_raw()))
}

impl OutputFile {
    /// Writes a finished picture: radiance where the file is an EXR, else what is ready for display.
    ///
    /// # Errors
    /// Those of [`write_exr`], [`write_png`] and [`OutputFile::commit`].
    pub fn commit_picture(self, picture: &Picture) -> Result<()> {
        let Picture { width_px, height_px, radiance, srgb, note } = picture;
        let mut bytes = Cursor::new(Vec::new());
        if self.kind() == FileKind::Exr {
            write_exr(&mut bytes, *width_px, *height_px, radiance, note)?;
        } else {
            write_png(&mut bytes, *width_px, *height_px, srgb, note)?;
        }
        self.commit(&bytes.into_inner())
    }
}

fn check_length(width: u32, height: u32, length: usize) -> Result<()> {
    if length > 0 && length as u64 == 3 * u64::from(width) * u64::from(height) {
        return Ok(());
    }
    Err(Error::Failure(format!("a picture of {width}x{height} cannot have {length} values")))
}

fn failed(error: &dyn std::fmt::Display) -> Error {
    Error::Failure(format!("the picture could not be encoded: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exr(width: u32, height: u32, rgb: &[f32]) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        write_exr(&mut bytes, width, height, rgb, "").unwrap();
        bytes.into_inner()
    }

    #[test]
    fn exr_round_trips_bit_for_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let mut rgb: Vec<f32> = (0..3 * 5 * 7).map(|i| i as f32 * 1.37 - 20.0).collect();
        (rgb[4], rgb[8], rgb[9]) = (f32::NAN, f32::INFINITY, 1e-40);
        let picture = Picture {
            width_px: 5,
            height_px: 7,
            radiance: rgb.clone(),
            note: "made here".to_owned(),
            ..Picture::default()
        };
        OutputFile::create(&path).unwrap().commit_picture(&picture).unwrap();
        let meta = exr::meta::MetaData::read_from_file(&path, false).unwrap();
        assert_eq!(meta.headers[0].own_attributes.comments.as_ref().unwrap().to_string(), "made here");
        let (width, height, found) = read_exr(&path).unwrap();
        assert_eq!((width, height), (5, 7));
        let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert!(found[4].is_nan());
        assert_eq!(bits(&found), bits(&rgb));
    }

    /// Files of one channel, of named layers and of several parts, as renderers write them.
    #[test]
    fn exr_layers_and_single_channels_are_read() {
        use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer};
        use exr::meta::attribute::IntegerBounds;
        use exr::meta::header::{ImageAttributes, LayerAttributes};

        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let size = Vec2(3, 2);
        let layer = |part: &str, names: &[&str]| {
            let channel = |name: &&str| {
                let value = f32::from(name.as_bytes()[name.len() - 1]);
                AnyChannel::new(*name, FlatSamples::F32((0..6).map(|i| value + i as f32).collect()))
            };
            let channels = AnyChannels::sort(names.iter().map(channel).collect());
            Layer::new(size, LayerAttributes::named(Text::from(part)), Encoding::UNCOMPRESSED, channels)
        };
        let grey = |name: &str| [f32::from(name.as_bytes()[name.len() - 1]); 3];
        let colour = [b'R', b'G', b'B'].map(f32::from);
        for (parts, first) in [
            (vec![layer("a", &["Y"])], grey("Y")),
            (vec![layer("a", &["Z"])], grey("Z")),
            (vec![layer("a", &["A", "Y"])], grey("Y")),
            (vec![layer("a", &["diffuse.B", "diffuse.G", "diffuse.R", "Z"])], colour),
            (vec![layer("depth", &["Z"]), layer("beauty", &["B", "G", "R"])], colour),
        ] {
            let attributes = ImageAttributes::new(IntegerBounds::from_dimensions(size));
            let image = Image::from_layers(attributes, parts);
            image.write().to_file(&path).unwrap();
            let (width, height, rgb) = read_exr(&path).unwrap();
            assert_eq!((width, height, &rgb[..3]), (3, 2, &first[..]));
            assert_eq!(rgb[15], first[0] + 5.0);
        }
        let image = Image::from_layer(layer("a", &["U", "V"]));
        image.write().to_file(&path).unwrap();
        let refused = read_exr(&path).unwrap_err().to_string();
        assert!(refused.contains("it has the channels U, V, and neither"), "{refused}");
    }

    /// A small picture of noise is one uncompressed block at the end of the file: each line, top first, as all of
    /// its B, then its G, then its R. That this is so makes every other reader see row 0 at the top.
    #[test]
    fn exr_row_zero_is_at_the_top() {
        let (width, height) = (2, 3);
        let rgb: Vec<f32> = (1..=3 * width * height).map(|i| (i as f32).sqrt().sin()).collect();
        let mut block = Vec::new();
        for row in rgb.chunks(3 * width) {
            for channel in [2, 1, 0] {
                block.extend(row.iter().skip(channel).step_by(3).flat_map(|value| value.to_le_bytes()));
            }
        }
        assert!(exr(width as u32, height as u32, &rgb).ends_with(&block));
    }

    #[test]
    fn png_round_trips() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let rgb: Vec<u8> = (0..3 * 4 * 2).map(|i| i * 9).collect();
        let picture = Picture {
            width_px: 4,
            height_px: 2,
            srgb: rgb.clone(),
            note: "made h\u{e9}re".to_owned(),
            ..Picture::default()
        };
        OutputFile::create(&path).unwrap().commit_picture(&picture).unwrap();
        let reader =
            png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&path).unwrap())).read_info().unwrap();
        assert_eq!(reader.info().utf8_text[0].get_text().unwrap(), "made h\u{e9}re");
        assert_eq!(read_png(&path).unwrap(), (4, 2, rgb));
    }

    /// Grey, palettes, alpha and 16 bits: the colours are those of the picture in 8 bits of RGB.
    #[test]
    fn every_format_of_png_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let write = |color, depth, palette: Option<&[u8]>, data: &[u8]| {
            let mut encoder = png::Encoder::new(std::fs::File::create(&path).unwrap(), 2, 1);
            encoder.set_color(color);
            encoder.set_depth(depth);
            palette.into_iter().for_each(|palette| encoder.set_palette(palette.to_vec()));
            encoder.write_header().unwrap().write_image_data(data).unwrap();
            read_png(&path).unwrap().2
        };
        let (gray, eight, sixteen) = ([51, 51, 51, 204, 204, 204], png::BitDepth::Eight, png::BitDepth::Sixteen);
        assert_eq!(write(png::ColorType::Grayscale, eight, None, &[51, 204]), gray);
        assert_eq!(write(png::ColorType::Grayscale, sixteen, None, &[51, 51, 204, 204]), gray);
        assert_eq!(write(png::ColorType::GrayscaleAlpha, eight, None, &[51, 9, 204, 0]), gray);
        assert_eq!(write(png::ColorType::GrayscaleAlpha, sixteen, None, &[51, 51, 9, 9, 204, 204, 0, 0]), gray);
        let colors = [1, 2, 3, 4, 5, 6];
        assert_eq!(write(png::ColorType::Indexed, png::BitDepth::One, Some(&colors), &[0b0100_0000]), colors);
        assert_eq!(write(png::ColorType::Rgba, eight, None, &[1, 2, 3, 0, 4, 5, 6, 99]), colors);
        let wide: Vec<u8> = colors.iter().flat_map(|byte| [*byte, *byte]).collect();
        assert_eq!(write(png::ColorType::Rgb, sixteen, None, &wide), colors);
    }

    /// A small part of a large picture is read; where it is damaged nothing of that size is made.
    #[test]
    fn a_small_part_of_a_large_picture() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let mut small = exr(8, 8, &[0.5; 192]);
        let display = (0..small.len() - 16).rfind(|at| small[*at..].starts_with(b"displayWindow\0")).unwrap();
        small[display + 32..display + 36].copy_from_slice(&200_000_u32.to_le_bytes());
        std::fs::write(&path, &small).unwrap();
        let (width, height, rgb) = read_exr(&path).unwrap();
        assert_eq!((width, height, rgb[0], rgb[21], rgb[24]), (200_001, 8, 0.5, 0.5, 0.0));
        small.truncate(small.len() - 3);
        std::fs::write(&path, &small).unwrap();
        assert!(read_exr(&path).is_err());
    }

    /// Few bytes that announce much are refused before there is room for it.
    #[test]
    fn sizes_that_a_file_cannot_have_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let mut small = exr(8, 8, &[0.5; 192]);
        // Data window and display window: 8x8 becomes 16001x16001.
        let window = [0_u32, 0, 7, 7].map(u32::to_le_bytes).concat();
        let places: Vec<usize> = (0..small.len() - 16).filter(|at| small[*at..at + 16] == window).collect();
        assert_eq!(places.len(), 2);
        for at in places {
            small[at + 8..at + 16].copy_from_slice(&[16_000_u32, 16_000].map(u32::to_le_bytes).concat());
        }
        std::fs::write(&path, small).unwrap();
        let refused = read_exr(&path).unwrap_err().to_string();
        assert!(refused.contains("it cannot have the 16001x16001 pixels"), "{refused}");
        let path = folder.path().join("a.png");
        let mut png = Vec::new();
        write_png(&mut png, 2, 2, &[9; 12], "").unwrap();
        png[16..24].copy_from_slice(&[16_000_u32, 16_000].map(u32::to_be_bytes).concat());
        let (header, sum) = (&png[12..29], png[29..33].to_vec());
        let right = !header.iter().fold(u32::MAX, |sum, byte| {
            (0..8).fold(sum ^ u32::from(*byte), |sum, _| (sum >> 1) ^ (0xedb8_8320 * (sum & 1)))
        });
        assert_ne!(sum, right.to_be_bytes());
        png[29..33].copy_from_slice(&right.to_be_bytes());
        std::fs::write(&path, png).unwrap();
        let refused = read_png(&path).unwrap_err().to_string();
        assert!(refused.contains("it cannot have the 16000x16000 pixels"), "{refused}");
    }

    #[test]
    fn wrong_lengths_and_files_are_errors() {
        assert!(write_exr(Cursor::new(Vec::new()), 2, 2, &[0.0; 11], "").is_err());
        assert!(write_png(Vec::new(), 0, 2, &[], "").is_err());
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        assert!(read_exr(&path).is_err());
        let whole = exr(8, 8, &[0.5; 192]);
        std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
        let cut = read_exr(&path).unwrap_err();
        assert_eq!(cut.exit_code(), 1);
        assert!(cut.to_string().ends_with("a.exr: it ends before its texels do"), "{cut}");
        assert!(read_png(&path).is_err());
        for (bytes, what) in [
            (&b""[..], "it is empty"),
            (b"\x89PNG\r\n\x1a\n", "it is no OpenEXR file"),
            (b"<html>", "it is a web page"),
        ] {
            std::fs::write(&path, bytes).unwrap();
            let error = read_exr(&path).unwrap_err().to_string();
            assert!(error.ends_with(&format!("a.exr: {what}")), "{error}");
        }
        std::fs::write(&path, "version https://git-lfs.github.com/spec/v1").unwrap();
        assert!(read_png(&path).unwrap_err().to_string().contains("Git LFS"));
    }
}
