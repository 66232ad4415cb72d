//! Twin of `compaction/mark_grid_lights`.

use super::grid::{Grid, s1_vertex_in_cells};
use super::mark_lights::mark_vertices;
use crate::shared::GridLight;

/// Marks the occupied vertices of levels 2..=Lmax that the S1 lights share themselves with, by the S1 vertices they stand at.
pub fn mark_grid_lights(occupancy: &mut [u32], grid: &Grid, s1: &[GridLight]) {
    for light in s1 {
        for level in 2..=grid.levels.top {
            let vertex = grid.vertex_from_index(light.vertex, 1);
            mark_vertices(occupancy, grid, s1_vertex_in_cells(vertex, level), level);
        }
    }
}
