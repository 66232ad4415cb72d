//! What extensions do to a scene, on hand-written numbers.

use std::f32::consts::FRAC_PI_2;

use serde_json::{Value, json};

use super::super::testing::Ktx2;
use super::tests::{Parts, QUAD, open, open_and_tell};
use super::*;

/// The quad with two sets of texture coordinates, of material 0, with these top-level entries.
fn quad(extra: impl FnOnce(&mut Parts) -> Value) -> Result<Scene> {
    open(&quad_file(extra))
}

/// The same with what is said of it.
fn told(extra: impl FnOnce(&mut Parts) -> Value) -> (Scene, Vec<String>) {
    open_and_tell(&quad_file(extra)).unwrap()
}

fn quad_file(extra: impl FnOnce(&mut Parts) -> Value) -> Vec<u8> {
    let mut parts = Parts::default();
    let position = parts.floats("VEC3", &QUAD);
    let first = parts.floats("VEC2", &[0., 0., 1., 0., 0., 1., 1., 1.]);
    let second = parts.floats("VEC2", &[0.5; 8]);
    let attributes = json!({"POSITION": position, "TEXCOORD_0": first, "TEXCOORD_1": second});
    let extra = extra(&mut parts);
    parts.glb(json!([{"primitives": [{"attributes": attributes, "mode": 5, "material": 0}]}]), extra)
}

/// A PNG of one texel.
fn image(parts: &mut Parts) -> usize {
    let mut png = std::io::Cursor::new(Vec::new());
    image::RgbImage::new(1, 1).write_to(&mut png, image::ImageFormat::Png).unwrap();
    parts.view(&png.into_inner())
}

/// The texture coordinates of the corners 0, 1 and 2 of the quad whose base colour has this texture info.
fn mapped(info: &Value) -> [[f32; 2]; 3] {
    let scene = quad(|parts| {
        json!({"images": [{"bufferView": image(parts)}], "textures": [{"source": 0}],
            "materials": [{"pbrMetallicRoughness": {"baseColorTexture": info}}]})
    });
    let scene = scene.unwrap();
    [0, 1, 2].map(|corner| scene.vertices[scene.indices[corner] as usize].uv.map(|c| (c * 1e4).round() / 1e4))
}

#[test]
fn textures_lie_as_their_set_and_transform_say() {
    assert_eq!(mapped(&json!({"index": 0})), [[0., 0.], [1., 0.], [0., 1.]]);
    assert_eq!(mapped(&json!({"index": 0, "texCoord": 1})), [[0.5, 0.5]; 3]);
    assert_eq!(mapped(&json!({"index": 0, "texCoord": 7})), [[0.0, 0.0]; 3], "a set that is not there");
    let transform = |t: Value| json!({"index": 0, "extensions": {"KHR_texture_transform": t}});
    assert_eq!(mapped(&transform(json!({"texCoord": 1}))), [[0.5, 0.5]; 3]);
    let stretched = transform(json!({"offset": [0.25, 0.5], "scale": [2, 3.0]}));
    assert_eq!(mapped(&stretched), [[0.25, 0.5], [2.25, 0.5], [0.25, 3.5]]);
    // A quarter turn counter-clockwise as the texture is seen takes +u to -v, which is up.
    assert_eq!(mapped(&transform(json!({"rotation": FRAC_PI_2}))), [[0., 0.], [0., -1.], [1., 0.]]);
    let all = transform(json!({"rotation": FRAC_PI_2, "scale": [2, 3], "offset": [10, 20]}));
    assert_eq!(mapped(&all), [[10., 20.], [10., 18.], [13., 20.]]);
}

#[test]
fn specular_glossiness_gives_its_diffuse_colour() {
    let scene = quad(|parts| {
        let sheen = json!({"diffuseFactor": [0.5, 0.25, 0, 1], "diffuseTexture": {"index": 0, "texCoord": 1.0},
            "specularFactor": [1, 1, 1], "glossinessFactor": 0.5, "extras": 3});
        json!({"images": [{"bufferView": image(parts)}], "textures": [{"source": 0}],
            "extensionsRequired": ["KHR_materials_pbrSpecularGlossiness"],
            "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]},
                "extensions": {"KHR_materials_pbrSpecularGlossiness": sheen}}]})
    });
    let scene = scene.unwrap();
    assert_eq!(scene.materials[0].base_color, [0.5, 0.25, 0.0, 1.0]);
    assert_eq!((scene.materials[0].base_color_texture, scene.vertices[0].uv), (Some(0), [0.5, 0.5]));
}

#[test]
fn instances_are_placed_below_their_node() {
    let scene = quad(|parts| {
        let translations = parts.floats("VEC3", &[0., 0., 0., 5., 0., 0., 0., 7., 0.]);
        let scales = parts.floats("VEC3", &[1., 1., 1., 2., 2., 2., 1., 1., 1.]);
        // Normalised shorts: none, none, a half turn about z.
        let turns = parts.view(bytemuck::cast_slice(&[0i16, 0, 0, 32767, 0, 0, 0, 32767, 0, 0, 32767, 0]));
        let turns = parts.accessor(json!({"bufferView": turns, "componentType": 5122, "normalized": true, "count": 3,
            "type": "VEC4"}));
        let attributes = json!({"TRANSLATION": translations, "SCALE": scales, "ROTATION": turns, "_ID": 99});
        json!({"materials": [{}], "extensionsRequired": ["EXT_mesh_gpu_instancing"],
            "nodes": [{"mesh": 0, "translation": [0, 0, 3], "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}}}]})
    });
    let scene = scene.unwrap();
    assert_eq!(scene.indices.len(), 18);
    assert_eq!((scene.bounds.min, scene.bounds.max), (Vec3::new(-1.0, 0.0, 3.0), Vec3::new(7.0, 7.0, 3.0)));
    let uneven = quad(|parts| {
        let (three, two) = (parts.floats("VEC3", &[0.0; 9]), parts.floats("VEC3", &[1.0; 6]));
        let attributes = json!({"TRANSLATION": three, "SCALE": two});
        json!({"materials": [{}], "nodes": [{"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}}}]})
    });
    let message = uneven.err().unwrap().to_string();
    assert!(message.contains("node 0 has instances with attributes of different counts"), "{message}");
}

#[test]
fn invisible_nodes_hide_what_is_below_them() {
    let scene = quad(|_| {
        let hidden = json!({"KHR_node_visibility": {"visible": false}});
        let shown = json!({"KHR_node_visibility": {"visible": true}, "KHR_lights_punctual": {"light": 0}});
        json!({"materials": [{}], "extensionsRequired": ["KHR_node_visibility"], "scenes": [{"nodes": [0, 1]}],
            "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point"}]}},
            "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
            "nodes": [{"mesh": 0}, {"children": [2], "extensions": hidden}, {"mesh": 0, "camera": 0, "extensions": shown}]})
    });
    let scene = scene.unwrap();
    assert_eq!((scene.indices.len(), scene.cameras.len()), (6, 1));
    assert_eq!(scene.lit_by, crate::scene::LitBy::Nothing);
}

/// A picture whose left half is red and whose right half is blue.
fn halves() -> image::RgbaImage {
    image::RgbaImage::from_fn(8, 4, |x, _| image::Rgba(if x < 4 { [255, 0, 0, 255] } else { [0, 0, 255, 255] }))
}

/// The scene with an extension's image as its texture, and what is said of it.
fn textured(extension: &str, file: &[u8]) -> (Scene, Vec<String>) {
    told(|parts| {
        json!({"images": [{"bufferView": parts.view(file)}], "extensionsRequired": [extension],
            "textures": [{"extensions": {extension: {"source": 0}}}],
            "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]})
    })
}

#[test]
fn webp_and_dds_images_are_read() {
    let mut webp = std::io::Cursor::new(Vec::new());
    halves().write_with_encoder(image::codecs::webp::WebPEncoder::new_lossless(&mut webp)).unwrap();
    // Two blocks of BC1: two colours of 5, 6 and 5 bits, and every texel the first of them.
    let block = |color: u16| [&color.to_le_bytes()[..], &[0; 6]].concat();
    let words = |words: &[u32]| words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>();
    let head = [&[124u32, 0x81007, 4, 8, 16, 0, 1][..], &[0; 11], &[32, 4], &[u32::from_le_bytes(*b"DXT1")], &[0; 5]];
    let head = [words(&head.concat()), words(&[0x1000, 0, 0, 0, 0])].concat();
    let dds = [b"DDS ".to_vec(), head, block(0xf800), block(0x001f)].concat();
    for (extension, file) in [("EXT_texture_webp", webp.into_inner()), ("MSFT_texture_dds", dds)] {
        let (scene, said) = textured(extension, &file);
        assert_eq!(said, [""; 0]);
        let texture = &scene.textures[0];
        assert_eq!((texture.width, texture.height), (8, 4), "{extension}");
        assert!(texture.rgba == halves().into_raw(), "{extension}");
        let (scene, said) = textured(extension, &file[..file.len() - 5]);
        assert!(said[0].starts_with("test.glb: texture `image 0` is unreadable: ") && said.len() == 1, "{said:?}");
        assert!(scene.textures.is_empty() && said[0].ends_with("; it is left out"), "{said:?}");
    }
    let ktx2 = Ktx2 { format: 37, color_model: 1, size: [8, 4], scheme: 0, level_bytes: 128, level: &halves() }.file();
    let (scene, _) = textured("EXT_texture_webp", &ktx2);
    assert!(scene.textures[0].rgba == halves().into_raw(), "the bytes say what an image is");
    let (_, unread) = textured("EXT_texture_webp", b"\xabKTX 11\xbb\r\n\x1a\n");
    let why = "it ends before what its header and its list of levels announce";
    assert_eq!(unread, [format!("test.glb: texture `image 0` is unreadable: {why}; it is left out")]);
}

/// The texels of a texture of `KHR_texture_basisu`, with another image or without, and what is said of it.
fn basis_texture(ktx2: &[u8], other: Option<&[u8]>, is_required: bool) -> (Option<Vec<u8>>, Vec<String>) {
    let (scene, said) = told(|parts| {
        let mut texture = json!({"extensions": {"KHR_texture_basisu": {"source": 0}}});
        let mut images = vec![json!({"bufferView": parts.view(ktx2), "mimeType": "image/ktx2"})];
        if let Some(other) = other {
            images.push(json!({"bufferView": parts.view(other)}));
            texture["source"] = json!(1);
        }
        let required: &[&str] = if is_required { &["KHR_texture_basisu"] } else { &[] };
        json!({"images": images, "extensionsUsed": ["KHR_texture_basisu"], "extensionsRequired": required,
            "textures": [texture], "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]})
    });
    (scene.materials[0].base_color_texture.map(|slot| scene.textures[slot as usize].rgba.clone()), said)
}

#[test]
fn basis_images_stand_before_others() {
    let etc1s = include_bytes!("../../tests/textures/etc1s.ktx2");
    let wanted = image::load_from_memory(include_bytes!("../../tests/textures/etc1s.png")).unwrap().into_rgba8();
    let wanted = Some(wanted.into_raw());
    let mut png = std::io::Cursor::new(Vec::new());
    halves().write_to(&mut png, image::ImageFormat::Png).unwrap();
    let png = png.into_inner();
    let unread = "is unreadable: it is neither png nor jpeg, webp, dds or ktx2";
    for is_required in [false, true] {
        assert!(basis_texture(etc1s, None, is_required) == (wanted.clone(), vec![]));
        assert!(basis_texture(etc1s, Some(&png), is_required) == (wanted.clone(), vec![]), "both can be read");
        let (other, said) = basis_texture(b"ktx?", Some(&png), is_required);
        assert!(other == Some(halves().into_raw()), "only the other can be read");
        assert_eq!(said, [format!("test.glb: texture `image 0` {unread}; the other image of the texture is used")]);
        let (neither, said) = basis_texture(b"ktx?", Some(b"png?"), is_required);
        assert!(neither.is_none() && said.len() == 2, "{said:?}");
        assert_eq!(said[1], format!("test.glb: texture `image 1` {unread}; it is left out"));
        let (none, said) = basis_texture(b"ktx?", None, is_required);
        assert!(none.is_none());
        assert_eq!(said, [format!("test.glb: texture `image 0` {unread}; it is left out")]);
    }
}

#[test]
fn emission_is_factor_times_strength_times_texture() {
    let material = |material: Value| {
        let scene = quad(
            |parts| json!({"images": [{"bufferView": image(parts)}], "textures": [{"source": 0}], "materials": [material]}),
        );
        scene.map(|scene| scene.materials[0].clone())
    };
    let strength = |strength: Value| json!({"KHR_materials_emissive_strength": {"emissiveStrength": strength}});
    let plain = material(json!({"emissiveFactor": [0.25, 0.5, 1]})).unwrap();
    assert_eq!((plain.emission, plain.emission_texture, plain.is_unlit), ([0.25, 0.5, 1.0], None, false));
    let strong = material(json!({"emissiveFactor": [0.25, 0.5, 1], "extensions": strength(json!(8))})).unwrap();
    assert!(strong.emission == [2.0, 4.0, 8.0] && strong.shines());
    let textured =
        material(json!({"emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0, "texCoord": 1}})).unwrap();
    assert_eq!(textured.emission_texture, Some(0));
    let black = material(json!({"emissiveTexture": {"index": 0}})).unwrap();
    assert!(black.emission_texture.is_none() && !black.shines(), "the factor is black by default");
    let elsewhere = json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "emissiveFactor": [1, 1, 1],
        "emissiveTexture": {"index": 0, "texCoord": 1}});
    assert_eq!(material(elsewhere).unwrap().emission_texture, None, "it lies otherwise than the base colour");
    let unlit = material(json!({"emissiveFactor": [1, 1, 1], "extensions": {"KHR_materials_unlit": {}}})).unwrap();
    assert!(unlit.is_unlit && !unlit.shines());
    for (wrong, nearest) in [(-1.0, 0.0), (1e30, 1e12)] {
        let bright = material(json!({"emissiveFactor": [1, 1, 1], "extensions": strength(json!(wrong))})).unwrap();
        assert_eq!(bright.emission, [nearest; 3]);
    }
}

#[test]
fn orthographic_cameras_look_from_far_away() {
    let lens = |ymag: f32| {
        let lens = json!({"type": "orthographic", "orthographic": {"xmag": 1, "ymag": ymag, "zfar": 9, "znear": 1}});
        quad(|_| {
            json!({"materials": [{}], "cameras": [lens], "scenes": [{"nodes": [0, 1]}],
            "nodes": [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 5]}]})
        })
    };
    let scene = lens(0.5).unwrap();
    let camera = &scene.cameras[0];
    // At the middle of the scene the picture is a metre high.
    let distance = (scene.bounds.center() - camera.position_ws).dot(camera.forward_ws);
    let height = 2.0 * distance * (0.5 * camera.yfov_rad).tan();
    assert!((height - 1.0).abs() < 1e-4 && distance >= 32.0, "{height} at {distance}");
    // The near plane is a metre in front of the node, as in the file.
    let near = camera.position_ws.z - camera.near;
    assert!((near - 4.0).abs() < 1e-3, "{near}");
}

#[test]
fn a_scene_of_several_is_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scenes.glb");
    let mut parts = Parts::default();
    let position = parts.floats("VEC3", &QUAD);
    let mesh = json!([{"primitives": [{"attributes": {"POSITION": position}}]}]);
    let scenes = json!({"scene": 1, "scenes": [{"name": "day", "nodes": [0]}, {"name": "night", "nodes": [0, 1]},
        {"nodes": [0, 1, 2]}], "nodes": [{"mesh": 0}, {"mesh": 0}, {"mesh": 0}]});
    std::fs::write(&path, parts.glb(mesh, scenes)).unwrap();
    let triangles =
        |wanted: Option<&str>| load_scene(&path, wanted, &|_, _, _| {}).map(|scene| scene.indices.len() / 3);
    let one = triangles(Some("day")).unwrap();
    for (wanted, meshes) in [(None, 2), (Some("night"), 2), (Some("0"), 1), (Some("2"), 3)] {
        assert_eq!(triangles(wanted).unwrap(), meshes * one, "{wanted:?}");
    }
    for wanted in ["dusk", "3", "-1"] {
        let error = triangles(Some(wanted)).unwrap_err();
        assert_eq!(error.exit_code(), 2);
        assert!(error.to_string().ends_with("scenes.glb; its scenes are day, night, 2"), "{error}");
    }
}
