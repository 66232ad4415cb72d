//! A clear sky: A. J. Preetham, P. Shirley, B. Smits, *A Practical Analytic Model for Daylight*, SIGGRAPH 1999.
//!
//! The paper gives the distribution of luminance and colour over the sky and, by its optical depths of the air, the
//! colour of the sun. How much sky and sun send is taken from the clear sky of the IES (*Recommended Practice for the
//! Calculation of Daylight Availability*, RP-21): the paper's own luminance is about twice too high.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DMat3, DVec3, Vec3};
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::{Environment, EnvironmentSun, image_direction, texel_solid_angle};
use crate::color::luminance_f64 as luminance;

/// Haze: 2 is very clear air, 10 is hazy.
const TURBIDITY: f64 = 3.0;
/// Albedo of the ground below the horizon, which sun and sky light.
const GROUND_ALBEDO: f64 = 0.2;
const SIZE: [u32; 2] = [512, 256];
/// Of a sky that is made for every frame.
const SIZE_IN_MOTION: [u32; 2] = [192, 96];
/// Lower suns have the sky of this one: what is below the horizon is beyond the model.
const LOWEST_SUN_DEG: f64 = 2.0;
/// Linear sRGB of CIE XYZ.
const RGB_FROM_XYZ: DMat3 = DMat3::from_cols_array(&[
    3.240_454_2,
    -0.969_266,
    0.055_643_4,
    -1.537_138_5,
    1.876_010_8,
    -0.204_025_9,
    -0.498_531_4,
    0.041_556,
    1.057_225_2,
]);

/// Direction towards the sun where a scene has none.
pub const DEFAULT_DIRECTION_TO_SUN: Vec3 = Vec3::new(-0.3, 1.0, -0.2);
/// Irradiance of that sun on a surface that faces it, in every channel or in luminance.
pub const DEFAULT_SUN_IRRADIANCE: f32 = 10.0;

impl Environment {
    /// A clear sky with its sun, in units in which the sun at its default place has the irradiance of a default sun.
    #[must_use]
    pub fn sky_with_sun(direction_to_sun: Vec3) -> Self {
        let units_per_klx = f64::from(DEFAULT_SUN_IRRADIANCE) / sun_klx(zenith_angle(DEFAULT_DIRECTION_TO_SUN));
        let towards = direction_to_sun.normalize_or(Vec3::Y);
        let zenith_angle = zenith_angle(towards);
        let sun = sun_color(zenith_angle) * (sun_klx(zenith_angle) * units_per_klx);
        let mut sky = dome(SIZE, towards, sun, units_per_klx);
        if towards.y > 0.0 {
            sky.suns.push(EnvironmentSun { direction_to_sun: towards, irradiance: sun.as_vec3() });
        }
        sky
    }

    /// The clear sky around a sun that the scene has: as bright as in nature beside such a sun. Where an animation moves it,
    /// the image is a smaller one, for it is made again in every frame.
    #[must_use]
    pub fn sky_for_sun(direction_to_sun: Vec3, irradiance: Vec3, moves: bool) -> Self {
        let towards = direction_to_sun.normalize_or(Vec3::Y);
        let units_per_klx = luminance(irradiance.to_array()) / sun_klx(zenith_angle(towards));
        dome(if moves { SIZE_IN_MOTION } else { SIZE }, towards, irradiance.as_dvec3(), units_per_klx)
    }
}

/// Angle between the zenith and a sun, no lower than the model allows.
fn zenith_angle(direction_to_sun: Vec3) -> f64 {
    f64::from(direction_to_sun.normalize_or(Vec3::Y).y).acos().min(FRAC_PI_2 - LOWEST_SUN_DEG.to_radians())
}

/// The image of a sky without its sun; `sun` is the sun's irradiance, for the ground.
fn dome(size: [u32; 2], direction_to_sun: Vec3, sun: DVec3, units_per_klx: f64) -> Environment {
    let model = Model::new(direction_to_sun, TURBIDITY);
    let [width, height] = size;
    let direction =
        |x: u32, y: u32| image_direction([(x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32]);
    let texels = (0..width * height / 2).into_par_iter().map(|i| (i % width, i / width));
    let colors: Vec<DVec3> = texels.map(|(x, y)| model.color(direction(x, y))).collect();
    let horizontal: DVec3 = (0..height / 2)
        .zip(colors.chunks_exact(width as usize))
        .map(|(y, row)| row.iter().sum::<DVec3>() * (texel_solid_angle(size, y) * f64::from(direction(0, y).y)))
        .sum();
    let wanted = dome_klx(model.zenith_angle) * units_per_klx;
    let scale = wanted / luminance(horizontal.as_vec3().to_array());
    let falling = horizontal * scale + sun * f64::from(direction_to_sun.y.max(0.0));
    let ground = (falling * (GROUND_ALBEDO / PI)).as_vec3().to_array();
    let mut radiance: Vec<[f32; 3]> = colors.iter().map(|color| (*color * scale).as_vec3().to_array()).collect();
    radiance.resize((width * height) as usize, ground);
    Environment { size, radiance, suns: Vec::new() }
}

/// Illuminance of a surface that faces the sun, in thousand lux (IES, clear sky).
fn sun_klx(zenith_angle: f64) -> f64 {
    127.5 * (-0.21 * air_mass(zenith_angle)).exp()
}

/// Horizontal illuminance by the sky without the sun, in thousand lux (IES, clear sky).
fn dome_klx(zenith_angle: f64) -> f64 {
    0.8 + 15.5 * zenith_angle.cos().sqrt()
}

/// Length of the sun's way through the air, 1 at the zenith (Kasten, as in the paper).
fn air_mass(zenith_angle: f64) -> f64 {
    1.0 / (zenith_angle.cos() + 0.15 * (93.885 - zenith_angle.to_degrees()).powf(-1.253))
}

/// Colour of the sun through the air as linear sRGB of luminance 1: a black body of 5778 K behind the paper's optical
/// depths of molecules and of haze; ozone and water vapour change it by a few per cent and are left out.
fn sun_color(zenith_angle: f64) -> DVec3 {
    let mass = air_mass(zenith_angle);
    let haze = 0.046_08 * TURBIDITY - 0.045_86;
    let xyz: DVec3 = (38..=78)
        .map(|step| {
            let nm = 10.0 * f64::from(step);
            let um = nm / 1000.0;
            let emitted = 1.0 / (um.powi(5) * ((14_388.0 / (um * 5778.0)).exp() - 1.0));
            let depth = 0.008_735 * um.powf(-4.08) + haze * um.powf(-1.3);
            color_matching(nm) * (emitted * (-depth * mass).exp())
        })
        .sum();
    let rgb = (RGB_FROM_XYZ * xyz).max(DVec3::ZERO);
    rgb / luminance(rgb.as_vec3().to_array())
}

/// The CIE 1931 observer, fitted by C. Wyman, P.-P. Sloan, P. Shirley, *Simple Analytic Approximations to the CIE XYZ
/// Color Matching Functions*, JCGT 2(2), 2013.
fn color_matching(nm: f64) -> DVec3 {
    let lobe = |center: f64, below: f64, above: f64| {
        let width = if nm < center { below } else { above };
        (-0.5 * ((nm - center) / width).powi(2)).exp()
    };
    DVec3::new(
        1.056 * lobe(599.8, 37.9, 31.0) + 0.362 * lobe(442.0, 16.0, 26.7) - 0.065 * lobe(501.1, 20.4, 26.2),
        0.821 * lobe(568.8, 46.9, 40.5) + 0.286 * lobe(530.9, 16.3, 31.1),
        1.217 * lobe(437.0, 11.8, 36.0) + 0.681 * lobe(459.0, 26.0, 13.8),
    )
}

/// The model for one sun: luminance in thousand candela per square metre, and chromaticity.
struct Model {
    towards_sun: DVec3,
    zenith_angle: f64,
    /// Perez' coefficients of Y, x and y.
    coefficients: [[f64; 5]; 3],
    /// Y, x and y at the zenith.
    zenith: [f64; 3],
    /// What [`perez`] makes of the zenith.
    at_zenith: [f64; 3],
}

impl Model {
    fn new(direction_to_sun: Vec3, turbidity: f64) -> Self {
        let zenith_angle = zenith_angle(direction_to_sun);
        let azimuth = f64::from(direction_to_sun.z).atan2(f64::from(direction_to_sun.x));
        let (sine, cosine) = zenith_angle.sin_cos();
        let towards_sun = DVec3::new(sine * azimuth.cos(), cosine, sine * azimuth.sin());
        let linear = |rows: [[f64; 2]; 5]| rows.map(|[slope, rest]| slope * turbidity + rest);
        let coefficients = [
            linear([[0.1787, -1.4630], [-0.3554, 0.4275], [-0.0227, 5.3251], [0.1206, -2.5771], [-0.0670, 0.3703]]),
            linear([[-0.0193, -0.2592], [-0.0665, 0.0008], [-0.0004, 0.2125], [-0.0641, -0.8989], [-0.0033, 0.0452]]),
            linear([[-0.0167, -0.2608], [-0.0950, 0.0092], [-0.0079, 0.2102], [-0.0441, -1.6537], [-0.0109, 0.0529]]),
        ];
        let at_zenith = [0, 1, 2].map(|i| perez(&coefficients[i], 1.0, zenith_angle));
        Self { towards_sun, zenith_angle, coefficients, zenith: zenith(zenith_angle, turbidity), at_zenith }
    }

    /// Y, x and y of a direction above the horizon.
    fn values(&self, direction: Vec3) -> [f64; 3] {
        let direction = direction.as_dvec3();
        let from_sun = direction.dot(self.towards_sun).clamp(-1.0, 1.0).acos();
        [0, 1, 2].map(|i| {
            let here = perez(&self.coefficients[i], direction.y.max(1e-3), from_sun);
            self.zenith[i] * here / self.at_zenith[i]
        })
    }

    /// Linear sRGB of a direction above the horizon.
    fn color(&self, direction: Vec3) -> DVec3 {
        let [luminance, x, y] = self.values(direction);
        let xyz = DVec3::new(x / y, 1.0, (1.0 - x - y) / y) * luminance;
        (RGB_FROM_XYZ * xyz).max(DVec3::ZERO)
    }
}

/// Perez' all-weather sky: relative brightness at a height (as the cosine of the zenith angle) and an angle from the sun.
fn perez([a, b, c, d, e]: &[f64; 5], cosine: f64, from_sun: f64) -> f64 {
    (1.0 + a * (b / cosine).exp()) * (1.0 + c * (d * from_sun).exp() + e * from_sun.cos().powi(2))
}

/// Luminance and chromaticity at the zenith.
fn zenith(zenith_angle: f64, turbidity: f64) -> [f64; 3] {
    let chi = (4.0 / 9.0 - turbidity / 120.0) * (PI - 2.0 * zenith_angle);
    let luminance = (4.0453 * turbidity - 4.9710) * chi.tan() - 0.2155 * turbidity + 2.4192;
    let powers = [zenith_angle.powi(3), zenith_angle.powi(2), zenith_angle, 1.0];
    let cubic = |row: [f64; 4]| row.iter().zip(powers).map(|(factor, power)| factor * power).sum::<f64>();
    let chromaticity = |rows: [[f64; 4]; 3]| {
        let [square, linear, constant] = rows.map(cubic);
        (square * turbidity + linear) * turbidity + constant
    };
    let x = chromaticity([
        [0.001_66, -0.003_75, 0.002_09, 0.0],
        [-0.029_03, 0.063_77, -0.032_02, 0.003_94],
        [0.116_93, -0.211_96, 0.060_52, 0.258_86],
    ]);
    let y = chromaticity([
        [0.002_75, -0.006_10, 0.003_17, 0.0],
        [-0.042_14, 0.089_70, -0.041_53, 0.005_16],
        [0.153_46, -0.267_56, 0.066_70, 0.266_88],
    ]);
    [luminance, x, y]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at_height(degrees: f32) -> Vec3 {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        Vec3::new(cosine, sine, 0.0)
    }

    fn near(found: f64, expected: f64, relative: f64) -> bool {
        (found / expected - 1.0).abs() <= relative
    }

    /// The paper's formulas, worked out apart from this program.
    #[test]
    fn zenith_values_are_those_of_the_paper() {
        for (turbidity, height, expected) in [
            (2.0, 45.0, [4.4696, 0.2410, 0.2437]),
            (2.0, 20.0, [2.9486, 0.2437, 0.2509]),
            (3.0, 70.0, [13.5672, 0.2601, 0.2678]),
            (3.0, 10.0, [2.8293, 0.2632, 0.2783]),
        ] {
            let found = Model::new(at_height(height), turbidity).values(Vec3::Y);
            for (found, expected) in found.iter().zip(expected) {
                assert!(
                    near(*found, expected, 5e-4),
                    "turbidity {turbidity}, {height} degrees: {found}, not {expected}"
                );
            }
        }
        assert!(!near(Model::new(at_height(46.0), 2.0).values(Vec3::Y)[0], 4.4696, 5e-4));
        let (sine, cosine) = 30_f32.to_radians().sin_cos();
        let aside = Model::new(at_height(45.0), 3.0).values(Vec3::new(0.0, sine, cosine));
        for (found, expected) in aside.iter().zip([7.3187, 0.250_27, 0.262_03]) {
            assert!(near(*found, expected, 5e-4), "{found}, not {expected}");
        }
    }

    /// Published: a clear sky's sun has 103 klx at the zenith and 69 klx at 20 degrees, its dome 15.8 klx at 70 degrees (IES).
    #[test]
    fn sun_and_dome_are_in_proportion() {
        assert!(near(sun_klx(0.0), 103.4, 1e-3) && near(sun_klx(70_f64.to_radians()), 69.3, 1e-3));
        for height in [5.0_f32, 20.0, 45.0, 70.0, 90.0] {
            let sky = Environment::sky_with_sun(at_height(height));
            let irradiance = luminance(sky.suns[0].irradiance.to_array());
            let up: f64 = (0..SIZE[1] / 2)
                .flat_map(|y| (0..SIZE[0]).map(move |x| (x, y)))
                .map(|(x, y)| {
                    let cosine = image_direction([0.0, (y as f32 + 0.5) / SIZE[1] as f32]).y;
                    let radiance = sky.radiance[(y * SIZE[0] + x) as usize];
                    luminance(radiance) * f64::from(cosine) * texel_solid_angle(SIZE, y)
                })
                .sum();
            let sine = f64::from(height).to_radians().sin();
            let zenith_angle = f64::from(90.0 - height).to_radians();
            assert!(
                near(up / irradiance, (0.8 + 15.5 * sine.sqrt()) / sun_klx(zenith_angle), 1e-3),
                "{height} degrees"
            );
            let ground = luminance(sky.radiance[sky.radiance.len() - 1]);
            assert!(near(ground, GROUND_ALBEDO / PI * (up + irradiance * sine), 1e-3), "{height} degrees: {ground}");
        }
    }

    #[test]
    fn a_default_sun_is_as_bright_as_one_without_a_sky() {
        let sky = Environment::sky_with_sun(DEFAULT_DIRECTION_TO_SUN);
        assert!(near(luminance(sky.suns[0].irradiance.to_array()), f64::from(DEFAULT_SUN_IRRADIANCE), 1e-4));
        // The scene's own sun has the same dome at the same irradiance, and a dome half as bright at half of it.
        let own = Environment::sky_for_sun(DEFAULT_DIRECTION_TO_SUN, sky.suns[0].irradiance, false);
        assert!(own.suns.is_empty());
        let half = Environment::sky_for_sun(DEFAULT_DIRECTION_TO_SUN, 0.5 * sky.suns[0].irradiance, false);
        let mean = |environment: &Environment| environment.radiance.iter().map(|texel| luminance(*texel)).sum::<f64>();
        assert!(near(mean(&own), mean(&sky), 1e-3) && near(mean(&half), 0.5 * mean(&sky), 1e-3));
    }

    /// The smaller image has the light of the other: in all, within the angle of a texel at the horizon, and in directions off it.
    #[test]
    fn a_sky_in_motion_is_the_same_sky() {
        for height in [-10.0, 3.0, 40.0] {
            let sky = |moves: bool| Environment::sky_for_sun(at_height(height), Vec3::splat(3.0), moves);
            let [still, moving] = [false, true].map(sky);
            let [whole, found] = [&still, &moving].map(|sky| sky.scalar_irradiance().to_array());
            for (found, whole) in found.iter().zip(whole) {
                assert!(near(f64::from(*found), f64::from(whole), 5e-3), "{height} degrees: {found}, not {whole}");
            }
            for direction in [at_height(80.0), at_height(height.max(0.0) + 20.0), Vec3::new(-0.6, 0.5, 0.6).normalize()]
            {
                let [still, moving] = [&still, &moving].map(|sky| luminance(sky.radiance(direction).to_array()));
                assert!(near(moving, still, 1e-2), "{height} degrees, {direction}: {moving}, not {still}");
            }
        }
    }

    #[test]
    fn the_sky_is_brightest_at_the_sun_and_blue_opposite_it() {
        let towards = at_height(30.0);
        let sky = Environment::sky_with_sun(towards);
        let luminance_at = |direction: Vec3| luminance(sky.radiance(direction).to_array());
        let opposite = Vec3::new(-towards.x, towards.y, 0.0);
        assert!(luminance_at(towards) > 5.0 * luminance_at(opposite));
        let blue = sky.radiance(opposite);
        assert!(blue.z > 1.5 * blue.x, "{blue}");
        let low = Environment::sky_with_sun(at_height(3.0)).suns[0].irradiance;
        assert!(low.x > 2.0 * low.y && low.y > 2.0 * low.z, "a low sun is red: {low}");
    }

    #[test]
    fn every_sun_has_a_finite_sky() {
        for towards in [Vec3::Y, Vec3::NEG_Y, Vec3::X, at_height(-30.0), at_height(0.5), Vec3::ZERO] {
            let for_sun = [false, true].map(|moves| Environment::sky_for_sun(towards, Vec3::splat(3.0), moves));
            for sky in for_sun.into_iter().chain([Environment::sky_with_sun(towards)]) {
                assert!(sky.radiance.iter().flatten().all(|v| v.is_finite() && *v >= 0.0), "{towards}");
                assert!(
                    sky.scalar_irradiance().is_finite() && sky.scalar_irradiance().min_element() > 0.0,
                    "{towards}"
                );
            }
        }
        assert!(Environment::sky_with_sun(at_height(-1.0)).suns.is_empty());
    }
}
