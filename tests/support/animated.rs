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

/// Screens in rows over a floor, before a lamp, and change places with each other in two seconds.
pub fn screens_that_change_places() -> Scene {
    const SCREENS: usize = 64;
    let place = |at: usize| [0.7 * (at % 8) as f32 - 2.5, 0.3 + 0.35 * (at / 8) as f32, 0.1 * (at % 3) as f32];
    let glb = quad_glb(|document, bin| {
        document["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 40.0}]}});
        document["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.9, "znear": 0.05}}]);
        let mut nodes = vec![
            json!({"mesh": 0}),
            json!({"extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [0.0, 1.8, 1.5]}),
            json!({"camera": 0, "translation": [0.0, 1.4, 4.5]}),
        ];
        let (mut samplers, mut channels) = (Vec::new(), Vec::new());
        let input = floats(document, bin, "SCALAR", &[0.0, 2.0]);
        for screen in 0..SCREENS {
            // 27 and 64 have no divisor in common.
            let output = floats(document, bin, "VEC3", &[place(screen), place(27 * screen % SCREENS)].concat());
            samplers.push(json!({"input": input, "output": output}));
            channels.push(json!({"sampler": screen, "target": {"node": nodes.len(), "path": "translation"}}));
            let upright = [std::f64::consts::FRAC_1_SQRT_2, 0.0, 0.0, std::f64::consts::FRAC_1_SQRT_2];
            nodes.push(json!({"mesh": 0, "scale": [0.2, 0.2, 0.2], "rotation": upright, "translation": place(screen)}));
        }
        document["scenes"][0]["nodes"] = (0..nodes.len()).collect();
        document["nodes"] = nodes.into();
        document["animations"] = json!([{"samplers": samplers, "channels": channels}]);
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
