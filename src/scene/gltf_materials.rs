//! Materials, and which images they need.

use ::gltf::json::material::{AlphaMode, Material as JsonMaterial};
use ::gltf::json::texture::{Info, MagFilter, MinFilter, WrappingMode};
use ::gltf::json::validation::Checked;
use serde::Deserialize;

use super::Material;
use super::gltf_buffers::Document;
use super::gltf_mapping::{Mapping, Slot};
use super::gltf_notes::Thing;
use super::gltf_textures::{ImageUse, Images, image_of};
use super::sampling::{Filter, Sampling, Wrap};

/// Emission ends here, so that sums over many triangles stay finite.
const MOST_RADIANCE: f32 = 1e12;
/// Factors up to here are 1 that was rounded.
const MOST_FACTOR: f32 = 1.001;

/// Everything unusual about materials that is worth one line at the end.
#[derive(Default)]
struct Oddities {
    blend: bool,
    unlike: bool,
    far_emission: bool,
}

/// All materials, with textures as indices into the returned list of images. Their texture coordinates are those of
/// `mappings`.
pub(super) fn materials(document: &Document, mappings: &[Mapping]) -> (Vec<Material>, Vec<ImageUse>) {
    let (mut images, mut odd) = (Images::default(), Oddities::default());
    let list = document.root.materials.iter().zip(mappings).enumerate();
    let materials = list.map(|(i, (m, mapping))| material(document, i, m, mapping, &mut images, &mut odd));
    let materials = materials.collect();
    let notes = [
        (odd.blend, "blended transparency (cut out at alpha 0.5)"),
        (odd.unlike, "normal maps that lie otherwise than the base colour"),
        (odd.far_emission, "textures of emission that lie otherwise than the base colour"),
    ];
    notes.iter().filter(|(seen, _)| *seen).for_each(|(_, note)| document.ignore(*note));
    (materials, images.order)
}

/// The material of primitives that name none.
pub(super) fn default_material() -> Material {
    Material {
        name: "default".into(),
        base_color: [1.0; 4],
        base_color_texture: None,
        base_color_sampling: Sampling::default(),
        has_vertex_colors: false,
        normal_texture: None,
        normal_sampling: Sampling::default(),
        normal_scale: 1.0,
        alpha_cutoff: None,
        double_sided: false,
        emission: [0.0; 3],
        emission_texture: None,
        emission_sampling: Sampling::default(),
        is_unlit: false,
    }
}

/// The extension's diffuse surface, which takes the place of the base colour.
#[derive(Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct SpecularGlossiness {
    diffuse_factor: [f32; 4],
    diffuse_texture: Option<Info>,
}

impl Default for SpecularGlossiness {
    fn default() -> Self {
        Self { diffuse_factor: [1.0; 4], diffuse_texture: None }
    }
}

fn thing(i: usize, json: &JsonMaterial) -> Thing {
    Thing::new("material", i, json.name.as_ref())
}

/// Factor and texture of the base colour.
fn base_color(document: &Document, i: usize, json: &JsonMaterial) -> ([f32; 4], Option<Slot>) {
    let others = json.extensions.as_ref().map(|e| &e.others);
    let name = "KHR_materials_pbrSpecularGlossiness";
    if let Some(diffuse) = document.spare_extension::<SpecularGlossiness>(thing(i, json), others, name) {
        return (diffuse.diffuse_factor, diffuse.diffuse_texture.as_ref().map(Slot::of_color));
    }
    let pbr = &json.pbr_metallic_roughness;
    (pbr.base_color_factor.0, pbr.base_color_texture.as_ref().map(Slot::of_color))
}

/// For each material how its textures lie on surfaces: the base colour's way, or else the normal map's or the emission's.
pub(super) fn mappings(document: &Document) -> Vec<Mapping> {
    let mapping = |(i, json): (usize, &JsonMaterial)| {
        let (_, color) = base_color(document, i, json);
        let slot = color.or_else(|| json.normal_texture.as_ref().map(Slot::of_normal));
        let slot = slot.or_else(|| json.emissive_texture.as_ref().map(Slot::of_color));
        slot.map_or_else(Mapping::default, |slot| slot.mapping(document, &thing(i, json)))
    };
    document.root.materials.iter().enumerate().map(mapping).collect()
}

fn material(
    document: &Document,
    i: usize,
    json: &JsonMaterial,
    mapping: &Mapping,
    images: &mut Images,
    odd: &mut Oddities,
) -> Material {
    let thing = thing(i, json);
    let (base_color, color_slot) = base_color(document, i, json);
    let lies_alike = |slot: &Slot| slot.mapping(document, &thing) == *mapping;
    let given = json.normal_texture.as_ref().map(Slot::of_normal);
    let has_normal_map = given.is_some();
    let normal_slot = given.filter(lies_alike);
    odd.unlike |= has_normal_map && normal_slot.is_none();
    let given = json.emissive_texture.as_ref().map(Slot::of_color);
    let has_emission_texture = given.is_some();
    let emission_slot = given.filter(lies_alike);
    odd.far_emission |= has_emission_texture && emission_slot.is_none();
    let sampling_of =
        |slot: &Option<Slot>| slot.as_ref().map_or_else(Sampling::default, |slot| sampling(document, slot));
    let (base_color_sampling, normal_sampling) = (sampling_of(&color_slot), sampling_of(&normal_slot));
    let emission_sampling = sampling_of(&emission_slot);
    let mut texture = |slot: Option<Slot>| -> Option<u32> {
        image_of(document, &thing, slot?.texture).map(|image| images.slot(image))
    };
    let base_color_texture = texture(color_slot);
    let normal_texture = texture(normal_slot);
    let emission = emission(document, i, json);
    // A texture of what does not shine is not worth its memory.
    let emission_slot = emission_slot.filter(|_| emission.iter().any(|channel| *channel > 0.0));
    let emission_texture = texture(emission_slot);
    let normal_scale = json.normal_texture.as_ref().map_or(1.0, |t| t.scale);
    let is_within = |range: std::ops::RangeInclusive<f32>, factors: &[f32]| factors.iter().all(|f| range.contains(f));
    if !is_within(0.0..=MOST_FACTOR, &base_color) {
        document.fault(thing.clone(), "has a base colour that is not within 0 and 1: the nearest is taken");
    }
    if !normal_scale.is_finite() {
        document.fault(thing.clone(), "has a normal map whose scale is not finite: it is 1 instead");
    }
    Material {
        name: json.name.clone().unwrap_or_else(|| format!("material {i}")),
        base_color: base_color.map(|c| c.clamp(0.0, 1.0)),
        base_color_texture,
        base_color_sampling,
        has_vertex_colors: false,
        normal_texture,
        normal_sampling,
        normal_scale: if normal_scale.is_finite() { normal_scale } else { 1.0 },
        alpha_cutoff: alpha_cutoff(document, &thing, json, odd),
        double_sided: json.double_sided,
        emission,
        emission_texture,
        emission_sampling,
        is_unlit: json.extensions.as_ref().is_some_and(|e| e.others.contains_key("KHR_materials_unlit")),
    }
}

/// The least alpha that is there, unless the surface has none.
fn alpha_cutoff(document: &Document, thing: &Thing, json: &JsonMaterial, odd: &mut Oddities) -> Option<f32> {
    match json.alpha_mode {
        Checked::Valid(AlphaMode::Opaque) => None,
        Checked::Valid(AlphaMode::Mask) => {
            let cutoff = json.alpha_cutoff.map_or(0.5, |c| c.0);
            // Above 1 nothing is there, as the specification says.
            if (0.0..=f32::MAX).contains(&cutoff) {
                return Some(cutoff);
            }
            document.fault(thing.clone(), "has an alphaCutoff that is negative or not finite: it is 0.5 instead");
            Some(0.5)
        }
        Checked::Valid(AlphaMode::Blend) => {
            odd.blend = true;
            Some(0.5)
        }
        Checked::Invalid => {
            document.fault(thing.clone(), "has an unknown alphaMode: it is opaque instead");
            None
        }
    }
}

/// Radiance that a material sends out by itself, before its texture: a strength of 1 is a radiance of 1.
fn emission(document: &Document, i: usize, json: &JsonMaterial) -> [f32; 3] {
    #[derive(Deserialize)]
    #[serde(default, rename_all = "camelCase")]
    struct Strength {
        emissive_strength: f32,
    }
    impl Default for Strength {
        fn default() -> Self {
            Self { emissive_strength: 1.0 }
        }
    }
    let others = json.extensions.as_ref().map(|e| &e.others);
    let name = "KHR_materials_emissive_strength";
    let found = document.spare_extension::<Strength>(thing(i, json), others, name);
    let strength = found.unwrap_or_default().emissive_strength;
    let emission = json.emissive_factor.0.map(|factor| factor * strength);
    if emission.iter().all(|channel| (0.0..=MOST_RADIANCE).contains(channel)) {
        return emission;
    }
    let has = format!("has an emission that is negative or above {MOST_RADIANCE:e}: the nearest is taken");
    document.fault(thing(i, json), has);
    // An infinite strength of a factor of 0 is no number.
    emission.map(|channel| if channel.is_nan() { 0.0 } else { channel.clamp(0.0, MOST_RADIANCE) })
}

/// How a texture is read. What a sampler leaves open, or has an unknown value for, is linear and repeats.
fn sampling(document: &Document, slot: &Slot) -> Sampling {
    let Some(texture) = document.root.textures.get(slot.texture.value()) else { return Sampling::default() };
    let Some(index) = texture.sampler.map(|sampler| sampler.value()) else { return Sampling::default() };
    let Some(sampler) = document.root.samplers.get(index) else {
        let has = format!("is read without its sampler: sampler {index} does not exist");
        document.fault(Thing::new("texture", slot.texture.value(), texture.name.as_ref()), has);
        return Sampling::default();
    };
    let knows_all = matches!((&sampler.wrap_s, &sampler.wrap_t), (Checked::Valid(_), Checked::Valid(_)))
        && !matches!(sampler.min_filter, Some(Checked::Invalid))
        && !matches!(sampler.mag_filter, Some(Checked::Invalid));
    if !knows_all {
        let has = "has an unknown filter or wrap mode: it is linear, or repeats, instead";
        document.fault(Thing::new("sampler", index, sampler.name.as_ref()), has);
    }
    let wrap = |mode: &Checked<WrappingMode>| match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
        _ => Wrap::Repeat,
    };
    let (linear, nearest) = (Filter::Linear, Filter::Nearest);
    let (minify, mips) = match sampler.min_filter {
        Some(Checked::Valid(MinFilter::Nearest)) => (nearest, None),
        Some(Checked::Valid(MinFilter::Linear)) => (linear, None),
        Some(Checked::Valid(MinFilter::NearestMipmapNearest)) => (nearest, Some(nearest)),
        Some(Checked::Valid(MinFilter::LinearMipmapNearest)) => (linear, Some(nearest)),
        Some(Checked::Valid(MinFilter::NearestMipmapLinear)) => (nearest, Some(linear)),
        _ => (linear, Some(linear)),
    };
    let magnify = if matches!(sampler.mag_filter, Some(Checked::Valid(MagFilter::Nearest))) { nearest } else { linear };
    Sampling { wrap: [wrap(&sampler.wrap_s), wrap(&sampler.wrap_t)], magnify, minify, mips }
}
