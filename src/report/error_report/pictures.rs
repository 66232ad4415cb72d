//! The pictures of a stage as PNG.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::StageImages;
use crate::Result;
use crate::compare::false_color::{SCALE_BAR_PX, difference_map, scale_bar};
use crate::compare::{Image, Tone, diverging_color, heatmap, tone_map};
use crate::files::pictures::write_png;

/// The relative difference at the ends of the scale; the labels of the scale say the same.
const DIFFERENCE_RANGE: f32 = 0.5;
const DIFFERENCE_LABELS: [&str; 3] = ["-50%", "0", "+50%"];
/// The colour of pixels that are not finite.
const NOT_FINITE: [u8; 3] = [255, 0, 255];

/// A picture for the page.
pub struct Picture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// 8-bit sRGB, row by row.
    pub rgb: Vec<u8>,
}

/// What a stage shows.
pub struct StagePictures {
    /// The reference as shown.
    pub reference: Picture,
    /// The test as shown.
    pub test: Picture,
    /// The signed relative difference, with its scale.
    pub difference: Picture,
    /// The FLIP map, with its scale.
    pub flip: Picture,
}

impl StagePictures {
    /// The four pictures of a stage.
    pub fn new(images: &StageImages, exposure: f64) -> Self {
        let (width, height, rgb) = heatmap(&images.flip_map, images.reference.width);
        Self {
            reference: shown(&images.reference, exposure),
            test: shown(&images.test, exposure),
            difference: difference(images),
            flip: Picture { width, height, rgb },
        }
    }
}

impl Picture {
    /// A `data:` URL of the picture as PNG.
    ///
    /// # Errors
    /// [`crate::Error::Failure`] when it cannot be encoded.
    pub fn to_url(&self) -> Result<String> {
        let mut png = Vec::new();
        write_png(&mut png, self.width, self.height, &self.rgb, "")?;
        Ok(format!("data:image/png;base64,{}", STANDARD.encode(png)))
    }
}

fn shown(image: &Image, exposure: f64) -> Picture {
    let shown = tone_map(image, Tone::Reinhard { exposure });
    let byte = |value: f32| (255.0 * value).round() as u8;
    let color = |(pixel, radiance): (&[f32; 3], &[f32; 3])| {
        if radiance.iter().all(|v| v.is_finite()) { pixel.map(byte) } else { NOT_FINITE }
    };
    let rgb = shown.pixels().iter().zip(image.pixels()).flat_map(color).collect();
    Picture { width: image.width as u32, height: image.height as u32, rgb }
}

fn difference(images: &StageImages) -> Picture {
    let (width, height) = images.reference.size();
    let mut rgb = difference_map(&images.reference, &images.test, DIFFERENCE_RANGE);
    rgb.extend(scale_bar(width, |value| diverging_color(2.0 * value - 1.0), DIFFERENCE_LABELS));
    Picture { width: width as u32, height: (height + SCALE_BAR_PX) as u32, rgb }
}
