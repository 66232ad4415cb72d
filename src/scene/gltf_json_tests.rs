//! JSON as the specification of glTF has it, field by field.

use std::path::Path;

use serde_json::{Value, json};

use super::*;
use crate::scene::gltf_lenient::NO_INDEX;

fn read(text: &str) -> Result<Root> {
    parse(Path::new("a.gltf"), text.as_bytes()).map(|parsed| parsed.root)
}

fn error(text: &str) -> String {
    read(text).err().unwrap_or_else(|| panic!("accepted: {text}")).to_string()
}

/// A glTF in which every object of the specification has every one of its fields.
fn complete() -> Value {
    json!({
        "asset": {"version": "2.0", "minVersion": "2.0", "generator": "g", "copyright": "c"},
        "extensionsUsed": ["KHR_lights_punctual", "X_more"], "extensionsRequired": ["KHR_lights_punctual"],
        "accessors": [{"bufferView": 1, "byteOffset": 4, "componentType": 5126, "count": 3, "type": "VEC3", "name": "a",
            "normalized": false, "min": [0, 0, 0], "max": [1, 1, 1],
            "sparse": {"count": 1, "indices": {"bufferView": 0, "byteOffset": 8, "componentType": 5125},
                "values": {"bufferView": 1, "byteOffset": 12}}}],
        "animations": [{"name": "b", "channels": [{"sampler": 0, "target": {"node": 1, "path": "rotation"}}],
            "samplers": [{"input": 0, "output": 2, "interpolation": "STEP"}]}],
        "buffers": [{"byteLength": 64, "uri": "x.bin", "name": "c"}],
        "bufferViews": [{"buffer": 0, "byteOffset": 16, "byteLength": 32, "byteStride": 12, "target": 34962}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": 2, "zfar": 3, "aspectRatio": 4}},
            {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 2, "zfar": 3, "znear": 4}}],
        "images": [{"bufferView": 3, "mimeType": "image/png"}],
        "materials": [{"alphaCutoff": 1, "alphaMode": "MASK", "doubleSided": true, "emissiveFactor": [1, 0, 1],
            "emissiveTexture": {"index": 1, "texCoord": 2}, "normalTexture": {"index": 2, "texCoord": 1, "scale": 3},
            "occlusionTexture": {"index": 3, "texCoord": 4, "strength": 1},
            "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 0, 1], "baseColorTexture": {"index": 4, "texCoord": 5},
                "metallicFactor": 1, "roughnessFactor": 0, "metallicRoughnessTexture": {"index": 5, "texCoord": 6}}}],
        "meshes": [{"weights": [1, 0], "primitives": [{"attributes": {"POSITION": 7, "TEXCOORD_1": 8, "_OWN": 9},
            "indices": 10, "material": 11, "mode": 5, "targets": [{"POSITION": 12, "NORMAL": 13, "TANGENT": 14}]}]}],
        "nodes": [{"camera": 1, "children": [2, 3], "mesh": 4, "skin": 5, "weights": [1], "matrix": vec![1; 16],
            "rotation": [0, 0, 0, 1], "scale": [1, 2, 3], "translation": [4, 5, 6], "name": "d",
            "extensions": {"KHR_lights_punctual": {"light": 6}, "X_more": {"count": 7}}}],
        "samplers": [{"magFilter": 9728, "minFilter": 9987, "wrapS": 33071, "wrapT": 33648}],
        "scene": 1, "scenes": [{"name": "e", "nodes": [0]}],
        "skins": [{"inverseBindMatrices": 3, "joints": [1, 2], "skeleton": 4}],
        "textures": [{"sampler": 5, "source": 6}],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "spot", "color": [1, 0, 1], "intensity": 2, "range": 3,
            "spot": {"innerConeAngle": 0, "outerConeAngle": 1}}]}, "X_more": [8]},
    })
}

/// Everything that was read, in the crate's own words.
fn told(text: &str) -> String {
    format!("{:#?}", read(text).unwrap())
}

/// The JSON text with every number written by `number`, and every object begun by `begin`.
fn written(value: &Value, number: &dyn Fn(&serde_json::Number) -> String, begin: &str) -> String {
    match value {
        Value::Number(value) => number(value),
        Value::Array(list) => {
            let items: Vec<String> = list.iter().map(|item| written(item, number, begin)).collect();
            format!("[{}]", items.join(","))
        }
        Value::Object(object) => {
            let items = object.iter().map(|(key, item)| format!("{}:{}", json!(key), written(item, number, begin)));
            let begin = Some(begin.to_owned()).filter(|begin| !begin.is_empty());
            let items: Vec<String> = begin.into_iter().chain(items).collect();
            format!("{{{}}}", items.join(","))
        }
        other => other.to_string(),
    }
}

/// Without the numbers of unknown extensions, which stay as they are written.
fn known(mut value: Value) -> Value {
    value["nodes"][0]["extensions"]["X_more"] = json!({});
    value["extensions"]["X_more"] = json!([]);
    value
}

#[test]
fn integers_may_be_written_as_any_number() {
    let document = known(complete());
    let plain = told(&document.to_string());
    let with_point = |number: &serde_json::Number| format!("{number}.0");
    let with_exponent = |number: &serde_json::Number| {
        if number.as_f64() == Some(0.0) { "0e5".to_owned() } else { format!("{number}0.00E-1") }
    };
    for number in [&with_point as &dyn Fn(&serde_json::Number) -> String, &with_exponent] {
        let text = written(&document, number, "");
        assert_eq!(told(&text).replace(".0", ""), plain.replace(".0", ""), "{text}");
    }
}

#[test]
fn extras_may_be_anything_anywhere() {
    let document = complete();
    let plain = told(&document.to_string());
    for extras in ["null", "1.5", "\"text\"", "[[{\"nodes\":3}]]", "{\"extras\":{\"extras\":[]}}", "true", "1e300"] {
        let text = written(&document, &ToString::to_string, &format!("\"extras\":{extras}"));
        assert!(text.matches("extras").count() >= 40, "{text}");
        assert_eq!(told(&text), plain, "{extras}");
    }
}

#[test]
fn what_is_optional_may_be_missing() {
    let root = read(r#"{"asset":{"version":"2.0"},"scenes":[{},{"name":"b","extras":1}],"animations":[{
        "channels":[{"sampler":0,"target":{"path":"pointer","extensions":{"KHR_animation_pointer":{"pointer":"/nodes/0"}}}}],
        "samplers":[{"input":0,"output":1}]}]}"#)
    .unwrap();
    assert!(root.scenes.iter().all(|scene| scene.nodes.is_empty()) && root.scenes.len() == 2);
    let target = &root.animations[0].channels[0].target;
    assert_eq!(target.node.value(), NO_INDEX as usize);
}

#[test]
fn null_is_a_key_that_is_not_there() {
    let blanked = |text: &str| String::from_utf8(without_nulls(text.as_bytes()).into_owned()).unwrap();
    for (text, wanted) in [
        (r#"{"a":1}"#, r#"{"a":1}"#),
        (r#"{"a":null}"#, r#"{        }"#),
        (r#"{"a": null,"b":[null, "x\\\":null"]}"#, r#"{          "b":[null, "x\\\":null"]}"#),
        (r#"{"b":1 , "a" : null }"#, r#"{"b":1              }"#),
        (r#"{"a":null,"b":null,"c":{"d":2,"e":null}}"#, r#"{                  "c":{"d":2         }}"#),
        (r#"{"a":nullx}"#, r#"{"a":nullx}"#),
        (r#"[null,"null",null]"#, r#"[null,"null",null]"#),
        ("{\"a", "{\"a"),
        ("{\"a\\", "{\"a\\"),
        ("null", "null"),
    ] {
        assert_eq!(blanked(text), wanted, "{text}");
    }
    let plain =
        r#"{"asset":{"version":"2.0"},"materials":[{}],"meshes":[{"primitives":[{"attributes":{}}]}],"nodes":[{}]}"#;
    let nulls = plain
        .replace("[{}]", r#"[{"emissiveFactor":null,"alphaMode":null,"matrix":null,"name":null,"extras":null}]"#)
        .replace(r#""attributes":{}"#, r#""mode":null,"attributes":{},"indices":null"#);
    assert_eq!(told(&nulls), told(plain));
    assert!(error(&nulls.replace(r#""attributes":{}"#, r#""attributes":null"#)).contains("missing field `attributes`"));
}

#[test]
fn what_is_wrong_is_named_with_its_place() {
    let with = |key: &str, value: Value| {
        let mut document = complete();
        document[key] = value;
        error(&document.to_string())
    };
    for (message, place) in [
        (with("nodes", json!([{"mesh": 0.5}])), "nodes[0].mesh: invalid type: floating point `0.5`"),
        (with("nodes", json!([{}, {"children": [0, -1]}])), "nodes[1].children[1]: invalid type: integer `-1`"),
        (with("scene", json!(4_294_967_296u64)), "scene: the integer 4294967296 is too large"),
        (with("accessors", json!([{"count": 1}])), "missing field `componentType`"),
        (with("buffers", json!([{"byteLength": "12"}])), "buffers[0].byteLength: invalid type: string"),
        (with("meshes", json!({"a": 1})), "meshes: invalid type: map"),
    ] {
        assert!(message.starts_with("a.gltf: the glTF JSON is broken: "), "{message}");
        assert!(message.contains(place), "{message}");
    }
    assert!(error("{\"asset\":").contains("the glTF JSON is broken: EOF"));
}

#[test]
fn sizes_may_pass_32_bits() {
    let mut document = complete();
    document["buffers"][0]["byteLength"] = json!(5_000_000_000u64);
    assert_eq!(read(&document.to_string()).unwrap().buffers[0].byte_length.0, 5_000_000_000);
}

#[test]
fn the_version_is_looked_at_first() {
    let of = |asset: Value| error(&json!({"asset": asset, "scene": "main", "nodes": {"a": {}}}).to_string());
    assert_eq!(of(json!({"version": "1.0"})), "a.gltf: it is of glTF version 1.0; only version 2 can be read");
    assert_eq!(of(json!({"version": 1.1})), "a.gltf: it is of glTF version 1.1; only version 2 can be read");
    assert_eq!(of(json!({"version": "3.0"})), "a.gltf: it is of glTF version 3.0; only version 2 can be read");
    assert_eq!(of(json!({"version": "x"})), "a.gltf: it is of glTF version x; only version 2 can be read");
    assert_eq!(of(json!({})), "a.gltf: it has no asset.version, which every glTF has");
    assert_eq!(of(json!("2.0")), "a.gltf: it has no asset.version, which every glTF has");
    let later = of(json!({"version": "2.1", "minVersion": "2.1"}));
    assert_eq!(later, "a.gltf: it needs a reader of glTF version 2.1; version 2.0 is what can be read");
    for asset in [json!({"version": "2.0"}), json!({"version": 2.0}), json!({"version": "2.1", "minVersion": "2.0"})] {
        assert!(read(&json!({"asset": asset}).to_string()).is_ok(), "{asset}");
    }
}

#[test]
fn required_extensions_are_looked_at_before_the_rest() {
    let text = json!({"asset": {"version": "2.0"}, "extensionsRequired": ["X_first", 3], "nodes": 7}).to_string();
    assert_eq!(error(&text), "a.gltf: it requires the extension X_first, which is not supported");
}
