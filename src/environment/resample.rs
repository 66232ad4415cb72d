//! Images of another size whose texels are means of the directions that they stand for.

use std::f64::consts::PI;
use std::ops::{AddAssign, Mul};

/// For each texel of an edge, which texels of the other edge it lies in, and its share of each.
type Shares = Vec<Vec<(usize, f64)>>;

/// An equirectangular image that is filled texel by texel from one of another size. Each of its texels becomes the mean
/// over its solid angle, so that what arrives from all directions together stays the same.
pub struct Resampled<T> {
    columns: Shares,
    rows: Shares,
    width: usize,
    height: usize,
    /// The image, row by row; empty before the first texel.
    texels: Vec<T>,
}

impl<T: Copy + Default + AddAssign + Mul<f64, Output = T>> Resampled<T> {
    /// A black image of size `to` for one of size `from`.
    pub fn new(from: [u32; 2], to: [u32; 2]) -> Self {
        let [width, height] = to.map(|edge| edge as usize);
        let columns = shares(from[0] as usize, width, |at| at);
        // Solid angle grows with the height of the direction.
        let rows = shares(from[1] as usize, height, |at| -(PI * at).cos());
        Self { columns, rows, width, height, texels: Vec::new() }
    }

    /// Adds a texel of the other image.
    pub fn add(&mut self, x: usize, y: usize, value: T) {
        if self.texels.is_empty() {
            self.texels.resize(self.width * self.height, T::default());
        }
        for (row, high) in &self.rows[y] {
            for (column, wide) in &self.columns[x] {
                self.texels[row * self.width + column] += value * (high * wide);
            }
        }
    }

    /// The image, row by row; complete when every texel of the other has been added.
    pub fn into_texels(mut self) -> Vec<T> {
        self.texels.resize(self.width * self.height, T::default());
        self.texels
    }
}

/// Which of `to` parts of an edge each of its `from` parts lies in. `measure` says how much of it lies before a point, 0 to 1.
fn shares(from: usize, to: usize, measure: impl Fn(f64) -> f64) -> Shares {
    let between = |start: f64, end: f64| measure(end) - measure(start);
    let parts = |part: usize| {
        // Bounds in whole numbers of 1 / (from to), so that equal ones are equal.
        let (start, end) = (part * to, (part + 1) * to);
        let fraction = |at: usize| at as f64 / (from * to) as f64;
        (start / from..end.div_ceil(from))
            .map(|target| {
                let (first, last) = (target * from, (target + 1) * from);
                let inside = between(fraction(start.max(first)), fraction(end.min(last)));
                (target, inside / between(fraction(first), fraction(last)))
            })
            .collect()
    };
    (0..from).map(parts).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::texel_solid_angle;

    fn resampled(from: [u32; 2], to: [u32; 2], value: impl Fn(u32, u32) -> f64) -> Vec<f64> {
        let mut image = Resampled::new(from, to);
        for y in 0..from[1] {
            (0..from[0]).for_each(|x| image.add(x as usize, y as usize, value(x, y)));
        }
        image.into_texels()
    }

    fn power(size: [u32; 2], texels: &[f64]) -> f64 {
        let row = |(y, row): (u32, &[f64])| row.iter().sum::<f64>() * texel_solid_angle(size, y);
        (0..).zip(texels.chunks_exact(size[0] as usize)).map(row).sum()
    }

    #[test]
    fn means_keep_the_power() {
        let value = |x: u32, y: u32| f64::from((x * 7 + y * 13) % 11) + if [x, y] == [5, 1] { 1e5 } else { 0.0 };
        for (from, to) in
            [([16, 8], [4, 4]), ([17, 9], [5, 4]), ([6, 6], [6, 6]), ([5, 3], [1, 1]), ([100, 3], [64, 3])]
        {
            let original: Vec<f64> =
                (0..from[1]).flat_map(|y| (0..from[0]).map(move |x| (x, y))).map(|(x, y)| value(x, y)).collect();
            let [before, after] = [power(from, &original), power(to, &resampled(from, to, value))];
            assert!((after / before - 1.0).abs() < 1e-9, "{from:?} to {to:?}: {before} became {after}");
            // Means without solid angles would not.
            if to[1] < from[1] && from[1] % to[1] == 0 && to[1] > 1 {
                let flat = |x: u32, y: u32| value(x, y) * f64::from(to[1]) / f64::from(from[1]);
                let mut plain = vec![0.0; (to[0] * to[1]) as usize];
                for y in 0..from[1] {
                    for x in 0..from[0] {
                        let cell = y / (from[1] / to[1]) * to[0] + x / (from[0] / to[0]);
                        plain[cell as usize] += flat(x, y) * f64::from(to[0]) / f64::from(from[0]);
                    }
                }
                assert!((power(to, &plain) / before - 1.0).abs() > 1e-3, "the measure does not see plain means");
            }
        }
    }

    #[test]
    fn the_same_size_is_the_same_image() {
        let texels = resampled([7, 5], [7, 5], |x, y| f64::from(10 * x + y));
        let expected: Vec<f64> = (0..5).flat_map(|y| (0..7).map(move |x| f64::from(10 * x + y))).collect();
        assert!(texels.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-9), "{texels:?}");
    }
}
