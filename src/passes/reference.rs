//! What the reference techniques share: pixels dispatched in parts, a sum that may be stopped early, its resolve.

use ash::vk;

use super::{Frame, shader};
use crate::gpu::{ComputeWork, Dispatch, Repeat};
use crate::graph::{Access, ImageHandle, Pass};
use crate::shared::{REFERENCE_TILES, TILE_SIZE};

/// Compute work that visits every pixel in each of `rounds`; round and part follow `push`.
#[must_use]
pub fn work(frame: &Frame, name: &str, rounds: u32, push: Vec<u32>) -> ComputeWork {
    let tiles = frame.shape.width_px.div_ceil(TILE_SIZE) * frame.shape.height_px.div_ceil(TILE_SIZE);
    let repeat = Repeat { rounds: rounds.max(1), parts: tiles.div_ceil(REFERENCE_TILES) };
    ComputeWork {
        push,
        repeat: Some(repeat),
        ..frame.ray_shader(name, Dispatch::Groups([REFERENCE_TILES.min(tiles), 1, 1]))
    }
}

/// Declares the image that a technique sums radiance per unit albedo in; alpha is the share of its samples.
pub fn sum_image(frame: &mut Frame) -> ImageHandle {
    // Persistent, since the first round writes it in parts.
    frame.kept_image("reference_sum", vk::Format::R32G32B32A32_SFLOAT)
}

/// Adds the repeated pass and the pass that divides its sum; gives the radiance per unit albedo.
pub fn add(frame: &mut Frame, pass: Pass<crate::gpu::Work>, sum: ImageHandle) -> ImageHandle {
    frame.graph.add_pass(pass.repeated());
    let lighting = frame.image("reference_lighting", vk::Format::R32G32B32A32_SFLOAT);
    let resolve = frame
        .compute("reference/resolve", shader("reference/resolve_sum", frame.per_pixel()))
        .bind("sum_image", sum, Access::ComputeSampled)
        .bind("out_lighting", lighting, Access::ComputeWrite);
    frame.graph.add_pass(resolve);
    lighting
}
