//! `compose`: final composition in linear radiance; the shadow ratio multiplies the analytic lighting
//! (Heitz et al. 2018).

use ash::vk;

use super::gbuffer::GBuffer;
use super::shadow_rays::ShadowEstimates;
use super::{Frame, shader};
use crate::gpu::ComputeWork;
use crate::graph::{Access, ImageHandle, ImageInfo};

/// The indirect part of the picture.
#[derive(Clone, Copy, Debug)]
pub struct Indirect {
    /// Radiance per unit albedo, unshadowed, in the picture's layout.
    pub lighting: ImageHandle,
    /// Shadow estimates; `None` without shadow samples.
    pub shadows: Option<ShadowEstimates>,
}

/// Adds the pass; gives the linear radiance, kept after the frame.
pub fn add(frame: &mut Frame, gbuffer: &GBuffer, direct: ImageHandle, indirect: Option<Indirect>) -> ImageHandle {
    let info = ImageInfo {
        format: vk::Format::R32G32B32A32_SFLOAT,
        width_px: frame.shape.width_px,
        height_px: frame.shape.height_px,
    };
    let radiance = frame.graph.persistent_image("radiance", info);
    let shadows = indirect.and_then(|i| i.shadows);
    // Bindings that a variant does not read still need an image of the right kind.
    let lighting = indirect.map_or(direct, |i| i.lighting);
    let work = ComputeWork {
        constants: vec![u32::from(indirect.is_some()), u32::from(shadows.is_some())],
        ..shader("compose/compose", frame.per_pixel())
    };
    let pass = frame
        .compute("compose", work)
        .bind(1, direct, Access::ComputeSampled)
        .bind(2, gbuffer.albedo, Access::ComputeSampled)
        .bind(3, lighting, Access::ComputeSampled)
        .bind(4, shadows.map_or(direct, |s| s.shadowed), Access::ComputeSampled)
        .bind(5, shadows.map_or(direct, |s| s.unshadowed), Access::ComputeSampled)
        .bind(6, radiance, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    radiance
}
