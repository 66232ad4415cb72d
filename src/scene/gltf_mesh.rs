//! Triangles of glTF meshes, transformed to world space and gathered by material.

use std::collections::HashMap;
use std::sync::Arc;

use ::gltf::json::Index;
use ::gltf::json::accessor::Accessor;
use ::gltf::json::mesh::{Mode, Primitive, Semantic};
use ::gltf::json::validation::Checked;
use glam::{Mat3, Mat4, Vec3, Vec4};

use super::gltf_buffers::Document;
use super::gltf_mapping::Mapping;
use super::gltf_nodes::Instance;
use super::gltf_notes::Thing;
use super::gltf_tangents::{CornerTangents, usable};
use super::motion::{Body, Motion};
use super::octahedral::{NO_TANGENT, pack_octahedral, pack_tangent};
use super::{Material, Vertex};
use crate::Result;
use crate::shared::MOST_METRES;

/// The most vertices, and the most triangles, a scene may have.
const MAX_COUNT: u64 = 1 << 26;
/// What a primitive counts at least: reading very many without any vertex takes time too.
const LEAST_VERTICES: u64 = 8;
/// The farthest a vertex may be from the origin: beyond it, areas overflow in single precision.
const MAX_COORDINATE: f32 = MOST_METRES as f32;

/// Geometry gathered so far.
#[derive(Default)]
pub(super) struct Geometry {
    /// All vertices.
    pub vertices: Vec<Vertex>,
    /// Packed tangents of the vertices up to the last that has one.
    pub tangents: Vec<u32>,
    /// Triangle corners for each material of the glTF, and last for primitives without one.
    pub corners: Vec<Vec<u32>>,
    /// Triangles without an area, left out.
    pub degenerate: u64,
    /// Primitives of points or lines, left out.
    pub not_triangles: u64,
    /// Primitives whose last corners make no whole triangle.
    pub incomplete: u64,
    /// Whether a primitive of the material has colours, in the order of `corners`.
    pub has_colors: Vec<bool>,
    /// For each material of the glTF, and last for primitives without one.
    pub looks: Vec<Look>,
    /// Computed tangents of primitives, by mesh and primitive: a mesh may be placed very often. `None` where there are too many.
    pub computed: HashMap<(usize, usize), Option<Arc<CornerTangents>>>,
    announced_vertices: u64,
    announced_triangles: u64,
}

/// What of a material decides which attributes are read.
#[derive(Clone, Copy, Default)]
pub(super) struct Look {
    /// How its textures lie.
    pub mapping: Mapping,
    /// Whether one of them is a normal map.
    pub has_normal_map: bool,
}

/// A primitive, in mesh space until it is placed.
pub(super) struct Shape {
    /// Which it is: its mesh, and its index there.
    pub of: (usize, usize),
    /// Corners.
    pub positions: Vec<Vec3>,
    /// Their normals; without them every triangle is flat.
    pub normals: Option<Vec<Vec3>>,
    /// Their tangents, with the side of the bitangent in w, 1 or -1, or all 0; empty without a normal map.
    pub tangents: Vec<Vec4>,
    /// Whether there is a normal map, and its tangents have to be computed.
    pub lacks_tangents: bool,
    /// What their surface looks like.
    pub paint: Paint,
    /// Indices of corners.
    pub triangles: Vec<[u32; 3]>,
}

/// What vertices have besides their place.
pub(super) struct Paint {
    /// Texture coordinates.
    pub uvs: Vec<[f32; 2]>,
    /// Factors of the base colour, if there are any.
    pub colors: Option<Vec<[u16; 4]>>,
}

impl Geometry {
    /// Room for triangles of the glTF's materials, whose textures lie like this.
    pub fn new(materials: &[Material], mappings: &[Mapping]) -> Self {
        let look = |(material, mapping): (&Material, &Mapping)| Look {
            mapping: *mapping,
            has_normal_map: material.normal_texture.is_some(),
        };
        let looks: Vec<Look> = materials.iter().zip(mappings).map(look).chain([Look::default()]).collect();
        let has_colors = vec![false; looks.len()];
        Self { corners: vec![Vec::new(); looks.len()], has_colors, looks, ..Self::default() }
    }

    /// One that reads the same apart: what it counts says nothing of this one.
    pub fn to_read_ahead(&self) -> Self {
        Self { looks: self.looks.clone(), ..Self::default() }
    }

    /// Adds all triangles of one placed mesh; those that move go to `motion` as well, which will place them.
    pub fn add(&mut self, document: &Document, instance: &Instance, motion: &mut Motion, moves: bool) -> Result<()> {
        let m = instance.mesh;
        let Some(mesh) = document.root.meshes.get(m) else {
            return Err(document.error(format_args!("mesh {m} does not exist")));
        };
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let what = format!("mesh {m}, primitive {p}");
            let material = self.material_of(document, m, primitive);
            let Checked::Valid(mode) = primitive.mode else {
                return Err(document.error(format_args!("{what} has an unknown mode")));
            };
            if !has_triangles(mode) {
                self.not_triangles += 1;
                continue;
            }
            let mut shape = self.read(document, ((m, p), &what), primitive, mode, self.looks[material])?;
            self.has_colors[material] |= shape.paint.colors.is_some();
            if moves {
                motion.add(document, self, primitive, (instance, &what, material), shape)?;
                continue;
            }
            self.compute_tangents(document, &mut shape, &mut []);
            self.degenerate += shape.place(&instance.world);
            if shape.positions.iter().any(|p| is_lost(*p)) {
                return Err(document.error(format_args!("{what} has a vertex position that is not finite or too far")));
            }
            match shape.normals.take() {
                Some(normals) => self.push_shared(material, &shape, &normals),
                None => self.push_flat(material, &shape),
            }
        }
        Ok(())
    }

    /// The material of a primitive of this mesh; the last of all where it names none that there is.
    pub fn material_of(&self, document: &Document, mesh: usize, primitive: &Primitive) -> usize {
        let no_material = self.corners.len() - 1;
        let Some(material) = primitive.material.map(|material| material.value()) else { return no_material };
        if material >= no_material {
            let thing = Thing::new("mesh", mesh, document.root.meshes[mesh].name.as_ref());
            document.fault(thing, format!("has the default material, as material {material} does not exist"));
        }
        material.min(no_material)
    }

    /// Reads a primitive of triangles with a material that looks like this.
    pub fn read(
        &mut self,
        document: &Document,
        (of, what): ((usize, usize), &str),
        primitive: &Primitive,
        mode: Mode,
        Look { mapping, has_normal_map }: Look,
    ) -> Result<Shape> {
        let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
        let Some(position) = attribute(Semantic::Positions) else {
            return Err(document.error(format_args!("{what} has no positions")));
        };
        self.announce(document, position, primitive.indices, mode)?;
        let positions = vectors(document.read_floats::<3>(what, position)?);
        let count = positions.len();
        let same = |name: &str, len: usize| {
            let differ = format_args!("{what} has {len} {name} for {count} positions");
            if len == count { Ok(()) } else { Err(document.error(differ)) }
        };
        let normals = attribute(Semantic::Normals).map(|a| document.read_floats::<3>(what, a)).transpose()?;
        let normals = normals.map(vectors);
        same("normals", normals.as_ref().map_or(count, Vec::len))?;
        let uvs =
            attribute(Semantic::TexCoords(mapping.set)).map(|a| document.read_floats::<2>(what, a)).transpose()?;
        // What has no place in the texture has no tangent either.
        let wants_tangents = has_normal_map && uvs.is_some();
        let mut uvs = uvs.unwrap_or_else(|| vec![[0.0; 2]; count]);
        same("texture coordinates", uvs.len())?;
        mapping.apply(&mut uvs);
        let colors = attribute(Semantic::Colors(0)).map(|a| document.read_colors(what, a)).transpose()?;
        same("colours", colors.as_ref().map_or(count, Vec::len))?;
        // Tangents for other normals than those of the triangles would not fit them.
        let tangents = attribute(Semantic::Tangents).filter(|_| wants_tangents && normals.is_some());
        let tangents = tangents.map(|a| document.read_floats::<4>(what, a)).transpose()?;
        same("tangents", tangents.as_ref().map_or(count, Vec::len))?;
        let tangents = tangents.and_then(|given| usable(document, &given));
        let indices = match primitive.indices {
            Some(accessor) => document.read_indices(what, accessor)?,
            None => (0..count as u32).collect(),
        };
        let restart = primitive.indices.filter(|_| mode != Mode::Triangles).and_then(|i| document.restart_index(i));
        let restart = restart.filter(|restart| *restart as usize >= count);
        if let Some(bad) = indices.iter().find(|i| **i as usize >= count && Some(**i) != restart) {
            return Err(document.error(format_args!("{what} has the index {bad} but only {count} vertices")));
        }
        self.incomplete += u64::from(if mode == Mode::Triangles { indices.len() % 3 != 0 } else { indices.len() < 3 });
        Ok(Shape {
            of,
            positions,
            normals,
            lacks_tangents: wants_tangents && tangents.is_none(),
            tangents: tangents.unwrap_or_default(),
            paint: Paint { uvs, colors },
            triangles: pieces(document, &indices, restart).flat_map(|piece| triangulate(mode, piece)).collect(),
        })
    }

    /// Keeps the totals within bounds before anything is read or allocated.
    fn announce(
        &mut self,
        document: &Document,
        position: Index<Accessor>,
        indices: Option<Index<Accessor>>,
        mode: Mode,
    ) -> Result<()> {
        let vertices = document.accessor_count(position)?;
        let corners = indices.map_or(Ok(vertices), |i| document.accessor_count(i))?;
        self.announced_vertices = self.announced_vertices.saturating_add(vertices.max(LEAST_VERTICES));
        // A strip or fan makes a triangle of every further corner.
        let triangles = if mode == Mode::Triangles { corners / 3 } else { corners };
        self.announced_triangles = self.announced_triangles.saturating_add(triangles);
        if self.announced_vertices > MAX_COUNT || self.announced_triangles > MAX_COUNT {
            return Err(document.error(format_args!("the scene has more than {MAX_COUNT} vertices or triangles")));
        }
        Ok(())
    }

    /// Adds tangents of the vertices from `first` on, which are the last so far; none where there are none.
    fn push_tangents(&mut self, first: usize, tangents: impl ExactSizeIterator<Item = Vec4>) {
        if tangents.len() > 0 {
            self.tangents.resize(first, NO_TANGENT);
            self.tangents.extend(tangents.map(pack_tangent));
        }
    }

    /// Keeps the vertices as they are; unusable normals become that of a triangle at the vertex.
    fn push_shared(&mut self, material: usize, shape: &Shape, normals: &[Vec3]) {
        let mut normals = normals.to_vec();
        fill_normals(&mut normals, &shape.positions, &shape.triangles);
        let base = self.vertices.len() as u32;
        self.push_tangents(base as usize, shape.tangents.iter().copied());
        self.vertices
            .extend(normals.iter().enumerate().map(|(i, normal)| shape.paint.vertex(i, shape.positions[i], *normal)));
        self.corners[material].extend(shape.triangles.iter().flatten().map(|i| base + i));
    }

    /// Gives every triangle three vertices of its own, with its geometric normal.
    fn push_flat(&mut self, material: usize, shape: &Shape) {
        if !shape.tangents.is_empty() {
            let of_corners = shape.triangles.as_flattened().iter().map(|corner| shape.tangents[*corner as usize]);
            self.push_tangents(self.vertices.len(), of_corners);
        }
        for triangle in &shape.triangles {
            let normal = face_normal(&shape.positions, *triangle);
            for corner in triangle.map(|i| i as usize) {
                self.corners[material].push(self.vertices.len() as u32);
                self.vertices.push(shape.paint.vertex(corner, shape.positions[corner], normal));
            }
        }
    }

    /// Adds the triangles of a body, whose vertices get their places when it is posed.
    pub fn add_unplaced(&mut self, material: usize, body: &Body, paint: &Paint) {
        let base = self.vertices.len() as u32;
        let tangent_count = if body.tangents.is_empty() { 0 } else { body.vertex_count() };
        self.push_tangents(base as usize, std::iter::repeat_n(Vec4::ZERO, tangent_count));
        let corners = body.triangles.iter().flatten();
        let unplaced = |i: usize| paint.vertex(i, Vec3::ZERO, Vec3::Z);
        if body.normals.is_some() {
            self.vertices.extend((0..paint.uvs.len()).map(unplaced));
            self.corners[material].extend(corners.map(|corner| base + corner));
        } else {
            self.vertices.extend(corners.map(|corner| unplaced(*corner as usize)));
            self.corners[material].extend(base..self.vertices.len() as u32);
        }
    }
}

impl Shape {
    /// Transforms to world space, keeps front faces in front under mirroring, drops and counts triangles without area.
    fn place(&mut self, world: &Mat4) -> u64 {
        let linear = Mat3::from_mat4(*world);
        let mirrored = linear.determinant() < 0.0;
        let to_world = normal_matrix(&linear, mirrored);
        self.positions.iter_mut().for_each(|p| *p = world.transform_point3(*p));
        // Zero marks a normal that cannot be used.
        self.normals.iter_mut().flatten().for_each(|n| *n = (to_world * n.normalize_or_zero()).normalize_or_zero());
        let to_world = TangentTransform::new(&linear, mirrored);
        self.tangents.iter_mut().for_each(|tangent| *tangent = to_world.apply(*tangent));
        if mirrored {
            self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        let before = self.triangles.len();
        let positions = &self.positions;
        self.triangles.retain(|t| {
            let [a, b, c] = t.map(|i| positions[i as usize]);
            // Not merely the area: its square must not vanish either, or no one could normalise the normal.
            // Positions that are not finite stay, to be found by the caller.
            (b - a).cross(c - a).length_squared() != 0.0
        });
        (before - self.triangles.len()) as u64
    }
}

impl Paint {
    /// The vertex `i` at this place.
    fn vertex(&self, i: usize, position: Vec3, normal: Vec3) -> Vertex {
        let color = self.colors.as_ref().map_or(Vertex::WHITE, |colors| colors[i]);
        Vertex { position_ws: position.to_array(), normal_oct: pack_octahedral(normal), uv: self.uvs[i], color }
    }
}

/// Whether a position is nowhere, or so far away that areas overflow.
pub(super) fn is_lost(position: Vec3) -> bool {
    !position.is_finite() || position.abs().max_element() > MAX_COORDINATE
}

/// The position, or the nearest that is not lost.
pub(super) fn within_reach(position: Vec3) -> Vec3 {
    let known = Vec3::select(position.is_nan_mask(), Vec3::ZERO, position);
    known.clamp(Vec3::splat(-MAX_COORDINATE), Vec3::splat(MAX_COORDINATE))
}

/// The normal of a triangle by its corners.
pub(super) fn face_normal(positions: &[Vec3], triangle: [u32; 3]) -> Vec3 {
    let [a, b, c] = triangle.map(|i| positions[i as usize]);
    (b - a).cross(c - a).normalize_or(Vec3::Z)
}

/// Gives vertices without a usable normal that of a triangle at the vertex.
pub(super) fn fill_normals(normals: &mut [Vec3], positions: &[Vec3], triangles: &[[u32; 3]]) {
    for triangle in triangles {
        for corner in triangle {
            let normal = &mut normals[*corner as usize];
            if *normal == Vec3::ZERO {
                *normal = face_normal(positions, *triangle);
            }
        }
    }
}

/// Takes tangents to world space.
pub(super) struct TangentTransform {
    linear: Mat3,
    /// -1 where space is mirrored, and the bitangent comes to lie on the other side.
    side: f32,
}

impl TangentTransform {
    /// For this transform of positions, for which normals are mirrored or not.
    pub fn new(linear: &Mat3, mirrored: bool) -> Self {
        Self { linear: scaled_to_one(linear), side: if mirrored { -1.0 } else { 1.0 } }
    }

    /// The tangent in world space, of unit length; 0 where it has no direction.
    pub fn apply(&self, tangent: Vec4) -> Vec4 {
        (self.linear * tangent.truncate()).normalize_or_zero().extend(self.side * tangent.w)
    }
}

/// With entries of at most 1, or the products of tiny or huge scales would leave the range of floats.
fn scaled_to_one(m: &Mat3) -> Mat3 {
    let size = m.x_axis.abs().max(m.y_axis.abs()).max(m.z_axis.abs()).max_element();
    if size > 0.0 { *m * (1.0 / size) } else { *m }
}

/// The inverse transpose up to a positive factor; cofactors, so that it exists for flattened meshes too.
pub(super) fn normal_matrix(m: &Mat3, mirrored: bool) -> Mat3 {
    let m = scaled_to_one(m);
    let cofactors = Mat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
    if mirrored { cofactors * -1.0 } else { cofactors }
}

pub(super) fn vectors(arrays: Vec<[f32; 3]>) -> Vec<Vec3> {
    arrays.into_iter().map(Vec3::from_array).collect()
}

/// Whether primitives of this mode are triangles.
pub(super) fn has_triangles(mode: Mode) -> bool {
    matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)
}

/// Strips or fans between indices that begin another one.
fn pieces<'a>(document: &Document, indices: &'a [u32], restart: Option<u32>) -> impl Iterator<Item = &'a [u32]> {
    if restart.is_some_and(|restart| indices.contains(&restart)) {
        document.mend("strips or fans that begin anew at the largest index");
    }
    indices.split(move |index| Some(*index) == restart)
}

/// Triangles of a list, strip or fan, wound as the glTF specification says.
fn triangulate(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => {
            let odd = |(i, w): (usize, &[u32])| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] };
            indices.windows(3).enumerate().map(odd).collect()
        }
        Mode::TriangleFan => indices.get(1..).unwrap_or(&[]).windows(2).map(|w| [w[0], w[1], indices[0]]).collect(),
        _ => indices.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_wind_as_specified() {
        assert_eq!(triangulate(Mode::TriangleStrip, &[0, 1, 2, 3]), [[0, 1, 2], [1, 3, 2]]);
        assert_eq!(triangulate(Mode::TriangleFan, &[0, 1, 2, 3]), [[1, 2, 0], [2, 3, 0]]);
        assert_eq!(triangulate(Mode::Triangles, &[0, 1, 2, 3, 4]), [[0, 1, 2]]);
        for mode in [Mode::Triangles, Mode::TriangleStrip, Mode::TriangleFan] {
            assert!(triangulate(mode, &[]).is_empty() && triangulate(mode, &[0, 1]).is_empty());
        }
    }

    #[test]
    fn normals_use_the_inverse_transpose() {
        let stretch = Mat3::from_diagonal(Vec3::new(2.0, 1.0, 1.0));
        let n = (normal_matrix(&stretch, false) * Vec3::new(1.0, 1.0, 0.0)).normalize();
        assert!((n - Vec3::new(1.0, 2.0, 0.0).normalize()).length() < 1e-6);
        let mirror = Mat3::from_diagonal(Vec3::new(-1.0, 1.0, 1.0));
        assert_eq!(normal_matrix(&mirror, true) * Vec3::X, Vec3::NEG_X);
        assert_eq!(normal_matrix(&mirror, true) * Vec3::Y, Vec3::Y);
        let tiny = Mat3::from_diagonal(Vec3::splat(1e-25));
        assert_eq!((normal_matrix(&tiny, false) * Vec3::Y).normalize(), Vec3::Y);
    }
}
