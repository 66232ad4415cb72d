//! `atrous`: edge-avoiding à-trous wavelet filter of the shadow estimates (Dammertz et al. 2010).

use super::gbuffer::GBuffer;
use super::shadow_rays::{FORMAT, ShadowEstimates};
use super::{Frame, shader};
use crate::gpu::ComputeWork;
use crate::graph::{Access, ImageHandle};
use crate::settings::ShadowEstimate;

/// Iterations; the step doubles each time.
const ITERATIONS: u32 = 3;
/// Further iterations for the unshadowed estimate alone, where the picture is made of it: it has no shadow edges.
const WIDE_ITERATIONS: u32 = 2;

/// Width of the shadow's own edge stop: none in the first iteration, then halved each time.
fn ratio_sigma(iteration: u32) -> f32 {
    match iteration {
        0 => NO_EDGE_STOP,
        _ => 0.5_f32.powi(iteration as i32 - 1),
    }
}

/// A width of the edge stop that no difference of shadows reaches.
const NO_EDGE_STOP: f32 = 1e6;

/// Adds the passes; `lighting` is the analytic lighting in the picture's layout.
pub fn add(frame: &mut Frame, gbuffer: &GBuffer, lighting: ImageHandle, input: ShadowEstimates) -> ShadowEstimates {
    let mut estimates = input;
    for number in 0..ITERATIONS {
        estimates = iteration(frame, gbuffer, lighting, estimates, number, ratio_sigma(number));
    }
    let mut wide = estimates;
    if input.estimate == ShadowEstimate::Corrected {
        for number in ITERATIONS..ITERATIONS + WIDE_ITERATIONS {
            wide = iteration(frame, gbuffer, lighting, wide, number, NO_EDGE_STOP);
        }
    }
    ShadowEstimates { typical: wide.unshadowed, ..estimates }
}

/// Adds iteration `number`, counted from 0.
fn iteration(
    frame: &mut Frame,
    gbuffer: &GBuffer,
    lighting: ImageHandle,
    estimates: ShadowEstimates,
    number: u32,
    ratio_sigma: f32,
) -> ShadowEstimates {
    let shadowed = frame.image(&format!("shadowed_{}", number + 1), FORMAT);
    let unshadowed = frame.image(&format!("unshadowed_{}", number + 1), FORMAT);
    let work = ComputeWork {
        push: vec![1 << number, ratio_sigma.to_bits()],
        ..shader("atrous/filter_shadows", frame.per_pixel())
    };
    let pass = frame
        .compute(&format!("atrous/{}", number + 1), work)
        .bind("depth_image", gbuffer.depth, Access::ComputeSampled)
        .bind("normals_image", gbuffer.normals, Access::ComputeSampled)
        .bind("lighting_image", lighting, Access::ComputeSampled)
        .bind("shadowed_image", estimates.shadowed, Access::ComputeSampled)
        .bind("unshadowed_image", estimates.unshadowed, Access::ComputeSampled)
        .bind("out_shadowed", shadowed, Access::ComputeWrite)
        .bind("out_unshadowed", unshadowed, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    ShadowEstimates { shadowed, unshadowed, typical: unshadowed, ..estimates }
}
