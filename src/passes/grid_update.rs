//! `grid_update`: S1 from the last one that was built, with the lights that have changed since taken out as they were and added as
//! they are (the future work of the paper). The sums are integers, so that they equal those of a new build to the bit; where many
//! lights have changed, or the grid stands elsewhere, there is a new build. The device decides.
//!
//! What is kept is a copy that only the last of these passes writes, so that it is whole whenever a frame ends. As no sum depends on
//! what was kept, a frame can be run again.

use std::sync::Arc;

use super::compaction::{GridLights, LightSlots, Lights};
use super::first_level::{self, Inputs};
use super::lgh_shape::LghShape;
use super::light_buckets::{self, LightBuckets};
use super::{Frame, read_dispatch, shader, threads};
use crate::gpu::{ComputeWork, Dispatch, TransferOp, Work};
use crate::graph::{Access, BufferHandle, Pass};
use crate::settings::GridUpdate;
use crate::shared::BuiltGrid;

/// S1 goes on where at most one of so many lights has changed: a light that is added by itself costs several times as much as one in
/// a sum over sorted lights.
pub const LIGHTS_PER_CHANGE: u32 = 8;

/// What is kept of the last build.
#[derive(Clone, Copy, Debug)]
struct Kept {
    slot_bits: BufferHandle,
    slot_ranks: BufferHandle,
    light_positions: BufferHandle,
    light_fluxes: BufferHandle,
    occupancy: BufferHandle,
    ranks: BufferHandle,
    moments: BufferHandle,
    grid: BufferHandle,
}

/// The lights that have changed.
#[derive(Clone, Copy, Debug)]
pub struct Changes {
    kept: Kept,
    slots: LightSlots,
    count: BufferHandle,
    lights: BufferHandle,
}

/// How S1 is to be built.
#[derive(Clone, Copy, Debug)]
pub struct Build {
    changes: Changes,
    built: BufferHandle,
    dispatches: BufferHandle,
    /// Lights that have changed, those of them that S1 was updated by, words that differ.
    pub counts: BufferHandle,
}

impl Build {
    /// Workgroups over the vertices of S1 where all lights are summed.
    const SUMS: u64 = 0;
    /// The same where it goes on.
    const GOES_ON: u64 = 1;
    /// Workgroups over the changes.
    const CHANGES: u64 = 2;
    /// Those of the passes that list the lights.
    const LISTS: [u64; 3] = [3, 4, 5];

    fn dispatch(&self, slot: u64) -> Dispatch {
        Dispatch::Indirect { buffer: self.dispatches, offset_bytes: 12 * slot }
    }

    /// The dispatches for [`light_buckets::add_where`].
    #[must_use]
    pub fn lists(&self) -> [Dispatch; 3] {
        Self::LISTS.map(|slot| self.dispatch(slot))
    }
}

/// Adds the pass that finds the changed lights.
///
/// # Panics
/// When it is not known which slots the lights are from.
pub fn find_changes(frame: &mut Frame, shape: &LghShape, lights: &Lights) -> Changes {
    let slots = lights.slots.expect("lights that were packed from slots");
    let kept = declare_kept(frame, shape, &slots);
    let changes = Changes {
        kept,
        slots,
        count: frame.graph.transient_buffer("change_count", 4),
        lights: frame.graph.transient_buffer("changes", 8 * u64::from(most_changes(shape))),
    };
    frame.clear(&[(changes.count, 0)]);
    let slot_count = slots.count + shape.lights.scene_light_count;
    let work = ComputeWork { push: vec![slots.count], ..shader("grid_update/find_changes", threads(slot_count)) };
    let pass = frame
        .compute("grid_update/find_changes", work)
        .bind("slot_bits", slots.bits, Access::ComputeRead)
        .bind("slot_ranks", slots.ranks, Access::ComputeRead)
        .with(|pass| lights.read_by(pass))
        .bind("light_counts", lights.counts, Access::ComputeRead)
        .bind("kept_slot_bits", kept.slot_bits, Access::ComputeRead)
        .bind("kept_slot_ranks", kept.slot_ranks, Access::ComputeRead)
        .with(|pass| kept.lights_read_by(pass))
        .bind("kept_grid", kept.grid, Access::ComputeRead)
        .bind("change_count", changes.count, Access::ComputeReadWrite)
        .bind("changes", changes.lights, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    changes
}

/// Changes that the list has room for: more than S1 is ever updated by.
fn most_changes(shape: &LghShape) -> u32 {
    shape.lights.light_capacity() / LIGHTS_PER_CHANGE + 1
}

fn declare_kept(frame: &mut Frame, shape: &LghShape, slots: &LightSlots) -> Kept {
    let capacity = u64::from(shape.lights.light_capacity());
    let slot_words = u64::from(slots.count.div_ceil(32));
    let grid_words = u64::from(shape.levels.total_words());
    let graph = &mut frame.graph;
    Kept {
        slot_bits: graph.persistent_buffer("kept_slot_bits", 4 * slot_words),
        slot_ranks: graph.persistent_buffer("kept_slot_ranks", 4 * (slot_words + 1)),
        light_positions: graph.persistent_buffer("kept_light_positions", 16 * capacity),
        light_fluxes: graph.persistent_buffer("kept_light_fluxes", 16 * capacity),
        occupancy: graph.persistent_buffer("kept_occupancy", 4 * (grid_words + 1)),
        ranks: graph.persistent_buffer("kept_occupancy_ranks", 4 * (grid_words + 1)),
        moments: graph.persistent_buffer("kept_moments", first_level::moments_bytes(shape)),
        // No vertices at first.
        grid: graph.filled_buffer("kept_grid", Arc::new([0; size_of::<BuiltGrid>()])),
    }
}

impl Kept {
    /// A compute pass that reads the lights as they were.
    fn lights_read_by(&self, pass: Pass<Work>) -> Pass<Work> {
        pass.bind("kept_positions", self.light_positions, Access::ComputeRead).bind(
            "kept_fluxes",
            self.light_fluxes,
            Access::ComputeRead,
        )
    }
}

/// Adds the pass that decides between an update and a new build, once the vertices of S1 are listed.
pub fn choose_build(frame: &mut Frame, inputs: Inputs<'_>, changes: Changes) -> Build {
    let Inputs { shape, lights, placement, grid } = inputs;
    let build = Build {
        changes,
        built: frame.graph.transient_buffer("built_grid", size_of::<BuiltGrid>() as u64),
        dispatches: frame.graph.transient_buffer("grid_update_dispatches", 12 * 6),
        counts: frame.graph.filled_buffer("grid_update_counts", Arc::new([0; 16])),
    };
    let sums_all = shape.grid_update == GridUpdate::Check;
    // Pixels find the lights themselves by their lists.
    let lists_all = sums_all || shape.first_level == 0;
    let work = ComputeWork {
        push: [LIGHTS_PER_CHANGE, most_changes(shape), lists_all.into(), sums_all.into()]
            .into_iter()
            .chain(light_buckets::workgroups(shape))
            .collect(),
        ..shader("grid_update/choose_build", Dispatch::groups(1))
    };
    let pass = frame
        .compute("grid_update/choose_build", work)
        .bind("grid", placement, Access::ComputeRead)
        .bind("light_counts", lights.counts, Access::ComputeRead)
        .bind("ranks", grid.ranks, Access::ComputeRead)
        .bind("level_table", grid.level_table, Access::ComputeRead)
        .bind("kept_grid", changes.kept.grid, Access::ComputeRead)
        .bind("change_count", changes.count, Access::ComputeRead)
        .bind("built_grid", build.built, Access::ComputeWrite)
        .bind("dispatches", build.dispatches, Access::ComputeWrite)
        .bind("update_counts", build.counts, Access::ComputeReadWrite);
    frame.graph.add_pass(pass);
    build
}

/// Adds the passes that build S1 in the way that was chosen, and keep what the next build goes on from.
pub fn build(frame: &mut Frame, inputs: Inputs<'_>, buckets: &LightBuckets, build: &Build) {
    let Inputs { shape, lights, grid, .. } = inputs;
    let moments = first_level::declare_moments(frame, shape);
    first_level::sum(frame, inputs, buckets, moments, build.dispatch(Build::SUMS));
    let is_checked = shape.grid_update == GridUpdate::Check;
    let updated = if is_checked {
        frame.graph.transient_buffer("updated_moments", first_level::moments_bytes(shape))
    } else {
        moments
    };
    update(frame, inputs, build, updated);
    if is_checked {
        compare(frame, grid, build, moments, updated);
    }
    first_level::resolve(frame, inputs, moments, 1);
    keep(frame, lights, grid, build, moments);
}

/// Adds the passes that bring the sums of the last build up to date.
fn update(frame: &mut Frame, inputs: Inputs<'_>, build: &Build, moments: BufferHandle) {
    let Inputs { shape, lights, placement, grid } = inputs;
    let Build { changes: Changes { kept, count, lights: changes, .. }, .. } = *build;
    let work = shader("grid_update/move_moments", build.dispatch(Build::GOES_ON));
    let pass = frame
        .compute("grid_update/move_moments", work)
        .bind("grid_lights", grid.lights, Access::ComputeRead)
        .bind("level_table", grid.level_table, Access::ComputeRead)
        .bind("kept_occupancy", kept.occupancy, Access::ComputeRead)
        .bind("kept_ranks", kept.ranks, Access::ComputeRead)
        .bind("kept_moments", kept.moments, Access::ComputeRead)
        .bind("moments", moments, Access::ComputeWrite)
        .with(read_dispatch);
    frame.graph.add_pass(pass);
    let work = ComputeWork {
        constants: vec![shape.center_constant()],
        ..shader("grid_update/apply_changes", build.dispatch(Build::CHANGES))
    };
    let pass = frame
        .compute("grid_update/apply_changes", work)
        .with(|pass| lights.read_by(pass))
        .with(|pass| kept.lights_read_by(pass))
        .bind("change_count", count, Access::ComputeRead)
        .bind("changes", changes, Access::ComputeRead)
        .bind("grid", placement, Access::ComputeRead)
        .with(|pass| grid.looked_up_by(pass))
        .bind("moments", moments, Access::ComputeReadWrite)
        .with(read_dispatch);
    frame.graph.add_pass(pass);
}

/// Adds the pass that counts where the sums of an update differ from those of a new build.
fn compare(frame: &mut Frame, grid: &GridLights, build: &Build, moments: BufferHandle, updated: BufferHandle) {
    let work = shader("grid_update/compare_moments", build.dispatch(Build::GOES_ON));
    let pass = frame
        .compute("grid_update/compare_moments", work)
        .bind("level_table", grid.level_table, Access::ComputeRead)
        .bind("moments", moments, Access::ComputeRead)
        .bind("updated_moments", updated, Access::ComputeRead)
        .bind("update_counts", build.counts, Access::ComputeReadWrite)
        .with(read_dispatch);
    frame.graph.add_pass(pass);
}

/// Adds the pass that keeps what the next build goes on from, all of it at once.
fn keep(frame: &mut Frame, lights: &Lights, grid: &GridLights, build: &Build, moments: BufferHandle) {
    let Changes { kept, slots, .. } = build.changes;
    let copies = [
        (slots.bits, kept.slot_bits),
        (slots.ranks, kept.slot_ranks),
        (lights.positions, kept.light_positions),
        (lights.fluxes, kept.light_fluxes),
        (grid.occupancy, kept.occupancy),
        (grid.ranks, kept.ranks),
        (moments, kept.moments),
        (build.built, kept.grid),
    ];
    let ops = copies.map(|(from, to)| TransferOp::Copy { from, to, offset_bytes: 0 });
    let pass = Pass::new("grid_update/keep", Work::Transfer(ops.into()));
    let pass = copies
        .into_iter()
        .fold(pass, |pass, (from, to)| pass.uses(from, Access::TransferRead).uses(to, Access::TransferWrite));
    frame.graph.add_pass(pass);
}
