//! What a run says on stderr of lights that its picture lacks.

mod support;

use std::path::{Path, PathBuf};

use gridlight::files::pictures::read_exr;
use serde_json::{Value, json};
use support::{Run, program, quad_glb, run};

/// A scene of the quad, four metres wide and looking up, at these places, under a lamp at this height.
fn under_a_lamp(folder: &Path, height: f64, albedo: f64, places: &[Value]) -> PathBuf {
    let glb = quad_glb(|document, _| {
        let lamp = json!({"type": "point", "intensity": 1000.0});
        document["extensions"] = json!({"KHR_lights_punctual": {"lights": [lamp]}});
        let color = [albedo, albedo, albedo, 1.0];
        document["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!(color);
        let mut nodes = places.to_vec();
        nodes.iter_mut().for_each(|node| node["mesh"] = json!(0));
        nodes.push(json!({"translation": [0, height, 0], "extensions": {"KHR_lights_punctual": {"light": 0}}}));
        document["scenes"][0]["nodes"] = json!((0..nodes.len()).collect::<Vec<_>>());
        document["nodes"] = json!(nodes);
    });
    let path = folder.join("scene.glb");
    std::fs::write(&path, glb).unwrap();
    path
}

fn render(folder: &Path, scene: &Path, options: &str) -> Run {
    let mut command = program();
    command.arg(scene).args(["--headless", "--size", "32x18"]).args(options.split_whitespace());
    command.arg("--output").arg(folder.join("a.exr")).arg("--timings").arg(folder.join("a.json"));
    let run = run(command);
    assert_eq!(run.code, Some(0), "{options}: {}", run.stderr);
    let (_, _, rgb) = read_exr(folder.join("a.exr")).unwrap();
    assert!(rgb.iter().all(|v| v.is_finite() && *v >= 0.0), "{options}");
    run
}

/// A count of the last run's timings.
fn count(folder: &Path, key: &str) -> u64 {
    let json: Value = serde_json::from_slice(&std::fs::read(folder.join("a.json")).unwrap()).unwrap();
    json["counts"][key].as_u64().unwrap()
}

#[test]
fn paths_that_hardly_ever_hit_are_told() {
    let folder = tempfile::tempdir().unwrap();
    // Of the lamp's light one part in 300 meets the floor, and the paths are what is limited.
    let scene = under_a_lamp(folder.path(), 20.0, 0.5, &[json!({})]);
    for technique in ["lgh", "brute-force"] {
        let run = render(folder.path(), &scene, &format!("--technique {technique} --vpls 1000"));
        let (paths, vpls) = (count(folder.path(), "paths"), count(folder.path(), "vpls"));
        assert!((1..500).contains(&vpls), "{technique}: {vpls}");
        let sentence =
            format!("{paths} were traced and left {vpls} virtual point lights, fewer than --vpls asks for\n");
        assert!(run.stderr.contains("hardly any light path hits the scene"), "{technique}: {}", run.stderr);
        assert!(run.stderr.ends_with(&sentence) && run.stderr.lines().count() == 1, "{technique}: {}", run.stderr);
    }
    let near = under_a_lamp(folder.path(), 1.0, 0.5, &[json!({})]);
    assert_eq!(render(folder.path(), &near, "--vpls 1000").stderr, "");
}

#[test]
fn what_is_not_rendered_is_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let scene = under_a_lamp(folder.path(), 1.0, 0.5, &[json!({})]);
    assert_eq!(render(folder.path(), &scene, "--technique direct").stderr, "");
    let glb = quad_glb(|document, _| {
        document["materials"][0]["emissiveFactor"] = json!([0, 1, 0]);
        document["materials"][0]["alphaMode"] = json!("BLEND");
        document["animations"] = json!([{"channels": [], "samplers": []}]);
        let lens = json!({"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "zfar": 9, "znear": 1}});
        document["cameras"] = json!([lens, lens]);
        document["nodes"] = json!([{"mesh": 0, "camera": 0}, {"camera": 1}]);
        document["scenes"][0]["nodes"] = json!([0, 1]);
    });
    std::fs::write(&scene, glb).unwrap();
    let said = render(folder.path(), &scene, "--technique direct --environment 1,1,1").stderr;
    let sentence = "the parallel views of orthographic cameras (seen from far away instead), \
        blended transparency (cut out at alpha 0.5)\n";
    assert!(said.starts_with("warn: not rendered of ") && said.ends_with(sentence), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
}

/// A deep white pot under a lamp, into which few paths fall; each that does leaves many lights. Where few of the paths that
/// are tried first do so, there is too little room.
#[test]
fn lights_without_room_are_told() {
    let folder = tempfile::tempdir().unwrap();
    // Twelve metres of the quad stand up.
    let wall = |at: [f64; 3], axis: [f64; 3]| {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let turn = [axis[0] * half, axis[1] * half, axis[2] * half, half];
        json!({"translation": at, "rotation": turn, "scale": [1.0 + 2.0 * axis[2].abs(), 1.0, 1.0 + 2.0 * axis[0].abs()]})
    };
    let pot = [
        json!({}),
        wall([2.0, 6.0, 0.0], [0.0, 0.0, 1.0]),
        wall([-2.0, 6.0, 0.0], [0.0, 0.0, -1.0]),
        wall([0.0, 6.0, 2.0], [-1.0, 0.0, 0.0]),
        wall([0.0, 6.0, -2.0], [1.0, 0.0, 0.0]),
    ];
    let scene = under_a_lamp(folder.path(), 41.0, 1.0, &pot);
    // Starts chosen by what is seen would all lead into the pot.
    let options = "--technique brute-force --vpls 3000 --vpl-importance none --bounces 32";
    let told = (1..=16).find_map(|seed| {
        let run = render(folder.path(), &scene, &format!("{options} --seed {seed}"));
        let sentence = run.stderr.contains(" had no room and were left out").then_some(run.stderr);
        println!("seed {seed}: {} vpls, {} paths", count(folder.path(), "vpls"), count(folder.path(), "paths"));
        sentence
    });
    let sentence = told.expect("a seed whose first paths miss the pot more than others do");
    // Room for the lights asked for, a quarter and 1,024.
    let room = 3000 + 750 + 1024;
    assert_eq!(count(folder.path(), "vpls"), room);
    let words = sentence.split_whitespace();
    let numbers: Vec<u64> = words.filter_map(|word| word.parse().ok()).collect();
    assert!(numbers.windows(2).any(|pair| pair[0] > 0 && pair[0] + room == pair[1]), "{sentence}");
    assert_eq!(sentence.lines().count(), 1, "{sentence}");
}

/// Each of these shows nothing, for a reason of its own; the last shows the floor.
#[test]
fn pictures_of_nothing_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let scene = under_a_lamp(folder.path(), 1.0, 0.5, &[json!({})]);
    let said =
        |scene: &Path, options: &str| render(folder.path(), scene, &format!("--technique direct {options}")).stderr;
    let camera = |height_deg: f64| format!("--camera 0,2,0,0,{height_deg}");
    let sees_none = "sees none of the scene's triangles\n";
    let away = said(&scene, &camera(80.0));
    assert!(away.starts_with("warn: the picture is black: the camera `0,2,0") && away.ends_with(sees_none), "{away}");
    let sky = said(&scene, &format!("{} --environment 1,1,1", camera(80.0)));
    assert!(sky.starts_with("warn: the camera") && sky.ends_with(sees_none), "{sky}");
    assert_eq!(said(&scene, &camera(-80.0)), "");
    let dark = folder.path().join("dark.glb");
    let unlit = quad_glb(|document, _| {
        document["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 0.0}]}});
        document["nodes"][0]["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
    });
    std::fs::write(&dark, unlit).unwrap();
    assert_eq!(said(&dark, ""), "warn: the picture is black: no light of the scene shines\n");
    let below = under_a_lamp(folder.path(), -1.0, 0.5, &[json!({})]);
    let said = said(&below, &camera(-80.0));
    assert!(said.contains("no light reaches what the camera") && said.lines().count() == 1, "{said}");
}
