//! The bounding volume hierarchy of a scene's triangles in the layout that shaders read, eight-wide, and a binary one
//! that the CPU traverses. Why eight: `docs/bvh.md`.

use std::collections::HashMap;
use std::time::{Duration, Instant};

use glam::Vec3;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;
use obvhs::ploc::PlocBuilder;
use obvhs::triangle::Triangle;

use super::Scene;
use crate::error::{Error, Result};
use crate::shared::TRIANGLE_ALPHA_MASKED;
pub use crate::shared::{BvhNode, BvhTriangle, MAX_WIDE_DEPTH};

/// No binary tree is deeper, so a traversal that descends to one child and stacks the other needs at most 63 slots.
pub const MAX_DEPTH: u32 = 64;

/// Most triangles in a leaf; the eight-wide node has room for three.
const LEAF_TRIANGLES: u32 = 3;

/// More triangles than this around one and the same point are not clustered.
const MAX_COINCIDENT_TRIANGLES: u32 = 4096;

/// One node of the binary tree, node 0 the root.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct BinaryNode {
    /// Smallest corner of the box.
    pub min: [f32; 3],
    /// Number of triangles; 0 marks an inner node.
    pub prim_count: u32,
    /// Largest corner of the box.
    pub max: [f32; 3],
    /// Leaf: the first triangle. Inner node: the left child, the right one being the next node.
    pub first_index: u32,
}

/// A binary BVH over all triangles of a scene.
pub struct BinaryBvh {
    /// Nodes, the root first.
    pub nodes: Vec<BinaryNode>,
    /// Triangles in the order that the leaves refer to.
    pub triangles: Vec<BvhTriangle>,
    /// Levels of the tree, at most [`MAX_DEPTH`].
    pub depth: u32,
    /// Wall-clock time of the build in milliseconds.
    pub build_ms: f64,
}

/// An eight-wide compressed BVH (Ylitie et al. 2017) over all triangles of a scene.
#[derive(Clone)]
pub struct SceneBvh {
    /// Nodes, the root first.
    pub nodes: Vec<BvhNode>,
    /// Triangles in the order that the leaves refer to.
    pub triangles: Vec<BvhTriangle>,
    /// Levels of the tree, at most [`MAX_WIDE_DEPTH`].
    pub depth: u32,
    /// Wall-clock time of the build in milliseconds.
    pub build_ms: f64,
}

impl SceneBvh {
    /// Checks that rays find everything: the traversal in shaders leaves out what its stack has no room for.
    ///
    /// # Errors
    /// [`Error::Failure`] for a tree that is too deep.
    pub fn check_depth(&self) -> Result<()> {
        if self.depth <= MAX_WIDE_DEPTH {
            return Ok(());
        }
        Err(Error::Failure(format!(
            "the scene's BVH has {} levels, and rays can follow it through {MAX_WIDE_DEPTH} at most",
            self.depth
        )))
    }
}

/// Where a ray meets the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance in lengths of the ray's direction.
    pub t: f32,
    /// Triangle of the scene.
    pub triangle_index: u32,
    /// Weight of the triangle's second corner.
    pub u: f32,
    /// Weight of the triangle's third corner.
    pub v: f32,
}

/// A ray, or the part of one between two distances.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Origin, world space.
    pub origin: Vec3,
    /// Direction of any length but zero.
    pub direction: Vec3,
    /// Hits nearer than this do not count.
    pub t_min: f32,
    /// Hits at this distance or farther do not count.
    pub t_max: f32,
}

/// What both kinds of tree are built with.
///
/// Every triangle appears once (no spatial splits), which keeps leaves and triangle buffer the size of the scene.
const fn params() -> BvhBuildParams {
    BvhBuildParams { max_prims_per_leaf: LEAF_TRIANGLES, ..BvhBuildParams::medium_build() }
}

/// Builds the binary tree.
#[must_use]
pub fn build_binary(scene: &Scene) -> BinaryBvh {
    let start = Instant::now();
    let corners = corners(scene);
    if most_coincident(&corners) > MAX_COINCIDENT_TRIANGLES {
        // The clustering below takes quadratic time there (35 s for 40,000 equal triangles).
        let order: Vec<u32> = (0..corners.len() as u32).collect();
        let triangles = ordered(scene, &order);
        let nodes = balanced(&triangles, LEAF_TRIANGLES);
        return BinaryBvh { depth: depth(&nodes), nodes, triangles, build_ms: milliseconds(start) };
    }
    let bvh = build_bvh2_from_tris(&corners, params(), &mut Duration::default());
    let nodes: Vec<BinaryNode> = bvh
        .nodes
        .iter()
        .map(|n| BinaryNode {
            min: Vec3::from(n.aabb().min).to_array(),
            prim_count: n.prim_count,
            max: Vec3::from(n.aabb().max).to_array(),
            first_index: n.first_index,
        })
        .collect();
    let triangles = ordered(scene, &bvh.primitive_indices);
    let mut bvh = BinaryBvh { depth: depth(&nodes), nodes, triangles, build_ms: 0.0 };
    if bvh.depth > MAX_DEPTH {
        // Many coinciding triangles make a chain; a plain tree over the same order is always shallow.
        bvh.nodes = balanced(&bvh.triangles, LEAF_TRIANGLES);
        bvh.depth = depth(&bvh.nodes);
    }
    bvh.build_ms = milliseconds(start);
    bvh
}

/// Builds the eight-wide tree.
#[must_use]
pub fn build(scene: &Scene) -> SceneBvh {
    let start = Instant::now();
    let corners = corners(scene);
    let balanced = || balanced_wide(scene, corners.len() as u32);
    let mut bvh =
        if most_coincident(&corners) > MAX_COINCIDENT_TRIANGLES { balanced() } else { clustered_wide(&corners) };
    let mut nodes = wide_nodes(&bvh);
    if wide_depth(&nodes) > MAX_WIDE_DEPTH {
        bvh = balanced();
        nodes = wide_nodes(&bvh);
    }
    let triangles = ordered(scene, &bvh.primitive_indices);
    SceneBvh { depth: wide_depth(&nodes), nodes, triangles, build_ms: milliseconds(start) }
}

/// The eight-wide tree by clustering: the steps of obvhs's `build_cwbvh_from_tris` without its check, which in builds with
/// debug assertions panics on a tree as deep as coinciding triangles make it. [`build`] looks at the depth itself.
fn clustered_wide(corners: &[Triangle]) -> CwBvh {
    let params = params();
    let order = (0..corners.len() as u32).collect();
    let mut binary = PlocBuilder::with_capacity(corners.len()).build(
        params.ploc_search_distance,
        corners,
        order,
        params.sort_precision,
        params.search_depth_threshold,
    );
    ReinsertionOptimizer::default().run(&mut binary, params.reinsertion_batch_ratio, None);
    bvh2_to_cwbvh(&binary, params.max_prims_per_leaf, true, false)
}

/// The eight-wide form of the balanced tree over the triangles in the scene's order.
fn balanced_wide(scene: &Scene, count: u32) -> CwBvh {
    let order: Vec<u32> = (0..count).collect();
    // The conversion merges leaves itself.
    let binary = balanced(&ordered(scene, &order), 1);
    let node = |n: &BinaryNode| {
        let aabb = Aabb::new(Vec3::from(n.min).into(), Vec3::from(n.max).into());
        Bvh2Node::new(aabb, n.prim_count, n.first_index)
    };
    let depth = depth(&binary) as usize;
    let bvh = Bvh2 {
        nodes: binary.iter().map(node).collect(),
        primitive_indices: order,
        children_are_ordered_after_parents: true,
        max_depth: depth.max(96),
        ..Bvh2::default()
    };
    bvh2_to_cwbvh(&bvh, LEAF_TRIANGLES, true, false)
}

fn wide_nodes(bvh: &CwBvh) -> Vec<BvhNode> {
    bvh.nodes.iter().map(|n| bytemuck::cast(*n)).collect()
}

fn wide_depth(nodes: &[BvhNode]) -> u32 {
    let mut stack = vec![(0u32, 1u32)];
    let mut deepest = 0;
    while let Some((i, level)) = stack.pop() {
        deepest = deepest.max(level);
        let node = &nodes[i as usize];
        let children = (node.exponents_and_inner >> 24).count_ones();
        stack.extend((0..children).map(|child| (node.first_child + child, level + 1)));
    }
    deepest
}

fn milliseconds(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}

fn corners(scene: &Scene) -> Vec<Triangle> {
    let corner = |i: u32| Vec3::from_array(scene.vertices[i as usize].position_ws).into();
    let triangle = |t: &[u32]| Triangle { v0: corner(t[0]), v1: corner(t[1]), v2: corner(t[2]) };
    scene.indices.chunks_exact(3).map(triangle).collect()
}

/// The triangles in the order of the tree.
fn ordered(scene: &Scene, order: &[u32]) -> Vec<BvhTriangle> {
    let position = |i: u32| Vec3::from_array(scene.vertices[i as usize].position_ws);
    let triangle = |triangle_index: &u32| {
        let t = *triangle_index as usize;
        let [a, b, c] = [0, 1, 2].map(|k| position(scene.indices[3 * t + k]));
        let material = scene.triangle_materials[t];
        let masked = scene.materials[material as usize].alpha_cutoff.is_some();
        let flags = if masked { TRIANGLE_ALPHA_MASKED } else { 0 };
        BvhTriangle { triangle_index: *triangle_index, material, flags, ..BvhTriangle::new([a, b, c]) }
    };
    order.iter().map(triangle).collect()
}

/// The largest number of triangles with the same centre.
fn most_coincident(triangles: &[Triangle]) -> u32 {
    let mut counts: HashMap<[u32; 3], u32> = HashMap::with_capacity(triangles.len());
    for t in triangles {
        let aabb = t.aabb();
        *counts.entry(Vec3::from(aabb.min + aabb.max).to_array().map(f32::to_bits)).or_default() += 1;
    }
    counts.into_values().max().unwrap_or(0)
}

/// A tree that halves the list of triangles until they fit a leaf.
fn balanced(triangles: &[BvhTriangle], leaf_triangles: u32) -> Vec<BinaryNode> {
    let mut nodes = vec![bounding_leaf(triangles, 0, triangles.len())];
    let mut next = 0;
    while next < nodes.len() {
        let (first, count) = (nodes[next].first_index as usize, nodes[next].prim_count as usize);
        if count > leaf_triangles as usize {
            (nodes[next].prim_count, nodes[next].first_index) = (0, nodes.len() as u32);
            let middle = first + count / 2;
            nodes.push(bounding_leaf(triangles, first, middle));
            nodes.push(bounding_leaf(triangles, middle, first + count));
        }
        next += 1;
    }
    nodes
}

fn bounding_leaf(triangles: &[BvhTriangle], first: usize, end: usize) -> BinaryNode {
    let (mut min, mut max) = (Vec3::MAX, Vec3::MIN);
    for triangle in &triangles[first..end] {
        let [v0, edge1, edge2] = [triangle.v0, triangle.edge1, triangle.edge2].map(Vec3::from_array);
        for p in [v0, v0 + edge1, v0 + edge2] {
            (min, max) = (min.min(p), max.max(p));
        }
    }
    BinaryNode { min: min.to_array(), prim_count: (end - first) as u32, max: max.to_array(), first_index: first as u32 }
}

fn depth(nodes: &[BinaryNode]) -> u32 {
    let mut stack = vec![(0u32, 1u32)];
    let mut deepest = 0;
    while let Some((i, level)) = stack.pop() {
        deepest = deepest.max(level);
        let node = &nodes[i as usize];
        if node.prim_count == 0 {
            stack.extend([(node.first_index, level + 1), (node.first_index + 1, level + 1)]);
        }
    }
    deepest
}

impl BinaryBvh {
    /// The nearest triangle along the ray, either side, alpha ignored.
    #[must_use]
    pub fn trace_closest(&self, ray: &Ray) -> Option<Hit> {
        let mut closest = None;
        let mut ray = *ray;
        self.traverse(&mut ray, |hit, ray| {
            ray.t_max = hit.t;
            closest = Some(hit);
            true
        });
        closest
    }

    /// Whether any triangle lies on the ray, alpha ignored.
    #[must_use]
    pub fn trace_any(&self, ray: &Ray) -> bool {
        let mut found = false;
        self.traverse(&mut ray.clone(), |_, _| {
            found = true;
            false
        });
        found
    }

    /// Calls `on_hit` for every triangle within the ray's range until it says `false`; nearer children come first.
    fn traverse(&self, ray: &mut Ray, mut on_hit: impl FnMut(Hit, &mut Ray) -> bool) {
        let inverse = ray.direction.recip();
        let mut stack = Vec::with_capacity(MAX_DEPTH as usize);
        stack.push((0u32, enter(&self.nodes[0], ray, inverse)));
        while let Some((i, t)) = stack.pop() {
            if t >= ray.t_max {
                continue;
            }
            let node = &self.nodes[i as usize];
            let first = node.first_index;
            if node.prim_count == 0 {
                let [left, right] = [first, first + 1].map(|i| (i, enter(&self.nodes[i as usize], ray, inverse)));
                stack.extend(if left.1 < right.1 { [right, left] } else { [left, right] });
                continue;
            }
            for triangle in &self.triangles[first as usize..(first + node.prim_count) as usize] {
                if let Some(hit) = triangle.intersect(ray)
                    && !on_hit(hit, ray)
                {
                    return;
                }
            }
        }
    }
}

/// Where the ray enters a node's box; infinite for a miss.
fn enter(node: &BinaryNode, ray: &Ray, inverse: Vec3) -> f32 {
    let t0 = (Vec3::from_array(node.min) - ray.origin) * inverse;
    let t1 = (Vec3::from_array(node.max) - ray.origin) * inverse;
    let near = t0.min(t1).max_element().max(ray.t_min);
    // A hair of slack, as rounding must not lose a triangle on the far face.
    let far = t0.max(t1).min_element().min(ray.t_max) * 1.000_001;
    if near <= far { near } else { f32::INFINITY }
}

impl BvhTriangle {
    /// A triangle by its corners: the first one of the first material, opaque.
    #[must_use]
    pub fn new([a, b, c]: [Vec3; 3]) -> Self {
        let [v0, edge1, edge2] = [a, b - a, c - a].map(|v| v.to_array());
        Self { v0, triangle_index: 0, edge1, material: 0, edge2, flags: 0 }
    }

    /// Whether a ray of this direction meets its front, where its corners are counter-clockwise.
    #[must_use]
    pub fn is_met_in_front(&self, direction: Vec3) -> bool {
        Vec3::from_array(self.edge1).cross(Vec3::from_array(self.edge2)).dot(direction) < 0.0
    }

    /// Möller and Trumbore's test, both sides.
    #[must_use]
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        let [v0, edge1, edge2] = [self.v0, self.edge1, self.edge2].map(Vec3::from_array);
        let p = ray.direction.cross(edge2);
        let inverse = edge1.dot(p).recip();
        let s = ray.origin - v0;
        let u = s.dot(p) * inverse;
        let q = s.cross(edge1);
        let v = ray.direction.dot(q) * inverse;
        let t = edge2.dot(q) * inverse;
        // Written so that NaN (a ray within the plane) is a miss.
        let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > ray.t_min && t < ray.t_max;
        inside.then_some(Hit { t, triangle_index: self.triangle_index, u, v })
    }
}

#[cfg(test)]
#[path = "bvh_tests.rs"]
mod tests;
