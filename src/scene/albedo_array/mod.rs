//! Textures of base colours and emission resampled to the layers of one square texture array, and mip chains; both in linear light.

use std::collections::HashMap;

mod resample;

use rayon::prelude::*;

use super::sampling::Filter;
use super::{Material, Scene, Texture};
use resample::{average, resample};
pub use resample::{mip_chain, sample_texture};

/// Base colours for light paths and alpha tests: every texture at one size.
#[derive(Clone, Debug, PartialEq)]
pub struct AlbedoArray {
    /// Width and height of a layer.
    pub size_px: u32,
    /// RGBA8 layers, colour sRGB encoded, alpha linear, `4 * size_px * size_px` bytes each.
    pub layers: Vec<Vec<u8>>,
    /// For each material the layer of its base-colour texture, if it has one that found a place.
    pub material_layer: Vec<Option<u32>>,
    /// The same for the texture of its emission.
    pub emission_layer: Vec<Option<u32>>,
    /// For each material a linear RGBA factor on top of `base_color`: 1 unless its texture found no place; then the
    /// texture's average colour, with alpha 1 so that a cut-out does not become one large hole.
    pub material_average: Vec<[f32; 4]>,
    /// The same on top of `emission`.
    pub emission_average: Vec<[f32; 4]>,
}

/// Resamples the textures of base colours, then those of emission, to at most `max_layers` layers, in order of first use.
#[must_use]
pub fn build_albedo_array(scene: &Scene, max_layers: u32) -> AlbedoArray {
    let mut slots: HashMap<u32, usize> = HashMap::new();
    // With whether the material that uses it first has its nearest texels.
    let mut used: Vec<(&Texture, bool)> = Vec::new();
    let base_color = |m: &Material| Some((m.base_color_texture?, m.base_color_sampling));
    let emission = |m: &Material| Some((m.emission_texture?, m.emission_sampling));
    let base_colors = scene.materials.iter().filter_map(base_color);
    for (index, sampling) in base_colors.chain(scene.materials.iter().filter_map(emission)) {
        if let Some(texture) = scene.textures.get(index as usize) {
            slots.entry(index).or_insert_with(|| {
                used.push((texture, sampling.magnify == Filter::Nearest));
                used.len() - 1
            });
        }
    }
    let kept = used.len().min(max_layers as usize);
    if kept < used.len() {
        let (all, lost) = (used.len(), used.len() - kept);
        log::warn!("{lost} of {all} textures find no layer: light paths see their average colour");
    }
    let size_px = layer_size(&used[..kept]);
    let layers: Vec<_> =
        used[..kept].par_iter().map(|(texture, nearest)| resample(texture, size_px, *nearest)).collect();
    let averages: Vec<_> = used[kept..].par_iter().map(|(texture, _)| average(texture)).collect();
    let layer = |texture: Option<u32>| {
        let slot = slots.get(&texture?)?;
        (*slot < kept).then_some(*slot as u32)
    };
    let factor = |texture: Option<u32>| {
        let lost = texture.and_then(|index| averages.get(slots.get(&index)?.checked_sub(kept)?));
        lost.map_or([1.0; 4], |[r, g, b, _]| [*r, *g, *b, 1.0])
    };
    let materials = || scene.materials.iter();
    AlbedoArray {
        size_px,
        layers,
        material_layer: materials().map(|m| layer(m.base_color_texture)).collect(),
        emission_layer: materials().map(|m| layer(m.emission_texture)).collect(),
        material_average: materials().map(|m| factor(m.base_color_texture)).collect(),
        emission_average: materials().map(|m| factor(m.emission_texture)).collect(),
    }
}

/// The mip chains of many textures (each with whether it is sRGB encoded), on all cores.
#[must_use]
pub fn mip_chains(textures: &[(&Texture, bool)]) -> Vec<Vec<(u32, u32, Vec<u8>)>> {
    textures.par_iter().map(|(texture, srgb)| mip_chain(texture, *srgb)).collect()
}

/// Smaller the more layers there are, and never beyond the largest texture.
fn layer_size(textures: &[(&Texture, bool)]) -> u32 {
    let by_count = match textures.len() {
        0..=32 => 1024,
        33..=64 => 512,
        65..=256 => 256,
        _ => 128,
    };
    let largest = textures.iter().map(|(t, _)| t.width.max(t.height)).max().unwrap_or(1);
    by_count.min(largest).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::testing::plane;

    fn solid(size: u32, rgba: [u8; 4]) -> Texture {
        let rgba = rgba.repeat((size * size) as usize);
        Texture { name: "solid".into(), width: size, height: size, rgba }
    }

    fn textured(count: u32, size: u32) -> Scene {
        let mut scene = plane(1.0);
        scene.textures = (0..count).map(|i| solid(size, [i as u8, 100, 200, 50])).collect();
        let plain = scene.materials.remove(0);
        scene.materials = (0..count).map(|i| Material { base_color_texture: Some(i), ..plain.clone() }).collect();
        scene.materials.push(plain);
        scene
    }

    #[test]
    fn layers_follow_materials() {
        let mut scene = textured(3, 8);
        scene.materials[1].base_color_texture = Some(2);
        let array = build_albedo_array(&scene, 16);
        assert_eq!((array.size_px, array.layers.len()), (8, 2));
        assert_eq!(array.material_layer, [Some(0), Some(1), Some(1), None]);
        assert_eq!(array.layers[1][..4], [2, 100, 200, 50], "a solid colour survives exactly");
        assert_eq!(array.material_average, [[1.0; 4]; 4]);
    }

    #[test]
    fn overflow_falls_back_to_the_average() {
        let array = build_albedo_array(&textured(3, 4), 2);
        assert_eq!(array.material_layer, [Some(0), Some(1), None, None]);
        let [r, g, b, a] = array.material_average[2];
        assert!((r - 2.0 / 255.0 / 12.92).abs() < 1e-6 && (g - 0.127_44).abs() < 1e-4);
        assert!((b - 0.577_58).abs() < 1e-4 && a == 1.0);
    }

    #[test]
    fn size_depends_on_count_and_sources() {
        let (big, small) = (solid(1024, [0; 4]), solid(16, [0; 4]));
        assert_eq!(layer_size(&[(&big, false); 64]), 512);
        assert_eq!(layer_size(&[(&big, false); 65]), 256);
        assert_eq!(layer_size(&[(&big, false); 257]), 128);
        assert_eq!(layer_size(&[(&small, false); 3]), 16);
        assert_eq!(layer_size(&[]), 1);
    }
}
