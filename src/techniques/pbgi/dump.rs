//! What the resources of point-based global illumination are, for dumps. Of what a pass makes for each primary point only
//! as much is told as there are points.

use crate::dump::{
    Array, COUNT, DEPTH, DumpContext, Entry, LIGHTING, RGBA, Scalar, all_words, buffer, bytes_of, image, noted, ranks,
    words,
};
use crate::micro_buffers::LOBES;
use crate::shared::{
    BLURRED_COLUMNS, BLURRED_ROWS, CacheCounts, CachePlace, MicroTexel, POINT_LEAVES, PRIMARY_EDGE, PointCounts,
    SECONDARY_EDGE, SharedStruct, ShownPoint,
};

/// Longer names stand before names that they begin with.
pub(super) const ENTRIES: &[Entry] = &[
    buffer(
        "micro_texels",
        "coverage (0 to 255) << 24 | key",
        micro_texels,
        "What each primary point sees, row by row in 16x16 texels about its normal: how much of a texel is covered, and by which key.",
    ),
    buffer(
        "kept_texels",
        "order << 24 | key",
        micro_texels,
        "With --reuse what the texels of each primary point see and how near the side's centre, as they are kept; where points are splatted as in micro_texels.",
    ),
    buffer("seen_bits", "bits", all_words, "One bit for each key, 1 where a primary point sees it."),
    buffer(
        "cache_lobes",
        "irradiance",
        cache_lobes,
        "For each primary point and each of 5x5 lobes the light of the environment, RGB, and the light of surfaces.",
    ),
    buffer("cache_places", "metres", cache_places, "Position, reach and key of each cache."),
    buffer(
        "reference_counts",
        COUNT,
        all_words,
        "Caches that reach each tile of pixels; 0 again once they are listed.",
    ),
    noted(buffer(
        "reference_starts",
        "index",
        ranks,
        "Where the caches of each tile start in their list, and its end.",
    )),
    buffer("cache_references", "index", cache_references, "The caches by tile."),
    noted(buffer(
        "cache_counts",
        COUNT,
        cache_counts,
        "References that did not fit into tiles, and pixels without a cache: within its reach, within twice its reach, at any distance.",
    )),
    image(
        "cache_lighting",
        LIGHTING,
        RGBA,
        "Light of the caches: of surfaces, and with direct light of the environment.",
    ),
    image("cache_mix", "1", RGBA, "The colours of the caches that light each pixel, mixed by their shares."),
    buffer("shown_ranks", COUNT, ranks, "For each word of bits the number of points before it that a view shows."),
    noted(buffer(
        "shown_points_draw",
        "vertices, instances",
        draws,
        "The indirect draw of the points that a view shows.",
    )),
    buffer(
        "shown_bounds",
        "ordered floats",
        all_words,
        "Of x, z, -x and -z the highest of any point that a view shows; whole numbers in the order of the floats.",
    ),
    buffer("shown_points", "metres", shown_points, "The points that a view shows, with the values shown for each."),
    image("shown_depth", "1", DEPTH, "Height of the points seen from above."),
];

/// What light is gathered with.
pub(super) const TABLES: &[Entry] = &[
    buffer(
        "micro_table_*",
        "1, sr",
        micro_table,
        "The texels of a micro-buffer, of primary or of secondary points, row by row: direction about the normal, solid angle and cosine-weighted solid angle.",
    ),
    buffer(
        "environment_means",
        "radiance",
        environment_means,
        "The environment's means over spherical caps of the sizes of texels, one image after another; the fourth number is unused.",
    ),
];

/// The points' tree, and what it is asked for.
pub(super) const POINTS: &[Entry] = &[
    image(
        "point_nodes",
        "words",
        RGBA,
        "The nodes of the point tree from 1 on, two texels each: centroid and radius, and packed normal, area, spread, leaf and flags.",
    ),
    buffer("point_albedos", "albedo, RGB9E5", all_words, "Albedo of each node."),
    buffer("point_turned_bits", "bits", all_words, "One bit for each node, 1 where its normal opposes its parent's."),
    buffer("leaf_cells", "index", all_words, "The leaf of each cell of a triangle, counted from the first leaf."),
    buffer(
        "triangle_cells",
        "index, count",
        pairs,
        "For each triangle its first cell, and the number of parts that its edges are divided into.",
    ),
    buffer("point_arrivals", COUNT, all_words, "Number of children of each inner node that have been visited."),
    buffer(
        "passing_bits",
        "bits",
        all_words,
        "One bit for each node, 1 where it is small and flat enough in the picture.",
    ),
    buffer("primary_bits", "bits", all_words, "One bit for each key, 1 where it is a primary point."),
    noted(buffer(
        "point_counts",
        COUNT,
        point_counts,
        "Primary points and those that did not fit, points that need a micro-buffer likewise, keys that are seen, and with --reuse what of primary and of other points is kept.",
    )),
    buffer(
        "point_dispatches",
        "workgroups",
        point_dispatches,
        "Indirect dispatches over primary points and over those that need a micro-buffer: a workgroup each, a thread each, a workgroup for four.",
    ),
    buffer("primaries_ranks", COUNT, ranks, "For each word of bits the number of primary points before it."),
    buffer("point_primaries", "key", primary_keys, "The keys of the primary points, in ascending order."),
    buffer(
        "needed_ranks",
        COUNT,
        ranks,
        "For each word of bits the number of points before it that need a micro-buffer.",
    ),
    buffer("point_needed", "key", needed_keys, "The keys of the points that need a micro-buffer, in ascending order."),
    buffer("under_bits", "bits", all_words, "One bit for each key, 1 where it is a primary point or lies under one."),
    buffer("borrowed_bits", "bits", all_words, "One bit for each key, 1 where it takes the light of its parent."),
    buffer("known_bits", "bits", all_words, "One bit for each key, 1 where keys above can take light from it."),
    buffer(
        "derived_bits",
        "bits",
        all_words,
        "One bit for each key, 1 where its light is the mean of those of its children that are known.",
    ),
    buffer("lit_bits", "bits", all_words, "With --reuse one bit for each key, 1 where it has light of its own."),
    buffer(
        "unlit_bits",
        "bits",
        all_words,
        "With --reuse one bit for each key, 1 where that light is not from the previous frame.",
    ),
    buffer(
        "point_places",
        "key, side of a leaf",
        point_places,
        "With --reuse the key of each primary point and the leaf that it is at.",
    ),
    buffer(
        "kept_slots",
        "index",
        kept_slots,
        "With --reuse the index of each primary point in the previous frame; 4294967295 for one that did not exist, or was elsewhere.",
    ),
    buffer("needed_bits", "bits", all_words, "One bit for each key, 1 where it needs a micro-buffer of its own."),
    buffer(
        "primary_leaves",
        "order << 22 | side of a leaf",
        primary_leaves,
        "For each primary point up to four of its leaves that the eye sees, counted by sides from the first; 4294967295 for none.",
    ),
    buffer(
        "seen_texels",
        "order << 25 | texel",
        seen_texels,
        "For each key hit by rays up to four texels of primary points whose rays hit it, counted over all micro-buffers; 4294967295 for none.",
    ),
    buffer(
        "lending_bits",
        "bits",
        all_words,
        "With more than one bounce one bit for each key, 1 where it has light that those can take who see it or what lies below it.",
    ),
    buffer(
        "averaged_bits",
        "bits",
        all_words,
        "With more than one bounce one bit for each key, 1 where its light is the mean of those of its children that lend it.",
    ),
    buffer(
        "secondary_texels",
        "coverage (0 to 255) << 24 | key",
        secondary_texels,
        "With more than one bounce what each point of point_needed sees, row by row in 8x8 texels about its normal, as in micro_texels.",
    ),
    buffer(
        "bounced_irradiance_*",
        "irradiance",
        point_irradiance,
        "With more than one bounce the light of each key that has any, RGB, after an even or odd number of them.",
    ),
    buffer("point_irradiance", "irradiance", point_irradiance, "Light of each key that has any, RGB."),
];

fn point_counts(bytes: &[u8], _: &DumpContext<'_>) -> Array {
    Array::structs(&PointCounts::INFO, |_| true, 1, bytes)
}

fn point_dispatches(bytes: &[u8], _: &DumpContext<'_>) -> Array {
    Array::plain(Scalar::U32, &[bytes.len() as u64 / 12, 3], bytes)
}

fn draws(bytes: &[u8], _: &DumpContext<'_>) -> Array {
    Array::plain(Scalar::U32, &[4], bytes)
}

fn shown_points(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    let count = known.words("shown_points_draw").get(1).copied().unwrap_or(0);
    Array::structs(&ShownPoint::INFO, |_| true, count.into(), bytes)
}

fn micro_table(bytes: &[u8], _: &DumpContext<'_>) -> Array {
    Array::structs(&MicroTexel::INFO, |_| true, (bytes.len() / size_of::<MicroTexel>()) as u64, bytes)
}

fn environment_means(bytes: &[u8], _: &DumpContext<'_>) -> Array {
    let [rows, columns] = [BLURRED_ROWS, BLURRED_COLUMNS].map(u64::from);
    Array::plain(Scalar::F32, &[bytes.len() as u64 / (16 * rows * columns), rows, columns, 4], bytes)
}

fn pairs(bytes: &[u8], _: &DumpContext<'_>) -> Array {
    Array::plain(Scalar::U32, &[bytes.len() as u64 / 8, 2], bytes)
}

fn primary_keys(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    Array::plain(Scalar::U32, &[count_of(known, "primary_count")], bytes)
}

fn needed_keys(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    Array::plain(Scalar::U32, &[count_of(known, "needed_count")], bytes)
}

fn primary_leaves(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    Array::plain(Scalar::U32, &[primaries(known), POINT_LEAVES.into()], bytes)
}

fn point_places(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    Array::plain(Scalar::U32, &[primaries(known), 2], bytes)
}

fn kept_slots(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    Array::plain(Scalar::U32, &[primaries(known)], bytes)
}

fn seen_texels(bytes: &[u8], _: &DumpContext<'_>) -> Array {
    let leaves = u64::from(POINT_LEAVES);
    Array::plain(Scalar::U32, &[bytes.len() as u64 / (4 * leaves), leaves], bytes)
}

fn point_irradiance(bytes: &[u8], _: &DumpContext<'_>) -> Array {
    Array::plain(Scalar::F32, &[bytes.len() as u64 / 12, 3], bytes)
}

/// A word of the counts of points.
fn count_of(known: &DumpContext<'_>, name: &str) -> u64 {
    let word = PointCounts::INFO.field(name).map_or(0, |field| field.offset_bytes / 4);
    known.words("point_counts").get(word).copied().unwrap_or(0).into()
}

/// Primary points of the frame.
fn primaries(known: &DumpContext<'_>) -> u64 {
    count_of(known, "primary_count")
}

fn micro_texels(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    Array::plain(Scalar::U32, &[primaries(known), PRIMARY_EDGE.into(), PRIMARY_EDGE.into()], bytes)
}

/// As many as there is room for.
fn secondary_texels(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    let edge = u64::from(SECONDARY_EDGE);
    let kept = count_of(known, "needed_count").min(bytes.len() as u64 / (4 * edge * edge));
    Array::plain(Scalar::U32, &[kept, edge, edge], bytes)
}

fn cache_lobes(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    Array::plain(Scalar::F32, &[primaries(known), LOBES.into(), 2, 3], bytes)
}

fn cache_places(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    Array::structs(&CachePlace::INFO, |_| true, primaries(known), bytes)
}

fn cache_counts(bytes: &[u8], _: &DumpContext<'_>) -> Array {
    Array::structs(&CacheCounts::INFO, |_| true, 1, bytes)
}

/// The lists of all tiles, each in ascending order: what is written has none.
fn cache_references(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    let starts = known.words("reference_starts");
    let mut words = words(bytes);
    let end = starts.last().map_or(0, |end| (*end as usize).min(words.len()));
    for range in starts.windows(2) {
        let [first, last] = [range[0], range[1]].map(|at| (at as usize).min(end));
        words[first..last].sort_unstable();
    }
    Array::plain(Scalar::U32, &[end as u64], &bytes_of(&words))
}
