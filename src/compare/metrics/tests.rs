//! Measures of tiny pictures, worked out by hand, and planted faults.

use super::*;
use crate::compare::testing::{close, image};

const PLAIN: Tone = Tone::Reinhard { exposure: 1.0 };

fn measure(reference: &Image, test: &Image) -> ImageMetrics {
    metrics(reference, test, PLAIN, None).unwrap()
}

fn pattern(x: usize, y: usize, c: usize) -> f32 {
    ((7 * x + 13 * y + 29 * c) % 64) as f32 / 32.0
}

#[test]
fn two_pixels_by_hand() {
    // Reference 1 and 3, mean 2, floor 0.04; test 2 and 2.
    let reference = image(2, 1, |x, _, _| [1.0, 3.0][x]);
    let found = measure(&reference, &image(2, 1, |_, _, _| 2.0));
    close(found.relmse.unwrap(), f64::midpoint(1.0 / 1.04, 1.0 / 9.04), 1e-12);
    close(found.rmse, 1.0, 1e-12);
    close(found.energy_ratio.unwrap(), 1.0, 1e-12);
    // Display 0.5 and 0.75 against 2 / 3, in sRGB 0.735357, 0.880825 and 0.836007 (mean square of the differences
    // 0.0060695): 22.168 dB.
    close(found.psnr_db.unwrap(), 22.168, 1e-3);
    assert_eq!((found.ssim, found.smooth_relmse, found.indirect), (None, None, None));
    assert_eq!((found.exposure, found.width_px, found.height_px), (Some(1.0), 2, 1));
}

#[test]
fn channels_have_their_own_ratios() {
    let reference = image(2, 2, |_, _, c| [1.0, 2.0, 0.0][c]);
    let found = measure(&reference, &image(2, 2, |_, _, c| [2.0, 1.0, 3.0][c]));
    assert_eq!(found.energy_ratio_rgb, [Some(2.0), Some(0.5), None]);
    assert_eq!(found.energy_ratio, Some(2.0));
    assert_eq!((found.reference_mean.to_bits(), found.test_mean.to_bits()), (1.0_f64.to_bits(), 2.0_f64.to_bits()));
}

#[test]
fn equal_pictures() {
    let picture = image(32, 24, pattern);
    let found = measure(&picture, &picture);
    assert_eq!((found.relmse, found.smooth_relmse, found.energy_ratio), (Some(0.0), Some(0.0), Some(1.0)));
    assert!(found.psnr_db.is_none() && found.flip == 0.0 && found.rmse == 0.0);
    close(found.ssim.unwrap(), 1.0, 1e-9);
}

#[test]
fn brighter_is_more_energy_and_shifted_is_flip() {
    let reference = image(32, 24, pattern);
    close(measure(&reference, &reference.map(|v| 1.02 * v)).energy_ratio.unwrap(), 1.02, 1e-6);
    let shifted = measure(&reference, &image(32, 24, |x, y, c| pattern(x + 1, y, c)));
    assert!(shifted.flip > 0.1 && shifted.relmse.unwrap() > 0.1, "{shifted:?}");
    close(shifted.energy_ratio.unwrap(), 1.0, 0.05);
}

#[test]
fn blocks_forgive_noise_and_not_bias() {
    let reference = image(24, 17, |_, _, _| 1.0);
    let noisy = image(24, 17, |x, y, _| [0.5, 1.5][(x + y) % 2]);
    let found = measure(&reference, &noisy);
    close(found.smooth_relmse.unwrap(), 0.0, 1e-12);
    close(found.relmse.unwrap(), 0.25 / 1.01, 1e-9);
    // One block of six twice as bright; the row beyond the blocks is not looked at.
    let biased = image(24, 17, |x, y, _| if (x < 8 && y < 8) || y == 16 { 2.0 } else { 1.0 });
    close(measure(&reference, &biased).smooth_relmse.unwrap(), 1.0 / 6.0 / 1.01, 1e-9);
}

#[test]
fn the_highest_block_is_the_one_that_is_too_bright() {
    // Of four blocks one is black, one half as bright as the reference, one the same, and one has a bright spot; the column
    // beyond them is not looked at.
    let reference = image(41, 40, |x, y, _| if x < 20 && y < 20 { 0.0 } else { 1.0 });
    let spot = |x: usize, y: usize| if (x, y) == (30, 30) { 401.0 } else { 1.0 };
    let test = image(41, 40, |x, y, _| {
        if x >= 40 {
            900.0
        } else if y < 20 {
            0.5 * reference.pixels()[y * 41 + x][0]
        } else {
            spot(x, y)
        }
    });
    let found = measure(&reference, &test);
    close(found.highest_block_ratio.unwrap(), 2.0, 1e-6);
    let lit = test.map(|v| if v == 0.0 { 0.03 } else { v });
    let mean = (41.0 * 40.0 - 400.0) / (41.0 * 40.0);
    close(measure(&reference, &lit).highest_block_ratio.unwrap(), 0.03 / (0.01 * mean), 1e-5);
    let small = image(19, 40, |_, _, _| 1.0);
    assert_eq!(measure(&small, &small).highest_block_ratio, None, "no block fits");
    let black = image(20, 20, |_, _, _| 0.0);
    assert_eq!(measure(&black, &black).highest_block_ratio, None);
}

#[test]
fn pixels_that_are_not_finite_do_not_count() {
    let reference = image(32, 24, pattern);
    let mut test = reference.map(|v| 1.5 * v);
    let whole = measure(&reference, &test);
    test.rgb[300] = f32::NAN;
    test.rgb[901] = f32::INFINITY;
    let found = measure(&reference, &test);
    assert_eq!((found.nonfinite_reference_pixels, found.nonfinite_test_pixels), (0, 2));
    for (found, whole) in [(found.flip, whole.flip), (found.ssim.unwrap(), whole.ssim.unwrap())] {
        assert!(found.is_finite() && (found - whole).abs() < 0.05 * whole, "{found} {whole}");
    }
    close(found.energy_ratio.unwrap(), 1.5, 1e-6);
    close(found.smooth_relmse.unwrap(), whole.smooth_relmse.unwrap(), 0.01);
    // Nothing else differs: the spoiled pixels leave no trace.
    let mut spoiled = reference.clone();
    spoiled.rgb[300] = f32::NAN;
    let found = measure(&reference, &spoiled);
    assert!(found.flip == 0.0 && found.relmse == Some(0.0) && found.psnr_db.is_none());
}

#[test]
fn against_black_nothing_is_relative() {
    let black = image(16, 16, |_, _, _| 0.0);
    let found = measure(&black, &image(16, 16, |_, _, _| 1.0));
    assert_eq!((found.relmse, found.energy_ratio, found.smooth_relmse), (None, None, None));
    close(found.rmse, 1.0, 1e-12);
    assert!(found.flip > 0.5);
}

#[test]
fn indirect_light_is_measured_where_nothing_else_arrives() {
    // Columns 0 to 15 are lit, 16 to 31 are not, and of those 24 to 31 are black below row 8.
    let direct = image(32, 16, |x, _, _| f32::from(u8::from(x < 16)));
    let reference = image(32, 16, |x, y, _| if x < 16 { 5.0 } else { f32::from(u8::from(x < 24 || y < 8)) });
    let test = image(32, 16, |x, y, _| {
        if x < 16 {
            9.0
        } else if x < 24 && y < 8 {
            1.3
        } else {
            1.0
        }
    });
    let found = metrics(&reference, &test, PLAIN, Some(&direct)).unwrap().indirect.unwrap();
    assert_eq!(found.indirect_pixels, 192);
    close(found.indirect_ratio.unwrap(), 3.3 / 3.0, 1e-6);
    close(found.indirect_smooth_relmse.unwrap(), 0.09 / 1.01 / 3.0, 1e-6);
    let lit = image(32, 16, |_, _, _| 1.0);
    let found = metrics(&reference, &test, PLAIN, Some(&lit)).unwrap().indirect.unwrap();
    assert_eq!(found, IndirectMetrics { indirect_ratio: None, indirect_smooth_relmse: None, indirect_pixels: 0 });
    assert!(metrics(&reference, &test, PLAIN, Some(&image(1, 1, |_, _, _| 1.0))).is_err());
}

#[test]
fn json_is_flat() {
    let picture = image(16, 16, pattern);
    let json = serde_json::to_value(metrics(&picture, &picture, PLAIN, Some(&picture)).unwrap()).unwrap();
    for key in ["relmse", "rmse", "energy_ratio", "flip", "ssim", "smooth_relmse", "exposure"] {
        assert!(json[key].is_number(), "{key} in {json}");
    }
    assert!(json["psnr_db"].is_null() && json["indirect_pixels"].is_number());
    let json = serde_json::to_value(measure(&picture, &picture)).unwrap();
    assert!(json.get("indirect_pixels").is_none(), "{json}");
}
