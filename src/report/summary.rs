//! Summary statistics of a series of measurements.

use serde::Serialize;

/// Five numbers that describe a series.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// The smallest value.
    pub min: f64,
    /// The middle value; of an even number of values, the mean of the middle two.
    pub median: f64,
    /// The arithmetic mean.
    pub mean: f64,
    /// The 95th percentile by nearest rank: the smallest value with at least 95 % of the series at or below it.
    pub p95: f64,
    /// The largest value.
    pub max: f64,
}

impl Summary {
    /// The statistics of `values`, or `None` when there are none.
    #[must_use]
    pub fn of(values: &[f64]) -> Option<Self> {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let count = sorted.len();
        let (&min, &max) = (sorted.first()?, sorted.last()?);
        let median = f64::midpoint(sorted[(count - 1) / 2], sorted[count / 2]);
        let mean = sorted.iter().sum::<f64>() / count as f64;
        let p95 = sorted[(95 * count).div_ceil(100) - 1];
        Some(Self { min, median, mean, p95, max })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_has_no_statistics() {
        assert_eq!(Summary::of(&[]), None);
    }

    #[test]
    fn one_value_is_every_statistic() {
        let stats = Summary::of(&[2.5]).unwrap();
        assert_eq!(stats, Summary { min: 2.5, median: 2.5, mean: 2.5, p95: 2.5, max: 2.5 });
    }

    #[test]
    fn odd_and_even_counts() {
        let stats = Summary::of(&[9.0, 1.0, 2.0]).unwrap();
        assert_eq!(stats, Summary { min: 1.0, median: 2.0, mean: 4.0, p95: 9.0, max: 9.0 });
        let stats = Summary::of(&[4.0, 1.0, 3.0, 8.0]).unwrap();
        assert_eq!(stats, Summary { min: 1.0, median: 3.5, mean: 4.0, p95: 8.0, max: 8.0 });
    }

    #[test]
    fn p95_is_by_nearest_rank() {
        let series = |count: u32| (1..=count).rev().map(f64::from).collect::<Vec<_>>();
        for (count, p95) in [(19, 19.0), (20, 19.0), (21, 20.0), (100, 95.0), (101, 96.0)] {
            assert_eq!(Summary::of(&series(count)).unwrap().p95.to_bits(), f64::to_bits(p95), "{count} values");
        }
    }
}
