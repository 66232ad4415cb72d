//! Twin of `point_propagation/average_children`.

use glam::Vec3;

use super::point_sides::{PointSides, has_bit};
use crate::points::{PointCloud, unpack_rgb9e5};

/// Gives each derived side the mean of its children's irradiance by the light that they reflect.
pub fn average_children(cloud: &PointCloud, sides: &PointSides, derived: &[u32], irradiance: &mut [Vec3]) {
    for key in sides.keys().rev().filter(|key| has_bit(derived, *key)) {
        let children = sides.children(key).map(|child| {
            let area = cloud.node(child / 2).area;
            (area, area * unpack_rgb9e5(cloud.albedos[child as usize / 2]), irradiance[child as usize])
        });
        let [(area, albedo, received), (other_area, other_albedo, other_received)] = children;
        let reflected = albedo * received + other_albedo * other_received;
        let plain = (area * received + other_area * other_received) / (area + other_area);
        let albedos = albedo + other_albedo;
        let mean = reflected / albedos.max(Vec3::splat(1e-30));
        irradiance[key as usize] = Vec3::select(albedos.cmpgt(Vec3::splat(1e-30)), mean, plain);
    }
}
