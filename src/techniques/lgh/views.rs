//! Views of the hierarchy, each with only the passes that it needs.

use super::super::{AddedView, many_lights};
use super::passes::{HierarchyOutputs, add_hierarchy, add_lighting, filter_shadows, trace_shadows};
use crate::graph::ImageHandle;
use crate::passes::Frame;
use crate::passes::atrous::Filtered;
use crate::passes::debug_view::{self, SurfaceView};
use crate::passes::gbuffer::GBuffer;
use crate::passes::lgh_shape::LghShape;
use crate::passes::light_shape::LightShape;
use crate::passes::temporal::Light;
use crate::passes::tone_map::{self, ToneMapped};
use crate::settings::View;

/// Adds the passes of a view.
pub(super) fn add(frame: &mut Frame, shape: &LghShape, gbuffer: &GBuffer, view: View) -> Option<AddedView> {
    let shape = &reduced(shape, view);
    match view {
        View::Vpls => Some(many_lights::add_points(frame, &shape.lights, gbuffer)),
        View::LightCount | View::LevelWeights => Some(light_sums(frame, shape, gbuffer, view)),
        View::Indirect | View::ShadowRatio | View::ShadowRatioFiltered | View::SelectedLevel | View::LightsTested => {
            Some(lighting(frame, shape, gbuffer, view))
        }
        // Of every frame, or of another technique.
        _ => None,
    }
}

/// The shape without what the view does not show: reservoirs unless their lights are looked at.
fn reduced(shape: &LghShape, view: View) -> LghShape {
    if super::needs_shadows(view) {
        return shape.clone();
    }
    let lights = LightShape { shadow_samples: 0, ..shape.lights.clone() };
    LghShape { lights, count_lights_tested: view == View::LightsTested, ..shape.clone() }
}

fn shown(shape: &LghShape, values: ImageHandle, picture: ToneMapped, hierarchy: &HierarchyOutputs) -> AddedView {
    AddedView { values, picture, outputs: hierarchy.outputs(shape) }
}

fn light_sums(frame: &mut Frame, shape: &LghShape, gbuffer: &GBuffer, view: View) -> AddedView {
    let hierarchy = add_hierarchy(frame, shape, false);
    let HierarchyOutputs { placement, merged, .. } = &hierarchy;
    let shares = view == View::LevelWeights;
    let sums = debug_view::sum_lights(frame, shape, gbuffer, *placement, merged, shares);
    let picture = debug_view::colorize(frame, view, if shares { sums.mix } else { sums.values });
    shown(shape, sums.values, picture, &hierarchy)
}

/// The views that need the lighting of the pixels.
fn lighting(frame: &mut Frame, shape: &LghShape, gbuffer: &GBuffer, view: View) -> AddedView {
    let for_shadows = matches!(view, View::ShadowRatio | View::ShadowRatioFiltered);
    let mut hierarchy = add_hierarchy(frame, shape, for_shadows);
    let lit = add_lighting(frame, shape, gbuffer, &mut hierarchy);
    let values = match (view, lit.lighting.reservoirs) {
        (View::LightsTested, _) => debug_view::show_lights_tested(frame, lit.lighting.lights_tested),
        (View::SelectedLevel, Some(reservoirs)) => {
            debug_view::show_chosen_levels(frame, shape, &hierarchy.merged, reservoirs)
        }
        (View::ShadowRatio | View::ShadowRatioFiltered, Some(_)) => {
            let estimates = trace_shadows(frame, shape, gbuffer, &hierarchy, &lit);
            let mut light = Light { estimates, lighting: lit.composite.lighting };
            if view == View::ShadowRatioFiltered {
                light = filter_shadows(frame, shape, gbuffer, &hierarchy, &lit, estimates, Filtered::Both);
            }
            debug_view::show_surface(frame, gbuffer, SurfaceView::ShadowRatio(light.lighting, light.estimates))
        }
        _ => debug_view::show_surface(frame, gbuffer, SurfaceView::Indirect(lit.composite.lighting)),
    };
    let picture = match view {
        View::Indirect => tone_map::add(frame, gbuffer, values),
        _ => debug_view::colorize(frame, view, values),
    };
    shown(shape, values, picture, &hierarchy)
}
