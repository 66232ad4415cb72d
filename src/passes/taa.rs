//! `taa`: temporal anti-aliasing of the whole picture. Frames sample their pixels at different places ([`jitter_px`]), and the
//! pass blends each into the mean of those before, which follows what moves (Karis 2014).

use ash::vk;
use glam::Vec2;

use super::gbuffer::{GBuffer, MotionImages};
use super::{Frame, shader};
use crate::graph::{Access, BufferHandle, ImageHandle};
use crate::random::centered_r2;

/// Points of a sequence on both sides of its first one, which is a pixel's centre. Points n and -n lie on opposite sides of it, so
/// that the middle of all is close to it: the last one's 0.004 and 0.035 pixels away.
const POINTS: [i32; 8] = [0, 1, -1, 2, -2, 3, -3, 4];

/// Where a frame samples its pixels, from their centres, y down: the first after a cut there itself.
#[must_use]
pub fn jitter_px(frames_since_cut: u32) -> Vec2 {
    Vec2::from_array(centered_r2(POINTS[frames_since_cut as usize % POINTS.len()]))
}

/// Adds the pass; gives the picture in linear radiance, with the number of frames in alpha, below 0 where something moves.
/// `exposure` tells what is brighter than white.
pub fn add(
    frame: &mut Frame,
    gbuffer: &GBuffer,
    motion: MotionImages,
    radiance: ImageHandle,
    exposure: BufferHandle,
) -> ImageHandle {
    let history = frame.history_image("antialiased", vk::Format::R32G32B32A32_SFLOAT);
    let pass = frame
        .compute("taa", shader("taa/blend_frames", frame.per_pixel()))
        .bind("radiance_image", radiance, Access::ComputeSampled)
        .bind("depth_image", gbuffer.depth, Access::ComputeSampled)
        .bind("motion_image", motion.motion, Access::ComputeSampled)
        .bind("previous_antialiased", history.previous, Access::ComputeSampled)
        .bind("exposure", exposure, Access::ComputeRead)
        .bind("out_antialiased", history.current, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    history.current
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sampling_points_are_spread_evenly_about_the_centre() {
        assert_eq!([0, 8, 16].map(jitter_px), [Vec2::ZERO; 3]);
        let points: Vec<Vec2> = (0..8).map(jitter_px).collect();
        assert!(points.iter().all(|point| point.abs().max_element() <= 0.5));
        let mean = points.iter().sum::<Vec2>() / 8.0;
        assert!(mean.abs().max_element() < 0.04, "{mean}");
        let distances = points.iter().enumerate().flat_map(|(i, a)| points[..i].iter().map(move |b| a.distance(*b)));
        assert!(distances.fold(f32::INFINITY, f32::min) > 0.2);
    }
}
