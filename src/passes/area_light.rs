//! What becomes of the shadow estimates of something large that lights surfaces directly: the environment, or surfaces that
//! shine by themselves.

use super::gbuffer::GBuffer;
use super::shadow_rays::ShadowEstimates;
use super::{AreaLightShape, Frame, atrous, temporal};
use crate::graph::ImageHandle;
use crate::settings::ShadowEstimate;

/// Estimates that are radiance per unit albedo. `label` begins the names of what is made of them.
pub(super) fn estimates(label: &'static str, shadowed: ImageHandle, unshadowed: ImageHandle) -> ShadowEstimates {
    ShadowEstimates { shadowed, unshadowed, estimate: ShadowEstimate::Unbiased, has_deviations: false, label }
}

/// Adds the passes that take the noise out of the estimates; gives the radiance per unit albedo.
pub(super) fn filter(
    frame: &mut Frame,
    gbuffer: &GBuffer,
    shape: AreaLightShape,
    mut estimates: ShadowEstimates,
) -> ImageHandle {
    if let Some((motion, reuse)) = gbuffer.motion.zip(shape.reuse) {
        estimates = temporal::add_radiance(frame, gbuffer, motion, reuse, estimates);
    }
    if shape.is_filtered {
        estimates = atrous::add(frame, gbuffer, 1, estimates, atrous::Filtered::ForPicture);
    }
    estimates.shadowed
}
