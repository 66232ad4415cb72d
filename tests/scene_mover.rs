//! Scenes moved on the device against the same scenes moved by the host: vertices, tangents, triangles, boxes of the BVH.

mod common;
mod support;

use std::sync::Arc;

use bytemuck::pod_collect_to_vec;
use common::compare::within;
use common::gpu;
use glam::Vec3;
use gridlight::gpu::Gpu;
use gridlight::renderer::UploadedScene;
use gridlight::scene::octahedral::{unpack_octahedral, unpack_tangent};
use gridlight::scene::refit::MovingBvh;
use gridlight::scene::testing::shared_dir;
use gridlight::scene::{Scene, Vertex, bvh, gltf};
use gridlight::scene_mover::SceneMover;
use gridlight::shared::{BvhNode, BvhTriangle};
use serde_json::{Value, json};
use support::animated::{carried, playing, screens_that_change_places};
use support::{attribute, floats, quad_glb, view};

/// Of the scene's radius: sums of three products in single precision, in whatever order a device takes them.
const POSITION_TOLERANCE: f32 = 2e-6;
/// Half a step of a packed normal is 1.5e-5 to 5e-5; where rounding differs it is a whole one.
const DIRECTION_TOLERANCE: f32 = 2e-4;

/// What a device has of a scene.
struct Parts {
    vertices: Vec<Vertex>,
    tangents: Vec<u32>,
    triangles: Vec<BvhTriangle>,
    nodes: Vec<BvhNode>,
    largest_triangle: f32,
}

fn parts(gpu: &Arc<Gpu>, uploaded: &UploadedScene) -> Parts {
    let bytes = uploaded.read_back(gpu).unwrap();
    Parts {
        vertices: pod_collect_to_vec(&bytes.vertices),
        tangents: pod_collect_to_vec(&bytes.tangents),
        triangles: pod_collect_to_vec(&bytes.triangles),
        nodes: pod_collect_to_vec(&bytes.nodes),
        largest_triangle: uploaded.largest_triangle(),
    }
}

fn near(a: [f32; 3], b: [f32; 3], tolerance: f32) -> bool {
    Vec3::from(a).distance(Vec3::from(b)) <= tolerance
}

/// What differs between what the device and what the host has made of a scene; nothing where they agree.
fn difference(device: &Parts, host: &Parts, radius: f32) -> Option<String> {
    let tolerance = POSITION_TOLERANCE * radius;
    if [device.vertices.len(), device.tangents.len(), device.triangles.len()]
        != [host.vertices.len(), host.tangents.len(), host.triangles.len()]
    {
        return Some("another number of vertices, tangents or triangles".to_owned());
    }
    for (index, (a, b)) in device.vertices.iter().zip(&host.vertices).enumerate() {
        let directions = [a, b].map(|vertex| unpack_octahedral(vertex.normal_oct));
        let same_direction = directions[0].distance(directions[1]) <= DIRECTION_TOLERANCE;
        if !near(a.position_ws, b.position_ws, tolerance) || !same_direction || (a.uv, a.color) != (b.uv, b.color) {
            return Some(format!("vertex {index}: {a:?} {b:?} {directions:?}"));
        }
    }
    for (index, pair) in device.tangents.iter().zip(&host.tangents).enumerate() {
        let [a, b] = [unpack_tangent(*pair.0), unpack_tangent(*pair.1)];
        if !within(a.distance(b), DIRECTION_TOLERANCE) {
            return Some(format!("tangent {index}: {a} {b}"));
        }
    }
    for (index, (a, b)) in device.triangles.iter().zip(&host.triangles).enumerate() {
        let place = |t: &BvhTriangle| (t.triangle_index, t.material, t.flags);
        let edges = near(a.edge1, b.edge1, 2.0 * tolerance) && near(a.edge2, b.edge2, 2.0 * tolerance);
        if place(a) != place(b) || !near(a.v0, b.v0, tolerance) || !edges {
            return Some(format!("triangle {index}: {a:?} {b:?}"));
        }
    }
    let largest = (device.largest_triangle - host.largest_triangle).abs();
    (!within(largest, 2.0 * tolerance)).then(|| format!("the largest triangle differs by {largest}"))
}

/// A scene on the device twice, moved there and by the host.
struct Twice {
    gpu: Arc<Gpu>,
    scene: Scene,
    mover: SceneMover,
    device: UploadedScene,
    host: UploadedScene,
    tree: MovingBvh,
}

impl Twice {
    fn new(gpu: &Arc<Gpu>, scene: Scene) -> Self {
        let [device, host] = [0, 1].map(|_| UploadedScene::new(gpu, &scene).unwrap());
        let mover = SceneMover::new(gpu, &scene, &device).unwrap();
        assert!(!mover.pass_names().is_empty(), "the device moves {}", scene.name);
        Self { gpu: Arc::clone(gpu), mover, device, host, tree: MovingBvh::new(&bvh::build(&scene)), scene }
    }

    fn on_device(&mut self, time_s: f64) -> Parts {
        self.scene.pose_without_vertices(time_s);
        self.mover.follow(&mut self.device, &mut self.scene).unwrap();
        parts(&self.gpu, &self.device)
    }

    fn on_host(&mut self, time_s: f64) -> Parts {
        self.scene.pose(time_s);
        self.host.follow(&self.gpu, &self.scene).unwrap();
        parts(&self.gpu, &self.host)
    }

    /// Whether the nodes are, to the bit, the host's around the device's triangles.
    fn fits(&self, parts: &Parts) -> bool {
        self.tree.nodes_around(&parts.triangles) == parts.nodes
    }
}

/// Moves a scene to several moments; returns at how many of them its tree was kept.
fn compare(gpu: &Arc<Gpu>, scene: Scene, moments_s: &[f64]) -> usize {
    let (name, radius) = (scene.name.clone(), scene.bounds.radius());
    let mut twice = Twice::new(gpu, scene);
    let mut kept = 0;
    let mut last: Option<Parts> = None;
    for time_s in moments_s {
        let [device, host] = [twice.on_device(*time_s), twice.on_host(*time_s)];
        let difference = difference(&device, &host, radius);
        assert!(difference.is_none(), "{name} at {time_s} s: {}", difference.unwrap_or_default());
        let order = |triangles: &[BvhTriangle]| triangles.iter().map(|t| t.triangle_index).collect::<Vec<_>>();
        if order(&device.triangles) == order(&twice.tree.built().triangles) {
            kept += 1;
            assert!(twice.fits(&device), "{name} at {time_s} s: the boxes are others");
        } else {
            assert!(device.nodes == host.nodes, "{name} at {time_s} s: another tree than the host's");
        }
        // The comparisons see what stands still.
        if let Some(last) = last {
            assert!(self::difference(&last, &host, radius).is_some(), "{name}: nothing has moved until {time_s} s");
            assert!(!twice.fits(&Parts { nodes: last.nodes, ..device }), "{name}: old boxes fit at {time_s} s");
        }
        last = Some(twice.on_device(*time_s));
    }
    kept
}

const MOMENTS_S: [f64; 4] = [0.3, 0.75, 1.9, 0.31];

/// Gives a node the channels of an animation.
fn animate(document: &mut Value, bin: &mut Vec<u8>, node: usize, channels: &[(&str, &str, &[f32])]) {
    let input = floats(document, bin, "SCALAR", &[0.0, 1.0, 2.0]);
    let mut samplers = Vec::new();
    let mut targets = Vec::new();
    for (path, kind, values) in channels {
        let output = floats(document, bin, kind, values);
        targets.push(json!({"sampler": samplers.len(), "target": {"node": node, "path": path}}));
        samplers.push(json!({"input": input, "output": output}));
    }
    document["animations"] = json!([{"samplers": samplers, "channels": targets}]);
}

/// A quad that turns, is stretched unevenly and mirrored on its way, seen by a camera.
fn stretched(has_normals: bool) -> Scene {
    let glb = quad_glb(|document, bin| {
        if has_normals {
            let slanted = [0.3, 0.9, 0.1, -0.3, 0.9, 0.2, 0.1, 0.95, -0.2, 0.0, 0.0, 0.0];
            attribute(document, bin, "NORMAL", "VEC3", &slanted);
        } else {
            document["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("NORMAL");
        }
        document["nodes"] = json!([{"mesh": 0}, {"mesh": 0, "translation": [0.0, -1.0, 0.0]}]);
        document["scenes"][0]["nodes"] = json!([0, 1]);
        let translation = [0.0, 0.0, 0.0, 0.4, 1.0, 0.2, 1.0, 0.5, -0.6];
        let rotation = [0.0, 0.0, 0.0, 1.0, 0.6, 0.0, 0.0, 0.8, 0.0, 0.6, 0.0, 0.8];
        let scale = [1.0, 1.0, 1.0, 0.5, 2.0, 1.5, -1.0, 0.2, 1.0];
        let channels: [(&str, &str, &[f32]); 3] =
            [("translation", "VEC3", &translation), ("rotation", "VEC4", &rotation), ("scale", "VEC3", &scale)];
        animate(document, bin, 0, &channels);
    });
    playing(&glb)
}

/// A quad without normals that is morphed towards a shape with some, which say nothing then.
fn morphed() -> Scene {
    let glb = quad_glb(|document, bin| {
        let offsets = [0.0, 0.5, 0.0, 0.0, 0.0, 0.3, 0.4, 0.0, 0.0, 0.0, -0.6, 0.0];
        let [positions, normals] = [&offsets, &[0.7; 12]].map(|values| floats(document, bin, "VEC3", values));
        document["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": positions, "NORMAL": normals}]);
        document["meshes"][0]["weights"] = json!([0.0]);
        animate(document, bin, 0, &[("weights", "SCALAR", &[0.0, 1.0, -0.5])]);
    });
    playing(&glb)
}

/// A quad that appears after a second, beside one that slides.
fn appearing() -> Scene {
    let glb = quad_glb(|document, bin| {
        document["nodes"] = json!([{"mesh": 0}, {"mesh": 0, "translation": [0.0, -1.0, 0.0]}]);
        document["scenes"][0]["nodes"] = json!([0, 1]);
        animate(document, bin, 1, &[("translation", "VEC3", &[0.0, -1.0, 0.0, 1.0, -1.0, 0.0, 2.0, -1.0, 0.5])]);
        let seen = view(document, bin, &[0, 1, 1]);
        let accessors = document["accessors"].as_array_mut().unwrap();
        accessors.push(json!({"bufferView": seen, "componentType": 5121, "count": 3, "type": "SCALAR"}));
        let output = accessors.len() - 1;
        let animation = &mut document["animations"][0];
        let input = animation["samplers"][0]["input"].clone();
        animation["samplers"]
            .as_array_mut()
            .unwrap()
            .push(json!({"input": input, "output": output, "interpolation": "STEP"}));
        animation["channels"].as_array_mut().unwrap().push(json!({"sampler": 1, "target": {"path": "pointer",
            "extensions": {"KHR_animation_pointer": {"pointer": "/nodes/0/extensions/KHR_node_visibility/visible"}}}}));
        document["nodes"][0]["extensions"] = json!({"KHR_node_visibility": {"visible": false}});
        document["extensionsUsed"] = json!(["KHR_animation_pointer", "KHR_node_visibility"]);
    });
    playing(&glb)
}

#[test]
fn meshes_that_nodes_carry_or_morph_are_where_the_host_has_them() {
    let test = gpu();
    for scene in [carried(1), stretched(true), stretched(false), morphed(), appearing()] {
        assert!(compare(&test.gpu, scene, &MOMENTS_S) > 0, "no tree is refitted");
    }
}

/// Beyond the first moment their tree is worth nothing; at the last it is the one that was built again.
#[test]
fn a_bad_tree_is_built_anew_and_comes_back() {
    let test = gpu();
    assert_eq!(compare(&test.gpu, screens_that_change_places(), &[0.05, 1.9, 0.06]), 2);
}

/// The built-in scene: morphed awnings, a skinned figure, a crate, among much that rests.
#[test]
fn the_courtyard_in_motion_is_where_the_host_has_it() {
    let test = gpu();
    let glb = include_bytes!("../assets/courtyard.glb");
    let mut scene = gltf::load_scene_of("courtyard", glb, "courtyard in motion", &|_, _, _| ()).unwrap();
    scene.play(None).unwrap();
    assert_eq!(compare(&test.gpu, scene, &[0.5, 1.0, 4.0]), 3);
}

#[test]
fn skins_and_morphs_of_others_are_where_the_host_has_them() {
    let test = gpu();
    let Some(shared) = shared_dir() else {
        eprintln!("skipped: no shared assets");
        return;
    };
    for file in ["Fox.glb", "SimpleSkin.gltf", "MorphStressTest.gltf"] {
        let mut scene = gltf::load(&shared.join("assets/animated").join(file), &|_, _, _| ()).unwrap();
        scene.play(None).unwrap();
        assert!(compare(&test.gpu, scene, &MOMENTS_S) > 0, "no tree is refitted");
    }
}
