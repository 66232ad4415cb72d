//! Twin of `grid_gather/gather_vertex`.

use std::ops::Add;

use glam::{UVec3, Vec3};

use super::count_lights::LevelTable;
use super::grid::{Grid, s1_vertex_in_cells};
use crate::settings::CenterWeight;
use crate::shared::{GATHER_SIZE, GridLight};

/// Sums over S1 lights, positions relative to the vertex in cells of the gathering level.
#[derive(Clone, Copy, Default)]
pub(super) struct Moments {
    flux: Vec3,
    weight: f32,
    position: Vec3,
    luminance: f32,
    square: Vec3,
    lobe: Vec3,
}

impl Add for Moments {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            flux: self.flux + other.flux,
            weight: self.weight + other.weight,
            position: self.position + other.position,
            luminance: self.luminance + other.luminance,
            square: self.square + other.square,
            lobe: self.lobe + other.lobe,
        }
    }
}

/// The S1 lights as the gathering vertices find them.
struct Source<'a> {
    grid: &'a Grid,
    occupancy: &'a [u32],
    ranks: &'a [u32],
    s1: &'a [GridLight],
    level: u32,
}

/// Every vertex of one level gathers the S1 lights within one cell of it.
pub fn gather_vertex(
    lights: &mut [GridLight],
    grid: &Grid,
    occupancy: &[u32],
    ranks: &[u32],
    table: &LevelTable,
    level: u32,
) {
    let s1 = lights[table.range(1)].to_vec();
    let source = Source { grid, occupancy, ranks, s1: &s1, level };
    for record in table.range(level) {
        let vertex = grid.vertex_from_index(lights[record].vertex, level);
        store_light(&mut lights[record], source.gather(vertex), vertex.as_vec3(), grid, level);
    }
}

impl Source<'_> {
    /// The sum over all lanes, in the order of the shader's tree.
    fn gather(&self, vertex: UVec3) -> Moments {
        let last = self.grid.levels.vertices_per_axis(1) - 1;
        let scale = 1 << (self.level - 1);
        let middle = vertex * scale;
        let low = middle - middle.min(UVec3::splat(scale - 1));
        let high = (middle + (scale - 1)).min(UVec3::splat(last));
        let extent = high - low + 1;
        let mut lanes = [Moments::default(); GATHER_SIZE as usize];
        for i in 0..extent.y * extent.z {
            let row = (low.z + i / extent.y) * (last + 1) + low.y + i % extent.y;
            self.add_row(&mut lanes[(i % GATHER_SIZE) as usize], row, low.x..high.x + 1, vertex.as_vec3());
        }
        let mut stride = lanes.len() / 2;
        while stride > 0 {
            for lane in 0..stride {
                lanes[lane] = lanes[lane] + lanes[lane + stride];
            }
            stride /= 2;
        }
        lanes[0]
    }

    /// Adds the S1 lights of one row whose x lies in `columns`.
    fn add_row(&self, sums: &mut Moments, row: u32, columns: std::ops::Range<u32>, vertex: Vec3) {
        let first = row * self.grid.levels.words_per_row(1);
        for word in first + columns.start / 32..=first + (columns.end - 1) / 32 {
            let all = self.occupancy[word as usize];
            let inside = |bit: &u32| columns.contains(&((word - first) * 32 + bit));
            for bit in (0..32).filter(|bit| all >> bit & 1 == 1).filter(inside) {
                let rank = self.ranks[word as usize] + (all & ((1 << bit) - 1)).count_ones();
                if let Some(light) = self.s1.get(rank as usize) {
                    let n = self.grid.levels.vertices_per_axis(1);
                    let s1_vertex = UVec3::new((word - first) * 32 + bit, row % n, row / n);
                    self.add_light(sums, light, s1_vertex, vertex);
                }
            }
        }
    }

    fn add_light(&self, sums: &mut Moments, light: &GridLight, s1_vertex: UVec3, vertex: Vec3) {
        let hat = (1.0 - (s1_vertex_in_cells(s1_vertex, self.level) - vertex).abs()).max(Vec3::ZERO);
        sums.add_light(light, hat.x * hat.y * hat.z, vertex, self.grid, self.level);
    }
}

impl Moments {
    /// Adds a finer light with a weight.
    pub(super) fn add_light(&mut self, light: &GridLight, weight: f32, vertex: Vec3, grid: &Grid, level: u32) {
        let h = grid.cell_size(level);
        let q = grid.grid_position(light.position_ws, level) - vertex;
        let sums = self;
        let wm = weight * light.luminance;
        sums.flux += weight * Vec3::from_array(light.flux);
        sums.weight += weight * light.weight;
        let wp = if grid.center == CenterWeight::Uniform { weight * light.weight } else { wm };
        sums.position += wp * q;
        sums.luminance += wm;
        sums.square += wp * (Vec3::from_array(light.variance) / (h * h) + q * q);
        sums.lobe += wm * Vec3::from_array(light.lobe);
    }
}

pub(super) fn store_light(light: &mut GridLight, sums: Moments, vertex: Vec3, grid: &Grid, level: u32) {
    let h = grid.cell_size(level);
    let wm = sums.luminance.max(1e-37);
    let wp = if grid.center == CenterWeight::Uniform { sums.weight.max(1e-37) } else { wm };
    let mean = sums.position / wp;
    light.position_ws = (Vec3::from_array(grid.placement.origin_ws) + (vertex + mean) * h).to_array();
    light.luminance = wm;
    light.variance = ((sums.square / wp - mean * mean).max(Vec3::ZERO) * h * h).to_array();
    light.lobe = (sums.lobe / wm).to_array();
    light.weight = sums.weight;
    light.flux = sums.flux.to_array();
}
