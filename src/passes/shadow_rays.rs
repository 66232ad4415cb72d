//! `shadow_rays`: one ray per reservoir over the BVH (section 3.3).

use ash::vk;

use super::Frame;
use super::compaction::{GridLights, Lights};
use super::descent::Descent;
use super::gbuffer::GBuffer;
use super::light_volumes::Lighting;
use super::merge::MergedLights;
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

/// What the pass reads besides the G-buffer.
#[derive(Clone, Copy, Debug)]
pub struct Inputs {
    /// The lights that reservoirs name.
    pub merged: MergedLights,
    /// The analytic lighting with the sum of f.
    pub lighting: Lighting,
    /// The reservoirs.
    pub reservoirs: BufferHandle,
    /// The lights S0 that descent leads to.
    pub lights: Lights,
    /// The grid lights.
    pub grid: GridLights,
    /// The way down; `None` jitters about the chosen light itself.
    pub descent: Option<Descent>,
}

/// Adds the pass.
pub fn add(frame: &mut Frame, gbuffer: &GBuffer, inputs: &Inputs) -> ShadowEstimates {
    let shadowed = frame.image("shadowed", FORMAT);
    let unshadowed = frame.image("unshadowed", FORMAT);
    let exact = frame.shape.reservoir == Reservoir::Exact;
    let constants = vec![u32::from(inputs.descent.is_some()), frame.shape.lobe.code(), u32::from(exact)];
    let push = vec![inputs.descent.map_or(0, |d| d.index_bits)];
    let work = ComputeWork { constants, push, ..frame.ray_shader("shadow_rays/trace_shadow_rays", frame.per_pixel()) };
    // Without descent the tables are not read, but a binding needs a buffer.
    let unused = inputs.grid.ranks;
    let pass = frame
        .compute("shadow_rays", work)
        .bind(1, gbuffer.depth, Access::ComputeSampled)
        .bind(2, gbuffer.normals, Access::ComputeSampled)
        .bind(3, inputs.lighting.image, Access::ComputeSampled)
        .bind(4, inputs.merged.lights, Access::ComputeRead)
        .bind(5, inputs.reservoirs, Access::ComputeRead)
        .bind(6, shadowed, Access::ComputeWrite)
        .bind(7, unshadowed, Access::ComputeWrite)
        .bind(8, frame.ray_count, Access::ComputeReadWrite)
        .bind(9, inputs.grid.lights, Access::ComputeRead)
        .bind(10, inputs.grid.level_table, Access::ComputeRead)
        .bind(11, inputs.descent.map_or(unused, |d| d.tables), Access::ComputeRead)
        .bind(12, inputs.descent.map_or(unused, |d| d.representatives), Access::ComputeRead)
        .bind(13, inputs.lights.positions, Access::ComputeRead)
        .bind(14, inputs.lights.fluxes, Access::ComputeRead);
    frame.graph.add_pass(pass);
    ShadowEstimates { shadowed, unshadowed }
}
