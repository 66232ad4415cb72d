//! Points that stand for the surfaces of a scene, and their tree: plain data, made before anything is drawn.
//!
//! The tree is complete and has no pointers: node 1 is the root, the children of node i are 2i and 2i + 1, leaf j of N is
//! node N + j, and the leaves of a node follow each other.

mod leaf_cells;
mod node;
mod sampling;
mod solid;
mod surface;
mod tree;

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::scene::Scene;
use crate::shared::POINT_IS_TURNED;
pub use crate::shared::PackedNode;
pub use leaf_cells::{CellRange, cell_of};
pub use node::{Node, pack_rgb9e5, unpack_rgb9e5};
pub use sampling::{Leaf, Sample};
pub use tree::{after_subtree, leaves_of};

/// Most points: 2 to this power.
pub const MAX_LEAF_COUNT_LOG2: u32 = 21;

/// The points of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct PointCloud {
    /// Binary logarithm of the number of leaves.
    pub leaf_count_log2: u32,
    /// Radius of a leaf's disc; the discs' areas sum to the visible surface.
    pub leaf_radius: f32,
    /// The tree in heap order; element 0 is unused.
    pub nodes: Vec<PackedNode>,
    /// Albedo of each node, RGB9E5.
    pub albedos: Vec<u32>,
    /// The leaf that stands for each cell of each triangle.
    pub leaf_cells: Vec<u32>,
    /// Per triangle of the scene its cells.
    pub triangle_cells: Vec<CellRange>,
}

impl PointCloud {
    /// Spreads 2 to the power `leaf_count_log2` points over the surfaces of a scene.
    ///
    /// # Errors
    /// [`Error::Failure`] for more points than a node has bits for, and for a scene of which nothing can be seen.
    pub fn of_scene(scene: &Scene, leaf_count_log2: u32) -> Result<Self> {
        if leaf_count_log2 > MAX_LEAF_COUNT_LOG2 {
            return Err(Error::Failure(format!(
                "2^{leaf_count_log2} points are too many: at most 2^{MAX_LEAF_COUNT_LOG2} have room"
            )));
        }
        let sample = sampling::sample(scene, 1 << leaf_count_log2).ok_or_else(|| {
            Error::Failure(format!("scene {} has no visible surface for points to lie on", scene.name))
        })?;
        Ok(Self::of_leaves(scene, sample))
    }

    /// The tree over leaves that were sampled.
    fn of_leaves(scene: &Scene, Sample { mut leaves, leaf_area }: Sample) -> Self {
        tree::order(&mut leaves);
        let leaf_radius = (leaf_area / std::f32::consts::PI).sqrt();
        let discs = node::Discs { leaves: &leaves, area: leaf_area, radius: leaf_radius };
        let mut found: Vec<(Node, Vec3)> =
            (0..2 * leaves.len()).into_par_iter().map(|node| discs.node(node.max(1))).collect();
        for i in (2..found.len()).rev() {
            found[i].0.is_turned = found[i].0.normal.dot(found[i / 2].0.normal) < 0.0;
        }
        let nodes: Vec<Node> = found.iter().map(|(node, _)| *node).collect();
        let (leaf_cells, triangle_cells) = leaf_cells::assign(scene, &leaves, &nodes);
        Self {
            leaf_count_log2: leaves.len().ilog2(),
            leaf_radius,
            nodes: nodes.iter().map(Node::pack).collect(),
            albedos: found.iter().map(|(_, albedo)| pack_rgb9e5(*albedo)).collect(),
            leaf_cells,
            triangle_cells,
        }
    }

    /// Number of leaves.
    #[must_use]
    pub fn leaf_count(&self) -> u32 {
        1 << self.leaf_count_log2
    }

    /// A node, from 1 on.
    #[must_use]
    pub fn node(&self, index: u32) -> Node {
        Node::unpack(&self.nodes[index as usize])
    }

    /// A bit for each node: whether its normal opposes its parent's.
    #[must_use]
    pub fn turned_bits(&self) -> Vec<u32> {
        let bit = |node: &PackedNode| u32::from(node.leaf_and_flags & POINT_IS_TURNED != 0);
        let word = |nodes: &[PackedNode]| nodes.iter().rev().fold(0, |word, node| word << 1 | bit(node));
        self.nodes.chunks(32).map(word).collect()
    }

    /// The leaf that stands for a point of a triangle. `barycentrics` are the weights of its second and third corner.
    #[must_use]
    pub fn leaf_of_hit(&self, triangle: u32, barycentrics: Vec2) -> u32 {
        let CellRange { first, edge } = self.triangle_cells[triangle as usize];
        self.leaf_cells[(first + cell_of(edge, barycentrics)) as usize]
    }
}

#[cfg(test)]
mod tests;
