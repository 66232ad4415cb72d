//! Materials, and the images they need: each decoded once, on all cores.

use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::mpsc;

use ::gltf::json::Index;
use ::gltf::json::material::{AlphaMode, Material as JsonMaterial};
use ::gltf::json::texture::{Info, MagFilter, MinFilter, Texture as JsonTexture, WrappingMode};
use ::gltf::json::validation::Checked;
use rayon::prelude::*;
use serde::Deserialize;

use super::gltf_buffers::{Document, shorten};
use super::gltf_images::{announced_bytes, decode_image};
use super::gltf_mapping::{Mapping, Slot};
use super::sampling::{Filter, Sampling, Wrap};
use super::{Material, Texture};
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

/// All materials, with textures as indices into the returned list of glTF image indices. Their texture coordinates are those
/// of `mappings`.
pub(super) fn materials(document: &Document, mappings: &[Mapping]) -> Result<(Vec<Material>, Vec<usize>)> {
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

/// Images in the order of first use.
#[derive(Default)]
struct Images {
    order: Vec<usize>,
    slots: HashMap<usize, u32>,
}

impl Images {
    fn slot(&mut self, image: usize) -> u32 {
        *self.slots.entry(image).or_insert_with(|| {
            self.order.push(image);
            self.order.len() as u32 - 1
        })
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
        Ok(image_of(document, i, texture, odd)?.map(|image| images.slot(image)))
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

/// The glTF image behind a texture, if it has one.
fn image_of(
    document: &Document,
    material: usize,
    index: Index<JsonTexture>,
    odd: &mut Oddities,
) -> Result<Option<usize>> {
    let i = index.value();
    let Some(texture) = document.root.textures.get(i) else {
        return Err(document.error(format_args!("material {material} refers to texture {i}, which does not exist")));
    };
    let Some(image) = source(document, i, texture)? else {
        odd.no_image = true;
        return Ok(None);
    };
    if image >= document.root.images.len() {
        return Err(document.error(format_args!("texture {i} refers to image {image}, which does not exist")));
    }
    Ok(Some(image))
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

/// The most that all textures may take as texels, in bytes: well-packed files hold a thousand times their length.
const MAX_TEXTURE_BYTES: u64 = 16 << 30;

/// Extensions by which a texture has an image of another format.
const IMAGE_EXTENSIONS: [&str; 2] = ["EXT_texture_webp", "MSFT_texture_dds"];

/// A texture's image: its own, or else that of an extension.
fn source(document: &Document, i: usize, texture: &JsonTexture) -> Result<Option<usize>> {
    #[derive(Deserialize)]
    struct Source {
        source: Option<u32>,
    }
    let own = texture.source.value();
    if own != u32::MAX as usize {
        return Ok(Some(own));
    }
    let others = texture.extensions.as_ref().map(|e| &e.others);
    for name in IMAGE_EXTENSIONS {
        let found = document.extension::<Source>(&format_args!("texture {i}"), others, name)?;
        if let Some(source) = found.and_then(|found| found.source) {
            return Ok(Some(source as usize));
        }
    }
    Ok(None)
}

/// Decodes the images, byte-identical files once, and points the materials at the result.
pub(super) fn decode_images(
    document: &Document,
    images: &[usize],
    materials: &mut [Material],
    progress: &dyn Fn(&str, u64, u64),
) -> Result<Vec<Texture>> {
    let encoded: Vec<(String, Cow<[u8]>)> =
        images.iter().map(|image| read_image(document, *image)).collect::<Result<_>>()?;
    let mut seen: HashMap<&[u8], u32> = HashMap::new();
    let mut unique: Vec<&(String, Cow<[u8]>)> = Vec::new();
    let mut slots = Vec::with_capacity(encoded.len());
    for item in &encoded {
        slots.push(*seen.entry(item.1.as_ref()).or_insert_with(|| {
            unique.push(item);
            unique.len() as u32 - 1
        }));
    }
    for slot in materials.iter_mut().flat_map(textures_of).flatten() {
        *slot = slots[*slot as usize];
    }
    let announced = unique.iter().fold(0_u64, |sum, item| sum.saturating_add(announced_bytes(&item.1)));
    if announced > MAX_TEXTURE_BYTES {
        let [has, most] = [announced, MAX_TEXTURE_BYTES].map(|bytes| bytes >> 30);
        return Err(document.error(format_args!("its textures are {has} GiB of texels, and {most} are the most")));
    }
    let total = unique.len() as u64;
    let decode = |item: &&(String, Cow<[u8]>)| decode_image(&item.0, &item.1);
    progress("textures", 0, total);
    let mut decoded = Vec::new();
    rayon::in_place_scope(|scope| {
        let (sender, receiver) = mpsc::channel();
        scope.spawn(|_| {
            let textures = unique.par_iter().map_with(sender, |sender, item| {
                let texture = decode(item);
                // Nobody listens only when the other thread is on its way out.
                let _ = sender.send(());
                texture
            });
            decoded = textures.collect();
        });
        for (done, ()) in receiver.iter().enumerate() {
            progress("textures", done as u64 + 1, total);
        }
    });
    let named = decoded.into_iter().zip(&unique);
    named
        .map(|(t, (name, _))| t.map_err(|e| document.error(format_args!("texture `{name}` is unreadable: {e}"))))
        .collect()
}

fn textures_of(material: &mut Material) -> [&mut Option<u32>; 3] {
    [&mut material.base_color_texture, &mut material.normal_texture, &mut material.emission_texture]
}

/// An image's name and its file's bytes.
fn read_image<'a>(document: &'a Document, index: usize) -> Result<(String, Cow<'a, [u8]>)> {
    let image = &document.root.images[index];
    let what = format!("image {index}");
    let plain = || image.name.clone().unwrap_or_else(|| what.clone());
    match (&image.uri, image.buffer_view) {
        (Some(uri), _) => {
            let name = if uri.starts_with("data:") { plain() } else { shorten(uri).to_owned() };
            Ok((name, Cow::Owned(document.fetch(&format!("texture {what}"), uri)?)))
        }
        (None, Some(view)) => Ok((plain(), Cow::Borrowed(document.view(&what, view)?.0))),
        (None, None) => Err(document.error(format_args!("{what} has neither a uri nor a buffer view"))),
    }
}
