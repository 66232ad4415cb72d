//! Materials, and the images they need: each decoded once, on all cores.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::Cursor;
use std::sync::mpsc;

use ::gltf::json::Index;
use ::gltf::json::material::{AlphaMode, Material as JsonMaterial};
use ::gltf::json::texture::{Texture as JsonTexture, WrappingMode};
use ::gltf::json::validation::Checked;
use image::{ImageFormat, ImageReader, Limits};
use rayon::prelude::*;

use super::gltf_buffers::{Document, shorten};
use super::{Material, Texture};
use crate::Result;

/// The largest width and height of an image.
const MAX_IMAGE_SIZE: u32 = 16_384;
/// The most memory a decoder may take for one image, in bytes.
const MAX_IMAGE_MEMORY: u64 = 2 << 30;

/// Everything unusual about materials that is worth one line at the end.
#[derive(Default)]
struct Oddities {
    blend: bool,
    second_uv: bool,
    wrapping: bool,
    no_image: bool,
    emission: bool,
}

/// All materials, with textures as indices into the returned list of glTF image indices.
pub(super) fn materials(document: &Document) -> Result<(Vec<Material>, Vec<usize>)> {
    let (mut images, mut odd) = (Images::default(), Oddities::default());
    let list = &document.root.materials;
    let materials =
        list.iter().enumerate().map(|(i, m)| material(document, i, m, &mut images, &mut odd)).collect::<Result<_>>()?;
    let transform = document.root.extensions_used.iter().any(|e| e == "KHR_texture_transform");
    let notes = [
        (odd.blend, "blended transparency (cut out at alpha 0.5)"),
        (odd.second_uv || transform, "texture transforms and second texture coordinates"),
        (odd.wrapping, "texture wrap modes other than repeat"),
        (odd.no_image, "textures without a png or jpeg image"),
        (odd.emission, "emission"),
    ];
    notes.iter().filter(|(seen, _)| *seen).for_each(|(_, note)| document.ignore(*note));
    Ok((materials, images.order))
}

/// Whether a material shines by itself.
pub(super) fn emits(material: &JsonMaterial) -> bool {
    material.emissive_factor.0.iter().any(|channel| *channel > 0.0)
}

/// The material of primitives that name none.
pub(super) fn default_material() -> Material {
    Material {
        name: "default".into(),
        base_color: [1.0; 4],
        base_color_texture: None,
        normal_texture: None,
        normal_scale: 1.0,
        alpha_cutoff: None,
        double_sided: false,
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

fn material(
    document: &Document,
    i: usize,
    json: &JsonMaterial,
    images: &mut Images,
    odd: &mut Oddities,
) -> Result<Material> {
    let pbr = &json.pbr_metallic_roughness;
    let mut texture = |info: Option<(Index<JsonTexture>, u32)>| -> Result<Option<u32>> {
        let Some((index, set)) = info else { return Ok(None) };
        odd.second_uv |= set != 0;
        Ok(image_of(document, i, index, odd)?.map(|image| images.slot(image)))
    };
    let base_color_texture = texture(pbr.base_color_texture.as_ref().map(|t| (t.index, t.tex_coord)))?;
    let normal_texture = texture(json.normal_texture.as_ref().map(|t| (t.index, t.tex_coord)))?;
    let normal_scale = json.normal_texture.as_ref().map_or(1.0, |t| t.scale);
    odd.emission |= emits(json);
    let base_color = pbr.base_color_factor.0;
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
        normal_texture,
        normal_scale,
        alpha_cutoff,
        double_sided: json.double_sided,
    })
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
    if let Some(sampler) = texture.sampler.and_then(|s| document.root.samplers.get(s.value())) {
        let repeat = |mode: &Checked<WrappingMode>| matches!(mode, Checked::Valid(WrappingMode::Repeat));
        odd.wrapping |= !repeat(&sampler.wrap_s) || !repeat(&sampler.wrap_t);
    }
    let image = texture.source.value();
    if image == u32::MAX as usize {
        odd.no_image = true; // only an extension's image
        return Ok(None);
    }
    if image >= document.root.images.len() {
        return Err(document.error(format_args!("texture {i} refers to image {image}, which does not exist")));
    }
    Ok(Some(image))
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
    for slot in materials.iter_mut().flat_map(|m| [&mut m.base_color_texture, &mut m.normal_texture]).flatten() {
        *slot = slots[*slot as usize];
    }
    let total = unique.len() as u64;
    let decode = |item: &&(String, Cow<[u8]>)| {
        // A fault of a decoder must not take the program down with it.
        std::panic::catch_unwind(|| decode_image(&item.0, &item.1)).unwrap_or_else(|_| Err("the decoder failed".into()))
    };
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

fn decode_image(name: &str, bytes: &[u8]) -> std::result::Result<Texture, String> {
    let format = image::guess_format(bytes).map_err(|_| "it is neither png nor jpeg".to_owned())?;
    if !matches!(format, ImageFormat::Png | ImageFormat::Jpeg) {
        return Err(format!("{format:?} images are not supported"));
    }
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_IMAGE_SIZE);
    limits.max_image_height = Some(MAX_IMAGE_SIZE);
    limits.max_alloc = Some(MAX_IMAGE_MEMORY);
    reader.limits(limits);
    let pixels = reader.decode().map_err(|e| e.to_string())?.into_rgba8();
    let (width, height) = pixels.dimensions();
    if width == 0 || height == 0 {
        return Err("it has no pixels".into());
    }
    Ok(Texture { name: name.to_owned(), width, height, rgba: pixels.into_raw() })
}
