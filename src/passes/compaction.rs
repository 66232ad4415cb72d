//! `compaction`: packs VPLs into S0, marks occupied grid vertices and gives each its place among the grid
//! lights. Counts stay on the GPU.

use super::exclusive_scan::{self, ScanRange};
use super::lgh_shape::LghShape;
use super::light_buckets::LightBuckets;
use super::light_shape::{LightShape, PathPart};
use super::vpl_trace::VplSlots;
use super::{Frame, shader, threads};
use crate::gpu::{ComputeWork, Dispatch, Work};
use crate::graph::{Access, BufferHandle, Pass};
use crate::shared::{GridLight, MAX_LEVEL};

/// The lights S0.
#[derive(Clone, Copy, Debug)]
pub struct Lights {
    /// Position and octahedral normal.
    pub positions: BufferHandle,
    /// Flux; 1 for VPLs, 0 for lights that shine in all directions.
    pub fluxes: BufferHandle,
    /// `[0]` lights, `[1]` VPLs among them, `[2]` VPLs that did not fit.
    pub counts: BufferHandle,
    /// The slots that they are from, where that is known.
    pub slots: Option<LightSlots>,
}

/// Which slots of the light paths the lights S0 are from.
#[derive(Clone, Copy, Debug)]
pub struct LightSlots {
    /// One bit per slot: whether it holds a VPL.
    pub bits: BufferHandle,
    /// For each word of them the set bits before it.
    pub ranks: BufferHandle,
    /// Slots.
    pub count: u32,
}

/// The grid lights and what leads to them.
#[derive(Clone, Copy, Debug)]
pub struct GridLights {
    /// All levels, one after the other.
    pub lights: BufferHandle,
    /// One bit per vertex of every level.
    pub occupancy: BufferHandle,
    /// Set bits before each word.
    pub ranks: BufferHandle,
    /// First light and count of each level, then the number that did not fit.
    pub level_table: BufferHandle,
    /// Indirect dispatches over levels; see [`over_level`] and [`per_light`].
    pub dispatches: BufferHandle,
    /// The lights S0 by cell of S1, where they have been listed.
    pub buckets: Option<LightBuckets>,
    /// What was counted where S1 may have been updated ([`super::grid_update`]).
    pub update_counts: Option<BufferHandle>,
}

impl LightSlots {
    /// Slots that the caller writes.
    pub fn given(frame: &mut Frame, count: u32) -> Self {
        let words = u64::from(count.div_ceil(32));
        Self {
            bits: frame.graph.persistent_buffer("vpl_slot_bits", 4 * words),
            ranks: frame.graph.persistent_buffer("vpl_slot_ranks", 4 * (words + 1)),
            count,
        }
    }
}

impl Lights {
    /// A compute pass that reads where the lights are and what they send out.
    pub fn read_by(&self, pass: Pass<Work>) -> Pass<Work> {
        pass.bind("light_positions", self.positions, Access::ComputeRead).bind(
            "light_fluxes",
            self.fluxes,
            Access::ComputeRead,
        )
    }
}

impl GridLights {
    /// A compute pass that finds the lights of vertices.
    pub fn looked_up_by(&self, pass: Pass<Work>) -> Pass<Work> {
        pass.bind("occupancy", self.occupancy, Access::ComputeRead).bind("ranks", self.ranks, Access::ComputeRead).bind(
            "level_table",
            self.level_table,
            Access::ComputeRead,
        )
    }
}

/// Declares the buffers of the lights S0.
pub fn declare_lights(frame: &mut Frame, shape: &LightShape) -> Lights {
    let capacity = u64::from(shape.light_capacity());
    Lights {
        positions: frame.graph.persistent_buffer("light_positions", 16 * capacity),
        fluxes: frame.graph.persistent_buffer("light_fluxes", 16 * capacity),
        counts: frame.graph.persistent_buffer("light_counts", 16),
        slots: None,
    }
}

/// The lights S0 while the parts of the paths are packed.
#[derive(Clone, Copy, Debug)]
pub struct Packing {
    /// What is packed so far.
    pub lights: Lights,
    scan: ScanRange,
    block_sums: BufferHandle,
}

/// Declares what the parts of the paths are packed into.
pub fn begin_lights(frame: &mut Frame, shape: &LightShape, slots: &VplSlots) -> Packing {
    let word_count = slots.count.div_ceil(32);
    let ranks = frame.graph.transient_buffer("vpl_slot_ranks", 4 * u64::from(word_count + 1));
    let scan = ScanRange { bits: slots.bits, ranks, first_word: 0, word_count, keep_ranks: false, values: false };
    let block_sums = exclusive_scan::declare_sums(frame, "vpls", scan);
    let slots = LightSlots { bits: slots.bits, ranks, count: slots.count };
    Packing { lights: Lights { slots: Some(slots), ..declare_lights(frame, shape) }, scan, block_sums }
}

/// Adds the passes that pack the VPLs of a part of the paths, after those of the parts before; the last are followed by the
/// scene's lights.
pub fn pack_part(frame: &mut Frame, shape: &LightShape, slots: &VplSlots, packing: &Packing, part: &PathPart) {
    exclusive_scan::add_with(frame, &part.named("vpls", '_'), packing.scan, packing.block_sums);
    let scene_lights = if part.slots.end == slots.count { shape.scene_light_count } else { 0 };
    let work = ComputeWork {
        push: vec![part.slots.start, part.slots.end, slots.count],
        uses_scene: true,
        ..shader("compaction/compact_vpls", threads(part.slots.len() as u32 + scene_lights))
    };
    // What earlier parts have left there stays.
    let write = if part.slots.start == 0 { Access::ComputeWrite } else { Access::ComputeReadWrite };
    let lights = packing.lights;
    let pass = frame
        .compute(&part.named("compaction/compact_vpls", '/'), work)
        .bind("slot_positions", slots.positions, Access::ComputeRead)
        .bind("slot_fluxes", slots.fluxes, Access::ComputeRead)
        .bind("slot_bits", slots.bits, Access::ComputeRead)
        .bind("slot_ranks", packing.scan.ranks, Access::ComputeRead)
        .bind("light_positions", lights.positions, write)
        .bind("light_fluxes", lights.fluxes, write)
        .bind("light_counts", lights.counts, write);
    frame.graph.add_pass(pass);
}

/// Declares the grid lights and clears their occupancy.
pub fn begin_grid(frame: &mut Frame, shape: &LghShape) -> GridLights {
    let words = u64::from(shape.levels.total_words());
    let grid = GridLights {
        lights: frame
            .graph
            .persistent_buffer("grid_lights", size_of::<GridLight>() as u64 * u64::from(shape.grid_capacity)),
        occupancy: frame.graph.persistent_buffer("occupancy", 4 * (words + 1)),
        ranks: frame.graph.persistent_buffer("occupancy_ranks", 4 * (words + 1)),
        level_table: frame.graph.persistent_buffer("level_table", 4 * u64::from(2 * (MAX_LEVEL + 2) + 1)),
        dispatches: frame.graph.persistent_buffer("level_dispatches", 12 * u64::from(2 * MAX_LEVEL + 2)),
        buckets: None,
        update_counts: None,
    };
    frame.clear(&[(grid.occupancy, 0), (grid.level_table, 0)]);
    grid
}

/// Adds the pass that marks levels `first..=last` from the lights S0.
pub fn mark_lights(
    frame: &mut Frame,
    shape: &LghShape,
    lights: &Lights,
    placement: BufferHandle,
    grid: &GridLights,
    first: u32,
    last: u32,
) {
    let work = ComputeWork {
        push: vec![first, last],
        ..shader("compaction/mark_lights", threads(shape.lights.light_capacity()))
    };
    let pass = frame
        .compute("compaction/mark_lights", work)
        .bind("light_positions", lights.positions, Access::ComputeRead)
        .bind("grid", placement, Access::ComputeRead)
        .bind("occupancy", grid.occupancy, Access::ComputeReadWrite);
    frame.graph.add_pass(pass);
}

/// Adds the pass that marks levels 2..=Lmax from the S1 lights.
pub fn mark_grid_lights(frame: &mut Frame, grid: &GridLights) {
    let pass = frame
        .compute("compaction/mark_grid_lights", shader("compaction/mark_grid_lights", per_light(grid, 1)))
        .bind("grid_lights", grid.lights, Access::ComputeRead)
        .bind("occupancy", grid.occupancy, Access::ComputeReadWrite)
        .bind("level_table", grid.level_table, Access::ComputeRead)
        .uses(grid.dispatches, Access::IndirectRead);
    frame.graph.add_pass(pass);
}

/// Adds the passes that rank, count and list the marked vertices of levels `first..=last`.
pub fn compact_levels(frame: &mut Frame, shape: &LghShape, what: &str, grid: &GridLights, first: u32, last: u32) {
    let levels = shape.levels;
    let (first_word, end_word) = (levels.first_word(first), levels.end_word(last));
    let word_count = end_word - first_word;
    let range =
        ScanRange { bits: grid.occupancy, ranks: grid.ranks, first_word, word_count, keep_ranks: true, values: false };
    exclusive_scan::add(frame, what, range);
    let count = ComputeWork {
        push: vec![first, last, shape.grid_capacity],
        ..shader("compaction/count_lights", Dispatch::Groups([1, 1, 1]))
    };
    let pass = frame
        .compute(&format!("compaction/count_lights/{what}"), count)
        .bind("ranks", grid.ranks, Access::ComputeRead)
        .bind("level_table", grid.level_table, Access::ComputeReadWrite)
        .bind("dispatches", grid.dispatches, Access::ComputeReadWrite);
    frame.graph.add_pass(pass);
    let list = ComputeWork { push: vec![first, last], ..shader("compaction/list_vertices", threads(word_count)) };
    let pass = frame
        .compute(&format!("compaction/list_vertices/{what}"), list)
        .with(|pass| grid.looked_up_by(pass))
        .bind("grid_lights", grid.lights, Access::ComputeReadWrite);
    frame.graph.add_pass(pass);
}

/// Workgroups of `WORKGROUP_SIZE` threads over the lights of a level.
#[must_use]
pub fn over_level(grid: &GridLights, level: u32) -> Dispatch {
    indirect(grid, MAX_LEVEL + 1 + level)
}

/// For level 1 [`over_level`]; for the levels above one workgroup per light.
#[must_use]
pub fn per_light(grid: &GridLights, level: u32) -> Dispatch {
    indirect(grid, level)
}

fn indirect(grid: &GridLights, slot: u32) -> Dispatch {
    Dispatch::Indirect { buffer: grid.dispatches, offset_bytes: 12 * u64::from(slot) }
}
