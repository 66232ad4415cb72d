//! Twin of `point_propagation/average_children`.

use glam::Vec3;

use super::point_sides::{PointSides, has_bit};
use crate::points::{PointCloud, unpack_rgb9e5};

/// Gives each derived side the mean of its known children's irradiance by the light that they reflect.
pub fn average_children(
    cloud: &PointCloud,
    sides: &PointSides,
    [derived, known]: [&[u32]; 2],
    irradiance: &mut [Vec3],
) {
    for key in sides.keys().rev().filter(|key| has_bit(derived, *key)) {
        let (mut reflected, mut albedos, mut received, mut areas) = (Vec3::ZERO, Vec3::ZERO, Vec3::ZERO, 0.0);
        for child in sides.children(key).into_iter().filter(|child| has_bit(known, *child)) {
            let area = cloud.node(child / 2).area;
            let albedo = area * unpack_rgb9e5(cloud.albedos[child as usize / 2]);
            reflected += albedo * irradiance[child as usize];
            received += area * irradiance[child as usize];
            albedos += albedo;
            areas += area;
        }
        let mean = reflected / albedos.max(Vec3::splat(1e-30));
        irradiance[key as usize] = Vec3::select(albedos.cmpgt(Vec3::splat(1e-30)), mean, received / areas);
    }
}
