//! `direct_light`: sun, spot and point lights with one ray-traced shadow each.

use ash::vk;

use super::Frame;
use super::gbuffer::GBuffer;
use crate::graph::{Access, ImageHandle};

/// Adds the pass; gives the outgoing radiance due to direct light.
pub fn add(frame: &mut Frame, gbuffer: &GBuffer) -> ImageHandle {
    let direct = frame.image("direct", vk::Format::R32G32B32A32_SFLOAT);
    let work = frame.ray_shader("direct_light/shade_direct", frame.per_pixel());
    let pass = frame
        .compute("direct_light", work)
        .bind("depth_image", gbuffer.depth, Access::ComputeSampled)
        .bind("albedo_image", gbuffer.albedo, Access::ComputeSampled)
        .bind("normals_image", gbuffer.normals, Access::ComputeSampled)
        .bind("out_direct", direct, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    direct
}
