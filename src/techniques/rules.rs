//! Which settings and views go with which technique.

use super::{TECHNIQUES, Technique, of};
use crate::settings::{Settings, View, name};
use crate::{Error, Result};

/// Checks settings with the technique that they ask for; no scene and no device are needed.
///
/// # Errors
/// [`Error::Usage`] with one sentence about the first thing wrong.
pub fn check(settings: &Settings) -> Result<()> {
    let technique = of(settings)?;
    for other in TECHNIQUES.iter().filter(|other| other.name() != technique.name()) {
        other.check_unused(settings, technique.name())?;
    }
    check_with(technique, settings)
}

/// The same with a technique that need not be listed, whatever stands in settings that it does not read.
///
/// # Errors
/// Those of [`check`].
pub fn check_with(technique: &dyn Technique, settings: &Settings) -> Result<()> {
    technique.check(settings)?;
    check_taa(technique, settings)?;
    check_view(technique, settings)
}

/// Checks that frames follow each other, and that more of them are of use.
fn check_taa(technique: &dyn Technique, settings: &Settings) -> Result<()> {
    if !settings.render.taa.is_on() {
        return Ok(());
    }
    settings.require_successive_frames("--taa on")?;
    require(!technique.is_reference(), || {
        format!(
            "--technique {} is a reference, which frames before would only blur: leave --taa on out, or take the mean of several by --accumulate",
            technique.name()
        )
    })
}

/// Whether a view shows what every frame has.
pub(super) fn is_of_every_frame(view: View) -> bool {
    matches!(
        view,
        View::Final
            | View::Albedo
            | View::Normal
            | View::Depth
            | View::MotionVectors
            | View::Direct
            | View::EnvironmentVisibility
    )
}

fn has(technique: &dyn Technique, view: View) -> bool {
    is_of_every_frame(view) || technique.has_view(view)
}

/// Checks that technique and settings leave something for the view to show.
fn check_view(technique: &dyn Technique, settings: &Settings) -> Result<()> {
    let view = settings.render.view;
    if view == View::Final {
        return Ok(());
    }
    let view_name = name(&view);
    require(has(technique, view), || {
        format!("--technique {} has no --view {view_name}: choose {}", technique.name(), alternatives(view))
    })?;
    require(settings.render.accumulate == 1, || {
        format!("--view {view_name} is of one frame, not of {}: leave --accumulate at 1", settings.render.accumulate)
    })?;
    require(view != View::EnvironmentVisibility || settings.environment.samples > 0, || {
        format!("--view {view_name} needs shadow rays towards the environment, and --environment-samples 0 leaves none")
    })?;
    require(view != View::Direct || settings.render.direct.is_on(), || {
        format!("--view {view_name} needs direct light: leave --direct on")
    })
}

/// The techniques that have a view, as a phrase.
fn alternatives(view: View) -> String {
    let names: Vec<_> = TECHNIQUES.iter().filter(|t| has(**t, view)).map(|t| t.name()).collect();
    format!("--technique {}", names.join(" or "))
}

pub(super) fn require(holds: bool, sentence: impl FnOnce() -> String) -> Result<()> {
    if holds { Ok(()) } else { Err(Error::Usage(sentence())) }
}

#[cfg(test)]
mod tests {
    use clap::ValueEnum;

    use super::*;
    use crate::settings::{LightSet, LightingMode, Reservoir, ShadowFilter, Switch, Technique as Named, Temporal};

    fn complaint(change: impl FnOnce(&mut Settings)) -> String {
        let error = check(&Settings::default().changed(change)).expect_err("a usage error");
        assert_eq!(error.exit_code(), 2);
        error.to_string()
    }

    #[test]
    fn every_technique_that_settings_name_is_listed() {
        for named in Named::value_variants() {
            let settings = Settings::default().changed(|s| s.render.technique = *named);
            assert_eq!(of(&settings).unwrap().name(), name(named));
            check(&settings).unwrap();
        }
        assert_eq!(TECHNIQUES.len(), Named::value_variants().len());
    }

    #[test]
    fn the_default_technique_or_that_of_points_has_every_view() {
        for view in View::value_variants() {
            let has = |technique| {
                let settings =
                    Settings::default().changed(|s| (s.render.technique, s.render.view) = (technique, *view));
                check(&settings).is_ok()
            };
            assert!(has(Named::Lgh) || has(Named::Pbgi), "{view:?}");
        }
    }

    #[test]
    fn final_gathering_says_what_it_has_no_use_for() {
        let complaint = |change: fn(&mut Settings)| {
            complaint(|s| {
                s.render.technique = Named::FinalGather;
                change(s);
            })
        };
        let sentence = complaint(|s| s.many_lights.bounces = 1);
        assert!(sentence.contains("--bounces 1 leaves none: give at least 2"), "{sentence}");
        let sentence = complaint(|s| s.pbgi.point_bounces = 4);
        assert!(sentence.contains("leave --point-bounces 4 out"), "{sentence}");
        let sentence = complaint(|s| s.lgh.first_level = 0);
        assert!(sentence.contains("leave --first-level at 1"), "{sentence}");
    }

    #[test]
    fn one_bounce_of_the_reference_of_points_is_all() {
        let sentence = complaint(|s| (s.render.technique, s.pbgi.point_bounces) = (Named::PbgiReference, 3));
        assert_eq!(
            sentence,
            "--technique pbgi-reference has one bounce, not 3: leave --point-bounces out, or choose --technique pbgi"
        );
    }

    #[test]
    fn a_missing_view_names_both() {
        let sentence = complaint(|s| (s.render.technique, s.render.view) = (Named::Direct, View::LightsTested));
        assert_eq!(sentence, "--technique direct has no --view lights-tested: choose --technique lgh");
        let sentence = complaint(|s| (s.render.technique, s.render.view) = (Named::PathTrace, View::Vpls));
        assert_eq!(sentence, "--technique path-trace has no --view vpls: choose --technique lgh or brute-force");
    }

    #[test]
    fn settings_in_the_way_of_a_view_are_named() {
        let sentence = complaint(|s| (s.many_lights.shadow_samples, s.render.view) = (0, View::ShadowRatio));
        assert_eq!(sentence, "--view shadow-ratio needs shadow samples, and --shadow-samples 0 leaves none");
        let sentence = complaint(|s| (s.many_lights.shadows, s.render.view) = (Switch::Off, View::SelectedLevel));
        assert_eq!(sentence, "--view selected-level needs shadow samples, and --shadows off leaves none");
        let sentence = complaint(|s| (s.lgh.filter, s.render.view) = (ShadowFilter::None, View::ShadowRatioFiltered));
        assert!(sentence.contains("shadow-ratio-filtered") && sentence.contains("--filter none"), "{sentence}");
        let sentence = complaint(|s| (s.render.accumulate, s.render.view) = (4, View::Normal));
        assert_eq!(sentence, "--view normal is of one frame, not of 4: leave --accumulate at 1");
        let sentence = complaint(|s| (s.environment.samples, s.render.view) = (0, View::EnvironmentVisibility));
        assert!(
            sentence.contains("environment-visibility") && sentence.contains("environment-samples 0"),
            "{sentence}"
        );
        let sentence = complaint(|s| (s.render.direct, s.render.view) = (Switch::Off, View::Direct));
        assert_eq!(sentence, "--view direct needs direct light: leave --direct on");
    }

    #[test]
    fn what_frames_cannot_take_over_is_named() {
        let shadows = Some(Temporal::Shadows);
        let sentence = complaint(|s| (s.lgh.temporal, s.render.accumulate) = (shadows, 4));
        assert!(sentence.starts_with("--temporal shadows needs frames that follow each other"), "{sentence}");
        assert!(sentence.contains("--accumulate 4"), "{sentence}");
        let sentence = complaint(|s| (s.lgh.temporal, s.many_lights.shadow_samples) = (shadows, 0));
        assert_eq!(sentence, "--temporal shadows needs shadow samples, and --shadow-samples 0 leaves none");
    }

    #[test]
    fn taa_is_not_for_means_and_references() {
        let sentence = complaint(|s| (s.render.taa, s.render.accumulate) = (Switch::On, 64));
        assert_eq!(
            sentence,
            "--taa on needs frames that follow each other, and --accumulate 64 takes the mean of independent ones: leave one of them out"
        );
        for technique in [Named::PathTrace, Named::BruteForce, Named::PbgiReference] {
            let sentence = complaint(|s| (s.render.taa, s.render.technique) = (Switch::On, technique));
            let start = format!("--technique {} is a reference, ", name(&technique));
            assert!(sentence.starts_with(&start) && sentence.contains("leave --taa on out"), "{sentence}");
        }
        for technique in [Named::Lgh, Named::Pbgi, Named::FinalGather, Named::Direct] {
            check(&Settings::default().changed(|s| (s.render.taa, s.render.technique) = (Switch::On, technique)))
                .unwrap();
        }
    }

    #[test]
    fn settings_of_another_technique_are_named() {
        let sentence = complaint(|s| (s.render.technique, s.lgh.reservoir) = (Named::Direct, Some(Reservoir::Race)));
        assert_eq!(sentence, "--technique direct has no reservoirs: leave --reservoir out, or choose --technique lgh");
        let volumes = Some(LightingMode::Volumes);
        let sentence = complaint(|s| (s.render.technique, s.lgh.lighting) = (Named::Direct, volumes));
        assert_eq!(
            sentence,
            "--technique direct has no lights of a hierarchy: leave --lighting out, or choose --technique lgh"
        );
        for lights in [LightSet::Vpl, LightSet::Both] {
            let sentence = complaint(|s| (s.many_lights.bounces, s.many_lights.lights) = (0, lights));
            assert_eq!(
                sentence,
                "--bounces 0 leaves no virtual point lights: give at least 1, or choose --lights scene"
            );
        }
    }
}
