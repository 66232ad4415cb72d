//! Reads the triangles that move.

use ::gltf::json::mesh::{MorphTarget, Primitive, Semantic};
use ::gltf::json::validation::Checked;
use glam::{Mat3, Vec3};

use super::Motion;
use super::body::{Body, Influence, Target};
use crate::Result;
use crate::scene::Vertex;
use crate::scene::gltf_buffers::Document;
use crate::scene::gltf_mesh::{Geometry, Shape, vectors};
use crate::scene::gltf_nodes::Instance;

/// Joints that a vertex of a file may follow: two sets of four.
const SETS: u32 = 2;
/// Most numbers that morph targets of one primitive may have.
const MOST_OFFSETS: usize = 1 << 26;

impl Motion {
    /// Whether the mesh of this instance is one of the moving.
    pub(in crate::scene) fn carries(&self, document: &Document, instance: &Instance, moved: &[bool]) -> bool {
        let mesh = document.root.meshes.get(instance.mesh);
        let morphs = mesh.is_some_and(|mesh| mesh.primitives.iter().any(|primitive| primitive.targets.is_some()));
        moved[instance.node] || morphs || document.root.nodes[instance.node].skin.is_some()
    }

    /// Adds one primitive of a moving mesh: its triangles to the geometry, where they have no place yet, and itself.
    pub(in crate::scene) fn add(
        &mut self,
        document: &Document,
        geometry: &mut Geometry,
        primitive: &Primitive,
        (instance, what, material): (&Instance, &str, usize),
        mut shape: Shape,
    ) -> Result<()> {
        let skin = document.root.nodes[instance.node].skin.map(|skin| skin.value());
        let mut influences = match skin {
            None => Vec::new(),
            Some(skin) => self.influences(document, what, primitive, (skin, shape.positions.len()))?,
        };
        let mut targets = targets(document, what, primitive, &shape)?;
        let vertices_before = shape.positions.len();
        let copies = geometry.compute_tangents(document, &mut shape, &mut targets);
        let per_vertex = influences.len() / vertices_before.max(1);
        copies.iter().map(|vertex| *vertex as usize * per_vertex).for_each(|first| {
            influences.extend_from_within(first..first + per_vertex);
        });
        let (skin, influences) = if influences.is_empty() { (None, influences) } else { (skin, influences) };
        let turned = skin.is_none() && Mat3::from_mat4(instance.world).determinant() < 0.0;
        let Shape { positions, normals, tangents, paint, mut triangles, .. } = shape;
        if turned {
            triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        let body = Body {
            what: what.to_owned(),
            node: instance.node,
            place: instance.place,
            skin,
            first_vertex: geometry.vertices.len(),
            targets,
            positions,
            normals,
            tangents,
            triangles,
            turned,
            influences,
        };
        geometry.add_unplaced(material, &body, &paint);
        self.bodies.push(body);
        Ok(())
    }

    /// Which joints every vertex follows, in equal numbers; none where the primitive says nothing of joints.
    fn influences(
        &self,
        document: &Document,
        what: &str,
        primitive: &Primitive,
        (skin, vertices): (usize, usize),
    ) -> Result<Vec<Influence>> {
        let Some(joint_count) = self.skins.get(skin).map(|skin| skin.joints.len()) else {
            return Err(document.error(format_args!("{what} has the skin {skin}, which does not exist")));
        };
        let mut sets = Vec::new();
        for set in 0..SETS {
            let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
            let (joints, weights) = (attribute(Semantic::Joints(set)), attribute(Semantic::Weights(set)));
            let (Some(joints), Some(weights)) = (joints, weights) else { break };
            let (joints, weights) = (document.read_joints(what, joints)?, document.read_floats::<4>(what, weights)?);
            if joints.len() != vertices || weights.len() != vertices {
                let (joints, weights) = (joints.len(), weights.len());
                let reason = format!("{what} has {joints} joints and {weights} weights for {vertices} positions");
                return Err(document.error(reason));
            }
            sets.push((joints, weights));
        }
        let mut influences = Vec::with_capacity(4 * sets.len() * vertices);
        for vertex in 0..vertices {
            let first = influences.len();
            for (joints, weights) in &sets {
                for (joint, weight) in joints[vertex].into_iter().zip(weights[vertex]) {
                    // A joint that nothing follows may have any number.
                    let weight = if weight.is_finite() { weight.max(0.0) } else { 0.0 };
                    if weight > 0.0 && joint as usize >= joint_count {
                        let reason =
                            format!("{what} has the joint {joint}, and its skin {skin} has only {joint_count} joints");
                        return Err(document.error(reason));
                    }
                    let joint = if weight > 0.0 { joint } else { 0 };
                    influences.push(Influence { joint, weight });
                }
            }
            share_out(&mut influences[first..]);
        }
        Ok(if joint_count == 0 { Vec::new() } else { influences })
    }

    /// Looks for a vertex that is nowhere; its body's name.
    pub(in crate::scene) fn find_lost(&self, is_lost: impl Fn(&Vertex) -> bool, vertices: &[Vertex]) -> Option<&str> {
        let lost =
            |body: &&Body| vertices[body.first_vertex..body.first_vertex + body.vertex_count()].iter().any(&is_lost);
        self.bodies.iter().find(lost).map(|body| body.what.as_str())
    }
}

/// Weights that add up to 1; a vertex that follows nothing follows the first joint.
fn share_out(influences: &mut [Influence]) {
    let sum: f32 = influences.iter().map(|influence| influence.weight).sum();
    if sum > 0.0 && sum.is_finite() {
        influences.iter_mut().for_each(|influence| influence.weight /= sum);
    } else if let Some(first) = influences.first_mut() {
        *first = Influence { joint: 0, weight: 1.0 };
    }
}

fn targets(document: &Document, what: &str, primitive: &Primitive, shape: &Shape) -> Result<Vec<Target>> {
    let vertices = shape.positions.len();
    let targets = primitive.targets.as_deref().unwrap_or_default();
    if targets.len().saturating_mul(vertices) > MOST_OFFSETS {
        let count = targets.len();
        return Err(document.error(format_args!("{what} has {count} morph targets of {vertices} vertices, too many")));
    }
    let read = |accessor| -> Result<Vec<Vec3>> {
        let Some(accessor) = accessor else { return Ok(Vec::new()) };
        let mut offsets = vectors(document.read_moving::<3>(what, accessor)?);
        if offsets.len() != vertices {
            let count = offsets.len();
            let reason = format!("{what} has a morph target of {count} offsets for {vertices} positions");
            return Err(document.error(reason));
        }
        offsets.iter_mut().filter(|offset| !offset.is_finite()).for_each(|offset| *offset = Vec3::ZERO);
        Ok(offsets)
    };
    // Without normals every triangle has its own, and offsets of tangents mean those of the file.
    let (has_normals, has_tangents) = (shape.normals.is_some(), !shape.tangents.is_empty());
    let target = |target: &MorphTarget| {
        let (positions, normals) = (read(target.positions)?, read(target.normals.filter(|_| has_normals))?);
        Ok(Target { positions, normals, tangents: read(target.tangents.filter(|_| has_tangents))? })
    };
    targets.iter().map(target).collect()
}
