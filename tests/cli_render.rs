//! Small renders through the whole program: validation, pictures, timings, determinism, many lights.

mod support;

use std::path::{Path, PathBuf};
use std::time::Duration;

use gridlight::files::pictures::{read_exr, read_png};
use gridlight::scene::testing::shared_dir;
use gridlight::settings::Settings;
use serde_json::{Value, json};
use support::{Run, names, program, quad_glb, run, succeed};

const SMALL: &str = "--headless --size 96x54 --vpls 1000";

/// Runs the small render with more options and a picture of this name in `folder`.
fn render(folder: &Path, picture: &str, options: &str) -> Run {
    let mut args: Vec<String> = SMALL.split(' ').chain(options.split_whitespace()).map(str::to_owned).collect();
    args.extend(["--output".to_owned(), text(&folder.join(picture))]);
    succeed(&args)
}

fn text(path: &Path) -> String {
    path.to_str().unwrap().to_owned()
}

fn json_file(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

/// A picture with light in it, every value finite and none negative.
fn sound_picture(path: &Path) -> Vec<f32> {
    let (width, height, rgb) = read_exr(path).unwrap();
    assert_eq!((width, height), (96, 54));
    assert!(rgb.iter().all(|v| v.is_finite() && *v >= 0.0));
    let mean = rgb.iter().sum::<f32>() / rgb.len() as f32;
    assert!(mean > 1e-3, "mean radiance {mean}");
    rgb
}

/// The pass names of the frame graph, from `--print-graph`.
fn graph_passes(options: &str) -> Vec<String> {
    let args: Vec<&str> = SMALL.split(' ').chain(options.split_whitespace()).chain(["--print-graph"]).collect();
    let dot = succeed(&args).stdout;
    let labels = dot.lines().filter_map(|line| line.split_once("[shape=box, label=\"")).map(|(_, label)| label);
    let found: Vec<String> = labels.map(|label| label.split("\\n").next().unwrap().to_owned()).collect();
    assert!(found.len() > 3, "{options}: {found:?}");
    found
}

fn table_passes(table: &str) -> Vec<String> {
    let rows = table.lines().skip(2).map(|row| row.split('|').nth(1).unwrap().trim().to_owned());
    rows.take_while(|name| name != "sum of passes").collect()
}

#[test]
fn verbose_runs_print_every_pass() {
    let mut command = program();
    command.args(SMALL.split(' ')).arg("-v");
    let run = run(command);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(run.stderr.lines().all(|line| line.starts_with("info: ")), "{}", run.stderr);
    assert_eq!(table_passes(&run.stdout), graph_passes(""));
    assert!(run.stdout.contains("\nexposure: "), "{}", run.stdout);
}

#[test]
fn json_timings_say_everything() {
    let folder = tempfile::tempdir().unwrap();
    let timings = folder.path().join("a.json");
    let options = format!("--validation --frames 3 --warmup 1 --timings {}", text(&timings));
    let run = render(folder.path(), "a.exr", &options);
    sound_picture(&folder.path().join("a.exr"));
    assert_eq!(names(folder.path()), ["a.exr", "a.json"]);

    let passes = graph_passes("");
    let json = json_file(&timings);
    let listed: Vec<_> = json["passes"].as_array().unwrap().iter().map(|p| p["name"].as_str().unwrap()).collect();
    assert_eq!(listed, passes);
    for pass in json["passes"].as_array().unwrap() {
        assert_eq!(pass["frames"], 3, "{pass}");
        statistics(&pass["ms"]);
    }
    for key in ["frame_gpu_ms", "frame_cpu_ms", "pass_sum_ms"] {
        statistics(&json[key]);
    }
    let exposure = json["exposure"].as_f64().unwrap();
    assert!(exposure > 0.0 && run.stdout.contains(", exposure "), "{}", run.stdout);
    for line in ["scene: courtyard, ", "device: ", "picture: 96x54, lgh, ", "frame: ", "written: "] {
        assert!(run.stdout.lines().any(|found| found.starts_with(line)), "no `{line}` in {}", run.stdout);
    }
    assert_eq!((&json["frames"], &json["warmup"]), (&json!(3), &json!(1)));
    assert_eq!(json["schema"], "gridlight-timings/1");
    for pointer in ["/program/version", "/program/commit", "/device/name", "/device/driver", "/device/api_version"] {
        assert!(json.pointer(pointer).is_some_and(|v| v.as_str().is_some_and(|v| !v.is_empty())), "{pointer}");
    }
    for pointer in ["/memory/device_bytes", "/scene/triangles", "/machine/cores"] {
        assert!(json.pointer(pointer).and_then(Value::as_u64).is_some_and(|v| v > 0), "{pointer}");
    }
    assert_eq!((&json["scene"]["name"], &json["scene"]["camera"]), (&json!("courtyard"), &json!("court")));
    settings_are_complete(&json["settings"]);
    counts_are_plausible(&json);
}

#[test]
fn timings_of_both_formats_are_of_one_run() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| text(&folder.path().join(name));
    let options = format!("--technique direct --timings {} --timings {}", file("a.json"), file("a.csv"));
    let run = render(folder.path(), "a.exr", &options);
    assert_eq!(names(folder.path()), ["a.csv", "a.exr", "a.json"]);
    assert_eq!(run.stdout.lines().filter(|line| line.starts_with("written: ")).count(), 3, "{}", run.stdout);
    let rows = std::fs::read_to_string(file("a.csv")).unwrap();
    let json = json_file(&folder.path().join("a.json"));
    let ms = json["frame_gpu_ms"]["median"].as_f64().unwrap();
    let sum: f64 = rows.lines().skip(1).map(|row| row.rsplit(',').next().unwrap().parse::<f64>().unwrap()).sum();
    assert!((sum - ms).abs() <= 1e-3 * ms, "{sum} in the rows, {ms} in the statistics");
    assert_eq!(json["settings"]["timings"], json!([file("a.json"), file("a.csv")]));
}

#[test]
fn every_view_is_a_file_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let run = render(folder.path(), "a.exr", "--technique direct --environment 1,1,1 --view all");
    let views = ["albedo", "depth", "direct", "environment-visibility", "final", "motion-vectors", "normal"];
    assert_eq!(names(folder.path()), views.map(|view| format!("a-{view}.exr")));
    assert_eq!(run.stdout.lines().filter(|line| line.starts_with("written: ")).count(), views.len(), "{}", run.stdout);
    let whole = sound_picture(&folder.path().join("a-final.exr"));
    render(folder.path(), "one.exr", "--technique direct --environment 1,1,1");
    assert_eq!(whole, sound_picture(&folder.path().join("one.exr")));
    assert_ne!(whole, sound_picture(&folder.path().join("a-albedo.exr")));
}

fn statistics(ms: &Value) {
    let part = |key: &str| ms[key].as_f64().unwrap_or_else(|| panic!("no {key} in {ms}"));
    let ordered = [part("min"), part("median"), part("p95"), part("max")];
    assert!(ordered[0] >= 0.0 && ordered.is_sorted(), "{ms}");
    assert!((ordered[0]..=ordered[3]).contains(&part("mean")), "{ms}");
}

fn settings_are_complete(settings: &Value) {
    let all = serde_json::to_value(Settings::default()).unwrap();
    for key in all.as_object().unwrap().keys() {
        assert!(settings.get(key).is_some(), "no {key} in the settings");
    }
    for (key, value) in [("size", json!("96x54")), ("vpls", json!(1000)), ("validation", json!(true))] {
        assert_eq!(settings[key], value);
    }
    assert!(settings["reservoir"].is_string(), "the mode that was chosen is not told");
}

fn counts_are_plausible(json: &Value) {
    let counts = &json["counts"];
    let count = |key: &str| counts[key].as_f64().unwrap_or_else(|| panic!("no {key} in {counts}"));
    assert!((800.0..1250.0).contains(&count("vpls")), "{counts}");
    assert!(count("paths") > 0.0 && count("vpl_rays") >= count("vpls"), "{counts}");
    assert!(count("shadow_rays") > 0.0 && count("shadow_rays") <= 4.0 * 96.0 * 54.0, "{counts}");
    assert!(
        count("lights_tested_mean") >= 1.0 && count("lights_tested_max") >= count("lights_tested_mean"),
        "{counts}"
    );
    let levels: Vec<u64> =
        counts["grid_lights_per_level"].as_array().unwrap().iter().map(|n| n.as_u64().unwrap()).collect();
    assert_eq!(levels.len() as f64, count("level_count"));
    assert!(levels[0] as f64 <= count("vpls") && *levels.last().unwrap() <= 8, "{counts}");
    assert!(levels.is_sorted_by(|a, b| a >= b), "{counts}");
}

#[test]
fn csv_timings_png_and_quiet() {
    let folder = tempfile::tempdir().unwrap();
    let timings = folder.path().join("a.csv");
    let options = format!("--quiet --frames 2 --technique direct --timings {}", text(&timings));
    let run = render(folder.path(), "a.png", &options);
    assert_eq!(run.stdout, "");
    let (width, height, rgb) = read_png(folder.path().join("a.png")).unwrap();
    assert_eq!((width, height), (96, 54));
    assert!(rgb.iter().any(|v| *v > 64) && rgb.iter().any(|v| *v < 192));
    let darker = format!("{options} --exposure-compensation -2");
    render(folder.path(), "b.png", &darker);
    let (.., dark) = read_png(folder.path().join("b.png")).unwrap();
    assert!(dark.iter().zip(&rgb).all(|(dark, bright)| dark <= bright) && dark != rgb);
    let csv = std::fs::read_to_string(timings).unwrap();
    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some("frame,pass,gpu_ms"));
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    let passes = graph_passes("--technique direct");
    assert_eq!(rows.len(), 2 * passes.len());
    for (index, row) in rows.iter().enumerate() {
        assert_eq!(row[0], (index / passes.len()).to_string());
        assert_eq!(row[1], passes[index % passes.len()]);
        assert!(row[2].parse::<f64>().unwrap() >= 0.0);
    }
}

#[test]
fn the_seed_decides_the_bytes() {
    let folder = tempfile::tempdir().unwrap();
    // Whatever is picked without regard to order.
    for (picture, seed) in [("a.exr", 1), ("b.exr", 1), ("c.exr", 2)] {
        render(folder.path(), picture, &format!("--reservoir exact --seed {seed}"));
    }
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert!(bytes("a.exr") == bytes("b.exr"), "the same seed gave two pictures");
    assert!(bytes("a.exr") != bytes("c.exr"), "two seeds gave the same picture");
}

#[test]
fn a_settings_file_stands_for_the_options() {
    let folder = tempfile::tempdir().unwrap();
    let options = "--camera arcade --bounces 2 --alpha 1.5 --levels 4 --shadow-samples 0 --interleave 2 --seed 7";
    render(folder.path(), "options.exr", options);
    let file = "camera = \"arcade\"\nbounces = 2\nalpha = 1.5\nlevels = 4\nshadow-samples = 0\ninterleave = 2\n\
                seed = 9\nsize = \"8x8\"\n";
    let settings = folder.path().join("settings.toml");
    std::fs::write(&settings, file).unwrap();
    // The command line wins: seed and size.
    render(folder.path(), "file.exr", &format!("--settings {} --seed 7", text(&settings)));
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert!(bytes("options.exr") == bytes("file.exr"), "the pictures differ");
    sound_picture(&folder.path().join("file.exr"));
}

#[test]
fn every_mode_is_silent_under_validation() {
    let folder = tempfile::tempdir().unwrap();
    let list = succeed(&["--list-gpus"]).stdout;
    let modes = [
        "--technique direct",
        "--reservoir race",
        "--reservoir lock --interleave 4",
        "--lighting volumes --reservoir exact --interleave 2",
        "--lighting gather --interleave 2",
        "--max-submit-ms 0.5 --warmup 1 --frames 2",
        "--build scatter --filter none",
        "--first-level 0 --shadow-from 0 --levels 2",
        "--shadow-samples 0 --interleave 4",
        "--shadow-samples 16 --clamp 0 --alpha 2 --levels 6",
    ];
    for mode in modes {
        if mode.contains("exact") && !list.contains("64-bit buffer atomics: found") {
            println!("skipped: {mode} needs 64-bit buffer atomics, which this device lacks");
            continue;
        }
        render(folder.path(), "a.exr", &format!("--validation --frames 2 {mode}"));
        sound_picture(&folder.path().join("a.exr"));
    }
}

#[test]
fn scenes_of_the_shared_folder() {
    let Some(shared) = shared_dir() else {
        println!("skipped: there is no shared folder with Sponza and Cornell");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    for scene in ["cornell/cornell.gltf", "sponza/sponza-sun.gltf"] {
        let scene = shared.join("assets").join(scene);
        render(folder.path(), "a.exr", &format!("--validation {}", text(&scene)));
        sound_picture(&folder.path().join("a.exr"));
    }
}

/// A floor four metres wide with a grid of point lights above it, in every colour.
fn floor_with_lights(folder: &Path, per_side: u32) -> PathBuf {
    let glb = quad_glb(|document, _| {
        let colors = [[1.0, 0.2, 0.1], [0.1, 1.0, 0.2], [0.2, 0.1, 1.0], [1.0, 1.0, 1.0]];
        let lights = colors.map(|color| json!({"type": "point", "color": color, "intensity": 2e-3}));
        document["extensions"] = json!({"KHR_lights_punctual": {"lights": lights}});
        let place = |i: u32| 4.0 * (f64::from(i) + 0.5) / f64::from(per_side) - 2.0;
        let nodes = document["nodes"].as_array_mut().unwrap();
        for i in 0..per_side * per_side {
            let (x, y) = (i % per_side, i / per_side);
            let at = [place(x), 0.2 + 0.01 * f64::from(i % 37), place(y)];
            nodes.push(json!({"translation": at, "extensions": {"KHR_lights_punctual": {"light": (x + y) % 4}}}));
        }
        let all: Vec<u32> = (0..=per_side * per_side).collect();
        document["scenes"][0]["nodes"] = json!(all);
    });
    let path = folder.join("lights.glb");
    std::fs::write(&path, glb).unwrap();
    path
}

#[test]
fn a_hundred_thousand_lights_of_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let scene = floor_with_lights(folder.path(), 317);
    let timings = folder.path().join("a.json");
    for (lights, vpls) in [("scene", 0..=0), ("both", 500..=1500)] {
        let options = format!("{} --lights {lights} --timings {}", text(&scene), text(&timings));
        let run = render(folder.path(), "a.exr", &options);
        assert!(run.time < Duration::from_secs(60), "{lights} took {:?}", run.time);
        sound_picture(&folder.path().join("a.exr"));
        let counts = &json_file(&timings)["counts"];
        assert!(vpls.contains(&counts["vpls"].as_u64().unwrap()), "{counts}");
        assert!(counts["grid_lights_per_level"][0].as_u64().unwrap() > 1000, "{counts}");
    }
}

/// The hierarchy over a scene's lights against the sum over all of them.
#[test]
fn lights_in_the_hierarchy_shine_as_bright_as_each_alone() {
    let folder = tempfile::tempdir().unwrap();
    let scene = text(&floor_with_lights(folder.path(), 20));
    let mean = |picture: &str, options: &str| {
        render(folder.path(), picture, &format!("{scene} {options}"));
        let rgb = sound_picture(&folder.path().join(picture));
        rgb.iter().map(|v| f64::from(*v)).sum::<f64>() / rgb.len() as f64
    };
    let hierarchy = mean("lgh.exr", "--lights scene --shadow-samples 0 --clamp 0 --alpha 2");
    let direct = mean("direct.exr", "--technique direct --quiet");
    assert!((hierarchy / direct - 1.0).abs() < 0.1, "hierarchy {hierarchy}, direct {direct}");
}

#[test]
fn a_killed_run_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    for milliseconds in [50, 400, 3000] {
        let mut command = program();
        command.args(SMALL.split(' ')).args(["--frames", "1000000", "--quiet"]);
        command.arg("--output").arg(folder.path().join("a.exr"));
        command.arg("--timings").arg(folder.path().join("a.json"));
        let mut child = command.spawn().unwrap();
        std::thread::sleep(Duration::from_millis(milliseconds));
        assert!(child.try_wait().unwrap().is_none(), "the run ended by itself");
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(names(folder.path()).is_empty(), "after {milliseconds} ms: {:?}", names(folder.path()));
    }
}
