//! Reads what moves from a glTF: nodes, animations, skins.

use std::collections::BTreeMap;

use ::gltf::json::accessor::Accessor;
use ::gltf::json::animation::{Animation, Channel as JsonChannel, Interpolation, Property as JsonProperty};
use ::gltf::json::validation::Checked;
use ::gltf::json::{Index, scene};
use glam::{Mat4, Quat, Vec3};

use super::body::Skin;
use super::clip::{Channel, Clip, Property};
use super::nodes::{Hierarchy, Node, Parts};
use super::sampler::{Between, Sampler};
use super::{Carried, Motion};
use crate::Result;
use crate::scene::gltf_buffers::Document;
use crate::scene::gltf_lenient::NO_INDEX;
use crate::scene::gltf_nodes::{Found, local_transform, roots};

impl Motion {
    /// What of the file moves, without its meshes. Animations that cannot be played are noted.
    pub(in crate::scene) fn read(document: &Document, found: &Found) -> Result<Self> {
        let hierarchy = hierarchy(document)?;
        let animations = document.root.animations.iter().enumerate();
        let clips = animations.map(|(index, animation)| clip(document, &hierarchy, index, animation)).collect();
        let skins = (0..document.root.skins.len()).map(|index| skin(document, index)).collect::<Result<_>>()?;
        let cameras = found.cameras.iter().zip(&found.camera_nodes);
        let cameras = cameras.map(|(camera, node)| Carried { node: *node, at_rest: camera.clone() }).collect();
        let lights = found.lights.iter().zip(&found.light_nodes);
        let lights = lights.map(|(light, node)| Carried { node: *node, at_rest: light.clone() }).collect();
        Ok(Self { hierarchy, clips, skins, cameras, lights, ..Self::default() })
    }

    /// Which nodes move in any of the file's animations.
    pub(in crate::scene) fn moved_nodes(&self) -> Vec<bool> {
        self.moved_by(self.clips.iter())
    }

    /// Forgets everything where nothing can move.
    pub(in crate::scene) fn or_nothing(self) -> Self {
        if self.clips.is_empty() && self.bodies.is_empty() { Self::default() } else { self }
    }
}

fn hierarchy(document: &Document) -> Result<Hierarchy> {
    let nodes = &document.root.nodes;
    let mut parents = vec![None; nodes.len()];
    for (index, node) in nodes.iter().enumerate() {
        for child in node.children.iter().flatten().map(|child| child.value()).filter(|child| *child < nodes.len()) {
            parents[child].get_or_insert(index);
        }
    }
    // Where the scene begins nothing is above, whatever the file says beside it.
    roots(document)?.into_iter().filter(|root| *root < nodes.len()).for_each(|root| parents[root] = None);
    let weights = |node: &scene::Node| {
        let mesh = node.mesh.and_then(|mesh| document.root.meshes.get(mesh.value()));
        let own = node.weights.as_ref().filter(|weights| !weights.is_empty());
        own.or(mesh.and_then(|mesh| mesh.weights.as_ref())).cloned().unwrap_or_default()
    };
    let read = |(node, parent): (&scene::Node, Option<usize>)| {
        let rest = local_transform(node).unwrap_or(Mat4::IDENTITY);
        Node { parent, rest, parts: parts(node, &rest), weights: weights(node) }
    };
    Ok(Hierarchy::new(nodes.iter().zip(parents).map(read).collect()))
}

/// A node's transform in parts. What moves should have no matrix; one that has is taken apart.
fn parts(node: &scene::Node, rest: &Mat4) -> Parts {
    if node.matrix.is_some() {
        let (scale, rotation, translation) = rest.to_scale_rotation_translation();
        return Parts { translation, rotation, scale };
    }
    let rotation = node.rotation.map_or(Quat::IDENTITY, |rotation| Quat::from_array(rotation.0));
    Parts {
        translation: node.translation.map_or(Vec3::ZERO, Vec3::from_array),
        rotation: rotation / rotation.length(),
        scale: node.scale.map_or(Vec3::ONE, Vec3::from_array),
    }
}

/// An animation, with a note of channels that cannot be played.
fn clip(document: &Document, hierarchy: &Hierarchy, index: usize, animation: &Animation) -> Clip {
    let name = animation.name.clone().unwrap_or_else(|| format!("animation {index}"));
    let mut faults: BTreeMap<String, u32> = BTreeMap::new();
    let mut channels = Vec::new();
    // What moves no node moves something of an extension, which is named once for the whole file.
    let moves_a_node = |channel: &&JsonChannel| channel.target.node.value() != NO_INDEX as usize;
    for channel in animation.channels.iter().filter(moves_a_node) {
        match read_channel(document, hierarchy, animation, channel) {
            Ok(channel) => channels.push(channel),
            Err(fault) => *faults.entry(fault).or_default() += 1,
        }
    }
    for (fault, count) in faults {
        let channels = if count == 1 { "a channel".to_owned() } else { format!("{count} channels") };
        document.ignore(format!("{channels} of the animation {name} {fault}"));
    }
    Clip::new(name, channels)
}

/// A channel, or what is wrong with it.
fn read_channel(
    document: &Document,
    hierarchy: &Hierarchy,
    animation: &Animation,
    channel: &JsonChannel,
) -> std::result::Result<Channel, String> {
    let node = channel.target.node.value();
    let Some(target) = document.root.nodes.get(node) else {
        return Err(format!("for the node {node}, which does not exist"));
    };
    let (property, width) = match channel.target.path {
        Checked::Valid(JsonProperty::Translation) => (Property::Translation, 3),
        Checked::Valid(JsonProperty::Rotation) => (Property::Rotation, 4),
        Checked::Valid(JsonProperty::Scale) => (Property::Scale, 3),
        Checked::Valid(JsonProperty::MorphTargetWeights) => {
            let mesh = target.mesh.and_then(|mesh| document.root.meshes.get(mesh.value()));
            let targets = mesh.and_then(|mesh| mesh.primitives.first()?.targets.as_ref()).map_or(0, Vec::len);
            (Property::Weights, targets.max(hierarchy.nodes[node].weights.len()))
        }
        Checked::Invalid => return Err("for a property that is not known".to_owned()),
    };
    let index = channel.sampler.value();
    let Some(sampler) = animation.samplers.get(index) else {
        return Err(format!("with the sampler {index}, which does not exist"));
    };
    let between = match sampler.interpolation {
        Checked::Valid(Interpolation::Step) => Between::Step,
        Checked::Valid(Interpolation::Linear) => Between::Linear,
        Checked::Valid(Interpolation::CubicSpline) => Between::CubicSpline,
        Checked::Invalid => return Err("with an interpolation that is not known".to_owned()),
    };
    let read = || -> Result<_> {
        let times_s = numbers::<1>(document, sampler.input)?;
        let values = match property {
            Property::Translation | Property::Scale => numbers::<3>(document, sampler.output)?,
            Property::Rotation => numbers::<4>(document, sampler.output)?,
            Property::Weights => numbers::<1>(document, sampler.output)?,
        };
        Ok((times_s, values))
    };
    let (times_s, values) = read().map_err(|error| format!("that cannot be read ({error})"))?;
    let sampler = Sampler::new(times_s, values, width, between, property == Property::Rotation)?;
    Ok(Channel { node, property, sampler })
}

fn numbers<const N: usize>(document: &Document, accessor: Index<Accessor>) -> Result<Vec<f32>> {
    Ok(document.read_floats::<N>("animation", accessor)?.into_iter().flatten().collect())
}

fn skin(document: &Document, index: usize) -> Result<Skin> {
    let skin = &document.root.skins[index];
    let joints: Vec<usize> = skin.joints.iter().map(|joint| joint.value()).collect();
    if let Some(joint) = joints.iter().find(|joint| **joint >= document.root.nodes.len()) {
        return Err(document.error(format_args!("skin {index} has the joint {joint}, a node that does not exist")));
    }
    let what = format!("skin {index}");
    let inverse_bind = match skin.inverse_bind_matrices {
        None => vec![Mat4::IDENTITY; joints.len()],
        Some(accessor) => {
            let matrices = document.read_floats::<16>(&what, accessor)?;
            matrices.iter().map(Mat4::from_cols_array).collect()
        }
    };
    if inverse_bind.len() < joints.len() || !inverse_bind.iter().all(Mat4::is_finite) {
        let (have, need) = (inverse_bind.len(), joints.len());
        let reason = format!("{what} has {have} inverse bind matrices, and {need} joints need as many finite ones");
        return Err(document.error(reason));
    }
    Ok(Skin { joints, inverse_bind })
}
