//! Settings that have no effect on a picture as the others are, and why: the panel shows them grey.

use crate::settings::{EnvironmentSource, MicroFill, Settings, Temporal, View, name};
use crate::techniques;

const LGH: &[&str] = &["lgh"];
const HIERARCHIES: &[&str] = &["lgh", "final-gather"];
const MANY_LIGHTS: &[&str] = &["lgh", "final-gather", "brute-force"];
const POINTS: &[&str] = &["pbgi", "final-gather", "pbgi-reference"];

/// Keys of settings, and the techniques that read them. All techniques read those that are not here.
const READERS: &[(&[&str], &[&str])] = &[
    (&["levels", "alpha", "lobe", "center", "build", "scatter", "grid-update", "shadow-from"], HIERARCHIES),
    (
        &[
            "first-level",
            "interleave",
            "indirect-size",
            "shadow-points",
            "shadow-estimate",
            "lighting",
            "reservoir",
            "temporal",
            "temporal-weight",
            "antilag",
            "temporal-rounds",
        ],
        LGH,
    ),
    (&["lights", "vpls", "vpl-importance", "clamp", "shadows", "shadow-samples"], MANY_LIGHTS),
    (&["bounces"], &["lgh", "final-gather", "brute-force", "path-trace"]),
    (&["points", "micro", "coverage", "hemisphere", "sun-leaves"], POINTS),
    (&["selection", "reuse"], &["pbgi", "final-gather"]),
    (&["point-bounces"], &["pbgi"]),
    (&["taa"], &["lgh", "pbgi", "final-gather", "direct"]),
    (&["samples"], &["path-trace"]),
];
/// Settings of shadow rays.
const OF_SHADOWS: &[&str] = &[
    "shadow-from",
    "shadow-points",
    "shadow-estimate",
    "reservoir",
    "temporal",
    "temporal-weight",
    "antilag",
    "temporal-rounds",
];

/// Why a setting has no effect on the picture as the others are, as a sentence without its first words: "with --micro rays".
/// `None` where it has one.
#[must_use]
pub fn why_unused(settings: &Settings, key: &str) -> Option<String> {
    let technique = techniques::of(settings).ok()?.name();
    let readers = READERS.iter().find(|(keys, _)| keys.contains(&key)).map(|(_, readers)| *readers);
    if readers.is_some_and(|readers| !readers.contains(&technique)) {
        return Some(format!("with --technique {technique}"));
    }
    let lights = &settings.many_lights;
    let of_shadows = OF_SHADOWS.contains(&key);
    let reason = match key {
        _ if (of_shadows || key == "shadow-samples") && !lights.shadows.is_on() => "with --shadows off",
        _ if of_shadows && lights.shadow_samples == 0 => "with --shadow-samples 0",
        "taa" if settings.render.view != View::Final => {
            return Some(format!("with --view {}", name(&settings.render.view)));
        }
        "antilag" | "temporal-weight" | "temporal-rounds" if settings.lgh.temporal == Some(Temporal::Off) => {
            "with --temporal off"
        }
        "coverage" if settings.pbgi.micro == MicroFill::Rays => "with --micro rays",
        "environment-scale" | "environment-turn" if settings.environment.source == Some(EnvironmentSource::None) => {
            "with --environment none"
        }
        _ => return None,
    };
    Some(reason.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{Switch, Technique};
    use crate::techniques::TECHNIQUES;

    #[test]
    fn keys_and_techniques_are_those_that_there_are() {
        for (keys, readers) in READERS {
            for key in *keys {
                assert!(Settings::scope_of(key).is_some(), "there is no setting {key}");
                let times = READERS.iter().filter(|(keys, _)| keys.contains(key)).count();
                assert_eq!(times, 1, "{key}");
            }
            for reader in *readers {
                assert!(
                    TECHNIQUES.iter().any(|technique| technique.name() == *reader),
                    "there is no technique {reader}"
                );
            }
        }
    }

    #[test]
    fn what_has_no_effect_is_told_with_the_reason() {
        let settings = Settings::default();
        assert_eq!(why_unused(&settings, "points").unwrap(), "with --technique lgh");
        assert_eq!(why_unused(&settings, "vpls"), None);
        let traced = settings.clone().changed(|s| s.render.technique = Technique::PathTrace);
        assert_eq!(why_unused(&traced, "vpls").unwrap(), "with --technique path-trace");
        assert_eq!(why_unused(&traced, "bounces"), None);
        let shown = settings.clone().changed(|s| s.render.view = View::ShadowRatio);
        assert_eq!(why_unused(&shown, "taa").unwrap(), "with --view shadow-ratio");
        assert_eq!(why_unused(&settings, "taa"), None);
        let open = settings.changed(|s| s.many_lights.shadows = Switch::Off);
        assert_eq!(why_unused(&open, "shadow-points").unwrap(), "with --shadows off");
    }
}
