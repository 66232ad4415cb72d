//! `light_buckets`: the lights S0 listed by cell of S1, by counting sort. `grid_scatter` sums them into S1, and
//! `light_gather` finds them by place when they are the first level.

use super::compaction::Lights;
use super::exclusive_scan::{self, ScanRange};
use super::lgh_shape::LghShape;
use super::{Frame, read_dispatch, shader, threads};
use crate::gpu::{Dispatch, Work};
use crate::graph::{Access, BufferHandle, Pass};
use crate::shared::WORKGROUP_SIZE;

/// The lists (`common/cells.glsl`).
#[derive(Clone, Copy, Debug)]
pub struct LightBuckets {
    /// One bit per cell, where its lowest vertex has its bit in the occupancy of S1.
    pub cells: BufferHandle,
    /// Set bits before each word.
    pub ranks: BufferHandle,
    /// By rank of the cell, where its lights start.
    pub starts: BufferHandle,
    /// Lights of S0.
    pub lights: BufferHandle,
}

impl LightBuckets {
    /// A compute pass that finds the lights of cells.
    pub fn read_by(&self, pass: Pass<Work>) -> Pass<Work> {
        pass.bind("cell_bits", self.cells, Access::ComputeRead)
            .bind("cell_ranks", self.ranks, Access::ComputeRead)
            .bind("bucket_starts", self.starts, Access::ComputeRead)
            .bind("bucket_lights", self.lights, Access::ComputeRead)
    }
}

/// How many workgroups the passes have: over the lights, and of the scans over cells and over counts.
#[must_use]
pub fn workgroups(shape: &LghShape) -> [u32; 3] {
    let lights = shape.lights.light_capacity();
    let scan = exclusive_scan::block_count;
    [lights.div_ceil(WORKGROUP_SIZE), scan(shape.levels.end_word(1)), scan(lights)]
}

/// Adds the passes. Within a cell the order is left to chance: see [`sort`].
pub fn add(frame: &mut Frame, shape: &LghShape, lights: &Lights, placement: BufferHandle) -> LightBuckets {
    add_where(frame, shape, lights, placement, workgroups(shape).map(Dispatch::groups))
}

/// The same with dispatches that have these [`workgroups`], or none: then nothing is listed.
pub fn add_where(
    frame: &mut Frame,
    shape: &LghShape,
    lights: &Lights,
    placement: BufferHandle,
    [over_lights, over_cells, over_counts]: [Dispatch; 3],
) -> LightBuckets {
    let words = shape.levels.end_word(1);
    let capacity = shape.lights.light_capacity();
    let counts = frame.graph.transient_buffer("light_bucket_counts", 4 * u64::from(capacity));
    let listed = LightBuckets {
        cells: frame.graph.transient_buffer("light_bucket_cells", 4 * u64::from(words)),
        ranks: frame.graph.transient_buffer("light_bucket_ranks", 4 * u64::from(words + 1)),
        starts: frame.graph.transient_buffer("light_bucket_starts", 4 * u64::from(capacity + 1)),
        lights: frame.graph.transient_buffer("light_bucket_lights", 4 * u64::from(capacity)),
    };
    frame.clear(&[(listed.cells, 0), (counts, 0)]);
    let per_light = |frame: &Frame, step: &str| {
        let name = format!("light_buckets/{step}");
        frame
            .compute(&name, shader(&name, over_lights))
            .bind("light_positions", lights.positions, Access::ComputeRead)
            .bind("grid", placement, Access::ComputeRead)
            .with(read_dispatch)
    };
    let pass = per_light(frame, "mark_cells").bind("cell_bits", listed.cells, Access::ComputeReadWrite);
    frame.graph.add_pass(pass);
    let range = |bits, ranks, word_count| ScanRange {
        bits,
        ranks,
        first_word: 0,
        word_count,
        keep_ranks: false,
        values: false,
    };
    exclusive_scan::add_where(frame, "cells", range(listed.cells, listed.ranks, words), over_cells);
    let per_cell = |frame: &Frame, step: &str| {
        per_light(frame, step)
            .bind("cell_bits", listed.cells, Access::ComputeRead)
            .bind("cell_ranks", listed.ranks, Access::ComputeRead)
            .bind("bucket_counts", counts, Access::ComputeReadWrite)
    };
    let pass = per_cell(frame, "count_lights");
    frame.graph.add_pass(pass);
    let sums = ScanRange { values: true, ..range(counts, listed.starts, capacity) };
    exclusive_scan::add_where(frame, "light_buckets", sums, over_counts);
    let pass = per_cell(frame, "list_lights").bind("bucket_starts", listed.starts, Access::ComputeRead).bind(
        "bucket_lights",
        listed.lights,
        Access::ComputeWrite,
    );
    frame.graph.add_pass(pass);
    listed
}

/// Adds the pass that puts the lights of each cell into the order of their numbers.
pub fn sort(frame: &mut Frame, shape: &LghShape, buckets: &LightBuckets) {
    let work = shader("light_buckets/sort_bucket", threads(shape.lights.light_capacity()));
    let pass = frame
        .compute("light_buckets/sort_bucket", work)
        .bind("cell_ranks", buckets.ranks, Access::ComputeRead)
        .bind("bucket_starts", buckets.starts, Access::ComputeRead)
        .bind("bucket_lights", buckets.lights, Access::ComputeReadWrite);
    frame.graph.add_pass(pass);
}
