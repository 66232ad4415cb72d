//! The density of starts, learnt from paths that come from the camera.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::StartDensity;
use crate::shared::{StartCell, StartSample};

/// Parts of the picture along each edge that starts are sought from, and paths from the point that is seen in each: so many
/// that places of a thousandth of the picture have their part, and so few that it takes less time than a frame.
pub const PARTS_PER_EDGE: u32 = 32;
/// See [`PARTS_PER_EDGE`].
pub const PATHS_PER_PART: u32 = 16;
/// Share of the paths that start where no light was found as well, so that light which was missed is there too, if noisier:
/// half of it anywhere, half in any cell, as cells are small near where there is light.
const SHARE_ANYWHERE: f64 = 0.5;
/// Cells are halved until none has more than this part of the light, each by enough samples that what is learnt is no
/// noise: their number is right to about a fifth.
const HEAVIEST_CELL: f64 = 1.0 / 512.0;
const FEWEST_SAMPLES: usize = 24;
/// Cells at most: where light comes from a few very small parts, it takes many cells to lead there.
const MOST_CELLS: usize = 2048;
/// Edges are not halved further: there the random numbers have no more bits.
const SHORTEST_EDGE: f32 = 1.0 / 1_048_576.0;

/// What has been learnt.
#[derive(Clone, Debug)]
pub struct Learnt {
    /// The density.
    pub density: StartDensity,
    /// Of so many paths that start anywhere, one counts.
    pub concentration: f64,
}

/// Learns from what paths from the camera have found; those of one visible point follow each other, `bounces` samples of
/// each path. `None` where no light was found. With one light there is nothing to choose in the first number.
#[must_use]
pub fn learn(samples: &[StartSample], bounces: u32, one_light: bool) -> Option<Learnt> {
    let weights = weights(samples, (PATHS_PER_PART * bounces) as usize);
    let total: f64 = weights.iter().sum();
    let found: Vec<Weighted> = samples
        .iter()
        .zip(&weights)
        .filter(|(_, weight)| **weight > 0.0)
        .map(|(sample, weight)| Weighted { start: sample.start, weight: weight / total })
        .collect();
    if found.is_empty() {
        return None;
    }
    let parts = divide(found, one_light);
    let concentration = parts.iter().map(|part| part.weight * part.weight / part.volume()).sum();
    Some(Learnt { density: density(&parts), concentration })
}

/// How much each sample counts: its part of the light of its visible point, so that dark places count like bright ones,
/// down to those that are darker than the mean.
fn weights(samples: &[StartSample], samples_of_point: usize) -> Vec<f64> {
    let light = |sample: &StartSample| f64::from(sample.light);
    let points: Vec<f64> = samples.chunks(samples_of_point).map(|point| point.iter().map(light).sum()).collect();
    let mean = points.iter().sum::<f64>() / points.len().max(1) as f64;
    let weight = |(index, sample): (usize, &StartSample)| light(sample) / (points[index / samples_of_point] + mean);
    if mean > 0.0 { samples.iter().enumerate().map(weight).collect() } else { vec![0.0; samples.len()] }
}

#[derive(Clone, Copy)]
struct Weighted {
    start: [f32; 3],
    weight: f64,
}

/// A cell and the samples in it.
struct Part {
    low: [f32; 3],
    size: [f32; 3],
    weight: f64,
    samples: Vec<Weighted>,
}

impl Part {
    fn volume(&self) -> f64 {
        self.size.iter().map(|edge| f64::from(*edge)).product()
    }

    /// Its halves across an axis, of which it keeps the lower one and gives the upper one.
    fn split(&mut self, axis: usize) -> Self {
        self.size[axis] *= 0.5;
        let mut low = self.low;
        low[axis] += self.size[axis];
        let (upper, lower) = self.samples.iter().partition(|sample| sample.start[axis] >= low[axis]);
        self.samples = lower;
        self.weight = sum(&self.samples);
        Self { low, size: self.size, weight: sum(&upper), samples: upper }
    }

    /// The axis whose halves differ most in their light; of equal ones the longest. `None` where no axis can be halved.
    fn best_axis(&self, first_axis: usize) -> Option<usize> {
        let key = |axis: &usize| {
            let middle = self.low[*axis] + 0.5 * self.size[*axis];
            let upper: f64 =
                self.samples.iter().filter(|sample| sample.start[*axis] >= middle).map(|sample| sample.weight).sum();
            ((2.0 * upper - self.weight).abs(), self.size[*axis])
        };
        let compare = |a: &usize, b: &usize| {
            let (a, b) = (key(a), key(b));
            a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
        };
        (first_axis..3).filter(|axis| self.size[*axis] > SHORTEST_EDGE).max_by(compare)
    }
}

fn sum(samples: &[Weighted]) -> f64 {
    samples.iter().map(|sample| sample.weight).sum()
}

/// Divides the unit cube, always the cell with the most light.
fn divide(samples: Vec<Weighted>, one_light: bool) -> Vec<Part> {
    let mut parts = vec![Part { low: [0.0; 3], size: [1.0; 3], weight: sum(&samples), samples }];
    let mut open = BinaryHeap::from([Heavy(parts[0].weight, 0)]);
    while let Some(Heavy(weight, index)) = open.pop() {
        if weight <= HEAVIEST_CELL || parts.len() == MOST_CELLS {
            break;
        }
        let axis = parts[index].best_axis(one_light.into());
        let Some(axis) = axis.filter(|_| parts[index].samples.len() >= FEWEST_SAMPLES) else { continue };
        let upper = parts[index].split(axis);
        parts.push(upper);
        open.extend([index, parts.len() - 1].map(|part| Heavy(parts[part].weight, part)));
    }
    parts
}

/// A cell by its light, the first of equal ones being the heaviest.
#[derive(PartialEq)]
struct Heavy(f64, usize);

impl Eq for Heavy {}

impl Ord for Heavy {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0).then(other.1.cmp(&self.1))
    }
}

impl PartialOrd for Heavy {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// The shares of the cells: by their light, and a part by their size and number.
fn density(parts: &[Part]) -> StartDensity {
    let (mut first, each) = (0.0, 1.0 / parts.len() as f64);
    let cells = parts.iter().map(|part| {
        let share = (1.0 - SHARE_ANYWHERE) * part.weight + SHARE_ANYWHERE * 0.5 * (part.volume() + each);
        let cell = StartCell { low: part.low, first: first as f32, size: part.size, share: share as f32 };
        first += share;
        cell
    });
    StartDensity { cells: cells.collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{hash, unit_float};

    /// What so many visible points find: `start` of each sample from three random numbers.
    fn samples(points: u32, light: f32, start: impl Fn([f32; 3]) -> [f32; 3]) -> Vec<StartSample> {
        let numbers = |i: u32| [1, 2, 3].map(|salt| unit_float(hash(i ^ hash(salt))));
        (0..points * PATHS_PER_PART).map(|i| StartSample { start: start(numbers(i)), light }).collect()
    }

    /// Whether the cells fill the cube and all paths start in one of them.
    fn check(density: &StartDensity) -> Result<(), String> {
        let volume: f64 = density.cells.iter().map(|cell| cell.size.map(f64::from).iter().product::<f64>()).sum();
        let mut first = 0.0;
        for cell in &density.cells {
            if !((f64::from(cell.first) - first).abs() <= 1e-6 && cell.share > 0.0) {
                return Err(format!("{cell:?} does not begin at {first}"));
            }
            first += f64::from(cell.share);
        }
        let complete = (volume - 1.0).abs() <= 1e-9 && (first - 1.0).abs() <= 1e-5;
        if complete { Ok(()) } else { Err(format!("volume {volume}, shares {first}")) }
    }

    #[test]
    fn even_light_has_nothing_to_choose() {
        let learnt = learn(&samples(1000, 1.0, |numbers| numbers), 1, false).unwrap();
        check(&learnt.density).unwrap();
        assert!((1.0..1.2).contains(&learnt.concentration), "{}", learnt.concentration);
        let mut wrong = learnt.density.clone();
        wrong.cells.pop();
        check(&wrong).unwrap_err();
        check(&StartDensity::default()).unwrap();
    }

    #[test]
    fn paths_start_where_the_light_comes_from() {
        // All light through a part of a millionth.
        let at = |[a, b, c]: [f32; 3]| [a, 0.3 + 1e-3 * b, 0.7 + 1e-3 * c];
        let learnt = learn(&samples(1000, 1.0, at), 1, true).unwrap();
        check(&learnt.density).unwrap();
        assert!(learnt.concentration > 3e5 && learnt.concentration < 2e6, "{}", learnt.concentration);
        let there = |cell: &&StartCell| cell.low[1] > 0.299 && cell.low[1] < 0.301 && cell.size[1] < 1e-2;
        let share: f32 = learnt.density.cells.iter().filter(there).map(|cell| cell.share).sum();
        // Half of the paths by light, and a quarter in cells of which most are there.
        assert!(share > 0.7, "{share}");
        assert!(learnt.density.cells.iter().all(|cell| cell.size[0] == 1.0), "with one light nothing is chosen");
    }

    #[test]
    fn dark_places_count_like_bright_ones() {
        let mut both = samples(500, 100.0, |[a, b, c]| [a, 0.5 * b, c]);
        both.extend(samples(500, 50.0, |[a, b, c]| [a, 0.5 + 0.5 * b, c]));
        let learnt = learn(&both, 1, true).unwrap();
        let dark: f32 = learnt.density.cells.iter().filter(|cell| cell.low[1] >= 0.5).map(|cell| cell.share).sum();
        // By their light alone it were a third; a point of half the light counts 2/3 as much as a bright one or more.
        assert!((0.38..0.5).contains(&dark), "{dark}");
    }

    #[test]
    fn without_light_nothing_is_learnt() {
        assert!(learn(&samples(10, 0.0, |numbers| numbers), 1, false).is_none());
        assert!(learn(&[], 3, false).is_none());
    }
}
