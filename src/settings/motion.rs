//! Which moments of a scene that moves are shown.

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

use super::group::{Validate, settings_group};
use super::validate::require;
use super::values::name_or_index;
use crate::Result;

/// The farthest moment: beyond it a frame's step is lost in rounding.
const FARTHEST_S: f64 = 1e6;
/// Most frames per second of an animation.
const MOST_FPS: f64 = 1e5;

settings_group! {
    /// Which moments of a scene that moves are shown.
    #[command(next_help_heading = "Picture")]
    pub struct MotionSettings: Scene {
        /// Moment of the animation that the first frame shows, in seconds; animations repeat [default: 0]
        #[arg(id = "time", long = "time", value_name = "SECONDS", allow_negative_numbers = true)]
        pub time_s as "time": f64 = 0.0,
        /// Frames per second of the animation: frame i, counted from 0, shows --time + i / --fps; frames before the measured
        /// ones show --time [default: 30]
        #[arg(long, value_name = "F", allow_negative_numbers = true)]
        pub fps: f64 = 30.0,
        /// Animation that plays, by name or by index from 0; all, or none [default: the first]
        #[arg(long, value_name = "NAME|INDEX|all|none")]
        #[serde(deserialize_with = "name_or_index")]
        pub animation: Option<String> = None,
    }
}

/// Which light paths the frames of a run trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum VplSeeds {
    /// Those with the random numbers of the first frame.
    Held,
    /// A sixteenth of them others in every frame.
    Rolling,
    /// Others in every frame.
    Fresh,
}

/// What frames take over from the frames before them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Temporal {
    /// Nothing.
    Off,
    /// Shadow estimates per unit of the unshadowed lighting, as in the paper; light of the environment and of surfaces that shine.
    Shadows,
    /// The same, and unshadowed lighting.
    Indirect,
}

/// What means over the frames before do where the light has changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Antilag {
    /// Nothing.
    Off,
    /// In tiles of pixels whose light differs by more than its noise, the frames before count less.
    Tiles,
}

/// How the finest grid is made in a frame. The sums are the same to the bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum GridUpdate {
    /// From that of the frame before by the lights that have changed, where something moves or some light paths are new; anew
    /// where many have changed.
    Auto,
    /// Anew in every frame.
    Full,
    /// In both ways, and compared.
    Check,
}

impl MotionSettings {
    /// Whether the scene shall move: an animation is asked for, or another moment than the first, or, where `of_sequence`, every
    /// frame is written.
    #[must_use]
    pub fn is_asked_for(&self, of_sequence: bool) -> bool {
        match self.animation.as_deref() {
            Some(name) => name != "none",
            None => of_sequence || self.time_s != 0.0,
        }
    }

    /// The moment that a measured frame shows, in seconds.
    #[must_use]
    pub fn moment_s(&self, frame: u32) -> f64 {
        self.time_s + f64::from(frame) / self.fps
    }
}

impl Validate for MotionSettings {
    fn validate(&self) -> Result<()> {
        let Self { time_s, fps, .. } = self;
        require(time_s.abs() <= FARTHEST_S, || {
            format!("--time must be a number of seconds from -{FARTHEST_S} to {FARTHEST_S}, not {time_s}")
        })?;
        require(*fps > 0.0 && *fps <= MOST_FPS, || format!("--fps must be above 0 and at most {MOST_FPS}, not {fps}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_follow_each_other_from_the_first_moment_on() {
        let settings = MotionSettings { time_s: 2.0, fps: 25.0, animation: None };
        assert_eq!([0, 1, 50].map(|frame| settings.moment_s(frame)), [2.0, 2.04, 4.0]);
    }

    #[test]
    fn motion_is_asked_for_by_name_by_moment_and_by_frames() {
        let asked = |animation: Option<&str>, time_s, of_sequence| {
            let animation = animation.map(str::to_owned);
            MotionSettings { time_s, fps: 25.0, animation }.is_asked_for(of_sequence)
        };
        assert!(asked(Some("sun"), 0.0, false) && asked(None, 1.0, false) && asked(None, 0.0, true));
        assert!(!asked(None, 0.0, false) && !asked(Some("none"), 1.0, true));
    }

    #[test]
    fn moments_are_numbers_of_seconds() {
        let complaint =
            |time_s, fps| MotionSettings { time_s, fps, animation: None }.validate().unwrap_err().to_string();
        for time_s in [f64::NAN, f64::INFINITY, -2e6] {
            assert!(complaint(time_s, 30.0).starts_with("--time must be a number of seconds"), "{time_s}");
        }
        for fps in [f64::NAN, 0.0, -1.0, 1e6] {
            assert!(complaint(0.0, fps).starts_with("--fps must be above 0"), "{fps}");
        }
    }
}
