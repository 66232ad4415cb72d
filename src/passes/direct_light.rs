//! `direct_light`: sun, spot and point lights with one ray-traced shadow each, the environment, and surfaces that shine.

use ash::vk;

use super::gbuffer::GBuffer;
use super::{Frame, emitter_light, environment_light};
use crate::gpu::ComputeWork;
use crate::graph::{Access, ImageHandle};

/// Where light is computed that comes to surfaces themselves from the environment, or from surfaces that shine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AreaLight {
    /// In passes of this picture.
    Here,
    /// In the technique's own.
    InTechnique,
}

/// The light that comes straight from lamps and the environment.
#[derive(Clone, Copy, Debug)]
pub struct DirectLight {
    /// Outgoing radiance due to it, with what surfaces send out by themselves, and the environment where it is seen.
    pub radiance: ImageHandle,
    /// The environment's part of it where surfaces are, per unit albedo; `None` where these passes compute none.
    pub environment: Option<ImageHandle>,
}

/// Adds the passes.
pub fn add(frame: &mut Frame, gbuffer: &GBuffer, environment: AreaLight, emitters: AreaLight) -> DirectLight {
    let shape = frame.shape.environment.filter(|_| environment == AreaLight::Here);
    let environment = shape.map(|shape| environment_light::add(frame, gbuffer, shape));
    let shape = frame.shape.emitters.filter(|_| emitters == AreaLight::Here);
    let emitters = shape.map(|shape| emitter_light::add(frame, gbuffer, shape));
    let direct = frame.image("direct", vk::Format::R32G32B32A32_SFLOAT);
    let work = ComputeWork {
        constants: vec![
            ("HAS_ENVIRONMENT_LIGHT", environment.is_some().into()),
            ("HAS_EMITTER_LIGHT", emitters.is_some().into()),
            ("HAS_EMISSION", gbuffer.emission.is_some().into()),
        ],
        ..frame.ray_shader("direct_light/shade_direct", frame.per_pixel())
    };
    // Without light the binding still needs an image of its kind.
    let or_any = |image: Option<ImageHandle>| image.unwrap_or(gbuffer.albedo);
    let pass = frame
        .compute("direct_light", work)
        .bind("depth_image", gbuffer.depth, Access::ComputeSampled)
        .bind("albedo_image", gbuffer.albedo, Access::ComputeSampled)
        .bind("normals_image", gbuffer.normals, Access::ComputeSampled)
        .bind("environment_lighting", or_any(environment), Access::ComputeSampled)
        .bind("emitter_lighting", or_any(emitters), Access::ComputeSampled)
        .bind("emission_image", or_any(gbuffer.emission), Access::ComputeSampled)
        .bind("out_direct", direct, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    DirectLight { radiance: direct, environment }
}
