//! Twin of the grid arithmetic in `common/lights.glsl`.

use glam::{UVec3, Vec3};

use crate::light_grid::Levels;
use crate::settings::CenterWeight;
use crate::shared::GridPlacement;

/// Where the grids stand and how many levels they have.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    /// Origin and cell size.
    pub placement: GridPlacement,
    /// The levels.
    pub levels: Levels,
    /// How lights count in positions.
    pub center: CenterWeight,
}

impl Grid {
    /// Edge of a cell of a level: `h_top / 2^(Lmax - l)`, exact.
    #[must_use]
    pub fn cell_size(&self, level: u32) -> f32 {
        self.placement.h_top * 2.0_f32.powi(level as i32 - self.levels.top as i32)
    }

    /// A position in units of a level's cells, within the level's vertices.
    #[must_use]
    pub fn grid_position(&self, position_ws: [f32; 3], level: u32) -> Vec3 {
        let offset = Vec3::from_array(position_ws) - Vec3::from_array(self.placement.origin_ws);
        let scale = self.placement.inverse_h_top * 2.0_f32.powi(self.levels.top as i32 - level as i32);
        let last = (self.levels.vertices_per_axis(level) - 1) as f32;
        (offset * scale).max(Vec3::ZERO).min(Vec3::splat(last))
    }

    /// The cell that holds a grid position: its lowest vertex.
    #[must_use]
    pub fn cell_of(&self, cells: Vec3, level: u32) -> UVec3 {
        cells.as_uvec3().min(UVec3::splat(self.levels.vertices_per_axis(level) - 2))
    }

    /// Word of the occupancy bits that holds a vertex; its bit is `x % 32`.
    #[must_use]
    pub fn occupancy_word(&self, vertex: UVec3, level: u32) -> usize {
        let n = self.levels.vertices_per_axis(level);
        let row = vertex.z * n + vertex.y;
        (self.levels.first_word(level) + row * self.levels.words_per_row(level) + vertex.x / 32) as usize
    }

    /// Index of a vertex within its level, x fastest.
    #[must_use]
    pub fn vertex_index(&self, vertex: UVec3, level: u32) -> u32 {
        let n = self.levels.vertices_per_axis(level);
        (vertex.z * n + vertex.y) * n + vertex.x
    }

    /// The vertex with an index within its level.
    #[must_use]
    pub fn vertex_from_index(&self, index: u32, level: u32) -> UVec3 {
        let n = self.levels.vertices_per_axis(level);
        UVec3::new(index % n, (index / n) % n, index / (n * n))
    }
}

/// Corner `0..8` of a cell, x in the lowest bit.
#[must_use]
pub fn corner(index: u32) -> UVec3 {
    UVec3::new(index & 1, (index >> 1) & 1, index >> 2)
}

/// A vertex of S1 in units of the cells of a level, exact: the grids nest.
#[must_use]
pub fn s1_vertex_in_cells(vertex: UVec3, level: u32) -> Vec3 {
    vertex.as_vec3() * 2.0_f32.powi(1 - level as i32)
}

/// Corners with no more than this weight are left out.
pub const MIN_WEIGHT: f32 = 1e-6;

/// Twin of `common/vertex_share.glsl`: the trilinear weight of a corner, or 0 where that is left out.
#[must_use]
pub fn vertex_share(fraction: Vec3, corner: UVec3) -> f32 {
    let weight = trilinear_weight(fraction, corner);
    if weight > MIN_WEIGHT { weight } else { 0.0 }
}

/// Trilinear weight of a corner for a position `fraction` inside its cell.
#[must_use]
pub fn trilinear_weight(fraction: Vec3, corner: UVec3) -> f32 {
    let along = |fraction: f32, corner: u32| if corner == 1 { fraction } else { 1.0 - fraction };
    along(fraction.x, corner.x) * along(fraction.y, corner.y) * along(fraction.z, corner.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit_grid(top: u32) -> Grid {
        let placement = GridPlacement {
            origin_ws: [0.0; 3],
            h_top: 1.0,
            inverse_h_top: 1.0,
            flux_scale: 1.0,
            light_count: 1,
            padding: 0,
        };
        Grid { placement, levels: Levels::new(top), center: CenterWeight::Intensity }
    }

    #[test]
    fn trilinear_weights_by_hand() {
        let fraction = Vec3::new(0.25, 0.5, 0.0);
        let weights: Vec<f32> = (0..8).map(|i| trilinear_weight(fraction, corner(i))).collect();
        assert_eq!(weights, [0.375, 0.125, 0.375, 0.125, 0.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn trilinear_weights_sum_to_one() {
        for i in 0..1000_u32 {
            let part = |k: u32| (i.wrapping_mul(k) >> 8 & 0xffff) as f32 / 65536.0;
            let fraction = Vec3::new(part(2_654_435_761), part(3_242_174_889), part(2_447_445_414));
            let sum: f32 = (0..8).map(|i| trilinear_weight(fraction, corner(i))).sum();
            assert!((sum - 1.0).abs() < 1e-6, "{fraction}: {sum}");
        }
    }

    #[test]
    fn positions_cells_and_indices() {
        let grid = unit_grid(3);
        assert_eq!(grid.cell_size(3), 1.0);
        assert_eq!(grid.cell_size(1), 0.25);
        assert_eq!(grid.grid_position([0.3, -1.0, 2.0], 1), Vec3::new(0.3, 0.0, 1.0) * 4.0);
        assert_eq!(grid.cell_of(Vec3::new(1.5, 4.0, 0.0), 1), UVec3::new(1, 3, 0), "the far side joins the last cell");
        let vertex = UVec3::new(4, 2, 1);
        assert_eq!(grid.vertex_index(vertex, 1), 25 + 10 + 4);
        assert_eq!(grid.vertex_from_index(39, 1), vertex);
        assert_eq!(grid.occupancy_word(vertex, 1), 7);
        assert_eq!(grid.occupancy_word(UVec3::ZERO, 2), 26, "25 words and the empty one");
    }
}
