//! The colour spaces of FLIP, all from linear sRGB primaries with a D65 white.

use std::sync::LazyLock;

use glam::{DMat3, DVec3, Mat3, Vec3};

/// Linear sRGB to XYZ, the exact rationals of the primaries of Rec. 709.
const TO_XYZ: DMat3 = DMat3::from_cols(
    DVec3::new(10_135_552.0 / 24_577_794.0, 2_613_072.0 / 12_288_897.0, 1_425_312.0 / 73_733_382.0),
    DVec3::new(8_788_810.0 / 24_577_794.0, 8_788_810.0 / 12_288_897.0, 8_788_810.0 / 73_733_382.0),
    DVec3::new(4_435_075.0 / 24_577_794.0, 887_015.0 / 12_288_897.0, 70_074_185.0 / 73_733_382.0),
);

/// Linear sRGB to XYZ relative to white, and back.
static RELATIVE_XYZ: LazyLock<(Mat3, Mat3)> = LazyLock::new(|| {
    let white = TO_XYZ * DVec3::ONE;
    let relative = DMat3::from_diagonal(white.recip()) * TO_XYZ;
    (relative.as_mat3(), relative.inverse().as_mat3())
});

/// Linear RGB to the opponent space YCxCz, in which the eye's contrast sensitivity is stated.
pub fn to_opponent(rgb: Vec3) -> Vec3 {
    let v = RELATIVE_XYZ.0 * rgb;
    Vec3::new(116.0 * v.y - 16.0, 500.0 * (v.x - v.y), 200.0 * (v.y - v.z))
}

/// The inverse of [`to_opponent`].
pub fn from_opponent(color: Vec3) -> Vec3 {
    let y = (color.x + 16.0) / 116.0;
    RELATIVE_XYZ.1 * Vec3::new(y + color.y / 500.0, y, y - color.z / 200.0)
}

/// Linear RGB to L*a*b*, its chroma scaled with the lightness (the Hunt effect).
pub fn to_hunt_lab(rgb: Vec3) -> Vec3 {
    const DELTA: f32 = 6.0 / 29.0;
    let curve = |v: f32| if v > DELTA * DELTA * DELTA { v.cbrt() } else { v / (3.0 * DELTA * DELTA) + 4.0 / 29.0 };
    let v = RELATIVE_XYZ.0 * rgb;
    let (x, y, z) = (curve(v.x), curve(v.y), curve(v.z));
    let lightness = 116.0 * y - 16.0;
    let hunt = 0.01 * lightness;
    Vec3::new(lightness, 500.0 * (x - y) * hunt, 200.0 * (y - z) * hunt)
}

/// The HyAB distance, for large colour differences: city block in lightness, Euclidean in chroma.
pub fn hyab(a: Vec3, b: Vec3) -> f32 {
    let difference = a - b;
    difference.x.abs() + difference.y.hypot(difference.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_and_black() {
        assert!(to_opponent(Vec3::ONE).abs_diff_eq(Vec3::new(100.0, 0.0, 0.0), 1e-3));
        assert!(to_hunt_lab(Vec3::ONE).abs_diff_eq(Vec3::new(100.0, 0.0, 0.0), 1e-3));
        assert!(to_hunt_lab(Vec3::ZERO).abs_diff_eq(Vec3::ZERO, 1e-3));
    }

    /// L*a*b* of sRGB green is (87.74, -86.18, 83.18); Hunt's factor is 0.8774.
    #[test]
    fn green_is_the_known_lab_color() {
        let green = to_hunt_lab(Vec3::Y);
        assert!(green.abs_diff_eq(Vec3::new(87.74, -86.18 * 0.8774, 83.18 * 0.8774), 0.1), "{green}");
    }

    #[test]
    fn opponent_colors_come_back() {
        let color = Vec3::new(0.2, 0.9, 0.05);
        assert!(from_opponent(to_opponent(color)).abs_diff_eq(color, 1e-5));
    }

    #[test]
    fn hyab_by_hand() {
        assert!((hyab(Vec3::new(1.0, 3.0, 4.0), Vec3::new(-1.0, 0.0, 0.0)) - 7.0).abs() < 1e-6);
    }
}
