//! `inspect`: everything about one pixel, for the window's inspector: surface, lights by level, shadow samples.

use super::cache_tiles::CacheTiles;
use super::compose::Indirect;
use super::direct_light::DirectLight;
use super::gbuffer::GBuffer;
use super::lgh_shape::LghShape;
use super::micro_buffers::{GatherTables, MicroBuffers};
use super::points::Points;
use super::radiance_cache::Caches;
use super::shadow_rays::{self, Samples};
use super::{Frame, shader};
use crate::gpu::{ComputeWork, Dispatch, Work};
use crate::graph::{Access, BufferHandle, ImageHandle, Pass};
use crate::shared::InspectedPixel;

/// What a frame has of a pixel.
#[derive(Clone, Copy, Debug)]
pub struct InspectorInputs {
    /// Linear radiance, or the values of a view.
    pub radiance: ImageHandle,
    /// Direct light.
    pub direct: Option<DirectLight>,
    /// Indirect light.
    pub indirect: Option<Indirect>,
}

/// What a frame has of points and of the light that they cache.
#[derive(Clone, Copy, Debug)]
pub struct InspectedLight {
    /// The points.
    pub points: Points,
    /// What primary points see.
    pub micro_buffers: MicroBuffers,
    /// Light of points.
    pub irradiance: BufferHandle,
    /// The caches.
    pub caches: Caches,
    /// The caches by tile.
    pub tiles: CacheTiles,
}

/// Adds the pass, one workgroup that looks at the pixel named in the frame's constants; gives an [`InspectedPixel`]
/// with the surface and its light.
pub fn add(frame: &mut Frame, gbuffer: &GBuffer, inputs: &InspectorInputs) -> BufferHandle {
    let estimate = inputs.indirect.and_then(|i| i.shadows).map_or(0, |s| s.estimate.code());
    let work = ComputeWork {
        push: vec![0, flags(inputs)],
        constants: vec![("ESTIMATE", estimate)],
        ..shader("inspect/inspect_pixel", Dispatch::groups(1))
    };
    let pass = frame.compute("inspect", work).bind("depth_image", gbuffer.depth, Access::ComputeSampled).bind(
        "normals_image",
        gbuffer.normals,
        Access::ComputeSampled,
    );
    finish(frame, pass, gbuffer, inputs)
}

/// The same with the lights of each level of the hierarchy and the pixel's shadow samples.
pub fn add_with_lights(
    frame: &mut Frame,
    shape: &LghShape,
    gbuffer: &GBuffer,
    inputs: &InspectorInputs,
    samples: &Samples,
) -> BufferHandle {
    let work = frame.ray_shader("inspect/inspect_pixel_lights", Dispatch::groups(1));
    let work = ComputeWork { push: vec![flags(inputs)], ..work };
    let pass = shadow_rays::sampling(frame, shape, "inspect", work, gbuffer, samples);
    finish(frame, pass, gbuffer, inputs)
}

/// Adds the pass that looks at the caches of light of the pixel, and at what one of them sees, into an [`InspectedPixel`].
pub fn add_caches(
    frame: &mut Frame,
    gbuffer: &GBuffer,
    caches: &InspectedLight,
    tables: &GatherTables,
    inspected: BufferHandle,
) {
    let pass = frame
        .compute("inspect/inspect_caches", shader("inspect/inspect_caches", Dispatch::groups(1)))
        .with(|pass| caches.micro_buffers.read_by(pass, tables))
        .bind("depth_image", gbuffer.depth, Access::ComputeSampled)
        .bind("normals_image", gbuffer.normals, Access::ComputeSampled)
        .bind("point_albedos", caches.points.albedos, Access::ComputeRead)
        .bind("point_irradiance", caches.irradiance, Access::ComputeRead)
        .bind("cache_places", caches.caches.places, Access::ComputeRead)
        .bind("reference_starts", caches.tiles.starts, Access::ComputeRead)
        .bind("cache_references", caches.tiles.references, Access::ComputeRead)
        .bind("inspected", inspected, Access::ComputeReadWrite);
    frame.graph.add_pass(pass);
}

/// Which images there are (`inspect/inspect_pixel.comp.glsl`).
fn flags(inputs: &InspectorInputs) -> u32 {
    let shadows = inputs.indirect.and_then(|i| i.shadows);
    let environment = inputs.direct.and_then(|light| light.environment);
    let there = [inputs.direct.is_some(), inputs.indirect.is_some(), shadows.is_some(), environment.is_some()];
    (0..).zip(there).map(|(bit, is_there)| u32::from(is_there) << bit).sum()
}

/// Binds what both variants read and write, and adds the pass.
fn finish(frame: &mut Frame, pass: Pass<Work>, gbuffer: &GBuffer, inputs: &InspectorInputs) -> BufferHandle {
    let inspected = frame.graph.persistent_buffer("inspected_pixel", size_of::<InspectedPixel>() as u64);
    // What is not there is black, and shadows that are not there darken nothing.
    let (lighting, shadows) = (inputs.indirect.map(|i| i.lighting), inputs.indirect.and_then(|i| i.shadows));
    let environment = inputs.direct.and_then(|light| light.environment);
    let unused = gbuffer.albedo;
    let pass = pass
        .bind("albedo_image", gbuffer.albedo, Access::ComputeSampled)
        .bind("radiance_image", inputs.radiance, Access::ComputeSampled)
        .bind("direct_image", inputs.direct.map_or(unused, |light| light.radiance), Access::ComputeSampled)
        .bind("indirect_image", lighting.unwrap_or(unused), Access::ComputeSampled)
        .bind("shadowed_image", shadows.map_or(unused, |s| s.shadowed), Access::ComputeSampled)
        .bind("unshadowed_image", shadows.map_or(unused, |s| s.unshadowed), Access::ComputeSampled)
        .bind("environment_image", environment.unwrap_or(unused), Access::ComputeSampled)
        .bind("inspected", inspected, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    inspected
}
