//! The split view and the pixel inspector: what is held on the left, and which pixel is looked at.

use super::Session;
use crate::app::window::panel::facts::{HeldFacts, SideFacts};
use crate::app::window::stage::{Done, FrameSet};
use crate::renderer::FrameFeedback;
use crate::settings::Settings;

/// The left side of a split view.
pub(super) struct Split {
    /// Its settings, of which how pictures are rendered counts; all else is as on the right side.
    settings: Settings,
    /// Where it ends, 0 to 1 from the left.
    pub(super) divider: f32,
    feedback: Option<FrameFeedback>,
    /// Sum of its passes in the last frame.
    ms: f64,
}

/// Which pixel is inspected.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Inspector {
    Off,
    /// The one under the cursor, which was here last.
    Cursor([f32; 2]),
    /// The one at this point of the window.
    At([f32; 2]),
}

impl Inspector {
    pub(super) fn is_on(self) -> bool {
        self != Self::Off
    }

    /// The point, 0 to 1 from the top left corner of the window.
    pub(super) fn point(self) -> Option<[f32; 2]> {
        match self {
            Self::Off => None,
            Self::Cursor(at) | Self::At(at) => Some(at),
        }
    }
}

impl Split {
    /// Takes note of a frame.
    pub(super) fn take(&mut self, done: Done) {
        self.ms = done.result.gpu_ms();
        self.feedback = done.feedback;
    }

    /// What the panel shows of it; `others` are the settings of the right side.
    pub(super) fn facts<'a>(&'a self, shown: Option<&'a FrameSet>, others: &Settings) -> HeldFacts<'a> {
        HeldFacts {
            side: SideFacts {
                shapes: shown.and_then(|set| Some(set.held.as_ref()?.renderer.shapes())),
                feedback: self.feedback.as_ref(),
            },
            divider: self.divider,
            differences: with_shared(&self.settings, others).differences(others).unwrap_or_default(),
            ms: self.ms,
        }
    }
}

impl Session {
    /// Begins or ends the split view.
    pub(super) fn toggle_split(&mut self) {
        self.split = match self.split.take() {
            Some(_) => None,
            None => Some(Split { settings: self.settings.clone(), divider: 0.5, feedback: None, ms: 0.0 }),
        };
        self.restart();
    }

    /// Exchanges the sides.
    pub(super) fn swap_sides(&mut self) {
        let Some(split) = &mut self.split else {
            self.panel.say("there is no split view to swap: C starts one".to_owned());
            return;
        };
        let shared = self.settings.clone();
        let held = std::mem::replace(&mut split.settings, shared.clone());
        self.settings = with_shared(&held, &shared);
        self.restart();
    }

    /// Puts the divider somewhere.
    pub(super) fn move_divider(&mut self, at: f32) {
        if let Some(split) = &mut self.split {
            split.divider = at;
        }
    }

    /// Begins or ends to inspect what is under the cursor.
    pub(super) fn toggle_inspector(&mut self) {
        self.inspector = if self.inspector.is_on() { Inspector::Off } else { Inspector::Cursor([0.5; 2]) };
    }

    /// Other settings or sides: what was learnt of the time and of the mean counts no longer.
    fn restart(&mut self) {
        self.scale.forget(self.window_px());
        self.begins_anew = true;
    }

    /// Settings of the left side.
    pub(super) fn held_settings(&self) -> Option<Settings> {
        let split = self.split.as_ref()?;
        Some(with_shared(&split.settings, &self.present_settings()))
    }
}

/// Settings with those of others, but for how pictures are rendered: in that alone the sides differ.
fn with_shared(settings: &Settings, others: &Settings) -> Settings {
    settings.clone().with_groups_of(others, |scope| !scope.is_method())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::testing::every_value_changed;

    #[test]
    fn the_sides_differ_in_the_method_alone() {
        let (held, others) = (every_value_changed(), Settings::default());
        let differences = with_shared(&held, &others).differences(&others).unwrap();
        for key in Settings::keys() {
            let differs = differences.iter().any(|(different, _)| *different == key);
            assert_eq!(differs, Settings::scope_of(&key).unwrap().is_method(), "{key}");
        }
    }
}
