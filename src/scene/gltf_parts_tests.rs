//! Parts of a file that are wrong and that its picture can do without: each is a line, and the rest is read.

use serde_json::{Value, json};

use super::tests::{Parts, QUAD, open, open_and_tell};
use super::*;
use crate::scene::sampling::Sampling;
use crate::scene::{Light, LitBy};

/// A quad with a camera, a lamp and a texture, all of which have names; `change` may spoil it.
fn file(change: impl FnOnce(&mut Value)) -> Vec<u8> {
    let mut parts = Parts::default();
    let attributes = json!({"POSITION": parts.floats("VEC3", &QUAD), "TEXCOORD_0": parts.floats("VEC2", &[0.5; 8])});
    let mut png = std::io::Cursor::new(Vec::new());
    image::RgbImage::new(3, 3).write_to(&mut png, image::ImageFormat::Png).unwrap();
    let image = parts.view(&png.into_inner());
    let mut all = json!({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0, 1, 2]}],
        "meshes": [{"name": "quad", "primitives": [{"attributes": attributes, "mode": 5, "material": 0}]}],
        "nodes": [{"mesh": 0}, {"name": "tripod", "camera": 0},
            {"name": "post", "extensions": {"KHR_lights_punctual": {"light": 0}}}],
        "cameras": [{"name": "eye", "type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
        "extensions": {"KHR_lights_punctual": {"lights": [{"name": "lamp", "type": "point", "intensity": 3}]}},
        "images": [{"name": "checks", "bufferView": image}], "samplers": [{"name": "s"}],
        "textures": [{"source": 0, "sampler": 0}],
        "materials": [{"name": "paint", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
    });
    change(&mut all);
    let meshes = all["meshes"].clone();
    parts.glb(meshes, all)
}

/// The file with another value at this JSON pointer, or without the value if there is none.
fn with(pointer: &str, value: &Value) -> Vec<u8> {
    file(|all| {
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        let parent = all.pointer_mut(parent).unwrap();
        match (value, key.parse::<usize>()) {
            (Value::Null, _) => drop(parent.as_object_mut().unwrap().remove(key)),
            (value, Ok(index)) => parent[index] = value.clone(),
            (value, _) => parent[key] = value.clone(),
        }
    })
}

/// Reads it so, with this as all that is said.
#[track_caller]
fn told(pointer: &str, value: &Value, sentence: &str) -> Scene {
    let (scene, said) = open_and_tell(&with(pointer, value)).unwrap_or_else(|e| panic!("{pointer} {value}: {e}"));
    assert_eq!(said, [format!("test.glb: {sentence}")], "{pointer} {value}");
    assert_eq!(scene.indices.len(), 6);
    scene
}

#[test]
fn the_whole_file_has_all_of_it() {
    let (scene, said) = open_and_tell(&file(|_| ())).unwrap();
    assert_eq!(said, [""; 0]);
    assert_eq!((scene.cameras[0].name.as_str(), scene.lit_by, scene.textures.len()), ("tripod", LitBy::Lights, 1));
}

#[test]
fn a_camera_that_cannot_be_used_is_left_out() {
    let lens = |lens: Value| json!({"name": "plan", "type": "orthographic", "orthographic": lens});
    let perspective = "/cameras/0/perspective";
    for (pointer, value, why) in [
        (perspective, json!({"znear": 1}), "perspective: missing field `yfov`"),
        (perspective, json!({"yfov": 1}), "perspective: missing field `znear`"),
        (perspective, json!({"yfov": 0, "znear": 1}), "its field of view is 0, not within 0 and pi"),
        (perspective, json!({"yfov": 4, "znear": 1}), "its field of view is 4, not within 0 and pi"),
        (
            perspective,
            json!({"yfov": "1", "znear": 1}),
            "perspective: perspective.yfov: invalid type: string \"1\", expected f32",
        ),
        (perspective, Value::Null, "it has no lens of its type"),
        ("/cameras/0/type", json!("fisheye"), "its type is neither perspective nor orthographic"),
        ("/cameras/0/type", Value::Null, "missing field `type`"),
    ] {
        let scene = told(pointer, &value, &format!("camera 0 (`eye`) is left out: {why}"));
        assert_eq!(scene.cameras[0].name, "default", "{value}");
    }
    for (value, why) in [
        (lens(json!({"xmag": 1, "ymag": 1, "znear": 0})), "orthographic: missing field `zfar`"),
        (lens(json!({"ymag": 1, "znear": 0, "zfar": 1})), "orthographic: missing field `xmag`"),
        (lens(json!({"xmag": 1, "ymag": 0, "znear": 0, "zfar": 1})), "its ymag is 0: no picture has that height"),
    ] {
        told("/cameras/0", &value, &format!("camera 0 (`plan`) is left out: {why}"));
    }
    told("/cameras/0", &json!(3), "camera 0 is left out: invalid type: integer `3`, expected struct Camera");
    let lost = "node 1 (`tripod`) is read without its camera: ";
    told("/nodes/1/camera", &json!(4), &format!("{lost}camera 4 does not exist"));
    told(
        "/nodes/1/camera",
        &json!("a"),
        &format!("{lost}invalid type: string \"a\", expected index into child of root"),
    );
    let at = json!({"yfov": 0.8, "znear": 0});
    let scene = told(perspective, &at, "camera 0 (`eye`) has a znear that is not above 0: it is 0.01 m instead");
    assert_eq!((scene.cameras[0].name.as_str(), scene.cameras[0].near), ("tripod", 0.01));
}

/// The camera that can be used is there, whatever the other lacks, and one line tells of it.
#[test]
fn other_cameras_stay() {
    let broken = json!({"name": "plan", "type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": 0}});
    let glb = file(|all| {
        all["cameras"].as_array_mut().unwrap().insert(0, broken);
        all["nodes"] = json!([{"mesh": 0}, {"camera": 0}, {"camera": 1, "name": "second"}]);
    });
    let (scene, said) = open_and_tell(&glb).unwrap();
    assert_eq!(said, ["test.glb: camera 0 (`plan`) is left out: orthographic: missing field `zfar`"]);
    assert_eq!(scene.cameras.iter().map(|camera| camera.name.as_str()).collect::<Vec<_>>(), ["second"]);
}

#[test]
fn a_light_that_cannot_be_used_is_left_out() {
    let light = |key: &str| format!("/extensions/KHR_lights_punctual/lights/0/{key}");
    let power = "its intensity or its colour is negative or not finite";
    for (key, value, why) in [
        ("type", Value::Null, "missing field `type`"),
        ("type", json!("area"), "its type is neither directional nor point nor spot"),
        ("intensity", json!(-1), power),
        ("intensity", json!(1e39), power),
        ("color", json!([1, -1, 0]), power),
    ] {
        let scene = told(&light(key), &value, &format!("light 0 (`lamp`) is left out: {why}"));
        assert_eq!(scene.lit_by, LitBy::Nothing, "{key} {value}");
    }
    let without = |part: &str, why: &str| format!("light 0 (`lamp`) is read without its {part}: {why}");
    let text = "invalid type: string \"x\", expected f32";
    for (key, value, sentence) in [
        ("color", json!([1, 1]), without("color", "invalid length 2, expected an array of length 3")),
        ("range", json!("x"), without("range", text)),
        ("spot", json!({"outerConeAngle": "x"}), without("spot.outerConeAngle", text)),
    ] {
        let scene = told(&light(key), &value, &sentence);
        assert_eq!(scene.lights, [Light::Point { position_ws: Vec3::ZERO, intensity: Vec3::splat(3.0) }]);
    }
    let spot = json!({"name": "lamp", "type": "spot", "spot": {"outerConeAngle": 9}});
    let has = "light 0 (`lamp`) has cone angles that no spot light has: the nearest are taken";
    told("/extensions/KHR_lights_punctual/lights/0", &spot, has);
    let lost = "node 2 (`post`) is read without its light: ";
    let node = "/nodes/2/extensions/KHR_lights_punctual";
    told(node, &json!({"light": 5}), &format!("{lost}light 5 does not exist"));
    told(node, &json!({}), &format!("{lost}it does not say which"));
    told("/extensions", &json!({}), &format!("{lost}light 0 does not exist"));
    let whole = "extensions.KHR_lights_punctual: invalid type: integer `3`, expected struct KhrLightsPunctual";
    told(node, &json!(3), &format!("node 2 (`post`) is read without its {whole}"));
}

#[test]
fn a_sampler_has_what_is_usual_instead() {
    let instead = "sampler 0 (`s`) has an unknown filter or wrap mode: it is linear, or repeats, instead";
    for (key, value) in [("magFilter", 1), ("minFilter", 9), ("wrapS", 5), ("wrapT", 33069)] {
        let scene = told(&format!("/samplers/0/{key}"), &json!(value), instead);
        assert_eq!(scene.materials[0].base_color_sampling, Sampling::default());
    }
    let why = "invalid type: string \"LINEAR\", expected any of: [9728, 9729]";
    let named = format!("sampler 0 (`s`) is read without its magFilter: {why}");
    assert_eq!(told("/samplers/0/magFilter", &json!("LINEAR"), &named).textures.len(), 1);
    told("/textures/0/sampler", &json!(9), "texture 0 is read without its sampler: sampler 9 does not exist");
}

#[test]
fn a_material_has_the_nearest_factors() {
    let color = "/materials/0/pbrMetallicRoughness/baseColorFactor";
    let outside = "material 0 (`paint`) has a base colour that is not within 0 and 1: the nearest is taken";
    for (given, nearest) in [([2.0, -1.0, 0.5, 1.0], [1.0, 0.0, 0.5, 1.0]), ([1e39, 1.0, 1.0, 1.0], [1.0; 4])] {
        assert_eq!(told(color, &json!(given), outside).materials[0].base_color, nearest);
    }
    let (_, said) = open_and_tell(&with(color, &json!([1.000_001, 1, 1, 1]))).unwrap();
    assert_eq!(said, [""; 0], "rounded");
    for (key, value, has) in [
        ("emissiveFactor", json!([-1, 0, 0]), "has an emission that is negative or above 1e12: the nearest is taken"),
        ("emissiveFactor", json!([1e39, 0, 0]), "has an emission that is negative or above 1e12: the nearest is taken"),
        ("alphaMode", json!("CLIP"), "has an unknown alphaMode: it is opaque instead"),
        (
            "normalTexture",
            json!({"index": 0, "scale": 1e39}),
            "has a normal map whose scale is not finite: it is 1 instead",
        ),
        ("normalTexture", json!({"index": 3}), "is read without texture 3, which does not exist"),
        ("normalTexture", json!({}), "is read without its normalTexture: missing field `index`"),
        ("alphaCutoff", json!("x"), "is read without its alphaCutoff: invalid type: string \"x\", expected f32"),
        ("doubleSided", json!(1), "is read without its doubleSided: invalid type: integer `1`, expected a boolean"),
        (
            "emissiveFactor",
            json!([1]),
            "is read without its emissiveFactor: invalid length 1, expected an array of length 3",
        ),
        (
            "extensions",
            json!({"KHR_materials_emissive_strength": {"emissiveStrength": "x"}}),
            "has a broken KHR_materials_emissive_strength, which is ignored: invalid type: string \"x\", expected f32",
        ),
        (
            "extensions",
            json!({"KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [1, 2]}}),
            "has a broken KHR_materials_pbrSpecularGlossiness, which is ignored: invalid length 2, expected an array of \
             length 4",
        ),
    ] {
        told(&format!("/materials/0/{key}"), &value, &format!("material 0 (`paint`) {has}"));
    }
    let cutoff = json!([{"name": "paint", "alphaMode": "MASK", "alphaCutoff": -2}]);
    let has = "material 0 (`paint`) has an alphaCutoff that is negative or not finite: it is 0.5 instead";
    assert_eq!(told("/materials", &cutoff, has).materials[0].alpha_cutoff, Some(0.5));
    let transform = "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions";
    let has = "material 0 (`paint`) has a texture transform that is not finite, which is ignored";
    told(transform, &json!({"KHR_texture_transform": {"scale": [1e39, 1]}}), has);
    let has = "mesh 0 (`quad`) has the default material, as material 7 does not exist";
    let scene = told("/meshes/0/primitives/0/material", &json!(7), has);
    assert_eq!(scene.materials[scene.triangle_materials[0] as usize].name, "default");
}

#[test]
fn a_texture_that_cannot_be_read_is_left_out() {
    let image = "/images/0";
    for (value, why) in [
        (json!({"uri": "a.png"}), "image 0 is the external file `a.png`, which a scene in memory lacks"),
        (json!({"uri": "http://a/a.png"}), "image 0 is at `http://a/a.png`: only files and data URIs can be read"),
        (json!({"uri": "data:;base64,@"}), "the data URI of image 0 is not base64: Invalid symbol 64, offset 0."),
        (json!({"uri": "data:,a"}), "`image 0` is unreadable: it is neither png nor jpeg, webp, dds or ktx2"),
        (json!({"bufferView": 0}), "`image 0` is unreadable: it is neither png nor jpeg, webp, dds or ktx2"),
        (json!({"bufferView": 77}), "image 0 refers to buffer view 77, which does not exist"),
        (json!({}), "image 0 has neither a uri nor a buffer view"),
    ] {
        let (scene, said) = open_and_tell(&with(image, &value)).unwrap();
        let start = format!("test.glb: texture {why}");
        assert!(said.len() == 1 && (said[0].starts_with(&start) || said[0].contains(why)), "{said:?}");
        assert!(scene.textures.is_empty() && said[0].ends_with("; it is left out"), "{said:?}");
    }
    told("/textures/0/source", &json!(3), "texture 0 is read without image 3, which does not exist");
    // What would shine through its texture does not shine without it.
    let glb = file(|all| {
        all["images"][0] = json!({});
        all["materials"][0] = json!({"emissiveFactor": [5, 5, 5], "emissiveTexture": {"index": 0}});
    });
    assert_eq!(open(&glb).unwrap().materials[0].emission, [0.0; 3]);
    let glb = file(|all| {
        all["images"] = (0..9).map(|i| json!({"uri": format!("{i}.png")})).collect();
        all["textures"] = (0..9).map(|i| json!({"source": i})).collect();
        let material = |i: u32| json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": i}}});
        all["materials"] = (0..9).map(material).collect();
    });
    let (_, said) = open_and_tell(&glb).unwrap();
    assert_eq!((said.len(), said[4].as_str()), (5, "test.glb: 5 more textures cannot be read"));
}

#[test]
fn what_is_no_part_of_the_picture_may_be_anything() {
    for (pointer, value) in [
        ("/accessors/0/min", json!("x")),
        ("/accessors/0/max", json!([1])),
        ("/accessors/0/min", json!([9, 9, 9])),
        ("/materials/0/pbrMetallicRoughness/roughnessFactor", json!(-3)),
    ] {
        let glb = file(|_| ());
        let at = pointer.strip_prefix("/accessors/0/");
        let glb = at.map_or_else(|| with(pointer, &value), |key| with_bounds(&glb, key, &value));
        let (scene, said) = open_and_tell(&glb).unwrap();
        assert!(said.is_empty() && scene.indices.len() == 6, "{pointer}: {said:?}");
    }
    let none = "is read without its channels: missing field `samplers`";
    let (_, said) = open_and_tell(&with("/animations", &json!([{"name": "walk", "channels": []}]))).unwrap();
    assert_eq!(said, ["test.glb: animation 0 (`walk`) is left out: missing field `samplers`"], "{none}");
    let text = "invalid type: map, expected a string";
    for (pointer, sentence) in [
        ("/nodes/0/name", format!("node 0 is read without its name: {text}")),
        ("/materials/0/name", format!("material 0 is read without its name: {text}")),
        ("/asset/generator", format!("the file is read without its asset.generator: {text}")),
        ("/cameras", "the file is read without its cameras: it is no list".to_owned()),
    ] {
        let (_, said) = open_and_tell(&with(pointer, &json!({}))).unwrap();
        assert_eq!(said[0], format!("test.glb: {sentence}"));
    }
    let shown = json!({"KHR_node_visibility": {"visible": "no"}});
    let why = "invalid type: string \"no\", expected a boolean";
    let has = format!("node 0 has a broken KHR_node_visibility, which is ignored: {why}");
    told("/nodes/0/extensions", &shown, &has);
}

/// The GLB with this as a bound of its first accessor.
fn with_bounds(glb: &[u8], key: &str, value: &Value) -> Vec<u8> {
    let end = 20 + u32::from_le_bytes([glb[12], glb[13], glb[14], glb[15]]) as usize;
    let mut all: Value = serde_json::from_slice(&glb[20..end]).unwrap();
    all["accessors"][0][key] = value.clone();
    crate::scene::testing::glb_from(&all.to_string(), &glb[end + 8..])
}

/// Of many with the same fault the first is named.
#[test]
fn a_fault_of_many_is_one_line() {
    let material = json!({"name": "m", "emissiveFactor": [1]});
    let glb = file(|all| all["materials"] = json!(vec![material; 4000]));
    let begin = std::time::Instant::now();
    let (_, said) = open_and_tell(&glb).unwrap();
    let why = "invalid length 1, expected an array of length 3";
    assert_eq!(
        said,
        [format!("test.glb: material 0 (`m`) is read without its emissiveFactor: {why} (3999 more of this kind)")]
    );
    assert!(begin.elapsed().as_secs() < 10);
}

/// The geometry cannot be spared, and the message is that of the parser.
#[test]
fn what_cannot_be_spared_is_refused() {
    for (pointer, value, place) in [
        ("/nodes/0/mesh", json!("a"), "nodes[0].mesh: invalid type: string"),
        ("/nodes/0/scale", json!([1, 1]), "nodes[0].scale: invalid length 2"),
        ("/meshes/0/primitives", Value::Null, "meshes[0]: missing field `primitives`"),
        ("/nodes", json!({}), "nodes: invalid type: map"),
    ] {
        let alone = open(&with(pointer, &value)).err().unwrap().to_string();
        assert!(alone.starts_with(&format!("test.glb: the glTF JSON is broken: {place}")), "{alone}");
        assert!(alone.contains(" at line 1 column "), "{alone}");
        // Beside what can be.
        let glb = file(|all| {
            all["cameras"] = json!([3]);
            let (parent, key) = pointer.rsplit_once('/').unwrap();
            let parent = if parent.is_empty() { all } else { all.pointer_mut(parent).unwrap() };
            parent[key] = value.clone();
        });
        let both = open(&glb).err().unwrap().to_string();
        assert!(both.starts_with("test.glb: the glTF JSON is broken: "), "{both}");
    }
}
