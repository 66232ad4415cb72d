//! What a well-formed glTF becomes, on hand-written numbers.

use base64::Engine as _;
use serde_json::{Value, json};

use super::*;
use crate::scene::octahedral::unpack_octahedral;
use crate::scene::testing::glb_from;
use crate::scene::{Camera, Light, LitBy};

/// Builds a binary chunk and its accessors.
#[derive(Default)]
pub(super) struct Parts {
    pub bin: Vec<u8>,
    pub views: Vec<Value>,
    pub accessors: Vec<Value>,
}

impl Parts {
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        self.views.push(json!({"buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len()}));
        self.bin.extend(bytes);
        self.views.len() - 1
    }

    pub fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let view = self.view(bytemuck::cast_slice(values));
        let count = values.len() / if kind == "VEC2" { 2 } else { 3 };
        self.accessor(json!({"bufferView": view, "componentType": 5126, "count": count, "type": kind}))
    }

    pub fn indices(&mut self, values: &[u16]) -> usize {
        let view = self.view(bytemuck::cast_slice(values));
        self.accessor(json!({"bufferView": view, "componentType": 5123, "count": values.len(), "type": "SCALAR"}))
    }

    pub fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    #[expect(clippy::needless_pass_by_value, reason = "`json!` values read better unborrowed")]
    /// The whole file; `extra` overrides top-level keys, or removes them by `null`.
    pub fn glb(&self, meshes: Value, extra: Value) -> Vec<u8> {
        let mut root = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": meshes, "accessors": self.accessors, "bufferViews": self.views,
            "buffers": [{"byteLength": self.bin.len()}],
        });
        if let (Value::Object(root), Value::Object(extra)) = (&mut root, extra) {
            root.extend(extra);
            root.retain(|_, value| !value.is_null());
        }
        glb_from(&root.to_string(), &self.bin)
    }
}

pub(super) const QUAD: [f32; 12] = [0., 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 0.];

/// One mesh of one primitive over `QUAD` with these extra keys and top-level entries.
fn quad(primitive: Value, extra: Value) -> Scene {
    let mut parts = Parts::default();
    let position = parts.floats("VEC3", &QUAD);
    let mut whole = json!({"attributes": {"POSITION": position}});
    if let (Value::Object(whole), Value::Object(primitive)) = (&mut whole, primitive) {
        whole.extend(primitive);
    }
    open(&parts.glb(json!([{"primitives": [whole]}]), extra)).unwrap()
}

pub(super) fn open(glb: &[u8]) -> Result<Scene> {
    load_bytes("test.glb", glb, &|_, _, _| ())
}

/// The scene, and what is said of how it was read.
pub(super) fn open_and_tell(glb: &[u8]) -> Result<(Scene, Vec<String>)> {
    let document = Document::parse(Path::new("test.glb"), None, glb, &|_, _, _| ())?;
    assemble("test.glb", &document, &|_, _, _| ()).map(|scene| (scene, document.remarks()))
}

fn normal(scene: &Scene, corner: usize) -> Vec3 {
    unpack_octahedral(scene.vertices[scene.indices[corner] as usize].normal_oct)
}

fn face(scene: &Scene) -> Vec3 {
    let [a, b, c] = [0, 1, 2].map(|i| Vec3::from_array(scene.vertices[scene.indices[i] as usize].position_ws));
    (b - a).cross(c - a).normalize()
}

fn close(a: Vec3, b: Vec3) -> bool {
    (a - b).length() < 1e-4
}

#[test]
fn a_strip_without_normals_gets_flat_ones() {
    let scene = quad(json!({"mode": 5}), json!({}));
    assert_eq!((scene.indices.len(), scene.vertices.len()), (6, 6));
    assert!((0..6).all(|c| close(normal(&scene, c), Vec3::Z)) && close(face(&scene), Vec3::Z));
    assert_eq!(scene.vertices[0].uv, [0.0; 2]);
    assert_eq!((scene.bounds.min, scene.bounds.max), (Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0)));
    assert_eq!((scene.materials[0].name.as_str(), scene.materials[0].base_color), ("default", [1.0; 4]));
    assert_eq!(scene.draws, [Draw { first_index: 0, index_count: 6, material: 0 }]);
    assert_eq!(scene.name, "test.glb");
}

#[test]
fn a_fan_has_its_triangles() {
    let scene = quad(json!({"mode": 6}), json!({}));
    assert_eq!(scene.indices.len(), 6);
}

#[test]
fn mirroring_flips_the_winding_and_normals_follow() {
    let mut parts = Parts::default();
    let position = parts.floats("VEC3", &QUAD);
    let normals = parts.floats("VEC3", &[0., 0., 1., 0., 0., 5., f32::NAN, 0., 0., 0., 0., 0.]);
    let indices = parts.indices(&[0, 1, 2, 1, 3, 2, 1, 1, 2]);
    let mesh = json!([{"primitives": [{"attributes": {"POSITION": position, "NORMAL": normals}, "indices": indices}]}]);
    let glb = parts.glb(mesh, json!({"nodes": [{"mesh": 0, "scale": [1, 1, -2], "translation": [3, 0, 0]}]}));
    let scene = open(&glb).unwrap();
    assert_eq!((scene.indices.len(), scene.vertices.len()), (6, 4), "the degenerate triangle is gone");
    assert!(close(face(&scene), Vec3::NEG_Z), "{}", face(&scene));
    assert!((0..6).all(|c| close(normal(&scene, c), Vec3::NEG_Z)), "unusable normals become geometric ones");
    assert_eq!(scene.bounds.min.x, 3.0);
}

#[test]
fn sparse_strided_and_quantised_accessors() {
    let mut parts = Parts::default();
    let base = parts.view(bytemuck::cast_slice(&[0i16, 0, 0, 99, 8, 0, 0, 99, 0, 8, 0, 99]));
    parts.views[base]["byteStride"] = json!(8);
    let at = parts.view(&[1, 0, 0, 0]);
    let values = parts.view(bytemuck::cast_slice(&[4i16, 0, 0, 0]));
    let position = parts.accessor(json!({
        "bufferView": base, "componentType": 5122, "count": 3, "type": "VEC3",
        "sparse": {"count": 1, "indices": {"bufferView": at, "componentType": 5121}, "values": {"bufferView": values}}
    }));
    let uv = parts.view(&[0, 255, 0, 0, 51, 0, 0, 0, 0, 0, 0, 0]);
    parts.views[uv]["byteStride"] = json!(4);
    let uv = parts
        .accessor(json!({"bufferView": uv, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC2"}));
    let mesh = json!([{"primitives": [{"attributes": {"POSITION": position, "TEXCOORD_0": uv}}]}]);
    let scene = open(&parts.glb(mesh, json!({"extensionsRequired": ["KHR_mesh_quantization"]}))).unwrap();
    let positions: Vec<_> = scene.vertices.iter().map(|v| v.position_ws).collect();
    assert_eq!(positions, [[0., 0., 0.], [4., 0., 0.], [0., 8., 0.]]);
    assert_eq!((scene.vertices[0].uv, scene.vertices[1].uv[0]), ([0.0, 1.0], 51.0 / 255.0));
}

#[test]
fn triangles_of_a_material_make_one_draw() {
    let mut parts = Parts::default();
    let position = parts.floats("VEC3", &QUAD);
    let primitive = |m: u32| json!({"attributes": {"POSITION": position}, "mode": 5, "material": m});
    let plain = json!({"attributes": {"POSITION": position}, "mode": 5});
    let points = json!({"attributes": {"POSITION": position}, "mode": 0});
    let mesh = json!([{"primitives": [primitive(1), plain, primitive(0), points, primitive(1)]}]);
    let materials = json!([{"name": "a"}, {"alphaMode": "BLEND", "doubleSided": true}]);
    let scene = open(&parts.glb(mesh, json!({"materials": materials}))).unwrap();
    let draws: Vec<_> = scene.draws.iter().map(|d| (d.first_index, d.index_count, d.material)).collect();
    assert_eq!(draws, [(0, 6, 0), (6, 12, 1), (18, 6, 2)]);
    assert_eq!(scene.triangle_materials, [0, 0, 1, 1, 1, 1, 2, 2]);
    let names: Vec<_> = scene.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["a", "material 1", "default"]);
    assert_eq!((scene.materials[1].alpha_cutoff, scene.materials[1].double_sided), (Some(0.5), true));
}

fn png(colour: u8) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::RgbaImage::from_pixel(2, 2, image::Rgba([colour; 4])).write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

#[test]
fn images_are_decoded_once_and_equal_files_shared() {
    let mut parts = Parts::default();
    let position = parts.floats("VEC3", &QUAD);
    let views = [png(9), png(9), png(7)].map(|p| parts.view(&p));
    let data = format!("data:image/png;base64,{}", base64::engine::general_purpose::STANDARD.encode(png(7)));
    let extra = json!({
        "images": [{"bufferView": views[0]}, {"bufferView": views[1]}, {"bufferView": views[2], "name": "seven"},
            {"uri": data}, {"uri": "not-used.png"}],
        "textures": [{"source": 0}, {"source": 1}, {"source": 2}, {"source": 3}, {"source": 4}, {"source": 0}],
        "materials": [
            {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "normalTexture": {"index": 2, "scale": 0.5}},
            {"pbrMetallicRoughness": {"baseColorTexture": {"index": 1}}, "alphaMode": "MASK", "alphaCutoff": 0.25},
            {"pbrMetallicRoughness": {"baseColorTexture": {"index": 3}}},
            {"pbrMetallicRoughness": {"baseColorTexture": {"index": 5}}}],
    });
    let mesh = json!([{"primitives": [{"attributes": {"POSITION": position}}]}]);
    let scene = open(&parts.glb(mesh, extra)).unwrap();
    assert_eq!(scene.textures.len(), 2);
    assert_eq!((scene.textures[1].name.as_str(), &scene.textures[1].rgba[..4]), ("seven", &[7u8; 4][..]));
    let used: Vec<_> = scene.materials.iter().map(|m| m.base_color_texture).collect();
    assert_eq!(used[..4], [Some(0), Some(0), Some(1), Some(0)]);
    assert_eq!((scene.materials[0].normal_texture, scene.materials[0].normal_scale), (Some(1), 0.5));
    assert_eq!(scene.materials[1].alpha_cutoff, Some(0.25));
}

#[test]
fn external_files_and_percent_signs() {
    let folder = tempfile::tempdir().unwrap();
    let bytes: Vec<u8> = bytemuck::cast_slice(&QUAD[..9]).to_vec();
    std::fs::write(folder.path().join("a b.bin"), &bytes).unwrap();
    std::fs::write(folder.path().join("100%.png"), png(3)).unwrap();
    let text = json!({
        "asset": {"version": "2.0"}, "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"uri": "a%20b.bin", "byteLength": 36}],
        "images": [{"uri": "100%.png"}], "textures": [{"source": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
    });
    let path = folder.path().join("thing.gltf");
    std::fs::write(&path, text.to_string()).unwrap();
    let scene = load(&path, &|_, _, _| ()).unwrap();
    assert_eq!((scene.name.as_str(), scene.indices.len(), scene.textures[0].rgba[0]), ("thing", 3, 3));
    assert_eq!(scene.textures[0].name, "100%.png");
    std::fs::write(folder.path().join("a b.bin"), &bytes[..20]).unwrap();
    let error = load(&path, &|_, _, _| ()).err().unwrap().to_string();
    assert!(error.ends_with("buffer 0 (a%20b.bin) is truncated: 36 bytes announced, 20 present"), "{error}");
}

fn camera_scene() -> Scene {
    let turn = [0.0, 0.5f32.sqrt(), 0.0, 0.5f32.sqrt()]; // +90 degrees about y: -z becomes -x
    let lens = json!({"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}});
    let extra = json!({
        "scenes": [{"nodes": [0, 1, 2, 3]}],
        "nodes": [{"mesh": 0}, {"name": "eye", "camera": 0, "rotation": turn, "scale": [2, -2, 2], "translation": [1, 2, 3]},
            {"name": "eye", "camera": 0}, {"camera": 0}],
        "cameras": [lens],
    });
    quad(json!({}), extra)
}

#[test]
fn cameras_have_orthonormal_frames_and_unique_names() {
    let scene = camera_scene();
    let names: Vec<_> = scene.cameras.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["eye", "eye 2", "camera 2"]);
    let Camera { position_ws, right_ws, up_ws, forward_ws, yfov_rad, near, .. } = scene.cameras[0].clone();
    assert_eq!((position_ws, yfov_rad, near), (Vec3::new(1.0, 2.0, 3.0), 0.8, 0.1));
    assert!(close(forward_ws, Vec3::NEG_X) && close(right_ws.cross(up_ws), -forward_ws));
    let Camera { right_ws, up_ws, forward_ws, .. } = scene.cameras[1].clone();
    assert_eq!((right_ws, up_ws, forward_ws), (Vec3::X, Vec3::Y, Vec3::NEG_Z));
}

#[test]
fn scenes_without_camera_and_light_get_them() {
    let scene = quad(json!({"mode": 5}), json!({}));
    let camera = &scene.cameras[0];
    assert_eq!((camera.name.as_str(), scene.cameras.len(), scene.lights.len()), ("default", 1, 1));
    let tan = (0.5 * camera.yfov_rad).tan();
    for v in &scene.vertices {
        let to = Vec3::from_array(v.position_ws) - camera.position_ws;
        let depth = to.dot(camera.forward_ws);
        assert!(depth > camera.near);
        assert!(to.dot(camera.right_ws).abs() < tan * depth && to.dot(camera.up_ws).abs() < tan * depth);
    }
    assert!(matches!(&scene.lights[0], Light::Directional { direction_ws, .. } if direction_ws.y < -0.9));
}

#[test]
fn lights_take_colour_position_and_direction() {
    let down = [-(0.5f32.sqrt()), 0.0, 0.0, 0.5f32.sqrt()]; // -90 degrees about x: -z becomes -y
    let on = |light: u32| json!({"KHR_lights_punctual": {"light": light}});
    let extra = json!({
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0}, {"translation": [0, 5, 0], "rotation": down, "extensions": on(0), "children": [2, 3, 4]},
            {"translation": [1, 0, 0], "extensions": on(1)}, {"extensions": on(2)}, {"extensions": on(3)}],
        "extensionsRequired": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [
            {"type": "directional", "color": [1, 0.5, 0], "intensity": 4},
            {"type": "point", "intensity": 3},
            {"type": "spot", "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.5}},
            {"type": "point", "intensity": 0}]}},
    });
    let lights = quad(json!({}), extra).lights;
    assert_eq!(lights.len(), 3);
    let Light::Directional { direction_ws, irradiance } = &lights[0] else { panic!("{:?}", lights[0]) };
    assert!(close(*direction_ws, Vec3::NEG_Y) && *irradiance == Vec3::new(4.0, 2.0, 0.0));
    let Light::Point { position_ws, intensity } = &lights[1] else { panic!("{:?}", lights[1]) };
    assert!(close(*position_ws, Vec3::new(1.0, 5.0, 0.0)) && *intensity == Vec3::splat(3.0));
    let Light::Spot { inner_cos, outer_cos, direction_ws, .. } = &lights[2] else { panic!("{:?}", lights[2]) };
    assert!(close(*direction_ws, Vec3::NEG_Y) && *inner_cos == 0.2f32.cos() && *outer_cos == 0.5f32.cos());
}

#[test]
fn what_lights_a_scene_is_told() {
    let lamp = |intensity: f32| {
        json!({"nodes": [{"mesh": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}],
            "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": intensity}]}}})
    };
    let glowing = |glow: f32| json!({"materials": [{"emissiveFactor": [0, glow, 0]}, {"emissiveFactor": [1, 1, 1]}]});
    let of_material = json!({"material": 0});
    let data = format!("data:image/png;base64,{}", base64::engine::general_purpose::STANDARD.encode(png(7)));
    let display = |strength: f32| {
        json!({"images": [{"uri": data}], "textures": [{"source": 0}], "materials": [{
            "emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0},
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": strength}}}]})
    };
    for (primitive, extra, lit_by) in [
        (json!({}), json!({}), LitBy::Nothing),
        (json!({}), lamp(2.0), LitBy::Lights),
        (json!({}), lamp(0.0), LitBy::Lights),
        (of_material.clone(), glowing(0.5), LitBy::EmissiveSurfaces),
        // A texture that glows is a detail, unless it is bright.
        (of_material.clone(), display(1.0), LitBy::Nothing),
        (of_material.clone(), display(2.0), LitBy::EmissiveSurfaces),
        // No triangle has the material that glows.
        (of_material.clone(), glowing(0.0), LitBy::Nothing),
        (
            of_material,
            json!({"materials": [{"emissiveFactor": [1, 1, 1], "extensions": {"KHR_materials_unlit": {}}}]}),
            LitBy::Nothing,
        ),
    ] {
        let scene = quad(primitive, extra.clone());
        assert_eq!(scene.lit_by, lit_by, "{extra}");
        assert_eq!(scene.lights.len(), 1, "{extra}");
    }
    assert_eq!(quad(json!({}), lamp(0.0)).lights, [Light::DARK]);
    assert_eq!(quad(json!({"material": 0}), glowing(0.5)).lights, [Light::DARK], "no sun beside what shines");
}

#[test]
fn a_hundred_thousand_light_nodes_load_at_once() {
    let count = 100_000;
    let mut nodes = vec![json!({"mesh": 0})];
    nodes.extend(
        (0..count).map(|i| json!({"translation": [i, 1, 0], "extensions": {"KHR_lights_punctual": {"light": i}}})),
    );
    let lights: Vec<_> = (0..count).map(|_| json!({"type": "point"})).collect();
    let extra = json!({
        "scenes": [{"nodes": (0..=count).collect::<Vec<_>>()}], "nodes": nodes,
        "extensions": {"KHR_lights_punctual": {"lights": lights}},
    });
    let mut parts = Parts::default();
    let position = parts.floats("VEC3", &QUAD);
    let glb = parts.glb(json!([{"primitives": [{"attributes": {"POSITION": position}}]}]), extra);
    let start = std::time::Instant::now();
    assert_eq!(open(&glb).unwrap().lights.len(), count);
    let seconds = start.elapsed().as_secs_f64();
    assert!(seconds < 20.0, "{seconds:.1} s for {count} lights");
}

#[test]
fn colours_of_vertices_are_read_in_every_format() {
    let color_of = |component: u32, kind: &str, normalized: bool, bytes: &[u8]| {
        let mut parts = Parts::default();
        let position = parts.floats("VEC3", &QUAD[..9]);
        let stride = bytes.len() / 3;
        let view = parts.view(bytes);
        parts.views[view]["byteStride"] = json!(stride);
        let color = parts.accessor(json!({"bufferView": view, "componentType": component, "count": 3, "type": kind,
            "normalized": normalized}));
        let mesh = json!([{"primitives": [{"attributes": {"POSITION": position, "COLOR_0": color}, "material": 0},
            {"attributes": {"POSITION": position}, "material": 1}]}]);
        let scene = open(&parts.glb(mesh, json!({"materials": [{}, {}]}))).unwrap();
        assert_eq!(scene.vertices[3].color, Vertex::WHITE);
        assert!(scene.materials[0].has_vertex_colors && !scene.materials[1].has_vertex_colors);
        scene.vertices[0].color
    };
    let floats = |values: [f32; 4]| values.repeat(3).iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let three = |values: [f32; 3]| values.repeat(3).iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let half = 32768;
    assert_eq!(color_of(5126, "VEC4", false, &floats([1.0, 0.5, 0.0, 0.25])), [u16::MAX, half, 0, 16384]);
    assert_eq!(color_of(5126, "VEC3", false, &three([1.0, 0.5, 0.0])), [u16::MAX, half, 0, u16::MAX]);
    assert_eq!(color_of(5126, "VEC3", false, &three([2.0, -1.0, 0.0])), [u16::MAX, 0, 0, u16::MAX]);
    let bytes = [255u8, 51, 0, 102].repeat(3);
    assert_eq!(color_of(5121, "VEC4", true, &bytes), [u16::MAX, 13107, 0, 26214]);
    assert_eq!(color_of(5121, "VEC3", true, &bytes), [u16::MAX, 13107, 0, u16::MAX]);
    assert_eq!(color_of(5121, "VEC4", false, &bytes), [u16::MAX, 13107, 0, 26214], "without the flag too");
    let shorts: Vec<u8> = [65535u16, 300, 0, 9].repeat(3).iter().flat_map(|v| v.to_le_bytes()).collect();
    assert_eq!(color_of(5123, "VEC4", true, &shorts), [65535, 300, 0, 9]);
}

#[test]
fn samplers_say_how_textures_are_read() {
    use crate::scene::sampling::{Filter, Sampling, Wrap};
    let sampling = |sampler: Value| {
        let mut parts = Parts::default();
        let position = parts.floats("VEC3", &QUAD);
        let image = parts.view(&png(9));
        let extra = json!({"images": [{"bufferView": image}], "samplers": [sampler],
            "textures": [{"source": 0, "sampler": 0}],
            "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]});
        let mesh = json!([{"primitives": [{"attributes": {"POSITION": position}, "material": 0}]}]);
        open(&parts.glb(mesh, extra)).unwrap().materials[0].base_color_sampling
    };
    let plain = Sampling::default();
    assert_eq!(sampling(json!({})), plain);
    assert_eq!(sampling(json!({"magFilter": 1, "minFilter": 2, "wrapS": 3})), plain, "unknown values");
    let pixels = sampling(json!({"magFilter": 9728.0, "minFilter": 9984, "wrapS": 33071, "wrapT": 33648}));
    let nearest = Filter::Nearest;
    let wrap = [Wrap::Clamp, Wrap::Mirror];
    assert_eq!(pixels, Sampling { wrap, magnify: nearest, minify: nearest, mips: Some(nearest) });
    let without = sampling(json!({"magFilter": 9729, "minFilter": 9729, "wrapT": 10497}));
    assert_eq!(without, Sampling { mips: None, ..plain });
}
