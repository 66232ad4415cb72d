//! Scenes that move, read from glTF, with known answers.

use std::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_2};

use glam::Vec3;
use serde_json::{Value, json};

use super::Moves;
use crate::scene::octahedral::unpack_octahedral;
use crate::scene::testing::{glb_from, shared_dir};
use crate::scene::{Light, Scene, gltf, upload};
use crate::{Error, Result};

/// A glTF in the making: JSON and the bytes that it refers to.
pub(super) struct File {
    pub json: Value,
    bytes: Vec<u8>,
}

impl File {
    /// A triangle in the plane z = 0, carried by node 0.
    pub fn new() -> Self {
        let mut file = Self {
            json: json!({
                "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                "accessors": [], "bufferViews": [], "buffers": [{"byteLength": 0}]
            }),
            bytes: Vec::new(),
        };
        let positions = file.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        file.json["meshes"] = json!([{"primitives": [{"attributes": {"POSITION": positions}}]}]);
        file
    }

    fn accessor(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) -> usize {
        let views = self.json["bufferViews"].as_array_mut().unwrap();
        views.push(json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()}));
        let view = views.len() - 1;
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let accessors = self.json["accessors"].as_array_mut().unwrap();
        accessors.push(json!({"bufferView": view, "componentType": component, "count": count, "type": kind}));
        accessors.len() - 1
    }

    pub fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let width = [("SCALAR", 1), ("VEC2", 2), ("VEC3", 3), ("VEC4", 4), ("MAT4", 16)]
            .iter()
            .find(|k| k.0 == kind)
            .unwrap()
            .1;
        self.accessor(kind, 5126, values.len() / width, bytemuck::cast_slice(values))
    }

    /// Adds an animation of one channel.
    pub fn animate(&mut self, (node, path, between): (usize, &str, &str), times: &[f32], values: &[f32]) {
        let kind = match path {
            "rotation" => "VEC4",
            "weights" => "SCALAR",
            _ => "VEC3",
        };
        let (input, output) = (self.floats("SCALAR", times), self.floats(kind, values));
        if self.json["animations"].is_null() {
            self.json["animations"] = json!([]);
        }
        let animations = self.json["animations"].as_array_mut().unwrap();
        animations.push(json!({
            "channels": [{"sampler": 0, "target": {"node": node, "path": path}}],
            "samplers": [{"input": input, "output": output, "interpolation": between}]
        }));
    }

    fn try_load(&self) -> Result<Scene> {
        let mut json = self.json.clone();
        json["buffers"][0]["byteLength"] = self.bytes.len().into();
        gltf::load_bytes("test", &glb_from(&json.to_string(), &self.bytes), &|_, _, _| {})
    }

    pub fn load(&self) -> Scene {
        self.try_load().unwrap_or_else(|error| panic!("{error}"))
    }

    /// What is said of a file that is refused.
    fn refused(&self) -> String {
        match self.try_load() {
            Err(error @ Error::File { .. }) => error.to_string(),
            Err(other) => panic!("{other}"),
            Ok(_) => panic!("it was read"),
        }
    }
}

pub(super) fn at(mut scene: Scene, animation: Option<&str>, time_s: f64) -> Scene {
    scene.play(animation).unwrap();
    scene.pose(time_s);
    scene
}

fn positions(scene: &Scene) -> Vec<Vec3> {
    scene.vertices.iter().map(|vertex| vertex.position_ws.into()).collect()
}

pub(super) fn normal(scene: &Scene, vertex: usize) -> Vec3 {
    unpack_octahedral(scene.vertices[vertex].normal_oct)
}

fn near(found: &[Vec3], expected: &[Vec3]) -> bool {
    found.len() == expected.len() && found.iter().zip(expected).all(|(f, e)| f.distance(*e) <= 1e-5)
}

/// Along x by a metre a second for two seconds.
fn sliding() -> File {
    let mut file = File::new();
    file.animate((0, "translation", "LINEAR"), &[0.0, 2.0], &[0.0, 0.0, 0.0, 2.0, 0.0, 0.0]);
    file
}

#[test]
fn a_mesh_goes_where_its_node_goes_and_repeats() {
    let rest = [Vec3::ZERO, Vec3::X, Vec3::Y];
    assert_eq!(positions(&sliding().load()), rest);
    for (time_s, x) in [(0.0, 0.0), (0.5, 0.5), (1.75, 1.75), (2.5, 0.5), (-0.5, 1.5)] {
        let scene = at(sliding().load(), None, time_s);
        assert!(near(&positions(&scene), &rest.map(|p| p + Vec3::X * x)), "{time_s}: {:?}", positions(&scene));
    }
    let scene = at(sliding().load(), Some("none"), 1.0);
    assert_eq!((positions(&scene), scene.motion.moves().any()), (rest.to_vec(), false));
}

/// At rest everything is in its place; keys and parents take it beyond all numbers.
#[test]
fn what_flies_away_stays_within_numbers() {
    for far in [3e9, 3e38] {
        let mut file = File::new();
        file.json["nodes"] = json!([{"mesh": 0}, {"children": [0], "scale": [10, 10, 10]}]);
        file.json["scenes"] = json!([{"nodes": [1]}]);
        file.animate((0, "translation", "STEP"), &[0.0, 1.0], &[0.0, 0.0, 0.0, far, -far, far]);
        let scene = at(file.load(), None, 1.0);
        let reach = positions(&scene).into_iter().chain([scene.bounds.min, scene.bounds.max]);
        assert!(reach.into_iter().all(|p| p.abs().max_element() <= 1e9), "{far}: {:?}", positions(&scene));
        let _ = crate::scene::bvh::build(&scene);
    }
}

#[test]
fn bounds_are_those_of_all_moments() {
    let scene = at(sliding().load(), None, 0.0);
    assert!(near(&[scene.bounds.min, scene.bounds.max], &[Vec3::ZERO, Vec3::new(3.0, 1.0, 0.0)]), "{:?}", scene.bounds);
    let still = at(sliding().load(), Some("none"), 0.0);
    assert_eq!(still.bounds.max, Vec3::new(1.0, 1.0, 0.0));
}

#[test]
fn animations_are_chosen_by_name_and_index() {
    let mut file = sliding();
    file.animate((0, "scale", "STEP"), &[0.0], &[2.0, 2.0, 2.0]);
    file.json["animations"][1]["name"] = json!("grow");
    let corner = |animation: Option<&str>| positions(&at(file.load(), animation, 1.0))[1];
    assert_eq!(corner(None), Vec3::X * 2.0);
    assert_eq!(corner(Some("0")), Vec3::X * 2.0);
    assert_eq!(corner(Some("grow")), Vec3::X * 2.0);
    assert_eq!(corner(Some("1")), Vec3::X * 2.0);
    assert_eq!(corner(Some("all")), Vec3::X * 3.0);
    let error = file.load().play(Some("jump")).unwrap_err();
    assert_eq!(error.to_string(), "--animation jump is not in the scene; its animations are animation 0, grow");
    let error = File::new().load().play(Some("jump")).unwrap_err();
    assert_eq!((error.exit_code(), error.to_string().ends_with("which has none")), (2, true));
    File::new().load().play(None).unwrap();
}

#[test]
fn children_go_with_their_parents() {
    let mut file = File::new();
    // The child comes first in the file.
    file.json["nodes"] = json!([{"mesh": 0, "translation": [1, 0, 0]}, {"children": [0]}]);
    file.json["scenes"][0]["nodes"] = json!([1]);
    let quarter = [0.0, FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2];
    file.animate((1, "rotation", "LINEAR"), &[0.0, 1.0], &[[0.0, 0.0, 0.0, 1.0], quarter].concat());
    let scene = at(file.load(), None, 0.999_999);
    assert!(scene.vertices[0].position_ws[2] < -0.999, "{:?}", scene.vertices[0]);
    assert!(normal(&scene, 0).distance(Vec3::X) < 1e-3, "{}", normal(&scene, 0));
}

#[test]
fn cameras_and_lights_are_carried() {
    let mut file = File::new();
    file.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}]);
    file.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "point", "intensity": 5.0}, {"type": "directional", "intensity": 3.0}
    ]}});
    let light = |index: usize| json!({"KHR_lights_punctual": {"light": index}});
    file.json["nodes"] = json!([
        {"mesh": 0}, {"camera": 0, "name": "eye", "children": [2]}, {"extensions": light(0), "translation": [0, 1, 0]},
        {"extensions": light(1)}
    ]);
    file.json["scenes"][0]["nodes"] = json!([0, 1, 3]);
    file.animate((1, "translation", "LINEAR"), &[0.0, 4.0], &[0.0, 0.0, 5.0, 4.0, 0.0, 5.0]);
    let scene = at(file.load(), None, 3.0);
    assert_eq!(scene.motion.moves(), Moves { geometry: false, lights: true, cameras: true });
    let camera = &scene.cameras[0];
    assert_eq!((camera.name.as_str(), camera.position_ws), ("eye", Vec3::new(3.0, 0.0, 5.0)));
    assert_eq!((camera.forward_ws, camera.yfov_rad), (Vec3::NEG_Z, 1.0));
    assert_eq!(scene.lights[0], Light::Point { position_ws: Vec3::new(3.0, 1.0, 5.0), intensity: Vec3::splat(5.0) });
    assert_eq!(scene.lights[1], file.load().lights[1]);
}

/// A bar of four corners along x, the outer two on the second of two joints, which sits at x = 1.
pub(super) fn bar(joints: &[u8], weights: &[f32]) -> File {
    let mut file = File::new();
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, 1.0, 0.0]];
    let positions = file.floats("VEC3", &corners.concat());
    let normals = file.floats("VEC3", &[[0.0, 0.0, 1.0]; 4].concat());
    let joints = file.accessor("VEC4", 5121, joints.len() / 4, joints);
    let weights = file.floats("VEC4", weights);
    let mut second = glam::Mat4::IDENTITY;
    second.w_axis.x = -1.0;
    let binds = [glam::Mat4::IDENTITY, second].map(|m| m.to_cols_array()).concat();
    let binds = file.floats("MAT4", &binds);
    let indices = file.accessor("SCALAR", 5121, 6, &[0, 1, 3, 1, 2, 3]);
    file.json["meshes"][0]["primitives"][0] = json!({
        "attributes": {"POSITION": positions, "NORMAL": normals, "JOINTS_0": joints, "WEIGHTS_0": weights},
        "indices": indices
    });
    file.json["nodes"] = json!([
        // Where the mesh's node stands does not matter.
        {"mesh": 0, "skin": 0, "translation": [7, 7, 7]}, {"children": [2]}, {"translation": [1, 0, 0]}
    ]);
    file.json["scenes"][0]["nodes"] = json!([0, 1]);
    file.json["skins"] = json!([{"joints": [1, 2], "inverseBindMatrices": binds}]);
    let half = f32::sin(0.5 * FRAC_PI_2);
    let bend = [[0.0, 0.0, 0.0, 1.0], [0.0, half, 0.0, half]].concat();
    file.animate((2, "rotation", "LINEAR"), &[0.0, 1.0], &bend);
    file.json["animations"][0]["samplers"][0]["interpolation"] = json!("STEP");
    file
}

pub(super) const FIRST: [f32; 4] = [1.0, 0.0, 0.0, 0.0];
const BOTH: [f32; 4] = [0.5, 0.5, 0.0, 0.0];
/// Not yet normalised.
pub(super) const SECOND: [f32; 4] = [0.0, 3.0, 0.0, 0.0];

#[test]
fn a_bar_of_two_bones_is_bent_by_a_right_angle() {
    let file = bar(&[0, 1, 0, 0].repeat(4), &[FIRST, BOTH, SECOND, SECOND].concat());
    let rest = [Vec3::ZERO, Vec3::X, Vec3::X * 2.0, Vec3::new(1.0, 1.0, 0.0)];
    assert!(near(&positions(&file.load()), &rest), "{:?}", positions(&file.load()));
    let mut scene = file.load();
    scene.play(None).unwrap();
    // The last key holds at the very end of the clip, just before it repeats.
    let bent = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 0.0, -1.0), Vec3::new(1.0, 1.0, 0.0)];
    scene.pose(1.0 - 1e-9);
    assert!(near(&positions(&scene), &bent), "{:?}", positions(&scene));
    assert!(normal(&scene, 2).distance(Vec3::X) < 1e-3 && normal(&scene, 0).distance(Vec3::Z) < 1e-3);
    assert!(normal(&scene, 1).distance(Vec3::new(1.0, 0.0, 1.0).normalize()) < 1e-3, "{}", normal(&scene, 1));
    let (bounds, found) = (&scene.bounds, positions(&scene));
    let inside = |p: &Vec3| p.cmpge(bounds.min - 1e-5).all() && p.cmple(bounds.max + 1e-5).all();
    assert!(found.iter().all(inside) && bounds.max.x >= 2.0 && bounds.min.z <= -1.0, "{bounds:?}");
}

#[test]
fn eight_joints_count() {
    let mut file = bar(&[0, 0, 0, 0].repeat(4), &[[0.25, 0.25, 0.0, 0.0]; 4].concat());
    let joints = file.accessor("VEC4", 5121, 4, &[1, 1, 1, 1].repeat(4));
    let weights = file.floats("VEC4", &[[0.5, 0.0, 0.0, 0.0]; 4].concat());
    let attributes = &mut file.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_1"] = json!(joints);
    attributes["WEIGHTS_1"] = json!(weights);
    let scene = at(file.load(), None, 1.0 - 1e-9);
    // Half of x = 2 rests, and half of it is at (1, 0, -1).
    assert!(near(&positions(&scene)[2..3], &[Vec3::new(1.5, 0.0, -0.5)]), "{:?}", positions(&scene));
}

#[test]
fn joints_that_are_not_there_are_named() {
    let file = bar(&[0, 7, 0, 0].repeat(4), &[BOTH; 4].concat());
    assert!(file.refused().ends_with("has the joint 7, and its skin 0 has only 2 joints"), "{}", file.refused());
    let file = bar(&[0, 7, 0, 0].repeat(4), &[FIRST; 4].concat());
    assert_eq!(file.load().vertices.len(), 4, "nothing follows it");
    let mut file = bar(&[0, 1, 0, 0].repeat(4), &[BOTH; 4].concat());
    file.json["skins"][0]["joints"] = json!([1, 9]);
    assert!(file.refused().contains("skin 0 has the joint 9"), "{}", file.refused());
    file.json["skins"] = json!([]);
    assert!(file.refused().contains("the skin 0, which does not exist"), "{}", file.refused());
}

/// A triangle with a target that lifts its last corner by two metres, and weights at rest.
fn morphing(weights: &Value) -> File {
    let mut file = File::new();
    let offsets = file.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0]);
    file.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": offsets}]);
    file.json["meshes"][0]["weights"] = weights.clone();
    file
}

#[test]
fn half_a_morph() {
    let lifted = |scene: &Scene| positions(scene)[2];
    assert_eq!(lifted(&morphing(&json!([0.0])).load()), Vec3::Y);
    // Weights of the file hold in a still picture; a node's own win.
    assert_eq!(lifted(&morphing(&json!([0.5])).load()), Vec3::new(0.0, 1.0, 1.0));
    let mut file = morphing(&json!([0.5]));
    file.json["nodes"][0]["weights"] = json!([1.0]);
    let scene = file.load();
    assert_eq!((lifted(&scene), scene.bounds.max.z), (Vec3::new(0.0, 1.0, 2.0), 2.0));
    let mut file = morphing(&json!([0.0]));
    file.animate((0, "weights", "LINEAR"), &[0.0, 1.0], &[0.0, 1.0]);
    let scene = at(file.load(), None, 0.5);
    assert!(lifted(&scene).distance(Vec3::new(0.0, 1.0, 1.0)) < 1e-5, "{}", lifted(&scene));
    // Without normals every triangle is flat where it is.
    let expected = Vec3::X.cross(Vec3::new(0.0, 1.0, 1.0)).normalize();
    assert!(normal(&scene, 0).distance(expected) < 1e-3, "{}", normal(&scene, 0));
}

#[test]
fn a_node_that_shrinks_to_nothing_comes_back() {
    let mut file = File::new();
    file.json["nodes"][0]["scale"] = json!([0, 0, 0]);
    file.animate((0, "scale", "LINEAR"), &[0.0, 1.0], &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
    let scene = at(file.load(), None, 0.5);
    assert!(near(&positions(&scene), &[Vec3::ZERO, Vec3::X * 0.5, Vec3::Y * 0.5]), "{:?}", positions(&scene));
}

#[test]
fn animations_that_cannot_be_played_rest() {
    let bad: [(&[f32], &[f32]); 4] = [
        (&[1.0, 0.0], &[0.0, 0.0, 0.0, 2.0, 0.0, 0.0]),
        (&[0.0, f32::NAN], &[0.0, 0.0, 0.0, 2.0, 0.0, 0.0]),
        (&[0.0, 1.0], &[0.0, 0.0, 0.0]),
        (&[0.0, 1.0], &[0.0, 0.0, 0.0, f32::INFINITY, 0.0, 0.0]),
    ];
    for (times, values) in bad {
        let mut file = File::new();
        file.animate((0, "translation", "LINEAR"), times, values);
        let scene = at(file.load(), None, 0.5);
        assert!(!scene.motion.moves().any(), "{times:?}");
        assert_eq!(positions(&scene), [Vec3::ZERO, Vec3::X, Vec3::Y]);
    }
    // A single moment is a pose.
    let mut file = File::new();
    file.animate((0, "translation", "LINEAR"), &[0.0], &[3.0, 0.0, 0.0]);
    assert_eq!(positions(&at(file.load(), None, 0.7))[0], Vec3::X * 3.0);
}

#[test]
fn sample_files_move() {
    let Some(shared) = shared_dir() else {
        println!("skipped: no shared assets");
        return;
    };
    for (file, animation) in [("Fox.glb", Some("Walk")), ("SimpleSkin.gltf", None), ("MorphStressTest.gltf", None)] {
        let load = || gltf::load(&shared.join("assets/animated").join(file), &|_, _, _| {}).unwrap();
        let (first, later) = (at(load(), animation, 0.0), at(load(), animation, 0.4));
        let [a, b] = [&first, &later].map(positions);
        let farthest = a.iter().zip(&b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        assert!(farthest > 0.01 * first.bounds.radius(), "{file}: {farthest}");
        let bounds = &later.bounds;
        let margin = 1e-3 * bounds.radius();
        let inside = |p: &Vec3| p.cmpge(bounds.min - margin).all() && p.cmple(bounds.max + margin).all();
        assert!(a.iter().chain(&b).all(inside), "{file}");
        assert!(bounds.radius() < 4.0 * load().bounds.radius(), "{file}: {bounds:?}");
    }
}

/// A channel with a pointer at once, as the only animation.
fn point(file: &mut File, pointer: &str, kind: &str, (times, values): (&[f32], &[f32])) {
    let (input, output) = (file.floats("SCALAR", times), file.floats(kind, values));
    let target = json!({"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": pointer}}});
    if file.json["animations"].is_null() {
        file.json["animations"] = json!([{"name": "all", "channels": [], "samplers": []}]);
    }
    let animation = &mut file.json["animations"][0];
    let samplers = animation["samplers"].as_array_mut().unwrap();
    samplers.push(json!({"input": input, "output": output, "interpolation": "STEP"}));
    let sampler = samplers.len() - 1;
    animation["channels"].as_array_mut().unwrap().push(json!({"sampler": sampler, "target": target}));
}

/// A spot at node 1 and a lamp at node 2, both of light 0 and 1, beside the triangle at node 0.
fn lit_file() -> File {
    let mut file = File::new();
    file.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "spot", "intensity": 0.0, "color": [1.0, 0.5, 0.25]}, {"type": "point", "intensity": 3.0}
    ]}});
    let carrying = |light: u32| json!({"extensions": {"KHR_lights_punctual": {"light": light}}});
    file.json["nodes"] = json!([{"mesh": 0}, carrying(0), carrying(1)]);
    file.json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    file
}

const LIGHT: &str = "/extensions/KHR_lights_punctual/lights/0";

fn power(light: &Light) -> Vec3 {
    match light {
        Light::Directional { irradiance: power, .. }
        | Light::Point { intensity: power, .. }
        | Light::Spot { intensity: power, .. } => *power,
    }
}

#[test]
fn pointers_turn_lights_on() {
    let mut file = lit_file();
    point(&mut file, &format!("{LIGHT}/intensity"), "SCALAR", (&[0.0, 1.0, 2.0], &[0.0, 8.0, 0.0]));
    point(&mut file, &format!("{LIGHT}/color"), "VEC3", (&[0.0, 1.5], &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0]));
    point(&mut file, &format!("{LIGHT}/spot/outerConeAngle"), "SCALAR", (&[0.0, 1.5], &[0.3, 0.6]));
    // A lamp that is dark at rest is there, since it may shine.
    let rest = at(file.load(), Some("none"), 1.0);
    assert_eq!((rest.lights.len(), rest.motion.moves().any()), (2, false));
    assert!(rest.lights[0].is_dark() && power(&rest.lights[1]) == Vec3::splat(3.0));
    for (time_s, expected, angle) in
        [(0.5, Vec3::ZERO, 0.3_f32), (1.25, Vec3::X * 8.0, 0.3), (1.75, Vec3::Y * 8.0, 0.6)]
    {
        let scene = at(file.load(), None, time_s);
        assert!(scene.motion.moves() == Moves { lights: true, ..Moves::default() });
        let Light::Spot { intensity, outer_cos, .. } = scene.lights[0] else { panic!("{:?}", scene.lights) };
        assert!(intensity.distance(expected) < 1e-6 && (outer_cos - angle.cos()).abs() < 1e-6, "{time_s}");
        assert_eq!(power(&scene.lights[1]), Vec3::splat(3.0));
        // Shares of the light paths are the same at all times, those of the greatest flux: never 0.
        let (lights, flux) = upload::lights(&scene, 0.0);
        let spot = lights.iter().find(|light| light.kind == crate::shared::LIGHT_SPOT).unwrap();
        let greatest = f64::from(crate::color::luminance(Vec3::new(8.0, 8.0, 0.0))) * 2.0 * std::f64::consts::PI;
        let greatest = greatest * (1.0 - f64::from(0.6_f32.cos()));
        let share = greatest / (greatest + 3.0 * 4.0 * std::f64::consts::PI);
        assert!((f64::from(spot.path_probability) - share).abs() < 1e-6, "{time_s}: {} {share}", spot.path_probability);
        assert!((flux * (1.0 - share) / (12.0 * std::f64::consts::PI) - 1.0).abs() < 1e-6);
    }
}

#[test]
fn pointers_show_and_hide_what_is_below() {
    let mut file = lit_file();
    let hidden = json!({"KHR_node_visibility": {"visible": false}});
    file.json["nodes"] = json!([{"mesh": 0}, {"children": [0, 2], "extensions": hidden}, file.json["nodes"][2]]);
    file.json["scenes"][0]["nodes"] = json!([1]);
    // Without the animation nothing of it is there.
    assert!(file.refused().contains("no triangles"));
    let values = file.accessor("SCALAR", 5121, 2, &[0, 1]);
    point(&mut file, "/nodes/1/extensions/KHR_node_visibility/visible", "SCALAR", (&[0.0, 1.0], &[0.0, 0.0]));
    point(&mut file, "/nodes/0/translation", "VEC3", (&[0.0, 2.0], &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0]));
    file.json["animations"][0]["samplers"][0]["output"] = json!(values);
    let area = |scene: &Scene| {
        let [a, b, c] = [0, 1, 2].map(|i| Vec3::from(scene.vertices[scene.indices[i] as usize].position_ws));
        (b - a).cross(c - a).length()
    };
    for (animation, time_s, shown) in [(Some("none"), 1.5, false), (None, 0.5, false), (None, 1.5, true)] {
        let scene = at(file.load(), animation, time_s);
        assert_eq!((area(&scene) > 0.5, !scene.lights[0].is_dark()), (shown, shown), "{animation:?} {time_s}");
    }
    assert!(at(file.load(), None, 0.0).motion.moves() == Moves { geometry: true, lights: true, cameras: false });
    assert_eq!(at(file.load(), None, 0.0).bounds.max, Vec3::new(1.0, 1.0, 0.0));
    // It is dark now, and has paths for when it is not.
    assert!(upload::lights(&at(file.load(), None, 0.5), 0.0).0[0].path_probability > 0.99);
}

#[test]
fn pointers_move_nodes_and_lenses() {
    let mut file = File::new();
    file.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.9, "znear": 0.05}}]);
    file.json["nodes"] = json!([{"mesh": 0}, {"camera": 0}]);
    file.json["scenes"][0]["nodes"] = json!([0, 1]);
    point(
        &mut file,
        "/nodes/0/translation",
        "VEC3",
        (&[0.0, 1.0, 2.0], &[0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0]),
    );
    point(&mut file, "/cameras/0/perspective/yfov", "SCALAR", (&[0.0, 1.0], &[0.5, 1.5]));
    let scene = at(file.load(), None, 1.5);
    assert!(near(&positions(&scene), &[Vec3::Y * 2.0, Vec3::new(1.0, 2.0, 0.0), Vec3::Y * 3.0]));
    assert_eq!(scene.cameras[0].yfov_rad, 1.5);
    assert!(scene.motion.moves() == Moves { geometry: true, lights: false, cameras: true });
    assert_eq!(at(file.load(), Some("none"), 1.5).cameras[0].yfov_rad, 0.9);
}

#[test]
fn pointers_to_what_stands_still_and_to_nothing() {
    let mut file = lit_file();
    for pointer in
        ["/materials/0/pbrMetallicRoughness/baseColorFactor", "/nodes/9/scale", "/cameras/0/perspective/yfov", ""]
    {
        point(&mut file, pointer, "VEC3", (&[0.0], &[1.0, 1.0, 1.0]));
    }
    let scene = at(file.load(), None, 0.0);
    assert!(!scene.motion.moves().any());
}
