//! Views of the points and of the caches, each with only the passes that it needs.

use super::super::{AddedView, TechniqueOutputs};
use super::passes;
use crate::passes::cache_gather::{self, ShownCaches};
use crate::passes::gbuffer::GBuffer;
use crate::passes::lgh_shape::LghShape;
use crate::passes::pbgi_shape::PbgiShape;
use crate::passes::point_view::{self, ShownSides, Viewer};
use crate::passes::{Frame, debug_view};
use crate::settings::View;

/// Whether there is such a view.
pub(super) fn has(view: View) -> bool {
    kind(view).is_some()
}

/// What a view shows.
enum Kind {
    Primaries(Viewer),
    Secondaries(Viewer),
    Caches,
}

fn kind(view: View) -> Option<Kind> {
    match view {
        View::PrimaryPoints => Some(Kind::Primaries(Viewer::Camera)),
        View::PrimaryPointsAbove => Some(Kind::Primaries(Viewer::Above)),
        View::SecondaryPoints => Some(Kind::Secondaries(Viewer::Camera)),
        View::SecondaryPointsAbove => Some(Kind::Secondaries(Viewer::Above)),
        View::CacheCount | View::CacheWeights | View::CacheMisses => Some(Kind::Caches),
        _ => None,
    }
}

/// Adds the passes of a view.
pub(super) fn add(
    frame: &mut Frame,
    shape: &PbgiShape,
    gbuffer: &GBuffer,
    view: View,
    lgh: Option<&LghShape>,
) -> Option<AddedView> {
    match kind(view)? {
        Kind::Primaries(viewer) => {
            let found = passes::find_primaries(frame, shape, gbuffer);
            let shown = ShownSides { bits: found.cut.bits, selection: None };
            let (values, picture) = point_view::add(frame, gbuffer, &found.points, &shown, viewer);
            Some(AddedView { values, picture, outputs: TechniqueOutputs::default() })
        }
        Kind::Secondaries(viewer) => {
            let found = passes::find_primaries(frame, shape, gbuffer);
            let selected = passes::select(frame, shape, &found);
            let shown = ShownSides { bits: selected.micro_buffers.seen_bits, selection: Some(selected.selection) };
            let (values, picture) = point_view::add(frame, gbuffer, &found.points, &shown, viewer);
            Some(AddedView { values, picture, outputs: TechniqueOutputs::default() })
        }
        Kind::Caches => Some(show_caches(frame, shape, gbuffer, view, lgh)),
    }
}

fn show_caches(
    frame: &mut Frame,
    shape: &PbgiShape,
    gbuffer: &GBuffer,
    view: View,
    lgh: Option<&LghShape>,
) -> AddedView {
    let lit = passes::fill_caches(frame, shape, gbuffer, lgh);
    let shown = if view == View::CacheMisses { ShownCaches::Misses } else { ShownCaches::Count };
    let caches = cache_gather::show(frame, gbuffer, &lit.light.caches, &lit.light.tiles, shown);
    let colored = if view == View::CacheWeights { caches.mix } else { caches.values };
    let picture = debug_view::colorize(frame, view, colored);
    AddedView { values: caches.values, picture, outputs: lit.outputs(caches.counts) }
}
