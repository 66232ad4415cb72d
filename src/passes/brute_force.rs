//! `brute_force`: every light of S0 at every pixel, the reference for the hierarchy over the same lights.

use super::compaction::Lights;
use super::gbuffer::GBuffer;
use super::light_shape::LightShape;
use super::{Frame, reference};
use crate::gpu::ComputeWork;
use crate::graph::{Access, ImageHandle};

/// Lights of a round where each takes a ray.
const SHADOWED_LIGHTS_PER_ROUND: u32 = 4;
/// Lights of a round without rays.
const LIGHTS_PER_ROUND: u32 = 256;

/// Adds the passes; gives the indirect radiance per unit albedo.
pub fn add(frame: &mut Frame, gbuffer: &GBuffer, lights: &Lights, shape: &LightShape) -> ImageHandle {
    let sum = reference::sum_image(frame);
    let has_shadows = shape.shadow_samples > 0;
    let lights_per_round = if has_shadows { SHADOWED_LIGHTS_PER_ROUND } else { LIGHTS_PER_ROUND };
    let rounds = shape.light_capacity().div_ceil(lights_per_round);
    let work = reference::work(frame, "brute_force/shade_all", rounds, vec![lights_per_round]);
    let pass = frame
        .compute("brute_force", ComputeWork { constants: vec![("HAS_SHADOWS", u32::from(has_shadows))], ..work })
        .bind("depth_image", gbuffer.depth, Access::ComputeSampled)
        .bind("normals_image", gbuffer.normals, Access::ComputeSampled)
        .bind("sum_image", sum, Access::ComputeReadWrite)
        .with(|pass| lights.read_by(pass))
        .bind("light_counts", lights.counts, Access::ComputeRead);
    reference::add(frame, pass, sum)
}
