//! `grid_scatter`: builds levels by scattering every light to its eight surrounding vertices (section 3.1).
//! S1 always; with `--build scatter` every level, the slow variant of Table 1.

use super::compaction::{GridLights, Lights, over_level};
use super::{Frame, shader, threads};
use crate::gpu::ComputeWork;
use crate::graph::{Access, BufferHandle};
use crate::settings::Center;
use crate::shared::MOMENT_WORDS;

/// Adds the passes for levels `1..=last`.
pub fn add(frame: &mut Frame, lights: &Lights, placement: BufferHandle, grid: &GridLights, last: u32) {
    let size = 4 * u64::from(MOMENT_WORDS) * u64::from(frame.shape.grid_capacity);
    let moments = frame.graph.transient_buffer("moments", size);
    let uniform_center = u32::from(frame.shape.center == Center::Uniform);
    frame.clear("grid_scatter/clear", &[(moments, 0)]);
    for level in 1..=last {
        let work = ComputeWork {
            push: vec![level],
            constants: vec![uniform_center],
            ..shader("grid_scatter/scatter_lights", threads(frame.shape.light_capacity()))
        };
        let pass = frame
            .compute(&format!("grid_scatter/S{level}"), work)
            .bind(1, lights.positions, Access::ComputeRead)
            .bind(2, lights.fluxes, Access::ComputeRead)
            .bind(3, placement, Access::ComputeRead)
            .bind(4, grid.occupancy, Access::ComputeRead)
            .bind(5, grid.ranks, Access::ComputeRead)
            .bind(6, grid.level_table, Access::ComputeRead)
            .bind(7, moments, Access::ComputeReadWrite);
        frame.graph.add_pass(pass);
    }
    for level in 1..=last {
        let work = ComputeWork {
            push: vec![level],
            constants: vec![uniform_center],
            ..shader("grid_scatter/resolve_moments", over_level(grid, level))
        };
        let pass = frame
            .compute(&format!("grid_scatter/resolve_S{level}"), work)
            .bind(1, moments, Access::ComputeRead)
            .bind(2, placement, Access::ComputeRead)
            .bind(3, grid.level_table, Access::ComputeRead)
            .bind(4, grid.lights, Access::ComputeReadWrite)
            .uses(grid.dispatches, Access::IndirectRead);
        frame.graph.add_pass(pass);
    }
}
