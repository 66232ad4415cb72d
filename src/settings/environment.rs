//! Light from all around the scene: what the settings say of it.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::group::{Validate, settings_group};
use super::validate::{require, within};
use super::values::from_word;
use crate::Result;
use crate::shared::MAX_ENVIRONMENT_SAMPLES;

settings_group! {
    /// Light from all around the scene.
    #[command(next_help_heading = "Picture")]
    pub struct EnvironmentSettings: Picture {
        /// Environment light: none, uniform radiance, an equirectangular image, or a clear sky for the scene's sun
        /// [default: sky if the scene has no light, else none]
        #[arg(id = "environment", long = "environment", value_name = "none|R,G,B|FILE.exr|FILE.hdr|sky", allow_negative_numbers = true)]
        pub source as "environment": Option<EnvironmentSource> = None,
        /// Brightness factor of the environment, 0 or above [default: 1]
        #[arg(id = "environment-scale", long = "environment-scale", value_name = "X", allow_negative_numbers = true)]
        pub scale as "environment-scale": f32 = 1.0,
        /// Rotation of the environment about +y in degrees, counterclockwise seen from above [default: 0]
        #[arg(id = "environment-turn", long = "environment-turn", value_name = "DEGREES", allow_negative_numbers = true)]
        pub turn_deg as "environment-turn": f32 = 0.0,
        /// Shadow rays per pixel towards the environment, and as many towards surfaces that shine, 0 to 64; 0 turns their direct light off [default: 4]
        #[arg(id = "environment-samples", long = "environment-samples", value_name = "N", help_heading = "Shadows")]
        pub samples as "environment-samples": u32 = 4,
    }
}

impl Validate for EnvironmentSettings {
    fn validate(&self) -> Result<()> {
        if let Some(EnvironmentSource::Uniform(radiance)) = self.source {
            require(radiance.iter().all(|value| value.is_finite() && *value >= 0.0), || {
                let [r, g, b] = radiance;
                format!("--environment {r},{g},{b} needs three finite numbers, 0 or above")
            })?;
        }
        let Self { scale, turn_deg, samples, .. } = self;
        within("environment-samples", *samples, 0..=MAX_ENVIRONMENT_SAMPLES)?;
        require(scale.is_finite() && *scale >= 0.0, || {
            format!("--environment-scale must be a finite number, 0 or above, not {scale}")
        })?;
        require(turn_deg.is_finite(), || format!("--environment-turn must be a finite number, not {turn_deg}"))
    }
}

/// Where the light from all around comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum EnvironmentSource {
    /// There is none.
    None,
    /// The same radiance from everywhere, linear RGB.
    Uniform([f32; 3]),
    /// An equirectangular image, `.exr` or `.hdr`.
    File(PathBuf),
    /// A clear sky for the scene's sun.
    Sky,
}

impl EnvironmentSource {
    /// Whether files of this name are images of an environment.
    #[must_use]
    pub fn is_image(path: &Path) -> bool {
        path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr") || e.eq_ignore_ascii_case("hdr"))
    }
}

impl fmt::Display for EnvironmentSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => f.write_str("none"),
            Self::Uniform([r, g, b]) => write!(f, "{r},{g},{b}"),
            Self::File(path) => path.display().fmt(f),
            Self::Sky => f.write_str("sky"),
        }
    }
}

/// What is expected where it is something else.
const EXPECTED: &str = "none, sky, R,G,B or a file that ends in .exr or .hdr";

impl FromStr for EnvironmentSource {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match text {
            "none" => return Ok(Self::None),
            "sky" => return Ok(Self::Sky),
            _ => {}
        }
        let numbers: Option<Vec<f32>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
        match numbers.as_deref() {
            Some([r, g, b]) => Ok(Self::Uniform([*r, *g, *b])),
            _ if Self::is_image(Path::new(text)) => Ok(Self::File(text.into())),
            _ => Err(format!("`{text}` is not {EXPECTED}")),
        }
    }
}

impl Serialize for EnvironmentSource {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for EnvironmentSource {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        from_word(deserializer, EXPECTED)
    }
}
