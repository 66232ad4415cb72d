//! Twin of `point_bounces/gather_bounce`.

use std::f32::consts::PI;

use glam::Vec3;

use super::fill_up::nearest_lending;
use super::point_sides::PointSides;
use crate::points::{PointCloud, unpack_rgb9e5};
use crate::shared::MicroTexel;

/// What a point gets from the surfaces that its micro-buffer sees, of the light that `lending` sides have.
#[must_use]
pub fn gather_bounce(
    cloud: &PointCloud,
    sides: &PointSides,
    lending: &[u32],
    irradiance: &[Vec3],
    table: &[MicroTexel],
    texels: &[u32],
) -> Vec3 {
    let seen = table.iter().zip(texels).filter(|(texel, seen)| texel.solid_angle > 0.0 && **seen & 0xff_ffff != 0);
    seen.map(|(texel, seen)| {
        let key = seen & 0xff_ffff;
        let coverage = (seen >> 24) as f32 / 255.0;
        let light = nearest_lending(sides, lending, key).map_or(Vec3::ZERO, |key| irradiance[key as usize]);
        coverage * texel.cosine_weight * unpack_rgb9e5(cloud.albedos[key as usize / 2]) * light
    })
    .sum::<Vec3>()
        / PI
}
