//! Normal maps in the G-buffer: a floor with a map of one texel, whose normal is known at every pixel.

mod support;

use std::f64::consts::FRAC_1_SQRT_2;
use std::path::Path;

use glam::Vec3;
use gridlight::files::pictures::read_exr;
use serde_json::{Value, json};
use support::{attribute, floats, program, quad_glb, run, view};

/// Width and height of the pictures: odd, so that a pixel shows the middle of the scene.
const SIZE: [usize; 2] = [65, 37];
/// The map's texel, and the normal that it stands for.
const TEXEL: [u8; 3] = [204, 153, 230];

/// Twice the step of the view's octahedral normals and of the vertices' tangents, which have 15 bits.
const TOLERANCE: f32 = 2e-4;

fn mapped() -> Vec3 {
    (Vec3::from(TEXEL.map(f32::from)) / 127.5 - 1.0).normalize()
}

const NORMALS: [f32; 12] = [0., 1., 0., 0., 1., 0., 0., 1., 0., 0., 1., 0.];
/// u along x, v along z.
const UPRIGHT: [f32; 8] = [0., 1., 1., 1., 1., 0., 0., 0.];
const MIRRORED: [f32; 8] = [1., 1., 0., 1., 0., 0., 1., 0.];

/// The floor with the map and what `change` adds.
fn floor(uvs: &[f32], change: impl FnOnce(&mut Value, &mut Vec<u8>)) -> Vec<u8> {
    quad_glb(|document, bin| {
        attribute(document, bin, "TEXCOORD_0", "VEC2", uvs);
        attribute(document, bin, "NORMAL", "VEC3", &NORMALS);
        let mut png = std::io::Cursor::new(Vec::new());
        let map = image::RgbImage::from_pixel(1, 1, image::Rgb(TEXEL));
        map.write_to(&mut png, image::ImageFormat::Png).unwrap();
        let view = view(document, bin, &png.into_inner());
        document["images"] = json!([{"bufferView": view, "mimeType": "image/png"}]);
        document["textures"] = json!([{"source": 0}]);
        document["materials"][0]["normalTexture"] = json!({"index": 0});
        change(document, bin);
    })
}

/// The shading normal in the middle of the picture.
fn seen(glb: &[u8], options: &str) -> Vec3 {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("floor.glb"), glb).unwrap();
    seen_in(&at("floor.glb"), &at("normal.exr"), options)
}

fn seen_in(scene: &Path, picture: &Path, options: &str) -> Vec3 {
    let [width, height] = SIZE;
    let mut command = program();
    command.arg(scene).args([
        "--headless",
        "--view",
        "normal",
        "--validation",
        "--environment",
        "none",
        "--size",
        &format!("{width}x{height}"),
    ]);
    command.args(options.split_whitespace()).arg("--output").arg(picture);
    let run = run(command);
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""), "{options}");
    let (found_width, _, pixels) = read_exr(picture).unwrap();
    let channels = pixels.len() / (width * height);
    assert_eq!((found_width as usize, channels >= 3), (width, true));
    let first = channels * (height / 2 * width + width / 2);
    Vec3::new(pixels[first], pixels[first + 1], pixels[first + 2])
}

fn is_near(found: Vec3, expected: Vec3, what: &str) {
    assert!(found.distance(expected) <= TOLERANCE, "{what}: {found}, not {expected}");
}

#[test]
fn the_map_lies_as_its_texture_coordinates_say() {
    let Vec3 { x, y, z } = mapped();
    // x of the map is along u, y against v, and z along the normal.
    is_near(seen(&floor(&UPRIGHT, |_, _| ()), ""), Vec3::new(x, z, -y), "upright");
    is_near(seen(&floor(&MIRRORED, |_, _| ()), ""), Vec3::new(-x, z, -y), "mirrored");
    let mirrors = floor(&UPRIGHT, |document, _| document["nodes"][0]["scale"] = json!([-1, 1, 1]));
    is_near(seen(&mirrors, ""), Vec3::new(-x, z, -y), "mirrored by its node");
    let flat = floor(&UPRIGHT, |document, _| {
        document["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("NORMAL");
    });
    is_near(seen(&flat, ""), Vec3::new(x, z, -y), "without normals");
    let nowhere = floor(&[0.5; 8], |_, _| ());
    is_near(seen(&nowhere, ""), Vec3::Y, "in one texel");
}

#[test]
#[should_panic(expected = "planted: ")]
fn planted_mirrored_texture_coordinates() {
    let Vec3 { x, y, z } = mapped();
    is_near(seen(&floor(&MIRRORED, |_, _| ()), ""), Vec3::new(x, z, -y), "planted");
}

#[test]
fn tangents_of_the_file_win() {
    let Vec3 { x, y, z } = mapped();
    let with = |tangent: [f32; 4]| {
        floor(&UPRIGHT, |document, bin| attribute(document, bin, "TANGENT", "VEC4", &tangent.repeat(4)))
    };
    // The bitangent is the side times (0, 1, 0) x (0, 0, 1) = (1, 0, 0).
    is_near(seen(&with([0.0, 0.0, 1.0, 1.0]), ""), Vec3::new(y, z, x), "one side");
    is_near(seen(&with([0.0, 0.0, 1.0, -1.0]), ""), Vec3::new(-y, z, x), "the other side");
}

/// MikkTSpace takes the interpolated tangent as it is, shorter than 1 between tangents that differ.
#[test]
fn only_the_result_has_unit_length() {
    let (a, b) = ([1.0, 0.0, 0.0, 1.0], [0.0, 0.0, -1.0, 1.0]);
    let glb = floor(&UPRIGHT, |document, bin| {
        attribute(document, bin, "TANGENT", "VEC4", &[a, b, b, a].concat());
    });
    let Vec3 { x, y, z } = mapped();
    // The middle is half way between the first corner and the third.
    let tangent = Vec3::new(0.5, 0.0, -0.5);
    let frame = |tangent: Vec3| (x * tangent + y * Vec3::Y.cross(tangent) + z * Vec3::Y).normalize();
    is_near(seen(&glb, ""), frame(tangent), "interpolated");
    assert!(frame(tangent.normalize()).distance(frame(tangent)) > 100.0 * TOLERANCE, "the other way is told apart");
}

/// From behind, the normal is that of the front reversed.
#[test]
fn backs_have_the_reversed_normal() {
    let glb = floor(&UPRIGHT, |document, _| {
        document["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}]);
        let upwards = json!({"camera": 0, "translation": [0, -3, 0], "rotation": [FRAC_1_SQRT_2, 0, 0, FRAC_1_SQRT_2]});
        document["nodes"] = json!([document["nodes"][0], upwards]);
        document["scenes"][0]["nodes"] = json!([0, 1]);
    });
    let Vec3 { x, y, z } = mapped();
    is_near(seen(&glb, ""), -Vec3::new(x, z, -y), "from below");
}

/// A floor that has turned looks like one that stands turned, in frames that find the motion of surfaces too.
#[test]
fn a_floor_that_turns_keeps_its_map() {
    let half = [0.0, 0.0, 0.3_f32.sin(), 0.3_f32.cos()];
    let still = floor(&UPRIGHT, |document, _| document["nodes"][0]["rotation"] = json!(half));
    let turning = floor(&UPRIGHT, |document, bin| {
        let input = floats(document, bin, "SCALAR", &[0.0, 1.0]);
        let output = floats(document, bin, "VEC4", &[[0.0, 0.0, 0.0, 1.0], half].concat());
        document["animations"] = json!([{
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "rotation"}}],
            "samplers": [{"input": input, "output": output}]
        }]);
    });
    // Both cameras look at the middle of the floor.
    let (expected, at_rest) = (seen(&still, ""), seen(&turning, ""));
    assert!(expected.distance(at_rest) > 100.0 * TOLERANCE, "it turns");
    for options in ["--time 0.99999", "--time 0.9999 --temporal shadows --frames 2 --fps 100000"] {
        is_near(seen(&turning, options), expected, options);
    }
}
