//! Which view goes with which technique and settings.

use clap::ValueEnum;

use super::validate::require;
use super::{Filter, Settings, Switch, Technique, View, name};
use crate::{Error, Result};

impl Technique {
    /// Whether frames of this technique have what a view shows.
    #[must_use]
    pub fn has(self, view: View) -> bool {
        match view {
            View::Final | View::Albedo | View::Normal | View::Depth | View::Direct => true,
            View::Vpls => matches!(self, Self::Lgh | Self::BruteForce),
            View::Indirect
            | View::ShadowRatio
            | View::ShadowRatioFiltered
            | View::SelectedLevel
            | View::Overdraw
            | View::LightCount
            | View::LevelWeights => self == Self::Lgh,
        }
    }
}

impl View {
    /// Whether the view shows what becomes of shadow samples.
    fn needs_shadows(self) -> bool {
        matches!(self, Self::ShadowRatio | Self::ShadowRatioFiltered | Self::SelectedLevel)
    }
}

impl Settings {
    /// Checks that there are shadow samples, which `what` needs.
    ///
    /// # Errors
    /// [`Error::Usage`] with one sentence that names `what` and the setting in its way.
    pub fn require_shadow_samples(&self, what: &str) -> Result<()> {
        let obstacle = match (self.many_lights.shadow_samples, self.many_lights.shadows) {
            (0, _) => "shadow-samples 0",
            (_, Switch::Off) => "shadows off",
            (_, Switch::On) => return Ok(()),
        };
        Err(Error::Usage(format!("{what} needs shadow samples, and {obstacle} leaves none")))
    }

    /// Checks that the technique and the other settings leave something for the view to show.
    ///
    /// # Errors
    /// [`Error::Usage`] with one sentence that names the view and what is in its way.
    pub fn validate_view(&self) -> Result<()> {
        if self.render.view == View::Final {
            return Ok(());
        }
        let view = name(&self.render.view);
        require(self.render.technique.has(self.render.view), || {
            format!(
                "technique {} has no view {view}: choose {}",
                name(&self.render.technique),
                alternatives(self.render.view)
            )
        })?;
        require(self.render.accumulate == 1, || {
            format!("view {view} is of one frame, not of {}: leave accumulate at 1", self.render.accumulate)
        })?;
        require(self.render.view != View::Direct || self.render.direct.is_on(), || {
            format!("view {view} needs direct light: leave direct on")
        })?;
        if self.render.view.needs_shadows() {
            self.require_shadow_samples(&format!("view {view}"))?;
        }
        require(self.render.view != View::ShadowRatioFiltered || self.lgh.filter != Filter::None, || {
            format!("view {view} needs a filter, and filter none is none: choose view shadow-ratio, or filter atrous")
        })
    }
}

/// The techniques that have a view, as a phrase.
fn alternatives(view: View) -> String {
    let names: Vec<_> = Technique::value_variants().iter().filter(|t| t.has(view)).map(name).collect();
    format!("technique {}", names.join(" or "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn complaint(change: impl FnOnce(&mut Settings)) -> String {
        let mut settings = Settings::default();
        change(&mut settings);
        let error = settings.validate().expect_err("a usage error");
        assert_eq!(error.exit_code(), 2);
        error.to_string()
    }

    #[test]
    fn the_default_technique_has_every_view() {
        for view in View::value_variants() {
            Settings::default().changed(|s| s.render.view = *view).validate().unwrap();
        }
    }

    #[test]
    fn a_missing_view_names_both() {
        let sentence = complaint(|s| (s.render.technique, s.render.view) = (Technique::Direct, View::Overdraw));
        assert_eq!(sentence, "technique direct has no view overdraw: choose technique lgh");
        let sentence = complaint(|s| (s.render.technique, s.render.view) = (Technique::PathTrace, View::Vpls));
        assert_eq!(sentence, "technique path-trace has no view vpls: choose technique lgh or brute-force");
    }

    #[test]
    fn settings_in_the_way_are_named() {
        let sentence = complaint(|s| (s.many_lights.shadow_samples, s.render.view) = (0, View::ShadowRatio));
        assert_eq!(sentence, "view shadow-ratio needs shadow samples, and shadow-samples 0 leaves none");
        let sentence = complaint(|s| (s.many_lights.shadows, s.render.view) = (Switch::Off, View::SelectedLevel));
        assert_eq!(sentence, "view selected-level needs shadow samples, and shadows off leaves none");
        let sentence = complaint(|s| (s.lgh.filter, s.render.view) = (Filter::None, View::ShadowRatioFiltered));
        assert!(sentence.contains("shadow-ratio-filtered") && sentence.contains("filter none"), "{sentence}");
        let sentence = complaint(|s| (s.render.accumulate, s.render.view) = (4, View::Normal));
        assert_eq!(sentence, "view normal is of one frame, not of 4: leave accumulate at 1");
        let sentence = complaint(|s| (s.render.direct, s.render.view) = (Switch::Off, View::Direct));
        assert_eq!(sentence, "view direct needs direct light: leave direct on");
    }
}
