//! `bounds`: the lights' bounding box and largest flux, and from them, or from an anchor, the placement of the grids.

use super::compaction::Lights;
use super::light_shape::LightShape;
use super::{Frame, shader, threads};
use crate::gpu::{ComputeWork, Dispatch};
use crate::graph::{Access, BufferHandle};
use crate::light_grid::anchor::GridAnchor;
use crate::shared::{GridPlacement, WORKGROUP_SIZE};

/// Threads of the reduction at most; each strides over the lights.
const MAX_THREADS: u32 = 64 * WORKGROUP_SIZE;

/// Adds the passes; gives the buffer with the [`GridPlacement`].
pub fn add(frame: &mut Frame, lights: &Lights, shape: &LightShape, anchor: Option<GridAnchor>) -> BufferHandle {
    let bounds = frame.graph.persistent_buffer("bounds", 32);
    let placement = frame.graph.persistent_buffer("grid_placement", size_of::<GridPlacement>() as u64);
    frame.clear(&[(bounds, 0)]);
    let reduce = shader("bounds/reduce_bounds", threads(shape.light_capacity().min(MAX_THREADS)));
    let pass = frame
        .compute("bounds/reduce_bounds", reduce)
        .with(|pass| lights.read_by(pass))
        .bind("light_counts", lights.counts, Access::ComputeRead)
        .bind("bounds", bounds, Access::ComputeReadWrite);
    frame.graph.add_pass(pass);
    let place = ComputeWork { push: GridAnchor::words(anchor), ..shader("bounds/place_grid", Dispatch::groups(1)) };
    let pass = frame
        .compute("bounds/place_grid", place)
        .bind("bounds", bounds, Access::ComputeRead)
        .bind("light_counts", lights.counts, Access::ComputeRead)
        .bind("grid", placement, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    placement
}
