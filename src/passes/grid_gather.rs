//! `grid_gather`: levels 2..=Lmax. Each vertex gathers the S1 lights around it (section 3.1), or with `--build cascade`
//! those of the level below: the same sums with a fraction of the work, but one level after the other.

use super::compaction::{GridLights, over_level, per_light};
use super::lgh_shape::LghShape;
use super::{Frame, shader};
use crate::gpu::ComputeWork;
use crate::graph::{Access, BufferHandle};
use crate::settings::LevelBuild;

/// Adds one pass per level.
pub fn add(frame: &mut Frame, shape: &LghShape, placement: BufferHandle, grid: &GridLights) {
    for level in 2..=shape.levels.top {
        let (name, dispatch) = match shape.build {
            LevelBuild::Cascade => ("grid_gather/gather_below", over_level(grid, level)),
            LevelBuild::Gather | LevelBuild::Scatter => ("grid_gather/gather_vertex", per_light(grid, level)),
        };
        let constants = vec![shape.center_constant()];
        let work = ComputeWork { push: vec![level], constants, ..shader(name, dispatch) };
        let pass = frame
            .compute(&format!("grid_gather/S{level}"), work)
            .bind("grid", placement, Access::ComputeRead)
            .with(|pass| grid.looked_up_by(pass))
            .bind("grid_lights", grid.lights, Access::ComputeReadWrite)
            .uses(grid.dispatches, Access::IndirectRead);
        frame.graph.add_pass(pass);
    }
}
