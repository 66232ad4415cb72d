//! How views of intermediate results look: colours, scales and legends. What each view holds is in `docs/views.md`.

pub mod legend;

use crate::settings::View;
use crate::shared::MAX_LEVEL;

/// Most colours of a [`ColorMap`]: as many as there are levels.
pub const MAX_COLORS: usize = MAX_LEVEL as usize + 1;

/// sRGB colour, `0xRRGGBB`, of pixels without a value: no surface, or no light.
pub const NO_VALUE: u32 = 0x303c50;

/// sRGB colours, `0xRRGGBB`, of the levels 0..=[`MAX_LEVEL`]: neighbours are easy to tell apart.
pub const LEVEL_COLORS: [u32; MAX_COLORS] =
    [0xf2f2f2, 0xe63040, 0xf59031, 0xffe119, 0x3cb44b, 0x42d4f4, 0x4363d8, 0x911eb4, 0xf062e6, 0x9a6324, 0xaaffc3];

/// The inferno map of matplotlib (CC0), dark to bright.
const INFERNO: &[u32] = &[0x000004, 0x1f0c48, 0x550f6d, 0x88226a, 0xba3655, 0xe35933, 0xf98c0a, 0xf9c932, 0xfcffa4];

/// From a number to a colour: piecewise linear in sRGB between evenly spaced colours, from 0 to an upper end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColorMap {
    /// sRGB colours `0xRRGGBB` from the lower end to the upper, 2..=[`MAX_COLORS`] of them.
    pub colors: &'static [u32],
    /// The value at the upper end; `None` is the largest of the picture.
    pub end: Option<f32>,
}

/// The colour map of a view that shows one number per pixel.
#[must_use]
pub fn color_map(view: View) -> Option<ColorMap> {
    match view {
        View::Depth => Some(ColorMap { colors: &[0xffffff, 0x101010], end: None }),
        View::ShadowRatio | View::ShadowRatioFiltered | View::EnvironmentVisibility => {
            Some(ColorMap { colors: &[0x000000, 0xffffff], end: Some(1.0) })
        }
        View::SelectedLevel => Some(ColorMap { colors: &LEVEL_COLORS, end: Some(MAX_LEVEL as f32) }),
        View::LightsTested | View::LightCount => Some(ColorMap { colors: INFERNO, end: None }),
        View::Final | View::Albedo | View::Normal | View::Direct | View::Indirect | View::LevelWeights | View::Vpls => {
            None
        }
    }
}

/// What is written beside the scale.
#[derive(Clone, Debug, PartialEq)]
pub enum Scale {
    /// A bar from 0 to a value.
    Bar {
        /// Colours from 0 to the end.
        map: ColorMap,
        /// The value at the end of the bar.
        end: f32,
        /// Whether only whole numbers occur.
        whole: bool,
    },
    /// A patch for each level.
    Levels {
        /// The first level with a patch.
        first: u32,
        /// The last.
        last: u32,
    },
}

/// The legend of a view whose levels are `first` to `last`, for a picture whose colour map ended at `measured_end`; `None` where the view needs none.
#[must_use]
pub fn legend_of(view: View, [first, last]: [u32; 2], measured_end: f32) -> Option<(&'static str, Scale)> {
    let title = match view {
        View::Depth => "depth, m",
        View::EnvironmentVisibility => "S / U of the environment",
        View::ShadowRatio => "S / U, unfiltered",
        View::ShadowRatioFiltered => "S / U, filtered",
        View::SelectedLevel => "mean level chosen",
        View::LightsTested => "lights tested per pixel",
        View::LightCount => "lights per pixel",
        View::LevelWeights => "share of each level",
        _ => return None,
    };
    let scale = match view {
        View::SelectedLevel | View::LevelWeights => Scale::Levels { first, last },
        _ => {
            let whole = matches!(view, View::LightsTested | View::LightCount);
            color_map(view).map(|map| Scale::Bar { map, end: map.end.unwrap_or(measured_end), whole })?
        }
    };
    Some((title, scale))
}

/// A number with as many digits as tell something.
#[must_use]
pub fn plain_number(v: f32) -> String {
    match v.abs() {
        a if a >= 1000.0 || (a > 0.0 && a < 0.001) => format!("{v:>9.2e}"),
        _ => format!("{v:>9.4}"),
    }
}
