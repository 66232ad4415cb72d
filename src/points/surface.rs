//! The triangles of a scene as points are spread over them: where they are, and what colour is seen there.

use glam::{Vec2, Vec3, Vec4};

use crate::scene::albedo_array::{mip_chains, sample_texture};
use crate::scene::upload::MipChain;
use crate::scene::{Scene, Texture};

/// A scene with the mips of its base-colour textures.
pub(super) struct Surface<'a> {
    scene: &'a Scene,
    /// Mips by texture, of those that materials take their base colour from.
    mips: Vec<Option<MipChain>>,
}

/// A triangle's corners.
#[derive(Clone, Copy)]
pub(super) struct Triangle {
    corners: [Vec3; 3],
    uvs: [Vec2; 3],
    colors: [Vec4; 3],
    material: usize,
}

impl<'a> Surface<'a> {
    pub fn new(scene: &'a Scene) -> Self {
        let mut used: Vec<u32> = scene.materials.iter().filter_map(|material| material.base_color_texture).collect();
        used.sort_unstable();
        used.dedup();
        used.retain(|index| (*index as usize) < scene.textures.len());
        let jobs: Vec<(&Texture, bool)> = used.iter().map(|index| (&scene.textures[*index as usize], true)).collect();
        let mut mips = vec![None; scene.textures.len()];
        for (index, chain) in used.iter().zip(mip_chains(&jobs)) {
            mips[*index as usize] = Some(chain);
        }
        Self { scene, mips }
    }

    /// The triangles alone.
    pub fn without_textures(scene: &'a Scene) -> Self {
        Self { scene, mips: Vec::new() }
    }

    pub fn triangle_count(&self) -> usize {
        self.scene.triangle_materials.len()
    }

    pub fn triangle(&self, index: usize) -> Triangle {
        let vertices = [0, 1, 2].map(|corner| self.scene.vertices[self.scene.indices[3 * index + corner] as usize]);
        Triangle {
            corners: vertices.map(|vertex| vertex.position_ws.into()),
            uvs: vertices.map(|vertex| vertex.uv.into()),
            colors: vertices.map(|vertex| vertex.color_factor()),
            material: self.scene.triangle_materials[index] as usize,
        }
    }

    /// Whether something is to be seen at a point of a triangle, and not a hole.
    pub fn is_visible(&self, triangle: &Triangle, barycentrics: Vec2) -> bool {
        let material = &self.scene.materials[triangle.material];
        let Some(cutoff) = material.alpha_cutoff else { return true };
        self.base_color(triangle, barycentrics, 0.0).w >= cutoff
    }

    /// Diffuse albedo about a point of a triangle, as a disc of this area has it.
    pub fn albedo(&self, triangle: &Triangle, barycentrics: Vec2, disc_area: f32) -> Vec3 {
        self.base_color(triangle, barycentrics, disc_area).truncate().clamp(Vec3::ZERO, Vec3::ONE)
    }

    fn base_color(&self, triangle: &Triangle, barycentrics: Vec2, disc_area: f32) -> Vec4 {
        let material = &self.scene.materials[triangle.material];
        let vertex_color = if material.has_vertex_colors { at(triangle.colors, barycentrics) } else { Vec4::ONE };
        let factor = Vec4::from(material.base_color) * vertex_color;
        let mips = material.base_color_texture.and_then(|index| self.mips.get(index as usize)?.as_ref());
        let Some(mips) = mips else { return factor };
        let [a, b, c] = triangle.uvs;
        let (width, height, _) = mips[0];
        let texels = 0.5 * (b - a).perp_dot(c - a).abs() * width as f32 * height as f32;
        // As many texels of the first level as lie in the disc make one of the level that is wanted.
        let texels_in_disc = texels * disc_area / triangle.area() as f32;
        let level = (0.5 * texels_in_disc.log2()).round().clamp(0.0, (mips.len() - 1) as f32);
        factor * sample_texture(&mips[level as usize], at(triangle.uvs, barycentrics), material.base_color_sampling)
    }
}

/// Between three corners.
fn at<T>([a, b, c]: [T; 3], barycentrics: Vec2) -> T
where
    T: Copy + std::ops::Add<Output = T> + std::ops::Sub<Output = T> + std::ops::Mul<f32, Output = T>,
{
    a + (b - a) * barycentrics.x + (c - a) * barycentrics.y
}

impl Triangle {
    pub fn area(&self) -> f64 {
        let [a, b, c] = self.corners.map(Vec3::as_dvec3);
        0.5 * (b - a).cross(c - a).length()
    }

    /// Unit normal towards where the corners are counter-clockwise; zero where there is none.
    pub fn normal(&self) -> Vec3 {
        let [a, b, c] = self.corners.map(Vec3::as_dvec3);
        (b - a).cross(c - a).normalize_or_zero().as_vec3()
    }

    pub fn position(&self, barycentrics: Vec2) -> Vec3 {
        at(self.corners, barycentrics)
    }
}
