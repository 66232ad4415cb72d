//! Meshes that move as a device poses them: what stays the same, and a pose for each moment. The shaders are
//! `motion/move_vertices` and `motion/move_triangles`; [`Body::pose`](super::Body) is their twin.

use std::collections::BTreeMap;

use glam::{Mat4, Vec3, Vec4};

use super::nodes::Posed;
use super::{Body, Motion};
use crate::scene::Scene;
use crate::shared::{
    BODY_HAS_TANGENTS, BODY_IS_FLAT, BODY_IS_TURNED, JointWeight, MorphOffset, MovingBody, POSE_MATRIX_WORDS,
    RestVertex,
};

/// What of the meshes that move is the same at all moments.
pub struct MovingMeshes {
    /// One per mesh.
    pub bodies: Vec<MovingBody>,
    /// Their vertices one after the other, and one more that says where the morph offsets end.
    pub vertices: Vec<RestVertex>,
    /// How much each vertex follows which joint, where there are skins.
    pub joints: Vec<JointWeight>,
    /// What morph targets add, by vertex and then by target.
    pub offsets: Vec<MorphOffset>,
    /// How poses of them are laid out.
    pub poses: PoseLayout,
}

/// Where parts of a pose begin, in words: whether each body is shown, the weights of its morph targets, matrices.
#[derive(Default)]
pub struct PoseLayout {
    /// By body.
    weights: Vec<usize>,
    /// By skin.
    joints: BTreeMap<usize, usize>,
    /// By body; that of the first joint where there is a skin.
    matrices: Vec<usize>,
    words: usize,
}

impl PoseLayout {
    fn new(bodies: &[&Body], motion: &Motion) -> Self {
        let mut layout = Self { words: bodies.len(), ..Self::default() };
        for body in bodies {
            layout.weights.push(layout.words);
            layout.words += body.targets.len();
        }
        for body in bodies {
            let known = body.skin.and_then(|skin| layout.joints.get(&skin).copied());
            layout.matrices.push(known.unwrap_or(layout.words));
            if known.is_none() {
                body.skin.map(|skin| layout.joints.insert(skin, layout.words));
                let matrices = body.skin.map_or(1, |skin| motion.skins[skin].joints.len());
                layout.words += matrices * POSE_MATRIX_WORDS as usize;
            }
        }
        layout
    }

    /// The pose at the moment that the scene, which is the one that they are of, is at.
    #[must_use]
    pub fn pose(&self, scene: &Scene) -> Vec<u32> {
        let motion = &scene.motion;
        let posed = motion.posed();
        let mut words = vec![0; self.words];
        for (index, body) in motion.moving_bodies().into_iter().enumerate() {
            words[index] = posed.visible[body.node].into();
            let weights = words[self.weights[index]..].iter_mut().take(body.targets.len());
            weights.zip(&posed.weights[body.node]).for_each(|(word, weight)| *word = weight.to_bits());
            if body.skin.is_none() {
                put_matrix(&mut words[self.matrices[index]..], &body.world(&posed));
            }
        }
        for (skin, first) in &self.joints {
            let matrices = motion.skins[*skin].matrices(&posed);
            let places = words[*first..].chunks_exact_mut(POSE_MATRIX_WORDS as usize);
            places.zip(&matrices).for_each(|(words, matrix)| put_matrix(words, matrix));
        }
        words
    }
}

/// A matrix without its last row.
fn put_matrix(words: &mut [u32], matrix: &Mat4) {
    let columns = [matrix.x_axis, matrix.y_axis, matrix.z_axis, matrix.w_axis].map(|axis| axis.truncate().to_array());
    words.iter_mut().zip(columns.as_flattened()).for_each(|(word, value)| *word = value.to_bits());
}

impl MovingMeshes {
    /// Of a scene whose animations have been chosen.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        let bodies = scene.motion.moving_bodies();
        let poses = PoseLayout::new(&bodies, &scene.motion);
        let (bodies_list, vertices) = (Vec::with_capacity(bodies.len()), Vec::new());
        let mut meshes = Self { bodies: bodies_list, vertices, joints: Vec::new(), offsets: Vec::new(), poses };
        bodies.iter().for_each(|body| meshes.add(body));
        let end = RestVertex { first_offset: meshes.offsets.len() as u32, ..bytemuck::Zeroable::zeroed() };
        meshes.vertices.push(end);
        meshes
    }

    /// Vertices that move.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.vertices.len() - 1
    }

    /// Words of a pose.
    #[must_use]
    pub fn pose_words(&self) -> usize {
        self.poses.words
    }

    fn add(&mut self, body: &Body) {
        let (index, first_rest) = (self.bodies.len(), self.vertices.len() as u32);
        let joints_per_vertex = body.joints_per_vertex();
        let flag = |is: bool, flag: u32| if is { flag } else { 0 };
        self.bodies.push(MovingBody {
            first_vertex: body.first_vertex as u32,
            first_rest,
            first_matrix: self.poses.matrices[index] as u32,
            first_weight: self.poses.weights[index] as u32,
            joints_per_vertex: joints_per_vertex as u32,
            flags: flag(body.turned, BODY_IS_TURNED)
                | flag(!body.tangents.is_empty(), BODY_HAS_TANGENTS)
                | flag(body.normals.is_none(), BODY_IS_FLAT),
            padding: [0; 2],
        });
        for (of_mesh, corners) in body.corners() {
            let first_offset = self.offsets.len() as u32;
            self.offsets.extend(body.offsets(of_mesh));
            let first_joint = self.joints.len() as u32;
            let joints = &body.influences[of_mesh * joints_per_vertex..][..joints_per_vertex];
            self.joints.extend(joints.iter().map(|i| JointWeight { joint: i.joint, weight: i.weight }));
            self.vertices.push(RestVertex {
                position: body.positions[of_mesh].to_array(),
                body: index as u32,
                normal: body.normals.as_ref().map_or(Vec3::ZERO, |normals| normals[of_mesh]).to_array(),
                first_offset,
                tangent: body.tangents.get(of_mesh).copied().unwrap_or(Vec4::ZERO).to_array(),
                corners: corners.map(|corner| first_rest + corner),
                first_joint,
            });
        }
    }
}

impl Motion {
    /// Where the nodes are at the moment that the scene is at.
    pub(super) fn posed(&self) -> Posed {
        self.posed_s.map_or_else(|| self.rest(), |time_s| self.hierarchy.pose(self.playing_clips(), time_s))
    }
}

impl Body {
    fn joints_per_vertex(&self) -> usize {
        if self.skin.is_some() { self.influences.len() / self.positions.len().max(1) } else { 0 }
    }

    /// For each of its vertices in the scene the vertex of the mesh, and the first triangle at it by its vertices in the scene.
    fn corners(&self) -> Vec<(usize, [u32; 3])> {
        if self.normals.is_none() {
            let corners = self.triangles.as_flattened().iter().zip(0..);
            return corners.map(|(of_mesh, at)| (*of_mesh as usize, [0, 1, 2].map(|k| at - at % 3 + k))).collect();
        }
        let alone = |vertex: usize| (vertex, [vertex as u32; 3]);
        let mut corners: Vec<_> = (0..self.positions.len()).map(alone).collect();
        for triangle in self.triangles.iter().rev() {
            triangle.iter().for_each(|vertex| corners[*vertex as usize].1 = *triangle);
        }
        corners
    }

    /// What its morph targets add to a vertex of the mesh.
    fn offsets(&self, vertex: usize) -> impl Iterator<Item = MorphOffset> {
        let of = move |list: &[Vec3]| list.get(vertex).copied().unwrap_or(Vec3::ZERO);
        let offsets = self.targets.iter().map(move |t| [&t.positions, &t.normals, &t.tangents].map(|list| of(list)));
        let used = offsets.zip(0..).filter(|(offsets, _)| *offsets != [Vec3::ZERO; 3]);
        used.map(|([position, normal, tangent], target)| MorphOffset {
            position: position.to_array(),
            target,
            normal: normal.to_array(),
            padding: 0,
            tangent: tangent.to_array(),
            padding_1: 0,
        })
    }
}
