//! Twin of `compaction/mark_grid_lights`.

use super::grid::Grid;
use super::mark_lights::mark_vertices;
use crate::shared::GridLight;

/// Marks the occupied vertices of levels 2..=Lmax from the centres of the S1 lights.
pub fn mark_grid_lights(occupancy: &mut [u32], grid: &Grid, s1: &[GridLight]) {
    for light in s1 {
        for level in 2..=grid.levels.top {
            mark_vertices(occupancy, grid, grid.grid_position(light.position_ws, level), level);
        }
    }
}
