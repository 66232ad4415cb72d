//! The node hierarchy: world transforms of meshes, and the cameras and lights along the way.

use std::collections::{HashMap, HashSet};

use ::gltf::json::scene::Node;
use glam::{Mat4, Quat, Vec3};

use super::gltf_buffers::Document;
use super::gltf_cameras::camera;
use super::gltf_instancing::{is_visible, places};
use super::gltf_lights::light;
use super::motion::{LightProperty, Property, Target};
use super::{Aabb, Camera, Light};
use crate::Result;
use crate::environment::{DEFAULT_DIRECTION_TO_SUN, DEFAULT_SUN_IRRADIANCE};

/// The most meshes that may be placed: few bytes suffice to place one very often.
const MAX_INSTANCES: usize = 1 << 22;

/// One mesh placed in the world.
pub(super) struct Instance {
    /// Index into the meshes of the glTF.
    pub mesh: usize,
    /// Index of the node that carries it.
    pub node: usize,
    /// From mesh to the node's space: where an instance of it is.
    pub place: Mat4,
    /// From mesh to world space.
    pub world: Mat4,
}

/// Where a camera or a light comes from.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source {
    /// The node that carries it.
    pub node: usize,
    /// What the node refers to.
    pub index: usize,
}

/// What animations change that decides what there is to render.
#[derive(Default)]
struct Changes {
    /// Nodes that are shown or hidden.
    visibilities: HashSet<usize>,
    /// Lights that may shine although they are dark at rest.
    lights: HashSet<usize>,
}

impl Changes {
    fn of(document: &Document) -> Self {
        let mut changes = Self::default();
        for target in document.pointers.targets() {
            match target {
                Target::Node { node, property: Property::Visibility } => {
                    changes.visibilities.insert(node);
                }
                Target::Light { light, property: LightProperty::Intensity | LightProperty::Color } => {
                    changes.lights.insert(light);
                }
                _ => {}
            }
        }
        changes
    }
}

/// A node on the way through the hierarchy.
struct Visit {
    node: usize,
    parent_world: Mat4,
    /// Whether what is above is visible at rest, and at some time.
    parent_is_visible: [bool; 2],
}

/// What the walk over the nodes finds.
#[derive(Default)]
pub(super) struct Found {
    /// Meshes.
    pub instances: Vec<Instance>,
    /// Cameras; those of parallel views have the place of their node.
    pub cameras: Vec<Camera>,
    /// Cameras of parallel views, each with half the height of its picture in metres.
    pub parallel: Vec<(usize, f32)>,
    /// The node of each camera, and its index in the file.
    pub camera_sources: Vec<Source>,
    /// Lights that shine at some time, as they are at rest.
    pub lights: Vec<Light>,
    /// The node of each, and its index in the file.
    pub light_sources: Vec<Source>,
    /// There are lights, but all of them are dark.
    pub is_dark: bool,
}

/// Walks the default scene, depth first, visiting every node once.
pub(super) fn walk(document: &Document) -> Result<Found> {
    let nodes = &document.root.nodes;
    let mut visited = vec![false; nodes.len()];
    let changes = Changes::of(document);
    let root = |node| Visit { node, parent_world: Mat4::IDENTITY, parent_is_visible: [true; 2] };
    let mut stack: Vec<_> = roots(document)?.into_iter().rev().map(root).collect();
    let mut found = Found::default();
    let mut names = HashMap::new();
    while let Some(Visit { node: i, parent_world, parent_is_visible }) = stack.pop() {
        let Some(node) = nodes.get(i) else {
            return Err(document.error(format_args!("node {i} does not exist")));
        };
        if std::mem::replace(&mut visited[i], true) {
            return Err(document.error(format_args!("node {i} is reached twice: the nodes do not form a tree")));
        }
        let local = local_transform(node);
        let world = parent_world * local.unwrap_or(Mat4::NAN);
        if !world.is_finite() {
            return Err(document.error(format_args!("node {i} has a transform that is not finite")));
        }
        let own = is_visible(document, i, node);
        let now = parent_is_visible[0] && own;
        let ever = parent_is_visible[1] && (own || changes.visibilities.contains(&i));
        if let Some(mesh) = node.mesh.filter(|_| ever) {
            let places = places(document, i, node)?.unwrap_or_else(|| vec![Mat4::IDENTITY]);
            if found.instances.len() + places.len() > MAX_INSTANCES {
                return Err(document.error(format_args!("the scene has more than {MAX_INSTANCES} instances of meshes")));
            }
            let instance = |place: Mat4| Instance { mesh: mesh.value(), node: i, place, world: world * place };
            found.instances.extend(places.into_iter().map(instance));
        }
        if let Some((camera, half_height)) = camera(document, (i, node), &world, found.cameras.len(), &mut names) {
            found.parallel.extend(half_height.map(|half_height| (found.cameras.len(), half_height)));
            found.cameras.push(camera);
            found.camera_sources.push(Source { node: i, index: node.camera.map_or(0, |camera| camera.value()) });
        }
        if let Some((light, index)) = light(document, (i, node), &world).filter(|_| ever) {
            if light.is_dark() && !changes.lights.contains(&index) {
                found.is_dark = true;
            } else {
                found.lights.push(if now { light } else { light.off() });
                found.light_sources.push(Source { node: i, index });
            }
        }
        let children = node.children.iter().flatten();
        let child = |child: usize| Visit { node: child, parent_world: world, parent_is_visible: [now, ever] };
        stack.extend(children.rev().map(|index| child(index.value())));
    }
    found.is_dark &= found.lights.is_empty();
    Ok(found)
}

/// The root nodes: those of the default (or first) scene, or without scenes those that are nobody's children.
pub(super) fn roots(document: &Document) -> Result<Vec<usize>> {
    let root = &document.root;
    let wanted = root.scene.map_or(0, |scene| scene.value());
    match root.scenes.get(wanted) {
        Some(scene) => Ok(scene.nodes.iter().map(|n| n.value()).collect()),
        None if root.scene.is_some() => Err(document.error(format_args!("scene {wanted} does not exist"))),
        None => {
            let children: HashSet<usize> =
                root.nodes.iter().flat_map(|n| n.children.iter().flatten()).map(|child| child.value()).collect();
            Ok((0..root.nodes.len()).filter(|i| !children.contains(i)).collect())
        }
    }
}

/// A node's own transform; `None` when its rotation is no rotation.
pub(super) fn local_transform(node: &Node) -> Option<Mat4> {
    if let Some(matrix) = &node.matrix {
        return Some(Mat4::from_cols_array(matrix));
    }
    let rotation = node.rotation.map_or(Quat::IDENTITY, |r| Quat::from_array(r.0));
    let length = rotation.length();
    if !(length.is_finite() && length > 1e-6) {
        return None;
    }
    let scale = node.scale.map_or(Vec3::ONE, Vec3::from_array);
    let translation = node.translation.map_or(Vec3::ZERO, Vec3::from_array);
    Some(Mat4::from_scale_rotation_translation(scale, rotation / length, translation))
}

/// The unit -z axis of a node.
pub(super) fn forward(world: &Mat4) -> Vec3 {
    (-world.z_axis.truncate()).normalize_or(Vec3::NEG_Z)
}

/// A camera that sees all of `bounds` from a diagonal, in any picture at least as wide as high.
pub(super) fn framing_camera(bounds: &Aabb) -> Camera {
    let yfov_rad = 45f32.to_radians();
    let radius = bounds.radius().max(1e-3);
    let forward_ws = Vec3::new(-0.6, -0.45, -1.0).normalize();
    let distance = 1.02 * radius / (0.5 * yfov_rad).sin();
    let right_ws = forward_ws.cross(Vec3::Y).normalize();
    Camera {
        name: "default".into(),
        position_ws: bounds.center() - forward_ws * distance,
        right_ws,
        up_ws: right_ws.cross(forward_ws),
        forward_ws,
        yfov_rad,
        near: 0.001 * radius,
        set_back: 0.0,
    }
}

/// The sun of scenes that bring no light.
pub(super) fn default_sun() -> Light {
    let irradiance = Vec3::splat(DEFAULT_SUN_IRRADIANCE);
    Light::Directional { direction_ws: -DEFAULT_DIRECTION_TO_SUN.normalize(), irradiance }
}
