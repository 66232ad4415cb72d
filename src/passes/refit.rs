//! `refit`: boxes of the BVH's nodes around triangles that have moved, from the lowest nodes to the root, a pass per height.

use super::motion::{Moved, filled};
use super::{shader, threads};
use crate::gpu::{ComputeWork, Work};
use crate::graph::{Access, Graph, ImageHandle, Pass};
use crate::scene::refit::{MovingBvh, MovingParts};

/// Adds `refit/level_0` and so on, after [`motion`](super::motion) has moved the triangles.
pub fn add(
    graph: &mut Graph<Work>,
    (triangles, nodes): (ImageHandle, ImageHandle),
    tree: &MovingBvh,
    parts: &MovingParts,
    moved: Moved,
) {
    let listed = filled(graph, "moving_nodes", &parts.levels.concat());
    let boxes = filled(graph, "node_boxes", tree.boxes());
    let mut first = 0;
    for (height, level) in parts.levels.iter().enumerate() {
        let count = level.len() as u32;
        let work = ComputeWork { push: vec![first, first + count], ..shader("refit/fit_nodes", threads(count)) };
        let pass = Pass::new(format!("refit/level_{height}"), Work::Compute(work))
            .bind("moving_nodes", listed, Access::ComputeRead)
            .bind("bvh_triangles", triangles, Access::ComputeSampled)
            .bind("bvh_nodes", nodes, Access::ComputeReadWrite)
            .bind("node_boxes", boxes, Access::ComputeReadWrite)
            .bind("moved_tree", moved.tree, Access::ComputeWrite);
        graph.add_pass(pass);
        first += count;
    }
}
