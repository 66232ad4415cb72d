//! The kinds of value that point-based global illumination has settings of.

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

/// What fills micro-buffers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum MicroFill {
    /// A ray for each texel.
    Rays,
    /// The points, splatted, as in the paper.
    Points,
}

/// How much of a texel a point covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Coverage {
    /// Fractional: its share of the texel.
    Fraction,
    /// All or nothing, as in the paper: all if points hide at least half.
    Binary,
}

/// Mapping of the hemisphere to the texels of a micro-buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Hemisphere {
    /// A paraboloid, as in the paper: the solid angle of texels at the rim is a quarter of that in the middle.
    Paraboloid,
    /// The concentric map: texels of equal cosine weight.
    Concentric,
}

/// How to find the visible points that need their own micro-buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Selection {
    /// As `levels`; in addition, visible points borrow the light of a point above or below in the tree, if it is lit.
    Borrow,
    /// Level by level: top-down from primary points first, so that the points below them help on the way up.
    Levels,
    /// Level by level, bottom-up first, as in the paper: never fewer points.
    Paper,
    /// As `levels`, in one dispatch: from each leaf upwards as long as it is the second to arrive, as in the paper.
    Arrival,
}
