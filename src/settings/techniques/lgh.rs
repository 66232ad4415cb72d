//! What the lighting grid hierarchy alone has settings for.

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

use crate::Result;
use crate::settings::group::{Validate, settings_group};
use crate::settings::validate::{above_zero, require, within};
use crate::settings::{
    Antilag, CenterWeight, FirstLevelBuild, GridUpdate, LevelBuild, Levels, LightingMode, Lobe, Reservoir,
    ShadowEstimate, ShadowFilter, ShadowPoints, Temporal,
};
use crate::shared::{MAX_LEVEL, MIN_TOP_LEVEL};

/// How many pixels indirect light is found for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum IndirectSize {
    /// All.
    Full,
    /// Every second one of every second row.
    Half,
}

settings_group! {
    /// The lighting grid hierarchy.
    #[command(next_help_heading = "Method")]
    pub struct LghSettings: Parameters {
        /// Top level of the hierarchy, 2 to 10, or `auto` [default: auto]
        #[arg(long, value_name = "auto|N")]
        pub levels: Levels = Levels::Auto,
        /// Blending radius of a level, in cells of that level, above 0: larger is more accurate and slower [default: 1]
        #[arg(long, value_name = "CELLS", allow_negative_numbers = true)]
        pub alpha: f32 = 1.0,
        /// Emission lobe of a grid light [default: mixture]
        #[arg(long, value_enum, hide_possible_values = true, value_name = "mixture|clamped-normal|sh1|sh1-nonlinear")]
        pub lobe: Lobe = Lobe::Mixture,
        /// Position of a grid light: the mean of its lights weighted by luminance, or unweighted [default: intensity]
        #[arg(long, value_enum, hide_possible_values = true, value_name = "intensity|uniform")]
        pub center: CenterWeight = CenterWeight::Intensity,
        /// Finest level used for lighting: 0 is the lights themselves, 1 the finest grid [default: 1]
        #[arg(long, value_name = "0|1")]
        pub first_level: u32 = 1,
        /// Side of the interleaving pattern, in pixels, 1, 2 or 4: each pixel evaluates 1 / n² of the lights, which is faster and
        /// blurs indirect light [default: 1]
        #[arg(long, value_name = "1|2|4")]
        pub interleave: u32 = 1,
        /// Pixels that indirect light is found for: all, or every second one of every second row, whose light the others take over
        /// from those around them: more than twice as fast, and blurs indirect light [default: full]
        #[arg(long, value_enum, hide_possible_values = true, value_name = "full|half")]
        pub indirect_size: IndirectSize = IndirectSize::Full,
        /// Source of the coarse levels: the next finer level, the finest level, or all lights [default: cascade]
        #[arg(long, value_enum, hide_possible_values = true, value_name = "cascade|gather|scatter")]
        pub build: LevelBuild = LevelBuild::Cascade,
        /// How lights are summed into the finest grid: sorted by cell, or with atomic additions [default: sorted, but
        /// atomic where very many lights share a cell]
        #[arg(long, value_enum, hide_possible_values = true, value_name = "sorted|atomic")]
        pub scatter: Option<FirstLevelBuild> = None,
        /// Finest grid of a frame: where few lights change, that of the frame before with these subtracted and added; built anew; or both,
        /// which must be the same to the bit. The picture is the same [default: auto]
        #[arg(long, value_enum, hide_possible_values = true, value_name = "auto|full|check")]
        pub grid_update: GridUpdate = GridUpdate::Auto,
        /// First level whose lights get shadow rays, 0 to 10 [default: 1]
        #[arg(long, value_name = "L", help_heading = "Shadows")]
        pub shadow_from: u32 = 1,
        /// Target of shadow rays: a finer light that the chosen one stands for, or a point jittered around the chosen
        /// one by its standard deviation as in the paper [default: descent]
        #[arg(
            long, value_enum, hide_possible_values = true, value_name = "descent|deviation", help_heading = "Shadows"
        )]
        pub shadow_points: ShadowPoints = ShadowPoints::Descent,
        /// Estimator of shadowed light: the hierarchy's light times the shadow ratio as in the paper, the shadowed
        /// samples' own sum with outliers clamped, or that sum unclamped [default: corrected; ratio with
        /// --shadow-points deviation]
        #[arg(
            long,
            value_enum,
            hide_possible_values = true,
            value_name = "ratio|corrected|unbiased",
            help_heading = "Shadows"
        )]
        pub shadow_estimate: Option<ShadowEstimate> = None,
        /// How pixels find their lights: gathered by tiles in compute, or drawn as light volumes [default: gather,
        /// volumes with --reservoir race or lock]
        #[arg(long, value_enum, hide_possible_values = true, value_name = "volumes|gather", help_heading = "Shadows")]
        pub lighting: Option<LightingMode> = None,
        /// Reservoir update; gathering supports only `exact` [default: exact, or lock for volumes on a device without
        /// 64-bit atomics]
        #[arg(long, value_enum, hide_possible_values = true, value_name = "race|lock|exact", help_heading = "Shadows")]
        pub reservoir: Option<Reservoir> = None,
        /// Filter of the shadow estimates [default: atrous]
        #[arg(long, value_enum, hide_possible_values = true, value_name = "atrous|none", help_heading = "Shadows")]
        pub filter: ShadowFilter = ShadowFilter::Atrous,
        /// Means over the frames before: of nothing, of the shadow estimates as in the paper, or of all indirect light, which is calmer
        /// and lags behind changes of light; of light of the environment and of surfaces that shine with either [default: off]
        #[arg(long, value_enum, hide_possible_values = true, value_name = "off|shadows|indirect", help_heading = "Shadows")]
        pub temporal: Option<Temporal> = None,
        /// Least weight of the newest frame in these means: 0.05 is a mean of 20 frames or more, and the paper has 0.2. Smaller is calmer
        /// and slower to follow [default: 0.05, or 0.02 with --antilag tiles]
        #[arg(long, value_name = "W", allow_negative_numbers = true, help_heading = "Shadows")]
        pub temporal_weight: Option<f32> = None,
        /// What these means do where the light has changed: nothing, or give up what the frames before know in tiles of 8x8 pixels whose
        /// light differs by more than its noise [default: off]
        #[arg(long, value_enum, hide_possible_values = true, value_name = "off|tiles", help_heading = "Shadows")]
        pub antilag: Antilag = Antilag::Off,
        /// Rounds of shadow samples in a frame without history, each of which counts as a frame; in others a pixel whose history is
        /// short takes rounds until it has 4, 1 to 64 [default: 1; 16 with --temporal shadows --antilag tiles]
        #[arg(long, value_name = "N", help_heading = "Shadows")]
        pub temporal_rounds: Option<u32> = None,
    }
}

impl LghSettings {
    /// What decides which levels are built over the lights, and what is measured for them before the first frame.
    #[must_use]
    pub fn measured(&self) -> impl PartialEq + use<> {
        (self.levels, self.build, self.scatter)
    }

    /// The estimate that is asked for, else the default. Only rays that end on lights can find what the hierarchy is wrong by.
    #[must_use]
    pub fn shadow_estimate_or_default(&self) -> ShadowEstimate {
        self.shadow_estimate.unwrap_or(match self.shadow_points {
            ShadowPoints::Descent => ShadowEstimate::Corrected,
            ShadowPoints::Deviation => ShadowEstimate::Ratio,
        })
    }

    /// The least weight that is asked for, else the default: a long mean needs something that notices where it is outdated.
    #[must_use]
    pub fn temporal_weight_or_default(&self) -> f32 {
        self.temporal_weight.unwrap_or(match self.antilag {
            Antilag::Off => 0.05,
            Antilag::Tiles => 0.02,
        })
    }

    /// The rounds that are asked for, else the default: the paper has one, and so has what cannot have more.
    #[must_use]
    pub fn temporal_rounds_or_default(&self) -> u32 {
        let has_more = self.antilag == Antilag::Tiles && self.one_round_only().is_none();
        self.temporal_rounds.unwrap_or(if has_more { 16 } else { 1 })
    }

    /// The setting with which a frame has one round of shadow samples only, and what to choose instead.
    #[must_use]
    pub fn one_round_only(&self) -> Option<[&'static str; 2]> {
        let draws_volumes = self.lighting == Some(LightingMode::Volumes);
        if self.temporal != Some(Temporal::Shadows) {
            Some(["anything but --temporal shadows", "--temporal shadows"])
        } else if self.interleave > 1 {
            Some(["--interleave", "--interleave 1"])
        } else if draws_volumes || matches!(self.reservoir, Some(Reservoir::Race | Reservoir::Lock)) {
            Some(["light volumes", "--lighting gather and --reservoir exact"])
        } else {
            None
        }
    }
}

impl Validate for LghSettings {
    fn validate(&self) -> Result<()> {
        if let Levels::Fixed(levels) = self.levels {
            within("levels", levels, MIN_TOP_LEVEL..=MAX_LEVEL)?;
        }
        above_zero("alpha", self.alpha)?;
        let weight = self.temporal_weight_or_default();
        require(weight > 0.0 && weight <= 1.0, || {
            format!("--temporal-weight must be above 0 and at most 1, not {weight}")
        })?;
        within("temporal-rounds", self.temporal_rounds_or_default(), 1..=64)?;
        within("first-level", self.first_level, 0..=1)?;
        require(matches!(self.interleave, 1 | 2 | 4), || {
            format!("--interleave must be 1, 2 or 4, not {}", self.interleave)
        })?;
        within("shadow-from", self.shadow_from, 0..=MAX_LEVEL)?;
        let picks_otherwise = matches!(self.reservoir, Some(Reservoir::Race | Reservoir::Lock));
        require(!picks_otherwise || self.lighting != Some(LightingMode::Gather), || {
            "--lighting gather has exact reservoirs only: leave --reservoir out, or choose --lighting volumes"
                .to_owned()
        })?;
        require(self.build != LevelBuild::Scatter || self.scatter != Some(FirstLevelBuild::Sorted), || {
            "--build scatter adds lights to every level, by atomic additions only: leave --scatter out, or choose another \
             --build"
                .to_owned()
        })?;
        let adds_atomically = self.build == LevelBuild::Scatter || self.scatter == Some(FirstLevelBuild::Atomic);
        require(self.grid_update != GridUpdate::Check || !adds_atomically, || {
            "--grid-update check compares with lights sorted by cell: leave --build scatter and --scatter atomic out"
                .to_owned()
        })
    }
}
