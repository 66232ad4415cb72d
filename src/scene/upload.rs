//! What the GPU needs of a scene, as plain data: materials, lights with their share of the light paths,
//! resampled textures. The upload itself is `gpu::SceneSet`.

use super::albedo_array::{AlbedoArray, build_albedo_array, mip_chains};
use super::emitters::Emitters;
use super::sampling::Sampling;
use super::{Light, Material, Scene, Texture};
use crate::environment::upload::PreparedEnvironment;
use crate::shared::{
    GpuMaterial, LIGHT_DIRECTIONAL, LIGHT_EMITTERS, LIGHT_POINT, LIGHT_SPOT, MATERIAL_EMISSION_SHIFT,
    MATERIAL_NORMAL_MAP, MATERIAL_SINGLE_SIDED, MATERIAL_UNLIT, MATERIAL_VERTEX_COLORS, NO_LAYER, PunctualLight,
};

/// Mip levels of one texture: width, height, RGBA8 texels.
pub type MipChain = Vec<(u32, u32, Vec<u8>)>;

/// Scene data in the layouts that shaders read.
pub struct PreparedScene {
    /// One per material.
    pub materials: Vec<GpuMaterial>,
    /// Directional and spot lights, then point lights.
    pub lights: Vec<PunctualLight>,
    /// Lights before the first point light.
    pub first_point_light: u32,
    /// Triangles that shine by themselves, which are the last of the lights together, and the luminance of their flux.
    pub emitters: Emitters,
    /// Something is seen that shines or is unlit.
    pub has_emission: bool,
    /// Flux (luminance) of all lights together.
    pub light_flux: f64,
    /// Light from all around.
    pub environment: PreparedEnvironment,
    /// Small base-colour textures for traced rays.
    pub albedo: AlbedoArray,
    /// Every texture with its mips; whether it is sRGB.
    pub textures: Vec<(bool, MipChain)>,
    /// Per material: textures of base colour, normals and emission, and how they are read.
    pub material_textures: Vec<[(Option<u32>, Sampling); 3]>,
}

/// Prepares a scene for upload.
#[must_use]
pub fn prepare(scene: &Scene, max_array_layers: u32) -> PreparedScene {
    let mut albedo = build_albedo_array(scene, max_array_layers);
    let materials = scene
        .materials
        .iter()
        .enumerate()
        .map(|(index, material)| {
            let layer = albedo.material_layer[index];
            // Without a layer the average colour stands in for the texture.
            let tint = if layer.is_none() && material.base_color_texture.is_some() {
                albedo.material_average[index]
            } else {
                [1.0; 4]
            };
            let glow = albedo.emission_average[index];
            GpuMaterial {
                base_color: std::array::from_fn(|i| material.base_color[i] * tint[i]),
                albedo_layer: layer.unwrap_or(NO_LAYER),
                alpha_cutoff: material.alpha_cutoff.unwrap_or(-1.0),
                normal_scale: material.normal_scale,
                flags: flags(material),
                emission: std::array::from_fn(|i| if material.shines() { material.emission[i] * glow[i] } else { 0.0 }),
                emission_layer: albedo.emission_layer[index].unwrap_or(NO_LAYER),
            }
        })
        .collect();
    if albedo.layers.is_empty() {
        albedo.size_px = 1;
        albedo.layers.push(vec![255; 4]);
    }
    let textures = textures(scene);
    let emitters = Emitters::new(scene, &textures);
    let (lights, light_flux) = lights(scene, emitters.flux);
    let first_point_light = lights.iter().take_while(|l| l.kind != LIGHT_POINT).count() as u32;
    PreparedScene {
        materials,
        lights,
        has_emission: scene.draws.iter().any(|draw| is_seen_by_itself(&scene.materials[draw.material as usize])),
        emitters,
        first_point_light,
        light_flux,
        environment: environment(scene),
        albedo,
        textures,
        material_textures: scene.materials.iter().map(material_textures).collect(),
    }
}

/// Light from all around, all of it where it follows a sun.
#[must_use]
pub fn environment(scene: &Scene) -> PreparedEnvironment {
    let environment = scene.environment.as_deref();
    match environment.filter(|_| scene.sky_sun.is_some_and(|sun| sun.moves)) {
        Some(sky) => PreparedEnvironment::whole(sky),
        None => PreparedEnvironment::new(environment),
    }
}

/// Whether something of a material is seen without light.
fn is_seen_by_itself(material: &Material) -> bool {
    material.is_unlit || material.shines()
}

fn flags(material: &Material) -> u32 {
    let bit = |is: bool, bit: u32| if is { bit } else { 0 };
    bit(material.normal_texture.is_some(), MATERIAL_NORMAL_MAP)
        | bit(material.has_vertex_colors, MATERIAL_VERTEX_COLORS)
        | bit(!material.double_sided, MATERIAL_SINGLE_SIDED)
        | bit(material.is_unlit, MATERIAL_UNLIT)
        | material.base_color_sampling.flags()
        | material.emission_sampling.flags() << MATERIAL_EMISSION_SHIFT
}

fn material_textures(material: &Material) -> [(Option<u32>, Sampling); 3] {
    [
        (material.base_color_texture, material.base_color_sampling),
        (material.normal_texture, material.normal_sampling),
        (material.emission_texture, material.emission_sampling),
    ]
}

/// Mips of every texture; a texture used as normal map is linear.
fn textures(scene: &Scene) -> Vec<(bool, MipChain)> {
    let is_normal = |index: usize| scene.materials.iter().any(|m| m.normal_texture == u32::try_from(index).ok());
    let jobs: Vec<(&Texture, bool)> =
        scene.textures.iter().enumerate().map(|(index, texture)| (texture, !is_normal(index))).collect();
    let mips = mip_chains(&jobs);
    jobs.iter().map(|(_, srgb)| *srgb).zip(mips).collect()
}

/// Lights in upload order, with the share of their light paths that start at each: proportional to its flux while it emits
/// most, so that a light which is dark now has paths when it shines. And that flux of all. Surfaces that shine by themselves,
/// of so much flux together, are the last one where there are any.
#[must_use]
pub fn lights(scene: &Scene, emitter_flux: f64) -> (Vec<PunctualLight>, f64) {
    listed(&scene.lights, scene.motion.brightest_of(&scene.lights), scene.bounds.radius(), emitter_flux)
}

/// `brightest` are the same lights while they emit most.
fn listed<'a>(
    lights: &'a [Light],
    brightest: impl Iterator<Item = &'a Light>,
    scene_radius: f32,
    emitter_flux: f64,
) -> (Vec<PunctualLight>, f64) {
    let both = lights.iter().zip(brightest);
    let mut list: Vec<(PunctualLight, f64)> =
        both.map(|(light, brightest)| (punctual(light), brightest.flux_luminance(scene_radius))).collect();
    list.sort_by_key(|(light, _)| u32::from(light.kind == LIGHT_POINT));
    if emitter_flux > 0.0 {
        list.push((PunctualLight { kind: LIGHT_EMITTERS, ..bytemuck::Zeroable::zeroed() }, emitter_flux));
    }
    let total: f64 = list.iter().map(|(_, flux)| flux).sum();
    let (mut before, count) = (0.0, list.len() as f64);
    for (light, flux) in &mut list {
        // Where all are dark none is preferred.
        let share = if total > 0.0 { *flux / total } else { 1.0 / count };
        before += share;
        light.path_probability = share as f32;
        light.path_cdf = before as f32;
    }
    if let Some((last, _)) = list.last_mut() {
        last.path_cdf = f32::MAX;
    }
    (list.into_iter().map(|(light, _)| light).collect(), total)
}

/// A light as shaders read it.
fn punctual(light: &Light) -> PunctualLight {
    let mut gpu: PunctualLight = bytemuck::Zeroable::zeroed();
    match light {
        Light::Directional { direction_ws, irradiance } => {
            gpu.kind = LIGHT_DIRECTIONAL;
            gpu.direction_ws = direction_ws.to_array();
            gpu.intensity = irradiance.to_array();
        }
        Light::Point { position_ws, intensity } => {
            gpu.kind = LIGHT_POINT;
            gpu.position_ws = position_ws.to_array();
            gpu.intensity = intensity.to_array();
        }
        Light::Spot { position_ws, direction_ws, intensity, inner_cos, outer_cos } => {
            gpu.kind = LIGHT_SPOT;
            gpu.position_ws = position_ws.to_array();
            gpu.direction_ws = direction_ws.to_array();
            gpu.intensity = intensity.to_array();
            (gpu.inner_cos, gpu.outer_cos) = (*inner_cos, *outer_cos);
        }
    }
    gpu
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn point_lights_come_last_and_shares_add_up() {
        let point = |i: f32| Light::Point { position_ws: Vec3::ZERO, intensity: Vec3::splat(i) };
        let sun = Light::Directional { direction_ws: Vec3::NEG_Y, irradiance: Vec3::splat(4.0) };
        let lights = [point(1.0), sun, point(3.0)];
        let (list, flux) = listed(&lights, lights.iter(), 1.0, 0.0);
        assert_eq!(list[0].kind, LIGHT_DIRECTIONAL);
        // Fluxes 4 pi r^2 = 4 pi, 4 pi and 12 pi.
        let shares: Vec<f32> = list.iter().map(|l| l.path_probability).collect();
        for (share, expected) in shares.iter().zip([0.2, 0.2, 0.6]) {
            assert!((share - expected).abs() < 1e-6, "{shares:?}");
        }
        assert!((list[1].path_cdf - 0.4).abs() < 1e-6);
        assert!((flux / (20.0 * std::f64::consts::PI) - 1.0).abs() < 1e-6);
    }
}
