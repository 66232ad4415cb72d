//! Twin of `grid_scatter/scatter_lights`.

use glam::Vec3;

use super::count_lights::LevelTable;
use super::fixed_point::{SMALLEST, fixed_from_float};
use super::grid::{Grid, corner, vertex_share};
use super::lights::LightList;
use crate::color::luminance;
use crate::settings::CenterWeight;

/// The 14 fixed-point sums of a vertex: w, wm, wm q (3), wm q^2 (3), wm n (3), w flux (3).
pub type Moments = [u64; 14];

/// Every light adds its moments to its surrounding vertices of one level; `moments` has one record per grid light.
pub fn scatter_lights(
    moments: &mut [Moments],
    lights: &LightList,
    grid: &Grid,
    occupancy: &[u32],
    ranks: &[u32],
    table: &LevelTable,
    level: u32,
) {
    for light in 0..lights.len() {
        let flux = lights.flux(light) / grid.placement.flux_scale;
        let cells = grid.grid_position(lights.position(light), level);
        let cell = grid.cell_of(cells, level);
        let fraction = cells - cell.as_vec3();
        for corner in (0..8).map(corner) {
            let weight = vertex_share(fraction, corner);
            let vertex = cell + corner;
            let word = grid.occupancy_word(vertex, level);
            let bit = 1 << (vertex.x % 32);
            if occupancy[word] & bit == 0 || weight <= 0.0 {
                continue;
            }
            let below = (occupancy[word] & (bit - 1)).count_ones();
            let rank = (ranks[word] - ranks[grid.levels.first_word(level) as usize] + below) as usize;
            if rank < table.count(level) {
                let record = &mut moments[table.first(level) + rank];
                let q = fraction - corner.as_vec3();
                add_moments(record, grid.center, weight, q, luminance(flux), lights.normal(light), flux);
            }
        }
    }
}

fn add_moments(record: &mut Moments, center: CenterWeight, weight: f32, q: Vec3, m: f32, normal: Vec3, flux: Vec3) {
    let wm = (weight * m).max(SMALLEST);
    let wp = if center == CenterWeight::Uniform { weight } else { wm };
    let mut add = |moment: usize, value: f32| {
        record[moment] = record[moment].wrapping_add(fixed_from_float(value));
    };
    add(0, weight);
    add(1, wm);
    for axis in 0..3 {
        add(2 + axis, wp * q[axis]);
        add(5 + axis, wp * q[axis] * q[axis]);
        add(8 + axis, wm * normal[axis]);
        add(11 + axis, weight * flux[axis]);
    }
}
