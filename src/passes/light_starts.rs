//! `light_starts`: where light paths would have to start that light what the camera sees.

use super::{Frame, threads};
use crate::graph::{Access, BufferHandle};
use crate::shared::{START_GRID, START_PATHS, StartSample};

/// Adds the pass; gives a buffer of [`StartSample`]s, `bounces` for each path of each part of the picture.
pub fn add(frame: &mut Frame, bounces: u32) -> BufferHandle {
    let paths = START_GRID * START_GRID * START_PATHS;
    let bytes = size_of::<StartSample>() as u64 * u64::from(paths * bounces);
    let samples = frame.graph.persistent_buffer("start_samples", bytes);
    let pass = frame.compute("light_starts", frame.ray_shader("light_starts/find_starts", threads(paths))).bind(
        "start_samples",
        samples,
        Access::ComputeWrite,
    );
    frame.graph.add_pass(pass);
    samples
}
