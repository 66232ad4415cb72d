//! Which variants each shader file is compiled into. A file not listed here has one variant: itself.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// Pipeline stage, from the file name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stage {
    /// `*.vert.glsl`
    Vertex,
    /// `*.frag.glsl`
    Fragment,
    /// `*.comp.glsl`
    Compute,
}

/// One compilation of one file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Variant {
    /// `folder/verb_noun[_suffix].stage`.
    pub name: String,
    /// Pipeline stage.
    pub stage: Stage,
    /// Preprocessor symbols set for this variant.
    pub defines: Vec<(&'static str, &'static str)>,
}

/// Name suffix and defines of one variant.
type VariantSpec = (&'static str, &'static [(&'static str, &'static str)]);

/// Files with several variants. Features that change which SPIR-V capabilities a module needs must be
/// variants; everything else is a specialization constant.
const VARIANTS: &[(&str, &[VariantSpec])] = &[
    ("atrous/filter_shadows.comp.glsl", FILTERS),
    ("cache_gather/shade_tiles.comp.glsl", CACHES),
    ("descent/draw_representatives.comp.glsl", ROUNDS),
    ("emitter_light/sample_emitters.comp.glsl", RAYS),
    ("gbuffer/draw_scene.frag.glsl", SURFACES),
    ("gbuffer/draw_scene.vert.glsl", MOVING_VERTICES),
    ("half_picture/pick_pixels.comp.glsl", WITH_MOTION),
    ("exclusive_scan/reduce_blocks.comp.glsl", SCANNED),
    ("exclusive_scan/scan_blocks.comp.glsl", SCANNED),
    ("light_gather/shade_tiles.comp.glsl", GATHERS),
    ("light_starts/find_starts.comp.glsl", RAYS),
    ("light_volumes/shade_light_volume.frag.glsl", RESERVOIR_MODES),
    ("light_volumes/shade_top_level.frag.glsl", RESERVOIR_MODES),
    ("shadow_rays/trace_shadow_rays.comp.glsl", RAYS_OF_ROUNDS),
    ("temporal/blend.comp.glsl", BLENDS),
    ("temporal/reproject.comp.glsl", HISTORIES),
    ("vpl_trace/trace_paths.comp.glsl", RAYS),
    ("direct_light/shade_direct.comp.glsl", RAYS),
    ("environment_light/sample_environment.comp.glsl", RAYS),
    ("inspect/inspect_pixel.comp.glsl", INSPECTIONS),
    ("brute_force/shade_all.comp.glsl", RAYS),
    ("point_cut/drop_hidden.comp.glsl", RAYS),
    ("micro_buffers/choose_leaves.comp.glsl", RAYS),
    ("micro_buffers/trace_texels.comp.glsl", TRACED_TEXELS),
    ("micro_buffers/splat_points.comp.glsl", KEEPING),
    ("point_reuse/keep_light.comp.glsl", MICRO_FILLS),
    ("point_light/light_primaries.comp.glsl", LIT_BY),
    ("point_light/light_secondaries.comp.glsl", MICRO_BUFFERS),
    ("path_trace/trace_pixels.comp.glsl", RAYS),
    ("pbgi_reference/gather_pixels.comp.glsl", RAYS),
    ("tests/fill_texels.comp.glsl", DIMENSIONS),
    ("tests/sum_texels.comp.glsl", DIMENSIONS),
];

/// A file with only itself as its variant.
const PLAIN: &[VariantSpec] = &[("", &[])];

/// Light of the caches, or which they are.
const CACHES: &[VariantSpec] = &[("", &[]), ("_show", &[("SHOW_CACHES", "1")])];

/// What is summed: set bits, or words as numbers.
const SCANNED: &[VariantSpec] = &[("", &[]), ("_values", &[("SCAN_VALUES", "1")])];

/// Gathering without reservoirs, and with the lights themselves as first level, which needs their lists; further rounds of a
/// frame, of reservoirs alone.
const GATHERS: &[VariantSpec] = &[
    ("", &[]),
    ("_none", &[("RESERVOIR_NONE", "1")]),
    ("_first_level_0", &[("FIRST_LEVEL_0", "1")]),
    ("_first_level_0_none", &[("FIRST_LEVEL_0", "1"), ("RESERVOIR_NONE", "1")]),
    ("_round", &[("ROUND", "1")]),
    ("_first_level_0_round", &[("FIRST_LEVEL_0", "1"), ("ROUND", "1")]),
];

/// `--shadow-samples 0` needs no reservoir, the other modes update it in three ways.
const RESERVOIR_MODES: &[VariantSpec] = &[
    ("_none", &[("RESERVOIR_NONE", "1")]),
    ("_race", &[("RESERVOIR_RACE", "1")]),
    ("_lock", &[("RESERVOIR_LOCK", "1")]),
    ("_exact", &[("RESERVOIR_EXACT", "1")]),
];

/// Vertices alone, or with their motion; they may have moved themselves.
const MOVING_VERTICES: &[VariantSpec] = &[
    ("", &[]),
    ("_motion", &[("FINDS_MOTION", "1")]),
    ("_motion_vertices", &[("FINDS_MOTION", "1"), ("VERTICES_MOVE", "1")]),
];

/// The shadowed estimate alone, or both.
const FILTERS: &[VariantSpec] = &[("", &[]), ("_both", &[("FILTERS_UNSHADOWED", "1")])];

/// The surfaces alone, or with their motion.
const WITH_MOTION: &[VariantSpec] = &[("", &[]), ("_motion", &[("FINDS_MOTION", "1")])];

/// Histories of the shadow estimates, or of the lighting as well.
const HISTORIES: &[VariantSpec] = &[("", &[]), ("_lighting", &[("KEEPS_LIGHTING", "1")])];

/// A frame's shadow samples, or further rounds of them where histories are short.
const ROUNDS: &[VariantSpec] = &[("", &[]), ("_round", &[("ROUND", "1")])];

/// The same; where another one may follow, what takes part in it is listed.
const BLENDS: &[VariantSpec] = &[
    ("", &[]),
    ("_rounds", &[("LISTS_TILES", "1")]),
    ("_round", &[("ROUND", "1"), ("LISTS_TILES", "1")]),
    ("_last_round", &[("ROUND", "1")]),
];

/// A frame's shadow samples, or further rounds of them, and what traces rays.
const RAYS_OF_ROUNDS: &[VariantSpec] = &[
    ("", &[]),
    ("_query", &[("RAY_QUERY", "1")]),
    ("_round", &[("ROUND", "1")]),
    ("_round_query", &[("ROUND", "1"), ("RAY_QUERY", "1")]),
];

/// What traces rays: `--rays bvh`, or `query`.
const RAYS: &[VariantSpec] = &[("", &[]), ("_query", &[("RAY_QUERY", "1")])];

/// What is on the surfaces alone, or with their motion; and in scenes of which something shines or is unlit.
const SURFACES: &[VariantSpec] = &[
    ("", &[]),
    ("_motion", &[("FINDS_MOTION", "1")]),
    ("_emission", &[("EMISSION", "1")]),
    ("_motion_emission", &[("FINDS_MOTION", "1"), ("EMISSION", "1")]),
];

/// What may be kept from the frame before.
const KEEPING: &[VariantSpec] = &[("", &[]), ("_kept", &[("KEEPS_TEXELS", "1")])];

/// The same for what is found by rays.
const TRACED_TEXELS: &[VariantSpec] = &[
    ("", &[]),
    ("_query", &[("RAY_QUERY", "1")]),
    ("_kept", &[("KEEPS_TEXELS", "1")]),
    ("_kept_query", &[("KEEPS_TEXELS", "1"), ("RAY_QUERY", "1")]),
];

/// Light of points depends on the rays that have seen them, or on nothing but the point.
const MICRO_FILLS: &[VariantSpec] = &[("", &[]), ("_points", &[("MICRO_POINTS", "1")])];

/// The first bounce alone, or all of them from the lighting grid hierarchy.
const LIT_BY: &[VariantSpec] = &[
    ("", &[]),
    ("_query", &[("RAY_QUERY", "1")]),
    ("_lights", &[("GATHERS_LIGHTS", "1")]),
    ("_lights_query", &[("GATHERS_LIGHTS", "1"), ("RAY_QUERY", "1")]),
];

/// What fills micro-buffers of the points that need one, or of all leaves: rays, or points, beside rays towards lamps;
/// what they see is kept for more bounces, or all of these come from the lighting grid hierarchy.
const MICRO_BUFFERS: &[VariantSpec] = &[
    ("", &[]),
    ("_query", &[("RAY_QUERY", "1")]),
    ("_leaves", &[("ALL_LEAVES", "1")]),
    ("_leaves_query", &[("ALL_LEAVES", "1"), ("RAY_QUERY", "1")]),
    ("_points", &[("MICRO_POINTS", "1")]),
    ("_points_query", &[("MICRO_POINTS", "1"), ("RAY_QUERY", "1")]),
    ("_keys", &[("KEEPS_KEYS", "1")]),
    ("_keys_query", &[("KEEPS_KEYS", "1"), ("RAY_QUERY", "1")]),
    ("_points_keys", &[("MICRO_POINTS", "1"), ("KEEPS_KEYS", "1")]),
    ("_points_keys_query", &[("MICRO_POINTS", "1"), ("KEEPS_KEYS", "1"), ("RAY_QUERY", "1")]),
    ("_lights", &[("GATHERS_LIGHTS", "1")]),
    ("_lights_query", &[("GATHERS_LIGHTS", "1"), ("RAY_QUERY", "1")]),
    ("_points_lights", &[("MICRO_POINTS", "1"), ("GATHERS_LIGHTS", "1")]),
    ("_points_lights_query", &[("MICRO_POINTS", "1"), ("GATHERS_LIGHTS", "1"), ("RAY_QUERY", "1")]),
];

/// Kinds of images.
const DIMENSIONS: &[VariantSpec] = &[("", &[]), ("_layers", &[("LAYERS", "1")]), ("_volume", &[("VOLUME", "1")])];

/// A pixel's surface alone, or with the lights of the hierarchy and the rays of its shadow samples.
const INSPECTIONS: &[VariantSpec] = &[
    ("", &[]),
    ("_lights", &[("INSPECT_LIGHTS", "1")]),
    ("_lights_query", &[("INSPECT_LIGHTS", "1"), ("RAY_QUERY", "1")]),
];

/// The variants of the shader file at `relative` (path under `shaders/`).
///
/// # Errors
/// When the name does not end in `.vert.glsl`, `.frag.glsl` or `.comp.glsl`.
pub fn variants_of(relative: &str) -> Result<Vec<Variant>> {
    let stem = relative.strip_suffix(".glsl").unwrap_or(relative);
    let (base, stage, end) = [(Stage::Vertex, "vert"), (Stage::Fragment, "frag"), (Stage::Compute, "comp")]
        .into_iter()
        .find_map(|(stage, end)| Some((stem.strip_suffix(end)?.strip_suffix('.')?, stage, end)))
        .ok_or_else(|| Error::file(relative, "not a vertex, fragment or compute shader by its name"))?;
    let specs = VARIANTS.iter().find(|(file, _)| *file == relative).map_or(PLAIN, |(_, specs)| specs);
    Ok(specs
        .iter()
        .map(|(suffix, defines)| Variant { name: format!("{base}{suffix}.{end}"), stage, defines: defines.to_vec() })
        .collect())
}
