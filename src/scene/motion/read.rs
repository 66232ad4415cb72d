//! Reads what moves from a glTF: nodes, animations, skins.

use std::collections::BTreeMap;

use ::gltf::json::accessor::Accessor;
use ::gltf::json::animation::{Animation, Channel as JsonChannel, Interpolation, Property as JsonProperty};
use ::gltf::json::validation::Checked;
use ::gltf::json::{Index, scene};
use glam::{Mat4, Quat, Vec3};

use super::body::Skin;
use super::clip::{Channel, Clip, LightProperty, Property, Target};
use super::nodes::{Hierarchy, Node, Parts};
use super::sampler::{Between, Sampler};
use super::{Carried, Motion};
use crate::Result;
use crate::scene::gltf_buffers::Document;
use crate::scene::gltf_instancing::is_visible;
use crate::scene::gltf_lenient::NO_INDEX;
use crate::scene::gltf_lights::{self, LightParts};
use crate::scene::gltf_nodes::{Found, Source, local_transform, roots};
use crate::scene::gltf_pointers;

impl Motion {
    /// What of the file moves, without its meshes. Animations that cannot be played are noted.
    pub(in crate::scene) fn read(document: &Document, found: &Found) -> Result<Self> {
        let hierarchy = hierarchy(document)?;
        let animations = document.root.animations.iter().enumerate();
        let clips = animations.map(|(index, animation)| clip(document, &hierarchy, index, animation)).collect();
        let skins = (0..document.root.skins.len()).map(|index| skin(document, index)).collect::<Result<_>>()?;
        let (cameras, camera_sources) = (&found.cameras, &found.camera_sources);
        let (cameras, lights) = (carried(cameras, camera_sources), carried(&found.lights, &found.light_sources));
        let lamps = gltf_lights::lights(document).iter().map(LightParts::of).collect();
        Ok(Self { hierarchy, clips, skins, cameras, lights, lamps, ..Self::default() })
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
    let read = |(index, (node, parent)): (usize, (&scene::Node, Option<usize>))| {
        let rest = local_transform(node).unwrap_or(Mat4::IDENTITY);
        let is_visible = is_visible(document, index, node);
        Ok(Node { parent, rest, parts: parts(node, &rest), weights: weights(node), is_visible })
    };
    Ok(Hierarchy::new(nodes.iter().zip(parents).enumerate().map(read).collect::<Result<_>>()?))
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
    for (number, channel) in animation.channels.iter().enumerate() {
        let pointer = document.pointers.get(index, number);
        if let Some(pointer) = pointer.filter(|pointer| gltf_pointers::target(pointer).is_none()) {
            let kind = gltf_pointers::kind(pointer);
            document.ignore(if kind.is_empty() {
                "channels without a target".into()
            } else {
                format!("the animation of {kind}")
            });
            continue;
        }
        match read_channel(document, hierarchy, animation, (channel, pointer)) {
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
    (channel, pointer): (&JsonChannel, Option<&str>),
) -> std::result::Result<Channel, String> {
    let target = match pointer.and_then(gltf_pointers::target) {
        Some(target) => target,
        None => target_of(channel)?,
    };
    let width = width(document, hierarchy, target)?;
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
    let is_weights = matches!(target, Target::Node { property: Property::Weights, .. });
    // Weights are a list of scalars however many there are.
    let kind = if is_weights { 1 } else { width };
    let is_rotation = matches!(target, Target::Node { property: Property::Rotation, .. });
    let read = || -> Result<_> {
        let times_s = numbers::<1>(document, sampler.input)?;
        let values = match kind {
            3 => numbers::<3>(document, sampler.output)?,
            4 => numbers::<4>(document, sampler.output)?,
            _ => numbers::<1>(document, sampler.output)?,
        };
        Ok((times_s, values))
    };
    let (times_s, values) = read().map_err(|error| format!("that cannot be read ({error})"))?;
    let sampler = Sampler::new(times_s, values, width, between, is_rotation)?;
    Ok(Channel { target, sampler })
}

/// What a channel of a node changes.
fn target_of(channel: &JsonChannel) -> std::result::Result<Target, String> {
    let property = match channel.target.path {
        Checked::Valid(JsonProperty::Translation) => Property::Translation,
        Checked::Valid(JsonProperty::Rotation) => Property::Rotation,
        Checked::Valid(JsonProperty::Scale) => Property::Scale,
        Checked::Valid(JsonProperty::MorphTargetWeights) => Property::Weights,
        Checked::Invalid => return Err("for a property that is not known".to_owned()),
    };
    Ok(Target::Node { node: channel.target.node.value(), property })
}

/// Numbers of one value of a target, which must exist.
fn width(document: &Document, hierarchy: &Hierarchy, target: Target) -> std::result::Result<usize, String> {
    let root = &document.root;
    let exists = |what: &str, index: usize, count: usize| match index < count {
        true => Ok(()),
        false if index == NO_INDEX as usize => Err("without a node".to_owned()),
        false => Err(format!("for the {what} {index}, which does not exist")),
    };
    match target {
        Target::Node { node, property } => {
            exists("node", node, root.nodes.len())?;
            Ok(match property {
                Property::Translation | Property::Scale => 3,
                Property::Rotation => 4,
                Property::Visibility => 1,
                Property::Weights => {
                    let mesh = root.nodes[node].mesh.and_then(|mesh| root.meshes.get(mesh.value()));
                    let targets = mesh.and_then(|mesh| mesh.primitives.first()?.targets.as_ref()).map_or(0, Vec::len);
                    targets.max(hierarchy.nodes[node].weights.len())
                }
            })
        }
        Target::Light { light, property } => {
            exists("light", light, gltf_lights::lights(document).len())?;
            Ok(if property == LightProperty::Color { 3 } else { 1 })
        }
        Target::FieldOfView { camera } => exists("camera", camera, root.cameras.len()).map(|()| 1),
    }
}

/// What nodes carry.
fn carried<T: Clone>(things: &[T], sources: &[Source]) -> Vec<Carried<T>> {
    let things = things.iter().zip(sources);
    things
        .map(|(thing, Source { node, index })| Carried { node: *node, index: *index, at_rest: thing.clone() })
        .collect()
}

fn numbers<const N: usize>(document: &Document, accessor: Index<Accessor>) -> Result<Vec<f32>> {
    Ok(document.read_moving::<N>("animation", accessor)?.into_iter().flatten().collect())
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
            let matrices = document.read_moving::<16>(&what, accessor)?;
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
