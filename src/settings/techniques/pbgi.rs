//! What point-based global illumination has settings for.

use crate::Result;
use crate::settings::group::{Validate, settings_group};
use crate::settings::validate::{require, within};
use crate::settings::{Coverage, Hemisphere, MicroFill, Selection, Switch};
use crate::shared::{MAX_POINTS, MIN_POINTS, POINT_LEAVES};

settings_group! {
    /// Point-based global illumination.
    #[command(next_help_heading = "Method")]
    pub struct PbgiSettings: Parameters {
        /// Points that represent the scene's surfaces, a power of two from 4096 to 2097152: more resolve finer detail,
        /// but cost memory and time [default: 524288]
        #[arg(long, value_name = "N")]
        pub points: u32 = 524_288,
        /// How micro-buffers are rendered: a ray for each texel, or points splatted as in the paper [default: rays]
        #[arg(long, value_enum, hide_possible_values = true, value_name = "rays|points")]
        pub micro: MicroFill = MicroFill::Rays,
        /// Coverage of a texel by points: fractional, or all or nothing as in the paper [default: fraction]
        #[arg(long, value_enum, hide_possible_values = true, value_name = "fraction|binary")]
        pub coverage: Coverage = Coverage::Fraction,
        /// Mapping of the hemisphere to the texels of a micro-buffer: a paraboloid as in the paper, or the concentric
        /// map [default: paraboloid]
        #[arg(long, value_enum, hide_possible_values = true, value_name = "paraboloid|concentric")]
        pub hemisphere: Hemisphere = Hemisphere::Paraboloid,
        /// How to find the points that need their own micro-buffer: top-down by levels, with or without borrowing light
        /// from a point above or below in the tree; bottom-up first as in the paper; or as `levels`, with the paper's
        /// atomic arrival counters [default: borrow]
        #[arg(long, value_enum, hide_possible_values = true, value_name = "borrow|levels|paper|arrival")]
        pub selection: Selection = Selection::Borrow,
        /// Leaves per point that cast shadow rays towards suns and lamps, 1 to 4 [default: 4]
        #[arg(long, value_name = "N")]
        pub sun_leaves: u32 = 4,
        /// Bounces of light between surfaces, 1 to 16 [default: 1]
        #[arg(long, value_name = "N")]
        pub point_bounces: u32 = 1,
        /// Reuse from the previous frame what does not depend on the camera; the picture is the same [default: off]
        #[arg(long, value_enum, hide_possible_values = true, value_name = "on|off")]
        pub reuse: Switch = Switch::Off,
    }
}

impl Validate for PbgiSettings {
    fn validate(&self) -> Result<()> {
        let fitting = self.points.clamp(MIN_POINTS, MAX_POINTS).next_power_of_two();
        require(self.points == fitting, || {
            format!(
                "--points must be a power of two from {MIN_POINTS} to {MAX_POINTS}, not {}: {fitting} would do",
                self.points
            )
        })?;
        require(self.hemisphere == Hemisphere::Paraboloid || self.micro == MicroFill::Rays, || {
            "--hemisphere concentric needs rays: choose --micro rays, or --hemisphere paraboloid".to_owned()
        })?;
        within("sun-leaves", self.sun_leaves, 1..=POINT_LEAVES)?;
        within("point-bounces", self.point_bounces, 1..=16)
    }
}
