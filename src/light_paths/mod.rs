//! Where light paths start: as densely as they bring light to what is seen.
//!
//! Three numbers between 0 and 1 say where a path starts (`common/path_starts.glsl`): the light, in the order of the lights
//! by power with the environment last, and two that say from where and in which direction. Cells of this cube have shares of
//! the paths.

mod learn;

pub use learn::{Learnt, PARTS_PER_EDGE, PATHS_PER_PART, learn};

use crate::shared::StartCell;

/// Cells of the unit cube of starts, in the order of the paths. Their shares sum to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct StartDensity {
    /// The cells; they fill the cube.
    pub cells: Vec<StartCell>,
}

impl Default for StartDensity {
    /// As many paths everywhere.
    fn default() -> Self {
        Self { cells: vec![StartCell { low: [0.0; 3], first: 0.0, size: [1.0; 3], share: 1.0 }] }
    }
}
