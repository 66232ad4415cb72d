//! Scenes that move: where nodes, cameras, lights and meshes are at a moment. No Vulkan here; `docs/motion.md` has what
//! moves and what does not yet.

mod body;
mod clip;
mod device;
mod lamps;
mod nodes;
mod play;
mod read;
mod read_body;
mod sampler;

use glam::Mat4;

use body::Skin;
pub(in crate::scene) use body::{Body, Target as MorphTarget};
use clip::{Channel, Clip};
pub(in crate::scene) use clip::{LightProperty, Property, Target};
pub use device::{MovingMeshes, PoseLayout};
use nodes::{Hierarchy, Posed};

use super::gltf_lights::LightParts;
use super::{Camera, Light, Vertex};

/// What of a scene moves, and how.
#[derive(Debug, Default)]
pub struct Motion {
    hierarchy: Hierarchy,
    clips: Vec<Clip>,
    skins: Vec<Skin>,
    bodies: Vec<Body>,
    cameras: Vec<Carried<Camera>>,
    lights: Vec<Carried<Light>>,
    /// Each light while it emits most, as the clips that play have it; empty where lights shine evenly.
    brightest: Vec<Light>,
    /// Lights of the file at rest.
    lamps: Vec<LightParts>,
    /// Clips that play, by their indices.
    playing: Vec<usize>,
    /// The moment that cameras and lights are at; `None` while they are where they are when nothing plays.
    posed_s: Option<f64>,
    /// The same of the vertices.
    vertices_s: Option<f64>,
}

/// Something of the scene that a node carries.
#[derive(Clone, Debug)]
pub(in crate::scene) struct Carried<T> {
    /// The node.
    pub node: usize,
    /// The index of the light or camera in the file.
    pub index: usize,
    /// What it carries, as it is at rest.
    pub at_rest: T,
}

/// What moves while the clips that were chosen play.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Moves {
    /// Vertices.
    pub geometry: bool,
    /// Lights.
    pub lights: bool,
    /// Cameras.
    pub cameras: bool,
}

impl Moves {
    /// Whether anything does.
    #[must_use]
    pub fn any(self) -> bool {
        self.geometry || self.lights || self.cameras
    }
}

impl Motion {
    /// Names of the animations, in the order of the file.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.clips.iter().map(|clip| clip.name.as_str())
    }

    /// How long the animations that play last, the longest of them, in seconds.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.playing_clips().map(|clip| clip.duration_s).fold(0.0, f64::max)
    }

    fn playing_clips(&self) -> impl Iterator<Item = &Clip> {
        self.playing.iter().map(|clip| &self.clips[*clip])
    }

    /// Nodes that any of these clips moves.
    fn moved_by<'a>(&self, clips: impl Iterator<Item = &'a Clip>) -> Vec<bool> {
        self.hierarchy.with_descendants(clips.flat_map(|clip| &clip.channels).filter_map(Channel::node))
    }

    /// Where the nodes are when nothing plays.
    fn rest(&self) -> Posed {
        self.hierarchy.pose(std::iter::empty(), 0.0)
    }

    /// Puts vertices where they are when nothing plays.
    pub(in crate::scene) fn pose_at_rest(&self, vertices: &mut [Vertex], tangents: &mut [u32]) {
        let posed = self.rest();
        self.bodies.iter().for_each(|body| body.pose(&posed, &self.skins, vertices, tangents));
    }

    /// Takes over the cameras of a scene where nothing has moved yet, in the order in which they were read.
    pub(in crate::scene) fn set_cameras(&mut self, cameras: &[Camera]) {
        self.cameras.iter_mut().zip(cameras).for_each(|(carried, camera)| carried.at_rest.clone_from(camera));
    }

    fn body_moves(&self, body: &Body, moved: &[bool]) -> bool {
        let joints = body.skin.map_or(&[][..], |skin| &self.skins[skin].joints);
        moved[body.node] || joints.iter().any(|joint| moved[*joint])
    }
}

impl Camera {
    /// The same camera where its node has gone.
    pub(in crate::scene) fn carried_to(&self, world: &Mat4) -> Self {
        let (right_ws, up_ws, forward_ws) = super::gltf_cameras::frame(world);
        let position_ws = world.w_axis.truncate() - forward_ws * self.set_back;
        Self { position_ws, right_ws, up_ws, forward_ws, ..self.clone() }
    }
}

impl Light {
    /// The same light where its node has gone.
    pub(in crate::scene) fn carried_to(&self, world: &Mat4) -> Self {
        let (place, axis) = (world.w_axis.truncate(), super::gltf_nodes::forward(world));
        let mut light = self.clone();
        match &mut light {
            Self::Directional { direction_ws, .. } => *direction_ws = axis,
            Self::Point { position_ws, .. } => *position_ws = place,
            Self::Spot { position_ws, direction_ws, .. } => (*position_ws, *direction_ws) = (place, axis),
        }
        light
    }
}

#[cfg(test)]
mod tangent_tests;
#[cfg(test)]
mod tests;
