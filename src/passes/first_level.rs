//! S1, the finest level (passes `grid_scatter/...`): each vertex sums the lights of its cells, or each light adds itself
//! to its eight surrounding vertices (section 3.1); with `--build scatter` every level, the slow variant of Table 1.

use super::compaction::{GridLights, Lights, over_level};
use super::lgh_shape::LghShape;
use super::light_buckets::LightBuckets;
use super::{Frame, read_dispatch, shader, threads};
use crate::gpu::{ComputeWork, Dispatch};
use crate::graph::{Access, BufferHandle};
use crate::shared::MOMENT_WORDS;

/// What S1 is built of: the lights, where the grids stand, and the vertices that are listed.
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'a> {
    /// Sizes and modes.
    pub shape: &'a LghShape,
    /// S0.
    pub lights: &'a Lights,
    /// Grid placement.
    pub placement: BufferHandle,
    /// The grid lights that the sums become.
    pub grid: &'a GridLights,
}

/// Adds the passes for levels `1..=last`, with atomic additions.
pub fn add(frame: &mut Frame, inputs: Inputs<'_>, last: u32) {
    let Inputs { shape, lights, placement, grid } = inputs;
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
        resolve(frame, inputs, moments, level);
    }
}

/// Adds the passes for S1, without atomic additions: each vertex sums the lights of its cells.
pub fn add_sorted(frame: &mut Frame, inputs: Inputs<'_>, buckets: &LightBuckets) {
    let moments = declare_moments(frame, inputs.shape);
    sum(frame, inputs, buckets, moments, over_level(inputs.grid, 1));
    resolve(frame, inputs, moments, 1);
}

/// Adds the pass that sums the lights of S1's vertices, with a dispatch over all of these, or none.
pub(super) fn sum(
    frame: &mut Frame,
    inputs: Inputs<'_>,
    buckets: &LightBuckets,
    moments: BufferHandle,
    dispatch: Dispatch,
) {
    let Inputs { shape, lights, placement, grid } = inputs;
    let work = ComputeWork { constants: vec![shape.center_constant()], ..shader("grid_scatter/sum_lights", dispatch) };
    let pass = frame
        .compute("grid_scatter/S1", work)
        .with(|pass| lights.read_by(pass))
        .bind("grid", placement, Access::ComputeRead)
        .with(|pass| buckets.read_by(pass))
        .bind("level_table", grid.level_table, Access::ComputeRead)
        .bind("moments", moments, Access::ComputeWrite)
        .bind("grid_lights", grid.lights, Access::ComputeRead)
        .with(read_dispatch);
    frame.graph.add_pass(pass);
}

/// Declares the sums of all vertices.
pub(super) fn declare_moments(frame: &mut Frame, shape: &LghShape) -> BufferHandle {
    frame.graph.transient_buffer("moments", moments_bytes(shape))
}

/// Bytes of the sums of all vertices.
pub(super) fn moments_bytes(shape: &LghShape) -> u64 {
    4 * u64::from(MOMENT_WORDS) * u64::from(shape.grid_capacity)
}

/// Turns the moments of a level into its lights.
pub(super) fn resolve(frame: &mut Frame, inputs: Inputs<'_>, moments: BufferHandle, level: u32) {
    let Inputs { shape, placement, grid, .. } = inputs;
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
        .with(read_dispatch);
    frame.graph.add_pass(pass);
}
