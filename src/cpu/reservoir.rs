//! Twin of the selection in `light_volumes/reservoir.glsl`: which light a pixel's shadow sample becomes.

use crate::random::{hash, hash3, unit_float};
use crate::shared::NO_LIGHT;

/// The pixel and sample whose reservoir it is.
#[derive(Clone, Copy, Debug)]
pub struct Stream {
    /// Index of the pixel in the interleaved layout.
    pub pixel_index: u32,
    /// Which of the pixel's reservoirs.
    pub sample: u32,
    /// The frame's seed.
    pub seed: u32,
}

impl Stream {
    fn bits(&self, light: u32) -> u32 {
        let offset = self.sample.wrapping_mul(0x9e37_79b9);
        hash(hash3(light, self.pixel_index, self.seed).wrapping_add(offset))
    }
}

/// `exact`: the light of weight f with the smallest `-ln(u) / f`.
#[must_use]
pub fn select_exact(stream: Stream, lights: &[(u32, f32)]) -> u32 {
    let key = |(light, f): (u32, f32)| {
        let key = -unit_float(stream.bits(light)).ln() / f;
        u64::from(key.to_bits()) << 32 | u64::from(light)
    };
    lights.iter().map(|light| key(*light)).min().map_or(NO_LIGHT, |key| key as u32)
}

/// `race` and `lock`: one light after the other against a running total.
#[must_use]
pub fn select_streaming(stream: Stream, lights: &[(u32, f32)]) -> u32 {
    let mut total = 0.0;
    let mut chosen = NO_LIGHT;
    for (light, f) in lights {
        total += f;
        if unit_float(stream.bits(*light)) * total < *f {
            chosen = *light;
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_light_always_wins_and_none_never() {
        let stream = Stream { pixel_index: 3, sample: 1, seed: 9 };
        assert_eq!(select_exact(stream, &[(17, 1e-6)]), 17);
        assert_eq!(select_streaming(stream, &[(17, 1e-6)]), 17);
        assert_eq!(select_exact(stream, &[]), NO_LIGHT);
        assert_eq!(select_streaming(stream, &[]), NO_LIGHT);
    }

    #[test]
    fn order_does_not_matter_to_exact() {
        let lights: Vec<(u32, f32)> = (0..50).map(|i| (i, 1.0 + i as f32)).collect();
        let reversed: Vec<(u32, f32)> = lights.iter().rev().copied().collect();
        for pixel_index in 0..200 {
            let stream = Stream { pixel_index, sample: 0, seed: 1 };
            assert_eq!(select_exact(stream, &lights), select_exact(stream, &reversed));
        }
    }
}
