//! Twin of `merge/merge_lights`.

use glam::Vec3;

use super::count_lights::LevelTable;
use super::deal_lights::{Deal, SUB_IMAGE_STRIDE};
use super::lights::LightList;
use crate::color::luminance;
use crate::shared::GridLight;

/// The merged list: `sub_images` from [`super::deal_lights::deal_lights`].
#[must_use]
pub fn merge_lights(
    grid_lights: &[GridLight],
    lights: &LightList,
    table: &LevelTable,
    sub_images: &[u32],
    deal: Deal,
) -> Vec<GridLight> {
    let total = sub_images[sub_images.len() - SUB_IMAGE_STRIDE + deal.top_level as usize + 1];
    let mut merged: Vec<GridLight> = vec![bytemuck::Zeroable::zeroed(); total as usize];
    let mut put = |light: GridLight, index: usize, count: usize| {
        let sub_image_count = deal.sub_image_count as usize;
        let first = |sub_image: usize| sub_images[SUB_IMAGE_STRIDE * sub_image + light.level as usize] as usize;
        if count < sub_image_count {
            (0..sub_image_count).for_each(|sub_image| merged[first(sub_image) + index] = light);
            return;
        }
        let scaled = GridLight {
            flux: light.flux.map(|f| f * sub_image_count as f32),
            luminance: light.luminance * sub_image_count as f32,
            weight: light.weight * sub_image_count as f32,
            ..light
        };
        merged[first(index % sub_image_count) + index / sub_image_count] = scaled;
    };
    for (index, light) in grid_lights[..table.range(deal.top_level).end].iter().enumerate() {
        if light.level >= deal.first_level {
            let copy = GridLight { vertex: index as u32, ..*light };
            put(copy, index - table.first(light.level), table.count(light.level));
        }
    }
    if deal.first_level == 0 {
        (0..lights.len()).for_each(|index| put(original_light(lights, index), index, lights.len()));
    }
    merged
}

/// A light of S0 as a light of the hierarchy.
#[must_use]
pub fn original_light(lights: &LightList, index: usize) -> GridLight {
    let flux = lights.flux(index);
    GridLight {
        position_ws: lights.position(index),
        luminance: luminance(flux),
        variance: Vec3::ZERO.to_array(),
        level: 0,
        lobe: lights.normal(index).to_array(),
        weight: 1.0,
        flux: flux.to_array(),
        vertex: index as u32,
    }
}

#[cfg(test)]
mod tests {
    use super::super::deal_lights::deal_lights;
    use super::*;

    #[test]
    fn five_lights_for_four_sub_images() {
        let light = |level: u32, flux: f32| GridLight { flux: [flux; 3], level, ..bytemuck::Zeroable::zeroed() };
        let grid_lights: Vec<GridLight> =
            (0..5).map(|i| light(1, i as f32)).chain([light(2, 10.0), light(2, 20.0)]).collect();
        let mut table = LevelTable::default();
        table.0[2..6].copy_from_slice(&[0, 5, 5, 2]);
        let deal = Deal { sub_image_count: 4, first_level: 1, top_level: 2, light_count: 0 };
        let sub_images = deal_lights(&table, deal);
        let merged = merge_lights(&grid_lights, &LightList::default(), &table, &sub_images, deal);
        let fluxes: Vec<f32> = merged.iter().map(|l| l.flux[0]).collect();
        assert_eq!(fluxes, [0.0, 16.0, 10.0, 20.0, 4.0, 10.0, 20.0, 8.0, 10.0, 20.0, 12.0, 10.0, 20.0]);
        assert_eq!(merged[1].vertex, 4);
    }
}
