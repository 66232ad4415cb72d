//! `environment_light`: direct light of the environment by shadow rays in directions drawn for each pixel.

use super::gbuffer::GBuffer;
use super::shadow_rays::{FORMAT, ShadowEstimates};
use super::{AreaLightShape, Frame, area_light};
use crate::gpu::ComputeWork;
use crate::graph::{Access, ImageHandle};

/// Adds the passes; gives the radiance per unit albedo.
pub fn add(frame: &mut Frame, gbuffer: &GBuffer, shape: AreaLightShape) -> ImageHandle {
    let estimates = trace(frame, gbuffer, shape.samples);
    area_light::filter(frame, gbuffer, shape, estimates)
}

/// Adds the pass that traces the rays; gives the estimates of each pixel by itself.
pub fn trace(frame: &mut Frame, gbuffer: &GBuffer, samples: u32) -> ShadowEstimates {
    let shadowed = frame.image("environment_shadowed", FORMAT);
    let unshadowed = frame.image("environment_unshadowed", FORMAT);
    let work = frame.ray_shader("environment_light/sample_environment", frame.per_pixel());
    let pass = frame
        .compute("environment_light", ComputeWork { push: vec![samples], ..work })
        .bind("depth_image", gbuffer.depth, Access::ComputeSampled)
        .bind("normals_image", gbuffer.normals, Access::ComputeSampled)
        .bind("out_shadowed", shadowed, Access::ComputeWrite)
        .bind("out_unshadowed", unshadowed, Access::ComputeWrite)
        .bind("ray_count", frame.ray_count, Access::ComputeReadWrite);
    frame.graph.add_pass(pass);
    area_light::estimates("environment_", shadowed, unshadowed)
}
