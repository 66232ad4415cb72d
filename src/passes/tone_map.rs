//! `tone_map`: exposure, Reinhard, sRGB.

use ash::vk;

use super::{Frame, shader};
use crate::gpu::Dispatch;
use crate::graph::{Access, BufferHandle, ImageHandle};

/// What the pass makes.
#[derive(Clone, Copy, Debug)]
pub struct ToneMapped {
    /// 8-bit sRGB, kept after the frame.
    pub picture: ImageHandle,
    /// One float: the exposure that was used.
    pub exposure: BufferHandle,
}

/// Adds the passes.
pub fn add(frame: &mut Frame, radiance: ImageHandle) -> ToneMapped {
    let exposure = measure_exposure(frame, "exposure", radiance);
    let picture = frame.kept_image("picture", vk::Format::R8G8B8A8_UNORM);
    let map = frame
        .compute("tone_map", shader("tone_map/tone_map", frame.per_pixel()))
        .bind("radiance_image", radiance, Access::ComputeSampled)
        .bind("exposure", exposure, Access::ComputeRead)
        .bind("out_picture", picture, Access::ComputeWrite);
    frame.graph.add_pass(map);
    ToneMapped { picture, exposure }
}

/// Adds the pass that measures the exposure of an image into a buffer called `name`.
pub fn measure_exposure(frame: &mut Frame, name: &str, radiance: ImageHandle) -> BufferHandle {
    let exposure = frame.graph.persistent_buffer(name, 16);
    let work = shader("tone_map/measure_exposure", Dispatch::Groups([1, 1, 1]));
    let pass = frame
        .compute(&format!("tone_map/measure_{name}"), work)
        .bind("radiance_image", radiance, Access::ComputeSampled)
        .bind("exposure", exposure, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    exposure
}
