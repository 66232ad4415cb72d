//! Legends drawn into finished pictures: a title over a colour bar or over numbered patches, in the lower left corner.

use font8x8::{BASIC_FONTS, UnicodeFonts};

use super::{Patch, Scale};

/// Edge of a character at scale 1.
const GLYPH_PX: u32 = 8;
/// Around the legend and between its lines, at scale 1.
const GAP_PX: u32 = 3;
/// Length of a colour bar, at scale 1.
const BAR_PX: u32 = 128;
/// Least width of a patch, at scale 1: two digits and some room.
const PATCH_PX: u32 = 18;
/// Between patches, and around their words.
const PATCH_GAP_PX: u32 = 2;
const TEXT: u32 = 0xffffff;
const BACKGROUND: u32 = 0x101014;

/// A picture of 8-bit sRGB, RGB, row 0 at the top, to draw into.
pub struct Canvas<'a> {
    /// `3 * width_px * height_px` bytes.
    pub rgb: &'a mut [u8],
    /// Width.
    pub width_px: u32,
    /// Height.
    pub height_px: u32,
}

impl Canvas<'_> {
    /// Fills a rectangle, cut off at the picture's edges.
    fn fill(&mut self, [x, y]: [u32; 2], [width, height]: [u32; 2], color: u32) {
        let [_, r, g, b] = color.to_be_bytes();
        for row in y..(y + height).min(self.height_px) {
            for column in x..(x + width).min(self.width_px) {
                let at = 3 * (row as usize * self.width_px as usize + column as usize);
                self.rgb[at..at + 3].copy_from_slice(&[r, g, b]);
            }
        }
    }

    /// Writes a line of text, each character [`GLYPH_PX`] times `scale` wide.
    fn write(&mut self, [x, y]: [u32; 2], scale: u32, color: u32, text: &str) {
        for (index, character) in text.chars().enumerate() {
            let left = x + index as u32 * GLYPH_PX * scale;
            for (row, bits) in BASIC_FONTS.get(character).unwrap_or_default().iter().enumerate() {
                for column in (0..GLYPH_PX).filter(|column| bits >> column & 1 == 1) {
                    self.fill([left + column * scale, y + row as u32 * scale], [scale; 2], color);
                }
            }
        }
    }
}

/// Draws the legend; a picture with too little room stays as it is.
pub fn draw(canvas: &mut Canvas<'_>, title: &str, scale: &Scale) {
    // Legible at any size: about a third of the width of a small picture, less of a large one.
    let unit = (canvas.width_px / 480).clamp(1, 4);
    let content_px = match scale {
        Scale::Bar { .. } => BAR_PX,
        Scale::Patches(patches) => patches.iter().map(|patch| patch_px(patch) + PATCH_GAP_PX).sum(),
    };
    let width = (content_px.max(text_px(title)) + 2 * GAP_PX) * unit;
    let height = (3 * GLYPH_PX + 4 * GAP_PX) * unit;
    if width > canvas.width_px || 2 * height > canvas.height_px {
        return;
    }
    let gap = GAP_PX * unit;
    let top = canvas.height_px - height;
    canvas.fill([0, top], [width, height], BACKGROUND);
    canvas.write([gap, top + gap], unit, TEXT, title);
    let line = top + 2 * gap + GLYPH_PX * unit;
    match scale {
        Scale::Bar { map, end, whole } => {
            for column in 0..BAR_PX * unit {
                let color = color_at(map.colors, column as f32 / (BAR_PX * unit - 1) as f32);
                canvas.fill([gap + column, line], [1, GLYPH_PX * unit], color);
            }
            draw_ticks(canvas, [gap, line + gap + GLYPH_PX * unit], unit, &ticks(*end, *whole));
        }
        Scale::Patches(patches) => {
            let mut left = gap;
            for patch in patches {
                let width = patch_px(patch);
                canvas.fill([left, line], [width * unit, GLYPH_PX * unit], patch.color);
                let inset = (width - text_px(&patch.text)) / 2 * unit;
                canvas.write([left + inset, line + gap + GLYPH_PX * unit], unit, TEXT, &patch.text);
                left += (width + PATCH_GAP_PX) * unit;
            }
        }
    }
}

fn patch_px(patch: &Patch) -> u32 {
    (text_px(&patch.text) + PATCH_GAP_PX).max(PATCH_PX)
}

fn text_px(text: &str) -> u32 {
    text.chars().count() as u32 * GLYPH_PX
}

/// Writes 0 at the bar's start, the middle below the middle and the end flush with the end.
fn draw_ticks(canvas: &mut Canvas<'_>, [x, y]: [u32; 2], unit: u32, ticks: &[String; 3]) {
    for (index, tick) in ticks.iter().enumerate() {
        let free = BAR_PX.saturating_sub(text_px(tick));
        canvas.write([x + free * index as u32 / 2 * unit, y], unit, TEXT, tick);
    }
}

/// Values at the start, the middle and the end of a bar. The middle of whole numbers is left out where it is not whole.
pub fn ticks(end: f32, whole: bool) -> [String; 3] {
    let text = |value: f32| match value {
        v if whole || v >= 100.0 => format!("{v:.0}"),
        v if v >= 10.0 => format!("{v:.1}"),
        v => format!("{v:.2}"),
    };
    let middle = 0.5 * end;
    let middle = if whole && middle.fract() != 0.0 && end < 20.0 { String::new() } else { text(middle) };
    ["0".to_owned(), middle, text(end)]
}

/// The sRGB colour `0xRRGGBB` at a fraction of a map, as `debug_view/colorize` mixes it.
pub fn color_at(colors: &[u32], fraction: f32) -> u32 {
    let at = fraction.clamp(0.0, 1.0) * (colors.len() - 1) as f32;
    let below = (at as usize).min(colors.len() - 2);
    let [a, b] = [colors[below], colors[below + 1]].map(u32::to_be_bytes);
    let t = at - below as f32;
    let mixed = [0, 1, 2, 3].map(|i| (f32::from(a[i]) * (1.0 - t) + f32::from(b[i]) * t).round() as u8);
    u32::from_be_bytes(mixed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::View;
    use crate::views::{LEVEL_COLORS, color_map, level_patches};

    fn drawn(width_px: u32, height_px: u32, title: &str, scale: &Scale) -> Vec<u8> {
        let mut rgb = vec![77; 3 * (width_px * height_px) as usize];
        draw(&mut Canvas { rgb: &mut rgb, width_px, height_px }, title, scale);
        rgb
    }

    fn count(rgb: &[u8], color: u32) -> usize {
        rgb.chunks(3).filter(|p| *p == &color.to_be_bytes()[1..]).count()
    }

    #[test]
    fn every_level_has_its_patch() {
        let rgb = drawn(320, 180, "levels", &level_patches([1, 7]));
        for (level, color) in LEVEL_COLORS.iter().enumerate() {
            let expected = if (1..=7).contains(&level) { PATCH_PX * GLYPH_PX } else { 0 };
            assert_eq!(count(&rgb, *color), expected as usize, "level {level}");
        }
        assert!(count(&rgb, TEXT) > 50);
    }

    #[test]
    fn a_bar_runs_from_end_to_end() {
        let map = color_map(View::LightsTested).unwrap();
        let rgb = drawn(640, 360, "fragments", &Scale::Bar { map, end: 1234.0, whole: true });
        for color in [map.colors[0], map.colors[map.colors.len() - 1]] {
            assert!(count(&rgb, color) >= 8, "{color:x}");
        }
        // The rest of the picture is untouched.
        assert_eq!(&rgb[..3 * 640 * 200], vec![77; 3 * 640 * 200]);
    }

    #[test]
    fn a_small_picture_stays_as_it_is() {
        for (width, height) in [(48, 27), (400, 60), (100, 400), (1, 1)] {
            let rgb = drawn(width, height, "a title", &level_patches([0, 10]));
            assert!(rgb.iter().all(|v| *v == 77), "{width}x{height}");
        }
    }

    #[test]
    fn ticks_are_short() {
        assert_eq!(ticks(1234.0, true), ["0", "617", "1234"]);
        assert_eq!(ticks(3.0, true), ["0", "", "3"]);
        assert_eq!(ticks(1.0, false), ["0", "0.50", "1.00"]);
        assert_eq!(ticks(33.26, false), ["0", "16.6", "33.3"]);
    }

    #[test]
    fn colors_mix_like_the_shader() {
        assert_eq!(color_at(&[0x000000, 0xffffff], 0.5), 0x808080);
        assert_eq!(color_at(&[0x102030, 0x405060, 0x708090], 0.5), 0x405060);
        assert_eq!(color_at(&[0x102030, 0x405060, 0x708090], 2.0), 0x708090);
    }
}
