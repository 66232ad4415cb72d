//! Settings that go together.

use crate::settings::{Lobe, Settings, ShadowPoints, Technique, View};

/// A name, what it is in a sentence, and what it changes of the defaults.
pub struct Preset {
    /// Name in the panel.
    pub name: &'static str,
    /// One line of help.
    pub help: &'static str,
    change: fn(&mut Settings),
}

/// Every preset.
pub const PRESETS: [Preset; 4] = [
    Preset {
        name: "paper",
        help: "The choices of Lin and Yuksel 2019 where this program's defaults differ",
        change: |s| {
            s.lobe = Lobe::ClampedNormal;
            s.shadow_points = ShadowPoints::Deviation;
            s.shadow_from = 2;
        },
    },
    Preset {
        name: "fastest",
        help: "Few lights, one shadow ray per pixel, each pixel sees a sixteenth of the lights",
        change: |s| {
            s.vpls = 2_000;
            s.bounces = 2;
            s.interleave = 4;
            s.shadow_samples = 1;
        },
    },
    Preset {
        name: "best quality",
        help: "Wider blending, 16 shadow rays per pixel, every light at every pixel",
        change: |s| {
            s.alpha = 2.0;
            s.shadow_samples = 16;
        },
    },
    Preset {
        name: "reference",
        help: "Path tracing, one path per pixel and frame, the mean of 1024 frames while the camera stands still",
        change: |s| {
            s.technique = Technique::PathTrace;
            s.samples = 1;
            s.accumulate = 1024;
            s.clamp = 0.0;
        },
    },
];

/// The settings of a preset; scene, camera, size, device and window stay.
pub fn apply(name: &str, settings: &Settings) -> Settings {
    let mut new = Settings {
        scene: settings.scene.clone(),
        size: settings.size,
        camera: settings.camera.clone(),
        sun: settings.sun,
        exposure: settings.exposure,
        gpu: settings.gpu.clone(),
        validation: settings.validation,
        present_mode: settings.present_mode,
        render_scale: settings.render_scale,
        seed: settings.seed,
        vpls: settings.vpls,
        view: View::Final,
        ..Settings::default()
    };
    if let Some(preset) = PRESETS.iter().find(|preset| preset.name == name) {
        (preset.change)(&mut new);
    }
    new
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_is_valid() {
        for preset in &PRESETS {
            apply(preset.name, &Settings::default()).validate().unwrap();
        }
    }
}
