//! The passes in order.

use super::super::{Added, TechniqueOutputs};
use crate::passes::compose::Indirect;
use crate::passes::gbuffer::GBuffer;
use crate::passes::micro_buffers::{self, GatherTables};
use crate::passes::pbgi_shape::PbgiShape;
use crate::passes::point_cut::Hidden;
use crate::passes::point_light::{self, Secondaries};
use crate::passes::points::Points;
use crate::passes::{Frame, cache_gather, cache_tiles, point_cut, point_propagation, point_selection, radiance_cache};

/// Adds the passes.
pub(super) fn add(frame: &mut Frame, shape: &PbgiShape, gbuffer: &GBuffer) -> Added {
    let tables = GatherTables::declare(frame, shape);
    let points = Points::declare(frame, &shape.cloud);
    let irradiance = point_propagation::declare_irradiance(frame, &points);
    let cut = point_cut::add(frame, gbuffer.depth, &points, shape.primary_capacity, Hidden::Dropped);
    let primaries = micro_buffers::choose_leaves(frame, &points, cut);
    let micro_buffers = micro_buffers::add(frame, shape, &points, &primaries, &tables);
    let seen = micro_buffers.seen_bits;
    let most_needed = 2 * points.node_count();
    let selection = point_selection::add(frame, &points, &cut, seen, most_needed, shape.selection);
    point_light::light_primaries(frame, &points, &primaries, &micro_buffers, &tables, irradiance);
    let secondaries =
        Secondaries { selection: &selection, primaries: &primaries, seen_texels: micro_buffers.seen_texels };
    point_light::light_secondaries(frame, shape, &points, &secondaries, &tables, irradiance);
    point_propagation::add(frame, &points, &cut, &selection, seen, irradiance);
    let caches = radiance_cache::add(frame, shape, &points, &primaries, &micro_buffers, &tables, irradiance);
    let tiles = cache_tiles::add(frame, shape, &primaries, &caches);
    let gathered = cache_gather::add(frame, gbuffer, &caches, &tiles);
    let indirect = Indirect { lighting: gathered.lighting, shadows: None, has_share: false };
    let outputs = TechniqueOutputs::new(vec![cut.counts.counts, gathered.counts], ());
    Added { indirect: Some(indirect), outputs, inspect: None }
}
