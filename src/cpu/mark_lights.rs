//! Twins of `compaction/mark_lights` and `compaction/mark_vertex.glsl`.

use std::ops::RangeInclusive;

use glam::Vec3;

use super::grid::{Grid, corner, vertex_share};
use super::lights::LightList;

/// Marks the vertices that a light at `cells` shares itself with.
pub fn mark_vertices(occupancy: &mut [u32], grid: &Grid, cells: Vec3, level: u32) {
    let cell = grid.cell_of(cells, level);
    let fraction = cells - cell.as_vec3();
    for corner in (0..8).map(corner) {
        if vertex_share(fraction, corner) > 0.0 {
            let vertex = cell + corner;
            occupancy[grid.occupancy_word(vertex, level)] |= 1 << (vertex.x % 32);
        }
    }
}

/// Marks the occupied vertices of `levels` from the lights S0.
pub fn mark_lights(occupancy: &mut [u32], grid: &Grid, lights: &LightList, levels: RangeInclusive<u32>) {
    for light in 0..lights.len() {
        for level in levels.clone() {
            mark_vertices(occupancy, grid, grid.grid_position(lights.position(light), level), level);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light_grid::Levels;
    use crate::shared::GridPlacement;

    #[test]
    fn a_light_inside_a_cell_marks_eight_and_one_on_a_vertex_marks_one() {
        let placement = GridPlacement {
            origin_ws: [0.0; 3],
            h_top: 2.0,
            inverse_h_top: 0.5,
            flux_scale: 1.0,
            light_count: 1,
            padding: 0,
        };
        let grid = Grid { placement, levels: Levels::new(2), center: crate::settings::CenterWeight::Intensity };
        let marked = |position: [f32; 3]| {
            let mut lights = LightList::default();
            lights.push(position, 0, [1.0; 3], false);
            let mut occupancy = vec![0; grid.levels.total_words() as usize];
            mark_lights(&mut occupancy, &grid, &lights, 1..=2);
            occupancy
        };
        // Level 1: 3 x 3 rows of one word, then the empty word, then level 2: 2 x 2 rows.
        assert_eq!(marked([1.5, 0.5, 0.5]), [6, 6, 0, 6, 6, 0, 0, 0, 0, 0, 3, 3, 3, 3, 0]);
        assert_eq!(marked([1.0, 0.0, 0.0]), [2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 3, 0, 0, 0, 0]);
    }
}
