//! Unit vectors in 32 bits: octahedral mapping, two 16-bit snorms, as GLSL's `packSnorm2x16` lays them out.

use glam::{Vec2, Vec3};

/// A unit vector as two snorm16, x in the low half. A zero or non-finite vector packs as +z.
#[must_use]
pub fn pack_octahedral(normal: Vec3) -> u32 {
    let sum = normal.x.abs() + normal.y.abs() + normal.z.abs();
    if !(sum.is_finite() && sum > 0.0) {
        return 0;
    }
    let n = normal / sum;
    let flat = Vec2::new(n.x, n.y);
    let folded = if n.z >= 0.0 { flat } else { fold(flat) };
    u32::from(snorm16(folded.x)) | (u32::from(snorm16(folded.y)) << 16)
}

/// The unit vector that [`pack_octahedral`] stored.
#[must_use]
pub fn unpack_octahedral(packed: u32) -> Vec3 {
    let e = Vec2::new(from_snorm16(packed as u16), from_snorm16((packed >> 16) as u16));
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
    fn every_pattern_unpacks_to_a_unit_vector() {
        for i in 0..65_536u32 {
            let n = unpack_octahedral(i.wrapping_mul(2_654_435_761));
            assert!((n.length() - 1.0).abs() < 1e-5);
        }
    }
}
