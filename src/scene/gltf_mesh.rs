//! Triangles of glTF meshes, transformed to world space and gathered by material.

use ::gltf::json::Index;
use ::gltf::json::accessor::Accessor;
use ::gltf::json::mesh::{Mode, Primitive, Semantic};
use ::gltf::json::validation::Checked;
use glam::{Mat3, Mat4, Vec3};

use super::Vertex;
use super::gltf_buffers::Document;
use super::gltf_extensions::compression;
use super::gltf_mapping::Mapping;
use super::gltf_nodes::Instance;
use super::motion::{Body, Motion};
use super::octahedral::pack_octahedral;
use crate::Result;

/// The most vertices, and the most triangles, a scene may have.
const MAX_COUNT: u64 = 1 << 26;
/// What a primitive counts at least: reading very many without any vertex takes time too.
const LEAST_VERTICES: u64 = 8;
/// The farthest a vertex may be from the origin: beyond it, areas overflow in single precision.
const MAX_COORDINATE: f32 = 1e9;

/// Geometry gathered so far.
#[derive(Default)]
pub(super) struct Geometry {
    /// All vertices.
    pub vertices: Vec<Vertex>,
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
    mappings: Vec<Mapping>,
    announced_vertices: u64,
    announced_triangles: u64,
}

/// A primitive, in mesh space until it is placed.
pub(super) struct Shape {
    /// Corners.
    pub positions: Vec<Vec3>,
    /// Their normals; without them every triangle is flat.
    pub normals: Option<Vec<Vec3>>,
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
    pub fn new(mappings: &[Mapping]) -> Self {
        let mappings: Vec<Mapping> = mappings.iter().copied().chain([Mapping::default()]).collect();
        let has_colors = vec![false; mappings.len()];
        Self { corners: vec![Vec::new(); mappings.len()], has_colors, mappings, ..Self::default() }
    }

    /// Adds all triangles of one placed mesh; those that move go to `motion` as well, which will place them.
    pub fn add(&mut self, document: &Document, instance: &Instance, motion: &mut Motion, moves: bool) -> Result<()> {
        let m = instance.mesh;
        let Some(mesh) = document.root.meshes.get(m) else {
            return Err(document.error(format_args!("mesh {m} does not exist")));
        };
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let what = format!("mesh {m}, primitive {p}");
            let no_material = self.corners.len() - 1;
            let material = primitive.material.map_or(no_material, |material| material.value());
            if material > no_material || (primitive.material.is_some() && material == no_material) {
                return Err(document.error(format_args!("{what} refers to material {material}, which does not exist")));
            }
            let Checked::Valid(mode) = primitive.mode else {
                return Err(document.error(format_args!("{what} has an unknown mode")));
            };
            if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
                self.not_triangles += 1;
                continue;
            }
            let mut shape = self.read(document, &what, primitive, mode, self.mappings[material])?;
            self.has_colors[material] |= shape.paint.colors.is_some();
            if moves {
                motion.add(document, self, primitive, (instance, &what, material), shape)?;
                continue;
            }
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

    fn read(
        &mut self,
        document: &Document,
        what: &str,
        primitive: &Primitive,
        mode: Mode,
        mapping: Mapping,
    ) -> Result<Shape> {
        let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
        let Some(position) = attribute(Semantic::Positions) else {
            return Err(document.error(format_args!("{what} has no positions")));
        };
        let extensions = primitive.extensions.as_ref().map(|e| &e.others);
        if let Some(name) = compression(extensions)
            && document.is_empty_accessor(position)?
        {
            return Err(document.compressed(&what, name));
        }
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
        let mut uvs = uvs.unwrap_or_else(|| vec![[0.0; 2]; count]);
        same("texture coordinates", uvs.len())?;
        mapping.apply(&mut uvs);
        let colors = attribute(Semantic::Colors(0)).map(|a| document.read_colors(what, a)).transpose()?;
        same("colours", colors.as_ref().map_or(count, Vec::len))?;
        let indices = match primitive.indices {
            Some(accessor) => document.read_indices(what, accessor)?,
            None => (0..count as u32).collect(),
        };
        if let Some(bad) = indices.iter().find(|i| **i as usize >= count) {
            return Err(document.error(format_args!("{what} has the index {bad} but only {count} vertices")));
        }
        self.incomplete += u64::from(if mode == Mode::Triangles { indices.len() % 3 != 0 } else { indices.len() < 3 });
        Ok(Shape { positions, normals, paint: Paint { uvs, colors }, triangles: triangulate(mode, &indices) })
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

    /// Keeps the vertices as they are; unusable normals become that of a triangle at the vertex.
    fn push_shared(&mut self, material: usize, shape: &Shape, normals: &[Vec3]) {
        let mut normals = normals.to_vec();
        fill_normals(&mut normals, &shape.positions, &shape.triangles);
        let base = self.vertices.len() as u32;
        self.vertices
            .extend(normals.iter().enumerate().map(|(i, normal)| shape.paint.vertex(i, shape.positions[i], *normal)));
        self.corners[material].extend(shape.triangles.iter().flatten().map(|i| base + i));
    }

    /// Gives every triangle three vertices of its own, with its geometric normal.
    fn push_flat(&mut self, material: usize, shape: &Shape) {
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

/// The inverse transpose up to a positive factor; cofactors, so that it exists for flattened meshes too.
pub(super) fn normal_matrix(m: &Mat3, mirrored: bool) -> Mat3 {
    // Scaled first, or the products of tiny or huge scales would leave the range of floats.
    let size = m.x_axis.abs().max(m.y_axis.abs()).max(m.z_axis.abs()).max_element();
    let m = if size > 0.0 { *m * (1.0 / size) } else { *m };
    let cofactors = Mat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
    if mirrored { cofactors * -1.0 } else { cofactors }
}

pub(super) fn vectors(arrays: Vec<[f32; 3]>) -> Vec<Vec3> {
    arrays.into_iter().map(Vec3::from_array).collect()
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
