//! Unit vectors in 32 bits: octahedral mapping, two 16-bit snorms, as GLSL's `packSnorm2x16` lays them out. Tangents have
//! 15 bits and 16, and one for the side of their bitangent.

use glam::{Vec2, Vec3, Vec4};

pub use crate::shared::NO_TANGENT;
use crate::shared::{MOST_TANGENT_X, TANGENT_SIDE};

const MOST_X: f32 = MOST_TANGENT_X as f32;

/// A unit vector as two snorm16, x in the low half. A zero or non-finite vector packs as +z.
#[must_use]
pub fn pack_octahedral(normal: Vec3) -> u32 {
    let Some(e) = flattened(normal) else { return 0 };
    u32::from(snorm16(e.x)) | (u32::from(snorm16(e.y)) << 16)
}

/// A tangent in xyz, and in w the side of its bitangent, 1 or -1. x has the low 15 bits, then follow the sign of w and y in
/// 16 bits. A zero or non-finite vector packs as [`NO_TANGENT`].
#[must_use]
pub fn pack_tangent(tangent: Vec4) -> u32 {
    let Some(e) = flattened(tangent.truncate()) else { return NO_TANGENT };
    let x = (e.x.clamp(-1.0, 1.0) * MOST_X).round() as i32 as u32 & (TANGENT_SIDE - 1);
    x | (if tangent.w < 0.0 { TANGENT_SIDE } else { 0 }) | (u32::from(snorm16(e.y)) << 16)
}

/// The tangent that [`pack_tangent`] stored; 0 for none.
#[must_use]
pub fn unpack_tangent(packed: u32) -> Vec4 {
    if packed == NO_TANGENT {
        return Vec4::ZERO;
    }
    let x = ((packed << 17) as i32 >> 17) as f32 / MOST_X;
    let direction = unfolded(Vec2::new(x, from_snorm16((packed >> 16) as u16)));
    direction.extend(if packed & TANGENT_SIDE != 0 { -1.0 } else { 1.0 })
}

/// The unit vector that [`pack_octahedral`] stored.
#[must_use]
pub fn unpack_octahedral(packed: u32) -> Vec3 {
    unfolded(Vec2::new(from_snorm16(packed as u16), from_snorm16((packed >> 16) as u16)))
}

/// A direction's place in the square; `None` for a zero or non-finite vector.
fn flattened(direction: Vec3) -> Option<Vec2> {
    let sum = direction.abs().element_sum();
    if !(sum.is_finite() && sum > 0.0) {
        return None;
    }
    let n = direction / sum;
    let flat = n.truncate();
    Some(if n.z >= 0.0 { flat } else { fold(flat) })
}

/// The unit vector at a place in the square.
fn unfolded(e: Vec2) -> Vec3 {
    let z = 1.0 - e.x.abs() - e.y.abs();
    let flat = if z >= 0.0 { e } else { fold(e) };
    Vec3::new(flat.x, flat.y, z).normalize_or(Vec3::Z)
}

/// Reflects the lower half of the octahedron into the corners of the square, and back.
fn fold(v: Vec2) -> Vec2 {
    let sign = |c: f32| if c >= 0.0 { 1.0 } else { -1.0 };
    Vec2::new((1.0 - v.y.abs()) * sign(v.x), (1.0 - v.x.abs()) * sign(v.y))
}

fn snorm16(c: f32) -> u16 {
    (c.clamp(-1.0, 1.0) * 32767.0).round() as i16 as u16
}

fn from_snorm16(bits: u16) -> f32 {
    (f32::from(bits as i16) / 32767.0).clamp(-1.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_bit_patterns() {
        assert_eq!(pack_octahedral(Vec3::Z), 0);
        assert_eq!(pack_octahedral(Vec3::X), 0x0000_7fff);
        assert_eq!(pack_octahedral(Vec3::NEG_X), 0x0000_8001);
        assert_eq!(pack_octahedral(Vec3::Y), 0x7fff_0000);
        assert_eq!(pack_octahedral(Vec3::NEG_Z), 0x7fff_7fff);
        assert_eq!(pack_octahedral(Vec3::ZERO), 0);
        assert_eq!(pack_octahedral(Vec3::NAN), 0);
        assert_eq!(unpack_octahedral(0x8000_8000).z, -1.0, "-32768 clamps to -1");
    }

    #[test]
    fn round_trips_over_the_sphere() {
        let count = 20_000;
        let mut worst = 0.0f32;
        for i in 0..count {
            let z = 1.0 - 2.0 * (i as f32 + 0.5) / count as f32;
            let (sin, cos) = (i as f32 * 2.399_963).sin_cos();
            let r = (1.0 - z * z).sqrt();
            let n = Vec3::new(r * cos, r * sin, z).normalize();
            worst = worst.max((unpack_octahedral(pack_octahedral(n)) - n).length());
        }
        assert!(worst < 1e-4, "worst error {worst}");
    }

    #[test]
    fn tangents_keep_their_side_and_axes_are_exact() {
        for axis in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z] {
            for side in [1.0, -1.0] {
                let tangent = axis.extend(side);
                assert_eq!(unpack_tangent(pack_tangent(tangent)), tangent);
            }
        }
        for none in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY] {
            assert_eq!(pack_tangent(none.extend(-1.0)), NO_TANGENT);
        }
        assert_eq!(unpack_tangent(NO_TANGENT), Vec4::ZERO);
        assert_eq!(pack_tangent(Vec3::NEG_X.extend(-1.0)), 0x0000_c001);
    }

    /// Half a unit of x in 15 bits is 3e-5, and a step in the square is at most 3 times that long in angle.
    #[test]
    fn tangents_round_trip_over_the_sphere() {
        let count = 20_000;
        for i in 0..count {
            let z = 1.0 - 2.0 * (i as f32 + 0.5) / count as f32;
            let (sin, cos) = (i as f32 * 2.399_963).sin_cos();
            let r = (1.0 - z * z).sqrt();
            let tangent = Vec3::new(r * cos, r * sin, z).normalize().extend(if i % 2 == 0 { 1.0 } else { -1.0 });
            let error = (unpack_tangent(pack_tangent(tangent)) - tangent).length();
            assert!(error < 1e-4, "{tangent}: {error}");
        }
    }

    #[test]
    fn every_pattern_unpacks_to_a_unit_vector() {
        for i in 0..65_536u32 {
            let n = unpack_octahedral(i.wrapping_mul(2_654_435_761));
            assert!((n.length() - 1.0).abs() < 1e-5);
        }
    }
}
