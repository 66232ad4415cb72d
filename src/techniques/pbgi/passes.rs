//! The passes in order.

use super::super::lgh::{self, HierarchyOutputs};
use super::super::{Added, InspectPass, TechniqueOutputs};
use crate::graph::BufferHandle;
use crate::passes::compose::Indirect;
use crate::passes::gbuffer::GBuffer;
use crate::passes::inspect::{self, InspectedLight};
use crate::passes::lgh_shape::LghShape;
use crate::passes::micro_buffers::{self, GatherTables, MicroBuffers, PlacedPoints};
use crate::passes::pbgi_shape::PbgiShape;
use crate::passes::point_bounces::{self, LitPoints};
use crate::passes::point_cut::{Hidden, PointCut};
use crate::passes::point_light::{self, LookedUp, Secondaries};
use crate::passes::point_propagation::Propagation;
use crate::passes::point_selection::PointSelection;
use crate::passes::points::Points;
use crate::passes::{Frame, cache_gather, cache_tiles, point_cut, point_propagation, point_selection, radiance_cache};
use crate::shared::POINT_LIST_NEEDED;

/// The tree, and its points that are seen.
pub(super) struct FoundPrimaries {
    pub points: Points,
    pub cut: PointCut,
    tables: GatherTables,
    irradiance: BufferHandle,
}

/// What primary points see, and what of it needs light of its own.
pub(super) struct Selected {
    pub micro_buffers: MicroBuffers,
    pub selection: PointSelection,
    primaries: PlacedPoints,
}

/// Light around primary points.
pub(super) struct FilledCaches {
    pub light: InspectedLight,
    tables: GatherTables,
    /// [`PointCounts`](crate::shared::PointCounts).
    pub counts: BufferHandle,
    /// Of the hierarchy, where points look light up in one.
    pub hierarchy_counters: Vec<BufferHandle>,
}

/// Adds the passes.
pub(super) fn add(frame: &mut Frame, shape: &PbgiShape, gbuffer: &GBuffer, lgh: Option<&LghShape>) -> Added {
    let filled = fill_caches(frame, shape, gbuffer, lgh);
    let gathered = cache_gather::add(frame, gbuffer, &filled.light.caches, &filled.light.tiles);
    let indirect = Indirect { lighting: gathered.lighting, shadows: None, has_share: false };
    let outputs = filled.outputs(gathered.counts);
    let inspect: InspectPass = Box::new(move |frame, gbuffer, inputs| {
        let inspected = inspect::add(frame, gbuffer, inputs);
        inspect::add_caches(frame, gbuffer, &filled.light, &filled.tables, inspected);
        inspected
    });
    Added { indirect: Some(indirect), outputs, inspect: Some(inspect) }
}

impl FilledCaches {
    /// What the host can read, with the counts of `cache_gather`.
    pub(super) fn outputs(&self, cache_counts: BufferHandle) -> TechniqueOutputs {
        TechniqueOutputs::new([&[self.counts, cache_counts], self.hierarchy_counters.as_slice()].concat(), ())
    }
}

/// Adds the passes that build a hierarchy for points to look light up in.
fn build_hierarchy(frame: &mut Frame, shape: &LghShape) -> Option<(LookedUp, Vec<BufferHandle>)> {
    let built = lgh::add_hierarchy(frame, shape, true);
    let HierarchyOutputs { lights, placement, grid, descent, .. } = built;
    let looked_up = LookedUp { shape: shape.clone(), lights, placement, grid, descent: descent? };
    Some((looked_up, built.outputs(shape).counters))
}

/// Adds the passes up to the primary points.
pub(super) fn find_primaries(frame: &mut Frame, shape: &PbgiShape, gbuffer: &GBuffer) -> FoundPrimaries {
    let tables = GatherTables::declare(frame, shape);
    let points = Points::declare(frame, &shape.cloud);
    let irradiance = point_propagation::declare_irradiance(frame, &points);
    let cut = point_cut::add(frame, gbuffer.depth, &points, shape.primary_capacity, Hidden::Dropped);
    FoundPrimaries { points, cut, tables, irradiance }
}

/// Adds the passes from there to the secondary points.
pub(super) fn select(frame: &mut Frame, shape: &PbgiShape, found: &FoundPrimaries) -> Selected {
    let FoundPrimaries { points, cut, tables, .. } = found;
    let primaries = micro_buffers::choose_leaves(frame, points, *cut);
    let micro_buffers = micro_buffers::add(frame, shape, points, &primaries, tables);
    let selection = point_selection::add(frame, points, cut, micro_buffers.seen_bits, shape.selection);
    Selected { micro_buffers, selection, primaries }
}

/// Adds all passes up to the caches and their tiles. With `lgh` points look the light of all bounces up in a hierarchy.
pub(super) fn fill_caches(
    frame: &mut Frame,
    shape: &PbgiShape,
    gbuffer: &GBuffer,
    lgh: Option<&LghShape>,
) -> FilledCaches {
    let (hierarchy, hierarchy_counters) = lgh.and_then(|lgh| build_hierarchy(frame, lgh)).unzip();
    let found = find_primaries(frame, shape, gbuffer);
    let Selected { micro_buffers, selection, primaries } = select(frame, shape, &found);
    let FoundPrimaries { points, cut, tables, irradiance } = found;
    let counts = cut.counts.counts;
    let unlit = match &micro_buffers.kept {
        // What points see is not kept from the frame before, and more bounces need it; a hierarchy is another in each frame.
        Some(kept) if shape.bounces == 1 && lgh.is_none() => kept.keep_light(frame, &points, counts, selection.needed),
        _ => selection.needed,
    };
    let list = point_cut::pack_keys(frame, &points, unlit, POINT_LIST_NEEDED, 2 * points.node_count(), &cut.counts);
    point_light::light_primaries(frame, &points, &primaries, &micro_buffers, &tables, hierarchy.as_ref(), irradiance);
    let kept_texels = point_bounces::declare_texels(frame, shape);
    let secondaries = Secondaries {
        list,
        primaries: &primaries,
        seen_texels: micro_buffers.seen_texels,
        kept_texels,
        hierarchy: hierarchy.as_ref(),
    };
    point_light::light_secondaries(frame, shape, &points, &secondaries, &tables, irradiance);
    let lending = kept_texels.map(|_| point_selection::fill_up(frame, &points, &cut, &selection));
    let sides = Propagation { cut: &cut, selection: &selection, seen: micro_buffers.seen_bits, lending };
    point_propagation::add(frame, &points, &sides, irradiance, "");
    let irradiance = kept_texels.map_or(irradiance, |secondary_texels| {
        let lit =
            LitPoints { primaries: &primaries, micro_buffers: &micro_buffers, secondaries: list, secondary_texels };
        point_bounces::add(frame, shape, &points, &lit, &tables, &sides, irradiance)
    });
    let caches = radiance_cache::add(frame, shape, &points, &primaries, &micro_buffers, &tables, irradiance);
    let tiles = cache_tiles::add(frame, shape, &primaries, &caches);
    let light = InspectedLight { points, micro_buffers, irradiance, caches, tiles };
    FilledCaches { light, tables, counts, hierarchy_counters: hierarchy_counters.unwrap_or_default() }
}
