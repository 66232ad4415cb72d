//! How textures lie on surfaces: which set of texture coordinates, and what `KHR_texture_transform` does to it.

use ::gltf::json::Index;
use ::gltf::json::material::NormalTexture;
use ::gltf::json::texture::{Info, Texture};
use glam::{Affine2, Vec2};
use serde::Deserialize;
use serde_json::{Map, Value};

use super::gltf_buffers::Document;
use super::gltf_notes::Thing;

/// The texture coordinates of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mapping {
    /// The set `TEXCOORD_n`.
    pub set: u32,
    /// From that set to the place in the texture.
    pub uv_from_set: Affine2,
}

impl Default for Mapping {
    fn default() -> Self {
        Self { set: 0, uv_from_set: Affine2::IDENTITY }
    }
}

/// The place of a texture in a material.
pub(super) struct Slot {
    /// The texture.
    pub texture: Index<Texture>,
    set: u32,
    extensions: Map<String, Value>,
}

/// The extension's object.
#[derive(Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct Transform {
    offset: [f32; 2],
    rotation: f32,
    scale: [f32; 2],
    tex_coord: Option<u32>,
}

impl Default for Transform {
    fn default() -> Self {
        Self { offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2], tex_coord: None }
    }
}

impl Slot {
    /// That of a colour.
    pub fn of_color(info: &Info) -> Self {
        let extensions = info.extensions.as_ref().map_or_else(Map::new, |e| e.others.clone());
        Self { texture: info.index, set: info.tex_coord, extensions }
    }

    /// That of a normal map.
    pub fn of_normal(info: &NormalTexture) -> Self {
        let extensions = info.extensions.as_ref().map_or_else(Map::new, |e| e.others.clone());
        Self { texture: info.index, set: info.tex_coord, extensions }
    }

    /// How the texture of a material lies.
    pub fn mapping(&self, document: &Document, material: &Thing) -> Mapping {
        let plain = Mapping { set: self.set, ..Mapping::default() };
        let name = "KHR_texture_transform";
        let found = document.spare_extension::<Transform>(material.clone(), Some(&self.extensions), name);
        let Some(Transform { offset, rotation, scale, tex_coord }) = found else { return plain };
        // Counter-clockwise as the texture is seen, with v downwards.
        let transform = Affine2::from_scale_angle_translation(scale.into(), -rotation, offset.into());
        if !transform.is_finite() {
            document.fault(material.clone(), "has a texture transform that is not finite, which is ignored");
            return plain;
        }
        Mapping { set: tex_coord.unwrap_or(self.set), uv_from_set: transform }
    }
}

impl Mapping {
    /// Maps coordinates of the set in place; those that are not finite become 0.
    pub fn apply(&self, coordinates: &mut [[f32; 2]]) {
        for uv in coordinates {
            let mapped = if self.uv_from_set == Affine2::IDENTITY {
                Vec2::from_array(*uv)
            } else {
                self.uv_from_set.transform_point2(Vec2::from_array(*uv))
            };
            *uv = mapped.to_array().map(|c| if c.is_finite() { c } else { 0.0 });
        }
    }
}
