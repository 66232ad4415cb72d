//! What is meant by the luminance of linear RGB, and by middle grey. GLSL: `common/color.glsl`.

use glam::Vec3;

/// Rec. 709.
pub const LUMINANCE_WEIGHTS: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// The display value, linear, that automatic exposure gives to what is neither bright nor dark. GLSL:
/// `tone_map/measure_exposure.comp.glsl`.
pub const MIDDLE_GREY: f64 = 0.18;

/// Luminance, in the precision of shaders.
#[must_use]
pub fn luminance(color: Vec3) -> f32 {
    color.dot(Vec3::from(LUMINANCE_WEIGHTS.map(|weight| weight as f32)))
}

/// Luminance in double precision, for sums over many.
#[must_use]
pub fn luminance_f64(rgb: [f32; 3]) -> f64 {
    rgb.into_iter().zip(LUMINANCE_WEIGHTS).map(|(value, weight)| weight * f64::from(value)).sum()
}
