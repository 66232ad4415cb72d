//! `merge`: the lights of all used levels in one list, dealt to the interleaved sub-images (section 4.1).

use super::compaction::{GridLights, Lights};
use super::{Frame, shader};
use crate::gpu::Dispatch;
use crate::graph::{Access, BufferHandle};
use crate::shared::{GridLight, MAX_LEVEL};

/// The merged list.
#[derive(Clone, Copy, Debug)]
pub struct MergedLights {
    /// The lights: per sub-image, per level.
    pub lights: BufferHandle,
    /// Where each level of each sub-image starts.
    pub tiles: BufferHandle,
    /// One indirect draw per sub-image.
    pub draws: BufferHandle,
}

/// Adds the passes.
pub fn add(frame: &mut Frame, lights: &Lights, grid: &GridLights) -> MergedLights {
    let shape = &frame.shape;
    let tile_count = shape.interleave * shape.interleave;
    let originals = if shape.first_level == 0 { shape.light_capacity() } else { 0 };
    // Levels with fewer lights than sub-images are copied to each.
    let copies = tile_count * tile_count * (MAX_LEVEL + 1);
    let capacity = u64::from(shape.grid_capacity + originals + copies);
    let merged = MergedLights {
        lights: frame.graph.persistent_buffer("merged_lights", size_of::<GridLight>() as u64 * capacity),
        tiles: frame.graph.persistent_buffer("tiles", 4 * u64::from(tile_count * (MAX_LEVEL + 2))),
        draws: frame.graph.transient_buffer("light_volume_draws", 16 * u64::from(tile_count)),
    };
    let dispatch = frame.graph.transient_buffer("merge_dispatch", 16);
    let pass = frame
        .compute("merge/deal_tiles", shader("merge/deal_tiles", Dispatch::groups(1)))
        .bind(1, grid.level_table, Access::ComputeRead)
        .bind(2, lights.counts, Access::ComputeRead)
        .bind(3, merged.tiles, Access::ComputeWrite)
        .bind(4, merged.draws, Access::ComputeWrite)
        .bind(5, dispatch, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    let indirect = Dispatch::Indirect { buffer: dispatch, offset_bytes: 0 };
    let pass = frame
        .compute("merge", shader("merge/merge_lights", indirect))
        .bind(1, grid.lights, Access::ComputeRead)
        .bind(2, grid.level_table, Access::ComputeRead)
        .bind(3, merged.tiles, Access::ComputeRead)
        .bind(4, lights.positions, Access::ComputeRead)
        .bind(5, lights.fluxes, Access::ComputeRead)
        .bind(6, lights.counts, Access::ComputeRead)
        .bind(7, merged.lights, Access::ComputeWrite)
        .uses(dispatch, Access::IndirectRead);
    frame.graph.add_pass(pass);
    merged
}
