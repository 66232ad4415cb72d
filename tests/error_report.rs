//! `gridlight error-report` through the whole program: the files it writes, what it measures, and how it ends.

mod support;

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use serde_json::Value;
use support::{Run, names, program, run, succeed};

const SMALL: &str = "--size 48x27 --vpls 200 --reference-samples 16 --frames-per-stage 2";
const FILES: [&str; 3] = ["report.html", "report.json", "report.md"];
const STAGES: [&str; 14] = [
    "VPL sampling",
    "clamp",
    "hierarchy",
    "build",
    "shadow sampling",
    "noise of a frame",
    "filter",
    "filtered shadows",
    "estimate ratio",
    "estimate corrected",
    "estimate unbiased",
    "interleave 2x2",
    "interleave 4x4",
    "whole method",
];

fn arguments(folder: &Path, options: &str) -> Vec<String> {
    let words = ["error-report"].into_iter().chain(options.split_whitespace());
    words.chain(["--report", folder.to_str().unwrap()]).map(str::to_owned).collect()
}

/// A small report of the built-in scene with more options, in `folder`.
fn report(folder: &Path, options: &str) -> (Run, Value) {
    let run = succeed(&arguments(folder, &format!("{SMALL} {options}")));
    assert_eq!(names(folder), FILES);
    (run, json(folder))
}

fn json(folder: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(folder.join("report.json")).unwrap()).unwrap()
}

fn text(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).unwrap()
}

fn complain(arguments: &[String], code: i32) -> String {
    let mut command = program();
    command.args(arguments);
    let run = run(command);
    assert_eq!((run.code, run.stdout.as_str()), (Some(code), ""), "{}", run.stderr);
    assert!(run.stderr.starts_with("error: ") && run.stderr.lines().count() == 1, "{}", run.stderr);
    run.stderr
}

fn stage<'a>(report: &'a Value, name: &str) -> &'a Value {
    let stages = report["stages"].as_array().unwrap();
    stages.iter().find(|stage| stage["name"] == name).unwrap_or_else(|| panic!("no stage {name}"))
}

fn metric(report: &Value, name: &str, key: &str) -> f64 {
    stage(report, name)["metrics"][key].as_f64().unwrap_or_else(|| panic!("no {key} of {name}"))
}

#[test]
fn every_stage_is_measured_and_shown() {
    let folder = tempfile::tempdir().unwrap();
    // An earlier report is replaced.
    std::fs::write(folder.path().join("report.md"), "old").unwrap();
    let (run, report) = report(folder.path(), "--validation --vpls 1000");
    assert_eq!(report["schema"], "gridlight-error-report/1");
    assert_eq!((&report["interrupted"], &report["frames_per_stage"]), (&Value::Bool(false), &2.into()));
    let found: Vec<_> = report["stages"].as_array().unwrap().iter().map(|s| s["name"].as_str().unwrap()).collect();
    assert_eq!(found, STAGES);
    for name in STAGES {
        for key in ["energy_ratio", "relmse", "smooth_relmse", "rmse", "flip", "ssim"] {
            assert!(metric(&report, name, key).is_finite(), "{name} {key}");
        }
        for key in ["nonfinite_reference_pixels", "nonfinite_test_pixels"] {
            assert_eq!(stage(&report, name)["metrics"][key], 0, "{name}");
        }
        for side in ["reference", "test"] {
            let ms = stage(&report, name)[side]["ms"].as_f64();
            assert!(ms.is_some_and(|ms| ms > 0.0), "{name}: {side} took {ms:?}");
        }
    }
    assert!(stage(&report, "whole method")["metrics"]["indirect_ratio"].is_f64());
    let noise = stage(&report, "VPL sampling")["reference"]["note"].as_str().unwrap();
    assert!(noise.contains("noise") && noise.contains("relMSE"), "{noise}");

    let markdown = text(folder.path(), "report.md");
    assert_eq!(run.stdout, markdown);
    let html = text(folder.path(), "report.html");
    assert_eq!(html.matches("data:image/png;base64,").count(), 4 * STAGES.len());
    for outside in ["http://", "https://", "<script", "<link", "@import", "src=\"/"] {
        assert!(!html.contains(outside), "the page refers to {outside}");
    }
    for name in STAGES {
        assert!(markdown.contains(&format!("| {name} |")) && html.contains(name), "{name}");
    }
}

/// What is known of the scene must come out: gathering changes little, fewer levels near the pixel change much,
/// the mean of frames has less noise than one.
#[test]
fn numbers_follow_the_settings() {
    let folder = tempfile::tempdir().unwrap();
    let (coarse, near) = (folder.path().join("coarse"), folder.path().join("near"));
    let options = "--quiet --vpls 1000 --frames-per-stage 4";
    let (run, coarse) = report(&coarse, &format!("{options} --alpha 0.3"));
    assert_eq!(run.stdout, "");
    let (_, near) = report(&near, &format!("{options} --alpha 3"));
    // A gathering vertex takes the lights of S1 for points at their centres: close to every VPL, not equal.
    let build = metric(&near, "build", "energy_ratio");
    assert!((build - 1.0).abs() < 0.02, "gathering changed the energy by the factor {build}");
    let (large, small) = (metric(&coarse, "hierarchy", "relmse"), metric(&near, "hierarchy", "relmse"));
    assert!(large > 1.5 * small, "the hierarchy at alpha 0.3 is off by {large}, at alpha 3 by {small}");
    // The same VPLs on both sides: nothing but the radius of blending differs between the reports.
    assert_eq!(metric(&coarse, "VPL sampling", "relmse").to_bits(), metric(&near, "VPL sampling", "relmse").to_bits());
    assert_eq!(metric(&coarse, "clamp", "rmse").to_bits(), metric(&near, "clamp", "rmse").to_bits());
}

/// More rays leave less noise, and the filter moves less light than one frame's noise does.
#[test]
fn an_environment_has_stages_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let with_rays = |rays: u32| {
        let options = format!("--quiet --environment sky --environment-samples {rays} --frames-per-stage 4");
        report(&folder.path().join(rays.to_string()), &format!("{options} --reference-samples 1 --vpls 50")).1
    };
    let (few, many) = (with_rays(1), with_rays(16));
    assert_eq!(few["stages"].as_array().unwrap().len(), STAGES.len() + 2);
    for found in [&few, &many] {
        for name in ["environment noise", "environment filter"] {
            let energy = metric(found, name, "energy_ratio");
            assert!((energy - 1.0).abs() < 0.02, "{name}: energy {energy}");
        }
    }
    let noise = |found: &Value| metric(found, "environment noise", "relmse");
    assert!(noise(&few) > 4.0 * noise(&many), "noise of 1 ray {}, of 16 rays {}", noise(&few), noise(&many));
    let filter = metric(&few, "environment filter", "relmse");
    assert!(filter > 0.0 && filter < 0.5 * noise(&few), "the filter moves {filter}, noise is {}", noise(&few));
}

#[test]
fn without_a_folder_the_table_goes_to_stdout() {
    let arguments: Vec<&str> = ["error-report"].into_iter().chain(SMALL.split(' ')).chain(["--quiet"]).collect();
    let run = succeed(&arguments);
    assert!(run.stdout.starts_with("# Error report: courtyard"), "{}", run.stdout);
    for name in STAGES {
        assert!(run.stdout.contains(&format!("| {name} |")), "{name}");
    }
}

#[test]
fn folders_are_checked_before_anything_is_rendered() {
    let folder = tempfile::tempdir().unwrap();
    let inside = |name: &str| folder.path().join(name);
    std::fs::write(inside("file"), "").unwrap();
    let sentence = complain(&arguments(&inside("file"), SMALL), 1);
    assert!(sentence.contains("file: the report needs a folder, and this is none"), "{sentence}");
    let sentence = complain(&arguments(&inside("no/d"), SMALL), 1);
    assert!(sentence.contains("no/d: the folder cannot be made: there is no folder above it"), "{sentence}");
    std::fs::create_dir_all(inside("taken/report.md")).unwrap();
    let sentence = complain(&arguments(&inside("taken"), SMALL), 1);
    assert!(sentence.contains("report.md: cannot be written: it is a folder"), "{sentence}");
    // A folder that was made for a report goes away with it.
    let sentence = complain(&arguments(&inside("new"), &format!("{SMALL} /no/such.gltf")), 1);
    assert!(sentence.contains("/no/such.gltf"), "{sentence}");
    let sentence = complain(&arguments(&inside("new"), &format!("{SMALL} --camera nobody")), 2);
    assert!(sentence.contains("--camera nobody is not in the scene"), "{sentence}");
    assert_eq!(names(folder.path()), ["file", "taken"]);
}

#[test]
fn usage_errors_make_no_folder() {
    let folder = tempfile::tempdir().unwrap();
    for (options, part) in [
        ("--technique direct", "'--technique'"),
        ("--output a.png", "'--output'"),
        ("--view depth", "'--view'"),
        ("--frames 3", "'--frames'"),
        ("--samples 3", "'--samples'"),
        ("--shadows off", "shadows off leaves none"),
        ("--reference-samples 0", "reference-samples must be at least 1"),
    ] {
        let sentence = complain(&arguments(&folder.path().join("d"), options), 2);
        assert!(sentence.contains(part), "{options}: {sentence}");
    }
    assert!(names(folder.path()).is_empty());
}

/// Interrupts the run once it has said `sign` on stderr. Gives the exit code and the last line of stderr.
#[cfg(unix)]
fn interrupt_at(sign: &str, arguments: &[String]) -> (Option<i32>, String) {
    let mut command = program();
    let mut child: Child =
        command.args(arguments).arg("-v").stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    assert!(lines.by_ref().any(|line| line.contains(sign)), "the run ended without a word of {sign}");
    let status = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(status.success());
    let last = lines.last().unwrap_or_default();
    (child.wait().unwrap().code(), last)
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_reports_what_it_has() {
    let folder = tempfile::tempdir().unwrap();
    // The fifth stage would take days.
    let options = format!("{SMALL} --frames-per-stage 100000000");
    let (code, last) = interrupt_at("stage 2 of 14 is finished", &arguments(folder.path(), &options));
    assert_eq!(code, Some(130), "{last}");
    assert!(last.starts_with("interrupted after ") && last.contains(" of 14 stages"), "{last}");
    assert_eq!(names(folder.path()), FILES);
    let report = json(folder.path());
    assert_eq!(report["interrupted"], true);
    let finished = report["stages"].as_array().unwrap().len();
    assert!((2..=4).contains(&finished), "{finished} stages");
    assert!(last.contains(&format!("after {finished} of")), "{last}");
    for name in ["report.md", "report.html"] {
        assert!(text(folder.path(), name).contains("The run was interrupted"), "{name}");
    }
}

#[cfg(unix)]
#[test]
fn a_run_interrupted_before_its_first_stage_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let options = format!("{SMALL} --reference-samples 100000000");
    let (code, last) = interrupt_at("BVH:", &arguments(&folder.path().join("d"), &options));
    assert_eq!(
        (code, last.as_str()),
        (Some(130), "interrupted before the first stage was finished; nothing is written")
    );
    assert!(names(folder.path()).is_empty());
}
