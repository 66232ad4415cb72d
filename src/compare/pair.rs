//! Two pictures made comparable: what is not finite in either is marked and made equal in both.

use super::image::Image;
use crate::{Error, Result};

/// A reference and a test of the same size.
pub struct Pair {
    /// The reference; where a pixel does not count, it is the same as in the test.
    pub reference: Image,
    /// The test; see `reference`.
    pub test: Image,
    /// Which pixels count: those finite in both.
    pub counts: Vec<bool>,
    /// Pixels of the reference with a NaN or an infinity.
    pub nonfinite_reference: usize,
    /// Pixels of the test with a NaN or an infinity.
    pub nonfinite_test: usize,
}

impl Pair {
    /// Marks what is finite in both. Elsewhere both take the reference's pixel, or black where that is the one that
    /// is not finite, so that filters that look at neighbours see no difference there.
    ///
    /// # Errors
    /// [`Error::Usage`] when the sizes differ, [`Error::Failure`] when no pixel is finite in both.
    pub fn new(reference: &Image, test: &Image) -> Result<Self> {
        if reference.size() != test.size() {
            let (a, b) = (reference.size(), test.size());
            return Err(Error::Usage(format!("the pictures' sizes differ: {}x{} and {}x{}", a.0, a.1, b.0, b.1)));
        }
        let finite = |pixel: &[f32; 3]| pixel.iter().all(|v| v.is_finite());
        let (mut left, mut right) = (reference.clone(), test.clone());
        let mut counts = vec![true; reference.pixels().len()];
        for (i, (r, t)) in reference.pixels().iter().zip(test.pixels()).enumerate() {
            counts[i] = finite(r) && finite(t);
            if !counts[i] {
                let replacement = if finite(r) { *r } else { [0.0; 3] };
                left.rgb[3 * i..3 * i + 3].copy_from_slice(&replacement);
                right.rgb[3 * i..3 * i + 3].copy_from_slice(&replacement);
            }
        }
        if !counts.contains(&true) {
            return Err(Error::Failure("no pixel is finite in both pictures".to_owned()));
        }
        let nonfinite = |image: &Image| image.pixels().iter().filter(|pixel| !finite(pixel)).count();
        let (nonfinite_reference, nonfinite_test) = (nonfinite(reference), nonfinite(test));
        Ok(Self { reference: left, test: right, counts, nonfinite_reference, nonfinite_test })
    }

    /// The reference's and the test's values of the pixels that count.
    pub fn values(&self) -> impl Iterator<Item = ([f64; 3], [f64; 3])> {
        counted(&self.reference, &self.test, &self.counts)
    }
}

/// The pixels of two pictures of one size, where `counts`.
pub fn counted<'a>(a: &'a Image, b: &'a Image, counts: &'a [bool]) -> impl Iterator<Item = ([f64; 3], [f64; 3])> + 'a {
    let pixels = a.pixels().iter().zip(b.pixels()).zip(counts);
    pixels.filter(|(_, counts)| **counts).map(|((a, b), _)| (a.map(f64::from), b.map(f64::from)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::testing::image;

    #[test]
    fn pixels_that_are_not_finite_are_counted_and_made_equal() {
        let reference = image(4, 1, |x, _, c| if x == 1 && c == 2 { f32::NAN } else { 1.0 });
        let test = image(4, 1, |x, _, _| if x == 2 { f32::INFINITY } else { 2.0 });
        let pair = Pair::new(&reference, &test).unwrap();
        assert_eq!((pair.nonfinite_reference, pair.nonfinite_test), (1, 1));
        assert_eq!(pair.counts, [true, false, false, true]);
        assert_eq!(pair.reference.pixels(), [[1.0; 3], [0.0; 3], [1.0; 3], [1.0; 3]]);
        assert_eq!(pair.test.pixels(), [[2.0; 3], [0.0; 3], [1.0; 3], [2.0; 3]]);
    }

    #[test]
    fn what_cannot_be_compared() {
        let (small, large) = (image(2, 2, |_, _, _| 1.0), image(2, 3, |_, _, _| 1.0));
        assert_eq!(Pair::new(&small, &large).err().map(|e| e.exit_code()), Some(2));
        let nothing = small.map(|_| f32::NAN);
        assert_eq!(Pair::new(&small, &nothing).err().map(|e| e.exit_code()), Some(1));
    }
}
