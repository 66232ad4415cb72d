//! `gridlight compare` through the whole program: what it finds, its limits, sentences and exit codes.

mod support;

use std::path::PathBuf;

use serde_json::{Value, json};
use support::{Run, names, noise, program, run};

use gridlight::compare::false_color::SCALE_BAR_PX;
use gridlight::files::pictures::{read_png, write_exr, write_png};

const WIDTH: u32 = 32;
const HEIGHT: u32 = 24;

struct Place {
    folder: tempfile::TempDir,
}

/// Radiance at a column, row and channel.
type Radiance = fn(usize, usize, usize) -> f32;

fn pattern(x: usize, y: usize, c: usize) -> f32 {
    ((7 * x + 13 * y + 29 * c) % 64) as f32 / 32.0
}

impl Place {
    fn new() -> Self {
        let place = Self { folder: tempfile::tempdir().unwrap() };
        place.exr("a.exr", pattern);
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn exr(&self, name: &str, radiance: Radiance) {
        self.exr_of_size(name, (WIDTH, HEIGHT), radiance);
    }

    fn exr_of_size(&self, name: &str, (width, height): (u32, u32), radiance: Radiance) {
        let value = |i| radiance((i / 3 % width) as usize, (i / 3 / width) as usize, (i % 3) as usize);
        let rgb: Vec<f32> = (0..3 * width * height).map(value).collect();
        write_exr(std::fs::File::create(self.path(name)).unwrap(), width, height, &rgb, "").unwrap();
    }

    fn png(&self, name: &str, offset: usize) {
        let rgb: Vec<u8> = (offset..offset + 3 * 32 * 24).map(|i| (i * 7 % 256) as u8).collect();
        write_png(std::fs::File::create(self.path(name)).unwrap(), WIDTH, HEIGHT, &rgb, "").unwrap();
    }

    /// A timings file with a frame of 10 ms and passes of 0.4 and 9 ms, changed.
    fn timings(&self, name: &str, change: impl FnOnce(&mut Value)) {
        let ms = |median: f64| json!({"min": 0.0, "median": median, "mean": median, "p95": median, "max": median});
        let mut file = json!({
            "schema": "gridlight-timings/1",
            "device": {"name": "llvmpipe", "driver": "Mesa 22.3.6"}, "machine": {"cores": 2},
            "scene": {"name": "courtyard", "triangles": 12, "camera": "court"}, "settings": {"vpls": 1000},
            "passes": [{"name": "bounds", "frames": 8, "ms": ms(0.4)}, {"name": "light_volumes", "frames": 8, "ms": ms(9.0)}],
            "frame_gpu_ms": ms(10.0), "frame_cpu_ms": ms(11.0),
        });
        change(&mut file);
        std::fs::write(self.path(name), file.to_string()).unwrap();
    }

    /// Runs in the folder.
    fn run(&self, line: &str) -> Run {
        let mut command = program();
        command.current_dir(self.folder.path()).arg("compare").args(line.split_whitespace());
        run(command)
    }

    fn passes(&self, line: &str) -> String {
        let run = self.run(line);
        assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""), "{line}");
        run.stdout
    }

    /// Fails with `code` and one sentence that has all `words`.
    fn fails(&self, line: &str, code: i32, words: &[&str]) -> Run {
        let run = self.run(line);
        assert_eq!(run.code, Some(code), "{line}: {}", run.stderr);
        assert_eq!(run.stderr.lines().count(), 1, "{line}: {}", run.stderr);
        for word in words {
            assert!(run.stderr.contains(word), "{line}: no `{word}` in {}", run.stderr);
        }
        run
    }

    fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&std::fs::read(self.path(name)).unwrap()).unwrap()
    }
}

#[test]
fn equal_pictures_pass_every_limit() {
    let place = Place::new();
    let table = place.passes("a.exr a.exr --max-flip 0 --max-relmse 0 --energy-within 0 --json o.json -v");
    for part in ["| relMSE ", "| FLIP ", "| SSIM ", "no difference", "| exposure "] {
        assert!(table.contains(part), "no `{part}` in {table}");
    }
    let found = place.json("o.json");
    assert_eq!(found["schema"], "gridlight-compare/1");
    assert_eq!(found["metrics"]["flip"], 0.0);
    assert_eq!(found["limits"]["max_flip"], 0.0);
    assert_eq!(found["exceeded"], json!([]));
    assert_eq!(place.passes("a.exr a.exr --quiet"), "");
}

#[test]
fn more_energy_is_found() {
    let place = Place::new();
    place.exr("b.exr", |x, y, c| 1.02 * pattern(x, y, c));
    place.passes("a.exr b.exr --energy-within 2.1 --max-flip 0.05 --max-relmse 0.001");
    let run =
        place.fails("a.exr b.exr --energy-within 1.9 --max-relmse 0.1", 3, &["b.exr", "a.exr", "energy ratio 1.02"]);
    assert!(run.stdout.contains("1 within 1.9 %: EXCEEDED") && run.stdout.contains("| 0.1: holds"), "{}", run.stdout);
    assert!(!run.stderr.contains("relMSE"), "{}", run.stderr);
    let words = ["FLIP", "relMSE", "energy ratio", "limit 0.0001"];
    place.fails("a.exr b.exr --energy-within 1 --max-relmse 0.0001 --max-flip 0.0001 --json o.json", 3, &words);
    assert_eq!(place.json("o.json")["exceeded"].as_array().unwrap().len(), 3);
}

#[test]
fn a_shifted_picture_is_found_and_shown() {
    let place = Place::new();
    place.exr("b.exr", |x, y, c| pattern(x + 1, y, c));
    place.fails("a.exr b.exr --max-flip 0.05 --heatmap h.png --quiet", 3, &["FLIP 0.", "limit 0.05"]);
    let (width, height, rgb) = read_png(place.path("h.png")).unwrap();
    assert_eq!((width, height), (WIDTH, HEIGHT + SCALE_BAR_PX as u32));
    assert!(rgb.iter().any(|v| *v > 200));
}

#[test]
fn pixels_that_are_not_finite() {
    let place = Place::new();
    place.exr("b.exr", |x, y, c| if (x, y, c) == (3, 4, 1) { f32::NAN } else { pattern(x, y, c) });
    let table = place.passes("a.exr b.exr");
    assert!(table.contains("NaN or infinite in the test, in no measure: 1"), "{table}");
    place.passes("b.exr a.exr --max-flip 0 --max-relmse 0 --energy-within 0");
    let sentence = "1 pixel of the test is NaN or infinite";
    for limit in ["--max-flip 1", "--max-relmse 9", "--energy-within 99"] {
        place.fails(&format!("a.exr b.exr {limit} --json o.json"), 3, &[sentence, "b.exr"]);
    }
    let found = place.json("o.json");
    assert_eq!(found["metrics"]["nonfinite_test_pixels"], 1);
    assert_eq!(found["metrics"]["flip"], 0.0);
    place.exr("c.exr", |_, _, _| f32::INFINITY);
    place.fails("a.exr c.exr", 1, &["no pixel that is finite"]);
    place.fails("a.exr c.exr --max-flip 1", 3, &["768 pixels of the test are NaN or infinite"]);
}

#[test]
fn a_black_reference() {
    let place = Place::new();
    place.exr("black.exr", |_, _, _| 0.0);
    let table = place.passes("black.exr a.exr --json o.json");
    assert!(table.contains("the reference is black: relative measures are undefined"), "{table}");
    assert!(place.json("o.json")["metrics"]["relmse"].is_null());
    place.passes("black.exr black.exr --max-flip 0");
    place.fails("black.exr black.exr --max-relmse 1", 3, &["relMSE is undefined", "reference is black"]);
}

#[test]
fn indirect_light() {
    let place = Place::new();
    place.exr("lit.exr", |x, _, _| if x < 16 { 4.0 } else { 1.0 });
    place.exr("direct.exr", |x, _, _| if x < 16 { 4.0 } else { 0.0 });
    place.exr("b.exr", |x, _, _| if x < 16 { 4.0 } else { 1.5 });
    place.passes("lit.exr b.exr --direct direct.exr --json o.json --exposure 2");
    let found = place.json("o.json");
    assert_eq!(found["metrics"]["indirect_ratio"], 1.5);
    assert_eq!(found["metrics"]["indirect_pixels"], 384);
    assert_eq!(found["metrics"]["exposure"], 2.0);
}

#[test]
fn png_pictures() {
    let place = Place::new();
    place.png("a.png", 0);
    place.png("b.png", 1);
    place.passes("a.png a.png --max-flip 0 --energy-within 0 --json o.json");
    assert!(place.json("o.json")["metrics"]["exposure"].is_null());
    place.fails("a.png b.png --max-flip 0.01", 3, &["FLIP"]);
}

#[test]
fn sizes_and_files_that_do_not_fit() {
    let place = Place::new();
    place.exr_of_size("small.exr", (16, 12), pattern);
    place.fails("a.exr small.exr", 2, &["a.exr is 32x24", "small.exr is 16x12"]);
    place.fails("a.exr a.exr --direct small.exr", 2, &["small.exr is 16x12"]);
    place.fails("a.exr gone.exr", 1, &["gone.exr", "No such file"]);
    std::fs::write(place.path("noise.exr"), noise(1, 500)).unwrap();
    place.fails("a.exr noise.exr", 1, &["noise.exr"]);
    std::fs::write(place.path("noise.png"), noise(1, 500)).unwrap();
    place.fails("noise.png noise.png", 1, &["noise.png"]);
    place.fails("a.exr b.json", 2, &["different kinds"]);
    place.fails("a.exr a.exr --json a.exr", 2, &["must end in .json"]);
    place.fails("a.exr a.exr --max-flip many", 2, &["--max-flip"]);
    let before = names(place.folder.path());
    place.fails("a.exr a.exr --heatmap no/h.png --json o.json", 1, &["no/h.png", "there is no folder"]);
    assert_eq!(names(place.folder.path()), before);
}

#[test]
fn slower_timings_are_found() {
    let place = Place::new();
    place.timings("a.json", |_| ());
    place.timings("b.json", |file| {
        file["passes"][0]["ms"]["median"] = json!(0.48);
        file["passes"][1]["ms"]["median"] = json!(10.8);
        file["frame_gpu_ms"]["median"] = json!(11.9);
    });
    let table = place.passes("a.json b.json");
    assert!(
        table.contains("| light_volumes ") && table.contains("1.200") && !table.contains("not the same"),
        "{table}"
    );
    place.passes("a.json b.json --max-regression 21");
    place.passes("b.json a.json --max-regression 0");
    let words = ["light_volumes is 20 % slower", "frame (GPU clock) is 19 % slower", "limit 10 %"];
    let run = place.fails("a.json b.json --max-regression 10 --json o.json", 3, &words);
    let marked: Vec<&str> = run.stdout.lines().filter(|row| row.contains("EXCEEDED")).collect();
    assert!(run.stdout.starts_with("the frame is 19.0 % slower\n") && marked.len() == 2, "{}", run.stdout);
    assert!(marked[0].starts_with("| light_volumes ") && marked[1].starts_with("| frame (GPU"), "{}", run.stdout);
    assert!(!run.stderr.contains("bounds"), "{}", run.stderr);
    let found = place.json("o.json");
    assert_eq!(found["exceeded"].as_array().unwrap().len(), 2);
    assert_eq!(found["timings"]["passes"][1]["test_ms"], 10.8);
    assert_eq!(found["max_regression_percent"], 10.0);
}

#[test]
fn timings_that_are_not_comparable_and_files_that_are_none() {
    let place = Place::new();
    place.timings("a.json", |_| ());
    place.timings("b.json", |file| {
        file["device"]["name"] = json!("another");
        file["passes"][0]["name"] = json!("descent");
    });
    let table = place.passes("a.json b.json -v");
    for part in ["device not the same: name `llvmpipe` against `another`", "only in test", "only in reference"] {
        assert!(table.contains(part), "no `{part}` in {table}");
    }
    place.timings("other.json", |file| file["schema"] = json!("other/1"));
    place.timings("part.json", |file| file["passes"] = json!(3));
    place.fails("a.json other.json", 1, &["other.json: not a timings file", "other/1"]);
    place.fails("a.json part.json", 1, &["part.json: not a whole timings file"]);
    std::fs::write(place.path("noise.json"), noise(1, 500)).unwrap();
    place.fails("noise.json a.json", 1, &["noise.json: not a JSON file"]);
    std::fs::write(place.path("list.json"), "[]").unwrap();
    place.fails("list.json a.json", 1, &["list.json: not a timings file of gridlight"]);
    place.fails("a.json gone.json", 1, &["gone.json: cannot be read"]);
}

/// A real picture against its direct light: every measure as an independent program finds it.
#[test]
fn the_measures_of_a_real_picture() {
    let Some(shared) = gridlight::scene::testing::shared_dir() else {
        println!("skipped: no shared references (set GRIDLIGHT_SHARED)");
        return;
    };
    let folder = shared.join("references/sponza-sun/atrium");
    let (place, full, direct) = (Place::new(), folder.join("gi3.exr"), folder.join("direct.exr"));
    let (full, direct) = (full.display(), direct.display());
    place.passes(&format!("{full} {direct} --direct {direct} --json o.json"));
    // What the references' own compare.py and flip_evaluator 1.7 find.
    let expected = [
        ("relmse", 0.262_727_961, 1e-8),
        ("rmse", 0.010_676_800, 1e-8),
        ("energy_ratio", 0.900_282_247, 1e-8),
        ("psnr_db", 9.760_547, 1e-5),
        ("ssim", 0.217_862_044, 1e-7),
        ("flip", 0.659_644_6, 1e-5),
        ("smooth_relmse", 0.254_497_347, 1e-8),
        ("indirect_smooth_relmse", 0.785_835_579, 1e-8),
        ("indirect_pixels", 180_497.0, 0.0),
        ("exposure", 28.792_252_73, 1e-6),
    ];
    let found = place.json("o.json");
    for (key, value, tolerance) in expected {
        let found = found["metrics"][key].as_f64().unwrap();
        assert!((found - value).abs() <= tolerance, "{key}: {found} is not {value}");
    }
}
