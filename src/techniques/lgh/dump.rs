//! What the resources of the hierarchy are, for dumps.
//!
//! Only the part that a pass wrote is told. What a pass left unwritten is 0 in the array, since the memory there holds
//! whatever was in it before.

use super::super::many_lights;
use crate::dump::{
    Array, COUNT, DEPTH, Derived, DumpContext, Entry, LIGHTING, RGBA, Scalar, all_words, buffer, bytes_of, f, image,
    interleaved, noted, per_pixel, ranks, u, words,
};
use crate::passes::lgh_shape::LghShape;
use crate::passes::rounds::LIST_HEADER;
use crate::settings::Reservoir;
use crate::shared::{
    self, DESCENT_STRIDE, FieldInfo, FrameData, GridLight, GridPlacement, MAX_LEVEL, MOMENT_WORDS, NO_LIGHT,
    SUB_IMAGE_STRIDE, SharedStruct,
};

/// Words of a sub-image in `sub_images`, and rows of the level table.
const LEVELS: u64 = SUB_IMAGE_STRIDE as u64;
/// Parts in a descent table.
const DESCENT_PARTS: usize = shared::DESCENT_PARTS as usize;
/// Representatives of an S1 light.
const REPRESENTATIVES: u64 = shared::REPRESENTATIVES as u64;
/// Units of a grid light.
const GRID_LIGHT: &str = "metres, square metres, flux";

/// Longer names stand before names that they begin with.
pub(in crate::techniques) const ENTRIES: &[Entry] = &[
    buffer("bounds", "metres, flux", bounds, "The lights' bounding box and the largest component of any light's flux."),
    noted(buffer(
        "grid_placement",
        "metres, flux",
        grid_placement,
        "Placement of the grids: vertex (0, 0, 0) of every level and the edge of the top level's cell.",
    )),
    buffer(
        "grid_lights",
        GRID_LIGHT,
        grid_lights,
        "The grid lights of the levels that the pass built, or the level and vertex of those that it listed.",
    ),
    buffer(
        "occupancy_ranks",
        COUNT,
        ranks,
        "For each word of the occupancy the number of occupied vertices before it in the scanned range.",
    ),
    buffer(
        "occupancy",
        "bits",
        all_words,
        "One bit for each grid vertex of every level, 1 where it holds a light; each row of vertices starts a new word.",
    ),
    noted(buffer(
        "level_table",
        COUNT,
        level_table,
        "First grid light and number of grid lights of every level, and the lights that did not fit.",
    )),
    buffer(
        "level_dispatches",
        "workgroups",
        level_dispatches,
        "Indirect dispatches: [0] over all grid lights, [l] one workgroup for each light of level l (256 lights for level 1), [11 + l] 256 lights of level l.",
    ),
    buffer(
        "moments",
        "fixed point, 40 fractional bits; metres in cells, flux over the largest",
        moments,
        "For each grid light the sums of w, wm, wmq (3), wmq^2 (3), wmn (3), w flux (3), with w the trilinear weight, m the luminance, q the offset from the vertex in cells, n the normal.",
    ),
    buffer(
        "merged_lights",
        GRID_LIGHT,
        merged_lights,
        "The lights of all used levels, by sub-image and level; vertex is the grid light, or the light of S0 for level 0.",
    ),
    buffer("merge_dispatch", "workgroups", merge_dispatch, "The indirect dispatch of the merge."),
    noted(buffer(
        "sub_images",
        COUNT,
        sub_images,
        "For each sub-image the first merged light of every used level, and the end of the list.",
    )),
    image(
        "merged_light_texels",
        "m, m; 1; flux",
        RGBA,
        "The merged lights again, three texels each: centre and blending radius, mean normal and luminance, flux.",
    ),
    buffer(
        "light_bucket_cells",
        "bits",
        all_words,
        "One bit for each cell of S1, 1 where it holds a light of S0; each row of cells starts a new word.",
    ),
    buffer("light_bucket_ranks", COUNT, ranks, "For each word of these bits the number of cells before it."),
    buffer("light_bucket_counts", COUNT, all_words, "Lights of S0 in each cell of S1; 0 again once they are listed."),
    buffer("light_bucket_starts", "index", ranks, "Where the lights of each cell start in their list, and its end."),
    buffer("light_bucket_lights", "index", light_bucket_lights, "The lights of S0 by cell of S1."),
    buffer(
        "light_volume_draws",
        COUNT,
        draws,
        "One indirect draw for each sub-image: an icosahedron of 60 vertices for every light below the top level.",
    ),
    interleaved(image(
        "interleaved_depth",
        "near / view z",
        DEPTH,
        "The depth buffer distributed over the sub-images.",
    )),
    interleaved(buffer(
        "lights_tested",
        COUNT,
        lights_tested,
        "Lights that each pixel tests: light-volume fragments and the top level, or the candidates of its tile.",
    )),
    interleaved(buffer(
        "reservoirs",
        "index; race key or luminance",
        reservoirs,
        "The merged lights selected by each pixel for its shadow rays, with the winning key or the sum of all weights.",
    )),
    interleaved(buffer(
        "round_reservoirs",
        "index; race key or luminance",
        reservoirs,
        "The same in further rounds of samples, where the inspector reads those of the first.",
    )),
    buffer(
        "round_tiles_*",
        "index",
        round_tiles,
        "Tiles of 8x8 pixels with some that take part in that round of samples, in rising order.",
    ),
    image(
        "lighting_blurred_*",
        LIGHTING,
        RGBA,
        "The unshadowed lighting merged from the sub-images and blurred along the axis in the name.",
    ),
    interleaved(image(
        "lighting",
        LIGHTING,
        RGBA,
        "Unshadowed light of the hierarchy; A is the sum of the weights (luminance) of the lights that may become shadow samples.",
    )),
    buffer(
        "descent_tables",
        "flux (luminance)",
        descent_tables,
        "The parts of each grid light above S1: grid lights one level below with the running sum of their luminances.",
    ),
    buffer(
        "representatives",
        "index; race key",
        representatives,
        "Four lights of S0 for each S1 light, drawn in proportion to their share of it.",
    ),
    buffer(
        "round_representatives",
        "index; race key",
        representatives,
        "The same of a further round of samples; none where there is a history.",
    ),
    buffer(
        "discontinuities",
        "bits",
        per_pixel,
        "Bit 0 where there is an edge towards the right neighbour, bit 1 towards the one below.",
    ),
    image(
        "reprojected_*",
        "that of the history",
        RGBA,
        "What was found of the image temporal_* for the visible surface, where it was in the frame before; 0 where it was not in sight.",
    ),
    image(
        "temporal_shadowed",
        "flux-weighted luminance",
        RGBA,
        "Mean over the frames of S per unit, or of S itself with --temporal indirect; A is the number of frames, at most one over the least weight.",
    ),
    image(
        "temporal_unshadowed",
        "flux-weighted luminance",
        RGBA,
        "Mean of U over the same frames; A is the variance of one frame's shadowed luminance.",
    ),
    image(
        "temporal_lighting",
        LIGHTING,
        RGBA,
        "Mean over the same frames of the unshadowed lighting; A is the mean of what the estimates are per unit of.",
    ),
    image(
        "tile_sums",
        "luminance",
        RGBA,
        "Sums over the pixels of each 8x8 tile that have a history: shadowed light of the frame, that of the history, what both are per unit of, and the latter over the number of frames in the history.",
    ),
    image(
        "temporal_tiles",
        "luminance per unit",
        RGBA,
        "For each 8x8 tile the mean shadowed light of the frame, the variance of such means, how far the last few frames are above their histories in standard deviations, and the number of frames.",
    ),
    image(
        "given_up",
        "share",
        RGBA,
        "For each 8x8 tile in R the share of the history that is given up; the rest is 0.",
    ),
    image(
        "shadowed_blended",
        "flux-weighted luminance",
        RGBA,
        "The mean of S for the filter, per unit; A is its standard deviation, -1 where too few frames tell it.",
    ),
    image(
        "unshadowed_blended",
        "flux-weighted luminance",
        RGBA,
        "The mean of U for the filter. Both are per unit of its alpha.",
    ),
    image(
        "shadowed*",
        "flux-weighted luminance",
        RGBA,
        "The shadowed estimate S of the lighting: as traced, blurred along an axis, or after this many iterations of the filter, with its standard deviation in alpha.",
    ),
    image(
        "unshadowed*",
        "flux-weighted luminance",
        RGBA,
        "The unshadowed estimate U of the same samples; S / U is the shadow. Both are per unit of its alpha.",
    ),
];

/// Lights of S0 by cell. Before they are sorted their order within a cell is left to chance, so that only which they are
/// is told: in the order of their numbers.
fn light_bucket_lights(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    let count = many_lights::light_count(known);
    let mut lights = words(bytes);
    lights.truncate(count as usize);
    if known.pass.ends_with("list_lights") {
        lights.sort_unstable();
    }
    Array::plain(Scalar::U32, &[count.into()], &bytes_of(&lights))
}

/// Bounds, from integers that are ordered like the floats back to floats.
fn bounds(bytes: &[u8], _: &DumpContext<'_>) -> Array {
    let float = |ordered: u32| if ordered >> 31 == 1 { ordered & 0x7fff_ffff } else { !ordered };
    let mut floats: Vec<u32> = words(bytes).into_iter().take(7).map(float).collect();
    // Minima are kept as maxima of the negated coordinate.
    floats[3..6].iter_mut().for_each(|bits| *bits ^= 0x8000_0000);
    let fields = vec![f("highest_ws", &[3]), f("lowest_ws", &[3]), f("largest_flux", &[])];
    Array::records(fields, &[1], &bytes_of(&floats))
}

/// `GridPlacement`.
fn grid_placement(bytes: &[u8], _: &DumpContext<'_>) -> Array {
    Array::structs(&GridPlacement::INFO, |field| !field.is_padding(), 1, bytes)
}

/// Grid lights of the levels that the pass made; of a listed vertex only its level and index.
fn grid_lights(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    let (first, count) = pushed_levels(known);
    let part = &bytes[size_of::<GridLight>() * first as usize..];
    let only_listed = known.pass.starts_with("compaction/");
    let is_wanted = |field: &FieldInfo| !only_listed || ["level", "vertex"].contains(&field.name);
    Array::structs(&GridLight::INFO, is_wanted, count, part).starting_at(first)
}

/// The merged list up to its end.
fn merged_lights(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    Array::structs(&GridLight::INFO, |_| true, merged_count(known), bytes)
}

/// Fixed-point sums of the levels that the pass added to.
fn moments(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    let (first, count) = pushed_levels(known);
    let record = 4 * MOMENT_WORDS as usize;
    let part = &bytes[record * first as usize..];
    Array::plain(Scalar::I64, &[count, u64::from(MOMENT_WORDS) / 2], part).starting_at(first)
}

/// First light and number of lights by level, and the lights lost.
fn level_table(bytes: &[u8], _: &DumpContext<'_>) -> Array {
    Array::records(vec![u("first_and_count", &[LEVELS, 2]), u("lost", &[])], &[1], bytes)
}

/// Indirect dispatches; those not yet written are zeroed.
fn level_dispatches(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    let last = known.push.get(1).copied().unwrap_or(MAX_LEVEL);
    let mut words = words(bytes);
    for (slot, dispatch) in words.chunks_exact_mut(3).enumerate() {
        let slot = slot as u32;
        let level = if slot > MAX_LEVEL { slot - MAX_LEVEL - 1 } else { slot };
        if slot != 0 && (level == 0 || level > last) {
            dispatch.fill(0);
        }
    }
    Array::plain(Scalar::U32, &[words.len() as u64 / 3, 3], &bytes_of(&words))
}

/// The tiles of a list, sorted: the order there is that in which workgroups came.
fn round_tiles(bytes: &[u8], _: &DumpContext<'_>) -> Array {
    let words = words(bytes);
    let count = words.get(LIST_HEADER - 1).copied().unwrap_or(0) as usize;
    let mut tiles: Vec<u32> = words.into_iter().skip(LIST_HEADER).take(count).collect();
    tiles.sort_unstable();
    Array::plain(Scalar::U32, &[tiles.len() as u64], &bytes_of(&tiles))
}

/// One dispatch.
fn merge_dispatch(bytes: &[u8], _: &DumpContext<'_>) -> Array {
    Array::plain(Scalar::U32, &[1, 3], bytes)
}

/// Starts of the used levels of every sub-image.
fn sub_images(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    let Some(shape) = known.shape::<LghShape>() else { return all_words(bytes, known) };
    let (first, end) = (shape.first_level as usize, shape.levels.top as usize + 1);
    let mut words = words(bytes);
    for starts in words.chunks_exact_mut(LEVELS as usize) {
        starts[..first].fill(0);
        starts[end + 1..].fill(0);
    }
    Array::plain(Scalar::U32, &[words.len() as u64 / LEVELS, LEVELS], &bytes_of(&words))
}

/// `VkDrawIndirectCommand`s.
fn draws(bytes: &[u8], _: &DumpContext<'_>) -> Array {
    let fields = ["vertex_count", "instance_count", "first_vertex", "first_instance"].map(|name| u(name, &[]));
    Array::records(fields.to_vec(), &[bytes.len() as u64 / 16], bytes)
}

/// Lights tested by pixel in the interleaved layout; nothing where they are not counted.
fn lights_tested(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    let Some(shape) = known.shape::<LghShape>() else { return all_words(bytes, known) };
    let pixels = interleaved_pixels(shape);
    // Views leave the counting out whatever the shape says.
    let counted = shape.count_lights_tested && bytes.len() as u64 == 4 * pixels[0] * pixels[1];
    Array::plain(Scalar::U32, &if counted { pixels } else { [0, 0] }, bytes)
}

/// Reservoirs by pixel in the interleaved layout.
fn reservoirs(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    let Some(shape) = known.shape::<LghShape>() else { return all_words(bytes, known) };
    let [height, width] = interleaved_pixels(shape);
    let samples = u64::from(shape.lights.shadow_samples);
    match shape.reservoir {
        // One 64-bit word: the key above the light.
        Reservoir::Exact => Array::records(vec![u("light", &[]), f("key", &[])], &[height, width, samples], bytes),
        Reservoir::Race | Reservoir::Lock => {
            let fields = vec![u("lock", &[]), f("total", &[]), u("light", &[samples])];
            Array::records(fields, &[height, width], bytes)
        }
    }
}

/// Descent tables of the lights above S1; unused parts have no light.
fn descent_tables(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    let Some(shape) = known.shape::<LghShape>() else { return all_words(bytes, known) };
    let stride = DESCENT_STRIDE as usize;
    let upper: u64 = (2..=shape.levels.top).map(|l| level(known, l).1).sum();
    let count = upper.min((bytes.len() / (4 * stride)) as u64);
    let words = words(bytes);
    let mut unpacked = Vec::new();
    for table in words.chunks_exact(stride).take(count as usize) {
        let parts = table[0].min(DESCENT_PARTS as u32);
        let part =
            |i: usize, unused: u32, offset: usize| if i < parts as usize { table[2 * i + offset] } else { unused };
        unpacked.push(parts);
        unpacked.extend((0..DESCENT_PARTS).map(|i| part(i, 0, 2)));
        unpacked.extend((0..DESCENT_PARTS).map(|i| part(i, NO_LIGHT, 3)));
    }
    let parts = DESCENT_PARTS as u64;
    let fields = vec![u("parts", &[]), f("cumulative_luminance", &[parts]), u("light", &[parts])];
    Array::records(fields, &[count], &bytes_of(&unpacked))
}

/// Representatives of the S1 lights: race key and light of S0.
fn representatives(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    let index_bits = known.push.first().copied().unwrap_or(1);
    let count = level(known, 1).1;
    let split = |word: u32| match word {
        // No light has been drawn.
        u32::MAX => [NO_LIGHT, u32::MAX >> index_bits],
        word => [word & ((1 << index_bits) - 1), word >> index_bits],
    };
    let used = (count * REPRESENTATIVES) as usize;
    let unpacked: Vec<u32> = words(bytes).into_iter().take(used).flat_map(split).collect();
    Array::records(vec![u("light", &[]), u("key", &[])], &[count, REPRESENTATIVES], &bytes_of(&unpacked))
}

/// First light of a level in the grid lights, and number of lights.
fn level(known: &DumpContext<'_>, level: u32) -> (u64, u64) {
    let table = known.words("level_table");
    let word = |index: usize| table.get(index).copied().unwrap_or(0).into();
    (word(2 * level as usize), word(2 * level as usize + 1))
}

/// First light and number of lights of the levels that the pass was pushed.
fn pushed_levels(known: &DumpContext<'_>) -> (u64, u64) {
    let first = known.push.first().copied().unwrap_or(1);
    let last = known.push.get(1).copied().unwrap_or(first);
    (level(known, first).0, (first..=last).map(|l| level(known, l).1).sum())
}

/// Height and width of the interleaved layout.
fn interleaved_pixels(shape: &LghShape) -> [u64; 2] {
    let [width, height] = shape.interleaved_px();
    [height.into(), width.into()]
}

/// End of the merged list.
fn merged_count(known: &DumpContext<'_>) -> u64 {
    let Some(shape) = known.shape::<LghShape>() else { return 0 };
    let sub_images = (shape.interleave * shape.interleave) as usize;
    let index = (sub_images - 1) * LEVELS as usize + shape.levels.top as usize + 1;
    known.words("sub_images").get(index).copied().unwrap_or(0).into()
}

/// The blending radius of every merged light, which the shaders compute where they need it.
pub(super) fn blending_radii(merged: &[u8], known: &DumpContext<'_>, data: &FrameData) -> Option<Derived> {
    let top = known.shape::<LghShape>()?.levels.top as i32;
    let word = GridPlacement::INFO.field("h_top")?.offset_bytes / 4;
    let h_top = f32::from_bits(*known.words("grid_placement").get(word)?);
    let list = merged_lights(merged, known);
    let lights: Vec<GridLight> = bytemuck::pod_collect_to_vec(&list.bytes);
    let alpha = data.alpha;
    let radius = |light: &GridLight| alpha * (h_top * 2.0_f32.powi(light.level as i32 - top));
    let radii: Vec<u8> = lights.iter().flat_map(|light| radius(light).to_le_bytes()).collect();
    Some(Derived {
        name: "blending_radii",
        units: "metres",
        meaning: "Blending radius of each merged light: alpha times the cell edge of its level.",
        array: Array::plain(Scalar::F32, &list.shape, &radii),
    })
}
