//! `gridlight compare-sequence` through the whole program: what it finds, its limits, sentences and exit codes.

mod support;

use std::path::PathBuf;

use serde_json::{Value, json};
use support::{Run, program, run};

use gridlight::files::pictures::write_exr;

const WIDTH: u32 = 32;
const HEIGHT: u32 = 24;

struct Place {
    folder: tempfile::TempDir,
}

impl Place {
    /// A truth of eight frames in which half of the picture becomes brighter at frame 4.
    fn new() -> Self {
        let place = Self { folder: tempfile::tempdir().unwrap() };
        place.sequence("true", step);
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn exr(&self, name: &str, (width, height): (u32, u32), radiance: impl Fn(u32) -> f32) {
        let rgb: Vec<f32> = (0..3 * width * height).map(|i| radiance(i / 3 % width)).collect();
        write_exr(std::fs::File::create(self.path(name)).unwrap(), width, height, &rgb, "").unwrap();
    }

    fn sequence(&self, name: &str, radiance: fn(u32, u32) -> f32) {
        for frame in 0..8 {
            self.exr(&format!("{name}-{frame:04}.exr"), (WIDTH, HEIGHT), |x| radiance(frame, x));
        }
    }

    fn run(&self, line: &str) -> Run {
        let mut command = program();
        command.current_dir(self.folder.path()).arg("compare-sequence").args(line.split_whitespace());
        run(command)
    }

    fn passes(&self, line: &str) -> String {
        let run = self.run(line);
        assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""), "{line}");
        run.stdout
    }

    /// Fails with `code` and one sentence that has all `words`.
    fn fails(&self, line: &str, code: i32, words: &[&str]) {
        let run = self.run(line);
        assert_eq!(run.code, Some(code), "{line}: {}", run.stderr);
        assert_eq!(run.stderr.lines().count(), 1, "{line}: {}", run.stderr);
        for word in words {
            assert!(run.stderr.contains(word), "{line}: no `{word}` in {}", run.stderr);
        }
    }

    fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&std::fs::read(self.path(name)).unwrap()).unwrap()
    }
}

fn step(frame: u32, x: u32) -> f32 {
    if frame >= 4 && x < WIDTH / 2 { 1.0 } else { 0.5 }
}

const LIMITS: &str = "--max-flicker 0 --max-block-flicker 0 --max-lag 0 --max-answer 0 --max-flip 0 --max-relmse 0 \
    --energy-within 0";

#[test]
fn the_same_sequence_passes_every_limit() {
    let place = Place::new();
    let table = place.passes(&format!("true-{{frame}}.exr true-{{frame}}.exr {LIMITS} --json o.json -v"));
    for part in ["8 frames, 0 to 7, of which 7 follow another", "a still camera is assumed", "| flicker ", "| lag in"] {
        assert!(table.contains(part), "no `{part}` in {table}");
    }
    assert_eq!(table.matches("holds").count(), 4, "{table}");
    let found = place.json("o.json");
    assert_eq!(found["schema"], "gridlight-compare-sequence/1");
    assert_eq!((&found["metrics"]["flicker"], &found["metrics"]["lag_frames"]), (&json!(0.0), &json!(0.0)));
    assert_eq!((&found["metrics"]["answer"]["frame"], &found["metrics"]["answer"]["frames"]), (&json!(4), &json!(0)));
    assert_eq!((&found["limits"]["max_lag_frames"], &found["exceeded"]), (&json!(0.0), &json!([])));
    assert_eq!(place.passes("true-{frame}.exr true-{frame}.exr --quiet"), "");
}

#[test]
fn a_test_that_is_late_is_found() {
    let place = Place::new();
    // Two frames later, and 10 % too bright in frame 1.
    place.sequence("late", |frame, x| if frame == 1 { 0.55 } else { step(frame.saturating_sub(2), x) });
    place.passes("true-{frame}.exr late-{frame}.exr --max-answer 2 --max-lag 1 --max-flip 0.5");
    let both = "true-{frame}.exr late-{frame}.exr";
    place.fails(&format!("{both} --max-answer 1 --json o.json"), 3, &["late-{frame}.exr against", "answer 2 is over"]);
    assert_eq!(place.json("o.json")["metrics"]["answer"]["frames"], 2);
    place.fails(&format!("{both} --max-flicker 0.01"), 3, &["flicker 0.", "over the limit 0.01"]);
    place.fails(&format!("{both} --energy-within 5"), 3, &["frame 1: the energy ratio 1.1", "(and 2 other frames)"]);
}

#[test]
fn frames_that_the_truth_lacks_are_not_looked_at() {
    let place = Place::new();
    for frame in [2, 3, 5] {
        std::fs::remove_file(place.path(&format!("true-000{frame}.exr"))).unwrap();
    }
    place.sequence("test", step);
    let table = place.passes("true-{frame}.exr test-{frame}.exr");
    assert!(table.contains("5 frames, 0 to 7, of which 2 follow another"), "{table}");
    place.fails("test-{frame}.exr true-{frame}.exr", 1, &["true-{frame}.exr: frame 2 is missing, which test-"]);
    place.fails("test-{frame}.exr test-{frame}.exr --second-truth true-{frame}.exr", 1, &["frame 2 is missing"]);
}

#[test]
fn one_frame_has_no_flicker() {
    let place = Place::new();
    place.exr("one-5.exr", (WIDTH, HEIGHT), |_| 1.0);
    let table = place.passes("one-{frame}.exr one-{frame}.exr --json o.json");
    assert!(table.contains("1 frame, 5, of which 0 follow another") && table.contains("undefined"), "{table}");
    assert!(place.json("o.json")["metrics"]["flicker"].is_null());
    let words = ["flicker is undefined as no two frames follow each other", "the limit 1"];
    place.fails("one-{frame}.exr one-{frame}.exr --max-flicker 1", 3, &words);
}

#[test]
fn what_cannot_be_compared_is_one_sentence() {
    let place = Place::new();
    place.exr("large-0000.exr", (64, 24), |_| 1.0);
    place.exr("nan-0000.exr", (WIDTH, HEIGHT), |_| f32::NAN);
    place.exr("one-0000.exr", (WIDTH, HEIGHT), |_| 1.0);
    place.exr("mixed-0000.exr", (WIDTH, HEIGHT), |_| 1.0);
    place.exr("mixed-0001.exr", (64, 24), |_| 1.0);
    for (line, code, words) in [
        ("true.exr true-{frame}.exr", 2, &["true.exr must have {frame} in its name", "`gridlight compare`"][..]),
        ("true-{frame}.exr {frame}-{frame}.exr", 2, &["must have {frame} once in its name"]),
        (
            "true-{frame}.exr none-{frame}.exr",
            1,
            &["none-{frame}.exr: there is no picture of this name", "none-0000.exr"],
        ),
        ("true-{frame}.exr a/b-{frame}.exr", 1, &["its folder cannot be read"]),
        ("true-{frame}.exr a-{frame}.png", 2, &["are of different kinds"]),
        ("a-{frame}.json a-{frame}.json", 2, &["timings are no sequence"]),
        ("a-{frame}.png a-{frame}.png --exposure 1", 2, &["--exposure applies to EXR pictures only"]),
        ("one-{frame}.exr large-{frame}.exr", 2, &["32x24", "64x24", "only pictures of one size compare"]),
        ("mixed-{frame}.exr mixed-{frame}.exr", 2, &["frames must be of one size"]),
        ("one-{frame}.exr nan-{frame}.exr", 1, &["no pixel that is finite in both"]),
        ("one-{frame}.exr nan-{frame}.exr --max-lag 1", 3, &["frame 0: 768 pixels of the test are NaN or infinite"]),
        ("true-{frame}.exr true-{frame}.exr --max-lag -1", 2, &["--max-lag must be a finite number of at least 0"]),
        ("true-{frame}.exr true-{frame}.exr --exposure 0", 2, &["--exposure must be a finite number above 0"]),
        ("true-{frame}.exr true-{frame}.exr --json a.txt", 2, &["--json a.txt must end in .json"]),
    ] {
        place.fails(line, code, words);
    }
}
