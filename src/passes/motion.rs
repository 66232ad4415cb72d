//! `motion`: the vertices and triangles of a scene that moves, at a moment. These passes are no part of a frame: they have a graph
//! of their own (`scene_mover`), which runs before the first frame of a moment, and frames of all techniques read what it leaves.

use std::sync::Arc;

use super::scene::SceneParts;
use super::{shader, threads};
use crate::gpu::{ComputeWork, TransferOp, Work};
use crate::graph::{Access, BufferHandle, Graph, Pass};
use crate::scene::motion::MovingMeshes;
use crate::scene::refit::MovingParts;
use crate::shared::MovedTree;

/// What the passes leave beside the scene's parts.
#[derive(Clone, Copy, Debug)]
pub struct Moved {
    /// Where the meshes are at the moment ([`MovingMeshes::pose`]): to be written before.
    pub pose: BufferHandle,
    /// A [`MovedTree`].
    pub tree: BufferHandle,
}

/// Adds `motion/keep_vertices`, which leaves the vertices of the moment before as the previous ones, `motion/move_vertices` and
/// `motion/move_triangles`.
pub fn add(graph: &mut Graph<Work>, scene: &mut SceneParts, meshes: &MovingMeshes, parts: &MovingParts) -> Moved {
    let pose = graph.persistent_buffer("pose", 4 * meshes.pose_words() as u64);
    let tree = graph.persistent_buffer("moved_tree", size_of::<MovedTree>() as u64);
    let moved = Moved { pose, tree };
    keep_vertices(graph, scene, moved);
    move_vertices(graph, scene, meshes, moved);
    move_triangles(graph, scene, parts, moved);
    moved
}

/// A buffer that has its contents from the start; a zero stands for none, as no buffer is empty.
pub(super) fn filled<T: bytemuck::Pod>(graph: &mut Graph<Work>, name: &str, list: &[T]) -> BufferHandle {
    let contents: Arc<[u8]> =
        if list.is_empty() { vec![0; size_of::<T>()].into() } else { bytemuck::cast_slice(list).into() };
    graph.filled_buffer(name, contents)
}

fn keep_vertices(graph: &mut Graph<Work>, scene: &mut SceneParts, moved: Moved) {
    let previous = scene.declare_previous(graph);
    let keep = TransferOp::Copy { from: scene.vertices, to: previous, offset_bytes: 0 };
    let clear = TransferOp::Fill { buffer: moved.tree, value: 0 };
    let pass = Pass::new("motion/keep_vertices", Work::Transfer(vec![keep, clear]))
        .uses(scene.vertices, Access::TransferRead)
        .uses(previous, Access::TransferWrite)
        .uses(moved.tree, Access::TransferWrite);
    graph.add_pass(pass);
}

fn move_vertices(graph: &mut Graph<Work>, scene: &SceneParts, meshes: &MovingMeshes, moved: Moved) {
    let count = meshes.vertex_count() as u32;
    let bodies = filled(graph, "moving_bodies", &meshes.bodies);
    let vertices = filled(graph, "rest_vertices", &meshes.vertices);
    let joints = filled(graph, "joint_weights", &meshes.joints);
    let offsets = filled(graph, "morph_offsets", &meshes.offsets);
    let work = ComputeWork { push: vec![count], ..shader("motion/move_vertices", threads(count)) };
    let pass = Pass::new("motion/move_vertices", Work::Compute(work))
        .bind("moving_bodies", bodies, Access::ComputeRead)
        .bind("rest_vertices", vertices, Access::ComputeRead)
        .bind("joint_weights", joints, Access::ComputeRead)
        .bind("morph_offsets", offsets, Access::ComputeRead)
        .bind("pose", moved.pose, Access::ComputeRead)
        .bind("scene_vertices", scene.vertices, Access::ComputeReadWrite)
        .bind("scene_tangents", scene.tangents, Access::ComputeReadWrite);
    graph.add_pass(pass);
}

fn move_triangles(graph: &mut Graph<Work>, scene: &SceneParts, parts: &MovingParts, moved: Moved) {
    let count = parts.triangles.len() as u32;
    let triangles = filled(graph, "moving_triangles", &parts.triangles);
    let work = ComputeWork { push: vec![count], ..shader("motion/move_triangles", threads(count)) };
    let pass = Pass::new("motion/move_triangles", Work::Compute(work))
        .bind("moving_triangles", triangles, Access::ComputeRead)
        .bind("scene_vertices", scene.vertices, Access::ComputeRead)
        .bind("scene_indices", scene.indices, Access::ComputeRead)
        .bind("bvh_triangles", scene.triangles, Access::ComputeReadWrite)
        .bind("moved_tree", moved.tree, Access::ComputeReadWrite);
    graph.add_pass(pass);
}
