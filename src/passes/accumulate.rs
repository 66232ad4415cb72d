//! `accumulate`: the mean of the frames so far.

use ash::vk;

use super::{Frame, shader};
use crate::graph::{Access, ImageHandle, ImageInfo};

/// Adds the pass; gives the mean radiance, kept after the frame.
pub fn add(frame: &mut Frame, radiance: ImageHandle) -> ImageHandle {
    let info = ImageInfo {
        format: vk::Format::R32G32B32A32_SFLOAT,
        width_px: frame.shape.width_px,
        height_px: frame.shape.height_px,
    };
    let sum = frame.graph.persistent_image("accumulated_sum", info);
    let mean = frame.graph.persistent_image("accumulated_mean", info);
    let pass = frame
        .compute("accumulate", shader("accumulate/add_frame", frame.per_pixel()))
        .bind(1, radiance, Access::ComputeSampled)
        .bind(2, sum, Access::ComputeReadWrite)
        .bind(3, mean, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    mean
}
