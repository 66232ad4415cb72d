//! The hierarchy of nodes, and where its nodes stand at a moment.

use glam::{Mat4, Quat, Vec3};

use super::clip::{Clip, Property, Target};

/// A node as the file has it.
#[derive(Clone, Debug)]
pub(in crate::scene) struct Node {
    /// Its parent, which comes before it in [`Hierarchy::order`].
    pub parent: Option<usize>,
    /// Its own transform when nothing moves it.
    pub rest: Mat4,
    /// The same in parts, which animations change.
    pub parts: Parts,
    /// Weights of its mesh's morph targets.
    pub weights: Vec<f32>,
    /// Whether it is there when nothing shows or hides it.
    pub is_visible: bool,
}

/// A transform in parts.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) struct Parts {
    /// Where it is.
    pub translation: Vec3,
    /// How it is turned, of length 1.
    pub rotation: Quat,
    /// How it is stretched.
    pub scale: Vec3,
}

impl Parts {
    fn matrix(&self) -> Mat4 {
        Mat4::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
    }
}

/// All nodes of a file.
#[derive(Clone, Debug, Default)]
pub(in crate::scene) struct Hierarchy {
    /// By their indices in the file.
    pub nodes: Vec<Node>,
    /// Parents first.
    pub order: Vec<usize>,
}

/// Where the nodes are at a moment, by their indices in the file.
#[derive(Clone, Debug)]
pub(in crate::scene) struct Posed {
    /// From node to world space.
    pub worlds: Vec<Mat4>,
    /// Weights of morph targets.
    pub weights: Vec<Vec<f32>>,
    /// Whether they and all above them are visible.
    pub visible: Vec<bool>,
}

impl Hierarchy {
    /// The nodes of parents, transforms and weights; of nodes in a circle none is in the order.
    pub fn new(nodes: Vec<Node>) -> Self {
        let mut children = vec![Vec::new(); nodes.len()];
        let mut stack = Vec::new();
        for (index, node) in nodes.iter().enumerate().rev() {
            match node.parent {
                Some(parent) => children[parent].push(index),
                None => stack.push(index),
            }
        }
        let mut order = Vec::with_capacity(nodes.len());
        while let Some(index) = stack.pop() {
            order.push(index);
            stack.append(&mut children[index]);
        }
        Self { nodes, order }
    }

    /// The nodes while clips play: of several that move the same, the last counts.
    pub fn pose<'a>(&self, clips: impl Iterator<Item = &'a Clip>, time_s: f64) -> Posed {
        let mut parts: Vec<Option<Parts>> = vec![None; self.nodes.len()];
        let mut weights: Vec<Vec<f32>> = self.nodes.iter().map(|node| node.weights.clone()).collect();
        let mut visible: Vec<bool> = self.nodes.iter().map(|node| node.is_visible).collect();
        for clip in clips {
            let time_s = clip.local_time_s(time_s);
            for channel in &clip.channels {
                let Target::Node { node, property } = channel.target else { continue };
                let value = channel.sampler.at(time_s);
                match property {
                    Property::Weights => weights[node] = value,
                    Property::Visibility => visible[node] = value[0] >= 0.5,
                    Property::Translation | Property::Rotation | Property::Scale => {
                        let own = parts[node].get_or_insert(self.nodes[node].parts);
                        match property {
                            Property::Translation => own.translation = Vec3::from_slice(&value),
                            Property::Rotation => own.rotation = Quat::from_slice(&value),
                            _ => own.scale = Vec3::from_slice(&value),
                        }
                    }
                }
            }
        }
        let mut worlds = vec![Mat4::IDENTITY; self.nodes.len()];
        for index in &self.order {
            let node = &self.nodes[*index];
            let local = parts[*index].as_ref().map_or(node.rest, Parts::matrix);
            // The product with the identity is left out nowhere, so that what rests stands where it is read to be.
            let parent = node.parent.map_or(Mat4::IDENTITY, |parent| worlds[parent]);
            let world = parent * local;
            // Keys may stretch it beyond all numbers.
            worlds[*index] = if world.is_finite() { world } else { parent };
            visible[*index] &= node.parent.is_none_or(|parent| visible[parent]);
        }
        Posed { worlds, weights, visible }
    }

    /// Nodes that these move, with all below them.
    pub fn with_descendants(&self, moved: impl Iterator<Item = usize>) -> Vec<bool> {
        let mut moves = vec![false; self.nodes.len()];
        moved.for_each(|node| moves[node] = true);
        for index in &self.order {
            moves[*index] |= self.nodes[*index].parent.is_some_and(|parent| moves[parent]);
        }
        moves
    }
}
