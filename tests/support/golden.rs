//! The goldens of the built-in scene and the loose comparison with them.

use std::path::{Path, PathBuf};

use gridlight::files::pictures::read_png;

/// Largest mean absolute difference that passes, of blocks of 8-bit sRGB values and as a fraction of the golden's mean value.
///
/// Drivers differ in texture filtering and in coverage at edges, and the shadow samples are noise that changes with
/// every change in the order of random numbers; another seed stands for that below and must pass. Pictures shifted
/// by 8 pixels, darkened by a fifth or upside down must not. The other seed differs by 0.12, the mildest fault by 0.20.
const TOLERANCE: f64 = 0.15;
/// Size of the goldens.
pub const SIZE: (u32, u32) = (160, 90);

/// An 8-bit RGB picture of [`SIZE`].
pub type Picture = Vec<u8>;

/// Path of a golden.
pub fn golden(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(format!("{name}.png"))
}

/// Sums over blocks of 5 x 5 pixels, each channel for itself: noise averages out, faults do not.
fn block_sums(picture: &[u8]) -> Vec<u32> {
    let (width, block) = (SIZE.0 as usize, 5);
    let mut sums = vec![0; picture.len() / (block * block)];
    for (i, value) in picture.iter().enumerate() {
        let (x, y, channel) = (i / 3 % width, i / 3 / width, i % 3);
        sums[(y / block * (width / block) + x / block) * 3 + channel] += u32::from(*value);
    }
    sums
}

/// Mean absolute difference of two pictures' blocks as a fraction of the mean of the second.
fn difference(picture: &[u8], golden: &[u8]) -> f64 {
    assert_eq!(picture.len(), golden.len());
    let (picture, blocks) = (block_sums(picture), block_sums(golden));
    let sum: u64 = blocks.iter().map(|v| u64::from(*v)).sum();
    assert!(sum > 5 * golden.len() as u64, "the golden is too dark to compare with");
    picture.iter().zip(&blocks).map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>() / sum as f64
}

/// Reads a picture of [`SIZE`].
pub fn load(path: &Path) -> Result<Picture, String> {
    let (width, height, rgb) = read_png(path).map_err(|error| format!("no golden: {error}"))?;
    if (width, height) == SIZE { Ok(rgb) } else { Err(format!("{} is {width}x{height}", path.display())) }
}

/// Why the picture does not match the golden, if it does not.
pub fn compare(picture: &[u8], golden: &Path) -> Result<(), String> {
    let difference = difference(picture, &load(golden)?);
    println!("{}: difference {difference:.4}", golden.display());
    if difference <= TOLERANCE {
        return Ok(());
    }
    Err(format!("{}: difference {difference:.3}, more than {TOLERANCE}", golden.display()))
}
