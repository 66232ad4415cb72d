//! `cache_gather`: light at pixels from the caches around them (Ward et al. 1988).

use ash::vk;

use super::cache_tiles::{self, CacheTiles};
use super::gbuffer::GBuffer;
use super::radiance_cache::Caches;
use super::{Frame, shader};
use crate::gpu::{ComputeWork, Dispatch};
use crate::graph::{Access, BufferHandle, ImageHandle};
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
    let counts = frame.graph.persistent_buffer("cache_counts", size_of::<CacheCounts>() as u64);
    frame.clear(&[(counts, 0)]);
    let [x, y] = cache_tiles::tile_count(frame);
    let work = ComputeWork {
        constants: vec![("HAS_SKY", frame.shape.direct.into())],
        ..shader("cache_gather/shade_tiles", Dispatch::Groups([x, y, 1]))
    };
    let pass = frame
        .compute("cache_gather", work)
        .bind("depth_image", gbuffer.depth, Access::ComputeSampled)
        .bind("normals_image", gbuffer.normals, Access::ComputeSampled)
        .bind("cache_places", caches.places, Access::ComputeRead)
        .bind("cache_lobes", caches.lobes, Access::ComputeRead)
        .bind("reference_starts", tiles.starts, Access::ComputeRead)
        .bind("cache_references", tiles.references, Access::ComputeRead)
        .bind("cache_counts", counts, Access::ComputeReadWrite)
        .bind("out_lighting", lighting, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    Gathered { lighting, counts }
}
