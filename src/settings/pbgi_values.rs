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
    /// Its share of the texel.
    Fraction,
    /// All of it, as in the paper.
    Binary,
}

/// How the texels of a micro-buffer divide the hemisphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Hemisphere {
    /// A paraboloid, as in the paper: the solid angle of texels at the rim is a quarter of that in the middle.
    Paraboloid,
    /// The concentric map: texels of the same cosine weight.
    Concentric,
}

/// How those of the points that are seen are found that need a micro-buffer of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Selection {
    /// As `levels`; and points that are seen borrow the light of the point above or below, if that is lit.
    Borrow,
    /// Level by level: down from primary points first, so that what lies under them helps on the way up.
    Levels,
    /// Level by level, upwards first, as in the paper: never fewer points.
    Paper,
    /// As `levels`, in one dispatch: from each leaf up for as long as one is the second to arrive, the paper's mechanism.
    Arrival,
}
