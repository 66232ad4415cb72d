//! Meshes that Google's encoder has compressed against the functions that they were made of (`tests/draco/make.py`).

use std::collections::BTreeSet;
use std::f32::consts::TAU;
use std::path::Path;

use ::gltf::json::Index;
use ::gltf::json::accessor::Accessor;
use ::gltf::json::mesh::Semantic;
use ::gltf::json::validation::Checked;
use serde_json::{Value, json};

use super::tests::{Parts, QUAD, open};
use super::*;
use crate::scene::testing::Random;

const EXTENSION: &str = "KHR_draco_mesh_compression";

/// A file of Google's encoder: a torus of so many vertices along and around it.
struct File {
    name: &'static str,
    stream: &'static [u8],
    size: [u32; 2],
}

macro_rules! files {
    ($($name:literal: $size:expr,)*) => {
        [$(File { name: $name, stream: include_bytes!(concat!("../../tests/draco/", $name, ".drc")), size: $size }),*]
    };
}

const FILES: [File; 5] = files! {
    "sequential": [9, 6],
    "unquantized": [9, 6],
    "standard": [9, 6],
    "valence": [27, 22],
    "smallest": [27, 22],
};

/// A vertex of the torus.
#[derive(Debug, PartialEq)]
struct Corner {
    position: [f32; 3],
    normal: [f32; 3],
    uv: [f32; 2],
    color: [f32; 4],
    joints: [u32; 4],
    weights: [f32; 4],
}

impl File {
    fn corner(&self, i: u32, j: u32) -> Corner {
        let [u, v] = self.size;
        let [a, b] = [(i, u), (j, v)].map(|(n, count)| TAU * (n % (count - 1)) as f32 / (count - 1) as f32);
        let normal = Vec3::new(a.cos() * b.cos(), b.sin(), a.sin() * b.cos());
        let bytes = |bytes: [u32; 4]| bytes.map(|byte| (byte % 256) as f32 / 255.0);
        Corner {
            position: (0.4 * normal + Vec3::new(a.cos(), 0.0, a.sin())).to_array(),
            normal: normal.to_array(),
            uv: [i as f32 / (u - 1) as f32, j as f32 / (v - 1) as f32],
            color: bytes([i, 7 * j, i + j, 255]),
            joints: [i, j, i + j, 300],
            weights: bytes([255 - j, j, 0, 0]),
        }
    }

    /// Triangles by the numbers of their vertices, the least first.
    fn triangles(&self) -> BTreeSet<[u32; 3]> {
        let [u, v] = self.size;
        let first = (0..u - 1).flat_map(|i| (0..v - 1).map(move |j| i * v + j));
        first.flat_map(|f| [[f, f + 1, f + v], [f + 1, f + v + 1, f + v]]).map(turned).collect()
    }

    /// The glTF of the torus, whose accessors have no data but the stream's.
    fn parts(&self) -> (Parts, Value) {
        let mut parts = Parts::default();
        let view = parts.view(self.stream);
        let count = self.size[0] * self.size[1];
        let mut accessor = |component: u32, kind: &str, normalized: bool, count: u32| {
            parts.accessor(json!({"componentType": component, "type": kind, "normalized": normalized, "count": count}))
        };
        let attributes = json!({"POSITION": accessor(5126, "VEC3", false, count),
            "NORMAL": accessor(5126, "VEC3", false, count), "TEXCOORD_0": accessor(5126, "VEC2", false, count), "COLOR_0": accessor(5121, "VEC4", true, count),
            "JOINTS_0": accessor(5123, "VEC4", false, count), "WEIGHTS_0": accessor(5121, "VEC4", true, count)});
        let indices = accessor(5123, "SCALAR", false, 3 * self.triangles().len() as u32);
        let ids = json!({"POSITION": 13, "NORMAL": 12, "TEXCOORD_0": 11, "COLOR_0": 10, "JOINTS_0": 7, "WEIGHTS_0": 9});
        let mesh = json!([{"primitives": [{"attributes": attributes, "indices": indices,
            "extensions": {EXTENSION: {"bufferView": view, "attributes": ids}}}]}]);
        (parts, mesh)
    }
}

/// The same triangle from its least corner on.
fn turned([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a <= b && a <= c { [a, b, c] } else { turned([b, c, a]) }
}

fn required() -> Value {
    json!({"extensionsRequired": [EXTENSION]})
}

/// What a file has of the first primitive: its vertices and triangles.
fn read(glb: &[u8]) -> (Vec<Corner>, Vec<[u32; 3]>) {
    let document = Document::parse(Path::new("test.glb"), None, glb, &|_, _, _| ()).unwrap();
    let primitive = &document.root.meshes[0].primitives[0];
    let of = |semantic| -> Index<Accessor> { primitive.attributes[&Checked::Valid(semantic)] };
    let positions = document.read_floats::<3>("a test", of(Semantic::Positions)).unwrap();
    let normals = document.read_floats::<3>("a test", of(Semantic::Normals)).unwrap();
    let uvs = document.read_floats::<2>("a test", of(Semantic::TexCoords(0))).unwrap();
    let colors = document.read_floats::<4>("a test", of(Semantic::Colors(0))).unwrap();
    let joints = document.read_joints("a test", of(Semantic::Joints(0))).unwrap();
    let weights = document.read_floats::<4>("a test", of(Semantic::Weights(0))).unwrap();
    let corner = |i: usize| Corner {
        position: positions[i],
        normal: normals[i],
        uv: uvs[i],
        color: colors[i],
        joints: joints[i],
        weights: weights[i],
    };
    let indices = document.read_indices("a test", primitive.indices.unwrap()).unwrap();
    ((0..positions.len()).map(corner).collect(), indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect())
}

/// What differs from the torus, in a word.
fn difference(file: &File, corners: &[Corner], triangles: &[[u32; 3]]) -> Option<&'static str> {
    let near = |a: &[f32], b: &[f32], most: f32| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= most);
    let [u, v] = file.size;
    let mut numbers = Vec::new();
    for corner in corners {
        // Quantised to 10 bits, which are steps finer than those from vertex to vertex.
        let [i, j] = [(corner.uv[0], u), (corner.uv[1], v)].map(|(c, count)| (c * (count - 1) as f32).round() as u32);
        let wanted = file.corner(i, j);
        numbers.push(i * v + j);
        match () {
            () if !near(&corner.uv, &wanted.uv, 1.0 / 1023.0) => return Some("uv"),
            // Half a step of 11 bits over 2.8 m; and of 8 bits, octahedral.
            () if !near(&corner.position, &wanted.position, 1.4 / 2047.0) => return Some("position"),
            () if !near(&corner.normal, &wanted.normal, 2.0 / 127.0) => return Some("normal"),
            () if !near(&corner.color, &wanted.color, 1e-6) => return Some("colour"),
            () if corner.joints != wanted.joints => return Some("joints"),
            () if !near(&corner.weights, &wanted.weights, 1e-6) => return Some("weights"),
            () => {}
        }
    }
    let found: Vec<[u32; 3]> = triangles.iter().map(|t| turned(t.map(|i| numbers[i as usize]))).collect();
    let is_same =
        found.len() == file.triangles().len() && found.into_iter().collect::<BTreeSet<_>>() == file.triangles();
    (!is_same || corners.len() as u32 != u * v).then_some("triangles")
}

#[test]
fn every_method_gives_the_mesh_that_was_encoded() {
    for file in &FILES {
        let (parts, mesh) = file.parts();
        let glb = parts.glb(mesh.clone(), required());
        let (mut corners, mut triangles) = read(&glb);
        assert_eq!(difference(file, &corners, &triangles), None, "{}", file.name);
        let scene = open(&glb).unwrap();
        assert_eq!(scene.indices.len(), 3 * file.triangles().len(), "{}", file.name);
        assert!((scene.bounds.max.x - 1.4).abs() < 1e-3 && scene.vertices.len() == corners.len());
        // Planted faults.
        corners[3].position[1] += 0.01;
        assert_eq!(difference(file, &corners, &triangles), Some("position"));
        corners[3].position[1] -= 0.01;
        corners[5].weights.swap(0, 3);
        assert_eq!(difference(file, &corners, &triangles), Some("weights"));
        corners[5].weights.swap(0, 3);
        triangles[1].swap(0, 1);
        assert_eq!(difference(file, &corners, &triangles), Some("triangles"));
    }
}

#[test]
fn what_is_not_compressed_stays() {
    let file = &FILES[0];
    let (mut parts, mut mesh) = file.parts();
    let (corners, _) = read(&parts.glb(mesh.clone(), required()));
    // Of a sequential stream the order is known, so that another attribute may lie beside it.
    let uvs: Vec<f32> = corners.iter().flat_map(|corner| [corner.uv[1], -corner.uv[0]]).collect();
    let other = parts.floats("VEC2", &uvs);
    mesh[0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(other);
    mesh[0]["primitives"][0]["extensions"][EXTENSION]["attributes"].as_object_mut().unwrap().remove("TEXCOORD_0");
    let (mixed, _) = read(&parts.glb(mesh, required()));
    for (mixed, whole) in mixed.iter().zip(&corners) {
        assert_eq!((mixed.position, mixed.uv), (whole.position, [whole.uv[1], -whole.uv[0]]));
    }
}

#[test]
fn primitives_share_streams_and_have_numbers_of_their_own_type() {
    let file = &FILES[2];
    let (mut parts, mut mesh) = file.parts();
    let mut second = mesh[0]["primitives"][0].clone();
    // The same colours as floats, not normalised, and joints as bytes, which end at 255.
    let count = file.size[0] * file.size[1];
    let floats = parts.accessor(json!({"componentType": 5126, "type": "VEC4", "count": count}));
    let bytes = parts.accessor(json!({"componentType": 5121, "type": "VEC4", "count": count}));
    second["attributes"]["COLOR_0"] = json!(floats);
    second["attributes"]["JOINTS_0"] = json!(bytes);
    second["mode"] = json!(5);
    let first = mesh[0]["primitives"][0].clone();
    mesh[0]["primitives"] = json!([second, first]);
    let glb = parts.glb(mesh, required());
    let (corners, triangles) = read(&glb);
    assert_eq!(triangles.len(), file.triangles().len(), "a stream is a list, also where the primitive was a strip");
    assert!(corners.iter().all(|corner| corner.color[3] == 255.0 && corner.joints[3] == 255));
    let document = Document::parse(Path::new("test.glb"), None, &glb, &|_, _, _| ()).unwrap();
    let [a, b] = [0, 1].map(|p| &document.root.meshes[0].primitives[p]);
    let accessor = |p: &::gltf::json::mesh::Primitive, s| p.attributes[&Checked::Valid(s)].value();
    assert_eq!(accessor(a, Semantic::Positions), accessor(b, Semantic::Positions));
    assert_ne!(accessor(a, Semantic::Colors(0)), accessor(b, Semantic::Colors(0)));
    assert_eq!(a.indices.unwrap().value(), b.indices.unwrap().value());
}

/// The message about a torus that `change` has spoiled, the last of the small ones.
fn message(change: impl FnOnce(&mut Parts, &mut Value)) -> String {
    let (mut parts, mut mesh) = FILES[2].parts();
    change(&mut parts, &mut mesh[0]["primitives"][0]);
    let outcome = open(&parts.glb(mesh, required()));
    let message = outcome.map(drop).map_or_else(|e| e.to_string(), |()| "it is read".to_owned());
    assert!(!message.contains('\n') && message.len() < 400, "{message}");
    message
}

#[test]
fn faults_are_named() {
    assert_eq!(message(|_, _| ()), "it is read");
    let cannot = |why: &str| {
        format!("test.glb: mesh 0, primitive 0 cannot be decompressed by KHR_draco_mesh_compression: {why}")
    };
    let id = message(|_, p| p["extensions"][EXTENSION]["attributes"]["NORMAL"] = json!(99));
    assert_eq!(id, cannot("its data have no attribute 99, which is to be NORMAL"));
    let kind = message(|_, p| p["extensions"][EXTENSION]["attributes"]["NORMAL"] = json!(11));
    assert_eq!(kind, cannot("attribute 11 has 2 components, and NORMAL is Vec3"));
    let fewer = message(|parts, _| (0..7).for_each(|i| parts.accessors[i]["count"] = json!(12)));
    assert_eq!(fewer, cannot("its data hold more than its accessors announce"));
    let many = message(|parts, _| parts.accessors[6]["count"] = json!(1u64 << 31));
    assert_eq!(many, cannot("the file has too few bytes for what it announces"));
    let cut = message(|parts, _| parts.views[0]["byteLength"] = json!(300));
    assert!(cut.starts_with(&cannot("its data are damaged")), "{cut}");
    let version = message(|parts, _| parts.bin[5] = 9);
    assert_eq!(version, cannot("its data are of version 9.2; 1 and 2 are read"));
    let cloud = message(|parts, _| parts.bin[7] = 0);
    assert_eq!(cloud, cannot("its data are a point cloud"));
    let other = message(|parts, _| parts.bin[..5].copy_from_slice(b"DRAKE"));
    assert_eq!(other, cannot("its data are not of Draco"));
    let view = message(|_, p| p["extensions"][EXTENSION]["bufferView"] = json!(9));
    assert_eq!(view, "test.glb: mesh 0, primitive 0 refers to buffer view 9, which does not exist");
    let object = message(|_, p| p["extensions"][EXTENSION] = json!({"bufferView": 0}));
    assert!(object.starts_with("test.glb: mesh 0, primitive 0 has a broken KHR_draco_mesh_compression: "), "{object}");
    let (parts, mut mesh) = FILES[2].parts();
    let mut second = mesh[0]["primitives"][0].clone();
    second["attributes"]["NORMAL"] = json!(55);
    mesh[0]["primitives"].as_array_mut().unwrap().push(second);
    let shared = open(&parts.glb(mesh, required())).err().unwrap().to_string();
    assert_eq!(shared, "test.glb: accessor 55 does not exist");
    // Points and lines are left out, compressed or not.
    let points = message(|_, p| (p["mode"], p["extensions"][EXTENSION]["bufferView"]) = (json!(0), json!(9)));
    assert_eq!(points, "test.glb: the scene has no triangles");
}

#[test]
fn a_file_without_the_extension_required_is_read_by_it() {
    let (mut parts, mesh) = FILES[0].parts();
    // Uncompressed positions that are something else.
    let quad = parts.floats("VEC3", &QUAD.repeat(14)[..162]);
    parts.accessors[0] = parts.accessors[quad].clone();
    let (corners, triangles) = read(&parts.glb(mesh, json!({"extensionsUsed": [EXTENSION]})));
    assert_eq!(difference(&FILES[0], &corners, &triangles), None);
}

#[test]
fn cut_and_changed_streams_never_panic() {
    let mut random = Random(5);
    let mut refused = 0;
    for (round, file) in FILES.iter().cycle().take(1000).enumerate() {
        let (mut parts, mesh) = file.parts();
        let at = (random.next_unit() * file.stream.len() as f32) as usize;
        if round < 250 {
            parts.views[0]["byteLength"] = json!(at);
        } else {
            parts.bin[at] ^= 1 + (random.next_unit() * 254.0) as u8;
        }
        let said = open(&parts.glb(mesh, required())).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(!said.contains("does not expect"), "the decoder panicked: round {round}");
        assert!(!said.is_empty() || round >= 250, "a stream of {at} bytes was read");
        refused += usize::from(!said.is_empty());
    }
    assert!(refused > 350, "{refused}: changes no longer reach the decoder");
}
