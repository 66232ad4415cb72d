//! Which variants each shader file is compiled into. A file not listed here has one variant: itself.

use crate::error::{Error, Result};

/// Pipeline stage, from the file name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
    ("light_volumes/shade_light_volume.frag.glsl", RESERVOIR_MODES),
    ("light_volumes/shade_top_level.frag.glsl", RESERVOIR_MODES),
    ("shadow_rays/trace_shadow_rays.comp.glsl", SHADOW_RAYS),
    ("vpl_trace/trace_paths.comp.glsl", RAYS),
    ("direct_light/shade_direct.comp.glsl", RAYS),
    ("brute_force/shade_all.comp.glsl", RAYS),
    ("path_trace/trace_pixels.comp.glsl", RAYS),
    ("debug_view/show_chosen_levels.comp.glsl", RESERVOIR_LAYOUTS),
];

/// A file with only itself as its variant.
const PLAIN: &[VariantSpec] = &[("", &[])];

/// `--shadow-samples 0` needs no reservoir, the other modes update it in three ways.
const RESERVOIR_MODES: &[VariantSpec] = &[
    ("_none", &[("RESERVOIR_NONE", "1")]),
    ("_race", &[("RESERVOIR_RACE", "1")]),
    ("_lock", &[("RESERVOIR_LOCK", "1")]),
    ("_exact", &[("RESERVOIR_EXACT", "1")]),
];

/// Readers only care whether a reservoir is a packed 64-bit key or a plain light index.
const RESERVOIR_LAYOUTS: &[VariantSpec] = &[("", &[]), ("_exact", &[("RESERVOIR_EXACT", "1")])];

/// What traces rays: `--rays bvh`, or `query`.
const RAYS: &[VariantSpec] = &[("", &[]), ("_query", &[("RAY_QUERY", "1")])];

/// Both layouts of reservoirs with both kinds of rays.
const SHADOW_RAYS: &[VariantSpec] = &[
    ("", &[]),
    ("_exact", &[("RESERVOIR_EXACT", "1")]),
    ("_query", &[("RAY_QUERY", "1")]),
    ("_exact_query", &[("RESERVOIR_EXACT", "1"), ("RAY_QUERY", "1")]),
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
