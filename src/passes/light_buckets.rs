//! `light_buckets`: the lights S0 listed by their nearest vertex of S1, so that `light_gather` finds them by place when
//! they are the first level.

use super::compaction::{GridLights, Lights};
use super::exclusive_scan::{self, ScanRange};
use super::{Frame, shader, threads};
use crate::graph::{Access, BufferHandle};

/// The lists.
#[derive(Clone, Copy, Debug)]
pub struct LightBuckets {
    /// By rank of the S1 vertex, where its lights start.
    pub starts: BufferHandle,
    /// Lights of S0.
    pub lights: BufferHandle,
}

/// Adds the passes: a counting sort.
pub fn add(frame: &mut Frame, lights: &Lights, placement: BufferHandle, grid: &GridLights) -> LightBuckets {
    let buckets = frame.shape.grid_capacity;
    let counts = frame.graph.transient_buffer("light_bucket_counts", 4 * u64::from(buckets));
    let listed = LightBuckets {
        starts: frame.graph.transient_buffer("light_bucket_starts", 4 * u64::from(buckets + 1)),
        lights: frame.graph.transient_buffer("light_bucket_lights", 4 * u64::from(frame.shape.light_capacity())),
    };
    frame.clear("light_buckets/clear", &[(counts, 0)]);
    let per_light = |frame: &Frame, step: &str| {
        let work = shader(&format!("light_buckets/{step}"), threads(frame.shape.light_capacity()));
        frame
            .compute(&format!("light_buckets/{step}"), work)
            .bind(1, lights.positions, Access::ComputeRead)
            .bind(2, placement, Access::ComputeRead)
            .bind(3, grid.occupancy, Access::ComputeRead)
            .bind(4, grid.ranks, Access::ComputeRead)
            .bind(5, grid.level_table, Access::ComputeRead)
            .bind(6, counts, Access::ComputeReadWrite)
    };
    let pass = per_light(frame, "count_lights");
    frame.graph.add_pass(pass);
    let range = ScanRange {
        bits: counts,
        ranks: listed.starts,
        first_word: 0,
        word_count: buckets,
        keep_ranks: false,
        values: true,
    };
    exclusive_scan::add(frame, "light_buckets", range);
    let pass = per_light(frame, "list_lights").bind(7, listed.starts, Access::ComputeRead).bind(
        8,
        listed.lights,
        Access::ComputeWrite,
    );
    frame.graph.add_pass(pass);
    let pass = frame
        .compute("light_buckets/sort_bucket", shader("light_buckets/sort_bucket", threads(buckets)))
        .bind(1, grid.level_table, Access::ComputeRead)
        .bind(2, listed.starts, Access::ComputeRead)
        .bind(3, listed.lights, Access::ComputeReadWrite);
    frame.graph.add_pass(pass);
    listed
}
