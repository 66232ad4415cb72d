//! `light_gather`: tiles of pixels gather the lights within their reach through the occupied grid vertices and pick
//! shadow samples in registers. The same sums and the same picks as `light_volumes` with exact reservoirs.

use ash::vk;

use super::compaction::{GridLights, Lights};
use super::gbuffer::GBuffer;
use super::lgh_shape::LghShape;
use super::light_buckets;
use super::light_volumes::{Lighting, declare};
use super::merge::MergedLights;
use super::{Frame, shader};
use crate::gpu::{ComputeWork, Dispatch};
use crate::graph::{Access, BufferHandle};
use crate::shared::TILE_SIZE;

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

/// Adds the passes.
pub fn add(frame: &mut Frame, shape: &LghShape, gbuffer: &GBuffer, inputs: &Inputs) -> Lighting {
    let Inputs { lights, placement, grid, merged } = inputs;
    let buckets = (shape.first_level == 0).then(|| {
        let buckets = grid.buckets.unwrap_or_else(|| light_buckets::add(frame, shape, lights, *placement));
        light_buckets::sort(frame, shape, &buckets);
        buckets
    });
    let lighting = declare(frame, shape, vk::Format::R32G32B32A32_SFLOAT);
    let mut pass = frame
        .compute("light_gather", work(shape))
        .bind("light_texels", merged.texels, Access::ComputeSampled)
        .bind("sub_images", merged.sub_images, Access::ComputeRead)
        .bind("grid", *placement, Access::ComputeRead)
        .bind("depth_image", gbuffer.depth, Access::ComputeSampled)
        .bind("normals_image", gbuffer.normals, Access::ComputeSampled)
        .with(|pass| grid.looked_up_by(pass))
        .bind("out_lighting", lighting.image, Access::ComputeWrite)
        .bind("lights_tested", lighting.lights_tested, Access::ComputeWrite);
    if let Some(reservoirs) = lighting.reservoirs {
        pass = pass.bind("reservoirs", reservoirs, Access::ComputeWrite);
    }
    if let Some(buckets) = buckets {
        pass = buckets.read_by(pass);
    }
    frame.graph.add_pass(pass);
    lighting
}

/// One workgroup per tile of each sub-image.
fn work(shape: &LghShape) -> ComputeWork {
    let [width, height] = shape.sub_image_px().map(|edge| edge.div_ceil(TILE_SIZE));
    let originals = if shape.first_level == 0 { "_first_level_0" } else { "" };
    let reservoirs = if shape.lights.shadow_samples == 0 { "_none" } else { "" };
    let dispatch = Dispatch::Groups([width, height, shape.interleave * shape.interleave]);
    let mut constants =
        vec![("COUNT_LIGHTS_TESTED", u32::from(shape.count_lights_tested)), ("LOBE", shape.lobe.code())];
    if shape.lights.shadow_samples > 0 {
        constants.push(("SAMPLES", shape.lights.shadow_samples));
    }
    ComputeWork { constants, ..shader(&format!("light_gather/shade_tiles{originals}{reservoirs}"), dispatch) }
}
