//! False colours: magma for errors, red and blue for signed differences, and pictures with their scale bar.

use super::image::Image;

/// Height of the scale bar below a heat map, its labels included.
pub const SCALE_BAR_PX: usize = 20;
/// Height of the coloured part of the scale bar.
const BAR_PX: usize = 8;
/// Pixels of a picture for each dot of a label.
const DOT_PX: usize = 2;
/// Columns and rows of dots of a character.
const GLYPH_DOTS: (usize, usize) = (3, 5);

/// The colour (sRGB) of an error from 0 to 1 in the perceptually uniform scale magma, black to pale yellow.
#[must_use]
pub fn false_color(value: f32) -> [u8; 3] {
    colorous::MAGMA.eval_continuous(unit(value)).into_array()
}

/// The colour (sRGB) of a signed difference from -1 to 1: blue below zero, white, red above.
#[must_use]
pub fn diverging_color(value: f32) -> [u8; 3] {
    colorous::RED_BLUE.eval_continuous(1.0 - unit(0.5 + 0.5 * value)).into_array()
}

fn unit(value: f32) -> f64 {
    if value.is_nan() { 0.0 } else { f64::from(value).clamp(0.0, 1.0) }
}

/// Width, height and 8-bit sRGB of an error map (0 to 1, row by row) in [`false_color`], a scale bar below it.
///
/// The bar is labelled 0, 0.5 and 1 where the map is wide enough.
#[must_use]
pub fn heatmap(errors: &[f32], width: usize) -> (u32, u32, Vec<u8>) {
    let mut rgb: Vec<u8> = errors.iter().flat_map(|&error| false_color(error)).collect();
    rgb.extend(scale_bar(width, false_color, ["0", "0.5", "1"]));
    let height = errors.len() / width + SCALE_BAR_PX;
    (width as u32, height as u32, rgb)
}

/// How a test differs from a reference: (t - r) / (r + 0.1 mean(r)) of the channels' means, in [`diverging_color`]
/// from -`range` to `range`, 8-bit sRGB, row by row. Grey where a picture is not finite or the reference black.
#[must_use]
pub fn difference_map(reference: &Image, test: &Image, range: f32) -> Vec<u8> {
    const UNKNOWN: [u8; 3] = [128; 3];
    let luminance = |pixel: &[f32; 3]| f64::from(pixel[0]) + f64::from(pixel[1]) + f64::from(pixel[2]);
    let finite = reference.pixels().iter().map(luminance).filter(|v| v.is_finite());
    let (sum, count) = finite.fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
    let floor = 0.1 * sum / f64::max(count, 1.0);
    let color = |(r, t): (&[f32; 3], &[f32; 3])| {
        let (r, t) = (luminance(r), luminance(t));
        let relative = ((t - r) / (r + floor)) as f32;
        if relative.is_finite() && t.is_finite() { diverging_color(relative / range) } else { UNKNOWN }
    };
    reference.pixels().iter().zip(test.pixels()).flat_map(color).collect()
}

/// [`SCALE_BAR_PX`] rows of 8-bit sRGB: the colours of 0 to 1 from left to right, and labels at both ends and half-way.
#[must_use]
pub fn scale_bar(width: usize, color: fn(f32) -> [u8; 3], labels: [&str; 3]) -> Vec<u8> {
    let mut rgb = vec![0; 3 * width * SCALE_BAR_PX];
    for (i, pixel) in rgb.as_chunks_mut().0.iter_mut().enumerate() {
        let (x, y) = (i % width, i / width);
        // The first two rows part the bar from the picture.
        if (2..BAR_PX).contains(&y) {
            *pixel = color(x as f32 / (width.max(2) - 1) as f32);
        }
    }
    let widths = labels.map(|label| label.len() * (GLYPH_DOTS.0 + 1) * DOT_PX);
    if widths.iter().sum::<usize>() <= width {
        for (i, (label, label_width)) in labels.iter().zip(widths).enumerate() {
            write_label(&mut rgb, width, i * (width - label_width) / 2, label);
        }
    }
    rgb
}

fn write_label(rgb: &mut [u8], width: usize, left: usize, label: &str) {
    let pixels: &mut [[u8; 3]] = rgb.as_chunks_mut().0;
    for (position, character) in label.chars().enumerate() {
        let rows = glyph(character);
        for dot in 0..GLYPH_DOTS.0 * GLYPH_DOTS.1 * DOT_PX * DOT_PX {
            let (x, y) = (dot % (GLYPH_DOTS.0 * DOT_PX), dot / (GLYPH_DOTS.0 * DOT_PX));
            if rows[y / DOT_PX] >> (GLYPH_DOTS.0 - 1 - x / DOT_PX) & 1 == 1 {
                let column = left + position * (GLYPH_DOTS.0 + 1) * DOT_PX + x;
                pixels[(BAR_PX + 1 + y) * width + column] = [255; 3];
            }
        }
    }
}

/// The rows of a character, three dots each; what is not needed for a scale is blank.
fn glyph(character: char) -> [u8; GLYPH_DOTS.1] {
    match character {
        '0' => [0b111, 0b101, 0b101, 0b101, 0b111],
        '1' => [0b010, 0b110, 0b010, 0b010, 0b111],
        '5' => [0b111, 0b100, 0b111, 0b001, 0b111],
        '.' => [0, 0, 0, 0, 0b010],
        '+' => [0, 0b010, 0b111, 0b010, 0],
        '-' => [0, 0, 0b111, 0, 0],
        '%' => [0b101, 0b001, 0b010, 0b100, 0b101],
        _ => [0; GLYPH_DOTS.1],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::testing::image;

    #[test]
    fn the_ends_of_the_scales() {
        assert_eq!((false_color(0.0), false_color(1.0)), ([0, 0, 4], [252, 253, 191]));
        assert_eq!((false_color(-1.0), false_color(f32::NAN)), (false_color(0.0), false_color(0.0)));
        let [blue, white, red] = [-1.0, 0.0, 1.0].map(diverging_color);
        assert!(blue[2] > blue[0] + 50 && red[0] > red[2] + 50 && white.iter().all(|v| *v > 230));
    }

    #[test]
    fn a_heat_map_is_the_map_and_its_bar() {
        let (width, height, rgb) = heatmap(&[0.0, 1.0, 0.5, 0.25], 2);
        assert_eq!((width, height as usize, rgb.len()), (2, 2 + SCALE_BAR_PX, 6 * (2 + SCALE_BAR_PX)));
        assert_eq!(rgb[..6], [0, 0, 4, 252, 253, 191]);
        let bar = scale_bar(100, false_color, ["0", "0.5", "1"]);
        let row = |y: usize| &bar[300 * y..300 * (y + 1)];
        assert_eq!((&row(4)[..3], &row(4)[297..]), (&[0, 0, 4][..], &[252, 253, 191][..]));
        // The top of the first zero: three dots.
        assert_eq!(row(BAR_PX + 1)[..21], [[255; 18].as_slice(), &[0; 3]].concat());
    }

    #[test]
    fn differences_have_their_sign() {
        // The mean of the sums is 6, the floor 0.6.
        let reference = image(4, 1, |_, _, _| 2.0);
        let test = image(4, 1, |x, _, _| [2.0, 2.33, 1.0, f32::NAN][x]);
        let map = difference_map(&reference, &test, 0.3);
        assert_eq!(map[..3], diverging_color(0.0));
        assert_eq!(map[3..6], diverging_color(0.5));
        assert_eq!(map[6..9], diverging_color(-1.0));
        assert_eq!(map[9..], [128; 3]);
    }
}
