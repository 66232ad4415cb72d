//! Which leaf stands for a point of a triangle: triangles are divided into cells, and each names one.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::node::Node;
use super::sampling::Leaf;
use super::surface::{Surface, Triangle};
use crate::scene::Scene;

/// Cosine of the angle up to which the normals of a triangle and of a leaf that is not its own agree.
const AGREEING_COS: f32 = 0.5;

/// The cells of a triangle.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct CellRange {
    /// The first of them.
    pub first: u32,
    /// Cells along an edge; there are as many as its square.
    pub edge: u32,
}

/// The cell, counted from a triangle's first, that a point of it lies in, where it has `edge` cells along an edge.
/// Row i of the second corner's weight has 2 (edge - i) - 1 cells, pointing up and down in turns.
#[must_use]
pub fn cell_of(edge: u32, barycentrics: Vec2) -> u32 {
    let scaled = barycentrics.max(Vec2::ZERO) * edge as f32;
    let row = (scaled.x as u32).min(edge - 1);
    let column = (scaled.y as u32).min(edge - 1 - row);
    let rest = scaled - Vec2::new(row as f32, column as f32);
    let points_down = rest.x + rest.y > 1.0 && row + column + 1 < edge;
    row * (2 * edge - row) + 2 * column + u32::from(points_down)
}

/// The middles of all cells in the order of [`cell_of`].
fn cell_middles(edge: u32) -> impl Iterator<Item = Vec2> {
    let row_cells = move |row: u32| (0..2 * (edge - row) - 1).map(move |cell| (row, cell / 2, cell % 2));
    (0..edge).flat_map(row_cells).map(move |(row, column, down)| {
        let third = (1 + down) as f32 / 3.0;
        (Vec2::new(row as f32, column as f32) + third) / edge as f32
    })
}

/// Leaves by cell, and the cells of each triangle.
pub(super) fn assign(scene: &Scene, leaves: &[Leaf], nodes: &[Node]) -> (Vec<u32>, Vec<CellRange>) {
    let surface = Surface::without_textures(scene);
    let mut own: Vec<Vec<u32>> = vec![Vec::new(); surface.triangle_count()];
    for (leaf, index) in leaves.iter().zip(0..) {
        own[leaf.triangle as usize].push(index);
    }
    let mut first = 0;
    let range = |own: &Vec<u32>| {
        let edge = (own.len() as f64).sqrt().ceil().max(1.0) as u32;
        first += edge * edge;
        CellRange { first: first - edge * edge, edge }
    };
    let ranges: Vec<CellRange> = own.iter().map(range).collect();
    let search = Search { leaves, nodes };
    let cells = (0..ranges.len())
        .into_par_iter()
        .flat_map_iter(|index| search.cells(&surface.triangle(index), index as u32, ranges[index].edge, &own[index]));
    (cells.collect(), ranges)
}

/// The leaves in their tree.
struct Search<'a> {
    leaves: &'a [Leaf],
    nodes: &'a [Node],
}

/// Own leaves up to which trying each is faster than the tree.
const FEW_LEAVES: usize = 24;

impl Search<'_> {
    /// The leaf of each cell of a triangle.
    fn cells(&self, triangle: &Triangle, index: u32, edge: u32, own: &[u32]) -> Vec<u32> {
        let normal = triangle.normal();
        let distance = |leaf: u32, place: Vec3| self.leaves[leaf as usize].position_ws.distance_squared(place);
        let mut hint = own.first().copied();
        let leaf = |middle: Vec2| {
            let place = triangle.position(middle);
            if own.len() <= FEW_LEAVES
                && let Some(leaf) = own.iter().min_by(|a, b| distance(**a, place).total_cmp(&distance(**b, place)))
            {
                return *leaf;
            }
            let found = if own.is_empty() {
                self.nearest(place, hint, |node| may_agree(node, normal), |leaf| leaf.normal.dot(normal) > AGREEING_COS)
            } else {
                self.nearest(place, hint, |_| true, |leaf| leaf.triangle == index)
            };
            let found = found.or_else(|| self.nearest(place, None, |_| true, |_| true)).unwrap_or(0);
            hint = Some(found);
            found
        };
        cell_middles(edge).map(leaf).collect()
    }

    /// The nearest leaf that is accepted; `hint` is one of them. Subtrees that cannot have one are left out.
    fn nearest(
        &self,
        place: Vec3,
        hint: Option<u32>,
        may_have: impl Fn(&Node) -> bool,
        accepts: impl Fn(&Leaf) -> bool,
    ) -> Option<u32> {
        let leaf_count = self.leaves.len() as u32;
        let distance = |leaf: u32| self.leaves[leaf as usize].position_ws.distance(place);
        let mut found = hint.map(|leaf| (distance(leaf), leaf));
        let enter = |node: u32| {
            let node = &self.nodes[node as usize];
            if may_have(node) { node.centroid_ws.distance(place) - node.radius } else { f32::INFINITY }
        };
        let mut stack = vec![(enter(1), 1)];
        while let Some((least, node)) = stack.pop() {
            if least == f32::INFINITY || found.is_some_and(|(nearest, _)| least >= nearest) {
                continue;
            }
            if node < leaf_count {
                let [left, right] = [2 * node, 2 * node + 1].map(|child| (enter(child), child));
                stack.extend(if left.0 <= right.0 { [right, left] } else { [left, right] });
                continue;
            }
            let leaf = node - leaf_count;
            let nearer = found.is_none_or(|(nearest, _)| distance(leaf) < nearest);
            if nearer && accepts(&self.leaves[leaf as usize]) {
                found = Some((distance(leaf), leaf));
            }
        }
        found.map(|(_, leaf)| leaf)
    }
}

/// Whether a leaf of the node may have a normal that agrees with this one.
fn may_agree(node: &Node, normal: Vec3) -> bool {
    let (cos, cone_cos) = (node.normal.dot(normal), node.cone_cos.clamp(-1.0, 1.0));
    let sines = ((1.0 - cos * cos) * (1.0 - cone_cos * cone_cos)).max(0.0).sqrt();
    // The cosine of what is left of the angle between them when the cone is opened towards the normal.
    cos >= cone_cos || cos * cone_cos + sines > AGREEING_COS - 1e-3
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_middle_lies_in_its_cell() {
        for edge in 1..40 {
            let cells: Vec<u32> = cell_middles(edge).map(|middle| cell_of(edge, middle)).collect();
            assert_eq!(cells, (0..edge * edge).collect::<Vec<_>>());
        }
    }

    #[test]
    fn points_on_and_beyond_the_rim_have_a_cell() {
        for edge in [1, 2, 7, 1449] {
            for x in [-1e-6, 0.0, 0.3, 0.999_999_9, 1.0, 1.000_001] {
                for y in [-1e-6, 0.0, 1.0 - x, 1.0 - x + 1e-6] {
                    assert!(cell_of(edge, Vec2::new(x, y)) < edge * edge, "{edge} {x} {y}");
                }
            }
        }
    }
}
