//! `bounds`: the lights' bounding box and largest flux, and from them the placement of the grids.

use super::compaction::Lights;
use super::{Frame, shader, threads};
use crate::gpu::Dispatch;
use crate::graph::{Access, BufferHandle};
use crate::shared::GridPlacement;

/// Workgroups of the reduction at most; each strides over the lights.
const MAX_GROUPS: u32 = 64;

/// Adds the passes; gives the buffer with the [`GridPlacement`].
pub fn add(frame: &mut Frame, lights: &Lights) -> BufferHandle {
    let bounds = frame.graph.persistent_buffer("bounds", 32);
    let placement = frame.graph.persistent_buffer("grid_placement", size_of::<GridPlacement>() as u64);
    frame.clear("bounds/clear", &[(bounds, 0)]);
    let Dispatch::Groups([groups, ..]) = threads(frame.shape.light_capacity()) else { return placement };
    let reduce = shader("bounds/reduce_bounds", Dispatch::groups(groups.min(MAX_GROUPS)));
    let pass = frame
        .compute("bounds/reduce_bounds", reduce)
        .bind(1, lights.positions, Access::ComputeRead)
        .bind(2, lights.fluxes, Access::ComputeRead)
        .bind(3, lights.counts, Access::ComputeRead)
        .bind(4, bounds, Access::ComputeReadWrite);
    frame.graph.add_pass(pass);
    let pass = frame
        .compute("bounds/place_grid", shader("bounds/place_grid", Dispatch::groups(1)))
        .bind(1, bounds, Access::ComputeRead)
        .bind(2, lights.counts, Access::ComputeRead)
        .bind(3, placement, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    placement
}
