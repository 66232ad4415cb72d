//! `cache_gather`: light at pixels from the caches around them (Ward et al. 1988).

use ash::vk;

use super::cache_tiles::{self, CacheTiles};
use super::gbuffer::GBuffer;
use super::radiance_cache::Caches;
use super::{Frame, debug_view, shader};
use crate::gpu::{ComputeWork, Dispatch, Work};
use crate::graph::{Access, BufferHandle, ImageHandle, Pass};
use crate::shared::CacheCounts;

/// What the pass leaves.
#[derive(Clone, Copy, Debug)]
pub struct Gathered {
    /// Radiance per unit albedo.
    pub lighting: ImageHandle,
    /// [`CacheCounts`].
    pub counts: BufferHandle,
}

/// Adds the pass. Where the picture has direct light, that of the environment is part of it.
pub fn add(frame: &mut Frame, gbuffer: &GBuffer, caches: &Caches, tiles: &CacheTiles) -> Gathered {
    let lighting = frame.image("cache_lighting", vk::Format::R32G32B32A32_SFLOAT);
    let constants = vec![("HAS_SKY", frame.shape.direct.into())];
    let (pass, counts) = per_tile(frame, "cache_gather/shade_tiles", constants, gbuffer, caches, tiles);
    let pass = pass.bind("cache_lobes", caches.lobes, Access::ComputeRead).bind(
        "out_lighting",
        lighting,
        Access::ComputeWrite,
    );
    frame.graph.add_pass(pass);
    Gathered { lighting, counts }
}

/// What is shown of the caches that light a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShownCaches {
    /// How many they are.
    Count = 0,
    /// Whether it lies within their reach.
    Misses = 1,
}

/// What [`show`] makes.
#[derive(Clone, Copy, Debug)]
pub struct CacheView {
    /// How many caches, the largest share of one, and whether they reach the pixel (`CACHES_*`).
    pub values: ImageHandle,
    /// Linear colour: the caches' colours mixed by share.
    pub mix: ImageHandle,
    /// [`CacheCounts`].
    pub counts: BufferHandle,
}

/// Adds the pass that shows which caches light each pixel, in place of their light.
pub fn show(
    frame: &mut Frame,
    gbuffer: &GBuffer,
    caches: &Caches,
    tiles: &CacheTiles,
    shown: ShownCaches,
) -> CacheView {
    let values = debug_view::values_image(frame);
    let mix = frame.image("cache_mix", vk::Format::R32G32B32A32_SFLOAT);
    let constants = vec![("SHOWN", shown as u32)];
    let (pass, counts) = per_tile(frame, "cache_gather/shade_tiles_show", constants, gbuffer, caches, tiles);
    let pass = pass.bind("out_values", values, Access::ComputeWrite).bind("out_mix", mix, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    CacheView { values, mix, counts }
}

/// A pass over the tiles, and the [`CacheCounts`] that it counts in.
fn per_tile(
    frame: &mut Frame,
    name: &str,
    constants: Vec<(&'static str, u32)>,
    gbuffer: &GBuffer,
    caches: &Caches,
    tiles: &CacheTiles,
) -> (Pass<Work>, BufferHandle) {
    let counts = frame.graph.persistent_buffer("cache_counts", size_of::<CacheCounts>() as u64);
    frame.clear(&[(counts, 0)]);
    let [x, y] = cache_tiles::tile_count(frame);
    let work = ComputeWork { constants, ..shader(name, Dispatch::Groups([x, y, 1])) };
    let pass = frame
        .compute("cache_gather", work)
        .bind("depth_image", gbuffer.depth, Access::ComputeSampled)
        .bind("normals_image", gbuffer.normals, Access::ComputeSampled)
        .bind("cache_places", caches.places, Access::ComputeRead)
        .bind("reference_starts", tiles.starts, Access::ComputeRead)
        .bind("cache_references", tiles.references, Access::ComputeRead)
        .bind("cache_counts", counts, Access::ComputeReadWrite);
    (pass, counts)
}
