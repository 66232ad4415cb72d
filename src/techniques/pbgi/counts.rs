//! What frames of point-based global illumination count.

use super::super::Count;
use crate::passes::pbgi_shape::PbgiShape;
use crate::shared::{CacheCounts, PointCounts};

/// The counters are those of points and of caches.
fn structs(words: &[Vec<u32>]) -> Option<(PointCounts, CacheCounts)> {
    let points = bytemuck::try_pod_read_unaligned(bytemuck::cast_slice(words.first()?)).ok()?;
    let caches = bytemuck::try_pod_read_unaligned(bytemuck::cast_slice(words.get(1)?)).ok()?;
    Some((points, caches))
}

pub(super) fn counts(words: &[Vec<u32>]) -> Vec<Count> {
    let Some((points, caches)) = structs(words) else { return Vec::new() };
    vec![
        Count::new("primary_points", "primary points", points.primary_count),
        Count::new("seen_points", "points seen", points.seen_count),
        Count::new("needed_points", "secondary points lit", points.needed_count),
        Count::new("kept_primaries", "primary points as in the frame before", points.primaries_kept),
        Count::new("kept_points", "secondary points that keep their light", points.needed_kept),
        Count::new("stretched_pixels", "pixels without a cache in reach", caches.stretched_pixels),
        Count::new("nearest_pixels", "pixels with the nearest cache", caches.nearest_pixels),
        Count::new("black_pixels", "pixels without a cache", caches.black_pixels),
    ]
}

pub(super) fn complaint(shape: &PbgiShape, words: &[Vec<u32>]) -> Option<String> {
    let (points, caches) = structs(words)?;
    let wanted = points.primary_count + points.primaries_lost;
    if points.primaries_lost > 0 {
        return Some(format!(
            "{wanted} primary points were found, and there is room for {}: the picture lacks light",
            shape.primary_capacity
        ));
    }
    let (needed, kept) = (points.needed_count, shape.kept_secondaries());
    if shape.bounces > 1 && needed > kept {
        return Some(format!(
            "{needed} secondary points are lit, and there is room for what {kept} of them see: the picture lacks light of \
             bounces after the first"
        ));
    }
    (caches.lost_references > 0).then(|| {
        format!("tiles had no room for {} references to caches: the picture lacks light", caches.lost_references)
    })
}
