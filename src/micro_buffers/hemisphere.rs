//! Which directions the texels of a micro-buffer stand for.

use std::f64::consts::{FRAC_PI_4, PI, TAU};

use bytemuck::Zeroable;
use glam::{DVec2, DVec3};

use crate::environment::blurred::cap_solid_angle;
use crate::settings::Hemisphere;
use crate::shared::{BLURRED_LEVELS, MicroTexel};

/// Samples along each edge of a texel.
const SAMPLES: u32 = 64;

/// The texels of a micro-buffer of so many texels along an edge, row by row. Those that no direction lies in have no solid
/// angle. Solid angles add up to 2 pi and cosine weights to pi, so that light from everywhere is exact.
#[must_use]
pub fn table(edge: u32, hemisphere: Hemisphere) -> Vec<MicroTexel> {
    let sums: Vec<Sums> = (0..edge * edge).map(|i| sums_of_texel(edge, [i % edge, i / edge], hemisphere)).collect();
    let total = |value: fn(&Sums) -> f64| sums.iter().map(value).sum::<f64>();
    let (solid_angle, cosine) = (total(|sums| sums.solid_angle), total(|sums| sums.cosine));
    sums.iter().map(|sums| sums.texel(TAU / solid_angle, PI / cosine)).collect()
}

/// Integrals over the directions of a texel.
#[derive(Default)]
struct Sums {
    direction: DVec3,
    solid_angle: f64,
    cosine: f64,
}

impl Sums {
    fn texel(&self, solid_angle_scale: f64, cosine_scale: f64) -> MicroTexel {
        if self.solid_angle <= 0.0 {
            return MicroTexel::zeroed();
        }
        MicroTexel {
            direction: self.direction.normalize().as_vec3().to_array(),
            solid_angle: (self.solid_angle * solid_angle_scale) as f32,
            cosine_weight: (self.cosine * cosine_scale) as f32,
            environment_level: environment_level(self.solid_angle * solid_angle_scale),
            padding: [0.0; 2],
        }
    }
}

/// The level of the environment's means whose caps are as large as a texel, with a fraction.
fn environment_level(solid_angle: f64) -> f32 {
    let level = (solid_angle / cap_solid_angle(0)).log(4.0);
    level.clamp(0.0, f64::from(BLURRED_LEVELS - 1)) as f32
}

fn sums_of_texel(edge: u32, [x, y]: [u32; 2], hemisphere: Hemisphere) -> Sums {
    let mut sums = Sums::default();
    let step = 2.0 / f64::from(edge * SAMPLES);
    let place = |texel: u32, i: u32| (f64::from(texel * SAMPLES + i) + 0.5) * step - 1.0;
    for i in 0..SAMPLES * SAMPLES {
        let point = DVec2::new(place(x, i % SAMPLES), place(y, i / SAMPLES));
        if let Some((direction, density)) = direction_at(point, hemisphere) {
            let solid_angle = density * step * step;
            sums.direction += direction * solid_angle;
            sums.solid_angle += solid_angle;
            sums.cosine += direction.z * solid_angle;
        }
    }
    sums
}

/// The direction of a point of the square from -1 to 1, and the solid angle per area there; `None` where there is none.
#[must_use]
pub fn direction_at(point: DVec2, hemisphere: Hemisphere) -> Option<(DVec3, f64)> {
    match hemisphere {
        Hemisphere::Paraboloid => {
            let s = point.length_squared();
            let direction = DVec3::new(2.0 * point.x, 2.0 * point.y, 1.0 - s) / (1.0 + s);
            (s < 1.0).then(|| (direction, 4.0 / ((1.0 + s) * (1.0 + s))))
        }
        Hemisphere::Concentric => {
            let disc = concentric_disc(point);
            let z = (1.0 - disc.length_squared()).max(0.0).sqrt();
            // The disc has pi/4 of the square's area, and the cosine times the solid angle is its area.
            Some((DVec3::new(disc.x, disc.y, z), FRAC_PI_4 / z.max(1e-6)))
        }
    }
}

/// The square on the disc with equal areas (Shirley and Chiu 1997).
fn concentric_disc(point: DVec2) -> DVec2 {
    let (radius, angle) = if point.x.abs() > point.y.abs() {
        (point.x, FRAC_PI_4 * point.y / point.x)
    } else if point.y == 0.0 {
        return DVec2::ZERO;
    } else {
        (point.y, 2.0 * FRAC_PI_4 - FRAC_PI_4 * point.x / point.y)
    };
    radius * DVec2::new(angle.cos(), angle.sin())
}

/// Where a direction lies on the paraboloid's disc, the inverse of [`direction_at`]; beyond length 1 below the horizon.
#[must_use]
pub fn disc_point(direction: DVec3) -> DVec2 {
    direction.truncate() / (1.0 + direction.z).max(1e-9)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::micro_buffers::EDGES;
    use crate::shared::{PRIMARY_EDGE, SECONDARY_EDGE};

    const BOTH: [Hemisphere; 2] = [Hemisphere::Paraboloid, Hemisphere::Concentric];

    fn used(texels: &[MicroTexel]) -> Vec<MicroTexel> {
        texels.iter().copied().filter(|texel| texel.solid_angle > 0.0).collect()
    }

    /// Whether the weights are those of a whole hemisphere.
    fn check_sums(texels: &[MicroTexel]) -> Result<(), String> {
        let solid_angle: f64 = texels.iter().map(|texel| f64::from(texel.solid_angle)).sum();
        let cosine: f64 = texels.iter().map(|texel| f64::from(texel.cosine_weight)).sum();
        if (solid_angle - TAU).abs() < 1e-5 && (cosine - PI).abs() < 1e-5 {
            Ok(())
        } else {
            Err(format!("{solid_angle} sr, {cosine}"))
        }
    }

    #[test]
    fn light_from_everywhere_is_exact() {
        for (edge, hemisphere) in EDGES.into_iter().flat_map(|edge| BOTH.map(|hemisphere| (edge, hemisphere))) {
            let mut texels = table(edge, hemisphere);
            check_sums(&texels).unwrap();
            let middle = (edge * edge / 2 + edge / 2) as usize;
            texels[middle].cosine_weight *= 1.01;
            check_sums(&texels).unwrap_err();
        }
    }

    #[test]
    fn corners_of_the_paraboloid_hold_no_direction() {
        let count = |edge, hemisphere| used(&table(edge, hemisphere)).len();
        assert_eq!(count(PRIMARY_EDGE, Hemisphere::Paraboloid), 224);
        assert_eq!(count(SECONDARY_EDGE, Hemisphere::Paraboloid), 60);
        assert_eq!(count(PRIMARY_EDGE, Hemisphere::Concentric), 256);
        assert_eq!(count(SECONDARY_EDGE, Hemisphere::Concentric), 64);
    }

    #[test]
    fn texels_have_the_solid_angle_of_their_place() {
        let edge = PRIMARY_EDGE;
        for (i, texel) in (0_u32..).zip(table(edge, Hemisphere::Paraboloid)) {
            let place = |texel: u32| (f64::from(texel) + 0.5) * 2.0 / f64::from(edge) - 1.0;
            let point = DVec2::new(place(i % edge), place(i / edge));
            let s = point.length_squared();
            let expected = 16.0 / (f64::from(edge * edge) * (1.0 + s) * (1.0 + s));
            // Texels at the rim are cut.
            if s.sqrt() < 1.0 - 2.0 / f64::from(edge) {
                assert!((f64::from(texel.solid_angle) / expected - 1.0).abs() < 0.01, "texel {i}: {texel:?}");
                let direction = glam::Vec3::from(texel.direction).as_dvec3();
                assert!(disc_point(direction).distance(point) < 0.01, "texel {i}: {direction}");
            }
        }
    }

    #[test]
    fn texels_of_the_concentric_map_weigh_the_same() {
        for texel in table(SECONDARY_EDGE, Hemisphere::Concentric) {
            assert!((texel.cosine_weight - PI as f32 / 64.0).abs() < 1e-3, "{texel:?}");
        }
    }

    #[test]
    fn directions_are_unit_and_above_the_horizon() {
        for (edge, hemisphere) in EDGES.into_iter().flat_map(|edge| BOTH.map(|hemisphere| (edge, hemisphere))) {
            for texel in used(&table(edge, hemisphere)) {
                let direction = glam::Vec3::from(texel.direction);
                assert!((direction.length() - 1.0).abs() < 1e-6 && direction.z > 0.0, "{texel:?}");
                // The mean of unit vectors that lie close together is a little shorter than they are.
                let length = texel.cosine_weight / (texel.solid_angle * direction.z);
                assert!((0.93..=1.001).contains(&length), "{length}: {texel:?}");
            }
        }
    }
}
