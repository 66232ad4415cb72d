//! Twin of `grid_scatter/scatter_lights` and `grid_scatter/add_light.glsl`.

use glam::{UVec3, Vec3};

use super::count_lights::LevelTable;
use super::fixed_point::{SMALLEST, fixed_from_float};
use super::grid::{Grid, corner, vertex_share};
use super::lights::LightList;
use crate::color::luminance;
use crate::settings::CenterWeight;

/// The 14 fixed-point sums of a vertex: w, wm, wm q (3), wm q^2 (3), wm n (3), w flux (3).
pub type Moments = [u64; 14];

/// Where the records of vertices are.
#[derive(Clone, Copy, Debug)]
pub struct Records<'a> {
    /// One bit per vertex.
    pub occupancy: &'a [u32],
    /// For each word of them the set bits before it.
    pub ranks: &'a [u32],
    /// First record and number of records of each level.
    pub table: &'a LevelTable,
}

impl Records<'_> {
    /// Record of a vertex of a level; `None` where there is none, or it had no room.
    #[must_use]
    pub fn at(&self, grid: &Grid, vertex: UVec3, level: u32) -> Option<usize> {
        let word = grid.occupancy_word(vertex, level);
        let bit = 1 << (vertex.x % 32);
        let below = (self.occupancy[word] & (bit - 1)).count_ones();
        let rank = (self.ranks[word] - self.ranks[grid.levels.first_word(level) as usize] + below) as usize;
        let is_there = self.occupancy[word] & bit != 0 && rank < self.table.count(level);
        is_there.then(|| self.table.first(level) + rank)
    }
}

/// Whether a light is added or taken away.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sign {
    /// Added.
    Plus,
    /// Taken away.
    Minus,
}

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
    let records = Records { occupancy, ranks, table };
    for light in 0..lights.len() {
        add_light(moments, lights, light, grid, &records, level, Sign::Plus);
    }
}

/// One light adds its moments to its surrounding vertices of a level, or takes them away.
pub fn add_light(
    moments: &mut [Moments],
    lights: &LightList,
    light: usize,
    grid: &Grid,
    records: &Records<'_>,
    level: u32,
    sign: Sign,
) {
    let flux = lights.flux(light) / grid.placement.flux_scale;
    let cells = grid.grid_position(lights.position(light), level);
    let cell = grid.cell_of(cells, level);
    let fraction = cells - cell.as_vec3();
    for corner in (0..8).map(corner) {
        let weight = vertex_share(fraction, corner);
        if weight <= 0.0 {
            continue;
        }
        if let Some(record) = records.at(grid, cell + corner, level) {
            let q = fraction - corner.as_vec3();
            let terms = moments_of(grid.center, weight, q, luminance(flux), lights.normal(light), flux);
            for (sum, term) in moments[record].iter_mut().zip(terms) {
                let term = fixed_from_float(term);
                *sum = sum.wrapping_add(if sign == Sign::Plus { term } else { term.wrapping_neg() });
            }
        }
    }
}

fn moments_of(center: CenterWeight, weight: f32, q: Vec3, m: f32, normal: Vec3, flux: Vec3) -> [f32; 14] {
    let wm = (weight * m).max(SMALLEST);
    let wp = if center == CenterWeight::Uniform { weight } else { wm };
    let mut terms = [0.0; 14];
    (terms[0], terms[1]) = (weight, wm);
    for axis in 0..3 {
        terms[2 + axis] = wp * q[axis];
        terms[5 + axis] = wp * q[axis] * q[axis];
        terms[8 + axis] = wm * normal[axis];
        terms[11 + axis] = weight * flux[axis];
    }
    terms
}
