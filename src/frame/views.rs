//! Frames that show an intermediate result instead of the finished picture, with only the passes it needs.

use super::{FrameOutputs, HierarchyOutputs, add_hierarchy, add_lighting, filter_shadows, trace_lights, trace_shadows};
use crate::gpu::Work;
use crate::graph::{Graph, ImageHandle};
use crate::passes::debug_view::{self, SurfaceView};
use crate::passes::gbuffer::GBuffer;
use crate::passes::tone_map::{self, ToneMapped};
use crate::passes::{Frame, FrameShape, compose, direct_light, gbuffer, inspect};
use crate::settings::View;

/// Whether a view (or the finished picture) needs the lights of the hierarchy.
#[must_use]
pub fn needs_lights(view: View) -> bool {
    !matches!(view, View::Albedo | View::Normal | View::Depth | View::Direct)
}

/// The shape without what the view does not show: reservoirs unless their lights are looked at.
fn reduced(shape: &FrameShape) -> FrameShape {
    let count_overdraw = shape.view == View::Overdraw;
    match shape.view {
        View::ShadowRatio | View::ShadowRatioFiltered | View::SelectedLevel => shape.clone(),
        _ => FrameShape { shadow_samples: 0, count_overdraw, ..shape.clone() },
    }
}

/// Values and picture of a view, and the hierarchy where it was built.
struct Shown {
    values: ImageHandle,
    picture: ToneMapped,
    hierarchy: Option<HierarchyOutputs>,
}

/// The frame of the shape's view, `None` where that is the finished picture. `Settings::validate_view` has made sure
/// that the technique has the view.
pub(super) fn build(shape: &FrameShape) -> Option<(Graph<Work>, FrameOutputs)> {
    let view = shape.view;
    let mut frame = Frame::new(reduced(shape));
    let gbuffer = gbuffer::add(&mut frame);
    let shown = match view {
        View::Final => return None,
        View::Albedo => surface(&mut frame, &gbuffer, SurfaceView::Albedo),
        View::Normal => surface(&mut frame, &gbuffer, SurfaceView::Normal),
        View::Depth => surface(&mut frame, &gbuffer, SurfaceView::Depth),
        View::Direct => direct(&mut frame, &gbuffer),
        View::Vpls => vpls(&mut frame, &gbuffer),
        View::LightCount | View::LevelWeights => light_sums(&mut frame, &gbuffer),
        View::Indirect | View::ShadowRatio | View::ShadowRatioFiltered | View::SelectedLevel | View::Overdraw => {
            lighting(&mut frame, &gbuffer)
        }
    };
    let Shown { values, picture, hierarchy } = shown;
    let seen = inspect::Seen { radiance: values, direct: None, indirect: None, lights: None };
    let inspected = frame.shape.inspect.then(|| inspect::add(&mut frame, &gbuffer, &seen));
    let ray_count = frame.ray_count;
    let outputs = FrameOutputs { radiance: values, tone_mapped: picture, ray_count, hierarchy, inspected };
    Some((frame.graph, outputs))
}

fn surface(frame: &mut Frame, gbuffer: &GBuffer, shown: SurfaceView) -> Shown {
    let values = debug_view::show_surface(frame, gbuffer, shown);
    Shown { values, picture: debug_view::colorize(frame, frame.shape.view, values), hierarchy: None }
}

fn direct(frame: &mut Frame, gbuffer: &GBuffer) -> Shown {
    let direct = direct_light::add(frame, gbuffer);
    let values = compose::add(frame, gbuffer, Some(direct), None);
    Shown { values, picture: tone_map::add(frame, values), hierarchy: None }
}

fn vpls(frame: &mut Frame, gbuffer: &GBuffer) -> Shown {
    let lights = trace_lights(frame);
    let direct = direct_light::add(frame, gbuffer);
    let values = debug_view::draw_points(frame, gbuffer, &lights);
    Shown { values, picture: debug_view::overlay_points(frame, values, direct, gbuffer.albedo), hierarchy: None }
}

fn light_sums(frame: &mut Frame, gbuffer: &GBuffer) -> Shown {
    let view = frame.shape.view;
    let hierarchy = add_hierarchy(frame);
    let HierarchyOutputs { placement, merged, .. } = &hierarchy;
    let shares = view == View::LevelWeights;
    let sums = debug_view::sum_lights(frame, gbuffer, *placement, merged, shares);
    let picture = debug_view::colorize(frame, view, if shares { sums.mix } else { sums.values });
    Shown { values: sums.values, picture, hierarchy: Some(hierarchy) }
}

/// The views that need the light volumes.
fn lighting(frame: &mut Frame, gbuffer: &GBuffer) -> Shown {
    let view = frame.shape.view;
    let mut hierarchy = add_hierarchy(frame);
    let lit = add_lighting(frame, gbuffer, &mut hierarchy);
    let values = match (view, lit.lighting.reservoirs) {
        (View::Overdraw, _) => debug_view::show_overdraw(frame, hierarchy.overdraw),
        (View::SelectedLevel, Some(reservoirs)) => debug_view::show_chosen_levels(frame, &hierarchy.merged, reservoirs),
        (View::ShadowRatio | View::ShadowRatioFiltered, Some(_)) => {
            let mut estimates = trace_shadows(frame, gbuffer, &mut hierarchy, &lit);
            if view == View::ShadowRatioFiltered {
                estimates = filter_shadows(frame, gbuffer, &lit, estimates);
            }
            debug_view::show_surface(frame, gbuffer, SurfaceView::ShadowRatio(estimates))
        }
        _ => debug_view::show_surface(frame, gbuffer, SurfaceView::Indirect(lit.composite.lighting)),
    };
    let picture = match view {
        View::Indirect => tone_map::add(frame, values),
        _ => debug_view::colorize(frame, view, values),
    };
    Shown { values, picture, hierarchy: Some(hierarchy) }
}
