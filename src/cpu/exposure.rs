//! Twin of `tone_map/count_luminances` and `tone_map/measure_exposure`: a histogram of luminances and the automatic
//! exposure that follows from it.

use glam::Vec3;

use crate::color::{MIDDLE_GREY, luminance};
use crate::shared::{EXPOSURE_BINS, EXPOSURE_STOPS};

const BINS: usize = EXPOSURE_BINS as usize;
const LOWEST_STOP: f32 = -0.5 * EXPOSURE_STOPS as f32;
const STOPS_PER_BIN: f32 = EXPOSURE_STOPS as f32 / EXPOSURE_BINS as f32;
const MIDDLE: [f64; 2] = [0.1, 0.9];
const HIGHLIGHTS_FROM: f64 = 0.98;
const BACKGROUND_OF_SURFACES: f64 = 0.25;
const BACKGROUND_OF_ALL: f64 = 0.01;

/// Numbers of samples by luminance: bins of surfaces, then bins of what is behind them.
#[must_use]
pub fn count_luminances(size_px: [usize; 2], step_px: usize, radiance: &[Vec3], depth: &[f32]) -> Vec<u32> {
    let mut histogram = vec![0; 2 * BINS];
    let [columns, rows] = size_px.map(|edge| edge.div_ceil(step_px));
    for sample in 0..columns * rows {
        let cell = [sample % columns, sample / columns];
        let [x, y] = [0, 1].map(|axis| (cell[axis] * step_px + step_px / 2).min(size_px[axis] - 1));
        let pixel = y * size_px[0] + x;
        let luminance = luminance(radiance[pixel]);
        if luminance > LOWEST_STOP.exp2() {
            let bin = ((luminance.log2() - LOWEST_STOP) / STOPS_PER_BIN).clamp(0.0, (BINS - 1) as f32) as usize;
            histogram[bin + if depth[pixel] > 0.0 { 0 } else { BINS }] += 1;
        }
    }
    histogram
}

/// The automatic exposure of a histogram, 1 where it is empty, and never more than `most`.
#[must_use]
pub fn measure_exposure(histogram: &[u32], most: f64) -> f64 {
    let (surfaces, background) = histogram.split_at(BINS);
    let sum = |bins: &[u32]| bins.iter().map(|count| f64::from(*count)).sum::<f64>();
    let (of_surfaces, of_background) = (sum(surfaces), sum(background));
    let allowed = BACKGROUND_OF_SURFACES * of_surfaces + BACKGROUND_OF_ALL * (of_surfaces + of_background);
    let weight = if of_background > 0.0 { (allowed / of_background).min(1.0) } else { 0.0 };
    let total = of_surfaces + weight * of_background;
    if total <= 0.0 {
        return most.min(1.0);
    }
    let (mut start, mut stops, mut counted, mut highlights) = (0.0, 0.0, 0.0, 0.0);
    for (bin, (surface, behind)) in surfaces.iter().zip(background).enumerate() {
        let count = f64::from(*surface) + weight * f64::from(*behind);
        let end = start + count;
        let middle = (end.min(MIDDLE[1] * total) - start.max(MIDDLE[0] * total)).max(0.0);
        stops += middle * stops_at(bin as f64 + 0.5);
        counted += middle;
        if count > 0.0 && start < HIGHLIGHTS_FROM * total {
            highlights = bin as f64 + ((HIGHLIGHTS_FROM * total - start) / count).min(1.0);
        }
        start = end;
    }
    (0.5 * (MIDDLE_GREY.log2() - stops / counted - stops_at(highlights))).exp2().min(most)
}

fn stops_at(place: f64) -> f64 {
    f64::from(LOWEST_STOP) + f64::from(STOPS_PER_BIN) * place
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Exposure of so many surface and background pixels of one luminance each.
    fn exposure(surfaces: &[(f32, usize)], background: &[(f32, usize)]) -> f64 {
        let pixels = |list: &[(f32, usize)], depth: f32| {
            let pixels = list.iter().flat_map(|(value, count)| vec![Vec3::splat(*value); *count]);
            pixels.map(|radiance| (radiance, depth)).collect::<Vec<_>>()
        };
        let all = [pixels(surfaces, 0.5), pixels(background, 0.0)].concat();
        let (radiance, depth): (Vec<_>, Vec<_>) = all.into_iter().unzip();
        measure_exposure(&count_luminances([radiance.len(), 1], 1, &radiance, &depth), f64::INFINITY)
    }

    fn is_near(found: f64, expected: f64) -> bool {
        // A bin, and half of one in the mean.
        (found / expected).log2().abs() <= f64::from(STOPS_PER_BIN)
    }

    #[test]
    fn exposures_by_hand() {
        // One grey lies between middle grey and white.
        assert!(is_near(exposure(&[(1.0, 1)], &[]), 0.18_f64.sqrt()));
        assert!(is_near(exposure(&[(4.0, 100)], &[]), 0.18_f64.sqrt() / 4.0));
        assert!(!is_near(exposure(&[(4.0, 100)], &[]), 0.18_f64.sqrt() / 4.4));
        // Half 1, half 4: the mean is 2, the highlights are 4.
        assert!(is_near(exposure(&[(1.0, 50), (4.0, 50)], &[]), (0.18_f64 / 8.0).sqrt()));
        // Two pixels in a hundred that shine, and ten that are nearly black, change nothing.
        let plain = exposure(&[(1.0, 100)], &[]);
        assert!(is_near(exposure(&[(0.001, 10), (1.0, 88), (1e6, 2)], &[]), plain));
        // Nothing but black, and what is no number.
        for black in [0.0, -1.0, f32::NAN, 1e-10] {
            assert_eq!(exposure(&[(black, 10)], &[(black, 5)]), 1.0, "{black}");
        }
        assert!(exposure(&[(f32::INFINITY, 1)], &[]) > 0.0);
    }

    #[test]
    fn a_bright_background_does_not_drown_what_is_before_it() {
        let alone = exposure(&[(0.1, 100)], &[]);
        let before_sky = |share: usize| exposure(&[(0.1, share)], &[(1.6, 1000 - share)]);
        // Four stops more in nine tenths of the picture are less than two stops of exposure.
        let stops = |found: f64| (alone / found).log2();
        assert!(stops(before_sky(100)) < 2.6, "{}", stops(before_sky(100)));
        // It is never more than that as the object grows small, and without an object the sky alone counts.
        assert!(is_near(before_sky(0), exposure(&[(1.6, 1000)], &[])));
        let small: Vec<f64> = [300, 100, 30, 10, 3, 1, 0].map(before_sky).to_vec();
        assert!(small.windows(2).all(|pair| pair[0] >= pair[1] && pair[0] < 2.0 * pair[1]), "{small:?}");
        // A background that is black is not seen.
        assert!(is_near(exposure(&[(0.1, 100)], &[(0.0, 900)]), alone));
    }
}
