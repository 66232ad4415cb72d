//! `emitter_light`: direct light of surfaces that shine by themselves, by shadow rays to points drawn on them.

use super::gbuffer::GBuffer;
use super::shadow_rays::FORMAT;
use super::{AreaLightShape, Frame, area_light};
use crate::gpu::ComputeWork;
use crate::graph::{Access, ImageHandle};

/// Adds the passes; gives the radiance per unit albedo.
pub fn add(frame: &mut Frame, gbuffer: &GBuffer, shape: AreaLightShape) -> ImageHandle {
    let shadowed = frame.image("emitter_shadowed", FORMAT);
    let unshadowed = frame.image("emitter_unshadowed", FORMAT);
    let work = frame.ray_shader("emitter_light/sample_emitters", frame.per_pixel());
    let pass = frame
        .compute("emitter_light", ComputeWork { push: vec![shape.samples], ..work })
        .bind("depth_image", gbuffer.depth, Access::ComputeSampled)
        .bind("normals_image", gbuffer.normals, Access::ComputeSampled)
        .bind("out_shadowed", shadowed, Access::ComputeWrite)
        .bind("out_unshadowed", unshadowed, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    area_light::filter(frame, gbuffer, shape, area_light::estimates("emitter_", shadowed, unshadowed))
}
