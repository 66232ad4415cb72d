//! Separable resampling of RGBA8 images in linear light.

use std::sync::LazyLock;

use glam::{Vec2, Vec4};

use crate::scene::Texture;
use crate::scene::sampling::{Filter, Sampling, Wrap};

/// Intervals of the table from linear light to sRGB: five per level where the curve is steepest.
const ENCODE_STEPS: usize = 16_384;

static DECODE: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        let c = i as f64 / 255.0;
        (if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }) as f32
    })
});

static ENCODE: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let encode = |c: f64| if c <= 0.003_130_8 { c * 12.92 } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
    (0..=ENCODE_STEPS).map(|i| (encode(i as f64 / ENCODE_STEPS as f64) * 255.0).round() as u8).collect()
});

/// A float image in linear light.
struct Linear {
    width: usize,
    height: usize,
    texels: Vec<Vec4>,
}

/// What one output texel takes along one axis: source positions and weights that sum to 1.
type Taps = Vec<(usize, f32)>;

/// An sRGB texture as a square of `size` texels; with hard edges between its texels if it `is_nearest`.
pub(super) fn resample(texture: &Texture, size: u32, is_nearest: bool) -> Vec<u8> {
    let Texture { width, height, rgba, .. } = texture;
    if (*width, *height) == (size, size) {
        return rgba.clone();
    }
    if is_nearest && size >= *width && size >= *height {
        let at = |i: u32, of: u32| (2 * u64::from(i) + 1) * u64::from(of) / (2 * u64::from(size));
        let texel = |i: u32| 4 * (at(i / size, *height) as usize * *width as usize + at(i % size, *width) as usize);
        return (0..size * size).flat_map(|i| rgba[texel(i)..texel(i) + 4].to_vec()).collect();
    }
    encode(&decode(texture, true).resized(size as usize, size as usize), true)
}

/// The mean linear colour and alpha of an sRGB texture.
pub(super) fn average(texture: &Texture) -> [f32; 4] {
    let sum = texture.rgba.chunks_exact(4).fold([0f64; 4], |sum, t| {
        let texel = linear_texel(t);
        std::array::from_fn(|c| sum[c] + f64::from(texel[c]))
    });
    let count = (texture.rgba.len() / 4).max(1) as f64;
    sum.map(|c| (c / count) as f32)
}

/// Linear colour and alpha of four bytes of an sRGB texture.
fn linear_texel(t: &[u8]) -> [f32; 4] {
    [DECODE[t[0] as usize], DECODE[t[1] as usize], DECODE[t[2] as usize], f32::from(t[3]) / 255.0]
}

/// Linear colour and alpha of a level of an sRGB texture at `uv`: of the nearest texel, or between the nearest four.
#[must_use]
pub fn sample_texture((width, height, rgba): &(u32, u32, Vec<u8>), uv: Vec2, sampling: Sampling) -> Vec4 {
    let is_nearest = sampling.magnify == Filter::Nearest;
    let between = |c: f32, size: u32, wrap: Wrap| {
        let c = if wrap == Wrap::Repeat { c.rem_euclid(1.0) } else { c };
        let place = if is_nearest { (c * size as f32).floor() } else { c * size as f32 - 0.5 };
        let first = place.floor();
        (wrap.texel(first as i64, size), wrap.texel(first as i64 + 1, size), place - first)
    };
    let [wrap_u, wrap_v] = sampling.wrap;
    let ((left, right, across), (top, bottom, down)) = (between(uv.x, *width, wrap_u), between(uv.y, *height, wrap_v));
    let texel = |x: u32, y: u32| Vec4::from(linear_texel(&rgba[4 * (y * width + x) as usize..]));
    let row = |y: u32| texel(left, y).lerp(texel(right, y), across);
    row(top).lerp(row(bottom), down)
}

/// All mip levels down to 1x1 as (width, height, RGBA8), the texture itself first. Sizes halve, rounding down; every
/// level is the area average of the one above, in linear light where `srgb` is set, alpha plainly.
#[must_use]
pub fn mip_chain(texture: &Texture, srgb: bool) -> Vec<(u32, u32, Vec<u8>)> {
    let mut levels = vec![(texture.width, texture.height, texture.rgba.clone())];
    let mut image = decode(texture, srgb);
    while image.width > 1 || image.height > 1 {
        image = image.resized((image.width / 2).max(1), (image.height / 2).max(1));
        levels.push((image.width as u32, image.height as u32, encode(&image, srgb)));
    }
    levels
}

fn decode(texture: &Texture, srgb: bool) -> Linear {
    let plain: [f32; 256] = std::array::from_fn(|i| i as f32 / 255.0);
    let colour = if srgb { &*DECODE } else { &plain };
    let texel =
        |t: &[u8]| Vec4::new(colour[t[0] as usize], colour[t[1] as usize], colour[t[2] as usize], plain[t[3] as usize]);
    let texels = texture.rgba.chunks_exact(4).map(texel).collect();
    Linear { width: texture.width as usize, height: texture.height as usize, texels }
}

fn encode(image: &Linear, srgb: bool) -> Vec<u8> {
    let table = &*ENCODE;
    let plain = |c: f32| (c.clamp(0.0, 1.0) * 255.0).round() as u8;
    let colour = |c: f32| table[(c.clamp(0.0, 1.0) * ENCODE_STEPS as f32).round() as usize];
    let texel = |t: &Vec4| {
        if srgb { [colour(t.x), colour(t.y), colour(t.z), plain(t.w)] } else { t.to_array().map(plain) }
    };
    image.texels.iter().flat_map(texel).collect()
}

impl Linear {
    fn resized(&self, width: usize, height: usize) -> Self {
        let (across, down) = (taps(self.width, width), taps(self.height, height));
        let mut rows = Vec::with_capacity(width * self.height);
        for row in self.texels.chunks_exact(self.width) {
            rows.extend(across.iter().map(|taps| taps.iter().map(|(x, w)| row[*x] * *w).sum::<Vec4>()));
        }
        let mut texels = vec![Vec4::ZERO; width * height];
        for (out, taps) in texels.chunks_exact_mut(width).zip(&down) {
            for (y, w) in taps {
                out.iter_mut().zip(&rows[y * width..(y + 1) * width]).for_each(|(o, t)| *o += *t * *w);
            }
        }
        Self { width, height, texels }
    }
}

/// Shrinking takes the exact area average, enlarging interpolates linearly and wraps around.
fn taps(from: usize, to: usize) -> Vec<Taps> {
    let scale = from as f64 / to as f64;
    (0..to)
        .map(|i| {
            if to > from {
                let centre = (i as f64 + 0.5) * scale - 0.5;
                let (floor, part) = (centre.floor(), (centre - centre.floor()) as f32);
                let wrapped = |x: f64| x.rem_euclid(from as f64) as usize;
                return vec![(wrapped(floor), 1.0 - part), (wrapped(floor + 1.0), part)];
            }
            // Integers over `to`: texel x covers [x * to, (x + 1) * to), output i covers [i * from, (i + 1) * from).
            let (start, end) = (i * from, (i + 1) * from);
            let covered = |x: usize| end.min((x + 1) * to) - start.max(x * to);
            (start / to..end.div_ceil(to)).map(|x| (x, covered(x) as f32 / from as f32)).collect()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texture(width: u32, height: u32, rgba: Vec<u8>) -> Texture {
        Texture { name: "t".into(), width, height, rgba }
    }

    #[test]
    fn srgb_tables_round_trip_and_stay_within_a_level() {
        let levels: Vec<u8> = (0..=255).flat_map(|i| [i, i, i, i]).collect();
        let image = decode(&texture(256, 1, levels.clone()), true);
        assert_eq!(encode(&image, true), levels);
        for i in 0..100_000 {
            let c = i as f32 / 100_000.0;
            let exact = if c <= 0.003_130_8 { c * 12.92 } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 } * 255.0;
            let got = ENCODE[(c * ENCODE_STEPS as f32).round() as usize];
            assert!((f32::from(got) - exact).abs() < 1.0, "{c}");
        }
    }

    #[test]
    fn black_and_white_average_in_linear_light() {
        let chain = mip_chain(&texture(2, 1, vec![0, 0, 0, 0, 255, 255, 255, 255]), true);
        assert_eq!(chain.len(), 2);
        assert_eq!(chain[1], (1, 1, vec![188, 188, 188, 128]));
        let plain = mip_chain(&texture(2, 1, vec![0, 0, 0, 0, 255, 255, 255, 255]), false);
        assert_eq!(plain[1].2, [128, 128, 128, 128]);
    }

    /// Opaque materials ignore alpha: what is transparent keeps its colour and its weight.
    #[test]
    fn alpha_has_no_say_in_colours() {
        let halves = texture(2, 1, vec![255, 0, 0, 0, 0, 0, 255, 255]);
        let (_, _, last) = mip_chain(&halves, true).pop().unwrap();
        assert_eq!(last, [188, 0, 188, 128]);
        assert_eq!(resample(&halves, 1, false), [188, 0, 188, 128]);
        let [r, g, b, alpha] = average(&halves);
        assert!([r, b, alpha].iter().all(|v| (v - 0.5).abs() < 1e-3) && g == 0.0, "{r} {g} {b} {alpha}");
    }

    #[test]
    fn odd_sizes_cover_everything() {
        let chain = mip_chain(&texture(5, 3, [0, 90, 0, 255].repeat(15)), false);
        let sizes: Vec<_> = chain.iter().map(|(w, h, _)| (*w, *h)).collect();
        assert_eq!(sizes, [(5, 3), (2, 1), (1, 1)]);
        assert_eq!(chain[2].2, [0, 90, 0, 255]);
        let bright_last = mip_chain(&texture(3, 1, vec![0, 0, 0, 0, 0, 0, 0, 0, 240, 240, 240, 240]), false);
        assert_eq!(bright_last[1].2, [80; 4], "the third texel counts as much as the others");
    }

    #[test]
    fn taps_sum_to_one() {
        for (from, to) in [(1, 1), (7, 3), (3, 7), (1024, 512), (1, 512), (500, 512), (513, 512)] {
            for t in taps(from, to) {
                assert!((t.iter().map(|(_, w)| w).sum::<f32>() - 1.0).abs() < 1e-5);
                assert!(t.iter().all(|(x, _)| *x < from));
            }
        }
    }

    #[test]
    fn resampling_keeps_halves_apart_and_averages() {
        let half: Vec<u8> = (0..64).flat_map(|i| if i % 8 < 4 { [255, 0, 0, 255] } else { [0, 0, 255, 255] }).collect();
        let small = resample(&texture(8, 8, half.clone()), 2, false);
        assert_eq!(small[..8], [255, 0, 0, 255, 0, 0, 255, 255]);
        let [r, g, b, a] = average(&texture(8, 8, half));
        assert!((r - 0.5).abs() < 1e-6 && g == 0.0 && (b - 0.5).abs() < 1e-6 && a == 1.0);
        assert_eq!(resample(&texture(1, 1, vec![9, 8, 7, 6]), 4, false), [9, 8, 7, 6].repeat(16));
    }
}
