//! Extensions of nodes that say whether and how often their meshes are there.

use std::collections::BTreeMap;

use ::gltf::json::Index;
use ::gltf::json::scene::Node;
use glam::{Mat4, Quat, Vec3};
use serde::Deserialize;

use super::gltf_buffers::Document;
use super::gltf_notes::Thing;
use crate::Result;

/// Whether `KHR_node_visibility` leaves the node and its children visible.
pub(super) fn is_visible(document: &Document, i: usize, node: &Node) -> bool {
    #[derive(Deserialize)]
    struct Visibility {
        visible: Option<bool>,
    }
    let others = node.extensions.as_ref().map(|e| &e.others);
    let thing = Thing::new("node", i, node.name.as_ref());
    let found = document.spare_extension::<Visibility>(thing, others, "KHR_node_visibility");
    found.and_then(|found| found.visible).unwrap_or(true)
}

/// The places of the node's mesh, relative to the node, where it has `EXT_mesh_gpu_instancing`.
pub(super) fn places(document: &Document, i: usize, node: &Node) -> Result<Option<Vec<Mat4>>> {
    #[derive(Deserialize)]
    struct Instancing {
        attributes: BTreeMap<String, u32>,
    }
    let others = node.extensions.as_ref().map(|e| &e.others);
    let what = format!("node {i}");
    let Some(instancing) = document.extension::<Instancing>(&what, others, "EXT_mesh_gpu_instancing")? else {
        return Ok(None);
    };
    let attribute = |name: &str| instancing.attributes.get(name).map(|accessor| Index::new(*accessor));
    let vectors = |name: &str| attribute(name).map(|index| document.read_floats::<3>(&what, index)).transpose();
    let translations = vectors("TRANSLATION")?;
    let scales = vectors("SCALE")?;
    let rotations = attribute("ROTATION").map(|index| document.read_floats::<4>(&what, index)).transpose()?;
    let counts = [translations.as_ref().map(Vec::len), scales.as_ref().map(Vec::len), rotations.as_ref().map(Vec::len)];
    let count = counts.into_iter().flatten().max().unwrap_or(0);
    if counts.into_iter().flatten().any(|other| other != count) {
        return Err(document.error(format_args!("{what} has instances with attributes of different counts")));
    }
    let place = |n: usize| {
        let translation = translations.as_ref().map_or(Vec3::ZERO, |list| Vec3::from_array(list[n]));
        let scale = scales.as_ref().map_or(Vec3::ONE, |list| Vec3::from_array(list[n]));
        let rotation = rotations.as_ref().map_or(Quat::IDENTITY, |list| Quat::from_array(list[n]).normalize());
        Mat4::from_scale_rotation_translation(scale, rotation, translation)
    };
    let places: Vec<Mat4> = (0..count).map(place).collect();
    if let Some(n) = places.iter().position(|place| !place.is_finite()) {
        return Err(document.error(format_args!("{what} has the instance {n} with a transform that is not finite")));
    }
    Ok(Some(places))
}
