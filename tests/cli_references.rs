//! The reference techniques, accumulation and interruption through the built program.

mod support;

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

use gridlight::files::pictures::read_exr;
use support::{program, run, succeed};

const SMALL: &str = "--headless --size 24x14 --vpls 300";

fn picture(folder: &Path, options: &str) -> Vec<f32> {
    let path = folder.join("a.exr");
    let line = format!("{SMALL} --validation --quiet {options} --output {}", path.display());
    succeed(&line.split_whitespace().collect::<Vec<_>>());
    let (width, height, rgb) = read_exr(&path).unwrap();
    assert_eq!((width, height), (24, 14), "{options}");
    assert!(rgb.iter().all(|v| v.is_finite() && *v >= 0.0) && rgb.iter().any(|v| *v > 0.0), "{options}");
    rgb
}

fn mean(rgb: &[f32]) -> f32 {
    rgb.iter().sum::<f32>() / rgb.len() as f32
}

#[test]
fn every_technique_is_silent_under_validation() {
    let folder = tempfile::tempdir().unwrap();
    let with = |options: &str| mean(&picture(folder.path(), options));
    let direct = with("--technique direct --accumulate 3");
    let path = with("--technique path-trace --samples 64");
    let brute = with("--technique brute-force --vpls 5000");
    with("--technique brute-force --clamp 0");
    let open = with("--technique brute-force --vpls 5000 --shadows off --max-submit-ms 1");
    assert!(path > 1.02 * direct && brute > 1.02 * direct, "{direct} {path} {brute}");
    // One clamped set of VPLs is a rough estimate; tests/references.rs is strict.
    assert!((brute / path - 1.0).abs() < 0.3, "brute force {brute}, path tracing {path}");
    assert!(open > brute, "shadows take light away: {open} {brute}");
    for lobe in ["clamped-normal", "sh1", "sh1-nonlinear"] {
        with(&format!("--lobe {lobe} --center uniform"));
    }
}

#[test]
fn parts_of_the_light_add_up() {
    let folder = tempfile::tempdir().unwrap();
    for technique in ["lgh", "brute-force --shadows off"] {
        let with = |options: &str| picture(folder.path(), &format!("--technique {technique} {options}"));
        let (all, indirect) = (with(""), with("--direct off"));
        let direct = picture(folder.path(), "--technique direct");
        for i in 0..all.len() {
            assert!((direct[i] + indirect[i] - all[i]).abs() <= 1e-5 * all[i], "{technique}, value {i}");
        }
    }
    let no_bounce = picture(folder.path(), "--technique path-trace --bounces 0 --samples 2");
    assert_eq!(no_bounce, picture(folder.path(), "--technique direct"), "without bounces there is direct light only");
}

#[test]
fn accumulation_is_the_same_every_time_and_less_noisy() {
    let folder = tempfile::tempdir().unwrap();
    let with = |options: &str| picture(folder.path(), &format!("--technique path-trace --samples 1 {options}"));
    let few = with("--accumulate 8");
    assert_eq!(few, with("--accumulate 8"));
    assert_ne!(few, with("--accumulate 8 --seed 2"));
    let error = |picture: &[f32], truth: &[f32]| picture.iter().zip(truth).map(|(a, b)| (a - b).powi(2)).sum::<f32>();
    let truth = with("--samples 256 --accumulate 8 --seed 3");
    let ratio = error(&few, &truth) / error(&with("--accumulate 32"), &truth);
    assert!(ratio > 2.0, "four times the frames divide the error by {ratio}");
}

#[test]
fn senseless_options_are_named() {
    for (options, words) in [
        ("--accumulate 4 --frames 2", ["accumulate", "frames"]),
        ("--accumulate 0", ["accumulate", "at least 1"]),
        ("--technique path-trace --samples 0", ["samples", "at least 1"]),
        ("--technique path-trace --reservoir exact", ["path-trace", "reservoir"]),
        ("--technique brute-force --bounces 0", ["bounces", "virtual point lights"]),
        ("--max-submit-ms 0", ["max-submit-ms", "above 0"]),
        ("--shadows maybe", ["maybe", "--shadows"]),
    ] {
        let mut command = program();
        command.args(SMALL.split_whitespace()).args(options.split_whitespace());
        let found = run(command);
        assert_eq!(found.code, Some(2), "{options}: {}", found.stderr);
        assert_eq!(found.stderr.lines().count(), 1, "{}", found.stderr);
        assert!(words.iter().all(|word| found.stderr.contains(word)), "{options}: {}", found.stderr);
    }
}

/// Interrupts a run that would take hours once its second frame is done.
fn interrupted(folder: &Path, options: &str) -> (Option<i32>, String) {
    let line = format!(
        "{SMALL} -vv {options} --output {} --timings {}",
        folder.join("a.exr").display(),
        folder.join("a.json").display()
    );
    let mut child =
        program().args(line.split_whitespace()).stderr(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    assert!(lines.any(|line| line.contains("frame 2 of")), "{options}");
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let last = lines.last().unwrap();
    (child.wait().unwrap().code(), last)
}

#[test]
fn an_interrupted_run_keeps_what_it_has_and_says_so() {
    for options in ["--technique path-trace --samples 1", "--technique direct", "--technique brute-force"] {
        let folder = tempfile::tempdir().unwrap();
        let (code, sentence) = interrupted(folder.path(), &format!("{options} --accumulate 1000000"));
        assert_eq!(code, Some(130), "{sentence}");
        assert!(sentence.contains("interrupted after ") && sentence.contains(" of 1000000 frames"), "{sentence}");
        let (_, _, rgb) = read_exr(folder.path().join("a.exr")).unwrap();
        assert!(mean(&rgb) > 0.0 && rgb.iter().all(|v| v.is_finite()));
        let meta = exr::meta::MetaData::read_from_file(folder.path().join("a.exr"), false).unwrap();
        let note = meta.headers[0].own_attributes.comments.as_ref().unwrap().to_string();
        assert!(note.contains("interrupted after"), "{note}");
        let json: serde_json::Value =
            serde_json::from_slice(&std::fs::read(folder.path().join("a.json")).unwrap()).unwrap();
        assert!(json["interrupted"].as_str().unwrap().starts_with("interrupted after"));
        assert!(json["frames"].as_u64().unwrap() >= 2);
    }
}
