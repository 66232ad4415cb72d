//! Skies that follow a sun which an animation moves.

mod common;
mod support;

use std::f64::consts::FRAC_PI_2;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::Vec3;
use gridlight::environment::Environment;
use gridlight::renderer::{Fresh, Job, Renderer, UploadedScene};
use gridlight::scene::testing::{diffuse, scene_from_quads};
use gridlight::scene::{Light, Scene, SkySun};
use gridlight::settings::{Settings, Size, Technique};
use serde_json::{Value, json};
use support::animated::{pixels, render};
#[cfg(feature = "window")]
use support::xvfb::Xvfb;
use support::{floats, quad_glb};

/// The rotation of a light that shines from this height.
fn from_height(height_deg: f64) -> [f64; 4] {
    let half = 0.5 * height_deg.to_radians();
    [-half.sin(), 0.0, 0.0, half.cos()]
}

/// A floor with an upright screen on it, half of the picture sky, under a sun 15 degrees high that an animation changes: a channel
/// to which key times in seconds and values of a kind lead.
fn scene_with(folder: &Path, target: &Value, times_s: &[f32], (kind, values): (&str, &[f32])) -> PathBuf {
    let glb = quad_glb(|document, bin| {
        document["extensionsUsed"] = json!(["KHR_lights_punctual", "KHR_animation_pointer"]);
        document["extensions"] =
            json!({"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": 4.0}]}});
        document["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.9, "znear": 0.05}}]);
        let upright = [(0.5 * FRAC_PI_2).sin(), 0.0, 0.0, (0.5 * FRAC_PI_2).cos()];
        document["nodes"] = json!([
            {"mesh": 0, "scale": [4.0, 4.0, 4.0]},
            {"mesh": 0, "scale": [0.5, 0.5, 0.5], "rotation": upright, "translation": [0.0, 0.5, 0.0]},
            {"extensions": {"KHR_lights_punctual": {"light": 0}}, "rotation": from_height(15.0)},
            {"camera": 0, "translation": [0.0, 0.8, 4.0]}
        ]);
        document["scenes"][0]["nodes"] = json!([0, 1, 2, 3]);
        let (input, output) = (floats(document, bin, "SCALAR", times_s), floats(document, bin, kind, values));
        document["animations"] = json!([{
            "samplers": [{"input": input, "output": output}], "channels": [{"sampler": 0, "target": target}]
        }]);
    });
    let path = folder.join("scene.glb");
    std::fs::write(&path, glb).unwrap();
    path
}

/// Its sun rises from 15 to 75 degrees in four seconds.
fn scene(folder: &Path) -> PathBuf {
    let keys = [15.0, 75.0].into_iter().flat_map(from_height).map(|value| value as f32);
    let keys: Vec<f32> = keys.collect();
    scene_with(folder, &json!({"node": 2, "path": "rotation"}), &[0.0, 4.0], ("VEC4", &keys))
}

/// The brightness of its sun, from dark on.
fn switched(folder: &Path, times_s: &[f32], brightness: &[f32]) -> PathBuf {
    let pointer = json!({"pointer": "/extensions/KHR_lights_punctual/lights/0/intensity"});
    let target = json!({"path": "pointer", "extensions": {"KHR_animation_pointer": pointer}});
    scene_with(folder, &target, times_s, ("SCALAR", brightness))
}

fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|value| value.to_bits()).collect()
}

/// Without rays to the sky nothing is left to chance: what is seen of it, and the light of its sun.
#[test]
fn frames_have_the_sky_of_a_run_that_starts_with_them() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene(folder.path());
    let options = "--environment sky --technique direct --environment-samples 0";
    for turn in ["", "--environment-turn 40"] {
        render(folder.path(), &scene, &format!("{options} {turn} --frames 3 --fps 1"), "a-{frame}.exr");
        let first = bits(&pixels(folder.path(), "a-0000.exr"));
        for (frame, time) in [(1, "1"), (2, "2")] {
            render(folder.path(), &scene, &format!("{options} {turn} --time {time}"), "b.exr");
            let [found, expected] =
                [&format!("a-000{frame}.exr"), "b.exr"].map(|name| bits(&pixels(folder.path(), name)));
            assert_eq!(found, expected, "frame {frame} {turn}");
            assert_ne!(found, first, "the sky stays as it is");
        }
    }
}

/// A sky without light has what one with light needs.
#[test]
fn a_sun_that_is_switched_on_lights_its_sky() {
    let folder = tempfile::tempdir().unwrap();
    let scene = switched(folder.path(), &[0.0, 1.0, 2.0, 3.0], &[0.0, 1.0, 4.0, 4.0]);
    let no_lag = "--temporal shadows --antilag tiles --temporal-weight 1";
    for options in ["--technique direct --environment-samples 0", no_lag] {
        let options = format!("--environment sky {options}");
        render(folder.path(), &scene, &format!("{options} --frames 3 --fps 1 --warmup 0"), "a-{frame}.exr");
        let [dark, dim, bright] = [0, 1, 2].map(|frame| pixels(folder.path(), &format!("a-000{frame}.exr")));
        assert!(dark.iter().all(|value| *value == 0.0), "{options}");
        for (index, (dim, bright)) in background(&dim).iter().zip(background(&bright)).enumerate() {
            // Half floats, of the same digits where the scale is a power of two.
            assert!(*dim > 0.0 && (bright / dim - 4.0).abs() <= 1e-3, "{options}, value {index}: {dim}, then {bright}");
        }
        render(folder.path(), &scene, &format!("{options} --time 2"), "b.exr");
        let there = pixels(folder.path(), "b.exr");
        assert_eq!(bits(background(&bright)), bits(background(&there)), "{options}");
        let [found, expected] = [&bright, &there].map(|picture| picture.iter().sum::<f32>());
        assert!((found / expected - 1.0).abs() <= 0.03, "{options}: {found}, not {expected}");
    }
}

/// A history without light does not count beside the first light.
#[test]
fn a_sky_that_was_black_is_forgotten_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let scene = switched(folder.path(), &[0.0, 1.0, 1.001, 3.0], &[0.0, 0.0, 4.0, 4.0]);
    let over_time = "--temporal shadows --antilag tiles --frames 16 --fps 10 --warmup 0";
    render(folder.path(), &scene, &format!("--environment sky --view direct {over_time}"), "a-{frame}.exr");
    render(folder.path(), &scene, "--environment sky --view direct --time 1.5", "b.exr");
    let [dark, found, expected] = ["a-0010.exr", "a-0015.exr", "b.exr"].map(|picture| {
        let values = pixels(folder.path(), picture);
        values[values.len() / 2..].iter().sum::<f32>()
    });
    assert_eq!(dark, 0.0);
    assert!((found / expected - 1.0).abs() <= 0.02, "{found}, not {expected}");
}

/// The upper quarter of a picture, which is all sky.
fn background(picture: &[f32]) -> &[f32] {
    &picture[..picture.len() / 4]
}

#[test]
fn a_sun_that_was_placed_keeps_its_sky() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene(folder.path());
    let options = "--environment sky --sun 120,30 --technique direct --environment-samples 0 --frames 3 --fps 1";
    render(folder.path(), &scene, options, "a-{frame}.exr");
    let [first, last] = ["a-0000.exr", "a-0002.exr"].map(|name| bits(&pixels(folder.path(), name)));
    assert_eq!(first, last);
}

/// With a filter over time, under validation.
#[test]
fn the_light_of_a_frame_is_that_of_a_run_that_starts_with_it() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene(folder.path());
    let mean = |picture: &str| {
        let values = pixels(folder.path(), picture);
        values.iter().map(|value| f64::from(*value)).sum::<f64>() / values.len() as f64
    };
    for (options, limit) in [
        ("--technique path-trace --samples 64", 0.01),
        ("--temporal shadows --antilag tiles --temporal-weight 1", 0.03),
        ("--technique pbgi --points 4096", 0.01),
    ] {
        let options = format!("--environment sky {options}");
        render(folder.path(), &scene, &format!("{options} --frames 4 --fps 1"), "a-{frame}.exr");
        render(folder.path(), &scene, &format!("{options} --time 3"), "b.exr");
        let [first, found, expected] = ["a-0000.exr", "a-0003.exr", "b.exr"].map(mean);
        println!("{options}: {first}, then {found}, expected {expected}");
        assert!((found / expected - 1.0).abs() <= limit, "{options}: {found}, not {expected}");
        assert!((first / expected - 1.0).abs() > 2.0 * limit, "{options}: nothing has changed");
        let [found, expected] = ["a-0003.exr", "b.exr"].map(|name| pixels(folder.path(), name));
        assert_eq!(bits(background(&found)), bits(background(&expected)), "{options}");
    }
}

/// A wall and a floor under a sky for a sun at this height.
fn under_sky(height: f32, irradiance: f32) -> Scene {
    let floor =
        [Vec3::new(-2.0, 0.0, 2.0), Vec3::new(2.0, 0.0, 2.0), Vec3::new(2.0, 0.0, -2.0), Vec3::new(-2.0, 0.0, -2.0)];
    let wall = floor.map(|p| Vec3::new(p.x, p.z + 1.0, -2.0)).map(|p| Vec3::new(p.x, p.y.max(0.0), p.z));
    let mut scene =
        scene_from_quads("sky", &[floor, [wall[3], wall[2], wall[1], wall[0]]], diffuse("grey", Vec3::splat(0.6)));
    let (sine, cosine) = height.to_radians().sin_cos();
    let (towards, irradiance) = (Vec3::new(cosine, sine, 0.0), Vec3::splat(irradiance));
    scene.lights = vec![Light::Directional { direction_ws: -towards, irradiance }];
    scene.environment = Some(Arc::new(Environment::sky_for_sun(towards, irradiance, true)));
    scene.sky_sun = Some(SkySun { towards, irradiance, own: Some(0), moves: true });
    scene.cameras = vec![common::rooms::camera(Vec3::new(0.0, 0.7, 3.0), Vec3::NEG_Z, 0.9)];
    scene
}

/// Image, table and constants on the device, to the bit, for every way to read them; a sky that is black between two others too.
#[test]
fn what_is_replaced_on_the_device_is_as_uploaded() {
    let test = common::gpu();
    let settings = |technique: Technique| {
        Settings::default().changed(|s| {
            (s.render.technique, s.picture.size) = (technique, Size { width: 33, height: 18 });
            (s.many_lights.vpls, s.path_trace.samples) = (500, 4);
        })
    };
    for technique in [Technique::Direct, Technique::Lgh, Technique::PathTrace] {
        let settings = settings(technique);
        let picture = |renderer: &mut Renderer, uploaded: &UploadedScene, scene: &Scene| {
            renderer.update(&Job::new(&test.gpu, uploaded, &scene.cameras[0], &settings));
            renderer.set_accumulated_frame(0, Fresh::Shadows);
            let ticket = renderer.submit().unwrap();
            renderer.wait(ticket).unwrap();
            bits(&renderer.read_radiance().unwrap())
        };
        let of = |scene: &Scene| {
            let uploaded = UploadedScene::new(&test.gpu, scene).unwrap();
            let mut renderer = Renderer::new(&Job::new(&test.gpu, &uploaded, &scene.cameras[0], &settings)).unwrap();
            (picture(&mut renderer, &uploaded, scene), uploaded, renderer)
        };
        let morning = under_sky(15.0, 3.0);
        let (first, mut uploaded, mut renderer) = of(&morning);
        let mut pictures = vec![first];
        for scene in [under_sky(15.0, 0.0), under_sky(60.0, 5.0)] {
            uploaded.follow(&test.gpu, &scene).unwrap();
            renderer.update_lights(UploadedScene::new(&test.gpu, &scene).unwrap().other_lights()).unwrap();
            renderer.expect_another_scene();
            let found = picture(&mut renderer, &uploaded, &scene);
            assert!(!pictures.contains(&found), "{technique:?}: the sky stays as it is");
            pictures.push(found);
        }
        let [_, night, noon] = &pictures[..] else { panic!("three pictures") };
        assert!(night.iter().all(|value| *value == 0), "{technique:?}: a sky without a sun is black");
        let (expected, ..) = of(&under_sky(60.0, 5.0));
        // Light paths and where they start are measured in the first frame.
        if technique != Technique::Lgh {
            assert_eq!(*noon, expected, "{technique:?}");
        }
    }
}

/// A window that is paused shows the sky of the moment, that of a later one once it goes there, and that of a sun which is placed.
#[cfg(feature = "window")]
#[test]
fn a_window_has_the_sky_of_the_moment() {
    let Some(display) = Xvfb::start(320, 240) else {
        println!("skipped: there is no Xvfb (Debian: apt install xvfb)");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let scene = scene(folder.path());
    let script = folder.path().join("s.txt");
    std::fs::write(&script, "at 1 pause\nat 2 time 1\nat 4 render one\nat 6 time 3\nat 8 render three\nat 10 set sun 120,30\nat 12 render placed\nat 14 quit\n")
        .unwrap();
    let technique = "--environment sky --technique direct --environment-samples 0";
    let options = format!("--validation --size 64x36 --render-scale 1 --accumulate 1 {technique}");
    let mut command = support::program();
    display.show(&mut command).current_dir(folder.path()).args(options.split_whitespace());
    command.arg("--script").arg(&script).arg(&scene);
    let run = support::run(command);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    for (name, there) in [("one", "--time 1"), ("three", "--time 3"), ("placed", "--time 3 --sun 120,30")] {
        render(folder.path(), &scene, &format!("{technique} {there}"), "expected.exr");
        let [found, expected] = [&format!("{name}.exr"), "expected.exr"].map(|name| bits(&pixels(folder.path(), name)));
        assert_eq!(found, expected, "{name}");
    }
}
