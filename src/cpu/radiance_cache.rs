//! Twins of `radiance_cache/convolve_lobes` and of what `cache_gather/shade_tiles` makes of one cache.

use std::f32::consts::PI;

use glam::{DVec3, Vec3};

use crate::micro_buffers::{lobe_directions, lobe_place};
use crate::shared::{CachePlace, LOBE_EDGE, MicroTexel};

/// Light of one kind in each lobe, of the radiance of each texel.
#[must_use]
pub fn convolve_lobes(table: &[MicroTexel], radiance: &[Vec3]) -> Vec<Vec3> {
    let lobe = |axis: DVec3| {
        let weight = |texel: &MicroTexel| texel.solid_angle * Vec3::from(texel.direction).dot(axis.as_vec3()).max(0.0);
        let sum: Vec3 = table.iter().zip(radiance).map(|(texel, radiance)| weight(texel) * *radiance).sum();
        PI * sum / table.iter().map(weight).sum::<f32>()
    };
    lobe_directions().into_iter().map(lobe).collect()
}

/// Irradiance that a cache's lobes hold for a normal in world space.
#[must_use]
pub fn cached_light(place: &CachePlace, lobes: &[Vec3], normal: Vec3) -> Vec3 {
    let [tangent, axis] = [place.tangent_ws, place.normal_ws].map(Vec3::from);
    let own = DVec3::new(normal.dot(tangent).into(), normal.dot(axis.cross(tangent)).into(), normal.dot(axis).into());
    let at = lobe_place(own).as_vec2();
    let low = at.floor().min(glam::Vec2::splat(LOBE_EDGE as f32 - 2.0));
    let part = at - low;
    let lobe = |x: u32, y: u32| lobes[((low.y as u32 + y) * LOBE_EDGE + low.x as u32 + x) as usize];
    let row = |y: u32| lobe(0, y).lerp(lobe(1, y), part.x);
    row(0).lerp(row(1), part.y)
}

/// How far from a cache a receiver is, by place and by angle, and how far before or behind its plane, over its reach.
#[must_use]
pub fn cache_distance(place: &CachePlace, position: Vec3, geometric: Vec3) -> [f32; 2] {
    let axis = Vec3::from(place.normal_ws);
    let offset = position - Vec3::from(place.position_ws);
    let turned = (1.0 - geometric.dot(axis)).max(0.0);
    [offset.length() / place.reach + (turned / 0.5).sqrt(), 0.5 * offset.dot(geometric + axis).abs() / place.reach]
}

/// Of how far a cache reaches, how near counts as being there: less would show single caches as dots.
const NEAREST: f32 = 0.25;

/// Light at a receiver from all caches there are, `lobes` of each: `None` where none is within `stretch` of its reach.
#[must_use]
pub fn gather(
    caches: &[(CachePlace, Vec<Vec3>)],
    [position, geometric, normal]: [Vec3; 3],
    stretch: f32,
) -> Option<Vec3> {
    let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
    for (place, lobes) in caches {
        let [distance, plane] = cache_distance(place, position, geometric);
        if distance < stretch && plane <= 0.25 * stretch {
            let weight = 1.0 / (distance / stretch).max(NEAREST) - 1.0;
            sum += weight * cached_light(place, lobes, normal);
            weights += weight;
        }
    }
    (weights > 0.0).then(|| sum / weights)
}
