//! `cache_tiles`: the caches that reach each tile of pixels, by counting sort.

use super::exclusive_scan::{self, ScanRange};
use super::micro_buffers::PlacedPoints;
use super::pbgi_shape::PbgiShape;
use super::radiance_cache::Caches;
use super::{Frame, shader};
use crate::graph::{Access, BufferHandle};
use crate::shared::CACHE_TILE;

/// The lists.
#[derive(Clone, Copy, Debug)]
pub struct CacheTiles {
    /// Where each tile's references start, and the end.
    pub starts: BufferHandle,
    /// Caches by tile, in any order within one.
    pub references: BufferHandle,
}

/// Tiles in a row, and rows.
#[must_use]
pub fn tile_count(frame: &Frame) -> [u32; 2] {
    [frame.shape.width_px, frame.shape.height_px].map(|edge| edge.div_ceil(CACHE_TILE))
}

/// Adds the passes.
pub fn add(frame: &mut Frame, shape: &PbgiShape, primaries: &PlacedPoints, caches: &Caches) -> CacheTiles {
    let tiles = tile_count(frame).into_iter().product::<u32>();
    let counts = frame.graph.transient_buffer("reference_counts", 4 * u64::from(tiles));
    let starts = frame.graph.transient_buffer("reference_starts", 4 * u64::from(tiles + 1));
    let references = frame.graph.transient_buffer("cache_references", 4 * u64::from(shape.reference_capacity));
    frame.clear(&[(counts, 0)]);
    let per_cache = |frame: &Frame, step: &str| {
        let name = format!("cache_tiles/{step}");
        frame
            .compute(&name, shader(&name, primaries.per_thread()))
            .with(|pass| primaries.counted_by(pass))
            .bind("cache_places", caches.places, Access::ComputeRead)
            .bind("reference_counts", counts, Access::ComputeReadWrite)
    };
    let pass = per_cache(frame, "count_references");
    frame.graph.add_pass(pass);
    let range =
        ScanRange { bits: counts, ranks: starts, first_word: 0, word_count: tiles, keep_ranks: false, values: true };
    exclusive_scan::add(frame, "cache_references", range);
    let pass = per_cache(frame, "fill_references").bind("reference_starts", starts, Access::ComputeRead).bind(
        "cache_references",
        references,
        Access::ComputeWrite,
    );
    frame.graph.add_pass(pass);
    CacheTiles { starts, references }
}
