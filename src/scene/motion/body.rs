//! Triangles that move: a primitive of a mesh that is carried by a node, bent by a skin or morphed.

use glam::{Mat3, Mat4, Vec3, Vec4};

use super::nodes::Posed;
use crate::scene::gltf_mesh::{TangentTransform, face_normal, fill_normals, normal_matrix, within_reach};
use crate::scene::octahedral::{pack_octahedral, pack_tangent};
use crate::scene::{Aabb, Vertex};

/// Joints that carry skinned meshes.
#[derive(Clone, Debug)]
pub(in crate::scene) struct Skin {
    /// Their nodes.
    pub joints: Vec<usize>,
    /// From mesh space to that of each joint.
    pub inverse_bind: Vec<Mat4>,
}

impl Skin {
    /// From mesh to world space by each joint alone.
    pub fn matrices(&self, posed: &Posed) -> Vec<Mat4> {
        self.joints.iter().zip(&self.inverse_bind).map(|(node, bind)| posed.worlds[*node] * *bind).collect()
    }
}

/// A shape that a mesh can be morphed towards.
#[derive(Clone, Debug)]
pub(in crate::scene) struct Target {
    /// Added to positions; empty where they stay.
    pub positions: Vec<Vec3>,
    /// Added to normals; empty where they stay.
    pub normals: Vec<Vec3>,
    /// Added to tangents; empty where they stay.
    pub tangents: Vec<Vec3>,
}

/// How much of a vertex follows a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::scene) struct Influence {
    /// Index into [`Skin::joints`].
    pub joint: u32,
    /// Of a vertex they add up to 1.
    pub weight: f32,
}

/// Triangles of one primitive that move together, in mesh space.
#[derive(Clone, Debug)]
pub(in crate::scene) struct Body {
    /// What the primitive is called in errors.
    pub what: String,
    /// The node that carries it.
    pub node: usize,
    /// From the mesh to the node's space.
    pub place: Mat4,
    /// The skin that bends it, by its index in the file.
    pub skin: Option<usize>,
    /// First of its vertices in the scene.
    pub first_vertex: usize,
    /// Corners of the mesh at rest.
    pub positions: Vec<Vec3>,
    /// Their normals; without them every triangle has vertices of its own, with the triangle's normal.
    pub normals: Option<Vec<Vec3>>,
    /// Their tangents, with the side of the bitangent in w; empty without a normal map.
    pub tangents: Vec<Vec4>,
    /// Corners of each triangle, counter-clockwise in front.
    pub triangles: Vec<[u32; 3]>,
    /// Whether the order of corners was turned because the node mirrors.
    pub turned: bool,
    /// Shapes that it can be morphed towards.
    pub targets: Vec<Target>,
    /// As many per vertex, where there is a skin.
    pub influences: Vec<Influence>,
}

/// A shape in world space.
struct Placed {
    positions: Vec<Vec3>,
    normals: Option<Vec<Vec3>>,
    tangents: Vec<Vec4>,
    /// Whether front faces are behind.
    mirrored: bool,
}

impl Body {
    /// Number of its vertices in the scene.
    pub fn vertex_count(&self) -> usize {
        if self.normals.is_some() { self.positions.len() } else { 3 * self.triangles.len() }
    }

    /// Puts its vertices where they are at a moment.
    pub fn pose(&self, posed: &Posed, skins: &[Skin], vertices: &mut [Vertex], tangents: &mut [u32]) {
        let mut placed = self.placed(posed, skins);
        if !posed.visible[self.node] {
            // Triangles without area are in no picture, and no ray hits them.
            let place = placed.positions.first().copied().unwrap_or_default();
            placed.positions.fill(place);
        }
        self.put_tangents(&placed.tangents, tangents);
        let vertices = &mut vertices[self.first_vertex..self.first_vertex + self.vertex_count()];
        let mut put = |index: usize, position: Vec3, normal: Vec3| {
            let vertex = &mut vertices[index];
            (vertex.position_ws, vertex.normal_oct) = (within_reach(position).to_array(), pack_octahedral(normal));
        };
        let Some(mut normals) = placed.normals else {
            for (index, triangle) in self.triangles.iter().enumerate() {
                let normal = face_normal(&placed.positions, *triangle);
                let normal = if placed.mirrored == self.turned { normal } else { -normal };
                for (corner, vertex) in triangle.iter().enumerate() {
                    put(3 * index + corner, placed.positions[*vertex as usize], normal);
                }
            }
            return;
        };
        fill_normals(&mut normals, &placed.positions, &self.triangles);
        for (index, (position, normal)) in placed.positions.iter().zip(normals).enumerate() {
            put(index, *position, normal);
        }
    }

    /// Puts tangents of the corners, if there are any, among those of all vertices.
    fn put_tangents(&self, placed: &[Vec4], tangents: &mut [u32]) {
        if placed.is_empty() {
            return;
        }
        let tangents = &mut tangents[self.first_vertex..self.first_vertex + self.vertex_count()];
        if self.normals.is_some() {
            tangents.iter_mut().zip(placed).for_each(|(packed, tangent)| *packed = pack_tangent(*tangent));
        } else {
            let corners = self.triangles.as_flattened();
            tangents.iter_mut().zip(corners).for_each(|(packed, i)| *packed = pack_tangent(placed[*i as usize]));
        }
    }

    /// From mesh to world space, where a node carries it.
    pub fn world(&self, posed: &Posed) -> Mat4 {
        posed.worlds[self.node] * self.place
    }

    /// Morphed, then bent or carried.
    fn placed(&self, posed: &Posed, skins: &[Skin]) -> Placed {
        let (mut positions, mut normals) = (self.positions.clone(), self.normals.clone());
        let mut tangents = self.tangents.clone();
        for (target, weight) in self.targets.iter().zip(&posed.weights[self.node]).filter(|(_, w)| **w != 0.0) {
            positions.iter_mut().zip(&target.positions).for_each(|(position, offset)| *position += *offset * *weight);
            let normals = normals.iter_mut().flatten();
            normals.zip(&target.normals).for_each(|(normal, offset)| *normal += *offset * *weight);
            let tangents = tangents.iter_mut();
            tangents.zip(&target.tangents).for_each(|(tangent, offset)| *tangent += (*offset * *weight).extend(0.0));
        }
        let Some(skin) = self.skin.map(|skin| &skins[skin]) else {
            let world = self.world(posed);
            let linear = Mat3::from_mat4(world);
            let mirrored = linear.determinant() < 0.0;
            let to_world = normal_matrix(&linear, mirrored);
            positions.iter_mut().for_each(|position| *position = world.transform_point3(*position));
            normals.iter_mut().flatten().for_each(|normal| *normal = turned(&to_world, *normal));
            let to_world = TangentTransform::new(&linear, mirrored);
            tangents.iter_mut().for_each(|tangent| *tangent = to_world.apply(*tangent));
            return Placed { positions, normals, tangents, mirrored };
        };
        let matrices = skin.matrices(posed);
        let per_vertex = self.influences.len() / positions.len().max(1);
        for (vertex, influences) in self.influences.chunks_exact(per_vertex.max(1)).enumerate() {
            let world = influences.iter().fold(Mat4::ZERO, |sum, i| sum + matrices[i.joint as usize] * i.weight);
            positions[vertex] = world.transform_point3(positions[vertex]);
            let linear = Mat3::from_mat4(world);
            let mirrored = linear.determinant() < 0.0;
            if let Some(normals) = &mut normals {
                normals[vertex] = turned(&normal_matrix(&linear, mirrored), normals[vertex]);
            }
            if let Some(tangent) = tangents.get_mut(vertex) {
                *tangent = TangentTransform::new(&linear, mirrored).apply(*tangent);
            }
        }
        Placed { positions, normals, tangents, mirrored: false }
    }

    /// A box that it stays in at a moment: what each joint alone would make of the vertices that follow it.
    pub fn bounds(&self, posed: &Posed, skins: &[Skin]) -> Aabb {
        let (mut least, mut most) = (Vec3::ZERO, Vec3::ZERO);
        for (target, weight) in self.targets.iter().zip(&posed.weights[self.node]) {
            let offsets = || target.positions.iter().map(|offset| *offset * *weight);
            least += offsets().fold(Vec3::ZERO, Vec3::min);
            most += offsets().fold(Vec3::ZERO, Vec3::max);
        }
        let around = |vertices: &mut dyn Iterator<Item = usize>, world: &Mat4| {
            let inside = vertices.fold(Aabb::EMPTY, |bounds, vertex| bounds.with(self.positions[vertex]));
            Aabb { min: inside.min + least, max: inside.max + most }.transformed(world)
        };
        let Some(skin) = self.skin.map(|skin| &skins[skin]) else {
            return around(&mut (0..self.positions.len()), &posed.worlds[self.node]);
        };
        let per_vertex = (self.influences.len() / self.positions.len().max(1)).max(1);
        let mut boxes = vec![Aabb::EMPTY; skin.joints.len()];
        for (index, influence) in self.influences.iter().enumerate().filter(|(_, i)| i.weight > 0.0) {
            let bounds = &mut boxes[influence.joint as usize];
            *bounds = bounds.with(self.positions[index / per_vertex]);
        }
        let used = boxes.iter().zip(skin.matrices(posed)).filter(|(bounds, _)| bounds.min.x <= bounds.max.x);
        used.fold(Aabb::EMPTY, |all, (bounds, world)| {
            let morphed = Aabb { min: bounds.min + least, max: bounds.max + most };
            all.union(&morphed.transformed(&world))
        })
    }
}

/// A unit normal in world space; zero marks one that cannot be used.
fn turned(to_world: &Mat3, normal: Vec3) -> Vec3 {
    (*to_world * normal.normalize_or_zero()).normalize_or_zero()
}
