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

/// Colours of points by where their light comes from: `LIGHT_OF_*`.
const LIGHT_COLORS: [u32; 4] = [0xff5a36, 0xffd23f, 0x3a86ff, 0x7ac74f];
const LIGHT_WORDS: [&str; 4] = ["own", "children", "primary", "above"];

/// Colours of pixels by the caches that they have: `CACHES_*`.
const MISS_COLORS: [u32; 4] = [0x74829a, 0xffe119, 0xf58231, 0xff2020];
const MISS_WORDS: [&str; 4] = ["reach", "twice", "nearest", "none"];

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

/// The map of whole numbers that have a colour each.
fn numbered(colors: &'static [u32]) -> ColorMap {
    ColorMap { colors, end: Some((colors.len() - 1) as f32) }
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
        View::MotionVectors | View::LightsTested | View::LightCount | View::CacheCount => {
            Some(ColorMap { colors: INFERNO, end: None })
        }
        View::PrimaryPoints | View::PrimaryPointsAbove => Some(numbered(&LEVEL_COLORS)),
        View::SecondaryPoints | View::SecondaryPointsAbove => Some(numbered(&LIGHT_COLORS)),
        View::CacheMisses => Some(numbered(&MISS_COLORS)),
        View::Final
        | View::Albedo
        | View::Normal
        | View::Direct
        | View::Indirect
        | View::LevelWeights
        | View::Vpls
        | View::CacheWeights => None,
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
    /// A patch for each of these.
    Patches(Vec<Patch>),
}

/// A patch of colour with what it stands for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Patch {
    /// sRGB colour, `0xRRGGBB`.
    pub color: u32,
    /// A number or a word.
    pub text: String,
}

/// Patches of levels.
#[must_use]
pub fn level_patches([first, last]: [u32; 2]) -> Scale {
    let patch = |level: u32| Patch { color: LEVEL_COLORS[level as usize % MAX_COLORS], text: level.to_string() };
    Scale::Patches((first..=last).map(patch).collect())
}

/// Patches of words.
fn word_patches(colors: &[u32], words: &[&str]) -> Scale {
    let patch = |(color, word): (&u32, &&str)| Patch { color: *color, text: (*word).to_owned() };
    Scale::Patches(colors.iter().zip(words).map(patch).collect())
}

/// The legend of a view whose levels go from the first to the last of `levels`, for a picture whose colour map ended at `measured_end`; `None` where the view needs none.
#[must_use]
pub fn legend_of(view: View, levels: [u32; 2], measured_end: f32) -> Option<(&'static str, Scale)> {
    let title = match view {
        View::Depth => "depth, m",
        View::MotionVectors => "moved, pixels",
        View::EnvironmentVisibility => "S / U of the environment",
        View::ShadowRatio => "S / U, unfiltered",
        View::ShadowRatioFiltered => "S / U, filtered",
        View::SelectedLevel => "mean level chosen",
        View::LightsTested => "lights tested per pixel",
        View::LightCount => "lights per pixel",
        View::LevelWeights => "share of each level",
        View::PrimaryPoints | View::PrimaryPointsAbove => "levels above the leaves",
        View::SecondaryPoints | View::SecondaryPointsAbove => "where light comes from",
        View::CacheCount => "caches per pixel",
        View::CacheMisses => "caches within",
        _ => return None,
    };
    let scale = match view {
        View::SelectedLevel | View::LevelWeights | View::PrimaryPoints | View::PrimaryPointsAbove => {
            level_patches(levels)
        }
        View::SecondaryPoints | View::SecondaryPointsAbove => word_patches(&LIGHT_COLORS, &LIGHT_WORDS),
        View::CacheMisses => word_patches(&MISS_COLORS, &MISS_WORDS),
        _ => {
            let whole = matches!(view, View::LightsTested | View::LightCount | View::CacheCount);
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
