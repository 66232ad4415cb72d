//! `compose`: final composition in linear radiance; the shadow ratio multiplies the analytic lighting
//! (Heitz et al. 2018).

use ash::vk;

use super::gbuffer::GBuffer;
use super::shadow_rays::ShadowEstimates;
use super::{Frame, shader};
use crate::gpu::ComputeWork;
use crate::graph::{Access, ImageHandle};

/// The indirect part of the picture.
#[derive(Clone, Copy, Debug)]
pub struct Indirect {
    /// Radiance per unit albedo, unshadowed, in the picture's layout.
    pub lighting: ImageHandle,
    /// Shadow estimates; `None` without shadow samples.
    pub shadows: Option<ShadowEstimates>,
    /// Alpha of the lighting is the share of its samples that were taken, rather than something else.
    pub has_share: bool,
}

/// Adds the pass; gives the linear radiance, kept after the frame. Its alpha is the share of the samples taken.
pub fn add(
    frame: &mut Frame,
    gbuffer: &GBuffer,
    direct: Option<ImageHandle>,
    indirect: Option<Indirect>,
) -> ImageHandle {
    let radiance = frame.kept_image("radiance", vk::Format::R32G32B32A32_SFLOAT);
    let shadows = indirect.and_then(|i| i.shadows);
    // Bindings that a variant does not read still need an image of the right kind.
    let unused = gbuffer.albedo;
    let lighting = indirect.map_or(unused, |i| i.lighting);
    let work = ComputeWork {
        constants: [indirect.is_some(), shadows.is_some(), direct.is_some(), indirect.is_some_and(|i| i.has_share)]
            .map(u32::from)
            .to_vec(),
        ..shader("compose/compose", frame.per_pixel())
    };
    let pass = frame
        .compute("compose", work)
        .bind(1, direct.unwrap_or(unused), Access::ComputeSampled)
        .bind(2, gbuffer.albedo, Access::ComputeSampled)
        .bind(3, lighting, Access::ComputeSampled)
        .bind(4, shadows.map_or(unused, |s| s.shadowed), Access::ComputeSampled)
        .bind(5, shadows.map_or(unused, |s| s.unshadowed), Access::ComputeSampled)
        .bind(6, radiance, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    radiance
}
