//! What frames of the hierarchy count.

use super::super::{Count, many_lights};
use super::grid_update;
use crate::passes::lgh_shape::LghShape;

/// The counters are those of the lights S0, the level table, those of the update of S1 where there is one, and the lights tested
/// per pixel where they are counted.
pub(super) fn counts(shape: &LghShape, words: &[Vec<u32>]) -> Vec<Count> {
    let mut counts = many_lights::counts(&shape.lights, words);
    let top = shape.levels.top as usize;
    if let Some(table) = words.get(1).filter(|table| table.len() >= 2 * top + 2) {
        let levels: Vec<u32> = (1..=top).map(|level| table[2 * level + 1]).collect();
        counts.push(Count::new("level_count", "levels", shape.levels.top));
        counts.push(Count::new("grid_lights_per_level", "lights of level", levels));
    }
    counts.extend(grid_update::counts(shape, words));
    if let Some(tested) = words.get(2 + usize::from(shape.is_updated())) {
        let sum: f64 = tested.iter().map(|lights| f64::from(*lights)).sum();
        let pixels = f64::from(shape.picture_px[0]) * f64::from(shape.picture_px[1]);
        let most = tested.iter().copied().max().unwrap_or(0);
        counts.push(Count::new("lights_tested_mean", "lights tested per pixel, mean", sum / pixels));
        counts.push(Count::new("lights_tested_max", "lights tested per pixel, most", most));
    }
    counts
}
