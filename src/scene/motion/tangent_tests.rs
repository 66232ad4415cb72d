//! Tangents of what moves, with answers by hand.

use std::f32::consts::FRAC_1_SQRT_2;

use base64::Engine as _;
use glam::{Vec3, Vec4};
use serde_json::json;

use super::tests::{FIRST, File, SECOND, at, bar, normal};
use crate::scene::Scene;
use crate::scene::octahedral::unpack_tangent;

/// Just before a clip of a second repeats: its last key.
const END_S: f64 = 1.0 - 1e-9;

/// Gives the mesh a normal map that lies at these texture coordinates.
fn mapped(mut file: File, uvs: &[f32]) -> File {
    let mut png = std::io::Cursor::new(Vec::new());
    let flat = image::RgbImage::from_pixel(1, 1, image::Rgb([128, 128, 255]));
    flat.write_to(&mut png, image::ImageFormat::Png).unwrap();
    let png = base64::engine::general_purpose::STANDARD.encode(png.into_inner());
    let uv = file.floats("VEC2", uvs);
    let primitive = &mut file.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["TEXCOORD_0"] = json!(uv);
    primitive["material"] = json!(0);
    file.json["materials"] = json!([{"normalTexture": {"index": 0}}]);
    file.json["textures"] = json!([{"source": 0}]);
    file.json["images"] = json!([{"uri": format!("data:image/png;base64,{png}")}]);
    file
}

/// The triangle in the plane z = 0 with u along x.
fn triangle() -> File {
    mapped(File::new(), &[0.0, 1.0, 1.0, 1.0, 0.0, 0.0])
}

fn with_normals(mut file: File) -> File {
    let normals = file.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    file.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    file
}

fn tangent(scene: &Scene, vertex: usize) -> Vec4 {
    unpack_tangent(scene.tangents[vertex])
}

fn is_near(found: Vec4, expected: Vec4) {
    assert!(found.distance(expected) <= 1e-4, "{found}, not {expected}");
}

#[test]
fn tangents_turn_with_their_node() {
    let quarter = [0.0, FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2];
    for mut file in [triangle(), with_normals(triangle())] {
        file.animate((0, "rotation", "STEP"), &[0.0, 1.0], &[[0.0, 0.0, 0.0, 1.0], quarter].concat());
        for vertex in 0..3 {
            is_near(tangent(&at(file.load(), None, 0.0), vertex), Vec4::new(1.0, 0.0, 0.0, 1.0));
            is_near(tangent(&at(file.load(), None, END_S), vertex), Vec4::new(0.0, 0.0, -1.0, 1.0));
        }
    }
}

#[test]
fn a_scale_that_passes_zero_changes_the_side() {
    for mut file in [triangle(), with_normals(triangle())] {
        file.animate((0, "scale", "STEP"), &[0.0, 1.0], &[1.0, 1.0, 1.0, -1.0, 1.0, 1.0]);
        let scene = at(file.load(), None, END_S);
        is_near(tangent(&scene, 0), Vec4::new(-1.0, 0.0, 0.0, -1.0));
        let bitangent = normal(&scene, 0).cross(tangent(&scene, 0).truncate()) * tangent(&scene, 0).w;
        assert!(bitangent.distance(Vec3::Y) <= 1e-4, "{bitangent}");
    }
}

#[test]
fn tangents_are_bent_by_skins() {
    let file = bar(&[0, 1, 0, 0].repeat(4), &[FIRST, FIRST, SECOND, SECOND].concat());
    let file = mapped(file, &[0.0, 1.0, 1.0, 1.0, 2.0, 1.0, 1.0, 0.0]);
    let scene = at(file.load(), None, END_S);
    is_near(tangent(&scene, 0), Vec4::new(1.0, 0.0, 0.0, 1.0));
    is_near(tangent(&scene, 2), Vec4::new(0.0, 0.0, -1.0, 1.0));
}

/// The vertices between two triangles of which one has the texture mirrored become two each, which follow the same joints.
#[test]
fn split_vertices_stay_together() {
    let file = bar(&[0, 1, 0, 0].repeat(4), &[FIRST, FIRST, SECOND, SECOND].concat());
    let file = mapped(file, &[0.0, 1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 0.0]);
    let scene = at(file.load(), None, END_S);
    assert_eq!((scene.vertices.len(), scene.tangents.len()), (6, 6));
    let place = |corner: usize| Vec3::from(scene.vertices[scene.indices[corner] as usize].position_ws);
    let side = |corner: usize| tangent(&scene, scene.indices[corner] as usize).w;
    // Triangles 0 1 3 and 1 2 3.
    assert_eq!((place(1), place(2)), (place(3), place(5)));
    assert!(place(4).distance(Vec3::new(1.0, 0.0, -1.0)) <= 1e-5, "{}", place(4));
    assert_eq!([0, 1, 2, 3, 4, 5].map(side), [1.0, 1.0, 1.0, -1.0, -1.0, -1.0]);
}

/// A target adds to tangents of the file what it says, and half of it at half of its weight.
#[test]
fn tangents_of_the_file_are_morphed() {
    let mut file = with_normals(triangle());
    let tangents = file.floats("VEC4", &[1.0, 0.0, 0.0, -1.0].repeat(3));
    let offsets = file.floats("VEC3", &[-1.0, 1.0, 0.0].repeat(3));
    let primitive = &mut file.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["TANGENT"] = json!(tangents);
    primitive["targets"] = json!([{"TANGENT": offsets}]);
    for (weight, expected) in [(0.0, Vec3::X), (0.5, Vec3::new(1.0, 1.0, 0.0).normalize()), (1.0, Vec3::Y)] {
        file.json["meshes"][0]["weights"] = json!([weight]);
        is_near(tangent(&file.load(), 1), expected.extend(-1.0));
    }
}

/// A strip of so many corners along x with u along it, and a target that moves its corners.
fn strip(corners: u16, target: impl Fn(u16, [f32; 3]) -> [f32; 3]) -> File {
    let place = |i: u16| [0.01 * f32::from(i), 1.0 - f32::from(i % 2), 0.0];
    let moved = |i: u16| (Vec3::from(target(i, place(i))) - Vec3::from(place(i))).to_array();
    let mut file = File::new();
    let positions = file.floats("VEC3", &(0..corners).flat_map(place).collect::<Vec<_>>());
    let offsets = file.floats("VEC3", &(0..corners).flat_map(moved).collect::<Vec<_>>());
    let normals = file.floats("VEC3", &[0.0, 0.0, 1.0].repeat(usize::from(corners)));
    file.json["meshes"][0]["primitives"][0] = json!({
        "attributes": {"POSITION": positions, "NORMAL": normals}, "mode": 5, "targets": [{"POSITION": offsets}]
    });
    let uvs: Vec<f32> = (0..corners).flat_map(|i| [0.01 * f32::from(i), f32::from(i % 2)]).collect();
    mapped(file, &uvs)
}

/// A target that gathers very many corners in one place is too much for MikkTSpace, and leaves the mesh without a normal map.
#[test]
fn a_target_may_gather_corners() {
    let gather = |i: u16, place: [f32; 3]| if i.is_multiple_of(2) { [0.0; 3] } else { place };
    is_near(tangent(&strip(400, gather).load(), 0), Vec4::new(1.0, 0.0, 0.0, 1.0));
    assert!(strip(4000, gather).load().tangents.is_empty());
}

/// The target turns the strip by a quarter in its plane. Among very many, no target has tangents of its own.
#[test]
fn very_many_targets_leave_tangents_as_they_are() {
    let mut file = strip(4000, |_, [x, y, z]| [-y, x, z]);
    file.json["meshes"][0]["weights"] = json!([1.0]);
    is_near(tangent(&file.load(), 0), Vec4::new(0.0, 1.0, 0.0, 1.0));
    let targets = file.json["meshes"][0]["primitives"][0]["targets"].as_array_mut().unwrap();
    targets.resize(300, json!({}));
    file.json["meshes"][0]["weights"] = json!([vec![1.0], vec![0.0; 299]].concat());
    is_near(tangent(&file.load(), 0), Vec4::new(1.0, 0.0, 0.0, 1.0));
}

/// Where tangents are computed, those of a target are too, whatever the file says that it adds.
#[test]
fn tangents_of_targets_are_computed() {
    // The target turns the triangle by a quarter about y.
    let (positions, normals) = ([0.0, 0.0, 0.0, -1.0, 0.0, -1.0, 0.0, 0.0, 0.0], [1.0, 0.0, -1.0].repeat(3));
    let turned = Vec4::new(0.0, 0.0, -1.0, 1.0);
    for mut file in [triangle(), with_normals(triangle())] {
        let (positions, normals) = (file.floats("VEC3", &positions), file.floats("VEC3", &normals));
        let ignored = file.floats("VEC3", &[0.0, 5.0, 0.0].repeat(3));
        file.json["meshes"][0]["primitives"][0]["targets"] =
            json!([{"POSITION": positions, "NORMAL": normals, "TANGENT": ignored}]);
        for (weight, expected) in [(0.0, Vec4::new(1.0, 0.0, 0.0, 1.0)), (1.0, turned)] {
            file.json["meshes"][0]["weights"] = json!([weight]);
            is_near(tangent(&file.load(), 1), expected);
        }
    }
}
