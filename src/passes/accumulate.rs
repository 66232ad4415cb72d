//! `accumulate`: the mean of the frames so far.

use ash::vk;

use super::{Frame, shader};
use crate::graph::{Access, ImageHandle};

/// Adds the pass; gives the mean radiance, kept after the frame.
pub fn add(frame: &mut Frame, radiance: ImageHandle) -> ImageHandle {
    let sum = frame.kept_image("accumulated_sum", vk::Format::R32G32B32A32_SFLOAT);
    let mean = frame.kept_image("accumulated_mean", vk::Format::R32G32B32A32_SFLOAT);
    let pass = frame
        .compute("accumulate", shader("accumulate/add_frame", frame.per_pixel()))
        .bind("frame_image", radiance, Access::ComputeSampled)
        .bind("sum_image", sum, Access::ComputeReadWrite)
        .bind("out_mean", mean, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    mean
}
