//! Twins of `common/micro_buffer.glsl` and of `micro_buffers/trace_texels`.

use std::f32::consts::{PI, TAU};

use glam::{Mat3, Vec3};

use crate::points::PointCloud;
use crate::random::{hash, unit_float};

/// Off the surface by this share of a leaf's radius.
pub(super) const POINT_OFFSET: f32 = 0.1;
/// Cosine of the widest cone of normals that a node may stand for.
const WIDEST_CONE: f32 = 0.5;
/// Of roundings that rays stay off surfaces by (`common/frame.glsl`).
const RAY_OFFSET: f32 = 1.0 / 1_048_576.0;

/// Two unit vectors that with `n` form an orthonormal frame (`common/random.glsl`).
fn tangent_frame(n: Vec3) -> [Vec3; 2] {
    let s = if n.z >= 0.0 { 1.0 } else { -1.0 };
    let a = -1.0 / (s + n.z);
    let c = n.x * n.y * a;
    [Vec3::new(1.0 + s * n.x * n.x * a, s * c, -s * n.x), Vec3::new(c, s + n.y * n.y * a, -n.y)]
}

/// From the frame of a micro-buffer to world space.
#[must_use]
pub fn micro_frame(normal: Vec3, key: u32, seed: u32) -> Mat3 {
    let [t, b] = tangent_frame(normal);
    let angle = TAU * unit_float(hash(key ^ hash(seed ^ 0x7f4a_7c15)));
    let (s, c) = angle.sin_cos();
    Mat3::from_cols(c * t + s * b, c * b - s * t, normal)
}

/// The side of a leaf in a word of `primary_leaves` or `seen_texels` (`common/point_leaves.glsl`).
#[must_use]
pub fn unpack_leaf(points: &PointCloud, word: u32) -> u32 {
    (word & 0x003f_ffff) + 2 * points.leaf_count()
}

/// The side of a leaf that a word of them stands for, or of a point without one that of its representative.
#[must_use]
pub fn leaf_key_of(points: &PointCloud, word: u32, key: u32) -> u32 {
    let representative = || 2 * (points.leaf_count() + points.node(key >> 1).leaf) + (key & 1);
    if word == u32::MAX { representative() } else { unpack_leaf(points, word) }
}

/// Where light is gathered at a side of a leaf, and its normal.
#[must_use]
pub fn place_of_leaf_key(points: &PointCloud, leaf_key: u32, largest_triangle: f32) -> (Vec3, Vec3) {
    let leaf = points.node(leaf_key >> 1);
    let normal = if leaf_key & 1 == 0 { leaf.normal } else { -leaf.normal };
    let size = leaf.centroid_ws.abs().max_element().max(largest_triangle);
    let offset = (POINT_OFFSET * points.leaf_radius).max(RAY_OFFSET * size);
    (leaf.centroid_ws + offset * normal, normal)
}

/// What sees leaves.
#[derive(Clone, Copy, Debug)]
pub struct Looking {
    /// From here.
    pub position: Vec3,
    /// In a texel of this solid angle.
    pub solid_angle: f32,
    /// With a node of this radius.
    pub radius: f32,
}

/// The key that one side of a leaf is kept as where it is seen, and how near the decisions on the way were to going the
/// other way: 0 is a tie.
#[must_use]
pub fn seen_key(points: &PointCloud, leaf_key: u32, from: Looking) -> (u32, f32) {
    let (mut node, mut side) = (leaf_key >> 1, leaf_key & 1);
    let mut margin = f32::INFINITY;
    while node > 1 {
        let parent = points.node(node >> 1);
        let subtended = PI * parent.radius * parent.radius;
        let texel = from.solid_angle * (parent.centroid_ws - from.position).length_squared();
        let (by_texel, by_radius) = (texel / subtended - 1.0, from.radius / parent.radius - 1.0);
        margin = margin.min(by_texel.max(by_radius).abs()).min((parent.cone_cos - WIDEST_CONE).abs());
        if (by_texel < 0.0 && by_radius < 0.0) || parent.cone_cos < WIDEST_CONE {
            break;
        }
        side ^= u32::from(points.node(node).is_turned);
        node >>= 1;
    }
    (2 * node + side, margin)
}
