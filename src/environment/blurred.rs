//! An environment seen through the texels of micro-buffers: means over caps of the sphere of several sizes.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};

use super::resample::Resampled;
use super::{Environment, image_direction, texel_solid_angle};
use crate::shared::{BLURRED_COLUMNS, BLURRED_LEVELS, BLURRED_ROWS};

/// Size of the image that means are taken of.
const SOURCE_SIZE: [u32; 2] = [128, 64];

/// Solid angle of the caps of a level, in steradians.
#[must_use]
pub fn cap_solid_angle(level: u32) -> f64 {
    // Texels in the middle of a micro-buffer of 16 have 1/16, those at its rim 1/64, and one of 8 four times as much.
    0.25_f64.powi(3 - level as i32)
}

/// Means of an environment's image over caps about the directions of smaller images, one for each size of cap, level by
/// level: radiance and 0 for each texel. Suns are left out; turn and scale are those of the image.
#[must_use]
pub fn blurred(environment: &Environment) -> Vec<[f32; 4]> {
    let source = Source::new(environment);
    let mut texels = Vec::with_capacity((BLURRED_LEVELS * BLURRED_ROWS * BLURRED_COLUMNS) as usize);
    for level in 0..BLURRED_LEVELS {
        let cosine = 1.0 - cap_solid_angle(level) / TAU;
        for i in 0..BLURRED_ROWS * BLURRED_COLUMNS {
            let place = [i % BLURRED_COLUMNS, i / BLURRED_COLUMNS].map(|i| i as f32 + 0.5);
            let axis = image_direction([place[0] / BLURRED_COLUMNS as f32, place[1] / BLURRED_ROWS as f32]);
            let [r, g, b] = source.mean(axis.as_dvec3(), cosine).to_array();
            texels.push([r, g, b, 0.0]);
        }
    }
    texels
}

/// The image that means are taken of.
struct Source {
    /// Radiance times solid angle, and the solid angle, in the order of the texels.
    texels: Vec<(DVec3, f64)>,
    directions: Vec<DVec3>,
}

impl Source {
    fn new(environment: &Environment) -> Self {
        let [width, height] = SOURCE_SIZE;
        let direction = |i: u32| {
            let [x, y] = [i % width, i / width].map(|i| i as f32 + 0.5);
            image_direction([x / width as f32, y / height as f32])
        };
        let directions: Vec<Vec3> = (0..width * height).map(direction).collect();
        let weighted = |(i, radiance): (u32, DVec3)| {
            let solid_angle = texel_solid_angle(SOURCE_SIZE, i / width);
            (radiance * solid_angle, solid_angle)
        };
        Self {
            texels: (0..).zip(resized(environment, &directions)).map(weighted).collect(),
            directions: directions.iter().map(|direction| direction.as_dvec3()).collect(),
        }
    }

    /// Mean over the cap about an axis whose edge has this cosine. Its edge is soft, over as far as texels are apart.
    fn mean(&self, axis: DVec3, cosine: f64) -> Vec3 {
        let radius = cosine.acos();
        let [width, height] = SOURCE_SIZE;
        let soft = 0.5 * PI / f64::from(height);
        let polar = axis.y.clamp(-1.0, 1.0).acos();
        let row = |angle: f64| (angle / PI * f64::from(height)).clamp(0.0, f64::from(height - 1)) as u32;
        let (first, last) = (row(polar - radius - soft), row(polar + radius + soft));
        let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
        let outer = (radius + soft).cos();
        for i in first * width..(last + 1) * width {
            let nearness = axis.dot(self.directions[i as usize]);
            if nearness <= outer {
                continue;
            }
            let inside = ((radius + soft - nearness.min(1.0).acos()) / (2.0 * soft)).clamp(0.0, 1.0);
            let (radiance, solid_angle) = self.texels[i as usize];
            sum += radiance * inside;
            weights += solid_angle * inside;
        }
        (sum / weights.max(1e-30)).as_vec3()
    }
}

/// An environment's radiance in the directions of the texels of the image that means are taken of.
fn resized(environment: &Environment, directions: &[Vec3]) -> Vec<DVec3> {
    let [width, height] = environment.size;
    if width < SOURCE_SIZE[0] || height < SOURCE_SIZE[1] {
        return directions.iter().map(|direction| environment.radiance(*direction).as_dvec3()).collect();
    }
    let mut image = Resampled::new(environment.size, SOURCE_SIZE);
    for (i, radiance) in environment.radiance.iter().enumerate() {
        let (x, y) = (i % width as usize, i / width as usize);
        image.add(x, y, Vec3::from_array(*radiance).as_dvec3());
    }
    image.into_texels()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level_of(texels: &[[f32; 4]], level: u32) -> &[[f32; 4]] {
        let size = (BLURRED_ROWS * BLURRED_COLUMNS) as usize;
        &texels[level as usize * size..][..size]
    }

    #[test]
    fn light_from_everywhere_stays_the_same() {
        for texel in blurred(&Environment::uniform([1.0, 2.0, 0.0])) {
            assert!((Vec3::new(texel[0], texel[1], texel[2]) - Vec3::new(1.0, 2.0, 0.0)).length() < 1e-5, "{texel:?}");
        }
    }

    /// An image that is 1 above the horizon and 0 below it, and a bright texel at a height of 45 degrees towards +z.
    fn half(bright: f32) -> Environment {
        let size = [128, 64];
        let texel = |i: u32| {
            let bright = if [i % size[0], i / size[0]] == [96, 16] { bright } else { 0.0 };
            [if i / size[0] < size[1] / 2 { 1.0 } else { 0.0 }, bright, 0.0]
        };
        Environment { size, radiance: (0..size[0] * size[1]).map(texel).collect(), suns: Vec::new() }
    }

    #[test]
    fn caps_of_every_level_have_their_size() {
        let environment = half(100.0);
        let texels = blurred(&environment);
        let power = 100.0 * texel_solid_angle(environment.size, 16);
        for level in 0..BLURRED_LEVELS {
            let texels = level_of(&texels, level);
            let sum: f64 = (0_u32..)
                .zip(texels)
                .map(|(i, texel)| {
                    f64::from(texel[1]) * texel_solid_angle([BLURRED_COLUMNS, BLURRED_ROWS], i / BLURRED_COLUMNS)
                })
                .sum();
            assert!((sum / power - 1.0).abs() < 0.05, "level {level}: {sum} of {power}");
            let most = texels.iter().fold(0.0_f32, |most, texel| most.max(texel[1]));
            let expected = power / cap_solid_angle(level);
            assert!((f64::from(most) / expected - 1.0).abs() < 0.25, "level {level}: {most} for {expected}");
            // Far from the horizon nothing of it is seen.
            assert!((texels[0][0] - 1.0).abs() < 1e-5 && texels[texels.len() - 1][0].abs() < 1e-5);
        }
    }
}
