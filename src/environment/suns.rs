//! Small suns within an environment's image, taken out of it as lights of their own.

use std::collections::BTreeSet;
use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};

use super::{Environment, EnvironmentSun, image_direction, texel_solid_angle};
use crate::color::luminance_f64 as luminance;

/// The largest sun: a texel of a micro-buffer of 8x8, of which 60 make a hemisphere.
const LARGEST_SUN_SR: f64 = TAU / 60.0;
/// The least share of the environment's power.
const LEAST_SHARE: f64 = 0.01;
/// A sun is what is so many times brighter than its surroundings.
const CONTRAST: f64 = 4.0;
/// The most suns of an environment.
const MOST_SUNS: usize = 4;

impl Environment {
    /// Takes small bright suns out of the image. What is in their place is as bright as their surroundings; what they
    /// were brighter becomes a light, so that the total stays the same.
    #[must_use]
    pub fn with_suns_apart(mut self) -> Self {
        let mut map = Luminances::new(&self);
        while self.suns.len() < MOST_SUNS {
            let Some(found) = map.next_sun() else { break };
            let sun = self.take(&map, &found);
            self.suns.push(sun);
            map.flatten(&found);
        }
        self
    }

    /// Replaces the texels of a sun by its surroundings.
    fn take(&mut self, map: &Luminances, found: &FoundSun) -> EnvironmentSun {
        let width = self.size[0] as usize;
        let ring: DVec3 = found.ring.iter().map(|at| self.texel(*at) * map.solid_angle(*at)).sum();
        let ring_sr: f64 = found.ring.iter().map(|at| map.solid_angle(*at)).sum();
        let surroundings = if ring_sr > 0.0 { ring / ring_sr } else { DVec3::ZERO };
        let (mut irradiance, mut towards) = (DVec3::ZERO, DVec3::ZERO);
        for &[x, y] in &found.texels {
            // A channel may be darker than around; then it stays.
            let above = (self.texel([x, y]) - surroundings).max(DVec3::ZERO) * map.solid_angle([x, y]);
            irradiance += above;
            towards += luminance(above.as_vec3().to_array()) * map.direction([x, y]);
            let rest = self.texel([x, y]).min(surroundings);
            self.radiance[y * width + x] = rest.as_vec3().to_array();
        }
        EnvironmentSun { direction_to_sun: towards.normalize().as_vec3(), irradiance: irradiance.as_vec3() }
    }

    fn texel(&self, [x, y]: [usize; 2]) -> DVec3 {
        Vec3::from_array(self.radiance[y * self.size[0] as usize + x]).as_dvec3()
    }
}

/// Texels by column and row.
type Texels = BTreeSet<[usize; 2]>;

/// A sun's texels and those around it.
struct FoundSun {
    texels: Texels,
    ring: Texels,
    surroundings: f64,
}

/// The luminance of an image, where suns are looked for.
struct Luminances {
    size: [usize; 2],
    rows_sr: Vec<f64>,
    values: Vec<f64>,
    power: f64,
}

impl Luminances {
    fn new(environment: &Environment) -> Self {
        let [width, height] = environment.size;
        let values: Vec<f64> = environment.radiance.iter().map(|texel| luminance(*texel)).collect();
        let rows_sr: Vec<f64> = (0..height).map(|row| texel_solid_angle(environment.size, row)).collect();
        let rows = values.chunks_exact(width as usize).zip(&rows_sr);
        let power = rows.map(|(row, sr)| row.iter().sum::<f64>() * sr).sum();
        Self { size: [width as usize, height as usize], rows_sr, values, power }
    }

    fn solid_angle(&self, [_, y]: [usize; 2]) -> f64 {
        self.rows_sr[y]
    }

    fn value(&self, [x, y]: [usize; 2]) -> f64 {
        self.values[y * self.size[0] + x]
    }

    fn direction(&self, at: [usize; 2]) -> DVec3 {
        let point = [0, 1].map(|axis| (at[axis] as f32 + 0.5) / self.size[axis] as f32);
        image_direction(point).as_dvec3()
    }

    /// The sun around the brightest texel, if that is one.
    fn next_sun(&self) -> Option<FoundSun> {
        let brightest = self.values.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1))?.0;
        let peak = [brightest % self.size[0], brightest / self.size[0]];
        // A texel of the image that is no smaller says nothing of what is small.
        if self.solid_angle(peak) >= LARGEST_SUN_SR {
            return None;
        }
        let surroundings = self.mean_around(peak);
        let (texels, ring) = self.connected_above(peak, CONTRAST * surroundings)?;
        let excess: f64 = texels.iter().map(|at| (self.value(*at) - surroundings) * self.solid_angle(*at)).sum();
        (excess > LEAST_SHARE * self.power).then_some(FoundSun { texels, ring, surroundings })
    }

    /// Mean luminance of the directions around one that lie outside the largest sun, up to twice as far from it.
    fn mean_around(&self, center: [usize; 2]) -> f64 {
        let [width, height] = self.size;
        let (axis, radius) = (self.direction(center), (LARGEST_SUN_SR / PI).sqrt());
        let (outer, inner) = ((2.0 * radius).cos(), radius.cos());
        let rows = (2.0 * radius / PI * height as f64).ceil() as usize + 1;
        let (mut sum, mut sr) = (0.0, 0.0);
        for y in center[1].saturating_sub(rows)..(center[1] + rows + 1).min(height) {
            for x in 0..width {
                let cosine = self.direction([x, y]).dot(axis);
                if cosine > outer && cosine < inner {
                    sum += self.value([x, y]) * self.rows_sr[y];
                    sr += self.rows_sr[y];
                }
            }
        }
        if sr > 0.0 { sum / sr } else { 0.0 }
    }

    /// The texels that hang together with one and are brighter than a limit, and those around them; `None` when they are
    /// more than a sun can have.
    fn connected_above(&self, start: [usize; 2], limit: f64) -> Option<(Texels, Texels)> {
        let [width, height] = self.size;
        let (mut inside, mut ring, mut open) = (BTreeSet::from([start]), BTreeSet::new(), vec![start]);
        let mut sr = self.solid_angle(start);
        while let Some([x, y]) = open.pop() {
            for row in y.saturating_sub(1)..(y + 2).min(height) {
                for column in [x + width - 1, x, x + 1].map(|column| column % width) {
                    let at = [column, row];
                    if inside.contains(&at) {
                        continue;
                    }
                    if self.value(at) <= limit {
                        ring.insert(at);
                        continue;
                    }
                    inside.insert(at);
                    open.push(at);
                    sr += self.solid_angle(at);
                    if sr >= LARGEST_SUN_SR {
                        return None;
                    }
                }
            }
        }
        Some((inside, ring))
    }

    fn flatten(&mut self, found: &FoundSun) {
        for [x, y] in &found.texels {
            let value = &mut self.values[y * self.size[0] + x];
            *value = value.min(found.surroundings);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [128, 64];

    fn image(texel: impl Fn(Vec3) -> [f32; 3]) -> Environment {
        let at = |x: u32, y: u32| image_direction([(x as f32 + 0.5) / 128.0, (y as f32 + 0.5) / 64.0]);
        let texels = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y)));
        Environment { size: SIZE, radiance: texels.map(|(x, y)| texel(at(x, y))).collect(), suns: Vec::new() }
    }

    /// A blue sky with a disc of this radius and radiance around a direction.
    fn with_disc(towards: Vec3, radius_deg: f32, radiance: f32) -> Environment {
        let cosine = radius_deg.to_radians().cos();
        image(|d| if d.dot(towards) > cosine { [radiance, radiance, 0.8 * radiance] } else { [0.2, 0.4, 1.0] })
    }

    fn assert_same_total(before: &Environment, after: &Environment) {
        let [before, after] = [before, after].map(Environment::scalar_irradiance);
        assert!((after / before - 1.0).abs().max_element() < 1e-4, "{before} became {after}");
    }

    #[test]
    fn a_small_sun_becomes_a_light() {
        // One lies over the seam, one near the pole.
        for towards in
            [Vec3::new(0.3, 0.5, -0.4), Vec3::new(-1.0, 0.2, 0.0), Vec3::new(0.0, 1.0, 0.04)].map(Vec3::normalize)
        {
            let before = with_disc(towards, 4.0, 2e3);
            let after = before.clone().with_suns_apart();
            let [sun] = after.suns.as_slice() else { panic!("{:?}", after.suns) };
            assert!(sun.direction_to_sun.dot(towards) > 0.999, "{} is not {towards}", sun.direction_to_sun);
            assert!(after.radiance.iter().all(|texel| *texel == [0.2, 0.4, 1.0]), "the sun is still in the image");
            assert_same_total(&before, &after);
            // A sun that is lost would be seen.
            let lost = Environment { suns: Vec::new(), ..after };
            assert!((lost.scalar_irradiance() / before.scalar_irradiance()).x < 0.9);
        }
    }

    #[test]
    fn what_is_large_or_weak_stays() {
        let towards = Vec3::new(0.3, 0.5, -0.4).normalize();
        // A large lamp, a disc of less than a hundredth of the power, a sky that grows brighter by and by.
        let glow = image(|d| [0.3 + 2.0 * d.dot(towards).max(0.0).powi(8); 3]);
        for environment in
            [with_disc(towards, 14.0, 2e3), with_disc(towards, 4.0, 2.5), glow, Environment::uniform([1.0; 3])]
        {
            assert_eq!(environment.clone().with_suns_apart(), environment);
        }
        let black = image(|_| [0.0; 3]);
        assert_eq!(black.clone().with_suns_apart(), black);
    }

    #[test]
    fn several_suns_are_found_up_to_a_limit() {
        let places: Vec<Vec3> = (0..6).map(|i| image_direction([i as f32 / 6.0 + 0.05, 0.4])).collect();
        let count = |number: usize| {
            let environment =
                image(|d| if places[..number].iter().any(|p| d.dot(*p) > 0.999) { [500.0; 3] } else { [0.1; 3] });
            let after = environment.clone().with_suns_apart();
            assert_same_total(&environment, &after);
            after.suns.len()
        };
        assert_eq!([2, 4, 6].map(count), [2, 4, MOST_SUNS]);
    }
}
