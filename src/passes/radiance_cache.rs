//! `radiance_cache`: what primary points see, convolved with cosine lobes about 5x5 directions.

use super::micro_buffers::{GatherTables, MicroBuffers, PlacedPoints};
use super::pbgi_shape::PbgiShape;
use super::points::Points;
use super::{Frame, shader};
use crate::graph::{Access, BufferHandle};
use crate::micro_buffers::LOBES;
use crate::shared::CachePlace;

/// Numbers of a lobe: irradiance from the environment and from surfaces.
pub const CACHE_CHANNELS: u32 = 6;

/// The caches, one for each primary point.
#[derive(Clone, Copy, Debug)]
pub struct Caches {
    /// [`CACHE_CHANNELS`] numbers for each of the lobes.
    pub lobes: BufferHandle,
    /// [`CachePlace`]s.
    pub places: BufferHandle,
}

/// Adds the pass.
pub fn add(
    frame: &mut Frame,
    shape: &PbgiShape,
    points: &Points,
    primaries: &PlacedPoints,
    micro_buffers: &MicroBuffers,
    tables: &GatherTables,
    irradiance: BufferHandle,
) -> Caches {
    let capacity = u64::from(shape.primary_capacity);
    let lobes = frame.graph.transient_buffer("cache_lobes", 4 * u64::from(CACHE_CHANNELS * LOBES) * capacity);
    let places = frame.graph.transient_buffer("cache_places", size_of::<CachePlace>() as u64 * capacity);
    let work = shader("radiance_cache/convolve_lobes", primaries.per_point());
    let pass = frame
        .compute("radiance_cache", work)
        .with(|pass| primaries.read_by(pass))
        .with(|pass| micro_buffers.read_by(pass, tables))
        .bind("point_nodes", points.nodes, Access::ComputeSampled)
        .bind("point_albedos", points.albedos, Access::ComputeRead)
        .bind("point_irradiance", irradiance, Access::ComputeRead)
        .bind("cache_lobes", lobes, Access::ComputeWrite)
        .bind("cache_places", places, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    Caches { lobes, places }
}
