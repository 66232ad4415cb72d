//! `atrous`: edge-avoiding à-trous wavelet filter of the shadow estimates (Dammertz et al. 2010), steered by their noise
//! (Schied et al. 2017).

use super::gbuffer::GBuffer;
use super::shadow_rays::{FORMAT, ShadowEstimates};
use super::{Frame, shader};
use crate::gpu::ComputeWork;
use crate::graph::{Access, ImageHandle};
use crate::settings::ShadowEstimate;

/// What comes out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filtered {
    /// What the picture is made of.
    ForPicture,
    /// Both estimates, whatever the picture is made of.
    Both,
}

/// The widest step of the last iteration. The ratio of both estimates has less noise than one of them, and needs less.
fn last_step_px(estimate: ShadowEstimate) -> u32 {
    match estimate {
        ShadowEstimate::Ratio => 4,
        ShadowEstimate::Corrected | ShadowEstimate::Unbiased => 16,
    }
}

/// Adds the passes. Steps double from iteration to iteration. The first is that of `interleave`: nearer pixels have had their
/// samples put together already.
pub fn add(
    frame: &mut Frame,
    gbuffer: &GBuffer,
    interleave: u32,
    input: ShadowEstimates,
    filtered: Filtered,
) -> ShadowEstimates {
    let steps = std::iter::successors(Some(interleave), |step_px| Some(2 * step_px));
    let steps = steps.take_while(|step_px| *step_px <= last_step_px(input.estimate));
    steps.enumerate().fold(input, |estimates, (index, step_px)| {
        iteration(frame, gbuffer, estimates, index as u32 + 1, step_px, filtered)
    })
}

/// Adds iteration `number`, counted from 1.
fn iteration(
    frame: &mut Frame,
    gbuffer: &GBuffer,
    estimates: ShadowEstimates,
    number: u32,
    step_px: u32,
    filtered: Filtered,
) -> ShadowEstimates {
    let both = filtered == Filtered::Both || estimates.estimate == ShadowEstimate::Ratio;
    let label = estimates.label;
    let shadowed = frame.image(&format!("{label}shadowed_{number}"), FORMAT);
    let name = if both { "atrous/filter_shadows_both" } else { "atrous/filter_shadows" };
    let work = ComputeWork {
        constants: vec![
            ("IS_FIRST", u32::from(number == 1)),
            // What is cut is lost to the mean.
            ("CUTS", u32::from(estimates.estimate != ShadowEstimate::Unbiased)),
            ("HAS_DEVIATIONS", u32::from(estimates.has_deviations)),
        ],
        push: vec![step_px],
        ..shader(name, frame.per_pixel())
    };
    let mut pass = frame
        .compute(&format!("atrous/{label}{number}"), work)
        .bind("depth_image", gbuffer.depth, Access::ComputeSampled)
        .bind("normals_image", gbuffer.normals, Access::ComputeSampled)
        .bind("shadowed_image", estimates.shadowed, Access::ComputeSampled)
        .bind("unshadowed_image", estimates.unshadowed, Access::ComputeSampled)
        .bind("out_shadowed", shadowed, Access::ComputeWrite);
    let mut unshadowed: ImageHandle = estimates.unshadowed;
    if both {
        unshadowed = frame.image(&format!("{label}unshadowed_{number}"), FORMAT);
        pass = pass.bind("out_unshadowed", unshadowed, Access::ComputeWrite);
    }
    frame.graph.add_pass(pass);
    ShadowEstimates { shadowed, unshadowed, ..estimates }
}
