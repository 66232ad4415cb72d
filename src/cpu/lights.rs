//! Twins of the light arithmetic in `common/lights.glsl` and `common/color.glsl`, and the lights S0.

use std::f32::consts::PI;

use glam::Vec3;

use crate::settings::Lobe;
use crate::shared::{FrameData, GridLight};

use crate::scene::octahedral::unpack_octahedral;

/// The lights S0 as the buffers hold them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightList {
    /// Position as float bits, octahedral normal.
    pub positions: Vec<[u32; 4]>,
    /// Flux, then 1 for VPLs and 0 for lights that shine in all directions.
    pub fluxes: Vec<[f32; 4]>,
}

impl LightList {
    /// Number of lights.
    #[must_use]
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Appends a light; an isotropic one keeps its normal bits but does not use them.
    pub fn push(&mut self, position_ws: [f32; 3], normal_oct: u32, flux: [f32; 3], isotropic: bool) {
        let [x, y, z] = position_ws.map(f32::to_bits);
        self.positions.push([x, y, z, normal_oct]);
        self.fluxes.push([flux[0], flux[1], flux[2], f32::from(u8::from(!isotropic))]);
    }

    /// Position of a light.
    #[must_use]
    pub fn position(&self, index: usize) -> [f32; 3] {
        let [x, y, z, _] = self.positions[index];
        [x, y, z].map(f32::from_bits)
    }

    /// Normal of a light; zero where it is isotropic.
    #[must_use]
    pub fn normal(&self, index: usize) -> Vec3 {
        if self.fluxes[index][3] > 0.5 { unpack_octahedral(self.positions[index][3]) } else { Vec3::ZERO }
    }

    /// Flux of a light.
    #[must_use]
    pub fn flux(&self, index: usize) -> Vec3 {
        let [r, g, b, _] = self.fluxes[index];
        Vec3::new(r, g, b)
    }
}

/// Blending function of a level at distance `d`, with `radius` = alpha times the level's cell.
#[must_use]
pub fn blend_weight(d: f32, radius: f32, level: u32, first_used: u32, last_used: u32) -> f32 {
    let rise = if level == first_used { 1.0 } else { (2.0 * d / radius - 1.0).clamp(0.0, 1.0) };
    let fall = if level == last_used { 1.0 } else { (2.0 - d / radius).clamp(0.0, 1.0) };
    f32::min(rise, fall)
}

/// Radiant intensity per unit flux towards the unit direction `w`, of a light whose mean normal is `lobe`.
#[must_use]
pub fn lobe_intensity(lobe: Vec3, w: Vec3, kind: Lobe) -> f32 {
    let agreement = lobe.length().min(1.0);
    let along = lobe.dot(w);
    let unnormalised = match kind {
        Lobe::Mixture => (1.0 - agreement) * 0.25 + along.max(0.0),
        Lobe::ClampedNormal => along.max(0.0),
        Lobe::Sh1 => (0.25 + 0.5 * along).max(0.0),
        Lobe::Sh1Nonlinear => {
            let power = 1.0 + 2.0 * agreement;
            let base = (1.0 - agreement) / (1.0 + agreement);
            let q = 0.5 * (1.0 + along / agreement.max(1e-6));
            0.25 * (base + (1.0 - base) * (power + 1.0) * q.max(0.0).powf(power))
        }
    };
    unnormalised / PI
}

/// The kind of lobe that lights of a level have: the lights themselves, level 0, have the one that is exact for them.
#[must_use]
pub fn lobe_of_level(level: u32, kind: Lobe) -> Lobe {
    if level == 0 { Lobe::Mixture } else { kind }
}

/// Below which distance lights do not grow brighter.
#[derive(Clone, Copy, Debug)]
pub struct Clamp {
    /// Squared, of lights that stand for a disc of the usual size, in square metres.
    pub squared: f32,
    /// VPLs whose flux has more luminance than this stand for discs as much larger.
    pub large_vpl_luminance: f32,
}

impl Clamp {
    /// That of a frame.
    #[must_use]
    pub fn of(frame: &FrameData) -> Self {
        Self { squared: frame.clamp_squared, large_vpl_luminance: frame.large_vpl_luminance }
    }

    /// Squared, of a light of the hierarchy, which may be a merged one.
    #[must_use]
    pub fn of_light(self, light: &GridLight) -> f32 {
        let is_vpl = light.level == 0 && Vec3::from(light.lobe) != Vec3::ZERO;
        let own_luminance = light.luminance / light.weight;
        if is_vpl { self.squared * (own_luminance / self.large_vpl_luminance).max(1.0) } else { self.squared }
    }
}

/// Outgoing radiance per unit albedo and unit flux of a light whose lobe is of this kind; `offset` leads from the surface
/// to the light.
#[must_use]
pub fn light_response(offset: Vec3, normal: Vec3, lobe: Vec3, kind: Lobe, clamp_squared: f32) -> f32 {
    let distance = offset.length();
    let w = offset / distance.max(1e-20);
    let cosine = normal.dot(w).max(0.0);
    if cosine <= 0.0 {
        return 0.0;
    }
    lobe_intensity(lobe, -w, kind) * cosine / (distance * distance).max(clamp_squared) / PI
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blending_by_hand() {
        // Middle level, radius 1: 0 up to 1/2, 1 at 1, 0 from 2 on.
        let middle = |d| blend_weight(d, 1.0, 3, 1, 5);
        assert_eq!([0.0, 0.5, 0.75, 1.0, 1.5, 2.0, 9.0].map(middle), [0.0, 0.0, 0.5, 1.0, 0.5, 0.0, 0.0]);
        assert_eq!([0.0, 1.0, 1.5, 2.0].map(|d| blend_weight(d, 1.0, 1, 1, 5)), [1.0, 1.0, 0.5, 0.0]);
        assert_eq!([0.0, 0.5, 0.75, 1.0, 99.0].map(|d| blend_weight(d, 1.0, 5, 1, 5)), [0.0, 0.0, 0.5, 1.0, 1.0]);
    }

    fn worst_blend_sum(scale_of: impl Fn(u32) -> f32) -> f32 {
        let mut worst = 0.0_f32;
        for (first, last) in [(0, 2), (0, 10), (1, 2), (1, 5), (1, 7), (2, 3)] {
            for alpha in [0.3_f32, 1.0, 1.7, 4.0] {
                for i in 0..4000 {
                    let d = 1e-4 * 1.003_f32.powi(i);
                    let weight = |l: u32| {
                        scale_of(l) * blend_weight(d, alpha * 2.0_f32.powi(l as i32 - last as i32), l, first, last)
                    };
                    worst = worst.max(((first..=last).map(weight).sum::<f32>() - 1.0).abs());
                }
            }
        }
        worst
    }

    #[test]
    fn blending_functions_sum_to_one() {
        let worst = worst_blend_sum(|_| 1.0);
        assert!(worst < 1e-6, "worst deviation {worst}");
    }

    #[test]
    fn a_blending_function_scaled_by_a_hundredth_is_noticed() {
        assert!(worst_blend_sum(|level| if level == 2 { 1.01 } else { 1.0 }) > 1e-3);
    }

    /// Integral over the sphere of the intensity of a unit flux.
    fn lobe_flux(length: f32, kind: Lobe) -> f32 {
        let n = 20_000;
        let sum: f32 = (0..n)
            .map(|i| {
                let z = 1.0 - 2.0 * (i as f32 + 0.5) / n as f32;
                let r = (1.0 - z * z).sqrt();
                lobe_intensity(Vec3::new(0.0, 0.0, length), Vec3::new(r, 0.0, z), kind)
            })
            .sum();
        sum * 4.0 * PI / n as f32
    }

    #[test]
    fn lobes_keep_the_flux() {
        for length in [0.0, 0.3, 0.8, 1.0] {
            for kind in [Lobe::Mixture, Lobe::Sh1Nonlinear] {
                let flux = lobe_flux(length, kind);
                assert!((flux - 1.0).abs() < 1e-3, "{kind:?} of length {length}: {flux}");
            }
            let flux = lobe_flux(length, Lobe::ClampedNormal);
            assert!((flux - length).abs() < 1e-3, "a shortened normal loses flux: {flux}");
        }
        assert!((lobe_flux(0.5, Lobe::Sh1) - 1.0).abs() < 1e-3, "not clamped up to half");
        // Clamping 1/4 + c/2 at zero adds the integral of its negative part: 1/16.
        assert!((lobe_flux(1.0, Lobe::Sh1) - 1.125).abs() < 1e-3);
    }

    #[test]
    fn single_normals_shine_straight_ahead() {
        let ahead = |kind| lobe_intensity(Vec3::Z, Vec3::Z, kind) * PI;
        assert!((ahead(Lobe::Mixture) - 1.0).abs() < 1e-6 && (ahead(Lobe::Sh1Nonlinear) - 1.0).abs() < 1e-6);
        assert!((ahead(Lobe::Sh1) - 0.75).abs() < 1e-6);
        assert!(lobe_intensity(Vec3::Z, -Vec3::Z, Lobe::Sh1Nonlinear).abs() < 1e-6);
    }

    #[test]
    fn clamps_by_hand() {
        let clamp = Clamp { squared: 0.5, large_vpl_luminance: 3.0 };
        let light = |level, lobe: Vec3, luminance, weight| GridLight {
            level,
            lobe: lobe.to_array(),
            luminance,
            weight,
            ..bytemuck::Zeroable::zeroed()
        };
        assert_eq!(clamp.of_light(&light(0, Vec3::X, 3.0, 1.0)), 0.5);
        assert_eq!(clamp.of_light(&light(0, Vec3::X, 12.0, 1.0)), 2.0, "a disc four times as large");
        assert_eq!(clamp.of_light(&light(0, Vec3::X, 48.0, 16.0)), 0.5, "as it was before it was dealt");
        assert_eq!(clamp.of_light(&light(0, Vec3::ZERO, 12.0, 1.0)), 0.5, "a lamp");
        assert_eq!(clamp.of_light(&light(1, Vec3::X, 12.0, 1.0)), 0.5, "many lights");
    }

    #[test]
    fn response_by_hand() {
        // A light facing the surface two metres above it: (1 / pi) / 4 / pi.
        let up = Vec3::Y;
        let response = |offset, normal, lobe, clamp| light_response(offset, normal, lobe, Lobe::Mixture, clamp);
        assert!((response(2.0 * up, up, -up, 0.0) - 0.25 / (PI * PI)).abs() < 1e-7);
        assert_eq!(response(2.0 * up, -up, -up, 0.0), 0.0);
        assert_eq!(response(2.0 * up, up, up, 0.0), 0.0, "the light faces away");
        assert_eq!(response(Vec3::ZERO, up, Vec3::ZERO, 1.0), 0.0);
        // Nearer than the clamp it is as bright as there, and beyond it the clamp changes nothing.
        assert_eq!(response(0.1 * up, up, -up, 0.25), response(0.5 * up, up, -up, 0.0));
        assert_eq!(response(2.0 * up, up, -up, 0.25), response(2.0 * up, up, -up, 0.0));
        // Without a mean direction first-order harmonics are uniform: (1 / (4 pi)) / 4 / pi.
        let uniform = light_response(2.0 * up, up, Vec3::ZERO, Lobe::Sh1, 0.0);
        assert!((uniform - 1.0 / 16.0 / (PI * PI)).abs() < 1e-7);
    }
}
