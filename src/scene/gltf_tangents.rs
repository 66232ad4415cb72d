//! Tangents of surfaces with normal maps: those of the file, or MikkTSpace's where it has none, as glTF wants it.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use ::gltf::json::mesh::{Primitive, Semantic};
use ::gltf::json::validation::Checked;
use bevy_mikktspace::{TangentSpace, generate_tangents};
use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::gltf_buffers::Document;
use super::gltf_mesh::{Geometry, Look, Shape, face_normal, fill_normals, has_triangles};
use super::gltf_nodes::Instance;
use super::motion::MorphTarget;
use crate::Result;

/// The most corners of triangles that may meet in a place: the time for them grows with their square, and MikkTSpace calls
/// itself once for each.
const MOST_CORNERS: u32 = 2048;
/// The most triangles that all morph targets of a primitive may have together to have tangents of their own: seconds of work.
const MOST_MORPHED_TRIANGLES: usize = 1 << 20;
/// No further vertex.
const NONE: u32 = u32::MAX;

/// Tangents of the file, of unit length and with a side of 1 or -1; `None` where one of them has no direction or no side.
pub(super) fn usable(document: &Document, given: &[[f32; 4]]) -> Option<Vec<Vec4>> {
    let usable = |[x, y, z, w]: &[f32; 4]| {
        let direction = Vec3::new(*x, *y, *z).try_normalize()?;
        (w.is_finite() && *w != 0.0).then(|| direction.extend(w.signum()))
    };
    let usable: Option<Vec<Vec4>> = given.iter().map(usable).collect();
    if usable.is_none() {
        document.mend("tangents without a direction or a side");
    }
    usable
}

/// Tangents of all corners, in the order of the triangles: of the shape itself, and of each shape that it can be morphed
/// towards.
pub(super) type CornerTangents = Vec<Vec<Vec4>>;

impl Geometry {
    /// Computes on all cores the tangents of all primitives that lack them, but for those that are morphed.
    pub fn compute_ahead(&mut self, document: &Document, instances: &[Instance]) -> Result<()> {
        // What it reads counts when it is placed.
        let mut reader = self.to_read_ahead();
        let mut shapes = Vec::new();
        let mut seen = HashSet::new();
        let placed = instances.iter().map(|instance| instance.mesh).filter(|mesh| seen.insert(*mesh));
        for (m, mesh) in placed.filter_map(|m| Some((m, document.root.meshes.get(m)?))) {
            for (p, primitive) in mesh.primitives.iter().enumerate() {
                let what = format!("mesh {m}, primitive {p}");
                let look = self.looks[self.material_of(document, m, primitive)];
                if let Checked::Valid(mode) = primitive.mode
                    && has_triangles(mode)
                    && primitive.targets.is_none()
                    && lacks_tangents(primitive, look)
                {
                    shapes.push(reader.read(document, ((m, p), &what), primitive, mode, look)?);
                }
            }
        }
        let computed = shapes.par_iter().with_max_len(1).map(|s| (s.of, s.corner_tangents(&[]).map(Arc::new)));
        self.computed = computed.collect();
        Ok(())
    }

    /// Gives a shape that lacks them its tangents, for which vertices may become several; returns of which vertex each new one
    /// is a copy.
    pub fn compute_tangents(
        &mut self,
        document: &Document,
        shape: &mut Shape,
        targets: &mut [MorphTarget],
    ) -> Vec<u32> {
        if !shape.lacks_tangents {
            return Vec::new();
        }
        let too_many = shape.triangles.len().saturating_mul(targets.len()) > MOST_MORPHED_TRIANGLES;
        if too_many {
            document.ignore("what very many morph targets do to tangents");
        }
        let compute = || shape.corner_tangents(if too_many { &[] } else { targets }).map(Arc::new);
        let Some(corners) = self.computed.entry(shape.of).or_insert_with(compute).clone() else {
            document.ignore("normal maps of surfaces with thousands of triangles at a vertex");
            return Vec::new();
        };
        shape.take_tangents(&corners, targets)
    }
}

/// Whether tangents are to be computed for a primitive that looks like this.
fn lacks_tangents(primitive: &Primitive, look: Look) -> bool {
    let has = |semantic| primitive.attributes.contains_key(&Checked::Valid(semantic));
    let is_mapped = look.has_normal_map && has(Semantic::TexCoords(look.mapping.set));
    is_mapped && !(has(Semantic::Tangents) && has(Semantic::Normals))
}

impl Shape {
    /// MikkTSpace's tangents, in the space of the mesh. `None` where more triangles meet than it can go through.
    pub fn corner_tangents(&self, targets: &[MorphTarget]) -> Option<CornerTangents> {
        let tangents = |positions: &[Vec3], normals: Option<&[Vec3]>| {
            let fits = self.most_corners_in_a_place(positions) <= MOST_CORNERS;
            fits.then(|| Corners::new(self, positions, normals).tangents())
        };
        let own = tangents(&self.positions, self.normals.as_deref())?;
        let morphed = targets.par_iter().map(|target| {
            let positions = moved(&self.positions, &target.positions);
            let normals = self.normals.as_ref().map(|normals| moved(normals, &target.normals));
            tangents(&positions, normals.as_deref())
        });
        let morphed = morphed.collect::<Option<CornerTangents>>()?;
        Some([own].into_iter().chain(morphed).collect())
    }

    /// Takes over tangents of its corners. A vertex whose corners have different ones becomes several; returns of which
    /// vertex each new one is a copy.
    pub fn take_tangents(&mut self, corners: &CornerTangents, targets: &mut [MorphTarget]) -> Vec<u32> {
        let count = self.positions.len();
        let Split { tangents, copies } = Split::new(count, &mut self.triangles, corners);
        append_copies(&mut self.positions, &copies);
        self.normals.iter_mut().for_each(|normals| append_copies(normals, &copies));
        append_copies(&mut self.paint.uvs, &copies);
        self.paint.colors.iter_mut().for_each(|colors| append_copies(colors, &copies));
        let mut tangents = tangents.into_iter();
        self.tangents = tangents.next().unwrap_or_default();
        for target in targets {
            append_copies(&mut target.positions, &copies);
            append_copies(&mut target.normals, &copies);
            let morphed = tangents.next().unwrap_or_default();
            target.tangents = morphed.iter().zip(&self.tangents).map(|(m, own)| (*m - *own).truncate()).collect();
        }
        copies
    }

    fn most_corners_in_a_place(&self, positions: &[Vec3]) -> u32 {
        let mut of_vertices = vec![0; positions.len()];
        self.triangles.iter().flatten().for_each(|vertex| of_vertices[*vertex as usize] += 1);
        let mut of_places: HashMap<[u32; 3], u32> = HashMap::with_capacity(of_vertices.len());
        for (position, corners) in positions.iter().zip(of_vertices) {
            *of_places.entry(unsigned_zeros(position.to_array()).map(f32::to_bits)).or_default() += corners;
        }
        of_places.into_values().max().unwrap_or(0)
    }
}

/// Appends to a list with an entry for each vertex, unless it is empty, those of the copies.
fn append_copies<T: Copy>(list: &mut Vec<T>, copies: &[u32]) {
    if !list.is_empty() {
        list.reserve_exact(copies.len());
        copies.iter().for_each(|vertex| list.push(list[*vertex as usize]));
    }
}

/// Vectors with their offsets added; all of them as they are where there are none.
fn moved(vectors: &[Vec3], offsets: &[Vec3]) -> Vec<Vec3> {
    let mut moved = vectors.to_vec();
    moved.iter_mut().zip(offsets).for_each(|(vector, offset)| *vector += *offset);
    moved
}

/// Zeros without a sign: MikkTSpace joins corners whose bits are the same.
fn unsigned_zeros<const N: usize>(values: [f32; N]) -> [f32; N] {
    values.map(|value| value + 0.0)
}

/// Triangles as MikkTSpace sees them.
struct Corners<'a> {
    shape: &'a Shape,
    positions: &'a [Vec3],
    /// Of unit length: one per vertex, or per triangle where these are flat.
    normals: Vec<Vec3>,
    is_flat: bool,
    /// Triangles whose corners are apart: it looks for what others could have among all triangles, one by one.
    proper: Vec<usize>,
    /// Of all corners; 0 where nothing says where it points.
    tangents: Vec<Vec4>,
}

impl<'a> Corners<'a> {
    fn new(shape: &'a Shape, positions: &'a [Vec3], normals: Option<&[Vec3]>) -> Self {
        let triangles = &shape.triangles;
        let unit_normals = match normals {
            Some(normals) => {
                let mut normals: Vec<Vec3> = normals.iter().map(|normal| normal.normalize_or_zero()).collect();
                fill_normals(&mut normals, positions, triangles);
                normals
            }
            None => triangles.iter().map(|triangle| face_normal(positions, *triangle)).collect(),
        };
        let is_proper = |triangle: &usize| {
            let [a, b, c] = triangles[*triangle].map(|vertex| positions[vertex as usize]);
            a.is_finite() && b.is_finite() && c.is_finite() && a != b && b != c && c != a
        };
        Self {
            shape,
            positions,
            normals: unit_normals,
            is_flat: normals.is_none(),
            proper: (0..triangles.len()).filter(is_proper).collect(),
            tangents: vec![Vec4::ZERO; 3 * triangles.len()],
        }
    }

    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.shape.triangles[self.proper[face]][corner] as usize
    }

    fn tangents(mut self) -> Vec<Vec4> {
        // There is no error that it could return.
        let _ = generate_tangents(&mut self);
        // A triangle without an area has those that others have at its vertices: it may get one by morphing.
        let triangles = &self.shape.triangles;
        let mut known = vec![Vec4::ZERO; self.positions.len()];
        let with_vertices = triangles.iter().flatten().zip(&self.tangents);
        with_vertices.filter(|(_, tangent)| tangent.w != 0.0).for_each(|(vertex, t)| known[*vertex as usize] = *t);
        let mut proper = self.proper.iter().peekable();
        for (index, triangle) in triangles.iter().enumerate() {
            if proper.next_if_eq(&&index).is_none() {
                self.tangents[3 * index..][..3].copy_from_slice(&triangle.map(|vertex| known[vertex as usize]));
            }
        }
        self.tangents
    }
}

impl bevy_mikktspace::Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.proper.len()
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        unsigned_zeros(self.positions[self.vertex(face, corner)].to_array())
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        let index = if self.is_flat { self.proper[face] } else { self.vertex(face, corner) };
        unsigned_zeros(self.normals[index].to_array())
    }

    /// It has v point up, as the bitangent of glTF does, whose v points down.
    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        let [u, v] = self.shape.paint.uvs[self.vertex(face, corner)];
        unsigned_zeros([u, -v])
    }

    fn set_tangent(&mut self, found: Option<TangentSpace>, face: usize, corner: usize) {
        let tangent = found.map_or(Vec4::ZERO, |found| Vec4::from_array(found.tangent_encoded()));
        if tangent.is_finite() && tangent.truncate() != Vec3::ZERO {
            self.tangents[3 * self.proper[face] + corner] = tangent;
        }
    }
}

/// Vertices that have one tangent each.
struct Split {
    /// Of each list, tangents of all vertices; 0 of those that no triangle uses.
    tangents: Vec<Vec<Vec4>>,
    /// Of which vertex each new one is a copy.
    copies: Vec<u32>,
}

impl Split {
    /// Makes as many vertices of each as its corners have tangents that differ in any of the lists.
    fn new(count: usize, triangles: &mut [[u32; 3]], corners: &CornerTangents) -> Self {
        let mut split = Self { tangents: vec![vec![Vec4::ZERO; count]; corners.len()], copies: Vec::new() };
        let mut is_used = vec![false; count];
        // Of each vertex the next one that is a copy of the same.
        let mut next = vec![NONE; count];
        for (corner, index) in triangles.as_flattened_mut().iter_mut().enumerate() {
            let original = *index;
            loop {
                let at = *index as usize;
                if !is_used[at] {
                    is_used[at] = true;
                    split.tangents.iter_mut().zip(corners).for_each(|(list, corners)| list[at] = corners[corner]);
                    break;
                }
                if split.tangents.iter().zip(corners).all(|(list, corners)| list[at] == corners[corner]) {
                    break;
                }
                if next[at] == NONE {
                    next[at] = is_used.len() as u32;
                    is_used.push(false);
                    next.push(NONE);
                    split.copies.push(original);
                    split.tangents.iter_mut().for_each(|list| list.push(Vec4::ZERO));
                }
                *index = next[at];
            }
        }
        split
    }
}
