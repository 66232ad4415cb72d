//! Scenes: what a glTF file becomes before it reaches the GPU. No Vulkan here.
//!
//! Everything is in world space (metres, y up), node transforms already applied.

pub mod albedo_array;
pub mod bvh;
pub mod chunks;
mod default_camera;
pub mod emitters;
pub mod gltf;
mod gltf_accessors;
mod gltf_buffers;
mod gltf_cameras;
#[cfg(feature = "codecs")]
mod gltf_dds;
#[cfg(feature = "codecs")]
mod gltf_draco;
mod gltf_extensions;
mod gltf_files;
mod gltf_glb;
mod gltf_images;
mod gltf_instancing;
mod gltf_json;
mod gltf_lenient;
mod gltf_lights;
mod gltf_mapping;
mod gltf_materials;
mod gltf_mesh;
#[cfg(feature = "codecs")]
mod gltf_meshopt;
mod gltf_nodes;
mod gltf_notes;
mod gltf_parts;
mod gltf_pointers;
mod gltf_tangents;
mod gltf_textures;
#[cfg(feature = "codecs")]
mod ktx2;
pub mod motion;
pub mod octahedral;
pub mod query_geometry;
pub mod refit;
pub mod sampling;
pub mod testing;
pub mod upload;
#[cfg(not(feature = "codecs"))]
mod without_codecs;

use std::sync::Arc;

use glam::{BVec3, Mat4, Vec3, Vec4};

pub use crate::camera::Camera;
use crate::color::luminance;
use crate::environment::Environment;
use motion::Motion;
use sampling::Sampling;
#[cfg(not(feature = "codecs"))]
use without_codecs::{gltf_dds, gltf_draco, gltf_meshopt, ktx2};

/// One vertex in world space, as the GPU reads it (32 bytes, no padding).
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Vertex {
    /// World-space position.
    pub position_ws: [f32; 3],
    /// Unit normal, octahedral, two 16-bit snorm (see `pack_octahedral`).
    pub normal_oct: u32,
    /// Texture coordinates of the material's textures.
    pub uv: [f32; 2],
    /// Linear factor of the base colour, RGBA, of 65535; white where the mesh has none.
    pub color: [u16; 4],
}

impl Vertex {
    /// The colour of vertices without one.
    pub const WHITE: [u16; 4] = [u16::MAX; 4];

    /// The factor of the base colour.
    #[must_use]
    pub fn color_factor(&self) -> Vec4 {
        Vec4::from(self.color.map(f32::from)) / f32::from(u16::MAX)
    }
}

/// A run of indices drawn with one material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Draw {
    /// First index of the run.
    pub first_index: u32,
    /// Number of indices, a multiple of 3.
    pub index_count: u32,
    /// Index into [`Scene::materials`].
    pub material: u32,
}

/// A purely diffuse material.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The glTF name, or `material N`.
    pub name: String,
    /// Linear base-colour factor, RGBA.
    pub base_color: [f32; 4],
    /// Index into [`Scene::textures`], sRGB encoded.
    pub base_color_texture: Option<u32>,
    /// How that texture is read.
    pub base_color_sampling: Sampling,
    /// Whether the colours of its vertices are to be looked at.
    pub has_vertex_colors: bool,
    /// Index into [`Scene::textures`], linear tangent-space normal map.
    pub normal_texture: Option<u32>,
    /// How that texture is read.
    pub normal_sampling: Sampling,
    /// glTF `normalTexture.scale`.
    pub normal_scale: f32,
    /// Below this alpha (texture times factor) the surface is a hole; `None` means opaque.
    pub alpha_cutoff: Option<f32>,
    /// glTF `doubleSided`. Every surface reflects light on both sides; others than these shine in front alone, and
    /// `--back-faces cull` hides their backs from the camera.
    pub double_sided: bool,
    /// Radiance that it sends out by itself, linear RGB: glTF's emissive factor times its strength.
    pub emission: [f32; 3],
    /// Index into [`Scene::textures`], a factor of that, sRGB encoded.
    pub emission_texture: Option<u32>,
    /// How that texture is read.
    pub emission_sampling: Sampling,
    /// It is seen as its base colour, in whatever light (`KHR_materials_unlit`).
    pub is_unlit: bool,
}

impl Material {
    /// Whether it shines by itself, and so lights the scene.
    #[must_use]
    pub fn shines(&self) -> bool {
        !self.is_unlit && self.emission.iter().any(|channel| *channel > 0.0)
    }

    /// Whether it can be meant to be all the light of a scene: a texture of emission no brighter than 1 is a detail, such as the
    /// display of a device, of a model that is to be shown in somebody's light.
    #[must_use]
    pub fn is_lamp(&self) -> bool {
        self.shines() && (self.emission_texture.is_none() || self.emission.iter().any(|channel| *channel > 1.0))
    }
}

/// A decoded texture, RGBA8, row 0 at the top.
#[derive(Clone, PartialEq)]
pub struct Texture {
    /// File name, or the name in the glTF.
    pub name: String,
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// `4 * width * height` bytes.
    pub rgba: Vec<u8>,
}

/// A light of `KHR_lights_punctual`. Colour times intensity, linear RGB.
#[derive(Clone, Debug, PartialEq)]
pub enum Light {
    /// Parallel light.
    Directional {
        /// Unit direction in which the light travels.
        direction_ws: Vec3,
        /// Irradiance on a surface facing the light (glTF lux read as W/m²).
        irradiance: Vec3,
    },
    /// Uniform in all directions.
    Point {
        /// Position.
        position_ws: Vec3,
        /// Radiant intensity (glTF candela read as W/sr).
        intensity: Vec3,
    },
    /// A point light within a cone.
    Spot {
        /// Position.
        position_ws: Vec3,
        /// Unit axis direction in which the light travels.
        direction_ws: Vec3,
        /// Radiant intensity on the axis.
        intensity: Vec3,
        /// Cosine of the inner cone angle.
        inner_cos: f32,
        /// Cosine of the outer cone angle, less than `inner_cos`.
        outer_cos: f32,
    },
}

impl Light {
    /// A light of no power, for scenes that shall have none.
    pub const DARK: Self = Self::Directional { direction_ws: Vec3::NEG_Y, irradiance: Vec3::ZERO };

    /// Whether it has no power.
    #[must_use]
    pub fn is_dark(&self) -> bool {
        let (Self::Directional { irradiance: power, .. }
        | Self::Point { intensity: power, .. }
        | Self::Spot { intensity: power, .. }) = self;
        power.max_element() == 0.0
    }

    /// Flux (luminance) into a scene of this radius.
    pub(crate) fn flux_luminance(&self, scene_radius: f32) -> f64 {
        let pi = std::f64::consts::PI;
        let luminance = |color: &Vec3| f64::from(luminance(*color));
        match self {
            Self::Directional { irradiance, .. } => luminance(irradiance) * pi * f64::from(scene_radius).powi(2),
            Self::Point { intensity, .. } => luminance(intensity) * 4.0 * pi,
            Self::Spot { intensity, outer_cos, .. } => luminance(intensity) * 2.0 * pi * (1.0 - f64::from(*outer_cos)),
        }
    }
}

/// The sun that a sky is made for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkySun {
    /// Towards it, before the sky is turned.
    pub towards: Vec3,
    /// Irradiance on a surface that faces it.
    pub irradiance: Vec3,
    /// The scene's own sun, by its number among the lights; `None` where the sky has brought its sun.
    pub own: Option<usize>,
    /// An animation moves or changes it, and the sky follows.
    pub moves: bool,
}

/// Where the light of a scene's file comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LitBy {
    /// Lights, be they dark.
    Lights,
    /// Emissive surfaces ([`Material::is_lamp`]), without a light.
    EmissiveSurfaces,
    /// Nothing: it leaves that to whoever shows it.
    Nothing,
}

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Smallest corner.
    pub min: Vec3,
    /// Largest corner.
    pub max: Vec3,
}

impl Aabb {
    /// A box of nothing.
    pub(crate) const EMPTY: Self = Self { min: Vec3::MAX, max: Vec3::MIN };

    /// The box that reaches to a point as well.
    pub(crate) fn with(&self, point: Vec3) -> Self {
        Self { min: self.min.min(point), max: self.max.max(point) }
    }

    /// The box around both.
    pub(crate) fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The box around this one, which is not empty, after a transform.
    pub(crate) fn transformed(&self, world: &Mat4) -> Self {
        let corner = |i: u32| {
            let high = BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0);
            world.transform_point3(Vec3::select(high, self.max, self.min))
        };
        (0..8).map(corner).fold(Self::EMPTY, |all, point| all.with(point))
    }

    /// Middle of the box.
    #[must_use]
    pub fn center(&self) -> Vec3 {
        (self.min + self.max) * 0.5
    }

    /// Radius of the sphere around the box: the design's scene radius.
    #[must_use]
    pub fn radius(&self) -> f32 {
        (self.max - self.min).length() * 0.5
    }
}

/// A scene ready for upload. Always has at least one triangle, one camera, one material and one light.
pub struct Scene {
    /// The file stem, or `courtyard` for the built-in scene.
    pub name: String,
    /// All vertices.
    pub vertices: Vec<Vertex>,
    /// Tangents of the vertices up to the last that has one, packed ([`octahedral::pack_tangent`]): where there are normal maps.
    pub tangents: Vec<u32>,
    /// Three per triangle, grouped by [`Draw`].
    pub indices: Vec<u32>,
    /// Material of each triangle (`indices.len() / 3` entries).
    pub triangle_materials: Vec<u32>,
    /// Draws, sorted by material.
    pub draws: Vec<Draw>,
    /// Materials; index 0 always exists.
    pub materials: Vec<Material>,
    /// Decoded textures, each image once however many materials use it.
    pub textures: Vec<Texture>,
    /// Cameras in the order of the file, or one framing camera named `default`.
    pub cameras: Vec<Camera>,
    /// Lights in the order of the file, or one default sun; then those of the environment.
    pub lights: Vec<Light>,
    /// What of its light is the file's.
    pub lit_by: LitBy,
    /// Light from all around, neither turned nor scaled yet.
    pub environment: Option<Arc<Environment>>,
    /// The sun that the environment is a sky for.
    pub sky_sun: Option<SkySun>,
    /// What of it moves.
    pub motion: Motion,
    /// Bounds of all vertices used by triangles, at all moments of the animations that play.
    pub bounds: Aabb,
}

#[cfg(test)]
mod asset_tests;
