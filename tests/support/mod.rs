//! Runs the built program, and makes small scenes for it.
#![allow(dead_code, reason = "every test binary uses its own part of this")]

pub mod animated;
pub mod golden;
pub mod xvfb;

use std::ffi::OsStr;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use gridlight::scene::testing::glb_from;

/// What one run of the program did.
pub struct Run {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
    pub time: Duration,
}

/// The program, not yet started. What it keeps between runs lies in the build folder.
pub fn program() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gridlight"));
    command.stdin(Stdio::null()).env_remove("RUST_LOG");
    command.env("XDG_CACHE_HOME", Path::new(env!("CARGO_TARGET_TMPDIR")).join("cache"));
    command
}

/// Runs the program to its end.
pub fn run(mut command: Command) -> Run {
    let start = Instant::now();
    let output = command.output().expect("the program starts");
    Run {
        code: output.status.code(),
        stdout: String::from_utf8(output.stdout).expect("stdout is text"),
        stderr: String::from_utf8(output.stderr).expect("stderr is text"),
        time: start.elapsed(),
    }
}

/// Runs the program with these arguments, which must succeed without a word on stderr.
pub fn succeed<S: AsRef<OsStr>>(args: &[S]) -> Run {
    let mut command = program();
    command.args(args);
    let run = run(command);
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    run
}

/// Names of the files in a folder, sorted; hidden ones too.
pub fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("the folder exists");
    let mut names: Vec<_> =
        entries.map(|entry| entry.expect("readable").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// A glTF document of a quad in its first 60 bytes of data, a floor facing up, four metres wide.
pub fn quad() -> (Value, Vec<u8>) {
    let corners = [[-2.0, 0.0, 2.0], [2.0, 0.0, 2.0], [2.0, 0.0, -2.0], [-2.0, 0.0, -2.0]];
    let mut bin: Vec<u8> = corners.iter().flatten().flat_map(|v: &f32| v.to_le_bytes()).collect();
    bin.extend([0u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()));
    let document = json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1.0]}}],
        "buffers": [{"byteLength": 60}],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
                "min": [-2.0, 0.0, -2.0], "max": [2.0, 0.0, 2.0]},
            {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}],
    });
    (document, bin)
}

/// The quad as a GLB, spoiled or extended by `change`.
pub fn quad_glb(change: impl FnOnce(&mut Value, &mut Vec<u8>)) -> Vec<u8> {
    let (mut document, mut bin) = quad();
    change(&mut document, &mut bin);
    glb_from(&document.to_string(), &bin)
}

/// Appends an entry to a list of a document; gives its index.
fn push(document: &mut Value, list: &str, entry: Value) -> usize {
    let list = document[list].as_array_mut().unwrap();
    list.push(entry);
    list.len() - 1
}

/// Appends data to the buffer as a view of its own.
pub fn view(document: &mut Value, bin: &mut Vec<u8>, bytes: &[u8]) -> usize {
    bin.resize(bin.len().next_multiple_of(4), 0);
    let view = push(document, "bufferViews", json!({"buffer": 0, "byteOffset": bin.len(), "byteLength": bytes.len()}));
    bin.extend(bytes);
    document["buffers"][0]["byteLength"] = json!(bin.len());
    view
}

/// Appends floats as an accessor of a type such as `VEC3`.
pub fn floats(document: &mut Value, bin: &mut Vec<u8>, kind: &str, values: &[f32]) -> usize {
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    let view = view(document, bin, &bytes);
    let width = kind.strip_prefix("VEC").map_or(1, |width| width.parse().unwrap());
    let count = values.len() / width;
    push(document, "accessors", json!({"bufferView": view, "componentType": 5126, "count": count, "type": kind}))
}

/// Appends floats as an attribute of the quad.
pub fn attribute(document: &mut Value, bin: &mut Vec<u8>, name: &str, kind: &str, values: &[f32]) {
    let accessor = floats(document, bin, kind, values);
    document["meshes"][0]["primitives"][0]["attributes"][name] = json!(accessor);
}

/// Pseudo-random bytes, the same for the same seed.
pub fn noise(seed: u64, length: usize) -> Vec<u8> {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as u8
    };
    (0..length).map(|_| next()).collect()
}
