//! `path_trace`: the indirect light by unidirectional path tracing (Kajiya 1986), a reference for everything else.

use super::gbuffer::GBuffer;
use super::{Frame, reference};
use crate::graph::{Access, ImageHandle};

/// Adds the passes; gives the indirect radiance per unit albedo.
pub fn add(frame: &mut Frame, gbuffer: &GBuffer) -> ImageHandle {
    let sum = reference::sum_image(frame);
    let samples = frame.shape.samples;
    let work = reference::work(frame, "path_trace/trace_pixels", samples, vec![samples]);
    let pass = frame
        .compute("path_trace", work)
        .bind(1, gbuffer.depth, Access::ComputeSampled)
        .bind(2, gbuffer.normals, Access::ComputeSampled)
        .bind(3, sum, Access::ComputeReadWrite);
    reference::add(frame, pass, sum)
}
