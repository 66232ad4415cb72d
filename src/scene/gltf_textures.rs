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
use super::{Material, Texture};
use crate::Result;

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
    otherwise: Otherwise,
}

/// What takes the place of an image that cannot be read.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Otherwise {
    /// The scene is not read.
    Error,
    /// The material goes without the texture.
    Nothing,
    Image(usize),
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

/// The image behind a texture, if it has one.
pub(super) fn image_of(document: &Document, material: usize, index: Index<JsonTexture>) -> Result<Option<ImageUse>> {
    let i = index.value();
    let Some(texture) = document.root.textures.get(i) else {
        return Err(document.error(format_args!("material {material} refers to texture {i}, which does not exist")));
    };
    let plain = plain_source(document, i, texture)?;
    let is_required = document.root.extensions_required.iter().any(|name| name == PREFERRED);
    let found = match extension_source(document, i, texture, PREFERRED)? {
        Some(image) => {
            let otherwise = match plain {
                Some(plain) => Otherwise::Image(plain),
                None if is_required => Otherwise::Error,
                None => Otherwise::Nothing,
            };
            Some(ImageUse { image, otherwise })
        }
        None => plain.map(|image| ImageUse { image, otherwise: Otherwise::Error }),
    };
    for image in found.iter().map(|found| found.image).chain(plain) {
        if image >= document.root.images.len() {
            return Err(document.error(format_args!("texture {i} refers to image {image}, which does not exist")));
        }
    }
    Ok(found)
}

/// A texture's own image, or else that of an extension.
fn plain_source(document: &Document, i: usize, texture: &JsonTexture) -> Result<Option<usize>> {
    let own = texture.source.value();
    if own != u32::MAX as usize {
        return Ok(Some(own));
    }
    for name in IMAGE_EXTENSIONS {
        if let Some(source) = extension_source(document, i, texture, name)? {
            return Ok(Some(source));
        }
    }
    Ok(None)
}

fn extension_source(document: &Document, i: usize, texture: &JsonTexture, name: &str) -> Result<Option<usize>> {
    #[derive(Deserialize)]
    struct Source {
        source: Option<u32>,
    }
    let others = texture.extensions.as_ref().map(|e| &e.others);
    let found = document.extension::<Source>(&format_args!("texture {i}"), others, name)?;
    Ok(found.and_then(|found| found.source).map(|source| source as usize))
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
    let in_place_of = |item: &ImageUse| match item.otherwise {
        Otherwise::Image(other) if decoded.slots[&item.image].is_err() => Some(other),
        _ => None,
    };
    let others: Vec<usize> = images.iter().filter_map(in_place_of).collect();
    decoded.add(document, others.into_iter(), progress)?;
    let slots = images.iter().map(|item| decoded.take(document, *item)).collect::<Result<Vec<_>>>()?;
    for texture in materials.iter_mut().flat_map(textures_of) {
        *texture = texture.and_then(|slot| slots[slot as usize]);
    }
    Ok(decoded.textures)
}

/// Images that have been decoded.
#[derive(Default)]
struct Decoded {
    textures: Vec<Texture>,
    /// By image, its texture or why there is none.
    slots: HashMap<usize, Result<u32>>,
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
                Err(error) => drop(self.slots.insert(image, Err(error))),
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
            let unreadable = |reason| document.error(format_args!("texture `{name}` is unreadable: {reason}"));
            self.slots.insert(*image, results[place].clone().map_err(unreadable));
        }
        Ok(())
    }

    /// The texture of an image, or that which takes its place, with a warning.
    fn take(&mut self, document: &Document, item: ImageUse) -> Result<Option<u32>> {
        let error = match &self.slots[&item.image] {
            Ok(slot) => return Ok(Some(*slot)),
            Err(error) => error.to_string(),
        };
        match item.otherwise {
            Otherwise::Error => self.slots.remove(&item.image).transpose(),
            Otherwise::Nothing => {
                document.warn(format!("{error}; the texture is left out"));
                Ok(None)
            }
            Otherwise::Image(other) => {
                document.warn(format!("{error}; the other image of the texture is used"));
                self.take(document, ImageUse { image: other, otherwise: Otherwise::Error })
            }
        }
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

/// An image's name and its file's bytes.
fn read_image<'a>(document: &'a Document, index: usize) -> Result<(String, Cow<'a, [u8]>)> {
    let image = &document.root.images[index];
    let what = format!("image {index}");
    let plain = || image.name.clone().unwrap_or_else(|| what.clone());
    match (&image.uri, image.buffer_view) {
        (Some(uri), _) => {
            let name = if gltf_files::data_of(uri).is_some() { plain() } else { uri.clone() };
            Ok((name, Cow::Owned(document.fetch(&format!("texture {what}"), uri)?)))
        }
        (None, Some(view)) => Ok((plain(), Cow::Borrowed(document.view(&what, view)?.0))),
        (None, None) => Err(document.error(format_args!("{what} has neither a uri nor a buffer view"))),
    }
}
