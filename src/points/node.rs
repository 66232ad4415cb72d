//! Nodes of the tree: what is known of the leaves below, and how it is packed.

use glam::{DVec3, Vec3};

use super::sampling::Leaf;
use super::tree::leaves_of;
use crate::scene::octahedral::{pack_octahedral, unpack_octahedral};
use crate::shared::{POINT_IS_SOLID, POINT_IS_TURNED, POINT_LEAF_MASK, PackedNode};

/// Room for rounding where something encloses something.
const ROUNDING: f32 = 1e-5;
/// A leaf represents a node when the cosine of its normal with the mean normal is above this.
const REPRESENTATIVE_COS: f32 = 0.5;

/// What stands for the surface of a part of the leaves. Its side 0 faces the normal, side 1 the other way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Mean position of its leaves, world space.
    pub centroid_ws: Vec3,
    /// Radius about the centroid that encloses the discs of all its leaves.
    pub radius: f32,
    /// Mean normal, unit.
    pub normal: Vec3,
    /// Area of its leaves.
    pub area: f32,
    /// Length of the mean of its leaves' normals: 1 where all are the same.
    pub normal_length: f32,
    /// Cosine of the widest angle between the mean normal and one of the leaves'.
    pub cone_cos: f32,
    /// No disc reaches farther from the plane through the centroid along the mean normal.
    pub half_thickness: f32,
    /// The leaf that represents it, as the centroid may lie inside a solid: the nearest to it that faces the same way.
    pub leaf: u32,
    /// All its leaves lie on closed surfaces.
    pub is_solid: bool,
    /// Its normal opposes its parent's.
    pub is_turned: bool,
}

impl Node {
    /// As shaders read it. What encloses is rounded up.
    #[must_use]
    pub fn pack(&self) -> PackedNode {
        let byte = |share: f32| share.clamp(0.0, 255.0) as u32;
        let normal_length = byte((self.normal_length * 255.0).round());
        // A hair more, as normals that are the same give a cosine just below 1.
        let cone_cos = byte(((self.cone_cos + 1.0) * 127.5 + 1e-4).floor());
        let thickness = if self.radius > 0.0 { self.half_thickness / self.radius } else { 0.0 };
        let thickness = (thickness * 65_535.0).ceil().clamp(0.0, 65_535.0) as u32;
        let flag = |is_set: bool, flag: u32| if is_set { flag } else { 0 };
        PackedNode {
            centroid_ws: self.centroid_ws.to_array(),
            radius: self.radius,
            normal_oct: pack_octahedral(self.normal),
            area: self.area,
            spread: normal_length | cone_cos << 8 | thickness << 16,
            leaf_and_flags: self.leaf | flag(self.is_solid, POINT_IS_SOLID) | flag(self.is_turned, POINT_IS_TURNED),
        }
    }

    /// What [`Self::pack`] stored; as `common/points.glsl`.
    #[must_use]
    pub fn unpack(packed: &PackedNode) -> Self {
        let byte = |shift: u32| (packed.spread >> shift & 0xff) as f32;
        Self {
            centroid_ws: packed.centroid_ws.into(),
            radius: packed.radius,
            normal: unpack_octahedral(packed.normal_oct),
            area: packed.area,
            normal_length: byte(0) / 255.0,
            cone_cos: byte(8) / 127.5 - 1.0,
            half_thickness: packed.radius * ((packed.spread >> 16) as f32 / 65_535.0),
            leaf: packed.leaf_and_flags & POINT_LEAF_MASK,
            is_solid: packed.leaf_and_flags & POINT_IS_SOLID != 0,
            is_turned: packed.leaf_and_flags & POINT_IS_TURNED != 0,
        }
    }
}

/// All leaves in the order of the tree, as discs of one size.
pub(super) struct Discs<'a> {
    pub leaves: &'a [Leaf],
    pub area: f32,
    pub radius: f32,
}

impl Discs<'_> {
    /// A node and its albedo, not knowing its parent.
    pub fn node(&self, index: usize) -> (Node, Vec3) {
        let range = leaves_of(index as u32, self.leaves.len() as u32);
        let own = &self.leaves[range.start as usize..range.end as usize];
        let count = own.len() as f64;
        let mean = |of: &dyn Fn(&Leaf) -> Vec3| own.iter().map(|leaf| of(leaf).as_dvec3()).sum::<DVec3>() / count;
        let centroid_ws = mean(&|leaf| leaf.position_ws).as_vec3();
        let mean_normal = mean(&|leaf| leaf.normal);
        let (representative, normal) = represent(own, centroid_ws, stored(mean_normal.as_vec3()));
        let extent = own
            .iter()
            .fold(Extent::default(), |extent, leaf| extent.with(&Extent::of(leaf, self.radius, centroid_ws, normal)));
        let node = Node {
            centroid_ws,
            radius: if own.len() == 1 { self.radius } else { extent.radius * (1.0 + ROUNDING) },
            normal,
            area: (f64::from(self.area) * count) as f32,
            normal_length: mean_normal.length() as f32,
            cone_cos: extent.cone_cos,
            half_thickness: extent.half_thickness * (1.0 + ROUNDING),
            leaf: range.start + representative as u32,
            is_solid: own.iter().all(|leaf| leaf.is_solid),
            is_turned: false,
        };
        (node, mean(&|leaf| leaf.albedo).as_vec3())
    }
}

/// A normal as it is read after it was packed.
fn stored(normal: Vec3) -> Vec3 {
    unpack_octahedral(pack_octahedral(normal))
}

/// The leaf that represents others, and the normal of them all: where no leaf faces the way of the mean, as on both sides
/// of a thin wall, the leaf's own.
fn represent(leaves: &[Leaf], centroid_ws: Vec3, normal: Vec3) -> (usize, Vec3) {
    let nearest = |accepted: &dyn Fn(&Leaf) -> bool| {
        let accepted = leaves.iter().enumerate().filter(|(_, leaf)| accepted(leaf));
        let distances = accepted.map(|(index, leaf)| (leaf.position_ws.distance_squared(centroid_ws), index));
        distances.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).map(|(_, index)| index)
    };
    if let Some(index) = nearest(&|leaf| leaf.normal.dot(normal) > REPRESENTATIVE_COS) {
        return (index, normal);
    }
    let index = nearest(&|_| true).unwrap_or(0);
    (index, leaves[index].normal)
}

/// How far discs reach from a place, and from a plane through it.
struct Extent {
    radius: f32,
    half_thickness: f32,
    cone_cos: f32,
}

impl Default for Extent {
    fn default() -> Self {
        Self { radius: 0.0, half_thickness: 0.0, cone_cos: 1.0 }
    }
}

impl Extent {
    fn of(leaf: &Leaf, radius: f32, centre: Vec3, normal: Vec3) -> Self {
        let offset = leaf.position_ws - centre;
        let beside = offset.cross(leaf.normal).length();
        // Cross products, as the cosine of a small angle has no digits of it.
        let tilt = normal.cross(leaf.normal).length();
        Self {
            radius: (beside + radius).hypot(offset.dot(leaf.normal)),
            half_thickness: offset.dot(normal).abs() + radius * tilt,
            cone_cos: leaf.normal.dot(normal),
        }
    }

    fn with(&self, other: &Self) -> Self {
        Self {
            radius: self.radius.max(other.radius),
            half_thickness: self.half_thickness.max(other.half_thickness),
            cone_cos: self.cone_cos.min(other.cone_cos),
        }
    }
}

/// Three numbers of nine bits with a common exponent, as `VK_FORMAT_E5B9G9R9_UFLOAT_PACK32` has them.
#[must_use]
pub fn pack_rgb9e5(color: Vec3) -> u32 {
    let largest = color.max_element().clamp(0.0, 65_408.0);
    // The exponent of the largest number, 16 above what its bits say; one more where it is rounded up to the next power.
    let exponent_of = |value: f32| (value.max(f32::MIN_POSITIVE).to_bits() >> 23).saturating_sub(111);
    let unit = |exponent: u32| (exponent as f32 - 24.0).exp2();
    let mut exponent = exponent_of(largest);
    if (largest / unit(exponent)).round() >= 512.0 {
        exponent += 1;
    }
    let part = |value: f32| (value.clamp(0.0, largest) / unit(exponent)).round() as u32;
    part(color.x) | part(color.y) << 9 | part(color.z) << 18 | exponent << 27
}

/// What [`pack_rgb9e5`] stored.
#[must_use]
pub fn unpack_rgb9e5(packed: u32) -> Vec3 {
    let unit = ((packed >> 27) as f32 - 24.0).exp2();
    Vec3::from([0, 9, 18].map(|shift| (packed >> shift & 0x1ff) as f32)) * unit
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_keep_nine_bits_of_the_largest() {
        assert_eq!(unpack_rgb9e5(pack_rgb9e5(Vec3::ZERO)), Vec3::ZERO);
        for color in [Vec3::ONE, Vec3::new(0.5, 0.25, 0.125), Vec3::splat(65_408.0), Vec3::new(3.0, 0.0, 2.0)] {
            assert_eq!(unpack_rgb9e5(pack_rgb9e5(color)), color);
        }
        for i in 1..2000 {
            let color = Vec3::new(i as f32 / 1999.0, 0.3, 1.0 / i as f32);
            let error = (unpack_rgb9e5(pack_rgb9e5(color)) - color).abs().max_element();
            assert!(error <= color.max_element() / 512.0, "{error} of {color}");
        }
    }

    #[test]
    fn packing_a_node_keeps_it_and_never_makes_it_smaller() {
        let node = Node {
            centroid_ws: Vec3::new(1.0, -2.0, 3.0),
            radius: 0.7,
            normal: Vec3::new(0.6, 0.0, -0.8),
            area: 0.3,
            normal_length: 0.9,
            cone_cos: 0.77,
            half_thickness: 0.123,
            leaf: POINT_LEAF_MASK - 5,
            is_solid: true,
            is_turned: false,
        };
        let found = Node::unpack(&node.pack());
        assert_eq!((found.centroid_ws, found.radius, found.area), (node.centroid_ws, node.radius, node.area));
        assert_eq!((found.leaf, found.is_solid, found.is_turned), (node.leaf, true, false));
        assert!(found.normal.distance(node.normal) < 1e-4 && (found.normal_length - 0.9).abs() < 0.002);
        assert!(found.cone_cos <= node.cone_cos && found.cone_cos > node.cone_cos - 0.008, "{}", found.cone_cos);
        assert!(found.half_thickness >= 0.123 && found.half_thickness < 0.123 + 2e-5, "{}", found.half_thickness);
        let turned = Node::unpack(&Node { is_solid: false, is_turned: true, cone_cos: 1.0, ..node }.pack());
        assert_eq!((turned.is_solid, turned.is_turned, turned.cone_cos), (false, true, 1.0));
    }
}
