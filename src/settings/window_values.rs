//! The kinds of value that only the window has settings of.

use std::fmt;
use std::str::FromStr;

use clap::ValueEnum;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::values::from_word;

/// When the display takes the window's pictures: a Vulkan present mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum PresentMode {
    /// Every picture waits for vertical blank; always available.
    Fifo,
    /// The newest picture is shown at the next vertical blank.
    Mailbox,
    /// Pictures are shown immediately and may tear.
    Immediate,
    /// As `fifo`, but a late picture is shown immediately.
    FifoRelaxed,
}

/// Edge of the rendered picture as a fraction of the window's, written `auto` or a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RenderScale {
    /// 1; on a CPU driver what holds about 10 frames per second.
    Auto,
    /// This fraction, 0.05 to 1.
    Fixed(f32),
}

impl fmt::Display for RenderScale {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Fixed(scale) => scale.fmt(f),
        }
    }
}

impl FromStr for RenderScale {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "auto" {
            return Ok(Self::Auto);
        }
        text.parse().map(Self::Fixed).map_err(|_| format!("`{text}` is not `auto` or a number"))
    }
}

impl Serialize for RenderScale {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Auto => serializer.serialize_str("auto"),
            Self::Fixed(scale) => serializer.serialize_f32(*scale),
        }
    }
}

impl<'de> Deserialize<'de> for RenderScale {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        from_word(deserializer, "`auto` or a number")
    }
}
