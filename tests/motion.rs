//! Scenes that move, through the whole program: sequences of pictures, and what moves in them.

mod support;

use std::f64::consts::FRAC_1_SQRT_2;
use std::path::{Path, PathBuf};

use gridlight::scene::testing::shared_dir;
use serde_json::json;
use support::animated::{pixels, render, slide};
#[cfg(feature = "window")]
use support::xvfb::Xvfb;
use support::{names, program, quad_glb, run};

/// What of the scene is carried along x, by a metre a second.
#[derive(Clone, Copy, PartialEq)]
enum Carried {
    Nothing,
    Screen,
    Lamp,
    Camera,
}

/// A floor with an upright screen on it, under a lamp, seen by a camera; what is carried starts at `x`.
fn scene(folder: &Path, carried: Carried, x: f64) -> PathBuf {
    let glb = quad_glb(|document, bin| {
        let lamp = json!({"type": "point", "intensity": 40.0});
        document["extensions"] = json!({"KHR_lights_punctual": {"lights": [lamp]}});
        document["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.9, "znear": 0.05}}]);
        let at = |of: Carried| if carried == of { x } else { 0.0 };
        let tilt = [-0.2588, 0.0, 0.0, 0.9659];
        document["nodes"] = json!([
            {"mesh": 0},
            {"mesh": 0, "scale": [0.3, 0.3, 0.3], "rotation": [FRAC_1_SQRT_2, 0, 0, FRAC_1_SQRT_2],
                "translation": [at(Carried::Screen), 0.7, 0.0]},
            {"extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [at(Carried::Lamp), 1.8, 0.9]},
            {"camera": 0, "rotation": tilt, "translation": [at(Carried::Camera), 3.0, 4.5]}
        ]);
        document["scenes"][0]["nodes"] = json!([0, 1, 2, 3]);
        if let Some(node) = [Carried::Screen, Carried::Lamp, Carried::Camera].iter().position(|c| *c == carried) {
            slide(document, bin, node + 1);
        }
    });
    let path = folder.join("scene.glb");
    std::fs::write(&path, glb).unwrap();
    path
}

/// Share of the values that differ by more than a hundredth.
fn differing(a: &[f32], b: &[f32]) -> f64 {
    assert_eq!(a.len(), b.len());
    // They are finite: `pixels` has seen to that.
    let differ = |(a, b): &(&f32, &f32)| (**a - **b).abs() > 0.01 * (a.abs() + b.abs()) + 1e-4;
    a.iter().zip(b).filter(differ).count() as f64 / a.len() as f64
}

#[test]
fn frames_show_the_scene_where_it_has_gone() {
    for carried in [Carried::Screen, Carried::Lamp, Carried::Camera] {
        let folder = tempfile::tempdir().unwrap();
        let moving = scene(folder.path(), carried, -1.0);
        render(folder.path(), &moving, "--technique direct --frames 3 --fps 1", "a-{frame}.exr");
        assert_eq!(names(folder.path()), ["a-0000.exr", "a-0001.exr", "a-0002.exr", "scene.glb"]);
        let first = pixels(folder.path(), "a-0000.exr");
        for (frame, x) in [(1, 0.0), (2, 1.0)] {
            let still = scene(folder.path(), carried, x);
            render(folder.path(), &still, "--technique direct --animation none", "still.exr");
            let (expected, found) =
                (pixels(folder.path(), "still.exr"), pixels(folder.path(), &format!("a-000{frame}.exr")));
            assert!(differing(&found, &expected) <= 0.002, "frame {frame}: {}", differing(&found, &expected));
            assert!(differing(&found, &first) > 0.02, "nothing moves that could be compared");
        }
    }
}

#[test]
fn the_hierarchy_follows_as_path_tracing_does() {
    let folder = tempfile::tempdir().unwrap();
    let moving = scene(folder.path(), Carried::Screen, -1.0);
    let mean = |options: &str, picture: &str| {
        render(folder.path(), &moving, options, picture);
        let rgb = pixels(folder.path(), &picture.replace("{frame}", "0002"));
        rgb.iter().sum::<f32>() / rgb.len() as f32
    };
    let indirect = "--direct off --frames 3 --fps 1";
    let lgh = mean(&format!("{indirect} --shadow-estimate unbiased --shadow-samples 16 --clamp 0"), "a-{frame}.exr");
    let truth = mean("--direct off --time 2 --technique path-trace --samples 256", "b.exr");
    assert!((lgh / truth - 1.0).abs() <= 0.08, "{lgh}, not {truth}");
}

#[test]
fn the_same_run_leaves_the_same_frames() {
    let folder = tempfile::tempdir().unwrap();
    let moving = scene(folder.path(), Carried::Screen, -1.0);
    let options = "--frames 2 --warmup 1 --fps 2 --time 0.5";
    render(folder.path(), &moving, options, "a-{frame}.exr");
    render(folder.path(), &moving, &format!("{options} --max-submit-ms 1"), "b-{frame}.exr");
    let bytes = |picture: &str| pixels(folder.path(), picture).iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    for frame in ["0000", "0001"] {
        assert_eq!(bytes(&format!("a-{frame}.exr")), bytes(&format!("b-{frame}.exr")), "{frame}");
    }
    // A last frame alone is the last of the sequence.
    render(folder.path(), &moving, options, "c.exr");
    assert_eq!(bytes("c.exr"), bytes("a-0001.exr"));
}

#[test]
fn points_are_spread_over_what_has_moved() {
    let folder = tempfile::tempdir().unwrap();
    let moving = scene(folder.path(), Carried::Screen, -1.0);
    render(folder.path(), &moving, "--technique pbgi --points 4096 --frames 2 --fps 0.5", "a-{frame}.exr");
    let [first, last] = ["a-0000.exr", "a-0001.exr"].map(|picture| pixels(folder.path(), picture));
    assert!(differing(&first, &last) > 0.02);
}

#[test]
fn a_scene_without_motion_stands() {
    let folder = tempfile::tempdir().unwrap();
    let still = scene(folder.path(), Carried::Nothing, 0.0);
    render(folder.path(), &still, "--frames 2 --fps 1", "a-{frame}.exr");
    render(folder.path(), &still, "--time 5", "b.exr");
    let bytes = |picture: &str| std::fs::read(folder.path().join(picture)).unwrap();
    assert_eq!(pixels(folder.path(), "a-0001.exr"), pixels(folder.path(), "b.exr"));
    assert!(!bytes("b.exr").is_empty());
}

#[test]
fn what_cannot_be_asked_for_is_one_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let moving = scene(folder.path(), Carried::Screen, 0.0);
    for (options, part) in [
        ("--animation jump", "--animation jump is not in the scene; its animations are slide"),
        ("--fps 0", "--fps must be above 0"),
        ("--time nan", "--time must be a number of seconds"),
        ("--rays query", "--rays query"),
    ] {
        let mut command = program();
        command.args(["--headless", "--size", "16x9"]).args(options.split(' ')).arg(&moving);
        let told = run(command);
        assert_eq!(told.code, Some(2), "{options}: {}", told.stderr);
        assert!(told.stderr.contains(part) && told.stderr.lines().count() == 1, "{options}: {}", told.stderr);
    }
}

#[test]
fn a_fox_walks() {
    let Some(shared) = shared_dir() else {
        println!("skipped: no shared assets");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let fox = shared.join("assets/animated/Fox.glb");
    render(folder.path(), &fox, "--animation Walk --frames 2 --fps 4 --technique direct", "a-{frame}.exr");
    let [first, last] = ["a-0000.exr", "a-0001.exr"].map(|picture| pixels(folder.path(), picture));
    assert!(differing(&first, &last) > 0.01, "{}", differing(&first, &last));
}

/// The window goes to a time of the animation, and saves it with the picture.
#[cfg(feature = "window")]
#[test]
fn a_window_goes_to_a_time() {
    let Some(display) = Xvfb::start(320, 240) else {
        println!("skipped: there is no Xvfb (Debian: apt install xvfb)");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let moving = scene(folder.path(), Carried::Screen, -1.0);
    let script = folder.path().join("s.txt");
    std::fs::write(&script, "at 1 pause\nat 2 time 2\nat 4 render shot\nat 5 quit\n").unwrap();
    let options = "--validation --size 64x36 --render-scale 1 --technique direct";
    let mut command = program();
    display.show(&mut command).current_dir(folder.path()).args(options.split_whitespace());
    command.arg("--script").arg(&script).arg(&moving);
    let run = run(command);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    render(folder.path(), &moving, "--technique direct --time 2", "expected.exr");
    let difference = differing(&pixels(folder.path(), "shot.exr"), &pixels(folder.path(), "expected.exr"));
    assert!(difference <= 0.002, "{difference}");
    let saved = gridlight::settings::Settings::read(&folder.path().join("shot.toml")).unwrap();
    assert_eq!(saved.motion.time_s, 2.0);
}
