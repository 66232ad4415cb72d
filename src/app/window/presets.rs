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
            s.lgh.lobe = Lobe::ClampedNormal;
            s.lgh.shadow_points = ShadowPoints::Deviation;
            s.lgh.shadow_from = 2;
        },
    },
    Preset {
        name: "fastest",
        help: "Few lights, one shadow ray per pixel, each pixel sees a sixteenth of the lights",
        change: |s| {
            s.many_lights.vpls = 2_000;
            s.many_lights.bounces = 2;
            s.lgh.interleave = 4;
            s.many_lights.shadow_samples = 1;
        },
    },
    Preset {
        name: "best quality",
        help: "Wider blending, 16 shadow rays per pixel, every light at every pixel",
        change: |s| {
            s.lgh.alpha = 2.0;
            s.many_lights.shadow_samples = 16;
        },
    },
    Preset {
        name: "reference",
        help: "Path tracing, one path per pixel and frame, the mean of 1024 frames while the camera stands still",
        change: |s| {
            s.render.technique = Technique::PathTrace;
            s.path_trace.samples = 1;
            s.render.accumulate = 1024;
            s.many_lights.clamp = 0.0;
        },
    },
];

/// The settings of a preset; scene, camera, size, device and window stay.
pub fn apply(name: &str, settings: &Settings) -> Settings {
    let mut new = Settings::default().changed(|s| {
        s.scene.file = settings.scene.file.clone();
        s.picture.size = settings.picture.size;
        s.scene.camera = settings.scene.camera.clone();
        s.scene.sun = settings.scene.sun;
        s.picture.exposure = settings.picture.exposure;
        s.device.gpu = settings.device.gpu.clone();
        s.device.validation = settings.device.validation;
        s.window.present_mode = settings.window.present_mode;
        s.window.render_scale = settings.window.render_scale;
        s.picture.seed = settings.picture.seed;
        s.many_lights.vpls = settings.many_lights.vpls;
        s.render.view = View::Final;
    });
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
