//! S1, the finest level (passes `grid_scatter/...`): each vertex sums the lights of its cells, or each light adds itself
//! to its eight surrounding vertices (section 3.1); with `--build scatter` every level, the slow variant of Table 1.

use super::compaction::{GridLights, Lights, over_level};
use super::lgh_shape::LghShape;
use super::light_buckets::LightBuckets;
use super::{Frame, shader, threads};
use crate::gpu::ComputeWork;
use crate::graph::{Access, BufferHandle};
use crate::shared::MOMENT_WORDS;

/// Adds the passes for levels `1..=last`, with atomic additions.
pub fn add(
    frame: &mut Frame,
    shape: &LghShape,
    lights: &Lights,
    placement: BufferHandle,
    grid: &GridLights,
    last: u32,
) {
    let moments = declare_moments(frame, shape);
    frame.clear(&[(moments, 0)]);
    for level in 1..=last {
        let work = ComputeWork {
            push: vec![level],
            constants: vec![shape.center_constant()],
            ..shader("grid_scatter/scatter_lights", threads(shape.lights.light_capacity()))
        };
        let pass = frame
            .compute(&format!("grid_scatter/S{level}"), work)
            .with(|pass| lights.read_by(pass))
            .bind("grid", placement, Access::ComputeRead)
            .with(|pass| grid.looked_up_by(pass))
            .bind("moments", moments, Access::ComputeReadWrite);
        frame.graph.add_pass(pass);
    }
    for level in 1..=last {
        resolve(frame, shape, placement, grid, moments, level);
    }
}

/// Adds the passes for S1, without atomic additions: each vertex sums the lights of its cells.
pub fn add_sorted(
    frame: &mut Frame,
    shape: &LghShape,
    lights: &Lights,
    placement: BufferHandle,
    grid: &GridLights,
    buckets: &LightBuckets,
) {
    let moments = declare_moments(frame, shape);
    let work = ComputeWork {
        constants: vec![shape.center_constant()],
        ..shader("grid_scatter/sum_lights", over_level(grid, 1))
    };
    let pass = frame
        .compute("grid_scatter/S1", work)
        .with(|pass| lights.read_by(pass))
        .bind("grid", placement, Access::ComputeRead)
        .with(|pass| buckets.read_by(pass))
        .bind("level_table", grid.level_table, Access::ComputeRead)
        .bind("moments", moments, Access::ComputeWrite)
        .bind("grid_lights", grid.lights, Access::ComputeRead)
        .uses(grid.dispatches, Access::IndirectRead);
    frame.graph.add_pass(pass);
    resolve(frame, shape, placement, grid, moments, 1);
}

fn declare_moments(frame: &mut Frame, shape: &LghShape) -> BufferHandle {
    let size = 4 * u64::from(MOMENT_WORDS) * u64::from(shape.grid_capacity);
    frame.graph.transient_buffer("moments", size)
}

/// Turns the moments of a level into its lights.
fn resolve(
    frame: &mut Frame,
    shape: &LghShape,
    placement: BufferHandle,
    grid: &GridLights,
    moments: BufferHandle,
    level: u32,
) {
    let work = ComputeWork {
        push: vec![level],
        constants: vec![shape.center_constant()],
        ..shader("grid_scatter/resolve_moments", over_level(grid, level))
    };
    let pass = frame
        .compute(&format!("grid_scatter/resolve_S{level}"), work)
        .bind("moments", moments, Access::ComputeRead)
        .bind("grid", placement, Access::ComputeRead)
        .bind("level_table", grid.level_table, Access::ComputeRead)
        .bind("grid_lights", grid.lights, Access::ComputeReadWrite)
        .uses(grid.dispatches, Access::IndirectRead);
    frame.graph.add_pass(pass);
}
