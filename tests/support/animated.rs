//! Animations in glTF documents.

use gridlight::scene::{Scene, gltf};
use serde_json::{Value, json};

/// Loads the scene of a GLB file whose first animation plays, at its beginning.
pub fn playing(glb: &[u8]) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("playing.glb");
    std::fs::write(&path, glb).unwrap();
    let mut scene = gltf::load(&path, &|_: &str, _, _| ()).unwrap();
    scene.play(None).unwrap();
    scene.pose(0.0);
    scene
}

/// Lets a node go along x for four seconds, by a metre a second.
pub fn slide(document: &mut Value, bin: &mut Vec<u8>, node: usize) {
    let place = |axis: usize| document["nodes"][node]["translation"][axis].as_f64().unwrap() as f32;
    let [x, y, z] = [0, 1, 2].map(place);
    let numbers = [0.0_f32, 4.0, x, y, z, x + 4.0, y, z];
    let offset = bin.len();
    bin.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    let list = |document: &mut Value, key: &str, value: Value| {
        let list = document[key].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    };
    let view = |offset: usize, bytes: usize| json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes});
    let accessor =
        |view: usize, kind: &str| json!({"bufferView": view, "componentType": 5126, "count": 2, "type": kind});
    let times = list(document, "bufferViews", view(offset, 8));
    let places = list(document, "bufferViews", view(offset + 8, 24));
    let input = list(document, "accessors", accessor(times, "SCALAR"));
    let output = list(document, "accessors", accessor(places, "VEC3"));
    document["animations"] = json!([{
        "name": "slide", "samplers": [{"input": input, "output": output}],
        "channels": [{"sampler": 0, "target": {"node": node, "path": "translation"}}]
    }]);
    document["buffers"][0]["byteLength"] = json!(bin.len());
}
