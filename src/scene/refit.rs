//! A tree whose triangles have moved: its boxes follow them, its nodes stay what they are.

use glam::Vec3;

use super::bvh::{SceneBvh, build};
use super::{Aabb, Scene};
use crate::shared::{BvhNode, BvhTriangle, NodeBox};

/// A tree that costs rays so much more than when it was built is built anew.
const WORST_COST: f32 = 1.5;
/// What a triangle in a leaf costs, in visits of a node.
const TRIANGLE_COST: f32 = 0.3;
/// The least unit of a node's planes: 2 to the power of -60.
const LEAST_EXPONENT: i32 = -60;
/// The greatest, whose inverse is a number as well.
const MOST_EXPONENT: i32 = 126;
/// Planes are whole numbers of units up to this. One less than fits, as rounding moves the last one outwards.
const MOST_UNITS: f32 = 254.0;

/// Places for the children of a node.
const SLOTS: usize = 8;

/// The tree of a scene that moves. At each moment it is a function of the scene alone, not of the moments before.
pub struct MovingBvh {
    /// The tree as it was built.
    built: SceneBvh,
    /// Boxes of its nodes then.
    boxes: Vec<NodeBox>,
}

/// What of a tree follows vertices that move.
pub struct MovingParts {
    /// Triangles with a corner that moves, by their places in the tree.
    pub triangles: Vec<u32>,
    /// Nodes above such triangles, by their height above them: a level needs those before it.
    pub levels: Vec<Vec<u32>>,
}

impl MovingBvh {
    /// Follows a tree that was built of a scene.
    #[must_use]
    pub fn new(built: &SceneBvh) -> Self {
        let (nodes, boxes) = refit(built.nodes.clone(), &built.triangles);
        Self { built: SceneBvh { nodes, ..built.clone() }, boxes }
    }

    /// Nodes that any tree of so many triangles is expected to take at most.
    #[must_use]
    pub fn node_capacity(triangles: usize) -> usize {
        triangles.div_ceil(4) + 8
    }

    /// The tree as it was built.
    #[must_use]
    pub fn built(&self) -> &SceneBvh {
        &self.built
    }

    /// Boxes of its nodes then.
    #[must_use]
    pub fn boxes(&self) -> &[NodeBox] {
        &self.boxes
    }

    /// What of the tree follows the vertices of a scene that move.
    #[must_use]
    pub fn moving_parts(&self, scene: &Scene) -> MovingParts {
        let moves = scene.motion.moving_vertices(scene.vertices.len());
        let triangle_moves: Vec<bool> = self
            .built
            .triangles
            .iter()
            .map(|t| scene.indices[3 * t.triangle_index as usize..][..3].iter().any(|vertex| moves[*vertex as usize]))
            .collect();
        let mut heights: Vec<Option<usize>> = vec![None; self.built.nodes.len()];
        let mut levels = Vec::new();
        for (index, node) in self.built.nodes.iter().enumerate().rev() {
            let height = (0..SLOTS).filter_map(|slot| match child(node, slot) {
                Child::Nothing => None,
                Child::Inner(child) => heights[child].map(|height| height + 1),
                Child::Leaf(range) => triangle_moves[range].contains(&true).then_some(0),
            });
            heights[index] = height.max();
            if let Some(height) = heights[index] {
                levels.resize_with(levels.len().max(height + 1), Vec::new);
                levels[height].push(index as u32);
            }
        }
        let triangles = (0..).zip(triangle_moves).filter_map(|(place, moves)| moves.then_some(place)).collect();
        MovingParts { triangles, levels }
    }

    /// Its nodes around triangles, in its order, that have moved.
    #[must_use]
    pub fn nodes_around(&self, triangles: &[BvhTriangle]) -> Vec<BvhNode> {
        refit(self.built.nodes.clone(), triangles).0
    }

    /// The tree of the scene where it is now. A tree that has become bad is built anew, as long as it fits the room.
    #[must_use]
    pub fn at(&self, scene: &Scene) -> SceneBvh {
        let triangles: Vec<_> = self.built.triangles.iter().map(|triangle| moved(triangle, scene)).collect();
        let (nodes, boxes) = refit(self.built.nodes.clone(), &triangles);
        let refitted = || SceneBvh { nodes, triangles, depth: self.built.depth, build_ms: 0.0 };
        self.built_anew(scene, relative_cost(&boxes)).unwrap_or_else(refitted)
    }

    /// Another tree of the scene where it is now, if the one that has followed it costs rays so much that another is worth it,
    /// and that one fits the room.
    #[must_use]
    pub fn built_anew(&self, scene: &Scene, cost: f32) -> Option<SceneBvh> {
        if !self.is_bad(cost) {
            return None;
        }
        let room = self.built.nodes.len().max(Self::node_capacity(self.built.triangles.len()));
        let anew = build(scene);
        let built_cost = relative_cost(&self.boxes);
        log::debug!("the BVH is built anew: {cost:.1} after {built_cost:.1}, {:.0} ms", anew.build_ms);
        if anew.nodes.len() > room || anew.check_depth().is_err() {
            return None;
        }
        let (nodes, _) = refit(anew.nodes, &anew.triangles);
        Some(SceneBvh { nodes, ..anew })
    }

    /// Whether a tree of this cost ([`MovedTree::cost`](crate::shared::MovedTree::cost)) is to be built anew.
    #[must_use]
    pub fn is_bad(&self, cost: f32) -> bool {
        cost.is_nan() || cost > WORST_COST * relative_cost(&self.boxes)
    }
}

/// What a tree costs rays, over the area of its root.
fn relative_cost(boxes: &[NodeBox]) -> f32 {
    let root = area(&bounds_of(&boxes[0]));
    if root > 0.0 { boxes[0].cost / root } else { boxes[0].cost }
}

fn bounds_of(node: &NodeBox) -> Aabb {
    Aabb { min: node.min.into(), max: node.max.into() }
}

/// A triangle where its corners are now.
fn moved(triangle: &BvhTriangle, scene: &Scene) -> BvhTriangle {
    let first = 3 * triangle.triangle_index as usize;
    let corner = |k: usize| Vec3::from_array(scene.vertices[scene.indices[first + k] as usize].position_ws);
    let BvhTriangle { triangle_index, material, flags, .. } = *triangle;
    BvhTriangle { triangle_index, material, flags, ..BvhTriangle::new([0, 1, 2].map(corner)) }
}

/// What is in a place for a child.
enum Child {
    Nothing,
    Inner(usize),
    Leaf(std::ops::Range<usize>),
}

/// Gives the nodes boxes around the triangles, children before parents. Twin of the shader `refit/fit_nodes`.
fn refit(mut nodes: Vec<BvhNode>, triangles: &[BvhTriangle]) -> (Vec<BvhNode>, Vec<NodeBox>) {
    let mut boxes: Vec<NodeBox> = vec![bytemuck::Zeroable::zeroed(); nodes.len()];
    // Children lie behind their parents.
    for index in (0..nodes.len()).rev() {
        let node = &mut nodes[index];
        let mut cost = 0.0;
        let children: [Aabb; SLOTS] = std::array::from_fn(|slot| match child(node, slot) {
            Child::Nothing => Aabb::EMPTY,
            Child::Inner(child) => {
                let inside = bounds_of(&boxes[child]);
                cost += boxes[child].cost;
                cost += area(&inside);
                inside
            }
            Child::Leaf(range) => {
                let count = range.len() as f32;
                let inside = triangles[range].iter().flat_map(corners).fold(Aabb::EMPTY, |all, p| all.with(p));
                cost += TRIANGLE_COST * count * area(&inside);
                inside
            }
        });
        let Aabb { min, max } = children.iter().fold(Aabb::EMPTY, |all, child| all.union(child));
        boxes[index] = NodeBox { min: min.to_array(), cost, max: max.to_array(), padding: 0 };
        enclose(node, &Aabb { min, max }, &children);
    }
    (nodes, boxes)
}

fn corners(triangle: &BvhTriangle) -> [Vec3; 3] {
    let [v0, edge1, edge2] = [triangle.v0, triangle.edge1, triangle.edge2].map(Vec3::from_array);
    [v0, v0 + edge1, v0 + edge2]
}

/// Half of a box's surface.
fn area(bounds: &Aabb) -> f32 {
    let size = (bounds.max - bounds.min).max(Vec3::ZERO);
    size.x * size.y + size.y * size.z + size.z * size.x
}

fn child(node: &BvhNode, slot: usize) -> Child {
    let meta = node.meta[slot / 4] >> (8 * (slot % 4)) & 0xff;
    let inner = node.exponents_and_inner >> 24;
    if meta == 0 {
        Child::Nothing
    } else if inner >> slot & 1 == 1 {
        Child::Inner((node.first_child + (inner & ((1 << slot) - 1)).count_ones()) as usize)
    } else {
        let first = (node.first_triangle + (meta & 31)) as usize;
        Child::Leaf(first..first + (meta >> 5).count_ones() as usize)
    }
}

/// Quantises the boxes of a node's children about its own, outwards. Which children there are stays.
fn enclose(node: &mut BvhNode, bounds: &Aabb, children: &[Aabb; SLOTS]) {
    node.origin = bounds.min.to_array();
    let mut exponents = 0;
    for axis in 0..3 {
        let origin = bounds.min[axis];
        let exponent = unit_exponent(bounds.max[axis] - origin);
        let unit = f32::exp2(exponent as f32);
        exponents |= ((exponent + 127) as u32) << (8 * axis);
        let mut words = [0; 4];
        for (slot, child) in children.iter().enumerate().filter(|(_, child)| child.min.x <= child.max.x) {
            let planes = [lower_plane(origin, unit, child.min[axis]), upper_plane(origin, unit, child.max[axis])];
            for (end, plane) in planes.into_iter().enumerate() {
                words[2 * end + slot / 4] |= plane << (8 * (slot % 4));
            }
        }
        *[&mut node.x, &mut node.y, &mut node.z][axis] = words;
    }
    node.exponents_and_inner = node.exponents_and_inner & 0xff00_0000 | exponents;
}

/// Exponent of the least unit of which the planes' numbers reach over an extent.
fn unit_exponent(extent: f32) -> i32 {
    // 254 units of an exponent that is lower by 8 than the extent's are less than it.
    let mut exponent = (extent.to_bits() >> 23) as i32 - 127 - 7;
    exponent = exponent.clamp(LEAST_EXPONENT, MOST_EXPONENT);
    while exponent < MOST_EXPONENT && MOST_UNITS * f32::exp2(exponent as f32) < extent {
        exponent += 1;
    }
    exponent
}

/// The highest plane that is not above a coordinate as shaders compute it.
fn lower_plane(origin: f32, unit: f32, coordinate: f32) -> u32 {
    let mut plane = ((coordinate - origin) / unit).floor().clamp(0.0, 255.0);
    while plane > 0.0 && origin + unit * plane > coordinate {
        plane -= 1.0;
    }
    plane as u32
}

/// The lowest plane that is not below a coordinate as shaders compute it.
fn upper_plane(origin: f32, unit: f32, coordinate: f32) -> u32 {
    let mut plane = ((coordinate - origin) / unit).ceil().clamp(0.0, 255.0);
    while plane < 255.0 && origin + unit * plane < coordinate {
        plane += 1.0;
    }
    plane as u32
}

#[cfg(test)]
#[path = "refit_tests.rs"]
mod tests;
