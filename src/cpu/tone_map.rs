//! Twin of `tone_map/tone_curves.glsl`: from exposed linear radiance, Rec. 709, to linear display values.

use glam::{Mat3, Vec3};

use crate::settings::ToneMap;

const REC2020_FROM_REC709: Mat3 =
    Mat3::from_cols_array(&[0.6274, 0.0691, 0.0164, 0.3293, 0.9195, 0.0880, 0.0433, 0.0113, 0.8956]);
const REC709_FROM_REC2020: Mat3 =
    Mat3::from_cols_array(&[1.6605, -0.1246, -0.0182, -0.5876, 1.1329, -0.1006, -0.0728, -0.0083, 1.1187]);
const AGX_INSET: Mat3 = Mat3::from_cols_array(&[
    0.856_627_15,
    0.137_318_97,
    0.111_898_21,
    0.095_121_24,
    0.761_242,
    0.076_799_42,
    0.048_251_606,
    0.101_439_04,
    0.811_302_37,
]);
const AGX_OUTSET: Mat3 = Mat3::from_cols_array(&[
    1.127_100_6,
    -0.141_329_76,
    -0.141_329_76,
    -0.110_606_64,
    1.157_823_7,
    -0.110_606_64,
    -0.016_493_939,
    -0.016_493_939,
    1.251_936_4,
]);
const AGX_LOWEST: f32 = -12.473_93;
const AGX_HIGHEST: f32 = 4.026_069;
const BRIGHTEST: f32 = 1e30;

/// Exposed radiance as linear display values, 0 to 1.
#[must_use]
pub fn tone_map(curve: ToneMap, exposed: Vec3) -> Vec3 {
    let exposed = exposed.clamp(Vec3::ZERO, Vec3::splat(BRIGHTEST));
    let shown = match curve {
        ToneMap::Reinhard => exposed / (1.0 + exposed),
        ToneMap::Agx => agx(exposed),
        ToneMap::Neutral => neutral(exposed),
    };
    shown.clamp(Vec3::ZERO, Vec3::ONE)
}

/// Linear display values as they are stored, in sRGB.
#[must_use]
pub fn srgb_encode(linear: Vec3) -> Vec3 {
    let encode = |v: f32| if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
    Vec3::from_array(linear.to_array().map(encode))
}

fn agx_sigmoid(x: f32) -> f32 {
    let coefficients = [15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.002_32];
    coefficients.iter().fold(0.0, |sum, coefficient| sum * x + coefficient)
}

fn agx(color: Vec3) -> Vec3 {
    let inset = AGX_INSET * (REC2020_FROM_REC709 * color);
    let stop = |v: f32| ((v.max(1e-10).log2() - AGX_LOWEST) / (AGX_HIGHEST - AGX_LOWEST)).clamp(0.0, 1.0);
    let encoded = AGX_OUTSET * Vec3::from_array(inset.to_array().map(|v| agx_sigmoid(stop(v))));
    REC709_FROM_REC2020 * encoded.max(Vec3::ZERO).powf(2.2)
}

fn neutral(color: Vec3) -> Vec3 {
    const START: f32 = 0.8 - 0.04;
    const DESATURATION: f32 = 0.15;
    let least = color.min_element();
    let color = color - if least < 0.08 { least - 6.25 * least * least } else { 0.04 };
    let peak = color.max_element();
    if peak < START {
        return color;
    }
    let rest = 1.0 - START;
    let compressed = 1.0 - rest * rest / (peak + rest - START);
    let kept = 1.0 / (DESATURATION * (peak - compressed) + 1.0);
    Vec3::splat(compressed).lerp(color * (compressed / peak), kept)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(curve: ToneMap, value: f32) -> f32 {
        let shown = tone_map(curve, Vec3::splat(value));
        assert!(shown.max_element() - shown.min_element() <= 2e-3, "{curve:?} colours grey {value}: {shown}");
        shown.y
    }

    /// Largest difference of any channel; a NaN is one.
    fn is_near(found: Vec3, expected: Vec3, limit: f32) -> bool {
        (found - expected).abs().max_element() <= limit && found.is_finite()
    }

    #[test]
    fn neutral_by_hand() {
        // Below the start of compression all channels lose the same: 0.04, or near black x - 6.25 x^2.
        for (color, shown) in [
            ([0.5, 0.3, 0.2], [0.46, 0.26, 0.16]),
            ([0.7, 0.04, 0.1], [0.67, 0.01, 0.07]),
            ([0.0, 0.0, 0.7], [0.0, 0.0, 0.7]),
            ([0.18; 3], [0.14; 3]),
            // Peak 1 after the offset: 1 - 0.24^2 / 0.48 = 0.88, of which 0.15 * 0.12 is given to white.
            ([1.04; 3], [0.88; 3]),
            ([1.0, 0.0, 0.0], [0.88, 0.88 * (1.0 - 1.0 / 1.018), 0.88 * (1.0 - 1.0 / 1.018)]),
        ] {
            let found = tone_map(ToneMap::Neutral, Vec3::from_array(color));
            assert!(is_near(found, Vec3::from_array(shown), 2e-6), "{color:?}: {found}, not {shown:?}");
        }
        assert!(!is_near(tone_map(ToneMap::Neutral, Vec3::splat(0.18)), Vec3::splat(0.15), 2e-6));
    }

    #[test]
    fn agx_at_known_values() {
        // Middle grey stays near it; the ends of its 16.5 stops are black and white.
        let middle = grey(ToneMap::Agx, 0.18);
        assert!((middle - 0.18).abs() <= 0.04, "{middle}");
        assert!(grey(ToneMap::Agx, 2.0_f32.powf(AGX_LOWEST)) <= 1e-3);
        assert!(grey(ToneMap::Agx, 2.0_f32.powf(AGX_HIGHEST)) >= 0.99);
        assert!(grey(ToneMap::Agx, f32::INFINITY) >= 0.99);
        // A saturated colour fades to white as it grows brighter.
        let saturation = |v: f32| {
            let shown = tone_map(ToneMap::Agx, v * Vec3::new(1.0, 0.1, 0.02));
            1.0 - shown.min_element() / shown.max_element()
        };
        assert!(saturation(0.2) > 0.7 && saturation(16.0) < 0.5 * saturation(0.2), "{}", saturation(16.0));
    }

    #[test]
    fn greys_rise_from_black_to_white() {
        for curve in [ToneMap::Reinhard, ToneMap::Agx, ToneMap::Neutral] {
            assert_eq!(grey(curve, 0.0), 0.0, "{curve:?}");
            assert!(grey(curve, f32::MAX) >= 0.99, "{curve:?}");
            let greys: Vec<f32> = (-120..=60).map(|step| grey(curve, (0.1 * step as f32).exp2())).collect();
            assert!(greys.windows(2).all(|pair| pair[0] <= pair[1]), "{curve:?}: {greys:?}");
        }
    }
}
