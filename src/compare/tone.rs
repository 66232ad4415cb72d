//! From radiance to what is shown, the same for both pictures.

use super::image::Image;

/// The grey that the log-average of a picture is exposed to (Reinhard et al. 2002).
const MIDDLE_GREY: f64 = 0.18;

/// How linear values become display values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tone {
    /// Radiance: one exposure, then Reinhard's x / (1 + x) in each channel, then sRGB.
    Reinhard {
        /// Factor on the radiance.
        exposure: f64,
    },
    /// Values that were decoded from a display-ready picture: sRGB alone, which gives that picture back.
    Srgb,
}

impl Tone {
    /// The exposure, where there is one.
    #[must_use]
    pub fn exposure(self) -> Option<f64> {
        match self {
            Self::Reinhard { exposure } => Some(exposure),
            Self::Srgb => None,
        }
    }
}

/// The log-average of pictures: of their finite, non-black pixels (mean of the channels).
#[derive(Clone, Copy, Debug, Default)]
pub struct LogAverage {
    sum: f64,
    count: f64,
}

impl LogAverage {
    /// Adds a picture.
    pub fn add(&mut self, picture: &Image) {
        for pixel in picture.pixels() {
            let mean = pixel.iter().map(|&v| f64::from(v)).sum::<f64>() / 3.0;
            if mean > 0.0 && mean.is_finite() {
                self.sum += mean.ln();
                self.count += 1.0;
            }
        }
    }

    /// 0.18 over the log-average; 1 if there are no such pixels.
    #[must_use]
    pub fn exposure(&self) -> f64 {
        if self.count > 0.0 { MIDDLE_GREY / f64::exp(self.sum / self.count) } else { 1.0 }
    }
}

/// 0.18 over the log-average of the picture's finite, non-black pixels (mean of the channels); 1 if there are none.
#[must_use]
pub fn auto_exposure(reference: &Image) -> f64 {
    let mut average = LogAverage::default();
    average.add(reference);
    average.exposure()
}

/// Display values (sRGB, 0 to 1) of linear ones. Negative values are black; NaN stays NaN.
#[must_use]
pub fn tone_map(image: &Image, tone: Tone) -> Image {
    image.map(|value| {
        let value = f64::from(value);
        let shown = match tone {
            Tone::Reinhard { exposure } => reinhard(value.max(0.0) * exposure),
            Tone::Srgb => value.clamp(0.0, 1.0),
        };
        if value.is_nan() { f32::NAN } else { encode_srgb(shown) as f32 }
    })
}

fn reinhard(value: f64) -> f64 {
    if value.is_infinite() { 1.0 } else { value / (1.0 + value) }
}

/// The sRGB encoding of IEC 61966-2-1.
fn encode_srgb(value: f64) -> f64 {
    if value <= 0.003_130_8 { 12.92 * value } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 }
}

/// The inverse of the sRGB encoding.
pub(super) fn decode_srgb(value: f32) -> f32 {
    if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::testing::image;

    #[test]
    fn tone_mapping_by_hand() {
        // 3 * 1 / (1 + 3) = 0.75; 1.055 * 0.75^(1/2.4) - 0.055 = 0.8808.
        let shown = tone_map(&image(1, 1, |_, _, c| [3.0, -1.0, f32::INFINITY][c]), Tone::Reinhard { exposure: 1.0 });
        assert!((shown.rgb[0] - 0.8808).abs() < 1e-4, "{shown:?}");
        assert_eq!(shown.rgb[1..], [0.0, 1.0]);
        let shown = tone_map(&image(1, 1, |_, _, c| [6.0, 0.002, f32::NAN][c]), Tone::Reinhard { exposure: 0.5 });
        assert!((shown.rgb[0] - 0.8808).abs() < 1e-4 && (shown.rgb[1] - 0.012_907).abs() < 1e-5, "{shown:?}");
        assert!(shown.rgb[2].is_nan());
    }

    #[test]
    fn display_ready_values_come_back() {
        let bytes = image(16, 16, |x, y, _| (16 * y + x) as f32 / 255.0);
        let shown = tone_map(&bytes.map(decode_srgb), Tone::Srgb);
        assert!(shown.rgb.iter().zip(&bytes.rgb).all(|(a, b)| (a - b).abs() < 1e-6));
    }

    #[test]
    fn auto_exposure_is_a_log_average_of_what_is_not_black() {
        // Means 1, 4 and black, infinite: log-average 2, exposure 0.09.
        let picture = image(4, 1, |x, _, _| [1.0, 4.0, 0.0, f32::INFINITY][x]);
        assert!((auto_exposure(&picture) - 0.09).abs() < 1e-9);
        assert_eq!(auto_exposure(&image(2, 2, |_, _, _| 0.0)).to_bits(), 1.0_f64.to_bits());
    }
}
