//! `light_starts`: where light paths would have to start that light what the camera sees.

use super::{Frame, threads};
use crate::gpu::ComputeWork;
use crate::graph::{Access, BufferHandle};
use crate::light_paths::{PARTS_PER_EDGE, PATHS_PER_PART};
use crate::shared::StartSample;

/// Adds the pass; gives a buffer of [`StartSample`]s, `bounces` for each path of each part of the picture. `changing_flux` is
/// the luminance of the flux of all lights while they emit most, where they change.
pub fn add(frame: &mut Frame, bounces: u32, changing_flux: Option<f32>) -> BufferHandle {
    let paths = PARTS_PER_EDGE * PARTS_PER_EDGE * PATHS_PER_PART;
    let bytes = size_of::<StartSample>() as u64 * u64::from(paths * bounces);
    let samples = frame.graph.persistent_buffer("start_samples", bytes);
    let work = ComputeWork {
        push: vec![PARTS_PER_EDGE, PATHS_PER_PART, changing_flux.unwrap_or(0.0).to_bits()],
        ..frame.ray_shader("light_starts/find_starts", threads(paths))
    };
    let pass = frame.compute("light_starts", work).bind("start_samples", samples, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    samples
}
