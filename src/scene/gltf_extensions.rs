//! The extensions of glTF: which are read, and what a picture lacks without the others.

/// Extensions that are read. Quantised attributes are read like any others.
const READ: [&str; 15] = [
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_animation_pointer",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "MSFT_texture_dds",
];

/// Those of them that only a build with the feature `codecs` reads.
const OF_CODECS: [&str; 6] = [
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_meshopt_compression",
    "KHR_texture_basisu",
    "MSFT_texture_dds",
];
/// What a build without the feature says of a file that needs it.
pub(super) const NEEDS_CODECS: &str =
    "this build lacks the feature `codecs`, which reads that: `cargo build --release` makes one that has it";

/// What the picture is like without an extension that is not read.
const NOT_READ: [(&str, &[&str]); 6] = [
    (
        "every surface is diffuse",
        &[
            "ADOBE_materials_clearcoat_specular",
            "ADOBE_materials_clearcoat_tint",
            "EXT_materials_clearcoat_darkening",
            "EXT_materials_specular_edge_color",
            "KHR_materials_anisotropy",
            "KHR_materials_clearcoat",
            "KHR_materials_ior",
            "KHR_materials_iridescence",
            "KHR_materials_sheen",
            "KHR_materials_specular",
            "MSFT_packing_normalRoughnessMetallic",
            "MSFT_packing_occlusionRoughnessMetallic",
            "NV_materials_mdl",
        ],
    ),
    (
        "no light passes through surfaces",
        &[
            "ADOBE_materials_thin_transparency",
            "KHR_materials_diffuse_transmission",
            "KHR_materials_dispersion",
            "KHR_materials_subsurface",
            "KHR_materials_transmission",
            "KHR_materials_volume",
            "KHR_materials_volume_scatter",
        ],
    ),
    ("materials are those without a variant", &["KHR_materials_variants", "FB_geometry_metadata"]),
    ("textures that only it has are left out", &["EXT_texture_astc", "EXT_texture_avif"]),
    ("its light is missing", &["EXT_lights_ies", "EXT_lights_image_based"]),
    (
        "the picture is as without it",
        &[
            "AGI_articulations",
            "AGI_stk_metadata",
            "CESIUM_primitive_outline",
            "EXT_instance_features",
            "EXT_mesh_features",
            "EXT_mesh_manifold",
            "EXT_mesh_polygon",
            "EXT_mesh_primitive_restart",
            "EXT_structural_metadata",
            "GRIFFEL_bim_data",
            "KHR_accessor_float64",
            "KHR_audio_emitter",
            "KHR_interactivity",
            "KHR_mesh_variants",
            "KHR_node_hoverability",
            "KHR_node_selectability",
            "KHR_physics_rigid_bodies",
            "KHR_xmp",
            "KHR_xmp_json_ld",
            "MPEG_accessor_timed",
            "MPEG_audio_spatial",
            "MPEG_buffer_circular",
            "MPEG_media",
            "MPEG_scene_interactivity",
            "MSFT_lod",
            "OMI_physics_body",
            "OMI_physics_shape",
            "VRM",
            "VRMC_materials_mtoon",
            "VRMC_node_constraint",
            "VRMC_springBone",
            "VRMC_vrm",
        ],
    ),
];

/// Whether a build with or without the feature `codecs` reads an extension.
fn is_read(name: &str, has_codecs: bool) -> bool {
    READ.contains(&name) && (has_codecs || !OF_CODECS.contains(&name))
}

/// Refuses a file that requires an extension that is not read, naming all of them.
pub(super) fn check_required(required: &[&str]) -> Result<(), String> {
    check_required_by(required, cfg!(feature = "codecs"))
}

fn check_required_by(required: &[&str], has_codecs: bool) -> Result<(), String> {
    let unread: Vec<&str> = required.iter().copied().filter(|name| !is_read(name, has_codecs)).collect();
    let is_of_codecs = unread.iter().all(|name| READ.contains(name));
    match unread.as_slice() {
        [] => Ok(()),
        [name] if is_of_codecs => Err(format!("it requires the extension {name}, and {NEEDS_CODECS}")),
        [name] => Err(format!("it requires the extension {name}, which is not supported")),
        [names @ .., last] => {
            let names = names.join(", ");
            let why = if is_of_codecs { format!("and {NEEDS_CODECS}") } else { "which are not supported".to_owned() };
            Err(format!("it requires the extensions {names} and {last}, {why}"))
        }
    }
}

/// For each extension in use that is not read, what that does to the picture: a sentence.
pub(super) fn unread<'a>(used: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut names: Vec<&str> = used.filter(|name| !is_read(name, cfg!(feature = "codecs"))).collect();
    names.sort_unstable();
    names.dedup();
    let of_codecs = |name: &str| OF_CODECS.contains(&name).then_some(NEEDS_CODECS);
    let of_picture = |name: &str| NOT_READ.iter().find(|(_, names)| names.contains(&name)).map(|(effect, _)| *effect);
    let effect = |name| of_codecs(name).or_else(|| of_picture(name)).unwrap_or("what it adds is missing");
    names.iter().map(|name| format!("the extension {name} is not read: {}", effect(name))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_extension_stands_once() {
        let mut names: Vec<&str> = NOT_READ.iter().flat_map(|(_, names)| *names).chain(&READ).copied().collect();
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count);
    }

    #[test]
    fn a_build_without_codecs_names_the_feature() {
        assert!(OF_CODECS.iter().all(|name| READ.contains(name)));
        let others: Vec<&str> = READ.iter().copied().filter(|name| !OF_CODECS.contains(name)).collect();
        assert_eq!(check_required_by(&others, false), Ok(()));
        let sentence = |required: &[&str]| check_required_by(required, false).unwrap_err();
        let [draco, webp] = ["KHR_draco_mesh_compression", "EXT_texture_webp"];
        assert_eq!(sentence(&[draco]), format!("it requires the extension {draco}, and {NEEDS_CODECS}"));
        let both = format!("it requires the extensions {draco} and {webp}, and {NEEDS_CODECS}");
        assert_eq!(sentence(&[draco, "KHR_mesh_quantization", webp]), both);
        let unknown = format!("it requires the extensions {draco} and A, which are not supported");
        assert_eq!(sentence(&[draco, "A"]), unknown);
    }

    #[test]
    fn required_ones_are_refused_together() {
        assert_eq!(check_required_by(&READ, true), Ok(()));
        let error = check_required(&["KHR_mesh_quantization", "A", "B", "C"]).unwrap_err();
        assert_eq!(error, "it requires the extensions A, B and C, which are not supported");
    }

    #[test]
    fn others_are_told_once_with_what_they_do() {
        let used = ["X_y", "KHR_lights_punctual", "KHR_materials_clearcoat", "X_y"];
        let told = unread(used.into_iter());
        assert_eq!(told[0], "the extension KHR_materials_clearcoat is not read: every surface is diffuse");
        assert_eq!(told[1..], ["the extension X_y is not read: what it adds is missing"]);
    }
}
