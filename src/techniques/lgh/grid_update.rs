//! Where the finest grid may go on from that of the frame before: when that is so, what is counted, and what its resources are.

use super::super::Count;
use super::super::many_lights::{light_fluxes, light_positions};
use crate::dump::{
    Array, COUNT, DumpContext, Entry, METRES_AND_BITS, Scalar, all_words, buffer, bytes_of, noted, u, words,
};
use crate::job::Job;
use crate::passes::lgh_shape::LghShape;
use crate::settings::{FirstLevelBuild, GridUpdate, VplSeeds};
use crate::shared::{BuiltGrid, MOMENT_WORDS, SharedStruct};
use crate::{Error, Result};

/// How the finest grid of a job's frames is made: from that of the frame before where their lights are others, but most of them the
/// same. A dump has the sums of all lights.
pub(super) fn mode(job: &Job<'_>) -> GridUpdate {
    let settings = job.settings;
    let few_change = match settings.many_lights.vpl_seeds {
        Some(VplSeeds::Fresh) => false,
        Some(VplSeeds::Rolling) => true,
        Some(VplSeeds::Held) | None => job.scene.has_moving_lighting(),
    };
    let gains = few_change && settings.render.accumulate == 1 && settings.output.dump.is_none();
    match settings.lgh.grid_update {
        GridUpdate::Auto if !gains => GridUpdate::Full,
        asked => asked,
    }
}

/// A check has nothing to compare where lights are not sorted.
pub(super) fn check(shape: &LghShape) -> Result<()> {
    if shape.grid_update != GridUpdate::Check || shape.scatter == FirstLevelBuild::Sorted {
        return Ok(());
    }
    Err(Error::Usage(
        "--grid-update check compares with lights sorted by cell, and so many share a cell here that they are not: leave it out, or \
         choose --scatter sorted"
            .to_owned(),
    ))
}

/// What was counted: lights that changed, those of them that the grid was updated by, words that differ.
fn words_of<'a>(shape: &LghShape, counters: &'a [Vec<u32>]) -> Option<&'a [u32]> {
    if shape.is_updated() { counters.get(2).map(Vec::as_slice) } else { None }
}

/// The same to tell; `counters` are those of the hierarchy.
pub(super) fn counts(shape: &LghShape, counters: &[Vec<u32>]) -> Vec<Count> {
    let Some([changed, applied, ..]) = words_of(shape, counters) else { return Vec::new() };
    vec![
        Count::new("lights_changed", "lights that changed", *changed),
        Count::new("lights_applied", "changes applied to the grid", *applied),
    ]
}

/// A sentence where an update was found to differ from a new build.
pub(super) fn fault(shape: &LghShape, counters: &[Vec<u32>]) -> Option<String> {
    let [_, _, differing, ..] = words_of(shape, counters)? else { return None };
    (*differing > 0).then(|| {
        format!(
            "--grid-update check: the finest grid updated by the changed lights differs from the one that is built anew, in {differing} \
             words of its sums"
        )
    })
}

/// Resources of the passes; a dump has them with `--grid-update check` alone.
pub(in crate::techniques) const DUMP: &[Entry] = &[
    noted(buffer(
        "change_count",
        COUNT,
        all_words,
        "With --grid-update check the lights that have changed since the last build of S1.",
    )),
    buffer(
        "changes",
        "index",
        changes,
        "The lights that have changed: which light of S0 it was and which it is, 4294967295 for none.",
    ),
    buffer("built_grid", "metres, flux", built_grid, "What S1 is built of: placement, lights, vertices."),
    noted(buffer(
        "grid_update_dispatches",
        "workgroups",
        dispatches,
        "Indirect dispatches: over the vertices of S1 where all lights are summed, over them where S1 is updated, over the changes; of the passes that list the lights, over these, over cells, over counts.",
    )),
    buffer(
        "grid_update_counts",
        COUNT,
        all_words,
        "Lights that have changed, those of them that S1 was updated by, and words of the sums that differ, of all frames; the last is unused.",
    ),
    buffer(
        "updated_moments",
        "fixed point, 40 fractional bits; metres in cells, flux over the largest",
        updated_moments,
        "The moments of S1 as the changed lights bring those of the last build up to date.",
    ),
    buffer("kept_slot_bits", "bits", all_words, "The vpl_slot_bits for the next frame to compare with."),
    buffer("kept_slot_ranks", COUNT, all_words, "The vpl_slot_ranks for the same."),
    buffer("kept_light_positions", METRES_AND_BITS, light_positions, "The light_positions for the same."),
    buffer("kept_light_fluxes", "flux", light_fluxes, "The light_fluxes for the same."),
    buffer("kept_occupancy", "bits", all_words, "The occupancy for the next frame to go on from."),
    buffer("kept_occupancy_ranks", COUNT, kept_ranks, "The occupancy_ranks for the same."),
    buffer(
        "kept_moments",
        "fixed point, 40 fractional bits; metres in cells, flux over the largest",
        kept_moments,
        "The moments of S1 for the same.",
    ),
    buffer("kept_grid", "metres, flux", built_grid, "The built_grid for the same."),
];

/// In the order of the lights, as that of the list is left to chance; none where all lights are summed anew.
fn changes(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    let count = known.words("change_count").first().copied().unwrap_or(0).min((bytes.len() / 8) as u32);
    let words = words(bytes);
    let mut pairs: Vec<[u32; 2]> = words.chunks_exact(2).take(count as usize).map(|pair| [pair[0], pair[1]]).collect();
    pairs.sort_unstable();
    Array::records(vec![u("before", &[]), u("now", &[])], &[count.into()], &bytes_of(pairs.as_flattened()))
}

fn built_grid(bytes: &[u8], _: &DumpContext<'_>) -> Array {
    Array::structs(&BuiltGrid::INFO, |_| true, 1, bytes)
}

fn dispatches(bytes: &[u8], _: &DumpContext<'_>) -> Array {
    Array::plain(Scalar::U32, &[6, 3], bytes)
}

/// Vertices of S1.
fn vertex_count(known: &DumpContext<'_>) -> u64 {
    known.words("level_table").get(3).copied().unwrap_or(0).into()
}

fn kept_moments(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    Array::plain(Scalar::I64, &[vertex_count(known), u64::from(MOMENT_WORDS) / 2], bytes)
}

/// The same; nothing where no pass wrote them.
fn updated_moments(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    let is_written = known.words("grid_update_dispatches").get(4).is_some_and(|groups| *groups > 0);
    let count = if is_written { vertex_count(known) } else { 0 };
    Array::plain(Scalar::I64, &[count, u64::from(MOMENT_WORDS) / 2], bytes)
}

/// Of all levels; one word is spare.
fn kept_ranks(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    let Some(shape) = known.shape::<LghShape>() else { return all_words(bytes, known) };
    Array::plain(Scalar::U32, &[shape.levels.total_words().into()], bytes)
}
