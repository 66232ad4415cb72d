//! Environments through the whole program: what cannot be one is refused in a sentence, what is odd is told.

mod support;

use std::path::{Path, PathBuf};
use std::process::Command;

use exr::image::{Image, SpecificChannels};
use exr::math::Vec2;
use exr::prelude::traits::*;
use gridlight::files::pictures::read_exr;
use support::{Run, program, quad_glb, run};

fn scene(folder: &Path) -> PathBuf {
    let path = folder.join("scene.glb");
    std::fs::write(&path, quad_glb(|_, _| ())).unwrap();
    path
}

fn command(folder: &Path) -> Command {
    let mut command = program();
    command.arg(scene(folder)).args(["--headless", "--size", "32x18", "--technique", "direct"]);
    command.arg("--output").arg(folder.join("out.exr"));
    command
}

fn under(folder: &Path, environment: &Path) -> Run {
    let mut command = command(folder);
    command.arg("--environment").arg(environment);
    run(command)
}

fn small_exr(path: &Path) {
    let channels = SpecificChannels::rgb(|at: Vec2<usize>| (at.0 as f32, 1.0_f32, 2.0_f32));
    Image::from_channels((4, 2), channels).write().to_file(path).unwrap();
}

#[test]
fn files_that_are_no_environment_get_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name);
    small_exr(&place("good.exr"));
    let good = std::fs::read(place("good.exr")).unwrap();
    let depth = SpecificChannels::build().with_channel("Z").with_pixel_fn(|_: Vec2<usize>| (1.0_f32,));
    Image::from_channels((4, 2), depth).write().to_file(place("depth.exr")).unwrap();
    let files: [(&str, &[u8]); 6] = [
        ("empty.exr", b""),
        ("text.exr", b"this is not a picture at all"),
        ("cut.exr", &good[..good.len() / 2]),
        ("empty.hdr", b""),
        ("text.hdr", b"this is not a picture at all"),
        ("cut.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 100 +X 100\nabc"),
    ];
    for (name, bytes) in files {
        std::fs::write(place(name), bytes).unwrap();
    }
    for name in ["missing.exr", "missing.hdr", "depth.exr"].into_iter().chain(files.map(|(name, _)| name)) {
        let run = under(folder.path(), &place(name));
        assert_eq!((run.code, run.stderr.lines().count()), (Some(1), 1), "{name}: {}", run.stderr);
        let start = format!("error: {}: the environment cannot be read: ", place(name).display());
        assert!(run.stderr.starts_with(&start) && run.stderr.len() > start.len() + 5, "{name}: {}", run.stderr);
        assert!(!place("out.exr").exists(), "{name}");
    }
    let run = under(folder.path(), &place("good.exr"));
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
}

#[test]
fn settings_that_make_no_sense_are_named() {
    let folder = tempfile::tempdir().unwrap();
    for (options, part) in [
        ("--environment sky.png", "`sky.png` is not none, sky, R,G,B or a file that ends in .exr or .hdr"),
        ("--environment 1,2", "`1,2` is not none, sky, R,G,B or a file"),
        ("--environment 1,-2,3", "environment 1,-2,3 needs three finite numbers, 0 or above"),
        ("--environment nan,1,1", "environment NaN,1,1 needs three finite numbers"),
        ("--environment-scale -1", "environment-scale must be a finite number, 0 or above, not -1"),
        ("--environment-scale inf", "environment-scale must be a finite number, 0 or above, not inf"),
        ("--environment-turn nan", "environment-turn must be a finite number, not NaN"),
        ("--environment 1,1,1 --sun 10,20", "--sun needs a directional light, and the scene has none"),
    ] {
        let mut command = command(folder.path());
        command.args(options.split_whitespace());
        let run = run(command);
        assert_eq!((run.code, run.stderr.lines().count()), (Some(2), 1), "{options}: {}", run.stderr);
        assert!(run.stderr.contains(part), "{options}: {}", run.stderr);
    }
}

#[test]
fn values_that_are_no_radiance_are_told_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("nan.exr");
    let bad = |at: Vec2<usize>| if at == Vec2(1, 1) { f32::NAN } else { 0.5 };
    let channels = SpecificChannels::rgb(move |at: Vec2<usize>| (bad(at), -bad(at), 0.5_f32));
    Image::from_channels((4, 2), channels).write().to_file(&path).unwrap();
    let run = under(folder.path(), &path);
    assert_eq!((run.code, run.stderr.lines().count()), (Some(0), 1), "{}", run.stderr);
    assert!(
        run.stderr.contains("nan.exr: 9 of 24 values are NaN, infinite or negative; they count as 0"),
        "{}",
        run.stderr
    );
    let (_, _, rgb) = read_exr(folder.path().join("out.exr")).unwrap();
    assert!(rgb.iter().all(|value| value.is_finite() && *value >= 0.0));
}

/// What a scene without a light is put into is told, and can be refused; emissive surfaces are a light.
#[test]
fn a_scene_without_a_light_stands_under_a_sky() {
    let folder = tempfile::tempdir().unwrap();
    let render = |scene: &Path, options: &[&str]| {
        let mut command = program();
        command.arg(scene).args(["--headless", "--size", "32x18", "--technique", "direct"]).args(options);
        command.arg("--output").arg(folder.path().join("out.exr"));
        command.arg("--timings").arg(folder.path().join("out.json"));
        let run = run(command);
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        (read_exr(folder.path().join("out.exr")).unwrap().2, run.stderr)
    };
    // What the timings say: the environment, whether it is there for lack of light, and rays towards it.
    let told = || {
        let text = std::fs::read(folder.path().join("out.json")).unwrap();
        let json: serde_json::Value = serde_json::from_slice(&text).unwrap();
        let (source, is_default) = (&json["scene"]["environment"], &json["scene"]["has_sky_for_lack_of_light"]);
        let rate = json["rays"]["environment_rays_per_s"].as_f64().unwrap_or(0.0);
        let rays = json["counts"]["environment_rays"].as_u64().unwrap();
        assert!((rate > 0.0) == (rays > 0) && rays <= 4 * 32 * 18, "{rays} rays, {rate} per second");
        (source.as_str().unwrap().to_owned(), is_default.as_bool().unwrap(), rays > 0)
    };
    let is = |source: &str, for_lack_of_light: bool, has_rays: bool| (source.to_owned(), for_lack_of_light, has_rays);
    let plain = scene(folder.path());
    let (by_itself, said) = render(&plain, &[]);
    assert_eq!(told(), is("sky", true, true));
    assert_eq!(said.lines().count(), 1, "{said}");
    assert!(said.contains("the scene has no light: a clear sky lights it; --environment none"), "{said}");
    let (sky, said) = render(&plain, &["--environment", "sky"]);
    assert!(by_itself == sky && said.is_empty(), "{said}");
    assert_eq!(told(), is("sky", false, true));
    let (sun, said) = render(&plain, &["--environment", "none"]);
    assert!(sun != sky && said.is_empty() && sun.iter().any(|value| *value > 0.0), "{said}");
    assert_eq!(told(), is("none", false, false));
    let image = folder.path().join("small.exr");
    small_exr(&image);
    render(&plain, &["--environment", image.to_str().unwrap(), "--environment-samples", "1"]);
    assert_eq!(told(), is(image.to_str().unwrap(), false, true));
    let emissive = quad_glb(|document, _| document["materials"][0]["emissiveFactor"] = serde_json::json!([0, 1, 0]));
    let path = folder.path().join("emissive.glb");
    std::fs::write(&path, emissive).unwrap();
    let (emissive, said) = render(&path, &[]);
    assert!(said.is_empty() && told() == is("none", false, false), "{said}");
    // The quad is its only light, and shines green.
    let (shines, is_dark) = (emissive.contains(&1.0), |v: &f32| *v == 0.0 || *v == 1.0);
    assert!(shines && emissive.iter().all(is_dark), "{emissive:?}");
}

/// The picture of a scene whose only light is dark is black, by every technique and without a warning.
#[test]
fn a_scene_whose_light_is_dark_stays_dark() {
    let folder = tempfile::tempdir().unwrap();
    let glb = quad_glb(|document, _| {
        let dark = serde_json::json!({"type": "point", "intensity": 0});
        document["extensions"] = serde_json::json!({"KHR_lights_punctual": {"lights": [dark]}});
        let node = serde_json::json!({"translation": [0, 1, 0], "extensions": {"KHR_lights_punctual": {"light": 0}}});
        document["nodes"] = serde_json::json!([{"mesh": 0}, node]);
        document["scenes"][0]["nodes"] = serde_json::json!([0, 1]);
    });
    let path = folder.path().join("dark.glb");
    std::fs::write(&path, glb).unwrap();
    for technique in ["lgh", "direct", "brute-force", "path-trace"] {
        let samples: &[&str] = if technique == "path-trace" { &["--samples", "1"] } else { &[] };
        let mut command = program();
        command.arg(&path).args(["--headless", "--size", "32x18", "--technique", technique]).args(samples);
        command.arg("--output").arg(folder.path().join("out.exr"));
        let run = run(command);
        assert_eq!(run.code, Some(0), "{technique}: {}", run.stderr);
        let (_, _, rgb) = read_exr(folder.path().join("out.exr")).unwrap();
        assert!(rgb.iter().all(|value| *value == 0.0), "{technique}");
    }
}
