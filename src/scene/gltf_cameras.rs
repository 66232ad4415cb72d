//! Cameras of a glTF. One that cannot be used is left out: the scene has others, or gets one.

use std::collections::HashMap;

use ::gltf::json::camera::{Camera as JsonCamera, Orthographic, Perspective, Type};
use ::gltf::json::scene::Node;
use ::gltf::json::validation::Checked;
use glam::{Mat4, Vec3};

use super::Camera;
use super::gltf_buffers::Document;
use super::gltf_nodes::forward;
use super::gltf_notes::Thing;

/// Half heights of parallel views end here, in metres.
const MOST_HALF_HEIGHT: f32 = 1e9;
/// The near plane of cameras without a usable one, in metres.
const NEAR: f32 = 0.01;

/// What a camera's picture is like: its field of view in radians or half its height in metres, and its near plane.
enum Lens {
    Perspective { yfov_rad: f32, near: f32 },
    Parallel { half_height: f32, near: f32 },
}

impl Lens {
    /// The lens of a camera, or why it has none that can be used.
    fn of(document: &Document, camera: &JsonCamera, thing: &Thing) -> Result<Self, String> {
        match (&camera.type_, &camera.perspective, &camera.orthographic) {
            (Checked::Valid(Type::Perspective), Some(lens), _) => Self::perspective(document, lens, thing),
            (Checked::Valid(Type::Orthographic), _, Some(lens)) => Self::parallel(document, lens),
            (Checked::Valid(_), ..) => Err("it has no lens of its type".into()),
            (Checked::Invalid, ..) => Err("its type is neither perspective nor orthographic".into()),
        }
    }

    fn perspective(document: &Document, lens: &Perspective, thing: &Thing) -> Result<Self, String> {
        let yfov_rad = lens.yfov;
        if !(yfov_rad > 0.0 && yfov_rad < std::f32::consts::PI) {
            return Err(format!("its field of view is {yfov_rad}, not within 0 and pi"));
        }
        let mut near = lens.znear;
        if !(near.is_finite() && near > 0.0) {
            document.fault(thing.clone(), format!("has a znear that is not above 0: it is {NEAR} m instead"));
            near = NEAR;
        }
        Ok(Self::Perspective { yfov_rad, near })
    }

    fn parallel(document: &Document, lens: &Orthographic) -> Result<Self, String> {
        // A mirrored view is one that is turned by half a circle, which nothing here needs.
        let half_height = lens.ymag.abs();
        if !(half_height > 0.0 && half_height < MOST_HALF_HEIGHT) {
            return Err(format!("its ymag is {half_height}: no picture has that height"));
        }
        document.ignore("the parallel views of orthographic cameras (seen from far away instead)");
        let near = if lens.znear.is_finite() { lens.znear.max(0.0) } else { 0.0 };
        Ok(Self::Parallel { half_height, near })
    }
}

/// The camera of a node, if it has one that can be used, and for parallel views half the height of the picture.
pub(super) fn camera(
    document: &Document,
    (i, node): (usize, &Node),
    world: &Mat4,
    number: usize,
    names: &mut HashMap<String, u32>,
) -> Option<(Camera, Option<f32>)> {
    let index = node.camera?.value();
    let Some(json) = document.root.cameras.get(index) else {
        let fault = format!("is read without its camera: camera {index} does not exist");
        document.fault(Thing::new("node", i, node.name.as_ref()), fault);
        return None;
    };
    let thing = Thing::new("camera", index, json.name.as_ref().or(node.name.as_ref()));
    let lens = Lens::of(document, json, &thing);
    let lens = lens.map_err(|why| document.leave_out(thing, why)).ok()?;
    let (yfov_rad, near, half_height) = match lens {
        Lens::Perspective { yfov_rad, near } => (yfov_rad, near, None),
        Lens::Parallel { half_height, near } => (1.0, near, Some(half_height)),
    };
    let wanted = node.name.clone().or_else(|| json.name.clone()).unwrap_or_else(|| format!("camera {number}"));
    let (right_ws, up_ws, forward_ws) = frame(world);
    let (name, position_ws) = (unique(&wanted, names), world.w_axis.truncate());
    let camera = Camera { name, position_ws, right_ws, up_ws, forward_ws, yfov_rad, near, set_back: 0.0 };
    Some((camera, half_height))
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
