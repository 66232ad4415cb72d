//! Moves a scene on its device: vertices, triangles and the boxes of the BVH follow the animations that play.

use std::sync::Arc;

use crate::error::{Error, Result};
use crate::gpu::{Executor, Gpu};
use crate::graph::Graph;
use crate::passes::motion::{self, Moved};
use crate::passes::scene::SceneParts;
use crate::passes::{refit, structures};
use crate::scene::Scene;
use crate::scene::motion::{MovingMeshes, PoseLayout};
use crate::scene::refit::MovingParts;
use crate::settings::Rays;
use crate::shared::{MovedTree, NodeBox};
use crate::uploaded_scene::UploadedScene;

/// What moves a scene that was uploaded.
pub struct SceneMover {
    gpu: Arc<Gpu>,
    /// `None` where no vertices move, or the host moves them.
    device: Option<DeviceMover>,
    pass_ms: Vec<f64>,
}

/// Passes that move vertices and what follows from them.
struct DeviceMover {
    poses: PoseLayout,
    executor: Executor,
    moved: Moved,
    /// Whether the device has the tree that the passes refit, and not one that was built for a moment.
    has_built_tree: bool,
}

impl SceneMover {
    /// For a scene whose animations have been chosen.
    ///
    /// # Errors
    /// Device errors.
    pub fn new(gpu: &Arc<Gpu>, scene: &Scene, uploaded: &UploadedScene) -> Result<Self> {
        let device = if uploaded.has_moving_vertices() { DeviceMover::new(gpu, scene, uploaded)? } else { None };
        let pass_ms = device.as_ref().map_or_else(Vec::new, DeviceMover::no_ms);
        Ok(Self { gpu: Arc::clone(gpu), device, pass_ms })
    }

    /// Names of its passes; none where no vertices move.
    #[must_use]
    pub fn pass_names(&self) -> Vec<String> {
        let graph = self.device.as_ref().map(|device| device.executor.graph());
        graph.map_or_else(Vec::new, |graph| graph.passes().iter().map(|pass| pass.name.clone()).collect())
    }

    /// How long each of them took when they ran last, in milliseconds; nothing where they have not since this was asked.
    pub fn take_pass_ms(&mut self) -> Vec<f64> {
        let none = self.device.as_ref().map_or_else(Vec::new, DeviceMover::no_ms);
        std::mem::replace(&mut self.pass_ms, none)
    }

    /// Puts on the device where the scene, which is the one that was uploaded, has everything that moves. Its vertices may be
    /// behind ([`Scene::pose_without_vertices`]). Waits; no frame may be running. Points that stand for its surfaces have to be
    /// spread again.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn follow(&mut self, uploaded: &mut UploadedScene, scene: &mut Scene) -> Result<()> {
        let Some(device) = &mut self.device else {
            scene.pose_vertices();
            return uploaded.follow(&self.gpu, scene);
        };
        uploaded.follow_lighting(&self.gpu, scene)?;
        if !scene.motion.moves().geometry {
            return Ok(());
        }
        self.pass_ms = device.follow(&self.gpu, uploaded, scene)?;
        Ok(())
    }
}

impl DeviceMover {
    /// `None` where the device has no room for what it would need.
    fn new(gpu: &Arc<Gpu>, scene: &Scene, uploaded: &UploadedScene) -> Result<Option<Self>> {
        let Some(tree) = uploaded.moving_bvh() else { return Ok(None) };
        let (meshes, parts) = (MovingMeshes::new(scene), tree.moving_parts(scene));
        if most_bytes(&meshes, &parts, tree.boxes().len()) > gpu.report().limits.storage_range_bytes {
            log::info!("the host moves the scene's vertices: what the device would need exceeds its buffers");
            return Ok(None);
        }
        let mut graph = Graph::new();
        let rays = if uploaded.has_structures { Rays::Query } else { Rays::Bvh };
        let mut scene_parts = SceneParts::declare(&mut graph, rays);
        let nodes = scene_parts.declare_nodes(&mut graph);
        let moved = motion::add(&mut graph, &mut scene_parts, &meshes, &parts);
        refit::add(&mut graph, (scene_parts.triangles, nodes), tree, &parts, moved);
        structures::add(&mut graph, &scene_parts, uploaded.set());
        let executor = match Executor::new(gpu, graph, Some(Arc::clone(uploaded.set()))) {
            Err(error @ Error::Memory { .. }) => {
                log::info!("the host moves the scene's vertices: {error}");
                return Ok(None);
            }
            executor => executor?,
        };
        Ok(Some(Self { poses: meshes.poses, executor, moved, has_built_tree: false }))
    }

    fn no_ms(&self) -> Vec<f64> {
        vec![0.0; self.executor.graph().passes().len()]
    }

    fn follow(&mut self, gpu: &Arc<Gpu>, uploaded: &mut UploadedScene, scene: &mut Scene) -> Result<Vec<f64>> {
        let Some(tree) = uploaded.moving_bvh().map(Arc::clone) else { return Ok(Vec::new()) };
        if !self.has_built_tree {
            uploaded.replace_tree(gpu, scene, tree.built())?;
            self.has_built_tree = true;
        }
        self.executor.write_buffer(self.moved.pose, bytemuck::cast_slice(&self.poses.pose(scene)))?;
        let ticket = self.executor.submit(&[])?;
        let pass_ms = self.executor.wait(ticket)?.pass_ms;
        let MovedTree { largest_triangle, cost } =
            bytemuck::pod_read_unaligned(&self.executor.read_buffer(self.moved.tree)?);
        uploaded.vertices_have_moved(f32::from_bits(largest_triangle));
        if tree.is_bad(cost) {
            scene.pose_vertices();
            if let Some(anew) = tree.built_anew(scene, cost) {
                uploaded.replace_tree(gpu, scene, &anew)?;
                self.has_built_tree = false;
            }
        }
        Ok(pass_ms)
    }
}

/// Bytes of the largest buffer that the passes need.
fn most_bytes(meshes: &MovingMeshes, parts: &MovingParts, node_count: usize) -> u64 {
    let sizes = [
        size_of_val(meshes.vertices.as_slice()),
        size_of_val(meshes.joints.as_slice()),
        size_of_val(meshes.offsets.as_slice()),
        size_of_val(meshes.bodies.as_slice()),
        size_of_val(parts.triangles.as_slice()),
        4 * meshes.pose_words(),
        node_count * size_of::<NodeBox>(),
    ];
    sizes.into_iter().max().unwrap_or(0) as u64
}
