//! Settings that go together.

use crate::settings::{Coverage, Lobe, MicroFill, Scope, Selection, Settings, ShadowPoints, Technique};

/// A name, what it is in a sentence, and what it changes of the defaults.
pub struct Preset {
    /// Name in the panel.
    pub name: &'static str,
    /// One line of help.
    pub help: &'static str,
    change: fn(&mut Settings),
}

/// Every preset.
pub const PRESETS: [Preset; 5] = [
    Preset {
        name: "paper",
        help: "The settings of Lin and Yuksel 2019 where the program's defaults differ",
        change: |s| {
            s.lgh.lobe = Lobe::ClampedNormal;
            s.lgh.shadow_points = ShadowPoints::Deviation;
            s.lgh.shadow_from = 2;
        },
    },
    Preset {
        name: "paper, points",
        help: "Point-based global illumination with the settings of Harada 2014 where the program's defaults differ",
        change: |s| {
            s.render.technique = Technique::Pbgi;
            s.pbgi.micro = MicroFill::Points;
            s.pbgi.coverage = Coverage::Binary;
            s.pbgi.selection = Selection::Paper;
            s.pbgi.sun_leaves = 1;
        },
    },
    Preset {
        name: "fastest",
        help: "Few lights, one shadow ray per pixel, each pixel evaluates a sixteenth of the lights",
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
        help: "Path tracing, one path per pixel and frame, accumulating 1024 frames while the camera is still",
        change: |s| {
            s.render.technique = Technique::PathTrace;
            s.path_trace.samples = 1;
            s.render.accumulate = 1024;
            s.many_lights.clamp = 0.0;
        },
    },
];

/// Settings with what a preset says of how pictures are rendered, over what `defaults` say; the rest stays.
pub fn apply(name: &str, settings: &Settings, defaults: &Settings) -> Settings {
    let mut new = settings.clone().with_groups_of(defaults, Scope::is_method);
    if let Some(preset) = PRESETS.iter().find(|preset| preset.name == name) {
        (preset.change)(&mut new);
    }
    new
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::testing::every_value_changed;

    #[test]
    fn every_preset_is_valid() {
        for preset in &PRESETS {
            let settings = apply(preset.name, &Settings::default(), &Settings::default());
            settings.validate().unwrap();
            crate::techniques::check(&settings).unwrap();
        }
    }

    #[test]
    fn presets_change_what_is_of_the_method_alone() {
        let (settings, defaults) = (every_value_changed(), Settings::default());
        for preset in &PRESETS {
            let new = apply(preset.name, &settings, &defaults);
            let set = defaults.clone().changed(preset.change);
            for key in Settings::keys() {
                let expected = if Settings::scope_of(&key).unwrap().is_method() { &set } else { &settings };
                assert_eq!(
                    new.table().unwrap().get(&key),
                    expected.table().unwrap().get(&key),
                    "{}: {key}",
                    preset.name
                );
            }
        }
    }
}
