//! `light_gather`: tiles of pixels gather the lights within their reach through the occupied grid vertices and pick
//! shadow samples in registers. The same sums and the same picks as `light_volumes` with exact reservoirs.

use ash::vk;

use super::compaction::{GridLights, Lights};
use super::gbuffer::GBuffer;
use super::lgh_shape::LghShape;
use super::light_buckets;
use super::light_volumes::{Lighting, declare, declare_reservoirs};
use super::merge::MergedLights;
use super::rounds::Round;
use super::{Frame, shader};
use crate::gpu::{ComputeWork, Dispatch, Work};
use crate::graph::{Access, BufferHandle, Pass};
use crate::shared::{NO_LIGHT, TILE_SIZE};

/// What the pass reads besides the G-buffer.
#[derive(Clone, Copy, Debug)]
pub struct Inputs {
    /// S0.
    pub lights: Lights,
    /// Grid placement.
    pub placement: BufferHandle,
    /// Where a level has lights.
    pub grid: GridLights,
    /// The lights.
    pub merged: MergedLights,
}

/// Adds the passes. Lists of the lights by cell are left in `inputs` where they are read.
pub fn add(frame: &mut Frame, shape: &LghShape, gbuffer: &GBuffer, inputs: &mut Inputs) -> Lighting {
    if shape.first_level == 0 {
        let Inputs { lights, placement, grid, .. } = inputs;
        let buckets = grid.buckets.unwrap_or_else(|| light_buckets::add(frame, shape, lights, *placement));
        light_buckets::sort(frame, shape, &buckets);
        inputs.grid.buckets = Some(buckets);
    }
    let lighting = declare(frame, shape, vk::Format::R32G32B32A32_SFLOAT);
    let variant = if lighting.reservoirs.is_some() { "" } else { "_none" };
    let mut work = work(shape, variant);
    work.constants.push(("COUNT_LIGHTS_TESTED", u32::from(shape.count_lights_tested)));
    let mut pass = gather(frame, shape, "light_gather", work, gbuffer, inputs)
        .bind("out_lighting", lighting.image, Access::ComputeWrite)
        .bind("lights_tested", lighting.lights_tested, Access::ComputeWrite);
    if let Some(reservoirs) = lighting.reservoirs {
        pass = pass.bind("reservoirs", reservoirs, Access::ComputeWrite);
    }
    frame.graph.add_pass(pass);
    lighting
}

/// Reservoirs for further rounds where those of the first are still read: nothing is in them yet.
pub fn add_round_reservoirs(frame: &mut Frame, shape: &LghShape) -> BufferHandle {
    let reservoirs = declare_reservoirs(frame, shape, "round_reservoirs");
    frame.clear_here("light_gather/clear", &[(reservoirs, NO_LIGHT)]);
    reservoirs
}

/// Adds the pass that picks the samples of a further round, into `reservoirs`. `inputs` are those that the first
/// round has left.
pub fn add_round(
    frame: &mut Frame,
    shape: &LghShape,
    gbuffer: &GBuffer,
    inputs: &Inputs,
    reservoirs: BufferHandle,
    round: Round,
) {
    let work = ComputeWork { push: round.push().to_vec(), dispatch: round.dispatch(), ..work(shape, "_round") };
    let pass = gather(frame, shape, &format!("light_gather/{}", round.number), work, gbuffer, inputs)
        .bind("history_shadowed", round.history, Access::ComputeSampled)
        .bind("reservoirs", reservoirs, Access::ComputeWrite);
    frame.graph.add_pass(round.listed(pass));
}

/// A pass with everything bound that it reads in every round.
fn gather(
    frame: &Frame,
    shape: &LghShape,
    name: &str,
    work: ComputeWork,
    gbuffer: &GBuffer,
    inputs: &Inputs,
) -> Pass<Work> {
    let Inputs { placement, grid, merged, .. } = inputs;
    let pass = frame
        .compute(name, work)
        .bind("light_texels", merged.texels, Access::ComputeSampled)
        .bind("sub_images", merged.sub_images, Access::ComputeRead)
        .bind("grid", *placement, Access::ComputeRead)
        .bind("depth_image", gbuffer.depth, Access::ComputeSampled)
        .bind("normals_image", gbuffer.normals, Access::ComputeSampled)
        .with(|pass| grid.looked_up_by(pass));
    match grid.buckets.filter(|_| shape.first_level == 0) {
        Some(buckets) => buckets.read_by(pass),
        None => pass,
    }
}

/// One workgroup per tile of each sub-image.
fn work(shape: &LghShape, variant: &str) -> ComputeWork {
    let [width, height] = shape.sub_image_px().map(|edge| edge.div_ceil(TILE_SIZE));
    let originals = if shape.first_level == 0 { "_first_level_0" } else { "" };
    let dispatch = Dispatch::Groups([width, height, shape.interleave * shape.interleave]);
    let mut constants = vec![("LOBE", shape.lobe.code())];
    if shape.lights.shadow_samples > 0 {
        constants.push(("SAMPLES", shape.lights.shadow_samples));
    }
    ComputeWork { constants, ..shader(&format!("light_gather/shade_tiles{originals}{variant}"), dispatch) }
}
