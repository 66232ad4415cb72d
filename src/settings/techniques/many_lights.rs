//! What the techniques of many lights share; path tracing has the bounces.

use crate::Result;
use crate::settings::group::{Validate, settings_group};
use crate::settings::validate::{at_least_one, require, within};
use crate::settings::values::count;
use crate::settings::{LightSet, Switch, VplImportance, VplSeeds};
use crate::shared::MAX_SHADOW_SAMPLES;

settings_group! {
    /// Which lights there are, and how any of them lights a pixel.
    #[command(next_help_heading = "Method")]
    pub struct ManyLightSettings: Parameters {
        /// Lights of the hierarchy: traced virtual point lights, the scene's point lights, or both [default: vpl]
        #[arg(long, value_enum, hide_possible_values = true, value_name = "vpl|scene|both")]
        pub lights: LightSet = LightSet::Vpl,
        /// Virtual point lights, about this many, 1 or more: 100000, 100k, 1e5; more resolve finer indirect light, but
        /// take more memory and time to build the hierarchy [default: 100000]
        #[arg(long, value_name = "N", value_parser = count)]
        pub vpls: u32 = 100_000,
        /// Maximum diffuse bounces of a light path, 1 to 64: more are brighter, especially in white rooms [default: 3]
        #[arg(long, value_name = "N")]
        pub bounces: u32 = 3,
        /// Importance sampling of light paths: by the camera's view, in scenes where few uniform paths would
        /// contribute, or uniform [default: view]
        #[arg(long, value_enum, hide_possible_values = true, value_name = "view|none")]
        pub vpl_importance: VplImportance = VplImportance::View,
        /// Random numbers of the light paths over the frames of a run: the same in all, new for a sixteenth of them in each frame, or new in each; shadow samples are
        /// new in every frame then [default: held where something moves; else every frame is the same]
        #[arg(long, value_enum, hide_possible_values = true, value_name = "held|rolling|fresh")]
        pub vpl_seeds: Option<VplSeeds> = None,
        /// Distance below which a light is clamped, in radii of the disc that a VPL represents; 0 disables clamping
        /// [default: 1]
        #[arg(long, value_name = "RADII", allow_negative_numbers = true)]
        pub clamp: f32 = 1.0,
        /// Shadow rays per pixel, 0 to 16; 0 turns indirect shadows off; more reduce noise, and take most of the frame
        /// time [default: 4]
        #[arg(long, value_name = "K", help_heading = "Shadows")]
        pub shadow_samples: u32 = 4,
        /// Shadows of the indirect light [default: on]
        #[arg(long, value_enum, hide_possible_values = true, value_name = "on|off", help_heading = "Shadows")]
        pub shadows: Switch = Switch::On,
    }
}

impl ManyLightSettings {
    /// What decides which lights are traced.
    #[must_use]
    pub fn traced(&self) -> impl PartialEq + use<> {
        let Self { lights, vpls, bounces, vpl_importance, vpl_seeds: _, clamp: _, shadow_samples: _, shadows: _ } =
            self;
        (*lights, *vpls, *bounces, *vpl_importance)
    }
}

impl Validate for ManyLightSettings {
    fn validate(&self) -> Result<()> {
        at_least_one("vpls", self.vpls)?;
        within("bounces", self.bounces, 0..=64)?;
        require(self.clamp.is_finite() && self.clamp >= 0.0, || {
            format!("--clamp must be a finite number, 0 or above, not {}", self.clamp)
        })?;
        within("shadow-samples", self.shadow_samples, 0..=MAX_SHADOW_SAMPLES)
    }
}
