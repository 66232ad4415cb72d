//! Automatic level choice: the most levels such that S1 has fewer than half as many lights as S0 (section 4.3), and that fit.

use rayon::prelude::*;

use super::Levels;
use super::anchor::GridAnchor;
use crate::shared::{MAX_LEVEL, MIN_TOP_LEVEL};

/// What the choice is based on and what follows from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LevelChoice {
    /// The levels.
    pub levels: Levels,
    /// Occupied vertices of S1.
    pub s1_count: u32,
    /// Occupied vertices of all levels above.
    pub upper_count: u32,
    /// Lights in the fullest cell of S1.
    pub most_in_cell: u32,
}

/// Chooses Lmax for lights at `positions`, of what `fits`; with `fixed` only counts. The grids stand where `anchor` is, else
/// around the lights.
#[must_use]
pub fn choose_levels(
    positions: &[[f32; 3]],
    anchor: Option<GridAnchor>,
    fixed: Option<u32>,
    fits: impl Fn(&LevelChoice) -> bool,
) -> LevelChoice {
    let last = fixed.map_or(MAX_LEVEL, |top| Levels::new(top).top);
    let (low, high) = light_bounds(positions);
    let cube = anchor.unwrap_or_else(|| GridAnchor {
        low_ws: low,
        edge: (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f32::max) * 1.0001,
    });
    let count_occupied = |levels: Levels| count_occupied(positions, cube, levels);
    let mut best = count_occupied(Levels::new(MIN_TOP_LEVEL));
    best.upper_count = best.s1_count;
    for top in MIN_TOP_LEVEL + 1..=last {
        // With one level more, what was S1 lies above it.
        let upper_count = best.upper_count.saturating_add(best.s1_count);
        let finer = LevelChoice { upper_count, ..count_occupied(Levels::new(top)) };
        let is_too_fine = 2 * finer.s1_count as usize >= positions.len();
        if fixed.is_none() && (is_too_fine || !fits(&finer)) {
            break;
        }
        best = finer;
    }
    best
}

/// The lowest and highest coordinates of lights.
#[must_use]
pub fn light_bounds(positions: &[[f32; 3]]) -> ([f32; 3], [f32; 3]) {
    let (mut low, mut high) = ([f32::MAX; 3], [f32::MIN; 3]);
    for p in positions {
        for axis in 0..3 {
            low[axis] = low[axis].min(p[axis]);
            high[axis] = high[axis].max(p[axis]);
        }
    }
    (low, high)
}

/// Counts the vertices of level 1 with a light in one of their cells.
fn count_occupied(positions: &[[f32; 3]], cube: GridAnchor, levels: Levels) -> LevelChoice {
    let GridAnchor { low_ws: low, edge } = cube;
    let vertices = levels.vertices_per_axis(1);
    let scale = if edge > 0.0 { (vertices - 1) as f32 / edge } else { 0.0 };
    let cell =
        |p: &[f32; 3]| pack([0, 1, 2].map(|axis| (((p[axis] - low[axis]) * scale) as u32).min(vertices - 2).into()));
    let mut cells: Vec<u64> = positions.par_iter().map(cell).collect();
    cells.par_sort_unstable();
    let most_in_cell = cells.chunk_by(|a, b| a == b).map(|lights| lights.len() as u32).max().unwrap_or(0);
    cells.dedup();
    // No carry: a coordinate has 20 bits.
    let corner = |i: u64| pack([i & 1, i >> 1 & 1, i >> 2]);
    let mut occupied: Vec<u64> = cells.par_iter().flat_map_iter(|cell| (0..8).map(move |i| cell + corner(i))).collect();
    occupied.par_sort_unstable();
    occupied.dedup();
    let s1_count = u32::try_from(occupied.len()).unwrap_or(u32::MAX);
    LevelChoice { levels, s1_count, upper_count: 0, most_in_cell }
}

/// A vertex or cell as one number.
fn pack([x, y, z]: [u64; 3]) -> u64 {
    x | y << 20 | z << 40
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_light_and_coincident_lights_take_the_fewest_levels() {
        let one = choose_levels(&[[1.0, 2.0, 3.0]], None, None, |_| true);
        assert_eq!(one.levels.top, 2);
        assert_eq!((one.s1_count, one.most_in_cell), (8, 1));
        assert_eq!(choose_levels(&[], None, None, |_| true).s1_count, 0);
    }

    #[test]
    fn coincident_lights_allow_every_level() {
        let many = choose_levels(&[[1.0, 2.0, 3.0]; 1000], None, None, |_| true);
        assert_eq!(many.levels.top, MAX_LEVEL);
        assert_eq!((many.s1_count, many.most_in_cell), (8, 1000));
    }

    #[test]
    fn s1_stays_below_half_the_lights() {
        let positions: Vec<[f32; 3]> = (0..10_000).map(|i| [(i % 100) as f32, (i / 100) as f32, 0.0]).collect();
        let choice = choose_levels(&positions, None, None, |_| true);
        assert!(choice.s1_count < 5_000, "{choice:?}");
        let next = choose_levels(&positions, None, Some(choice.levels.top + 1), |_| true);
        assert!(next.s1_count >= 5_000, "{next:?}");
    }

    #[test]
    fn levels_above_s1_are_counted_and_only_those_that_fit_are_chosen() {
        let positions: Vec<[f32; 3]> = (0..10_000).map(|i| [(i % 100) as f32, (i / 100) as f32, 0.0]).collect();
        let of = |top| choose_levels(&positions, None, Some(top), |_| true);
        let best = choose_levels(&positions, None, None, |_| true);
        assert_eq!(best, of(best.levels.top));
        let above: u32 = (2..=best.levels.top).map(|level| of(best.levels.top - level + 1).s1_count).sum();
        assert_eq!(best.upper_count, above);
        let room = best.s1_count + best.upper_count - 1;
        let smaller = choose_levels(&positions, None, None, |choice| choice.s1_count + choice.upper_count <= room);
        assert_eq!(smaller, of(best.levels.top - 1));
        // The fewest levels are taken whether they fit or not: what asks for them says so.
        assert_eq!(choose_levels(&positions, None, None, |_| false), of(MIN_TOP_LEVEL));
    }

    #[test]
    fn an_anchor_is_the_cube_that_cells_come_from() {
        let positions: Vec<[f32; 3]> =
            (0..1000).map(|i| [(i % 10) as f32, (i / 10 % 10) as f32, (i / 100) as f32]).collect();
        let own = choose_levels(&positions, None, Some(3), |_| true);
        assert_eq!(own.s1_count, 125, "every vertex of 4 cells per axis");
        // Twice as large: half as many cells hold them.
        let anchor = GridAnchor { low_ws: [0.0; 3], edge: 18.002 };
        let anchored = choose_levels(&positions, Some(anchor), Some(3), |_| true);
        assert_eq!(anchored.s1_count, 27, "{anchored:?}");
    }
}
