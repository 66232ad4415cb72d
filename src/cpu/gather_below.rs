//! Twin of `grid_gather/gather_below`.

use std::collections::HashMap;

use glam::{IVec3, UVec3};

use super::count_lights::LevelTable;
use super::gather_vertex::{Moments, store_light};
use super::grid::Grid;
use crate::shared::{DESCENT_PARTS, GridLight};

/// Every vertex of one level gathers the lights of the 27 vertices of the level below that it is made of.
pub fn gather_below(lights: &mut [GridLight], grid: &Grid, table: &LevelTable, level: u32) {
    let vertex_of = |light: &GridLight, level: u32| grid.vertex_from_index(light.vertex, level);
    let below: HashMap<UVec3, usize> =
        table.range(level - 1).map(|record| (vertex_of(&lights[record], level - 1), record)).collect();
    for record in table.range(level) {
        let vertex = vertex_of(&lights[record], level);
        let mut sums = Moments::default();
        for i in 0..DESCENT_PARTS as i32 {
            let step = IVec3::new(i % 3, i / 3 % 3, i / 9) - 1;
            // A vertex outside the grid is none of the keys.
            let finer = (2 * vertex.as_ivec3() + step).as_uvec3();
            if let Some(light) = below.get(&finer) {
                let share = 0.5_f32.powi(step.abs().element_sum());
                sums.add_light(&lights[*light], share, vertex.as_vec3(), grid, level);
            }
        }
        store_light(&mut lights[record], sums, vertex.as_vec3(), grid, level);
    }
}
