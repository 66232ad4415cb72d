//! Limits on the measures, and sentences about those exceeded.

use serde::Serialize;

use super::metrics::ImageMetrics;
use super::table::number;

/// What a comparison of pictures must keep to. Every limit is finite and at least 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ImageLimits {
    /// Most mean FLIP.
    pub max_flip: Option<f64>,
    /// Most relMSE.
    pub max_relmse: Option<f64>,
    /// Most |energy ratio - 1| in percent.
    pub energy_within_percent: Option<f64>,
}

impl ImageLimits {
    /// Whether there is any limit.
    #[must_use]
    pub fn any(&self) -> bool {
        *self != Self::default()
    }

    /// A clause for each limit that `metrics` exceeds, and for each that says nothing because the measure is
    /// undefined. With any limit, pixels of the test that are not finite are a fault themselves.
    #[must_use]
    pub fn exceeded(&self, metrics: &ImageMetrics) -> Vec<String> {
        let mut clauses = Vec::new();
        if self.any() {
            clauses.extend(not_finite(metrics.nonfinite_test_pixels));
        }
        clauses.extend(self.flip(metrics));
        clauses.extend(self.relmse(metrics));
        clauses.extend(self.energy(metrics));
        clauses
    }

    /// The clause about the limit on FLIP, where it is exceeded.
    pub(super) fn flip(&self, metrics: &ImageMetrics) -> Option<String> {
        over("FLIP", Some(metrics.flip), self.max_flip)
    }

    /// The clause about the limit on relMSE, where it is exceeded.
    pub(super) fn relmse(&self, metrics: &ImageMetrics) -> Option<String> {
        over("relMSE", metrics.relmse, self.max_relmse)
    }

    /// The clause about the limit on the energy ratio, where it is exceeded.
    pub(super) fn energy(&self, metrics: &ImageMetrics) -> Option<String> {
        let limit = self.energy_within_percent?;
        let Some(ratio) = metrics.energy_ratio else { return Some(undefined("the energy ratio", limit)) };
        let off = 100.0 * (ratio - 1.0).abs();
        let clause =
            || format!("the energy ratio {} is {} % from 1, over the limit {limit} %", number(ratio), number(off));
        (off > limit).then(clause)
    }
}

/// The clause about pixels of the test that are not finite; `None` without such pixels.
#[must_use]
pub fn not_finite(pixels: usize) -> Option<String> {
    let (noun, verb) = if pixels == 1 { ("pixel", "is") } else { ("pixels", "are") };
    (pixels > 0).then(|| format!("{pixels} {noun} of the test {verb} NaN or infinite"))
}

fn over(name: &str, value: Option<f64>, limit: Option<f64>) -> Option<String> {
    let limit = limit?;
    let Some(value) = value else { return Some(undefined(name, limit)) };
    (value > limit).then(|| format!("{name} {} is over the limit {limit}", number(value)))
}

fn undefined(name: &str, limit: f64) -> String {
    format!("{name} is undefined as the reference is black, and cannot be held to the limit {limit}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::testing::image;
    use crate::compare::{Tone, metrics};

    fn exceeded(limits: ImageLimits, reference: f32, test: f32) -> Vec<String> {
        let picture = |value: f32| image(8, 8, |_, _, _| value);
        let tone = Tone::Reinhard { exposure: 1.0 };
        limits.exceeded(&metrics(&picture(reference), &picture(test), tone, None).unwrap())
    }

    #[test]
    fn every_limit_is_checked_and_named() {
        let limits = ImageLimits { max_flip: Some(0.01), max_relmse: Some(0.1), energy_within_percent: Some(1.5) };
        assert_eq!(exceeded(limits, 1.0, 1.0), Vec::<String>::new());
        let clauses = exceeded(limits, 1.0, 1.5);
        assert_eq!(clauses.len(), 3, "{clauses:?}");
        assert!(clauses[0].starts_with("FLIP 0.") && clauses[0].ends_with("is over the limit 0.01"), "{clauses:?}");
        assert_eq!(clauses[1], "relMSE 0.247525 is over the limit 0.1");
        assert_eq!(clauses[2], "the energy ratio 1.5 is 50 % from 1, over the limit 1.5 %");
        assert_eq!(exceeded(ImageLimits::default(), 1.0, 1.5), Vec::<String>::new());
    }

    #[test]
    fn a_limit_of_exactly_the_value_holds() {
        let limits = ImageLimits { energy_within_percent: Some(50.0), ..ImageLimits::default() };
        assert!(exceeded(limits, 1.0, 1.5).is_empty() && exceeded(limits, 1.0, 0.5).is_empty());
        assert_eq!(exceeded(limits, 1.0, 0.25).len(), 1);
    }

    #[test]
    fn what_is_undefined_does_not_pass() {
        let limits = ImageLimits { max_relmse: Some(0.1), energy_within_percent: Some(1.0), ..ImageLimits::default() };
        let clauses = exceeded(limits, 0.0, 0.0);
        assert!(
            clauses.len() == 2 && clauses.iter().all(|clause| clause.contains("reference is black")),
            "{clauses:?}"
        );
    }

    #[test]
    fn one_pixel_is_enough() {
        assert_eq!(not_finite(0), None);
        assert_eq!(not_finite(1).unwrap(), "1 pixel of the test is NaN or infinite");
        assert_eq!(not_finite(2).unwrap(), "2 pixels of the test are NaN or infinite");
        let (reference, mut test) = (image(8, 8, |_, _, _| 1.0), image(8, 8, |_, _, _| 1.0));
        test.rgb[5] = f32::NAN;
        let found = metrics(&reference, &test, Tone::Reinhard { exposure: 1.0 }, None).unwrap();
        assert_eq!(ImageLimits::default().exceeded(&found), Vec::<String>::new());
        let limits = ImageLimits { max_flip: Some(1.0), ..ImageLimits::default() };
        assert_eq!(limits.exceeded(&found), ["1 pixel of the test is NaN or infinite"]);
    }
}
