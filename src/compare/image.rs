//! A picture to compare.

use std::path::Path;

use super::tone::decode_srgb;
use crate::files::FileKind;
use crate::files::pictures::{read_exr, read_png};
use crate::{Error, Result};

/// A picture: RGB, row 0 at the top, linear radiance unless said otherwise.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// `3 * width * height` values.
    pub rgb: Vec<f32>,
}

impl Image {
    /// A picture of these values.
    ///
    /// # Errors
    /// [`Error::Failure`] when `rgb` is not `3 * width * height` long or there are no pixels.
    pub fn new(width: usize, height: usize, rgb: Vec<f32>) -> Result<Self> {
        if rgb.is_empty() || rgb.len() != 3 * width * height {
            return Err(Error::Failure(format!("a picture of {width}x{height} cannot have {} values", rgb.len())));
        }
        Ok(Self { width, height, rgb })
    }

    /// Reads linear radiance: an EXR as it is, a PNG decoded from sRGB.
    ///
    /// # Errors
    /// [`Error::File`] when it cannot be read, [`Error::Usage`] when the extension is neither `.exr` nor `.png`.
    pub fn read(path: &Path) -> Result<Self> {
        let (width, height, rgb) = match FileKind::of(path) {
            Some(FileKind::Exr) => read_exr(path)?,
            Some(FileKind::Png) => {
                let (width, height, bytes) = read_png(path)?;
                let rgb = bytes.iter().map(|&byte| decode_srgb(f32::from(byte) / 255.0)).collect();
                (width, height, rgb)
            }
            _ => return Err(Error::Usage(format!("{} must end in .exr or .png", path.display()))),
        };
        Self::new(width as usize, height as usize, rgb)
    }

    /// The pixels, row by row.
    #[must_use]
    pub fn pixels(&self) -> &[[f32; 3]] {
        self.rgb.as_chunks().0
    }

    /// Width and height in pixels.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// The same picture with every value passed through `change`.
    #[must_use]
    pub fn map(&self, change: impl Fn(f32) -> f32) -> Self {
        Self { width: self.width, height: self.height, rgb: self.rgb.iter().map(|&value| change(value)).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::OutputFile;
    use crate::files::pictures::Picture;

    fn pixel(radiance: Vec<f32>, srgb: Vec<u8>) -> Picture {
        Picture { width_px: 1, height_px: 1, radiance, srgb, ..Picture::default() }
    }

    #[test]
    fn png_is_decoded_and_exr_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let (png, exr) = (folder.path().join("a.png"), folder.path().join("a.exr"));
        OutputFile::create(&png).unwrap().commit_picture(&pixel(vec![], vec![0, 188, 255])).unwrap();
        OutputFile::create(&exr).unwrap().commit_picture(&pixel(vec![0.5, 7.0, -1.0], vec![])).unwrap();
        let image = Image::read(&png).unwrap();
        // 188 / 255 is 0.7373; ((0.7373 + 0.055) / 1.055)^2.4 = 0.5029.
        assert!((image.rgb[1] - 0.5029).abs() < 1e-4 && image.rgb[0] == 0.0 && image.rgb[2] == 1.0, "{image:?}");
        assert_eq!(Image::read(&exr).unwrap().pixels(), [[0.5, 7.0, -1.0]]);
    }

    #[test]
    fn png_of_every_format_is_the_same_picture() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let grey = |x: u32, y: u32| (50 * x + 20 * y) as u8;
        image::RgbImage::from_fn(4, 3, |x, y| image::Rgb([grey(x, y); 3])).save(path("rgb.png")).unwrap();
        image::GrayImage::from_fn(4, 3, |x, y| image::Luma([grey(x, y)])).save(path("grey.png")).unwrap();
        let sixteen = |x, y| 257 * u16::from(grey(x, y));
        let with_alpha = |x, y| image::LumaA([sixteen(x, y), 9000]);
        image::ImageBuffer::from_fn(4, 3, with_alpha).save(path("grey-alpha-16.png")).unwrap();
        let with_alpha = |x, y| image::Rgba([sixteen(x, y), sixteen(x, y), sixteen(x, y), 0]);
        image::ImageBuffer::from_fn(4, 3, with_alpha).save(path("rgba-16.png")).unwrap();
        let plain = Image::read(&path("rgb.png")).unwrap();
        assert!(plain.pixels()[0] == [0.0; 3] && plain.pixels()[11][0] > 0.4, "{plain:?}");
        for name in ["grey.png", "grey-alpha-16.png", "rgba-16.png"] {
            assert_eq!(Image::read(&path(name)).unwrap(), plain, "{name}");
        }
    }

    #[test]
    fn wrong_lengths_and_names_are_errors() {
        assert!(Image::new(2, 1, vec![0.0; 5]).is_err());
        assert!(Image::new(0, 1, Vec::new()).is_err());
        assert_eq!(Image::read(Path::new("a.jpg")).unwrap_err().exit_code(), 2);
    }
}
