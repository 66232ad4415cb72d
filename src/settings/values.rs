//! The kinds of value a setting can have, as they are written in files and on the command line.

use std::fmt;
use std::str::FromStr;

use crate::shared;
use clap::ValueEnum;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// The word that a value has on the command line and in settings files.
pub fn name(value: &impl ValueEnum) -> String {
    value.to_possible_value().map_or_else(String::new, |v| v.get_name().to_owned())
}

/// A number of things as people write it: `100000`, `100k`, `2M`, `1e5`.
///
/// # Errors
/// When it is no whole number from 0 to 4294967295.
pub(super) fn count(text: &str) -> Result<u32, String> {
    let (digits, unit) = match text.chars().last() {
        Some('k' | 'K') => (&text[..text.len() - 1], 1e3),
        Some('m' | 'M') => (&text[..text.len() - 1], 1e6),
        _ => (text, 1.0),
    };
    // Unlike f64's own notation: no signs, infinities or names.
    let is_number = digits.starts_with(|c: char| c.is_ascii_digit() || c == '.');
    let number = digits.parse::<f64>().ok().filter(|_| is_number).map(|number| number * unit);
    // `1.5k` is whole but for rounding, `0.5` and `1.2345k` are not.
    let is_whole = |n: &f64| (n - n.round()).abs() < 1e-6 && (0.0..=f64::from(u32::MAX)).contains(&n.round());
    number
        .filter(is_whole)
        .map(|n| n.round() as u32)
        .ok_or_else(|| format!("`{text}` is not a whole number such as 100000, 100k, 2M or 1e5"))
}

/// Which pipeline renders.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Technique {
    /// The lighting grid hierarchy: direct and indirect light.
    Lgh,
    /// Point-based global illumination: light of an environment, of suns and of lamps, with one bounce or more.
    Pbgi,
    /// Points that look light of all bounces up in the lighting grid hierarchy, and what pixels see of them.
    FinalGather,
    /// Direct light only.
    Direct,
    /// Every virtual point light shaded at every pixel: the reference for the hierarchy.
    BruteForce,
    /// Unidirectional path tracing: the reference for everything.
    PathTrace,
    /// Every point lit and gathered at every pixel: the reference for point-based global illumination.
    PbgiReference,
}

/// A part of the picture that can be left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Switch {
    /// On.
    On,
    /// Off.
    Off,
}

impl Switch {
    /// Whether it is on.
    #[must_use]
    pub fn is_on(self) -> bool {
        self == Self::On
    }
}

/// What the camera sees of the backs of single-sided surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum BackFaces {
    /// They are surfaces like all others.
    Keep,
    /// The camera looks through them.
    Cull,
}

/// How textures are read where the camera sees them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum TextureFilter {
    /// With up to eight samples along the direction in which a pixel is stretched.
    Anisotropic,
    /// With one, which blurs surfaces seen at a flat angle.
    Trilinear,
}

/// Emission lobe of a grid light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Lobe {
    /// A clamped cosine around the mean normal for the coherent part of the normals, uniform for the rest.
    Mixture,
    /// A clamped cosine around the mean normal, scaled by its length: loses flux where normals disagree.
    ClampedNormal,
    /// First-order spherical harmonics, clamped at zero.
    Sh1,
    /// Geomerics' non-linear first-order reconstruction: never negative, preserves the flux.
    Sh1Nonlinear,
}

impl Lobe {
    /// The number that shaders know it by.
    #[must_use]
    pub fn code(self) -> u32 {
        match self {
            Self::Mixture => shared::LOBE_MIXTURE,
            Self::ClampedNormal => shared::LOBE_CLAMPED_NORMAL,
            Self::Sh1 => shared::LOBE_SH1,
            Self::Sh1Nonlinear => shared::LOBE_SH1_NONLINEAR,
        }
    }
}

/// Position of a grid light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum CenterWeight {
    /// The mean position of its lights, weighted by luminance.
    Intensity,
    /// The unweighted mean position of its lights.
    Uniform,
}

/// What the picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum View {
    /// The finished picture.
    #[default]
    Final,
    /// Linear base colour.
    Albedo,
    /// Shading normal.
    Normal,
    /// Distance along the viewing direction.
    Depth,
    /// How far surfaces have moved in the picture since the frame before.
    MotionVectors,
    /// Direct light.
    Direct,
    /// Fraction of the environment's light that reaches the surface.
    EnvironmentVisibility,
    /// Indirect light without shadows.
    Indirect,
    /// Shadow ratio before the filter.
    ShadowRatio,
    /// Shadow ratio after the filter.
    ShadowRatioFiltered,
    /// Mean level of the lights chosen for shadow rays.
    SelectedLevel,
    /// Lights that a pixel tests: candidates of its tile, or light-volume fragments.
    #[value(alias = "overdraw")]
    #[serde(alias = "overdraw")]
    LightsTested,
    /// Lights per pixel that contribute.
    LightCount,
    /// Blending weights: the share of each level in the lights that contribute.
    LevelWeights,
    /// Virtual point lights as points.
    Vpls,
    /// Primary points as discs, by their level in the tree.
    PrimaryPoints,
    /// The same from above, with the camera.
    PrimaryPointsAbove,
    /// Points that primary points see as discs, by where their light comes from.
    SecondaryPoints,
    /// The same from above, with the camera.
    SecondaryPointsAbove,
    /// Caches that light each pixel.
    CacheCount,
    /// The weights of those caches.
    CacheWeights,
    /// Pixels outside every cache's reach.
    CacheMisses,
}

/// Which lights enter the hierarchy.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum LightSet {
    /// Virtual point lights traced from the scene's lights.
    Vpl,
    /// The point lights of the scene file.
    Scene,
    /// Both kinds.
    Both,
}

/// Where light paths start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum VplImportance {
    /// More where the light that the camera sees comes from.
    View,
    /// Uniformly.
    None,
}

/// How the lights of the hierarchy reach the pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum LightingMode {
    /// Light volumes: polyhedra drawn with additive blending, as in the paper.
    Volumes,
    /// Tiles of pixels gather the lights within reach, in compute.
    Gather,
}

/// How a pixel's reservoirs are updated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Reservoir {
    /// Plain read-modify-write, without locks.
    Race,
    /// With a lock for each pixel.
    Lock,
    /// One 64-bit atomic minimum: independent of order, deterministic.
    Exact,
}

/// What traces rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Rays {
    /// The BVH in compute shaders.
    Bvh,
    /// The device's acceleration structures (`VK_KHR_ray_query`).
    Query,
}

/// How the levels above the first are built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum LevelBuild {
    /// Every level gathers from the one below.
    Cascade,
    /// Every level gathers from the first, as in the paper.
    Gather,
    /// Every light scatters into every level (slow, for comparison).
    Scatter,
}

/// How the lights are summed into the finest grid. The sums are the same to the bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum FirstLevelBuild {
    /// Each vertex sums the lights of its cells, listed by cell.
    Sorted,
    /// Each light is added to its vertices with atomic additions.
    Atomic,
}

/// Where on a chosen light the shadow ray ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum ShadowPoints {
    /// On one of the S1 lights that the chosen light is made of, picked by luminance.
    Descent,
    /// Jittered around the chosen light's centre by its standard deviation, as in the paper.
    Deviation,
}

/// Estimator of shadowed light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum ShadowEstimate {
    /// The hierarchy's light times the shadow ratio of the samples, as in the paper.
    Ratio,
    /// The shadowed samples' own sum, with outliers clamped.
    Corrected,
    /// The shadowed samples' own sum, unbiased: on average the light of every VPL, whatever the error of the grid
    /// lights.
    Unbiased,
}

impl ShadowEstimate {
    /// Its number in shaders (`shadow_rays/estimate.glsl`).
    #[must_use]
    pub fn code(self) -> u32 {
        match self {
            Self::Ratio => 0,
            Self::Corrected => 1,
            Self::Unbiased => 2,
        }
    }
}

/// The filter of the shadow estimates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum ShadowFilter {
    /// Edge-aware à-trous wavelet.
    Atrous,
    /// No filter.
    None,
}

/// Tone curve from exposed radiance to a display.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum ToneMap {
    /// x / (1 + x) in each channel: soft and pale, never quite white.
    Reinhard,
    /// AgX: film-like contrast, bright colours desaturate to white without a hue shift.
    Agx,
    /// Khronos PBR Neutral: colours unchanged up to near white, only highlights are compressed.
    Neutral,
}

impl ToneMap {
    /// The number that shaders know it by.
    #[must_use]
    pub fn code(self) -> u32 {
        match self {
            Self::Reinhard => shared::TONE_MAP_REINHARD,
            Self::Agx => shared::TONE_MAP_AGX,
            Self::Neutral => shared::TONE_MAP_NEUTRAL,
        }
    }
}

/// A picture size, written `WIDTHxHEIGHT`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
}

/// The top level of the hierarchy, written `auto` or a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Levels {
    /// The largest that leaves the finest grid fewer than half as many lights as there are lights.
    Auto,
    /// This one.
    Fixed(u32),
}

/// The exposure of PNG pictures, written `auto` or a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// From the picture itself.
    Auto,
    /// This factor on the radiance.
    Fixed(f32),
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = text
            .split_once(['x', 'X'])
            .and_then(|(width, height)| Some(Self { width: width.parse().ok()?, height: height.parse().ok()? }));
        parsed.ok_or_else(|| format!("`{text}` is not a size of the form WIDTHxHEIGHT, such as 1280x720"))
    }
}

impl FromStr for Levels {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "auto" {
            return Ok(Self::Auto);
        }
        text.parse().map(Self::Fixed).map_err(|_| format!("`{text}` is not `auto` or a whole number of levels"))
    }
}

impl FromStr for Exposure {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "auto" {
            return Ok(Self::Auto);
        }
        text.parse().map(Self::Fixed).map_err(|_| format!("`{text}` is not `auto` or a number"))
    }
}

impl Serialize for Size {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl Serialize for Levels {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Auto => serializer.serialize_str("auto"),
            Self::Fixed(levels) => serializer.serialize_u32(*levels),
        }
    }
}

impl Serialize for Exposure {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Auto => serializer.serialize_str("auto"),
            Self::Fixed(factor) => serializer.serialize_f32(*factor),
        }
    }
}

/// What a file may hold where the command line takes a word: the word, or a bare number.
#[derive(Deserialize)]
#[serde(untagged)]
enum Word {
    Integer(i64),
    Float(f64),
    Text(String),
}

impl fmt::Display for Word {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Integer(number) => number.fmt(f),
            Self::Float(number) => number.fmt(f),
            Self::Text(text) => text.fmt(f),
        }
    }
}

pub(super) fn from_word<'de, D, T>(deserializer: D, expected: &str) -> Result<T, D::Error>
where
    D: Deserializer<'de>,
    T: FromStr<Err = String>,
{
    let word = Word::deserialize(deserializer).map_err(|_| serde::de::Error::custom(format!("expected {expected}")))?;
    word.to_string().parse().map_err(serde::de::Error::custom)
}

impl<'de> Deserialize<'de> for Size {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        from_word(deserializer, "a size of the form \"WIDTHxHEIGHT\"")
    }
}

impl<'de> Deserialize<'de> for Levels {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        from_word(deserializer, "`auto` or a whole number of levels")
    }
}

impl<'de> Deserialize<'de> for Exposure {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        from_word(deserializer, "`auto` or a number")
    }
}

/// A name, or an index that may stand without quotes.
pub(super) fn name_or_index<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<String>, D::Error> {
    let word = Option::<Word>::deserialize(deserializer)
        .map_err(|_| serde::de::Error::custom("expected a name or an index"))?;
    Ok(word.map(|word| word.to_string()))
}

#[cfg(test)]
mod tests {
    use super::count;

    #[test]
    fn counts_as_people_write_them() {
        for (text, expected) in [
            ("0", 0),
            ("7", 7),
            ("100k", 100_000),
            ("2M", 2_000_000),
            ("1e5", 100_000),
            ("1.5k", 1500),
            (".5m", 500_000),
        ] {
            assert_eq!(count(text), Ok(expected), "{text}");
        }
        assert_eq!(count("4294967295"), Ok(u32::MAX));
        for text in ["", "k", "-1", "+1", "0.5", "1.2345k", "nan", "inf", "many", "1e99", "4294967296", "1e5k5", "1 k"]
        {
            assert!(count(text).is_err(), "{text}: {:?}", count(text));
        }
    }
}
