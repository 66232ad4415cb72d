//! One mesh as many tools write it: each file must become the triangles of the plainest one.

use glam::{Mat3, Mat4, Quat};
use serde_json::{Value, json};

use super::tests::{Parts, open};
use super::*;
use crate::scene::octahedral::unpack_octahedral;
use crate::scene::testing::glb_from;
use crate::scene::{Light, LitBy};

/// Two squares beside each other, by rows from below.
const POSITIONS: [[f32; 3]; 6] = [[0., 0., 0.], [1., 0., 0.], [2., 0., 0.], [0., 1., 0.], [1., 1., 0.], [2., 1., 0.]];
const NORMAL: [f32; 3] = [0., 0., 1.];
const UVS: [[f32; 2]; 6] = [[0., 1.], [0.4, 1.], [1., 1.], [0., 0.2], [0.4, 0.2], [1., 0.2]];
const TRIANGLES: [u16; 12] = [3, 0, 4, 0, 1, 4, 4, 1, 5, 1, 2, 5];

/// A triangle by its corners, the least of them first: position, normal and texture coordinates, in thousandths.
type Triangle = [[i32; 8]; 3];

/// The triangles of a scene in an order of their own.
fn triangles(scene: &Scene) -> Vec<Triangle> {
    let corner = |index: &u32| {
        let vertex = &scene.vertices[*index as usize];
        let normal = unpack_octahedral(vertex.normal_oct).to_array();
        let all: Vec<f32> = vertex.position_ws.into_iter().chain(normal).chain(vertex.uv).collect();
        std::array::from_fn(|i| (1e3 * all[i]).round() as i32)
    };
    let mut triangles: Vec<Triangle> =
        scene.indices.chunks_exact(3).map(|t| [0, 1, 2].map(|i| corner(&t[i]))).collect();
    for triangle in &mut triangles {
        let first = (0..3).min_by_key(|i| triangle[*i]).unwrap();
        triangle.rotate_left(first);
    }
    triangles.sort_unstable();
    triangles
}

fn floats<const N: usize>(parts: &mut Parts, kind: &str, values: &[[f32; N]]) -> usize {
    parts.floats(kind, values.as_flattened())
}

/// Accessors of the mesh's attributes.
fn attributes(parts: &mut Parts) -> Value {
    let (position, normal, uv) =
        (floats(parts, "VEC3", &POSITIONS), floats(parts, "VEC3", &[NORMAL; 6]), floats(parts, "VEC2", &UVS));
    json!({"POSITION": position, "NORMAL": normal, "TEXCOORD_0": uv})
}

/// The plain mesh with keys of its primitive, and of the file, replaced.
fn read(primitive: impl FnOnce(&mut Parts, &mut Value), extra: Value) -> Result<Scene> {
    let mut parts = Parts::default();
    let attributes = attributes(&mut parts);
    let indices = parts.indices(&TRIANGLES);
    let mut whole = json!({"attributes": attributes, "indices": indices});
    primitive(&mut parts, &mut whole);
    open(&parts.glb(json!([{"primitives": [whole]}]), extra))
}

#[track_caller]
fn is_plain(primitive: impl FnOnce(&mut Parts, &mut Value), extra: Value) {
    let found = triangles(&read(primitive, extra).unwrap());
    assert_eq!(found, triangles(&read(|_, _| (), json!({})).unwrap()));
}

#[test]
fn another_mesh_is_another() {
    let plain = triangles(&read(|_, _| (), json!({})).unwrap());
    assert_eq!(plain.len(), 4);
    let turned = read(|p, m| m["indices"] = json!(p.indices(&[0, 3, 4, 0, 1, 4, 4, 1, 5, 1, 2, 5])), json!({}));
    assert_ne!(triangles(&turned.unwrap()), plain, "a triangle is seen from behind");
    let moved = read(|_, _| (), json!({"nodes": [{"mesh": 0, "translation": [0, 0, 0.01]}]}));
    assert_ne!(triangles(&moved.unwrap()), plain);
}

/// An accessor of indices with components of this many bytes.
fn indices(parts: &mut Parts, bytes: usize, values: &[u32]) -> usize {
    let raw: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()[..bytes].to_vec()).collect();
    let component = [(1, 5121), (2, 5123), (4, 5125)].iter().find(|(size, _)| *size == bytes).unwrap().1;
    let view = parts.view(&raw);
    parts.accessor(json!({"bufferView": view, "componentType": component, "count": values.len(), "type": "SCALAR"}))
}

#[test]
fn strips_fans_and_lists_of_every_index() {
    let stitched = [3, 0, 4, 1, 1, 4, 4, 1, 5, 2];
    for bytes in [1, 2, 4] {
        is_plain(|p, m| m["indices"] = json!(indices(p, bytes, &TRIANGLES.map(u32::from))), json!({}));
        is_plain(|p, m| (m["indices"], m["mode"]) = (json!(indices(p, bytes, &stitched)), json!(5)), json!({}));
    }
    let mut parts = Parts::default();
    let fans: Vec<Value> = [[4, 3, 0, 1], [5, 4, 1, 2]]
        .into_iter()
        .map(|fan| {
            let (position, normal) = (fan.map(|i| POSITIONS[i]), [NORMAL; 4]);
            let (position, normal) = (floats(&mut parts, "VEC3", &position), floats(&mut parts, "VEC3", &normal));
            let uv = floats(&mut parts, "VEC2", &fan.map(|i| UVS[i]));
            json!({"mode": 6, "attributes": {"POSITION": position, "NORMAL": normal, "TEXCOORD_0": uv}})
        })
        .collect();
    let fans = triangles(&open(&parts.glb(json!([{"primitives": fans}]), json!({}))).unwrap());
    assert_eq!(fans, triangles(&read(|_, _| (), json!({})).unwrap()));
}

/// glTF forbids the largest index, and OpenGL and Vulkan begin another strip there.
#[test]
fn the_largest_index_begins_another_strip_or_fan() {
    for (bytes, restart) in [(1, 0xff), (2, 0xffff), (4, u32::MAX)] {
        for (mode, values) in [
            (5, [&[restart, 3, 0, 4, 1, restart][..], &[4, 1, 5, 2]].concat()),
            (6, [&[4, 3, 0, 1, restart, restart][..], &[5, 4, 1, 2, restart]].concat()),
        ] {
            is_plain(|p, m| (m["indices"], m["mode"]) = (json!(indices(p, bytes, &values)), json!(mode)), json!({}));
        }
    }
    // Of a list it is no more than a vertex that does not exist, and so is the largest index of another type.
    for (mode, bytes, index) in [(4, 2, 0xffff), (5, 2, 0xff), (5, 4, 0xffff)] {
        let values = [3, 0, 4, index, 1, 4];
        let wrong =
            read(|p, m| (m["indices"], m["mode"]) = (json!(indices(p, bytes, &values)), json!(mode)), json!({}));
        let message = wrong.err().unwrap().to_string();
        assert!(message.contains(&format!("has the index {index} but only 6 vertices")), "{message}");
    }
}

#[test]
fn attributes_may_be_interleaved_sparse_or_quantised() {
    let mut rows = Vec::new();
    for (position, uv) in POSITIONS.iter().zip(&UVS) {
        rows.extend(position.iter().chain(&NORMAL).chain(uv).flat_map(|value| value.to_le_bytes()));
    }
    is_plain(
        |p, m| {
            let view = p.view(&rows);
            p.views[view]["byteStride"] = json!(32);
            for (name, offset, kind) in [("POSITION", 0, "VEC3"), ("NORMAL", 12, "VEC3"), ("TEXCOORD_0", 24, "VEC2")] {
                m["attributes"][name] = json!(p.accessor(json!({"bufferView": view, "byteOffset": offset,
                    "componentType": 5126, "count": 6, "type": kind})));
            }
        },
        json!({}),
    );
    // From zeros, with all that is none.
    is_plain(
        |p, m| {
            let (at, values) = (p.view(&[1, 2, 3, 4, 5]), p.view(bytemuck::cast_slice(&POSITIONS[1..])));
            m["attributes"]["POSITION"] = json!(p.accessor(json!({"componentType": 5126, "count": 6, "type": "VEC3",
                "sparse": {"count": 5, "indices": {"bufferView": at, "componentType": 5121},
                    "values": {"bufferView": values}}})));
        },
        json!({}),
    );
    is_plain(
        |p, m| {
            let shorts: Vec<u16> =
                POSITIONS.iter().flat_map(|p| [p[0], p[1], p[2], 9.0].map(|v| 500 * v as u16)).collect();
            let bytes: Vec<u8> =
                UVS.iter().flat_map(|uv| [uv[0], uv[1], 0.3, 0.7].map(|v| (255.0 * v).round() as u8)).collect();
            let mut quantised = |name: &str, bytes: &[u8], stride: u32, accessor: Value| {
                let view = p.view(bytes);
                p.views[view]["byteStride"] = json!(stride);
                let index = p.accessor(accessor);
                (p.accessors[index]["bufferView"], p.accessors[index]["count"]) = (json!(view), json!(6));
                m["attributes"][name] = json!(index);
            };
            quantised("POSITION", bytemuck::cast_slice(&shorts), 8, json!({"componentType": 5123, "type": "VEC3"}));
            let normals = [0u8, 0, 127, 77].repeat(6);
            quantised("NORMAL", &normals, 4, json!({"componentType": 5120, "normalized": true, "type": "VEC3"}));
            quantised("TEXCOORD_0", &bytes, 4, json!({"componentType": 5121, "normalized": true, "type": "VEC2"}));
        },
        json!({"nodes": [{"mesh": 0, "scale": [0.002, 0.002, 0.002]}], "extensionsRequired": ["KHR_mesh_quantization"]}),
    );
}

#[test]
fn what_has_no_area_leaves_no_trace() {
    is_plain(
        |p, m| m["indices"] = json!(p.indices(&[&TRIANGLES[..], &[0, 0, 1, 0, 1, 2, 4, 4, 4]].concat())),
        json!({}),
    );
    // Flat triangles of a plane have its normal.
    is_plain(|_, m| drop(m["attributes"].as_object_mut().unwrap().remove("NORMAL")), json!({}));
    // A vertex that no triangle has may have anything but a position that is none.
    is_plain(
        |p, m| {
            let with = |last: [f32; 3], all: &[[f32; 3]]| [all, &[last]].concat();
            let position = floats(p, "VEC3", &with([9.0; 3], &POSITIONS));
            let normal = floats(p, "VEC3", &with([f32::NAN; 3], &[NORMAL; 6]));
            let uv = floats(p, "VEC2", &[&UVS[..], &[[f32::INFINITY, f32::NAN]]].concat());
            m["attributes"] = json!({"POSITION": position, "NORMAL": normal, "TEXCOORD_0": uv});
        },
        json!({}),
    );
}

#[test]
fn nodes_that_mirror_and_shear() {
    is_plain(|_, _| (), json!({"nodes": [{"children": [1], "scale": [-1, 1, 1]}, {"mesh": 0, "scale": [-1, 1, 1]}]}));
    is_plain(
        |_, _| (),
        json!({"nodes": [{"children": [1], "scale": [-3, 0.5, -2]}, {"mesh": 0, "matrix":
        [-1.0 / 3.0, 0, 0, 0, 0, 2, 0, 0, 0, 0, -0.5, 0, 0, 0, 0, 1]}]}),
    );
    // A stretched parent over a turned child, and the mesh sheared the other way.
    let turn = Quat::from_euler(glam::EulerRot::XYZ, 0.3, 0.6, -0.4);
    let parent = Vec3::new(3.0, 0.5, 1.0);
    let world = Mat4::from_scale(parent) * Mat4::from_quat(turn);
    is_plain(
        |p, m| {
            let back = world.inverse();
            let positions = POSITIONS.map(|position| back.transform_point3(position.into()).to_array());
            let normal = (Mat3::from_mat4(world).transpose() * Vec3::from_array(NORMAL)).normalize().to_array();
            m["attributes"]["POSITION"] = json!(floats(p, "VEC3", &positions));
            m["attributes"]["NORMAL"] = json!(floats(p, "VEC3", &[normal; 6]));
        },
        json!({"nodes": [{"children": [1], "scale": parent.to_array()}, {"mesh": 0, "rotation": turn.to_array()}]}),
    );
}

#[test]
fn scenes_may_be_missing_or_empty() {
    let two = json!([{"children": [1]}, {"mesh": 0}]);
    is_plain(|_, _| (), json!({"scene": null, "scenes": null, "nodes": two}));
    is_plain(|_, _| (), json!({"scene": null, "scenes": [], "nodes": two}));
    is_plain(|_, _| (), json!({"scene": null}));
    is_plain(|_, _| (), json!({"scenes": [{"nodes": [0]}, {"name": "empty"}]}));
    is_plain(|_, _| (), json!({"extras": [1, "a"], "asset": {"version": "2.0", "extras": null}}));
}

#[test]
fn lights_may_be_shared_and_have_sharp_cones() {
    let lit = |light: Value, count: usize| {
        let mut nodes = vec![json!({"mesh": 0})];
        let at = |i| json!({"translation": [i, 0, 5], "extensions": {"KHR_lights_punctual": {"light": 0}}});
        nodes.extend((0..count).map(at));
        let all: Vec<usize> = (0..=count).collect();
        let extra = json!({"nodes": nodes, "scenes": [{"nodes": all}],
            "extensions": {"KHR_lights_punctual": {"lights": [light]}}});
        read(|_, _| (), extra).unwrap()
    };
    let scene = lit(json!({"type": "point", "intensity": 2.5}), 17);
    assert_eq!((scene.lights.len(), scene.lit_by), (17, LitBy::Lights));
    let places: Vec<f32> = scene
        .lights
        .iter()
        .map(|light| match light {
            Light::Point { position_ws, intensity } if *intensity == Vec3::splat(2.5) => position_ws.x,
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(places, (0..17).map(|i| i as f32).collect::<Vec<_>>());
    for (inner, outer) in [(0.5, 0.5), (0.7, 0.5), (0.0, 0.0), (1.5, 1.6)] {
        let spot = json!({"type": "spot", "spot": {"innerConeAngle": inner, "outerConeAngle": outer}});
        let Light::Spot { inner_cos, outer_cos, .. } = lit(spot, 1).lights[0] else { panic!("no spot") };
        assert!(
            inner_cos > outer_cos && outer_cos > -1e-6 && inner_cos <= 1.0,
            "{inner} {outer}: {inner_cos} {outer_cos}"
        );
    }
}

#[test]
fn files_without_base64_and_with_unknown_chunks() {
    let bytes: Vec<u8> = bytemuck::cast_slice(&POSITIONS[..3]).to_vec();
    let percent: String = bytes.iter().map(|byte| format!("%{byte:02X}")).collect();
    let document = json!({"asset": {"version": "2.0"}, "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"mode": 4, "attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5121, "count": 3, "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 1, "byteLength": 3}],
        "buffers": [{"uri": format!("data:application/octet-stream,{percent}"), "byteLength": 36},
            {"uri": "data:,%00%01%02", "byteLength": 3}]});
    // Three places on a line have no area, so that the file is read to its end.
    let message = open(document.to_string().as_bytes()).err().unwrap().to_string();
    assert!(message.contains("no triangles"), "{message}");

    let mut parts = Parts::default();
    let attributes = attributes(&mut parts);
    let indices = parts.indices(&TRIANGLES);
    let glb = parts.glb(json!([{"primitives": [{"attributes": attributes, "indices": indices}]}]), json!({}));
    let json_end = 20 + u32::from_le_bytes([glb[12], glb[13], glb[14], glb[15]]) as usize;
    let unknown = b"\x08\0\0\0TOOLits data";
    for place in [json_end, glb.len()] {
        let mut with = [&glb[..place], unknown, &glb[place..]].concat();
        let length = (with.len() as u32).to_le_bytes();
        with[8..12].copy_from_slice(&length);
        let wanted = triangles(&read(|_, _| (), json!({})).unwrap());
        assert_eq!(triangles(&open(&with).unwrap()), wanted, "at {place}");
    }
    assert!(open(&glb_from("{}", &[])).is_err());
}

#[test]
fn images_of_every_kind_have_their_colours() {
    let decoded = |name: &str, file: &[u8]| {
        let texture = super::super::gltf_images::decode_image(name, file).unwrap();
        assert_eq!([texture.width, texture.height], [8, 8], "{name}");
        move |x: usize, y: usize| -> [u8; 4] { std::array::from_fn(|i| texture.rgba[4 * (8 * y + x) + i]) }
    };
    let palette = decoded("palette.png", include_bytes!("../../tests/textures/palette.png"));
    assert_eq!([palette(0, 7), palette(7, 0)], [[255, 0, 0, 255], [0, 0, 255, 64]]);
    let interlaced = decoded("interlaced16.png", include_bytes!("../../tests/textures/interlaced16.png"));
    for (x, y) in (0..8).flat_map(|y| (0..8).map(move |x| (x, y))) {
        let sixteen = [8192 * x + 257 * y, 65535 - 8192 * y, 257 * (16 * x + y)];
        let [r, g, b, alpha] = interlaced(x, y);
        let near = |(byte, wanted): (u8, usize)| (f64::from(byte) - wanted as f64 / 257.0).abs() <= 0.5 + 1e-9;
        assert!([r, g, b].into_iter().zip(sixteen).all(near) && alpha == 255, "{x} {y}: {:?}", interlaced(x, y));
    }
    // libjpeg has (200, 137, 75) for both.
    for (name, file) in [
        ("cmyk.jpg", include_bytes!("../../tests/textures/cmyk.jpg")),
        ("ycck.jpg", include_bytes!("../../tests/textures/ycck.jpg")),
    ] {
        let [r, g, b, alpha] = decoded(name, file)(3, 4);
        let is_near = |(a, b): (u8, u8)| a.abs_diff(b) <= 3;
        assert!([(r, 200), (g, 137), (b, 75)].into_iter().all(is_near) && alpha == 255, "{name}: {r} {g} {b}");
    }
}
