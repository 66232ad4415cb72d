//! Broken files: an error that names the fault, and never a panic.

use std::panic::{AssertUnwindSafe, catch_unwind};

use serde_json::{Value, json};

use super::tests::{Parts, QUAD, open};

/// A quad with everything the loader reads; `change` may spoil it.
fn spoiled(change: impl FnOnce(&mut Parts, &mut Value, &mut Value)) -> Vec<u8> {
    let mut parts = Parts::default();
    let position = parts.floats("VEC3", &QUAD);
    let normals = parts.floats("VEC3", &[0., 0., 1.].repeat(4));
    let uvs = parts.floats("VEC2", &[0.5; 8]);
    let indices = parts.indices(&[0, 1, 2, 1, 3, 2]);
    let mut png = std::io::Cursor::new(Vec::new());
    image::RgbImage::new(3, 3).write_to(&mut png, image::ImageFormat::Png).unwrap();
    let image = parts.view(&png.into_inner());
    let attributes = json!({"POSITION": position, "NORMAL": normals, "TEXCOORD_0": uvs});
    let mut meshes = json!([{"primitives": [{"attributes": attributes, "indices": indices, "material": 0}]}]);
    let mut extra = json!({
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0, "scale": [1, 2, 3]}, {"children": [2], "camera": 0},
            {"extensions": {"KHR_lights_punctual": {"light": 0}}}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "spot", "spot": {"outerConeAngle": 0.5}}]}},
        "images": [{"bufferView": image, "mimeType": "image/png"}], "textures": [{"source": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
    });
    change(&mut parts, &mut meshes, &mut extra);
    parts.glb(meshes, extra)
}

fn refused(wanted: &str, change: impl FnOnce(&mut Parts, &mut Value, &mut Value)) {
    let error = open(&spoiled(change)).err().unwrap_or_else(|| panic!("`{wanted}` was accepted")).to_string();
    assert!(error.starts_with("test.glb: ") && error.contains(wanted), "{error}");
    assert!(!error.contains('\n'), "{error}");
}

#[test]
fn faults_of_accessors_are_named() {
    refused("accessor 0 (mesh 0, primitive 0) with 5 elements reaches beyond", |p, _, _| {
        p.accessors[0]["count"] = json!(5);
    });
    refused("reaches beyond its buffer view", |p, _, _| p.accessors[0]["byteOffset"] = json!(u64::MAX));
    refused("reaches beyond its buffer view", |p, _, _| p.accessors[0]["count"] = json!(1u64 << 25));
    refused("more than 67108864 vertices", |p, _, _| p.accessors[0]["count"] = json!(u64::MAX));
    refused("buffer view 0 (48 bytes from byte 18446744073709551615)", |p, _, _| {
        p.views[0]["byteOffset"] = json!(u64::MAX);
    });
    refused("stride of 4 bytes for elements of 12", |p, _, _| p.views[0]["byteStride"] = json!(4));
    refused("type Vec2, not Vec3", |p, _, _| p.accessors[0]["type"] = json!("VEC2"));
    refused("unknown type", |p, _, _| p.accessors[0]["componentType"] = json!(5130));
    refused("indices of type I16", |p, _, _| p.accessors[3]["componentType"] = json!(5122));
    refused("buffer view 77, which does not exist", |p, _, _| p.accessors[0]["bufferView"] = json!(77));
    refused("without a buffer view", |p, _, _| {
        p.accessors[0] = json!({"componentType": 5126, "count": 1 << 25, "type": "VEC3"});
    });
    refused("sparse index 9 beyond its end", |p, _, _| {
        let (at, values) = (p.view(&[9, 0, 0, 0]), p.view(&[0; 12]));
        p.accessors[0]["sparse"] = json!({"count": 1, "indices": {"bufferView": at, "componentType": 5125},
            "values": {"bufferView": values}});
    });
    refused("with 9 elements reaches beyond", |p, _, _| {
        p.accessors[0]["sparse"] = json!({"count": 9, "indices": {"bufferView": 3, "componentType": 5121},
            "values": {"bufferView": 4}});
    });
    refused("has 3 normals for 4 positions", |p, _, _| p.accessors[1]["count"] = json!(3));
    refused("has the index 3 but only 3 vertices", |p, _, _| {
        [0, 1, 2].into_iter().for_each(|a| p.accessors[a]["count"] = json!(3));
    });
    refused("position that is not finite", |p, _, _| p.bin[..4].copy_from_slice(&f32::NAN.to_le_bytes()));
    refused("position that is not finite", |p, _, _| p.bin[..4].copy_from_slice(&3e38f32.to_le_bytes()));
}

#[test]
fn faults_of_structure_are_named() {
    refused("requires the extension EXT_texture_avif", |_, _, e| {
        e["extensionsRequired"] = json!(["EXT_texture_avif"]);
    });
    refused("node 1 is reached twice", |_, _, e| e["nodes"][2]["children"] = json!([1]));
    refused("node 9 does not exist", |_, _, e| e["nodes"][1]["children"] = json!([9]));
    refused("mesh 4 does not exist", |_, _, e| e["nodes"][0]["mesh"] = json!(4));
    refused("scene 4 does not exist", |_, _, e| e["scene"] = json!(4));
    refused("accessor 55 does not exist", |_, m, _| m[0]["primitives"][0]["indices"] = json!(55));
    refused("has no positions", |_, m, _| m[0]["primitives"][0]["attributes"] = json!({}));
    refused("no triangles", |_, m, _| m[0]["primitives"][0]["mode"] = json!(1));
    refused("node 0 has a transform that is not finite", |_, _, e| e["nodes"][0]["scale"] = json!([1e38, 1e39, 1]));
    refused("node 0 has a transform that is not finite", |_, _, e| e["nodes"][0]["rotation"] = json!([0, 0, 0, 0]));
    refused("JSON is broken", |_, _, e| e["nodes"] = json!(3));
}

/// Seventeen headers that announce a GiB each.
#[test]
fn textures_that_are_too_large_together_are_refused() {
    refused("its textures are 17 GiB of texels, and 16 are the most", |p, _, e| {
        let image = |i: u32| {
            let words = [u32::from_le_bytes(*b"DDS "), 124, 0, 16_384, 16_384, i];
            json!({"bufferView": p.view(&words.map(u32::to_le_bytes).concat()), "mimeType": "image/vnd-ms.dds"})
        };
        e["images"] = (0..17).map(image).collect();
        e["textures"] = (0..17).map(|i| json!({"source": i})).collect();
        let material = |i: u32| json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": i}}});
        e["materials"] = (0..17).map(material).collect();
    });
}

#[test]
fn missing_files_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let message = |text: &str| {
        let path = folder.path().join("scene.gltf");
        std::fs::write(&path, text).unwrap();
        super::load(&path, &|_, _, _| ()).err().unwrap().to_string()
    };
    let missing = message(r#"{"asset":{"version":"2.0"},"buffers":[{"uri":"gone.bin","byteLength":4}]}"#);
    assert!(missing.contains("scene.gltf: buffer 0, the file `gone.bin`, cannot be read: No such file"), "{missing}");
    let folder_instead = message(r#"{"asset":{"version":"2.0"},"buffers":[{"uri":".","byteLength":4}]}"#);
    assert!(folder_instead.contains("not a regular file"), "{folder_instead}");
    assert!(message("{").contains("JSON is broken"));
    assert!(message("").contains("it is empty"));
    let none = super::load(&folder.path().join("none.glb"), &|_, _, _| ()).err().unwrap().to_string();
    assert!(none.contains("none.glb: the scene file cannot be read"), "{none}");
}

fn survives(bytes: &[u8], what: &str) -> bool {
    catch_unwind(AssertUnwindSafe(|| open(bytes).is_ok())).unwrap_or_else(|_| panic!("panicked: {what}"))
}

#[test]
fn truncation_at_every_length_is_refused() {
    let glb = spoiled(|_, _, _| ());
    assert!(survives(&glb, "whole"));
    // Behind the last byte of the buffer there is padding.
    let padding = glb.iter().rev().take_while(|byte| **byte == 0).count();
    assert!(padding < 4);
    for length in 0..glb.len() - padding {
        assert!(!survives(&glb[..length], &format!("cut to {length}")), "cut to {length}");
    }
    assert!(survives(&glb[..glb.len() - padding], "without padding"));
}

#[test]
fn flipped_bytes_never_panic() {
    let glb = spoiled(|_, _, _| ());
    let mut state = 0x9e37_79b9_7f4a_7c15u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let mut accepted = 0;
    for round in 0..6000 {
        let mut bytes = glb.clone();
        for _ in 0..=random(3) {
            let at = random(bytes.len());
            // Digits become other digits, so that many changes get past the parser.
            bytes[at] = if bytes[at].is_ascii_digit() { b'0' + random(10) as u8 } else { random(256) as u8 };
        }
        accepted += u32::from(survives(&bytes, &format!("round {round}")));
    }
    assert!(accepted > 300, "only {accepted} changed files still load: the test no longer reaches the loader");
}
