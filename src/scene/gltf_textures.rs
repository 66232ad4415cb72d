//! Textures: the image of each, decoded once, on all cores.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::sync::mpsc;

use ::gltf::json::Index;
use ::gltf::json::texture::Texture as JsonTexture;
use rayon::prelude::*;
use serde::Deserialize;

use super::gltf_buffers::Document;
use super::gltf_files;
use super::gltf_images::{announced_bytes, decode_image};
use super::gltf_notes::Thing;
use super::{Material, Texture};
use crate::{Error, Result};

/// The most that all textures may take as texels, in bytes: well-packed files hold a thousand times their length.
const MAX_TEXTURE_BYTES: u64 = 16 << 30;

/// The extension whose image stands before a texture's own, which is there for programs that do not read KTX2.
const PREFERRED: &str = "KHR_texture_basisu";
/// Extensions that give an image to a texture without its own.
const IMAGE_EXTENSIONS: [&str; 2] = ["EXT_texture_webp", "MSFT_texture_dds"];

/// The image of a texture, by its index.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct ImageUse {
    image: usize,
    /// The image that takes its place if it cannot be read.
    otherwise: Option<usize>,
}

/// Images in the order of first use.
#[derive(Default)]
pub(super) struct Images {
    pub order: Vec<ImageUse>,
    slots: HashMap<ImageUse, u32>,
}

impl Images {
    pub fn slot(&mut self, image: ImageUse) -> u32 {
        *self.slots.entry(image).or_insert_with(|| {
            self.order.push(image);
            self.order.len() as u32 - 1
        })
    }
}

/// The image behind a texture of a material, if it has one.
pub(super) fn image_of(document: &Document, material: &Thing, index: Index<JsonTexture>) -> Option<ImageUse> {
    let i = index.value();
    let Some(texture) = document.root.textures.get(i) else {
        document.fault(material.clone(), format!("is read without texture {i}, which does not exist"));
        return None;
    };
    let thing = Thing::new("texture", i, texture.name.as_ref());
    let exists = |image: &usize| {
        let exists = *image < document.root.images.len();
        if !exists {
            document.fault(thing.clone(), format!("is read without image {image}, which does not exist"));
        }
        exists
    };
    let plain = plain_source(document, &thing, texture);
    let preferred = extension_source(document, &thing, texture, PREFERRED);
    if plain.or(preferred).is_none() {
        document.ignore("textures without an image that can be read");
    }
    let plain = plain.filter(exists);
    match preferred.filter(exists) {
        Some(image) => Some(ImageUse { image, otherwise: plain }),
        None => plain.map(|image| ImageUse { image, otherwise: None }),
    }
}

/// A texture's own image, or else that of an extension.
fn plain_source(document: &Document, thing: &Thing, texture: &JsonTexture) -> Option<usize> {
    let own = texture.source.value();
    if own != u32::MAX as usize {
        return Some(own);
    }
    IMAGE_EXTENSIONS.iter().find_map(|name| extension_source(document, thing, texture, name))
}

fn extension_source(document: &Document, thing: &Thing, texture: &JsonTexture, name: &str) -> Option<usize> {
    #[derive(Deserialize)]
    struct Source {
        source: Option<u32>,
    }
    let others = texture.extensions.as_ref().map(|e| &e.others);
    let found = document.spare_extension::<Source>(thing.clone(), others, name);
    found.and_then(|found| found.source).map(|source| source as usize)
}

/// Decodes the images, byte-identical files once, and points the materials at the result.
pub(super) fn decode_images(
    document: &Document,
    images: &[ImageUse],
    materials: &mut [Material],
    progress: &dyn Fn(&str, u64, u64),
) -> Result<Vec<Texture>> {
    let mut decoded = Decoded::default();
    decoded.add(document, images.iter().map(|item| item.image), progress)?;
    let in_place_of = |item: &ImageUse| item.otherwise.filter(|_| decoded.slots[&item.image].is_err());
    let others: Vec<usize> = images.iter().filter_map(in_place_of).collect();
    decoded.add(document, others.into_iter(), progress)?;
    let slots: Vec<Option<u32>> = images.iter().map(|item| decoded.take(document, *item)).collect();
    for material in materials {
        let shines_by_texture = material.emission_texture.is_some();
        for texture in textures_of(material) {
            *texture = texture.and_then(|slot| slots[slot as usize]);
        }
        // Where a surface shines is not known without the texture that says so.
        if shines_by_texture && material.emission_texture.is_none() {
            material.emission = [0.0; 3];
        }
    }
    Ok(decoded.textures)
}

/// Images that have been decoded.
#[derive(Default)]
struct Decoded {
    textures: Vec<Texture>,
    /// By image, its texture or why there is none.
    slots: HashMap<usize, std::result::Result<u32, String>>,
    announced_bytes: u64,
}

impl Decoded {
    /// Decodes those images that have not been decoded before.
    fn add(
        &mut self,
        document: &Document,
        images: impl Iterator<Item = usize>,
        progress: &dyn Fn(&str, u64, u64),
    ) -> Result<()> {
        let mut encoded: Vec<(usize, String, Cow<[u8]>)> = Vec::new();
        let mut known: HashSet<usize> = self.slots.keys().copied().collect();
        for image in images.filter(|image| known.insert(*image)) {
            match read_image(document, image) {
                Ok((name, bytes)) => encoded.push((image, name, bytes)),
                Err(why) => drop(self.slots.insert(image, Err(why))),
            }
        }
        let mut seen: HashMap<&[u8], usize> = HashMap::new();
        let mut unique: Vec<(&str, &[u8])> = Vec::new();
        let places: Vec<usize> = encoded
            .iter()
            .map(|(_, name, bytes)| {
                *seen.entry(bytes).or_insert_with(|| {
                    unique.push((name, bytes));
                    unique.len() - 1
                })
            })
            .collect();
        let announced =
            unique.iter().fold(self.announced_bytes, |sum, item| sum.saturating_add(announced_bytes(item.1)));
        if announced > MAX_TEXTURE_BYTES {
            let [has, most] = [announced, MAX_TEXTURE_BYTES].map(|bytes| bytes >> 30);
            return Err(document.error(format_args!("its textures are {has} GiB of texels, and {most} are the most")));
        }
        self.announced_bytes = announced;
        let results = decode_all(&unique, progress).into_iter().map(|result| {
            result.map(|texture| {
                self.textures.push(texture);
                self.textures.len() as u32 - 1
            })
        });
        let results: Vec<std::result::Result<u32, String>> = results.collect();
        for ((image, name, _), place) in encoded.iter().zip(places) {
            let unreadable = |reason| format!("`{name}` is unreadable: {reason}");
            self.slots.insert(*image, results[place].clone().map_err(unreadable));
        }
        Ok(())
    }

    /// The texture of an image, or that which takes its place, with a warning.
    fn take(&self, document: &Document, item: ImageUse) -> Option<u32> {
        let why = match &self.slots[&item.image] {
            Ok(slot) => return Some(*slot),
            Err(why) => why,
        };
        let instead =
            if item.otherwise.is_some() { "the other image of the texture is used" } else { "it is left out" };
        document.unreadable_texture(format!("texture {why}; {instead}"));
        self.take(document, ImageUse { image: item.otherwise?, otherwise: None })
    }
}

/// Decodes images, each with its name, on all cores.
fn decode_all(
    images: &[(&str, &[u8])],
    progress: &dyn Fn(&str, u64, u64),
) -> Vec<std::result::Result<Texture, String>> {
    let total = images.len() as u64;
    let mut decoded = Vec::new();
    if total == 0 {
        return decoded;
    }
    progress("textures", 0, total);
    rayon::in_place_scope(|scope| {
        let (sender, receiver) = mpsc::channel();
        scope.spawn(|_| {
            let textures = images.par_iter().map_with(sender, |sender, (name, bytes)| {
                let texture = decode_image(name, bytes);
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
    decoded
}

fn textures_of(material: &mut Material) -> [&mut Option<u32>; 3] {
    [&mut material.base_color_texture, &mut material.normal_texture, &mut material.emission_texture]
}

/// An image's name and its file's bytes, or why there are none.
fn read_image<'a>(document: &'a Document, index: usize) -> std::result::Result<(String, Cow<'a, [u8]>), String> {
    let image = &document.root.images[index];
    let what = format!("image {index}");
    let plain = || image.name.clone().unwrap_or_else(|| what.clone());
    let reason = |error: Error| match error {
        Error::File { reason, .. } => reason,
        other => other.to_string(),
    };
    match (&image.uri, image.buffer_view) {
        (Some(uri), _) => {
            let name = if gltf_files::data_of(uri).is_some() { plain() } else { uri.clone() };
            Ok((name, Cow::Owned(document.fetch(&what, uri).map_err(reason)?)))
        }
        (None, Some(view)) => Ok((plain(), Cow::Borrowed(document.view(&what, view).map_err(reason)?.0))),
        (None, None) => Err(format!("{what} has neither a uri nor a buffer view")),
    }
}
