//! Lights that an animation changes by `KHR_animation_pointer`, through the whole program.

mod support;

use std::f64::consts::FRAC_1_SQRT_2;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use support::animated::{pixels, render};
use support::{floats, quad_glb};

/// Intensities of the lamp at 0 s, 1 s and 2 s, each until the next.
const INTENSITIES: [f32; 3] = [0.0, 40.0, 8.0];

/// A floor with an upright screen on it, a weak lamp that shines evenly, and another one: animated, or with an intensity.
fn scene(folder: &Path, intensity: Option<f32>) -> PathBuf {
    let glb = quad_glb(|document, bin| {
        let lamp = |intensity: f32| json!({"type": "point", "intensity": intensity});
        let lights = [lamp(4.0), lamp(intensity.unwrap_or(INTENSITIES[0]))];
        document["extensions"] = json!({"KHR_lights_punctual": {"lights": lights}});
        document["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.9, "znear": 0.05}}]);
        let at = |light: u32, x: f64| json!({"extensions": {"KHR_lights_punctual": {"light": light}}, "translation": [x, 1.8, 0.9]});
        document["nodes"] = json!([
            {"mesh": 0},
            {"mesh": 0, "scale": [0.3, 0.3, 0.3], "rotation": [FRAC_1_SQRT_2, 0, 0, FRAC_1_SQRT_2], "translation": [0, 0.7, 0]},
            at(0, -1.5), at(1, 0.5),
            {"camera": 0, "rotation": [-0.2588, 0.0, 0.0, 0.9659], "translation": [0.0, 3.0, 4.5]}
        ]);
        document["scenes"][0]["nodes"] = json!([0, 1, 2, 3, 4]);
        if intensity.is_none() {
            animate(document, bin);
        }
    });
    let name = intensity.map_or_else(|| "animated.glb".to_owned(), |intensity| format!("{intensity}.glb"));
    std::fs::write(folder.join(&name), glb).unwrap();
    folder.join(name)
}

/// Lets the second lamp have the intensities one after the other, and the last for a second.
fn animate(document: &mut Value, bin: &mut Vec<u8>) {
    let [a, b, c] = INTENSITIES;
    let input = floats(document, bin, "SCALAR", &[0.0, 1.0, 2.0, 3.0]);
    let output = floats(document, bin, "SCALAR", &[a, b, c, c]);
    let pointer = json!({"pointer": "/extensions/KHR_lights_punctual/lights/1/intensity"});
    let target = json!({"path": "pointer", "extensions": {"KHR_animation_pointer": pointer}});
    document["animations"] = json!([{
        "samplers": [{"input": input, "output": output, "interpolation": "STEP"}],
        "channels": [{"sampler": 0, "target": target}]
    }]);
    document["extensionsUsed"] = json!(["KHR_lights_punctual", "KHR_animation_pointer"]);
}

fn mean(rgb: &[f32]) -> f64 {
    rgb.iter().map(|value| f64::from(*value)).sum::<f64>() / rgb.len() as f64
}

#[test]
fn a_lamp_lights_the_frames_in_which_it_is_on() {
    let folder = tempfile::tempdir().unwrap();
    let animated = scene(folder.path(), None);
    render(folder.path(), &animated, "--technique direct --frames 3 --fps 1", "a-{frame}.exr");
    let means = [0, 1, 2].map(|frame| mean(&pixels(folder.path(), &format!("a-000{frame}.exr"))));
    assert!(means[1] > 2.0 * means[0] && means[1] > 2.0 * means[2] && means[2] > 1.2 * means[0], "{means:?}");
    for (frame, intensity) in INTENSITIES.into_iter().enumerate() {
        let still = scene(folder.path(), Some(intensity));
        render(folder.path(), &still, "--technique direct", "still.exr");
        let (found, expected) =
            (pixels(folder.path(), &format!("a-000{frame}.exr")), pixels(folder.path(), "still.exr"));
        let differs = found.iter().zip(&expected).any(|(a, b)| (a - b).abs() > 1e-4 * (a + b));
        assert!(found.len() == expected.len() && !differs, "frame {frame}");
    }
}

#[test]
fn a_mean_of_frames_is_that_of_a_still_scene() {
    // The lamp has a share of the light paths for its greatest intensity, 5 times that at 2 s: light must be the same as with
    // the share of a still scene, but for noise. In the dark only a tenth of the paths, that of the other lamp, brings light.
    const LIMIT: f64 = 0.02;
    const LIMIT_IN_THE_DARK: f64 = 0.04;
    let folder = tempfile::tempdir().unwrap();
    let animated = scene(folder.path(), None);
    let still = scene(folder.path(), Some(INTENSITIES[2]));
    let indirect = |scene: &Path, options: &str| {
        let mean_of = |technique: &str| {
            render(folder.path(), scene, &format!("{technique} {options}"), "mean.exr");
            mean(&pixels(folder.path(), "mean.exr"))
        };
        mean_of("--accumulate 128") - mean_of("--technique direct")
    };
    let (found, expected) = (indirect(&animated, "--time 2"), indirect(&still, ""));
    assert!(expected > 0.0 && (found / expected - 1.0).abs() <= LIMIT, "{found} is not {expected}");
    // While it is off the other lamp alone is left.
    let dark = scene(folder.path(), Some(0.0));
    let (found, expected) = (indirect(&animated, "--time 0"), indirect(&dark, ""));
    assert!(expected > 0.0 && (found / expected - 1.0).abs() <= LIMIT_IN_THE_DARK, "{found} is not {expected}");
}
