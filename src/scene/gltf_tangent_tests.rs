//! Tangents with answers by hand: those of the file, and those that are computed.

use std::f32::consts::TAU;

use glam::{Vec3, Vec4};
use serde_json::{Value, json};

use super::tests::{Parts, QUAD, open};
use crate::scene::Scene;
use crate::scene::octahedral::{unpack_octahedral, unpack_tangent};

/// Texture coordinates of `QUAD`: u along x, and v down.
const UPRIGHT: [f32; 8] = [0., 1., 1., 1., 0., 0., 1., 0.];
/// The same with u against x.
const MIRRORED: [f32; 8] = [1., 1., 0., 1., 1., 0., 0., 0.];
const TOWARDS_Z: [f32; 12] = [0., 0., 1., 0., 0., 1., 0., 0., 1., 0., 0., 1.];
const TWO_TRIANGLES: [u16; 6] = [0, 1, 2, 1, 3, 2];

/// A mesh with a normal map in the making.
struct Mesh {
    parts: Parts,
    primitive: Value,
    node: Value,
    has_map: bool,
}

impl Mesh {
    fn new(positions: &[f32], uvs: &[f32], indices: &[u16]) -> Self {
        let mut parts = Parts::default();
        let (position, uv) = (parts.floats("VEC3", positions), parts.floats("VEC2", uvs));
        let indices = parts.indices(indices);
        let primitive =
            json!({"attributes": {"POSITION": position, "TEXCOORD_0": uv}, "indices": indices, "material": 0});
        Self { parts, primitive, node: json!({"mesh": 0}), has_map: true }
    }

    /// `QUAD` with normals towards z.
    fn quad(uvs: &[f32]) -> Self {
        Self::new(&QUAD, uvs, &TWO_TRIANGLES).with_normals(&TOWARDS_Z)
    }

    fn with_normals(mut self, normals: &[f32]) -> Self {
        self.primitive["attributes"]["NORMAL"] = json!(self.parts.floats("VEC3", normals));
        self
    }

    /// The same tangent at each of four corners.
    fn with_tangents(mut self, component: u32, bytes: &[u8]) -> Self {
        let view = self.parts.view(&bytes.repeat(4));
        let accessor =
            json!({"bufferView": view, "componentType": component, "normalized": true, "count": 4, "type": "VEC4"});
        self.primitive["attributes"]["TANGENT"] = json!(self.parts.accessor(accessor));
        self
    }

    fn with_node(mut self, key: &str, value: Value) -> Self {
        self.node[key] = value;
        self
    }

    fn load(mut self) -> Scene {
        let mut png = std::io::Cursor::new(Vec::new());
        let flat = image::RgbImage::from_pixel(1, 1, image::Rgb([128, 128, 255]));
        flat.write_to(&mut png, image::ImageFormat::Png).unwrap();
        let image = self.parts.view(&png.into_inner());
        let material = if self.has_map { json!({"normalTexture": {"index": 0}}) } else { json!({}) };
        let extra = json!({
            "nodes": [self.node], "materials": [material], "textures": [{"source": 0}],
            "images": [{"bufferView": image, "mimeType": "image/png"}]
        });
        open(&self.parts.glb(json!([{"primitives": [self.primitive]}]), extra)).unwrap()
    }
}

fn floats(tangent: [f32; 4]) -> Vec<u8> {
    bytemuck::cast_slice(&tangent).to_vec()
}

/// The tangent of each corner of the triangles.
fn tangents(scene: &Scene) -> Vec<Vec4> {
    scene.indices.iter().map(|index| unpack_tangent(scene.tangents[*index as usize])).collect()
}

fn all_are(scene: &Scene, expected: Vec4) {
    let found = tangents(scene);
    assert!(found.iter().all(|tangent| tangent.distance(expected) <= 1e-4), "{found:?}, not {expected}");
}

#[test]
fn tangents_are_computed_along_u() {
    all_are(&Mesh::quad(&UPRIGHT).load(), Vec4::new(1.0, 0.0, 0.0, 1.0));
    // Turned by a quarter: u runs along y, and upwards in the texture is against x.
    all_are(&Mesh::quad(&[0., 0., 0., 1., 1., 0., 1., 1.]).load(), Vec4::new(0.0, 1.0, 0.0, 1.0));
    all_are(&Mesh::quad(&MIRRORED).load(), Vec4::new(-1.0, 0.0, 0.0, -1.0));
}

/// Of two squares side by side the second has the texture mirrored: the vertices between them become two each.
#[test]
fn a_mirror_seam_splits_its_vertices() {
    let positions = [0., 0., 0., 1., 0., 0., 2., 0., 0., 0., 1., 0., 1., 1., 0., 2., 1., 0.];
    let uvs = [0., 1., 1., 1., 0., 1., 0., 0., 1., 0., 0., 0.];
    let indices = [0, 1, 3, 1, 4, 3, 1, 2, 4, 2, 5, 4];
    let scene = Mesh::new(&positions, &uvs, &indices).with_normals(&[0., 0., 1.].repeat(6)).load();
    assert_eq!((scene.vertices.len(), scene.tangents.len()), (8, 8));
    let (left, right) = (Vec4::new(1.0, 0.0, 0.0, 1.0), Vec4::new(-1.0, 0.0, 0.0, -1.0));
    assert_eq!(tangents(&scene), [[left; 6], [right; 6]].concat());
    // They are where they were.
    let place = |corner: usize| scene.vertices[scene.indices[corner] as usize];
    assert_eq!((place(1).position_ws, place(6).position_ws, place(6).uv), ([1., 0., 0.], [1., 0., 0.], [1., 1.]));
}

#[test]
fn tangents_of_the_file_are_used_though_texture_coordinates_disagree() {
    for (component, bytes) in [
        (5126, floats([0.0, 2.0, 0.0, -1.0])),
        (5120, vec![0, 127, 0, 0x81]),
        (5122, bytemuck::cast_slice(&[0i16, 32767, 0, -32767]).to_vec()),
    ] {
        let scene = Mesh::quad(&UPRIGHT).with_tangents(component, &bytes).load();
        all_are(&scene, Vec4::new(0.0, 1.0, 0.0, -1.0));
        assert_eq!(scene.vertices.len(), 4);
    }
}

#[test]
fn tangents_without_a_direction_or_a_side_are_computed_instead() {
    for unusable in [[0.0, 0.0, 0.0, 1.0], [f32::NAN, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0], [0.0, 1.0, 0.0, f32::NAN]] {
        let scene = Mesh::quad(&UPRIGHT).with_tangents(5126, &floats(unusable)).load();
        all_are(&scene, Vec4::new(1.0, 0.0, 0.0, 1.0));
    }
}

/// Without normals triangles are flat, and tangents of the file would belong to other normals.
#[test]
fn flat_triangles_have_computed_tangents() {
    // A ridge of slope 1 on both sides.
    let positions = [0., 0., 0., 1., 0., 1., 2., 0., 0., 0., 1., 0., 1., 1., 1., 2., 1., 0.];
    let uvs = [0., 1., 1., 1., 2., 1., 0., 0., 1., 0., 2., 0.];
    let indices = [0, 1, 3, 1, 4, 3, 1, 2, 4, 2, 5, 4];
    let scene = Mesh::new(&positions, &uvs, &indices).load();
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let [up, down] = [half, -half].map(|z| Vec4::new(half, 0.0, z, 1.0));
    for (found, expected) in tangents(&scene).into_iter().zip([[up; 6], [down; 6]].concat()) {
        assert!(found.distance(expected) <= 1e-4, "{found}, not {expected}");
    }
    let scene = Mesh::new(&QUAD, &UPRIGHT, &TWO_TRIANGLES).with_tangents(5126, &floats([0.0, 1.0, 0.0, -1.0])).load();
    all_are(&scene, Vec4::new(1.0, 0.0, 0.0, 1.0));
}

/// In a mirrored mesh the bitangent, which is `w cross(normal, tangent)`, still goes where upwards in the texture does.
#[test]
fn a_node_that_mirrors_changes_the_side() {
    for (scale, expected) in [
        (json!([-1, 1, 1]), Vec4::new(-1.0, 0.0, 0.0, -1.0)),
        (json!([1, -3, 1]), Vec4::new(1.0, 0.0, 0.0, -1.0)),
        (json!([1, 1, -1]), Vec4::new(1.0, 0.0, 0.0, -1.0)),
        (json!([-1, -1, 1]), Vec4::new(-1.0, 0.0, 0.0, 1.0)),
    ] {
        for mesh in [Mesh::quad(&UPRIGHT), Mesh::new(&QUAD, &UPRIGHT, &TWO_TRIANGLES)] {
            let scene = mesh.with_node("scale", scale.clone()).load();
            all_are(&scene, expected);
            let normal = unpack_octahedral(scene.vertices[0].normal_oct);
            let bitangent = normal.cross(expected.truncate()) * expected.w;
            let upwards = Vec3::Y * scale[1].as_f64().unwrap().signum() as f32;
            assert!(bitangent.distance(upwards) <= 1e-4, "{scale}: {bitangent}");
        }
    }
}

/// Half of a cylinder about z in `segments` strips, with u around it.
fn cylinder(segments: u16) -> Mesh {
    let (mut positions, mut normals, mut uvs, mut indices) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for i in 0..=segments {
        let share = f32::from(i) / f32::from(segments);
        let (y, x) = (0.5 * TAU * share).sin_cos();
        for z in [0.0, 1.0] {
            positions.extend([x, y, z]);
            normals.extend([x, y, 0.0]);
            uvs.extend([share, 1.0 - z]);
        }
        if i < segments {
            indices.extend([0, 2, 1, 1, 2, 3].map(|k| 2 * i + k));
        }
    }
    Mesh::new(&positions, &uvs, &indices).with_normals(&normals)
}

#[test]
fn tangents_of_a_cylinder_are_smooth() {
    let scene = cylinder(16).load();
    assert_eq!(scene.vertices.len(), 34, "no vertex is split");
    for (vertex, tangent) in scene.vertices.iter().zip(&scene.tangents) {
        let [x, y, _] = vertex.position_ws;
        let (found, around) = (unpack_tangent(*tangent), Vec4::new(-y, x, 0.0, 1.0));
        // What a strip adds is its chord, projected to the tangent plane of the vertex.
        assert!(found.distance(around) <= 2e-4, "{found}, not {around}");
    }
}

#[test]
fn only_vertices_with_a_normal_map_have_tangents() {
    let mut plain = Mesh::quad(&UPRIGHT);
    plain.has_map = false;
    assert!(plain.load().tangents.is_empty());
    // A normal map without a place in it.
    let mut unplaced = Mesh::quad(&UPRIGHT);
    unplaced.primitive["attributes"].as_object_mut().unwrap().remove("TEXCOORD_0");
    assert!(unplaced.load().tangents.is_empty());
    // All of a surface in one texel: nothing says where u runs.
    all_are(&Mesh::quad(&[0.5; 8]).load(), Vec4::ZERO);
}

/// A fan of so many triangles about a vertex.
fn fan(triangles: u16) -> Mesh {
    let (mut positions, mut uvs) = (vec![0.0; 3], vec![0.5; 2]);
    for i in 0..=triangles {
        let (y, x) = (TAU * f32::from(i) / f32::from(triangles)).sin_cos();
        positions.extend([x, y, 0.0]);
        uvs.extend([0.5 + 0.5 * x, 0.5 - 0.5 * y]);
    }
    let indices: Vec<u16> = (1..=triangles).flat_map(|i| [0, i, i + 1]).collect();
    let normals = [0., 0., 1.].repeat(positions.len() / 3);
    Mesh::new(&positions, &uvs, &indices).with_normals(&normals)
}

#[test]
fn where_too_many_triangles_meet_there_is_no_normal_map() {
    all_are(&fan(2000).load(), Vec4::new(1.0, 0.0, 0.0, 1.0));
    assert!(fan(30_000).load().tangents.is_empty());
}

#[test]
fn hostile_numbers_make_no_tangents_that_are_not_finite() {
    let huge = [0., 0., 0., 1e30, 0., 0., 0., 1e30, 0., 1e30, 1e30, 0.];
    let small = json!([1e-30, 1e-30, 1e-30]);
    for uvs in [UPRIGHT, [3e38, -3e38, 0., 3e38, 1e-38, 0., -3e38, 1e38], [f32::NAN; 8], [1e-40; 8]] {
        for positions in [QUAD, huge] {
            let mesh = Mesh::new(&positions, &uvs, &TWO_TRIANGLES).with_normals(&TOWARDS_Z);
            let mesh = if positions == huge { mesh.with_node("scale", small.clone()) } else { mesh };
            assert!(tangents(&mesh.load()).iter().all(|tangent| tangent.is_finite()), "{uvs:?}");
        }
    }
}
