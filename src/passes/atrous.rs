//! `atrous`: edge-avoiding à-trous wavelet filter of the shadow estimates (Dammertz et al. 2010).

use super::gbuffer::GBuffer;
use super::shadow_rays::{FORMAT, ShadowEstimates};
use super::{Frame, shader};
use crate::gpu::ComputeWork;
use crate::graph::{Access, ImageHandle};

/// Iterations; the step doubles each time.
const ITERATIONS: u32 = 3;

/// Width of the shadow's own edge stop: none in the first iteration, then halved each time.
fn ratio_sigma(iteration: u32) -> f32 {
    match iteration {
        0 => 1e6,
        _ => 0.5_f32.powi(iteration as i32 - 1),
    }
}

/// Adds the passes; `lighting` is the analytic lighting in the picture's layout.
pub fn add(frame: &mut Frame, gbuffer: &GBuffer, lighting: ImageHandle, input: ShadowEstimates) -> ShadowEstimates {
    let mut estimates = input;
    for iteration in 0..ITERATIONS {
        let shadowed = frame.image(&format!("shadowed_{}", iteration + 1), FORMAT);
        let unshadowed = frame.image(&format!("unshadowed_{}", iteration + 1), FORMAT);
        let work = ComputeWork {
            push: vec![1 << iteration, ratio_sigma(iteration).to_bits()],
            ..shader("atrous/filter_shadows", frame.per_pixel())
        };
        let pass = frame
            .compute(&format!("atrous/{}", iteration + 1), work)
            .bind("depth_image", gbuffer.depth, Access::ComputeSampled)
            .bind("normals_image", gbuffer.normals, Access::ComputeSampled)
            .bind("lighting_image", lighting, Access::ComputeSampled)
            .bind("shadowed_image", estimates.shadowed, Access::ComputeSampled)
            .bind("unshadowed_image", estimates.unshadowed, Access::ComputeSampled)
            .bind("out_shadowed", shadowed, Access::ComputeWrite)
            .bind("out_unshadowed", unshadowed, Access::ComputeWrite);
        frame.graph.add_pass(pass);
        estimates = ShadowEstimates { shadowed, unshadowed };
    }
    estimates
}
