//! Light from all around a scene, as an image of every direction. No Vulkan here.
//!
//! The image is equirectangular, linear radiance, row 0 towards +y. Its column u in 0..1 looks along (cos a, ., sin a)
//! with a = 2 pi (u - 1/2), so that the middle of the image is +x.

pub mod blurred;
pub mod file;
mod resample;
mod sampling;
mod sky;
mod suns;
pub mod upload;

use std::f32::consts::{PI, TAU};

use glam::{DVec3, Vec3};

pub use sampling::{SamplingTable, Visit};
pub use sky::{DEFAULT_DIRECTION_TO_SUN, DEFAULT_SUN_IRRADIANCE};

/// Light from all around, before it is turned and scaled.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// Width and height in texels, at least one each.
    pub size: [u32; 2],
    /// Radiance of each texel, linear RGB, finite and not negative, row by row.
    pub radiance: Vec<[f32; 3]>,
    /// Small bright sources that are no longer in the image.
    pub suns: Vec<EnvironmentSun>,
}

/// A source of an environment that is too small for its image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnvironmentSun {
    /// Unit vector towards it.
    pub direction_to_sun: Vec3,
    /// Irradiance on a surface that faces it, linear RGB.
    pub irradiance: Vec3,
}

impl Environment {
    /// The same radiance from everywhere.
    #[must_use]
    pub fn uniform(radiance: [f32; 3]) -> Self {
        Self { size: [1, 1], radiance: vec![radiance], suns: Vec::new() }
    }

    /// Radiance that arrives from a unit direction, as shaders read it: bilinear between the centres of texels, around
    /// the image without a seam, constant beyond the centres of its first and last rows.
    #[must_use]
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        let [width, height] = self.size;
        let [u, v] = image_point(direction);
        let (x, y) = (u * width as f32 - 0.5, (v * height as f32 - 0.5).clamp(0.0, (height - 1) as f32));
        let (left, top) = (x.floor(), y.floor());
        let column = |offset: i64| (left as i64 + offset).rem_euclid(i64::from(width)) as usize;
        let rows = [top as usize, (top as usize + 1).min(height as usize - 1)];
        let texel = |row: usize, column: usize| Vec3::from_array(self.radiance[row * width as usize + column]);
        let [above, below] = rows.map(|row| texel(row, column(0)).lerp(texel(row, column(1)), x - left));
        above.lerp(below, y - top)
    }

    /// Integral of the radiance over all directions (scalar irradiance), suns included.
    #[must_use]
    pub fn scalar_irradiance(&self) -> Vec3 {
        let suns: Vec3 = self.suns.iter().map(|sun| sun.irradiance).sum();
        self.image_irradiance() + suns
    }

    /// That of the image alone.
    fn image_irradiance(&self) -> Vec3 {
        let width = self.size[0] as usize;
        let image: DVec3 = (0_u32..)
            .zip(self.radiance.chunks_exact(width))
            .map(|(row, texels)| {
                let sum: DVec3 = texels.iter().map(|texel| Vec3::from_array(*texel).as_dvec3()).sum();
                sum * texel_solid_angle(self.size, row)
            })
            .sum();
        image.as_vec3()
    }
}

/// Where in the image a unit direction is: column and row, 0 to 1.
#[must_use]
pub fn image_point(direction: Vec3) -> [f32; 2] {
    let azimuth = direction.z.atan2(direction.x);
    [azimuth / TAU + 0.5, direction.y.clamp(-1.0, 1.0).acos() / PI]
}

/// The unit direction of a point of the image, the inverse of [`image_point`].
#[must_use]
pub fn image_direction([u, v]: [f32; 2]) -> Vec3 {
    let (sin_azimuth, cos_azimuth) = (TAU * (u - 0.5)).sin_cos();
    let (sin_polar, cos_polar) = (PI * v).sin_cos();
    Vec3::new(sin_polar * cos_azimuth, cos_polar, sin_polar * sin_azimuth)
}

/// Solid angle of a texel in this row.
#[must_use]
pub fn texel_solid_angle([width, height]: [u32; 2], row: u32) -> f64 {
    std::f64::consts::TAU / f64::from(width) * (row_cosine(height, row) - row_cosine(height, row + 1))
}

/// Height (y) of unit directions at the upper edge of a row.
fn row_cosine(height: u32, row: u32) -> f64 {
    (std::f64::consts::PI * f64::from(row) / f64::from(height)).cos()
}

/// A direction turned about +y by an angle in degrees, as `--environment-turn` turns the environment: from +x towards
/// -z, counterclockwise seen from above.
#[must_use]
pub fn turned(direction: Vec3, turn_deg: f32) -> Vec3 {
    glam::Quat::from_rotation_y(turn_deg.to_radians()) * direction
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An image whose red is the column and whose green is the row.
    fn ramp(size: [u32; 2]) -> Environment {
        let texels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [x as f32, y as f32, 1.0]));
        Environment { size, radiance: texels.collect(), suns: Vec::new() }
    }

    #[test]
    fn the_middle_of_the_image_is_x_and_its_first_row_is_up() {
        for (point, direction) in [
            ([0.5, 0.5], Vec3::X),
            ([0.75, 0.5], Vec3::Z),
            ([0.25, 0.5], Vec3::NEG_Z),
            ([0.0, 0.5], Vec3::NEG_X),
            ([0.3, 0.0], Vec3::Y),
            ([0.3, 1.0], Vec3::NEG_Y),
        ] {
            assert!(image_direction(point).distance(direction) < 1e-6, "{point:?}");
        }
        for point in [[0.1, 0.2], [0.6, 0.7], [0.99, 0.5]] {
            let again = image_point(image_direction(point));
            assert!((again[0] - point[0]).abs() < 1e-5 && (again[1] - point[1]).abs() < 1e-5, "{again:?}");
        }
    }

    #[test]
    fn texels_have_all_directions_between_them() {
        for size in [[1, 1], [7, 5], [512, 256]] {
            let sum: f64 = (0..size[1]).map(|row| f64::from(size[0]) * texel_solid_angle(size, row)).sum();
            assert!((sum - 2.0 * std::f64::consts::TAU).abs() < 1e-9, "{sum}");
        }
        let total = Environment::uniform([1.0, 2.0, 0.0]).scalar_irradiance();
        assert!((total - 4.0 * PI * Vec3::new(1.0, 2.0, 0.0)).length() < 1e-4, "{total}");
    }

    #[test]
    fn radiance_is_bilinear_without_a_seam() {
        let image = ramp([8, 4]);
        let at = |x: f32, y: f32| image.radiance(image_direction([x / 8.0, y / 4.0]));
        for (point, expected) in [
            ((2.5, 1.5), [2.0, 1.0]),
            ((3.0, 2.0), [2.5, 1.5]),
            ((0.0, 1.5), [3.5, 1.0]),
            ((5.5, 0.1), [5.0, 0.0]),
            ((5.5, 3.9), [5.0, 3.0]),
        ] {
            let found = at(point.0, point.1);
            assert!((found - Vec3::new(expected[0], expected[1], 1.0)).length() < 1e-4, "{point:?}: {found}");
        }
    }

    #[test]
    fn a_quarter_turn_takes_x_to_minus_z() {
        assert!(turned(Vec3::X, 90.0).distance(Vec3::NEG_Z) < 1e-6);
        assert!(turned(Vec3::Y, 33.0).distance(Vec3::Y) < 1e-6);
    }
}
