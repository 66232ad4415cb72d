//! Structural similarity (Wang, Bovik, Sheikh, Simoncelli 2004) of luma.

use super::image::Image;
/// Luma has the weights of luminance.
use crate::color::LUMINANCE_WEIGHTS as LUMA;

/// Taps of the Gaussian window, in each direction.
const TAPS: usize = 11;
/// Its standard deviation in pixels.
const DEVIATION_PX: f64 = 1.5;
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// Mean SSIM of two display pictures (0 to 1) of one size, over the windows that lie within them and whose centre
/// `counts`; `None` when there are none.
pub fn ssim(reference: &Image, test: &Image, counts: &[bool]) -> Option<f64> {
    let (width, height) = reference.size();
    if width < TAPS || height < TAPS {
        return None;
    }
    let (a, b) = (luma(reference), luma(test));
    let window = window();
    let local_mean = |value: &dyn Fn(usize) -> f64| {
        let values: Vec<f64> = (0..a.len()).map(value).collect();
        blur(&values, width, &window)
    };
    let (mean_a, mean_b) = (local_mean(&|i| a[i]), local_mean(&|i| b[i]));
    let squares_a = local_mean(&|i| a[i] * a[i]);
    let squares_b = local_mean(&|i| b[i] * b[i]);
    let products = local_mean(&|i| a[i] * b[i]);
    let (mut sum, mut windows) = (0.0, 0.0);
    for i in 0..mean_a.len() {
        let valid_width = width - TAPS + 1;
        let centre = (i / valid_width + TAPS / 2) * width + i % valid_width + TAPS / 2;
        if counts[centre] {
            let (ma, mb) = (mean_a[i], mean_b[i]);
            let (va, vb) = (squares_a[i] - ma * ma, squares_b[i] - mb * mb);
            let covariance = products[i] - ma * mb;
            sum += (2.0 * ma * mb + C1) * (2.0 * covariance + C2) / ((ma * ma + mb * mb + C1) * (va + vb + C2));
            windows += 1.0;
        }
    }
    (windows > 0.0).then(|| sum / windows)
}

/// Luma of a display picture, pixel by pixel.
pub fn luma(image: &Image) -> Vec<f64> {
    image.pixels().iter().map(|pixel| pixel.iter().zip(LUMA).map(|(&v, weight)| f64::from(v) * weight).sum()).collect()
}

fn window() -> [f64; TAPS] {
    let gaussian = |i: usize| (-0.5 * ((i as f64 - (TAPS / 2) as f64) / DEVIATION_PX).powi(2)).exp();
    let weights: [f64; TAPS] = std::array::from_fn(gaussian);
    let sum: f64 = weights.iter().sum();
    weights.map(|weight| weight / sum)
}

/// The weighted means of all windows that lie within the plane.
fn blur(values: &[f64], width: usize, window: &[f64; TAPS]) -> Vec<f64> {
    let valid = width - TAPS + 1;
    let row = |row: &[f64]| -> Vec<f64> {
        row.windows(TAPS).map(|taps| taps.iter().zip(window).map(|(v, weight)| v * weight).sum()).collect()
    };
    let rows: Vec<Vec<f64>> = values.chunks(width).map(row).collect();
    let mut blurred = Vec::with_capacity(valid * (rows.len() - TAPS + 1));
    for taps in rows.windows(TAPS) {
        let mut sums = vec![0.0; valid];
        for (row, weight) in taps.iter().zip(window) {
            sums.iter_mut().zip(row).for_each(|(sum, v)| *sum += weight * v);
        }
        blurred.extend(sums);
    }
    blurred
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::testing::{close, image};

    fn all(reference: &Image, test: &Image) -> Option<f64> {
        ssim(reference, test, &vec![true; reference.pixels().len()])
    }

    #[test]
    fn flat_pictures_by_hand() {
        // No variance: (2 * 0.2 * 0.6 + C1) / (0.2^2 + 0.6^2 + C1).
        let (a, b) = (image(13, 12, |_, _, _| 0.2), image(13, 12, |_, _, _| 0.6));
        close(all(&a, &b).unwrap(), 0.2401 / 0.4001, 1e-6);
        close(all(&a, &a).unwrap(), 1.0, 1e-12);
    }

    #[test]
    fn opposite_structure_is_negative() {
        let a = image(24, 24, |x, y, _| ((x + y) % 2) as f32);
        let b = a.map(|v| 1.0 - v);
        assert!(all(&a, &b).unwrap() < -0.9);
    }

    #[test]
    fn small_pictures_have_no_window() {
        let small = image(10, 30, |_, _, _| 0.5);
        assert_eq!(all(&small, &small), None);
        let one = image(11, 11, |_, _, _| 0.5);
        close(all(&one, &one).unwrap(), 1.0, 1e-12);
        assert_eq!(ssim(&one, &one, &[false; 121]), None);
    }
}
