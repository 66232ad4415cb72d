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
        constants: vec![
            ("HAS_INDIRECT", u32::from(indirect.is_some())),
            ("HAS_SHADOWS", u32::from(shadows.is_some())),
            ("HAS_DIRECT", u32::from(direct.is_some())),
            ("HAS_SHARE", u32::from(indirect.is_some_and(|i| i.has_share))),
            ("ESTIMATE", shadows.map_or(0, |s| s.estimate.code())),
        ],
        ..shader("compose/compose", frame.per_pixel())
    };
    let pass = frame
        .compute("compose", work)
        .bind("direct_image", direct.unwrap_or(unused), Access::ComputeSampled)
        .bind("albedo_image", gbuffer.albedo, Access::ComputeSampled)
        .bind("indirect_image", lighting, Access::ComputeSampled)
        .bind("shadowed_image", shadows.map_or(unused, |s| s.shadowed), Access::ComputeSampled)
        .bind("unshadowed_image", shadows.map_or(unused, |s| s.unshadowed), Access::ComputeSampled)
        .bind("out_radiance", radiance, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    radiance
}
