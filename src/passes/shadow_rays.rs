//! `shadow_rays`: one ray per reservoir over the BVH (section 3.3).

use ash::vk;

use super::gbuffer::GBuffer;
use super::light_volumes::Lighting;
use super::merge::MergedLights;
use super::{Frame, shader};
use crate::gpu::ComputeWork;
use crate::graph::{Access, BufferHandle, ImageHandle};
use crate::settings::Reservoir;

/// Shadowed and unshadowed estimate of the lighting, in the picture's layout.
#[derive(Clone, Copy, Debug)]
pub struct ShadowEstimates {
    /// S.
    pub shadowed: ImageHandle,
    /// U.
    pub unshadowed: ImageHandle,
}

/// Format of the estimates.
pub(super) const FORMAT: vk::Format = vk::Format::R16G16B16A16_SFLOAT;

/// Adds the pass.
pub fn add(
    frame: &mut Frame,
    gbuffer: &GBuffer,
    merged: &MergedLights,
    lighting: &Lighting,
    reservoirs: BufferHandle,
) -> ShadowEstimates {
    let shadowed = frame.image("shadowed", FORMAT);
    let unshadowed = frame.image("unshadowed", FORMAT);
    let name = match frame.shape.reservoir {
        Reservoir::Exact => "shadow_rays/trace_shadow_rays_exact",
        Reservoir::Race | Reservoir::Lock => "shadow_rays/trace_shadow_rays",
    };
    let work = ComputeWork { uses_scene: true, ..shader(name, frame.per_pixel()) };
    let pass = frame
        .compute("shadow_rays", work)
        .bind(1, gbuffer.depth, Access::ComputeSampled)
        .bind(2, gbuffer.normals, Access::ComputeSampled)
        .bind(3, lighting.image, Access::ComputeSampled)
        .bind(4, merged.lights, Access::ComputeRead)
        .bind(5, reservoirs, Access::ComputeRead)
        .bind(6, shadowed, Access::ComputeWrite)
        .bind(7, unshadowed, Access::ComputeWrite)
        .bind(8, frame.ray_count, Access::ComputeReadWrite);
    frame.graph.add_pass(pass);
    ShadowEstimates { shadowed, unshadowed }
}
