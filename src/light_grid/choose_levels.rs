//! Automatic level choice: the most levels such that S1 has fewer than half as many lights as S0 (section 4.3).

use std::collections::{HashMap, HashSet};

use super::Levels;
use crate::shared::MAX_LEVEL;

/// What the choice is based on and what follows from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LevelChoice {
    /// The levels.
    pub levels: Levels,
    /// Occupied vertices of S1.
    pub s1_count: u32,
    /// Lights in the fullest cell of S1.
    pub most_in_cell: u32,
}

/// Chooses Lmax for lights at `positions`; with `fixed` only counts.
#[must_use]
pub fn choose_levels(positions: &[[f32; 3]], fixed: Option<u32>) -> LevelChoice {
    if let Some(top) = fixed {
        let levels = Levels::new(top);
        return count_occupied(positions, levels);
    }
    let mut best = count_occupied(positions, Levels::new(2));
    for top in 3..=MAX_LEVEL {
        let finer = count_occupied(positions, Levels::new(top));
        if 2 * finer.s1_count as usize >= positions.len() {
            break;
        }
        best = finer;
    }
    best
}

/// Counts the vertices of level 1 with a light in one of their cells.
fn count_occupied(positions: &[[f32; 3]], levels: Levels) -> LevelChoice {
    let (mut low, mut high) = ([f32::MAX; 3], [f32::MIN; 3]);
    for p in positions {
        for axis in 0..3 {
            low[axis] = low[axis].min(p[axis]);
            high[axis] = high[axis].max(p[axis]);
        }
    }
    let edge = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f32::max) * 1.0001;
    let vertices = levels.vertices_per_axis(1);
    let scale = if edge > 0.0 { (vertices - 1) as f32 / edge } else { 0.0 };
    let mut cells: HashMap<[u32; 3], u32> = HashMap::new();
    for p in positions {
        let cell = [0, 1, 2].map(|axis| (((p[axis] - low[axis]) * scale) as u32).min(vertices - 2));
        *cells.entry(cell).or_default() += 1;
    }
    let occupied: HashSet<u64> = cells
        .keys()
        .flat_map(|cell| {
            (0..8_u32).map(|i| {
                let corner = [cell[0] + (i & 1), cell[1] + (i >> 1 & 1), cell[2] + (i >> 2)].map(u64::from);
                corner[0] | corner[1] << 20 | corner[2] << 40
            })
        })
        .collect();
    LevelChoice {
        levels,
        s1_count: u32::try_from(occupied.len()).unwrap_or(u32::MAX),
        most_in_cell: cells.values().copied().max().unwrap_or(0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_light_and_coincident_lights_take_the_fewest_levels() {
        let one = choose_levels(&[[1.0, 2.0, 3.0]], None);
        assert_eq!(one.levels.top, 2);
        assert_eq!((one.s1_count, one.most_in_cell), (8, 1));
        assert_eq!(choose_levels(&[], None).s1_count, 0);
    }

    #[test]
    fn coincident_lights_allow_every_level() {
        let many = choose_levels(&[[1.0, 2.0, 3.0]; 1000], None);
        assert_eq!(many.levels.top, MAX_LEVEL);
        assert_eq!((many.s1_count, many.most_in_cell), (8, 1000));
    }

    #[test]
    fn s1_stays_below_half_the_lights() {
        let positions: Vec<[f32; 3]> = (0..10_000).map(|i| [(i % 100) as f32, (i / 100) as f32, 0.0]).collect();
        let choice = choose_levels(&positions, None);
        assert!(choice.s1_count < 5_000, "{choice:?}");
        let next = choose_levels(&positions, Some(choice.levels.top + 1));
        assert!(next.s1_count >= 5_000, "{next:?}");
    }
}
