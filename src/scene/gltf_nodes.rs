//! The node hierarchy: world transforms of meshes, and the cameras and lights along the way.

use std::collections::{HashMap, HashSet};

use ::gltf::json::camera::Type as CameraType;
use ::gltf::json::extensions::scene::khr_lights_punctual::{Light as JsonLight, Type as LightType};
use ::gltf::json::scene::Node;
use ::gltf::json::validation::Checked;
use glam::{Mat4, Quat, Vec3};

use super::gltf_buffers::Document;
use super::gltf_instancing::{is_visible, places};
use super::{Aabb, Camera, Light};
use crate::Result;
use crate::environment::{DEFAULT_DIRECTION_TO_SUN, DEFAULT_SUN_IRRADIANCE};

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

/// What the walk over the nodes finds.
#[derive(Default)]
pub(super) struct Found {
    /// Meshes.
    pub instances: Vec<Instance>,
    /// Perspective cameras.
    pub cameras: Vec<Camera>,
    /// The node of each.
    pub camera_nodes: Vec<usize>,
    /// Lights that shine.
    pub lights: Vec<Light>,
    /// The node of each.
    pub light_nodes: Vec<usize>,
    /// There are lights, but all of them are dark.
    pub is_dark: bool,
}

/// Walks the default scene, depth first, visiting every node once.
pub(super) fn walk(document: &Document) -> Result<Found> {
    let nodes = &document.root.nodes;
    let mut visited = vec![false; nodes.len()];
    let mut stack: Vec<_> = roots(document)?.into_iter().rev().map(|n| (n, Mat4::IDENTITY, true)).collect();
    let mut found = Found::default();
    let mut names = HashMap::new();
    while let Some((i, parent, parent_is_visible)) = stack.pop() {
        let Some(node) = nodes.get(i) else {
            return Err(document.error(format_args!("node {i} does not exist")));
        };
        if std::mem::replace(&mut visited[i], true) {
            return Err(document.error(format_args!("node {i} is reached twice: the nodes do not form a tree")));
        }
        let local = local_transform(node);
        let world = parent * local.unwrap_or(Mat4::NAN);
        if !world.is_finite() {
            return Err(document.error(format_args!("node {i} has a transform that is not finite")));
        }
        let is_visible = parent_is_visible && is_visible(document, i, node)?;
        if let Some(mesh) = node.mesh.filter(|_| is_visible) {
            let places = places(document, i, node)?.unwrap_or_else(|| vec![Mat4::IDENTITY]);
            let instance = |place: Mat4| Instance { mesh: mesh.value(), node: i, place, world: world * place };
            found.instances.extend(places.into_iter().map(instance));
        }
        found.cameras.extend(camera(document, node, &world, found.cameras.len(), &mut names)?);
        match light(document, node, &world)?.filter(|_| is_visible) {
            Some(light) if light.is_dark() => found.is_dark = true,
            light => found.lights.extend(light),
        }
        found.camera_nodes.resize(found.cameras.len(), i);
        found.light_nodes.resize(found.lights.len(), i);
        let children = node.children.iter().flatten();
        stack.extend(children.rev().map(|child| (child.value(), world, is_visible)));
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

fn camera(
    document: &Document,
    node: &Node,
    world: &Mat4,
    number: usize,
    names: &mut HashMap<String, u32>,
) -> Result<Option<Camera>> {
    let Some(index) = node.camera.map(|c| c.value()) else { return Ok(None) };
    let Some(camera) = document.root.cameras.get(index) else {
        return Err(document.error(format_args!("camera {index} does not exist")));
    };
    let (Checked::Valid(CameraType::Perspective), Some(lens)) = (&camera.type_, &camera.perspective) else {
        document.ignore("cameras without perspective");
        return Ok(None);
    };
    if !(lens.yfov > 0.0 && lens.yfov < std::f32::consts::PI) {
        let yfov = lens.yfov;
        return Err(document.error(format_args!("camera {index} has the field of view {yfov}, not within 0 and pi")));
    }
    let wanted = node.name.clone().or_else(|| camera.name.clone()).unwrap_or_else(|| format!("camera {number}"));
    let (right_ws, up_ws, forward_ws) = frame(world);
    Ok(Some(Camera {
        name: unique(&wanted, names),
        position_ws: world.w_axis.truncate(),
        right_ws,
        up_ws,
        forward_ws,
        yfov_rad: lens.yfov,
        near: if lens.znear.is_finite() && lens.znear > 0.0 { lens.znear } else { 0.01 },
    }))
}

/// `wanted`, or with the first free number behind it. `names` maps a name to the next number to try.
fn unique(wanted: &str, names: &mut HashMap<String, u32>) -> String {
    let mut name = wanted.to_owned();
    while names.contains_key(&name) {
        let number = names.entry(wanted.to_owned()).or_insert(2);
        name = format!("{wanted} {number}");
        *number += 1;
    }
    names.insert(name.clone(), 2);
    name
}

/// Right, up and forward of a camera at this transform: orthonormal and right-handed, whatever its scale.
pub(super) fn frame(world: &Mat4) -> (Vec3, Vec3, Vec3) {
    let forward = forward(world);
    let up = world.y_axis.truncate().normalize_or(Vec3::Y);
    let right = forward.cross(up).try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
    (right, right.cross(forward), forward)
}

/// The unit -z axis of a node.
pub(super) fn forward(world: &Mat4) -> Vec3 {
    (-world.z_axis.truncate()).normalize_or(Vec3::NEG_Z)
}

fn light(document: &Document, node: &Node, world: &Mat4) -> Result<Option<Light>> {
    let reference = node.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
    let Some(index) = reference.map(|r| r.light.value()) else { return Ok(None) };
    let lights = document.root.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
    let Some(light) = lights.and_then(|l| l.lights.get(index)) else {
        return Err(document.error(format_args!("light {index} does not exist")));
    };
    let power = Vec3::from_array(light.color) * light.intensity;
    if !power.is_finite() || power.min_element() < 0.0 {
        return Err(document.error(format_args!("light {index} has an intensity that is negative or not finite")));
    }
    let (position_ws, direction_ws) = (world.w_axis.truncate(), forward(world));
    match light.type_ {
        Checked::Valid(LightType::Directional) => Ok(Some(Light::Directional { direction_ws, irradiance: power })),
        Checked::Valid(LightType::Point) => Ok(Some(Light::Point { position_ws, intensity: power })),
        Checked::Valid(LightType::Spot) => {
            let (inner_cos, outer_cos) = cone(light);
            Ok(Some(Light::Spot { position_ws, direction_ws, intensity: power, inner_cos, outer_cos }))
        }
        Checked::Invalid => Err(document.error(format_args!("light {index} has an unknown type"))),
    }
}

/// Cosines of the inner and outer cone angles, the outer one strictly smaller.
fn cone(light: &JsonLight) -> (f32, f32) {
    let quarter = std::f32::consts::FRAC_PI_4;
    let (inner, outer) = light.spot.as_ref().map_or((0.0, quarter), |s| (s.inner_cone_angle, s.outer_cone_angle));
    let outer = if outer.is_finite() { outer.clamp(0.01, 2.0 * quarter) } else { quarter };
    let inner = if inner.is_finite() { inner.clamp(0.0, outer - 0.005) } else { 0.0 };
    (inner.cos(), outer.cos())
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
    }
}

/// The sun of scenes that bring no light.
pub(super) fn default_sun() -> Light {
    let irradiance = Vec3::splat(DEFAULT_SUN_IRRADIANCE);
    Light::Directional { direction_ws: -DEFAULT_DIRECTION_TO_SUN.normalize(), irradiance }
}
