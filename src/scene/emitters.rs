//! Triangles that shine by themselves, and how much each of them does. GLSL: `common/emitters.glsl`.

use std::f64::consts::PI;

use glam::{DVec3, Vec2, Vec3};
use rayon::prelude::*;

use super::albedo_array::sample_texture;
use super::upload::MipChain;
use super::{Material, Scene};
use crate::color::luminance_f64;
use crate::shared::Emitter;

/// Most steps along an edge of a triangle at which its texture is looked at.
const MOST_STEPS: f32 = 256.0;

/// The triangles of a scene that shine.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Emitters {
    /// Each with its share of the flux.
    pub list: Vec<Emitter>,
    /// Luminance of the flux of all of them.
    pub flux: f64,
}

impl Emitters {
    /// Finds them. `textures` are the first mips of the scene's textures.
    #[must_use]
    pub fn new(scene: &Scene, textures: &[(bool, MipChain)]) -> Self {
        let shines = |triangle: &usize| scene.materials[scene.triangle_materials[*triangle] as usize].shines();
        let candidates: Vec<usize> = if scene.materials.iter().any(Material::shines) {
            (0..scene.triangle_materials.len()).filter(shines).collect()
        } else {
            Vec::new()
        };
        let fluxes = candidates.par_iter().map(|triangle| (*triangle, flux_of(scene, textures, *triangle)));
        Self::of_fluxes(scene, &fluxes.filter(|(_, flux)| *flux > 0.0).collect::<Vec<_>>())
    }

    fn of_fluxes(scene: &Scene, fluxes: &[(usize, f64)]) -> Self {
        let flux: f64 = fluxes.iter().map(|(_, flux)| flux).sum();
        let mut list: Vec<Emitter> = Vec::with_capacity(fluxes.len());
        let (mut before, mut first) = (0.0, 0.0f32);
        for (triangle, own) in fluxes {
            before += own;
            // Its probability is just that with which shaders find it, rounding included.
            let end = ((before / flux) as f32).min(1.0);
            let probability = end - first;
            if probability > 0.0 {
                let material = scene.triangle_materials[*triangle];
                list.push(Emitter { triangle: *triangle as u32, material, first, probability });
                first = end;
            }
        }
        Self { list, flux }
    }
}

/// Luminance of the flux of a triangle, from both sides where it has two.
fn flux_of(scene: &Scene, textures: &[(bool, MipChain)], triangle: usize) -> f64 {
    let material = &scene.materials[scene.triangle_materials[triangle] as usize];
    let vertices = [0, 1, 2].map(|corner| scene.vertices[scene.indices[3 * triangle + corner] as usize]);
    let [a, b, c] = vertices.map(|vertex| Vec3::from(vertex.position_ws).as_dvec3());
    let area = 0.5 * (b - a).cross(c - a).length();
    let texture = material.emission_texture.and_then(|index| textures.get(index as usize)).map(|(_, mips)| &mips[0]);
    let tint = texture.map_or(DVec3::ONE, |level| mean_color(level, vertices.map(|v| v.uv.into()), material));
    let radiance = DVec3::from(material.emission.map(f64::from)) * tint;
    let sides = if material.double_sided { 2.0 } else { 1.0 };
    PI * area * sides * luminance_f64(radiance.as_vec3().to_array())
}

/// The mean of a texture over a triangle, in steps of half a texel where these are not too many: what is black there has
/// nothing that shines.
fn mean_color(level: &(u32, u32, Vec<u8>), [a, b, c]: [Vec2; 3], material: &Material) -> DVec3 {
    let size = Vec2::new(level.0 as f32, level.1 as f32);
    let longest = ((b - a) * size).length().max(((c - a) * size).length()).max(((c - b) * size).length());
    let steps = (2.0 * longest).ceil().clamp(1.0, MOST_STEPS) as u32;
    let mut sum = DVec3::ZERO;
    let mut count = 0.0;
    for row in 0..steps {
        for column in 0..steps - row {
            // The middles of the small triangles that point the same way as the large one, and of those that do not.
            for (part, inside) in [(1.0 / 3.0, true), (2.0 / 3.0, column + row + 1 < steps)] {
                if inside {
                    let at = (Vec2::new(column as f32, row as f32) + part) / steps as f32;
                    let uv = a + (b - a) * at.x + (c - a) * at.y;
                    sum += sample_texture(level, uv, material.emission_sampling).truncate().as_dvec3();
                    count += 1.0;
                }
            }
        }
    }
    sum / count
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::testing::{box_room, diffuse, plane};

    fn shining(emission: [f32; 3]) -> Material {
        Material { emission, ..diffuse("lamp", Vec3::ONE) }
    }

    #[test]
    fn flux_is_that_of_a_lambertian_surface() {
        let mut scene = plane(2.0);
        assert_eq!(Emitters::new(&scene, &[]), Emitters::default());
        scene.materials[0] = shining([3.0; 3]);
        let emitters = Emitters::new(&scene, &[]);
        assert!((emitters.flux / (PI * 4.0 * 3.0) - 1.0).abs() < 1e-6, "{}", emitters.flux);
        let shares: Vec<f32> = emitters.list.iter().map(|emitter| emitter.probability).collect();
        assert_eq!(shares, [0.5, 0.5]);
        scene.materials[0].double_sided = true;
        let both = Emitters::new(&scene, &[]).flux;
        assert!((both / emitters.flux - 2.0).abs() < 1e-9, "{both}");
        scene.materials[0].is_unlit = true;
        assert_eq!(Emitters::new(&scene, &[]).list, []);
    }

    #[test]
    fn intervals_follow_each_other_and_end_at_one() {
        let mut scene = box_room(1.0, Vec3::ONE);
        scene.materials[0] = shining([0.1, 0.2, 0.3]);
        let list = Emitters::new(&scene, &[]).list;
        assert_eq!(list.len(), 12);
        let mut first = 0.0;
        for emitter in &list {
            assert_eq!(emitter.first.to_bits(), f32::to_bits(first));
            first += emitter.probability;
        }
        assert!((first - 1.0).abs() < 1e-6);
    }

    #[test]
    fn textures_weigh_by_what_they_show_on_a_triangle() {
        let mut scene = plane(2.0);
        scene.materials[0] = Material { emission_texture: Some(0), ..shining([1.0; 3]) };
        // White right of the middle: one triangle has three quarters of it, the other one a quarter.
        let texel = |x: u32| if x < 32 { [0, 0, 0, 255] } else { [255; 4] };
        let rgba: Vec<u8> = (0..64 * 64).flat_map(|i| texel(i % 64)).collect();
        let textures = |rgba: Vec<u8>| [(true, vec![(64, 64, rgba)])];
        let emitters = Emitters::new(&scene, &textures(rgba));
        assert!((emitters.flux / (0.5 * PI * 4.0) - 1.0).abs() < 0.03, "{}", emitters.flux);
        let mut shares: Vec<f32> = emitters.list.iter().map(|emitter| emitter.probability).collect();
        shares.sort_by(f32::total_cmp);
        assert!((shares[1] - 0.75).abs() < 0.01, "{shares:?}");
        let black = Emitters::new(&scene, &textures([0, 0, 0, 255].repeat(64 * 64)));
        assert_eq!(black, Emitters::default(), "what is black does not shine");
    }
}
