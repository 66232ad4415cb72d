//! Small pictures for tests.

use super::Image;

/// A picture whose value at column x, row y and channel c is `value(x, y, c)`.
pub fn image(width: usize, height: usize, value: impl Fn(usize, usize, usize) -> f32) -> Image {
    let index = |i: usize| value(i / 3 % width, i / 3 / width, i % 3);
    Image::new(width, height, (0..3 * width * height).map(index).collect()).unwrap()
}

/// Fails unless `found` is within `tolerance` of `expected`.
#[track_caller]
pub fn close(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found} is not {expected}");
}
