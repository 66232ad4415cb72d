//! Materials, and which images they need.

use ::gltf::json::material::{AlphaMode, Material as JsonMaterial};
use ::gltf::json::texture::{Info, MagFilter, MinFilter, WrappingMode};
use ::gltf::json::validation::Checked;
use serde::Deserialize;

use super::Material;
use super::gltf_buffers::Document;
use super::gltf_mapping::{Mapping, Slot};
use super::gltf_textures::{ImageUse, Images, image_of};
use super::sampling::{Filter, Sampling, Wrap};
use crate::Result;

/// Emission ends here, so that sums over many triangles stay finite.
const MOST_RADIANCE: f32 = 1e12;

/// Everything unusual about materials that is worth one line at the end.
#[derive(Default)]
struct Oddities {
    blend: bool,
    unlike: bool,
    no_image: bool,
    far_emission: bool,
}

/// All materials, with textures as indices into the returned list of images. Their texture coordinates are those of
/// `mappings`.
pub(super) fn materials(document: &Document, mappings: &[Mapping]) -> Result<(Vec<Material>, Vec<ImageUse>)> {
    let (mut images, mut odd) = (Images::default(), Oddities::default());
    let list = document.root.materials.iter().zip(mappings).enumerate();
    let materials = list.map(|(i, (m, mapping))| material(document, i, m, mapping, &mut images, &mut odd));
    let materials = materials.collect::<Result<_>>()?;
    let notes = [
        (odd.blend, "blended transparency (cut out at alpha 0.5)"),
        (odd.unlike, "normal maps that lie otherwise than the base colour"),
        (odd.no_image, "textures without an image that can be read"),
        (odd.far_emission, "textures of emission that lie otherwise than the base colour"),
    ];
    notes.iter().filter(|(seen, _)| *seen).for_each(|(_, note)| document.ignore(*note));
    Ok((materials, images.order))
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

/// Factor and texture of the base colour.
fn base_color(document: &Document, i: usize, json: &JsonMaterial) -> Result<([f32; 4], Option<Slot>)> {
    let others = json.extensions.as_ref().map(|e| &e.others);
    let name = "KHR_materials_pbrSpecularGlossiness";
    let what = format_args!("material {i}");
    if let Some(diffuse) = document.extension::<SpecularGlossiness>(&what, others, name)? {
        return Ok((diffuse.diffuse_factor, diffuse.diffuse_texture.as_ref().map(Slot::of_color)));
    }
    let pbr = &json.pbr_metallic_roughness;
    Ok((pbr.base_color_factor.0, pbr.base_color_texture.as_ref().map(Slot::of_color)))
}

/// For each material how its textures lie on surfaces: the base colour's way, or else the normal map's or the emission's.
pub(super) fn mappings(document: &Document) -> Result<Vec<Mapping>> {
    let mapping = |(i, json): (usize, &JsonMaterial)| {
        let (_, color) = base_color(document, i, json)?;
        let slot = color.or_else(|| json.normal_texture.as_ref().map(Slot::of_normal));
        let slot = slot.or_else(|| json.emissive_texture.as_ref().map(Slot::of_color));
        slot.map_or(Ok(Mapping::default()), |slot| slot.mapping(document, i))
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
) -> Result<Material> {
    let (base_color, color_slot) = base_color(document, i, json)?;
    let mut normal_slot = json.normal_texture.as_ref().map(Slot::of_normal);
    if let Some(slot) = &normal_slot
        && slot.mapping(document, i)? != *mapping
    {
        odd.unlike = true;
        normal_slot = None;
    }
    let mut emission_slot = json.emissive_texture.as_ref().map(Slot::of_color);
    if let Some(slot) = &emission_slot
        && slot.mapping(document, i)? != *mapping
    {
        odd.far_emission = true;
        emission_slot = None;
    }
    let sampling_of =
        |slot: &Option<Slot>| slot.as_ref().map_or_else(Sampling::default, |slot| sampling(document, slot));
    let (base_color_sampling, normal_sampling) = (sampling_of(&color_slot), sampling_of(&normal_slot));
    let emission_sampling = sampling_of(&emission_slot);
    let mut texture = |slot: Option<Slot>| -> Result<Option<u32>> {
        let Some(Slot { texture, .. }) = slot else { return Ok(None) };
        let image = image_of(document, i, texture)?;
        odd.no_image |= image.is_none();
        Ok(image.map(|image| images.slot(image)))
    };
    let base_color_texture = texture(color_slot)?;
    let normal_texture = texture(normal_slot)?;
    let emission = emission(document, i, json)?;
    // A texture of what does not shine is not worth its memory.
    let emission_slot = emission_slot.filter(|_| emission.iter().any(|channel| *channel > 0.0));
    let emission_texture = texture(emission_slot)?;
    let normal_scale = json.normal_texture.as_ref().map_or(1.0, |t| t.scale);
    let cutoff = json.alpha_cutoff.map_or(0.5, |c| c.0);
    if !normal_scale.is_finite() || !cutoff.is_finite() || base_color.iter().any(|c| !c.is_finite()) {
        return Err(document.error(format_args!("material {i} has a factor that is not finite")));
    }
    let alpha_cutoff = match json.alpha_mode {
        Checked::Valid(AlphaMode::Opaque) => None,
        Checked::Valid(AlphaMode::Mask) => Some(cutoff),
        Checked::Valid(AlphaMode::Blend) => {
            odd.blend = true;
            Some(0.5)
        }
        Checked::Invalid => return Err(document.error(format_args!("material {i} has an unknown alpha mode"))),
    };
    Ok(Material {
        name: json.name.clone().unwrap_or_else(|| format!("material {i}")),
        base_color: base_color.map(|c| c.clamp(0.0, 1.0)),
        base_color_texture,
        base_color_sampling,
        has_vertex_colors: false,
        normal_texture,
        normal_sampling,
        normal_scale,
        alpha_cutoff,
        double_sided: json.double_sided,
        emission,
        emission_texture,
        emission_sampling,
        is_unlit: json.extensions.as_ref().is_some_and(|e| e.others.contains_key("KHR_materials_unlit")),
    })
}

/// Radiance that a material sends out by itself, before its texture: a strength of 1 is a radiance of 1.
fn emission(document: &Document, i: usize, json: &JsonMaterial) -> Result<[f32; 3]> {
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
    let found =
        document.extension::<Strength>(&format_args!("material {i}"), others, "KHR_materials_emissive_strength")?;
    let strength = found.unwrap_or_default().emissive_strength;
    let emission = json.emissive_factor.0.map(|factor| factor * strength);
    if emission.iter().all(|channel| (0.0..=MOST_RADIANCE).contains(channel)) {
        return Ok(emission);
    }
    Err(document
        .error(format_args!("material {i} has an emission that is negative, not finite or above {MOST_RADIANCE}")))
}

/// How a texture is read. What a sampler leaves open, or has an unknown value for, is linear and repeats.
fn sampling(document: &Document, slot: &Slot) -> Sampling {
    let texture = document.root.textures.get(slot.texture.value());
    let sampler = texture.and_then(|texture| document.root.samplers.get(texture.sampler?.value()));
    let Some(sampler) = sampler else { return Sampling::default() };
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
