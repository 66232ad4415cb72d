//! Twin of `micro_buffers/splat.glsl`: a micro-buffer from the points' tree.

use std::f32::consts::PI;

use glam::{IVec2, Mat3, Vec2, Vec3};

use super::micro_buffers::POINT_OFFSET;
use crate::points::{Node, PointCloud, after_subtree};
use crate::shared::MicroTexel;

/// The tree's first row that subtrees are dealt from.
const FIRST_SUBTREE: u32 = 1024;
/// Of discs that are hit by rays, in radii of leaves.
const COVER_RADIUS: f32 = 1.75;
/// Coverage 1 as it is summed.
const COVERAGE_ONE: f32 = 1_048_576.0;
/// With binary coverage a texel is covered when this share of it is.
const LEAST_BINARY_SHARE: f32 = 0.5;
/// Nothing below this share of a leaf's radius above the tangent plane is seen.
const LEAST_HEIGHT: f32 = 1e-3;
/// No key in a texel.
const NONE: u32 = u32::MAX;

/// What all micro-buffers of a frame are drawn with.
#[derive(Clone, Copy, Debug)]
pub struct Splatting<'a> {
    /// The scene's points.
    pub points: &'a PointCloud,
    /// Texels of the micro-buffers.
    pub table: &'a [MicroTexel],
    /// Whether texels are covered or not, or by a share.
    pub is_binary: bool,
    /// Of the scene's bounds.
    pub scene_radius: f32,
    /// Cosine of the widest cone of normals that a node may stand for.
    pub widest_cone_cos: f32,
}

/// Who looks.
#[derive(Clone, Copy, Debug)]
pub struct MicroEye {
    /// From here.
    pub position_ws: Vec3,
    /// Tangents and normal.
    pub to_world: Mat3,
}

/// A micro-buffer.
#[derive(Clone, Debug)]
pub struct MicroBuffer<'a> {
    by: Splatting<'a>,
    /// By fronts and by backs.
    coverage: Vec<[u32; 2]>,
    nearest: Vec<u32>,
}

/// What a node covers and hides, seen in a direction.
struct Seen<'a> {
    index: u32,
    node: &'a Node,
    offset: Vec3,
    local: Vec3,
    distance: f32,
    facing: f32,
}

/// Solid angle of a texel in a direction of this height.
fn texel_solid_angle(texels: usize, z: f32) -> f32 {
    let plus = 2.0 / (1.0 + z.max(-0.999));
    16.0 / (texels as f32 * plus * plus)
}

fn is_inside(node: &Node, facing: f32) -> bool {
    let cone_cos = node.cone_cos.max(0.0);
    node.is_solid && facing > 0.0 && facing * facing >= 1.0 - cone_cos * cone_cos
}

fn hidden_area(node: &Node, facing: f32) -> f32 {
    let r = node.normal_length;
    let flat_and_ball =
        if node.is_solid { r * (-facing).max(0.0) + 0.25 * (1.0 - r) } else { r * facing.abs() + 0.5 * (1.0 - r) };
    node.area * flat_and_ball
}

impl Splatting<'_> {
    /// What is seen from a point.
    #[must_use]
    pub fn micro_buffer(&self, eye: MicroEye) -> MicroBuffer<'_> {
        let texels = self.table.len();
        let mut buffer = MicroBuffer { by: *self, coverage: vec![[0; 2]; texels], nearest: vec![NONE; texels] };
        for root in FIRST_SUBTREE..2 * FIRST_SUBTREE {
            let mut index = root;
            while index != after_subtree(root) {
                index = buffer.visit(index, eye);
            }
        }
        buffer
    }
}

impl MicroBuffer<'_> {
    /// How much of each texel is covered.
    #[must_use]
    pub fn coverage(&self) -> Vec<f32> {
        let share = |[front, back]: &[u32; 2]| (*front.max(back) as f32 / COVERAGE_ONE).min(1.0);
        let kept = |share| if !self.by.is_binary { share } else { f32::from(share >= LEAST_BINARY_SHARE) };
        self.coverage.iter().map(|sides| kept(share(sides))).collect()
    }

    /// The key that is seen in a texel: its own, else the nearest of its neighbours'; 0 for none.
    #[must_use]
    pub fn key(&self, texel: usize) -> u32 {
        let own = self.nearest[texel];
        let centre = IVec2::new((texel as u32 % self.edge()) as i32, (texel as u32 / self.edge()) as i32);
        let around = (0..9).map(|i| centre + IVec2::new(i % 3, i / 3) - 1).filter_map(|at| self.texel(at));
        let nearest = if own == NONE { around.map(|at| self.nearest[at]).min().unwrap_or(NONE) } else { own };
        if nearest == NONE { 0 } else { nearest & ((1 << self.key_bits()) - 1) }
    }

    fn edge(&self) -> u32 {
        self.by.table.len().isqrt() as u32
    }

    fn key_bits(&self) -> u32 {
        self.by.points.leaf_count().ilog2() + 2
    }

    /// Index of a texel that any direction lies in.
    fn texel(&self, at: IVec2) -> Option<usize> {
        let edge = self.edge() as i32;
        let is_inside = at.cmpge(IVec2::ZERO).all() && at.cmplt(IVec2::splat(edge)).all();
        let index = is_inside.then(|| (at.y * edge + at.x) as usize)?;
        (self.by.table[index].solid_angle > 0.0).then_some(index)
    }

    fn see(&mut self, texel: usize, distance: f32, key: u32) {
        let most = (1_u32 << (32 - self.key_bits())) - 2;
        let nearest = POINT_OFFSET * self.by.points.leaf_radius;
        let range = (2.0 * self.by.scene_radius / nearest).log2().max(1e-3);
        let depth = ((distance / nearest).max(1.0).log2() / range).clamp(0.0, 1.0);
        let word = ((depth * most as f32) as u32) << self.key_bits() | key;
        self.nearest[texel] = self.nearest[texel].min(word);
    }

    fn cover(&mut self, texel: usize, side: u32, share: f32) {
        self.coverage[texel][side as usize] += (share.min(4.0) * COVERAGE_ONE).round() as u32;
    }

    /// Draws a node, or part of it; gives the node to go on with.
    fn visit(&mut self, index: u32, eye: MicroEye) -> u32 {
        let node = self.by.points.node(index);
        let (normal, is_leaf) = (eye.to_world.z_axis, index >= self.by.points.leaf_count());
        let offset = node.centroid_ws - eye.position_ws;
        let along = node.normal.dot(normal);
        let reach = node.half_thickness * along.abs() + node.radius * (1.0 - along * along).max(0.0).sqrt();
        if offset.dot(normal) + reach <= LEAST_HEIGHT * self.by.points.leaf_radius {
            return after_subtree(index);
        }
        let distance = offset.length().max(1e-20);
        let local = eye.to_world.transpose() * (offset / distance);
        let solid_angle = texel_solid_angle(self.by.table.len(), local.z);
        let largest = distance * distance * (solid_angle / PI) * (1.0 - solid_angle / (4.0 * PI));
        let is_small = node.radius * node.radius < largest;
        if !(is_leaf || is_small && node.cone_cos >= self.by.widest_cone_cos) {
            return 2 * index;
        }
        let facing = node.normal.dot(offset / distance);
        if local.z > 0.0 && !is_inside(&node, facing) {
            let seen = Seen { index, node: &node, offset, local, distance, facing };
            if is_small { self.splat(&seen) } else { self.cast_leaf(&seen, eye) }
        }
        after_subtree(index)
    }

    /// Shares a node out among the four texels around it.
    fn splat(&mut self, seen: &Seen<'_>) {
        let edge = self.edge() as f32;
        let at = (seen.local.truncate() / (1.0 + seen.local.z).max(1e-6) * 0.5 + 0.5) * edge;
        let Some(own) = self.texel(at.as_ivec2().clamp(IVec2::ZERO, IVec2::splat(edge as i32 - 1))) else { return };
        let hidden = hidden_area(seen.node, seen.facing) * seen.local.z / (seen.distance * seen.distance);
        let low = (at - 0.5).floor();
        let part = at - 0.5 - low;
        let corners = [IVec2::ZERO, IVec2::X, IVec2::Y, IVec2::ONE].map(|step| {
            let along = Vec2::select(step.cmpgt(IVec2::ZERO), part, 1.0 - part);
            (self.texel(low.as_ivec2() + step).unwrap_or(own), along.x * along.y)
        });
        let weight: f32 = corners.iter().map(|(texel, share)| share * self.by.table[*texel].cosine_weight).sum();
        for (texel, share) in corners {
            self.cover(texel, shown_side(seen), hidden * share / weight.max(1e-30));
        }
        self.see(own, seen.distance, 2 * seen.index + shown_side(seen));
    }

    /// Four directions in each texel that meet a leaf's disc.
    fn cast_leaf(&mut self, seen: &Seen<'_>, eye: MicroEye) {
        let radius = COVER_RADIUS * self.by.points.leaf_radius;
        let edge = self.edge();
        for i in 0..4 * edge * edge {
            let (texel, sample) = (i / 4, i % 4);
            let place = Vec2::new((texel % edge) as f32, (texel / edge) as f32);
            let corner = 0.25 + 0.5 * Vec2::new((sample & 1) as f32, (sample >> 1) as f32);
            let at = (place + corner) * (2.0 / edge as f32) - 1.0;
            let s = at.length_squared();
            let height = (1.0 - s) / (1.0 + s);
            let direction = eye.to_world * Vec3::new(2.0 * at.x / (1.0 + s), 2.0 * at.y / (1.0 + s), height);
            let t = seen.offset.dot(seen.node.normal) / direction.dot(seen.node.normal);
            let beside = t * direction - seen.offset;
            let Some(texel) = self.texel(place.as_ivec2()) else { continue };
            if s < 1.0 && t > 0.0 && beside.length_squared() <= radius * radius {
                let weight = self.by.table[texel].cosine_weight;
                self.cover(
                    texel,
                    shown_side(seen),
                    0.25 * texel_solid_angle(self.by.table.len(), height) * height / weight,
                );
                self.see(texel, t, 2 * seen.index + shown_side(seen));
            }
        }
    }
}

/// The side that is seen.
fn shown_side(seen: &Seen<'_>) -> u32 {
    u32::from(!(seen.node.is_solid || seen.facing < 0.0))
}
