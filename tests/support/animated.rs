//! Animations in glTF documents, and pictures of them.

use std::path::Path;

use gridlight::files::pictures::read_exr;
use gridlight::scene::{Scene, gltf};
use serde_json::{Value, json};

use super::{floats, quad_glb, succeed};

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
    let input = floats(document, bin, "SCALAR", &[0.0, 4.0]);
    let output = floats(document, bin, "VEC3", &[x, y, z, x + 4.0, y, z]);
    document["animations"] = json!([{
        "name": "slide", "samplers": [{"input": input, "output": output}],
        "channels": [{"sampler": 0, "target": {"node": node, "path": "translation"}}]
    }]);
}

/// A floor, a screen and a lamp above them, of which one node is carried along x.
pub fn carried(node: usize) -> Scene {
    let glb = quad_glb(|document, bin| {
        let lamp = json!({"type": "point", "intensity": 40.0});
        document["extensions"] = json!({"KHR_lights_punctual": {"lights": [lamp]}});
        document["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.9, "znear": 0.05}}]);
        document["nodes"] = json!([
            {"mesh": 0},
            {"mesh": 0, "scale": [0.3, 0.3, 0.3], "translation": [0.5, 0.2, 0.0]},
            {"extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [0.0, 1.8, 0.9]},
            {"camera": 0, "translation": [0.0, 1.0, 4.5]}
        ]);
        document["scenes"][0]["nodes"] = json!([0, 1, 2, 3]);
        slide(document, bin, node);
    });
    playing(&glb)
}

/// Renders a small picture into a file of the folder, without a message of validation.
pub fn render(folder: &Path, scene: &Path, options: &str, picture: &str) {
    let options = format!("--headless --quiet --validation --size 64x36 --vpls 2000 {options}");
    let mut arguments: Vec<String> = options.split_whitespace().map(str::to_owned).collect();
    arguments.extend([scene, Path::new("--output"), &folder.join(picture)].map(|p| p.to_str().unwrap().to_owned()));
    succeed(&arguments);
}

/// Red, green and blue of all pixels of a file of the folder: finite, and not below 0.
pub fn pixels(folder: &Path, picture: &str) -> Vec<f32> {
    let (_, _, rgb) = read_exr(folder.join(picture)).unwrap();
    assert!(rgb.iter().all(|value| value.is_finite() && *value >= 0.0), "{picture}");
    rgb
}
