//! The frame in order: its table of contents. What lies between the G-buffer and the picture is the technique's.

pub mod readback;

use crate::gpu::Work;
use crate::graph::{BufferHandle, Graph, ImageHandle};
use crate::passes::debug_view::{self, SurfaceView};
use crate::passes::direct_light::AreaLight;
use crate::passes::gbuffer::GBuffer;
use crate::passes::inspect::{self, InspectorInputs};
use crate::passes::tone_map::{self, ToneMapped};
use crate::passes::{Frame, accumulate, compose, direct_light, environment_light, gbuffer, taa};
use crate::settings::View;
use crate::techniques::{AddedView, Shapes, TechniqueOutputs};

/// What can be read after a frame.
#[derive(Clone, Debug)]
pub struct FrameOutputs {
    /// Linear radiance.
    pub radiance: ImageHandle,
    /// Tone-mapped picture and its exposure.
    pub tone_mapped: ToneMapped,
    /// Rays traced.
    pub ray_count: BufferHandle,
    /// What the technique has.
    pub technique: TechniqueOutputs,
    /// An [`InspectedPixel`](crate::shared::InspectedPixel), when the shape asks for it.
    pub inspected: Option<BufferHandle>,
}

/// The whole frame of a technique, or the part of it that the shape's view shows.
#[must_use]
pub fn build(shapes: &Shapes) -> (Graph<Work>, FrameOutputs) {
    let mut frame = Frame::new(shapes.frame.clone());
    let gbuffer = gbuffer::add(&mut frame);
    let outputs = match add_view(&mut frame, &gbuffer, shapes) {
        Some(shown) => finish_view(&mut frame, &gbuffer, shown),
        None => add_picture(&mut frame, &gbuffer, shapes),
    };
    frame.graph.keep_results();
    (frame.graph, outputs)
}

fn add_picture(frame: &mut Frame, gbuffer: &GBuffer, shapes: &Shapes) -> FrameOutputs {
    let added = shapes.technique.add_passes(frame, gbuffer);
    let (environment, emitters) = (shapes.technique.environment_light(), shapes.technique.emitter_light());
    let direct = frame.shape.direct.then(|| direct_light::add(frame, gbuffer, environment, emitters));
    let mut radiance = compose::add(frame, gbuffer, direct.map(|light| light.radiance), added.indirect);
    let inspected = frame.shape.inspect.then(|| {
        let inputs = InspectorInputs { radiance, direct, indirect: added.indirect };
        match added.inspect {
            Some(inspect) => inspect(frame, gbuffer, &inputs),
            None => inspect::add(frame, gbuffer, &inputs),
        }
    });
    if frame.shape.accumulate {
        radiance = accumulate::add(frame, radiance);
    }
    let exposure = tone_map::measure_exposure(frame, "exposure", gbuffer, radiance);
    if let Some(motion) = gbuffer.motion.filter(|_| frame.shape.taa) {
        radiance = taa::add(frame, gbuffer, motion, radiance, exposure);
    }
    let tone_mapped = tone_map::map(frame, radiance, exposure);
    FrameOutputs { radiance, tone_mapped, ray_count: frame.ray_count, technique: added.outputs, inspected }
}

/// Adds the passes that lead to the shape's view, `None` where that is the finished picture. `techniques::check` has
/// made sure that the technique has the view.
fn add_view(frame: &mut Frame, gbuffer: &GBuffer, shapes: &Shapes) -> Option<AddedView> {
    match shapes.frame.view {
        View::Final => None,
        View::Albedo => Some(surface(frame, gbuffer, SurfaceView::Albedo)),
        View::Normal => Some(surface(frame, gbuffer, SurfaceView::Normal)),
        View::Depth => Some(surface(frame, gbuffer, SurfaceView::Depth)),
        View::MotionVectors => gbuffer.motion.map(|images| surface(frame, gbuffer, SurfaceView::Motion(images.motion))),
        View::Direct => Some(direct(frame, gbuffer)),
        View::EnvironmentVisibility => Some(environment_visibility(frame, gbuffer)),
        view => shapes.technique.add_view(frame, gbuffer, view),
    }
}

fn finish_view(frame: &mut Frame, gbuffer: &GBuffer, shown: AddedView) -> FrameOutputs {
    let AddedView { values, picture, outputs } = shown;
    let inputs = InspectorInputs { radiance: values, direct: None, indirect: None };
    let inspected = frame.shape.inspect.then(|| inspect::add(frame, gbuffer, &inputs));
    FrameOutputs { radiance: values, tone_mapped: picture, ray_count: frame.ray_count, technique: outputs, inspected }
}

fn surface(frame: &mut Frame, gbuffer: &GBuffer, shown: SurfaceView) -> AddedView {
    let values = debug_view::show_surface(frame, gbuffer, shown);
    let picture = debug_view::colorize(frame, frame.shape.view, values);
    AddedView { values, picture, outputs: TechniqueOutputs::default() }
}

fn environment_visibility(frame: &mut Frame, gbuffer: &GBuffer) -> AddedView {
    let samples = frame.shape.environment.map_or(0, |shape| shape.samples);
    let estimates = environment_light::trace(frame, gbuffer, samples);
    surface(frame, gbuffer, SurfaceView::EnvironmentVisibility(estimates))
}

fn direct(frame: &mut Frame, gbuffer: &GBuffer) -> AddedView {
    let direct = direct_light::add(frame, gbuffer, AreaLight::Here, AreaLight::Here);
    let values = compose::add(frame, gbuffer, Some(direct.radiance), None);
    AddedView { values, picture: tone_map::add(frame, gbuffer, values), outputs: TechniqueOutputs::default() }
}
