//! `shadow_rays`: one ray per reservoir over the BVH (section 3.3).

use ash::vk;

use super::Frame;
use super::compaction::{GridLights, Lights};
use super::descent::Descent;
use super::gbuffer::GBuffer;
use super::lgh_shape::LghShape;
use super::merge::MergedLights;
use super::rounds::Round;
use crate::gpu::{ComputeWork, Work};
use crate::graph::{Access, BufferHandle, ImageHandle, Pass};
use crate::settings::{Reservoir, ShadowEstimate};

/// Shadowed and unshadowed estimate of the lighting, in the picture's layout.
#[derive(Clone, Copy, Debug)]
pub struct ShadowEstimates {
    /// S; once filtered, its alpha is a standard deviation.
    pub shadowed: ImageHandle,
    /// U, in alpha what both are per unit of. Filtered only where it is needed.
    pub unshadowed: ImageHandle,
    /// What the picture is made of.
    pub estimate: ShadowEstimate,
    /// The alpha of S is a standard deviation before the filter as well, below 0 where it is not known.
    pub has_deviations: bool,
    /// Begins the names of what the filter makes of them.
    pub label: &'static str,
}

/// Format of the estimates. Dim channels of strongly coloured lights are out of the range of half floats.
pub(super) const FORMAT: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// The lights of the hierarchy and what the pixels have picked of them.
#[derive(Clone, Copy, Debug)]
pub struct Samples {
    /// The lights that reservoirs name.
    pub merged: MergedLights,
    /// The analytic lighting with the sum of f, in the interleaved layout.
    pub lighting: ImageHandle,
    /// The reservoirs; `None` without shadow samples.
    pub reservoirs: Option<BufferHandle>,
    /// The lights S0 that descent leads to.
    pub lights: Lights,
    /// Grid placement.
    pub placement: BufferHandle,
    /// The grid lights.
    pub grid: GridLights,
    /// The way down; `None` jitters about the chosen light itself.
    pub descent: Option<Descent>,
}

/// Adds the pass.
pub fn add(frame: &mut Frame, shape: &LghShape, gbuffer: &GBuffer, samples: &Samples) -> ShadowEstimates {
    let shadowed = frame.image("shadowed", FORMAT);
    let unshadowed = frame.image("unshadowed", FORMAT);
    let work = frame.ray_shader("shadow_rays/trace_shadow_rays", frame.per_pixel());
    let pass = sampling(frame, shape, "shadow_rays", work, gbuffer, samples)
        .bind("out_shadowed", shadowed, Access::ComputeWrite)
        .bind("out_unshadowed", unshadowed, Access::ComputeWrite)
        .bind("ray_count", frame.ray_count, Access::ComputeReadWrite);
    frame.graph.add_pass(pass);
    ShadowEstimates { shadowed, unshadowed, estimate: shape.shadow_estimate, has_deviations: false, label: "" }
}

/// Adds the pass that traces the rays of a further round, into the estimates of the last one. The round has representatives of
/// its own for descent.
pub fn add_round(
    frame: &mut Frame,
    shape: &LghShape,
    gbuffer: &GBuffer,
    (samples, representatives): (&Samples, Option<BufferHandle>),
    estimates: ShadowEstimates,
    round: Round,
) {
    let rays = frame.ray_shader("shadow_rays/trace_shadow_rays_round", round.dispatch());
    let work = ComputeWork { push: round.push().to_vec(), ..rays };
    let pass = sampling(frame, shape, &format!("shadow_rays/{}", round.number), work, gbuffer, samples)
        .bind("history_shadowed", round.history, Access::ComputeSampled)
        // What is not there is not read, but a binding needs a buffer.
        .bind("round_representatives", representatives.unwrap_or(samples.grid.ranks), Access::ComputeRead)
        // Written in part.
        .bind("out_shadowed", estimates.shadowed, Access::ComputeReadWrite)
        .bind("out_unshadowed", estimates.unshadowed, Access::ComputeReadWrite)
        .bind("ray_count", frame.ray_count, Access::ComputeReadWrite);
    frame.graph.add_pass(round.listed(pass));
}

/// A pass whose shader includes `shadow_rays/samples.glsl`, with everything bound that this needs.
pub(super) fn sampling(
    frame: &Frame,
    shape: &LghShape,
    name: &str,
    work: ComputeWork,
    gbuffer: &GBuffer,
    samples: &Samples,
) -> Pass<Work> {
    let Samples { merged, lights, grid, descent, .. } = samples;
    let exact = shape.reservoir == Reservoir::Exact;
    let constants = vec![
        ("DESCEND", u32::from(descent.is_some())),
        ("LOBE", shape.lobe.code()),
        ("EXACT", u32::from(exact)),
        ("ESTIMATE", shape.shadow_estimate.code()),
    ];
    let push = [&[descent.map_or(0, |d| d.index_bits)], work.push.as_slice()].concat();
    // What is not there is not read, but a binding needs a buffer.
    let unused = grid.ranks;
    frame
        .compute(name, ComputeWork { constants, push, ..work })
        .bind("depth_image", gbuffer.depth, Access::ComputeSampled)
        .bind("normals_image", gbuffer.normals, Access::ComputeSampled)
        .bind("lighting_image", samples.lighting, Access::ComputeSampled)
        .bind("merged_lights", merged.lights, Access::ComputeRead)
        .bind("reservoirs", samples.reservoirs.unwrap_or(unused), Access::ComputeRead)
        .bind("light_texels", merged.texels, Access::ComputeSampled)
        .bind("grid", samples.placement, Access::ComputeRead)
        .bind("sub_images", merged.sub_images, Access::ComputeRead)
        .bind("grid_lights", grid.lights, Access::ComputeRead)
        .with(|pass| grid.looked_up_by(pass))
        .bind("descent", descent.map_or(unused, |d| d.tables), Access::ComputeRead)
        .bind("representatives", descent.map_or(unused, |d| d.representatives), Access::ComputeRead)
        .with(|pass| lights.read_by(pass))
}
