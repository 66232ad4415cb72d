//! `tone_map`: exposure, a tone curve, sRGB.

use ash::vk;

use super::gbuffer::GBuffer;
use super::{Extent, Frame, shader};
use crate::gpu::{ComputeWork, Dispatch};
use crate::graph::{Access, BufferHandle, ImageHandle};
use crate::shared::{EXPOSURE_BINS, WORKGROUP_SIZE};

/// Most pixels that the exposure is measured from: enough for a smooth histogram, and the time has a bound.
const MOST_SAMPLES: u64 = 1 << 20;
/// Pixels that one thread counts: many, so that workgroups seldom add to the histogram.
const SAMPLES_PER_THREAD: u32 = 64;

/// What the pass makes.
#[derive(Clone, Copy, Debug)]
pub struct ToneMapped {
    /// 8-bit sRGB, kept after the frame.
    pub picture: ImageHandle,
    /// One float: the exposure that was used, or the upper end of a view's scale.
    pub exposure: BufferHandle,
    /// Which of the two it is.
    pub is_exposed: bool,
}

/// Adds the passes that expose a picture by itself.
pub fn add(frame: &mut Frame, gbuffer: &GBuffer, radiance: ImageHandle) -> ToneMapped {
    let exposure = measure_exposure(frame, "exposure", gbuffer, radiance);
    map(frame, radiance, exposure)
}

/// Adds the pass alone.
pub fn map(frame: &mut Frame, radiance: ImageHandle, exposure: BufferHandle) -> ToneMapped {
    let picture = frame.kept_image("picture", vk::Format::R8G8B8A8_UNORM);
    let map = frame
        .compute("tone_map", shader("tone_map/tone_map", frame.per_pixel()))
        .bind("radiance_image", radiance, Access::ComputeSampled)
        .bind("exposure", exposure, Access::ComputeRead)
        .bind("out_picture", picture, Access::ComputeWrite);
    frame.graph.add_pass(map);
    ToneMapped { picture, exposure, is_exposed: true }
}

/// Adds the passes that measure the exposure of an image into a buffer called `name`.
pub fn measure_exposure(frame: &mut Frame, name: &str, gbuffer: &GBuffer, radiance: ImageHandle) -> BufferHandle {
    let histogram = frame.graph.transient_buffer(&format!("{name}_histogram"), 8 * u64::from(EXPOSURE_BINS));
    frame.clear(&[(histogram, 0)]);
    let size_px = [frame.shape.width_px, frame.shape.height_px];
    let step_px = sample_step_px(size_px);
    let samples = size_px.map(|edge| edge.div_ceil(step_px)).iter().product::<u32>();
    let groups = Dispatch::groups(samples.div_ceil(WORKGROUP_SIZE * SAMPLES_PER_THREAD));
    let constants = vec![("STEP_PX", step_px)];
    let work = ComputeWork { constants, ..shader("tone_map/count_luminances", Extent::Workgroups(groups)) };
    let count = frame
        .compute(&format!("tone_map/{name}_histogram"), work)
        .bind("radiance_image", radiance, Access::ComputeSampled)
        .bind("depth_image", gbuffer.depth, Access::ComputeSampled)
        .bind("histogram", histogram, Access::ComputeReadWrite);
    frame.graph.add_pass(count);
    let exposure = frame.graph.persistent_buffer(name, 16);
    let measure = frame
        .compute(&format!("tone_map/measure_{name}"), shader("tone_map/measure_exposure", Dispatch::groups(1)))
        .bind("histogram", histogram, Access::ComputeRead)
        .bind("exposure", exposure, Access::ComputeWrite);
    frame.graph.add_pass(measure);
    exposure
}

/// Edge of the squares of pixels of which the exposure looks at one each.
#[must_use]
pub fn sample_step_px(size_px: [u32; 2]) -> u32 {
    let samples = |step: u32| size_px.map(|edge| u64::from(edge.div_ceil(step))).iter().product::<u64>();
    (1..u32::MAX).find(|step| samples(*step) <= MOST_SAMPLES).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_every_pixel_as_long_as_they_are_few() {
        for (size_px, step_px) in
            [([1, 1], 1), ([1024, 1024], 1), ([1025, 1024], 2), ([1920, 1080], 2), ([16384, 16384], 16)]
        {
            assert_eq!(sample_step_px(size_px), step_px, "{size_px:?}");
        }
        assert_eq!(sample_step_px([u32::MAX, u32::MAX]), 1 << 22);
    }
}
