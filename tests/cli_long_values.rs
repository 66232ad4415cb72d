//! Values of thousands of characters, wherever people can give one: each error and each warning stays a line that can be
//! read, with the words that matter.

mod support;

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::{Value, json};
use support::{Run, program, quad_glb, run};

/// Most characters of a line: a sentence of 900 with its file of 300.
const LONGEST_LINE: usize = 1300;

fn long() -> String {
    "A".repeat(10_000)
}

/// As long, of short words.
fn of_words() -> String {
    "a name ".repeat(1500)
}

/// One line on stderr that is short and has these words.
fn says(run: &Run, code: i32, words: &[&str]) {
    assert_eq!(run.code, Some(code), "{}", run.stderr);
    assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
    assert!(run.stderr.chars().count() < LONGEST_LINE, "{} characters: {}", run.stderr.len(), run.stderr);
    words.iter().for_each(|word| assert!(run.stderr.contains(word), "no `{word}` in {}", run.stderr));
    let longest = run.stdout.lines().map(str::len).max().unwrap_or(0);
    assert!(longest < LONGEST_LINE, "{longest} bytes of stdout: {}", run.stdout);
}

fn small(folder: &Path) -> Command {
    let mut command = program();
    command.current_dir(folder).args(["--headless", "--size", "32x18", "--technique", "direct"]);
    command
}

#[test]
fn values_of_options() {
    let folder = tempfile::tempdir().unwrap();
    for value in [long(), of_words()] {
        for (option, word) in [
            ("--vpls", "is not a whole number"),
            ("--size", "WIDTHxHEIGHT"),
            ("--technique", "possible values: lgh, "),
            ("--view", "possible values: final, "),
            ("--camera", "its cameras are court, arcade"),
            ("--sun", "in degrees"),
            ("--animation", "its animations are "),
            ("--environment", ".exr or .hdr"),
            ("--output", ".exr or .png"),
            ("--timings", ".json or .csv"),
            ("--gpu", "names no device"),
            ("--seed", "--seed"),
        ] {
            let mut command = small(folder.path());
            says(
                &run({
                    command.args([option, &value]);
                    command
                }),
                2,
                &[option, word],
            );
        }
        let mut command = small(folder.path());
        command.args(["--output", &format!("{value}.exr"), "--timings", &format!("{value}.exr")]);
        says(&run(command), 2, &["--timings", "give two names"]);
        let mut command = small(folder.path());
        command.args(["--dump", &value]);
        says(&run(command), 1, &["too long"]);
        let mut command = small(folder.path());
        command.args(["scene.glb", &value]);
        says(&run(command), 2, &["there is one scene"]);
        let mut command = small(folder.path());
        command.arg(format!("{value}.glb"));
        says(&run(command), 1, &["cannot be read"]);
        for names in [["exr", "exr"], ["exr", "png"], ["json", "txt"]] {
            let mut command = program();
            command.arg("compare").args(names.map(|extension| format!("{value}.{extension}")));
            let run = run(command);
            says(&run, run.code.unwrap(), &[]);
            assert_ne!(run.code, Some(0));
        }
    }
}

#[test]
fn values_of_settings_files() {
    let folder = tempfile::tempdir().unwrap();
    for value in [long(), of_words()] {
        let both = format!("output = \"{value}.exr\"\ndump = \"{value}.exr\"");
        let cases = [
            ("a.toml", format!("vpls = \"{value}\""), 2, "a.toml, line 1"),
            ("a.toml", format!("\"{value}\" = 1"), 2, "a.toml, line 1"),
            ("a.toml", format!("technique = \"{value}\""), 2, "a.toml, line 1"),
            ("a.toml", format!("output = \"{value}\""), 2, ".exr or .png"),
            ("a.toml", format!("camera = \"{value}\""), 2, "its cameras are"),
            ("a.toml", both, 2, "--dump"),
            ("a.json", json!({"vpls": value}).to_string(), 2, "a.json, line 1"),
            ("a.json", json!({&value: 1}).to_string(), 2, "a.json, line 1"),
            ("a.json", json!({"animation": value}).to_string(), 2, "its animations are"),
            ("a.json", format!("{{\"{value}"), 1, "not a JSON file"),
        ];
        for (name, text, code, word) in cases {
            std::fs::write(folder.path().join(name), text).unwrap();
            let mut command = small(folder.path());
            command.args(["--settings", name]);
            says(&run(command), code, &[word]);
        }
    }
}

fn scene(folder: &Path, change: impl Fn(&mut Value)) -> PathBuf {
    let path = folder.join("scene.glb");
    std::fs::write(&path, quad_glb(|document, _| change(document))).unwrap();
    path
}

#[test]
fn strings_of_scenes() {
    let folder = tempfile::tempdir().unwrap();
    for value in [long(), of_words()] {
        let text = json!(value);
        let textured = |image: Value| {
            let text = &text;
            move |d: &mut Value| {
                d["images"] = json!([image]);
                d["textures"] = json!([{"source": 0, "name": text}]);
                d["materials"][0]["name"] = text.clone();
                d["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": 0});
            }
        };
        type Change<'a> = Box<dyn Fn(&mut Value) + 'a>;
        let faults: [(Change<'_>, i32, &str); 9] = [
            (Box::new(|d| d["buffers"][0]["uri"] = text.clone()), 1, "buffer 0"),
            (Box::new(textured(json!({"uri": value}))), 0, "image 0"),
            (Box::new(textured(json!({"uri": format!("http://{value}")}))), 0, "only files"),
            (Box::new(textured(json!({"uri": format!("data:,{value}"), "name": value}))), 0, "unreadable"),
            (Box::new(textured(json!({"bufferView": 0, "name": value, "mimeType": value}))), 0, "unreadable"),
            (Box::new(|d| d["extensionsRequired"] = json!([text])), 1, "extension"),
            (Box::new(|d| d["asset"]["version"] = text.clone()), 1, "version"),
            (Box::new(|d| d["accessors"][0]["type"] = text.clone()), 1, "unknown type"),
            (Box::new(|d| d["materials"][0]["alphaMode"] = text.clone()), 0, "alphaMode"),
        ];
        for (change, code, word) in faults {
            let mut command = small(folder.path());
            command.args(["--environment", "1,1,1"]).arg(scene(folder.path(), change));
            says(&run(command), code, &["scene.glb", word]);
        }
        // What is not rendered is a warning.
        let mut command = small(folder.path());
        command.args(["--environment", "1,1,1"]).arg(scene(folder.path(), |d| {
            d["extensionsUsed"] = json!([text]);
            d["nodes"][0]["name"] = text.clone();
            d["meshes"][0]["name"] = text.clone();
            d["scenes"][0]["name"] = text.clone();
        }));
        says(&run(command), 0, &["warn: ", "scene.glb"]);
        // Names that an option chooses by.
        let path = scene(folder.path(), |d| {
            d["scenes"][0]["name"] = text.clone();
            d["animations"] = json!([{"name": text, "channels": [], "samplers": []}]);
            d["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}]);
            d["nodes"] = json!([{"mesh": 0}, {"camera": 0, "name": text}]);
            d["scenes"][0]["nodes"] = json!([0, 1]);
        });
        for option in ["--camera", "--scene-name", "--animation"] {
            let mut command = small(folder.path());
            command.arg(&path).args(["--environment", "1,1,1", option, "none such"]);
            says(&run(command), 2, &[option, "none such"]);
        }
        let mut command = small(folder.path());
        command.arg(&path).args(["--camera", &value, "--environment", "1,1,1"]);
        let run = run(command);
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        assert!(run.stderr.lines().chain(run.stdout.lines()).all(|line| line.chars().count() < LONGEST_LINE));
    }
}
