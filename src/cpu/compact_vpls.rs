//! Twin of `compaction/compact_vpls`.

use std::f32::consts::PI;

use glam::Vec3;

use super::exclusive_scan::exclusive_scan;
use super::lights::LightList;
use crate::scene::octahedral::pack_octahedral;
use crate::shared::PunctualLight;

/// Packs the VPLs of the path slots whose bit is set into S0, at most `capacity`, followed by the scene's own
/// lights. Gives S0 and the light counts: lights, VPLs among them, VPLs that did not fit.
#[must_use]
pub fn compact_vpls(
    slots: &LightList,
    bits: &[u32],
    capacity: u32,
    scene_lights: &[PunctualLight],
) -> (LightList, [u32; 3]) {
    let found = exclusive_scan(bits).last().copied().unwrap_or(0);
    let vpl_count = found.min(capacity);
    let mut lights = LightList::default();
    let set = (0..slots.len()).filter(|slot| bits[slot / 32] >> (slot % 32) & 1 == 1);
    for slot in set.take(vpl_count as usize) {
        lights.positions.push(slots.positions[slot]);
        lights.fluxes.push(slots.fluxes[slot]);
    }
    for light in scene_lights {
        let flux = light.intensity.map(|i| i * 4.0 * PI);
        lights.push(light.position_ws, pack_octahedral(Vec3::Y), flux, true);
    }
    (lights, [vpl_count + scene_lights.len() as u32, vpl_count, found - vpl_count])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holes_are_closed_and_the_rest_is_counted() {
        let mut slots = LightList::default();
        for i in 0..40 {
            slots.push([i as f32, 0.0, 0.0], 7, [1.0; 3], false);
        }
        let bits = [1 << 3 | 1 << 31, 0b100];
        let point = PunctualLight { intensity: [1.0; 3], position_ws: [9.0; 3], ..bytemuck::Zeroable::zeroed() };
        let (lights, counts) = compact_vpls(&slots, &bits, 2, &[point]);
        assert_eq!(counts, [3, 2, 1]);
        assert_eq!([0, 1, 2].map(|i| lights.position(i)[0]), [3.0, 31.0, 9.0]);
        assert_eq!((lights.fluxes[0][3], lights.fluxes[2]), (1.0, [4.0 * PI, 4.0 * PI, 4.0 * PI, 0.0]));
    }
}
