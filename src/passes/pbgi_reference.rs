//! `pbgi_reference`: what point-based global illumination is without its savings (Harada 2014, figure 8): every leaf lit, and
//! a micro-buffer at every pixel.

use super::gbuffer::GBuffer;
use super::micro_buffers::GatherTables;
use super::points::Points;
use super::{Frame, point_propagation, reference};
use crate::gpu::{ComputeWork, Dispatch, Repeat};
use crate::graph::{Access, BufferHandle, ImageHandle};
use crate::shared::{KEYS_PER_PART, REFERENCE_TILES, TILE_SIZE};

/// Adds the passes; gives the radiance per unit albedo. Where the picture has direct light, that of the environment is part
/// of it.
pub fn add(frame: &mut Frame, gbuffer: &GBuffer, points: &Points, tables: &GatherTables) -> ImageHandle {
    let irradiance = point_propagation::declare_irradiance(frame, points);
    light_leaves(frame, points, tables, irradiance);
    gather_pixels(frame, gbuffer, points, tables, irradiance)
}

fn light_leaves(frame: &mut Frame, points: &Points, tables: &GatherTables, irradiance: BufferHandle) {
    let parts = (2 * points.leaf_count()).div_ceil(KEYS_PER_PART);
    let work = frame.ray_shader("point_light/light_secondaries_leaves", Dispatch::groups(KEYS_PER_PART));
    let work = ComputeWork { repeat: Some(Repeat { rounds: 1, parts }), ..work };
    let pass = frame
        .compute("point_light/light_leaves", work)
        .with(|pass| tables.secondary_read_by(pass))
        .bind("point_nodes", points.nodes, Access::ComputeSampled)
        .bind("point_irradiance", irradiance, Access::ComputeReadWrite);
    frame.graph.add_pass(pass.repeated());
}

fn gather_pixels(
    frame: &mut Frame,
    gbuffer: &GBuffer,
    points: &Points,
    tables: &GatherTables,
    irradiance: BufferHandle,
) -> ImageHandle {
    let sum = reference::sum_image(frame);
    let per_part = REFERENCE_TILES * TILE_SIZE * TILE_SIZE;
    let parts = (frame.shape.width_px * frame.shape.height_px).div_ceil(per_part);
    let work = frame.ray_shader("pbgi_reference/gather_pixels", Dispatch::groups(per_part));
    let work = ComputeWork { push: vec![frame.shape.direct.into()], repeat: Some(Repeat { rounds: 1, parts }), ..work };
    let pass = frame
        .compute("pbgi_reference", work)
        .with(|pass| tables.primary_read_by(pass))
        .bind("point_nodes", points.nodes, Access::ComputeSampled)
        .with(|pass| points.hit_by(pass))
        .bind("point_albedos", points.albedos, Access::ComputeRead)
        .bind("point_irradiance", irradiance, Access::ComputeRead)
        .bind("depth_image", gbuffer.depth, Access::ComputeSampled)
        .bind("normals_image", gbuffer.normals, Access::ComputeSampled)
        .bind("sum_image", sum, Access::ComputeReadWrite);
    reference::add(frame, pass, sum)
}
