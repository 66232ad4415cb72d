//! `path_trace`: the indirect light by unidirectional path tracing (Kajiya 1986), a reference for everything else.

use super::gbuffer::GBuffer;
use super::{Frame, reference};
use crate::graph::{Access, ImageHandle};

/// Adds the passes, with so many paths per pixel; gives the indirect radiance per unit albedo. Where the picture has direct
/// light, that of the environment is part of it.
pub fn add(frame: &mut Frame, gbuffer: &GBuffer, samples: u32) -> ImageHandle {
    let sum = reference::sum_image(frame);
    let work = reference::work(frame, "path_trace/trace_pixels", samples, vec![samples, frame.shape.direct.into()]);
    let pass = frame
        .compute("path_trace", work)
        .bind("depth_image", gbuffer.depth, Access::ComputeSampled)
        .bind("normals_image", gbuffer.normals, Access::ComputeSampled)
        .bind("sum_image", sum, Access::ComputeReadWrite);
    reference::add(frame, pass, sum)
}
