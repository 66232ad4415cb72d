//! What every resource of the frame is: the one place where a dump's names, units and meanings are written.

use super::array::Array;
use super::contents::{self, Known};

/// How a resource is taken apart.
#[derive(Clone, Copy)]
pub enum Contents {
    /// A buffer, by the function that makes an array of it.
    Buffer(fn(&[u8], &Known) -> Array),
    /// An image, by the names of its channels.
    Image(&'static [&'static str]),
}

/// One resource of the frame, or several whose names begin alike.
#[derive(Clone, Copy)]
pub struct Entry {
    /// The graph's name; with `*` at the end any name that begins so.
    pub name: &'static str,
    /// Units of its numbers.
    pub units: &'static str,
    /// What it holds, in a sentence.
    pub meaning: &'static str,
    /// Whether its pixels are in the interleaved layout.
    pub interleaved: bool,
    /// How it is taken apart.
    pub contents: Contents,
}

const RGBA: &[&str] = &["R", "G", "B", "A"];
const DEPTH: &[&str] = &["Z"];
const NORMALS: &[&str] = &["shading", "geometric"];

const RADIANCE: &str = "radiance";
const LIGHTING: &str = "radiance per unit albedo";
const METRES_AND_BITS: &str = "metres; octahedral mapping, 16-bit snorm";
const GRID_LIGHT: &str = "metres, square metres, flux";
const COUNT: &str = "count";

/// The resource of this name.
#[must_use]
pub fn entry(resource: &str) -> Option<&'static Entry> {
    let fits = |name: &str| match name.strip_suffix('*') {
        Some(start) => resource.starts_with(start),
        None => resource == name,
    };
    TABLE.iter().find(|entry| fits(entry.name))
}

const fn buffer(
    name: &'static str,
    units: &'static str,
    contents: fn(&[u8], &Known) -> Array,
    meaning: &'static str,
) -> Entry {
    Entry { name, units, meaning, interleaved: false, contents: Contents::Buffer(contents) }
}

const fn image(
    name: &'static str,
    units: &'static str,
    channels: &'static [&'static str],
    meaning: &'static str,
) -> Entry {
    Entry { name, units, meaning, interleaved: false, contents: Contents::Image(channels) }
}

const fn interleaved(entry: Entry) -> Entry {
    Entry { interleaved: true, ..entry }
}

/// Longer names stand before names that they begin with.
pub const TABLE: &[Entry] = &[
    buffer(
        "frame_data",
        "see docs/dumps.md",
        contents::frame_data,
        "The frame's constants, from which every pass starts.",
    ),
    buffer("ray_count", COUNT, contents::all_words, "Rays traced so far: [0] by light paths, [1] for shadows."),
    image("gbuffer_albedo", "1", RGBA, "Linear base colour of the visible surface; A is 1 where there is one."),
    image(
        "gbuffer_normals",
        "two 16-bit snorm in a word",
        NORMALS,
        "Shading and geometric normal of the visible surface, octahedral.",
    ),
    image("gbuffer_depth", "near / view z", DEPTH, "Reversed depth of the visible surface, 0 where there is none."),
    buffer(
        "vpl_slot_positions",
        METRES_AND_BITS,
        contents::slot_positions,
        "Positions and normals of the VPLs where the paths left them: bounce b of path p is slot p * bounces + b.",
    ),
    buffer("vpl_slot_fluxes", "flux", contents::slot_fluxes, "Fluxes of the VPLs in the same slots."),
    buffer("vpl_slot_bits", "bits", contents::all_words, "One bit for each slot, 1 where it holds a VPL."),
    buffer("vpl_slot_ranks", COUNT, contents::ranks, "For each word of the slot bits the number of VPLs before it."),
    buffer(
        "scan_block_sums_*",
        COUNT,
        contents::all_words,
        "Set bits of each block of words, after the second step those of all blocks before it.",
    ),
    buffer(
        "light_positions",
        METRES_AND_BITS,
        contents::light_positions,
        "Positions and normals of the lights S0: the VPLs in slot order, then the scene's lights.",
    ),
    buffer(
        "light_fluxes",
        "flux",
        contents::light_fluxes,
        "Fluxes of the lights S0; is_vpl is 1 for VPLs and 0 for lights that shine in all directions.",
    ),
    buffer("light_counts", COUNT, contents::light_counts, "Lights in S0, VPLs among them, and VPLs that did not fit."),
    buffer(
        "bounds",
        "metres, flux",
        contents::bounds,
        "The lights' bounding box and the largest component of any light's flux.",
    ),
    buffer(
        "grid_placement",
        "metres, flux",
        contents::grid_placement,
        "Where the grids lie: vertex (0, 0, 0) of every level and the edge of the top level's cell.",
    ),
    buffer(
        "grid_lights",
        GRID_LIGHT,
        contents::grid_lights,
        "The grid lights of the levels that the pass made, or the level and vertex of those that it listed.",
    ),
    buffer(
        "occupancy_ranks",
        COUNT,
        contents::ranks,
        "For each word of the occupancy the number of occupied vertices before it in the scanned range.",
    ),
    buffer(
        "occupancy",
        "bits",
        contents::all_words,
        "One bit for each grid vertex of every level, 1 where it holds a light; rows of vertices begin a word.",
    ),
    buffer(
        "level_table",
        COUNT,
        contents::level_table,
        "First grid light and number of grid lights of every level, and the lights that did not fit.",
    ),
    buffer(
        "level_dispatches",
        "workgroups",
        contents::level_dispatches,
        "Indirect dispatches: [0] over all grid lights, [l] one workgroup for each light of level l (256 lights for level 1), [11 + l] 256 lights of level l.",
    ),
    buffer(
        "moments",
        "fixed point, 40 fractional bits; metres in cells, flux over the largest",
        contents::moments,
        "For each grid light the sums of w, wm, wmq (3), wmq^2 (3), wmn (3), w flux (3), with w the trilinear weight, m the luminance, q the offset from the vertex in cells, n the normal.",
    ),
    buffer(
        "merged_lights",
        GRID_LIGHT,
        contents::merged_lights,
        "The lights of all used levels, by sub-image and level; vertex is the grid light, or the light of S0 for level 0.",
    ),
    buffer("merge_dispatch", "workgroups", contents::merge_dispatch, "The indirect dispatch of the merge."),
    buffer(
        "tiles",
        COUNT,
        contents::tiles,
        "For each sub-image the first merged light of every used level, and the end of the list.",
    ),
    image(
        "merged_light_texels",
        "m, m; 1; flux",
        RGBA,
        "The merged lights once more, three texels each: centre and blending radius, mean normal, flux.",
    ),
    buffer(
        "light_bucket_cells",
        "bits",
        contents::all_words,
        "One bit for each cell of S1, 1 where it holds a light of S0; rows of cells begin a word.",
    ),
    buffer("light_bucket_ranks", COUNT, contents::ranks, "For each word of these bits the number of cells before it."),
    buffer(
        "light_bucket_counts",
        COUNT,
        contents::all_words,
        "Lights of S0 in each cell of S1; 0 again once they are listed.",
    ),
    buffer(
        "light_bucket_starts",
        "index",
        contents::ranks,
        "Where the lights of each cell start in their list, and its end.",
    ),
    buffer("light_bucket_lights", "index", contents::light_bucket_lights, "The lights of S0 by cell of S1."),
    buffer(
        "light_volume_draws",
        COUNT,
        contents::draws,
        "One indirect draw for each sub-image: an icosahedron of 60 vertices for every light below the top level.",
    ),
    interleaved(image("interleaved_depth", "near / view z", DEPTH, "The depth buffer dealt to the sub-images.")),
    interleaved(buffer(
        "overdraw",
        COUNT,
        contents::overdraw,
        "Lights that each pixel tests: light-volume fragments and the top level, or the candidates of its tile.",
    )),
    interleaved(buffer(
        "reservoirs",
        "index; race key or luminance",
        contents::reservoirs,
        "The merged lights that each pixel chose for its shadow rays, with the key that won or the sum of all weights.",
    )),
    image(
        "lighting_blurred_*",
        LIGHTING,
        RGBA,
        "The unshadowed lighting put together from the sub-images and blurred along the axis in the name.",
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
        contents::descent_tables,
        "What each grid light above S1 is made of: grid lights one level below with the running sum of their luminances.",
    ),
    buffer(
        "representatives",
        "index; race key",
        contents::representatives,
        "Four lights of S0 for each S1 light, drawn in proportion to their share of it.",
    ),
    buffer(
        "discontinuities",
        "bits",
        contents::per_pixel,
        "Bit 0 where the surface breaks towards the right neighbour, bit 1 towards the one below.",
    ),
    image(
        "shadowed*",
        "flux-weighted luminance",
        RGBA,
        "The shadowed estimate S of the lighting: as traced, blurred along an axis, or after so many iterations of the filter.",
    ),
    image(
        "unshadowed*",
        "flux-weighted luminance",
        RGBA,
        "The unshadowed estimate U of the same samples; S / U is the shadow.",
    ),
    image("direct", RADIANCE, RGBA, "Outgoing radiance due to direct light, shadows included."),
    image("radiance", RADIANCE, RGBA, "The frame in linear radiance; A is the share of its samples that was taken."),
    image("reference_sum", LIGHTING, RGBA, "Running sum of a reference technique; A is the share of its samples."),
    image(
        "reference_lighting",
        LIGHTING,
        RGBA,
        "Indirect light of a reference technique; A is the share of its samples that was taken.",
    ),
    image(
        "accumulated_sum",
        RADIANCE,
        RGBA,
        "Sum of the frames so far, each weighted by the share of its samples; A is the sum of the weights.",
    ),
    image("accumulated_mean", RADIANCE, RGBA, "The picture in linear radiance, the mean of the frames so far."),
    image("view_values", "those of the view, docs/views.md", RGBA, "The numbers that a view shows in colours."),
    image("level_mix", "1", RGBA, "The colour of each pixel in the view of the level weights."),
    buffer(
        "view_scale",
        "those of the view",
        contents::exposure,
        "The number at the upper end of a view's colour scale.",
    ),
    buffer(
        "direct_exposure",
        "1 / radiance",
        contents::exposure,
        "The exposure of the direct light under the points of a view.",
    ),
    buffer("exposure", "1 / radiance", contents::exposure, "The factor on the radiance before tone mapping."),
    image("picture", "0 to 255", RGBA, "The tone-mapped picture, sRGB."),
];

/// Meanings of the files that are no resource of the graph.
pub mod others {
    /// Blending radii.
    pub const BLENDING_RADII: (&str, &str, &str) =
        ("blending_radii", "metres", "Blending radius of each merged light: alpha times the cell edge of its level.");
    /// Triangles.
    pub const TRIANGLES: (&str, &str, &str) = (
        "triangles",
        "metres",
        "The scene's triangles in the order of the BVH's leaves: first corner, two edges, material.",
    );
    /// Materials.
    pub const MATERIALS: (&str, &str, &str) = (
        "materials",
        "1",
        "The scene's materials as traced rays see them; albedo_layer is 4294967295 without a texture.",
    );
    /// Lights.
    pub const PUNCTUAL_LIGHTS: (&str, &str, &str) = (
        "punctual_lights",
        "metres; irradiance (kind 0, directional) or radiant intensity (1 point, 2 spot)",
        "The lights of the scene file, directional and spot lights first.",
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    const DOCS: &str = include_str!("../../../docs/dumps.md");

    #[test]
    fn every_entry_is_documented_and_is_reached() {
        for listed in TABLE {
            let name = listed.name.trim_end_matches('*');
            assert!(listed.meaning.ends_with('.') && !listed.units.is_empty(), "{name}");
            let row = format!("| {} |", listed.meaning);
            let documented = DOCS.lines().any(|l| l.starts_with(&format!("| `{}` ", listed.name)) && l.ends_with(&row));
            assert!(documented, "{name} is missing in docs/dumps.md, or is described differently there");
            assert_eq!(entry(name).map(|e| e.name), Some(listed.name), "{name} is hidden by an entry before it");
        }
        assert!(entry("no such resource").is_none());
    }
}
