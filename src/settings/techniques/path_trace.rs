//! What path tracing alone has settings for.

use crate::Result;
use crate::settings::group::{Validate, settings_group};
use crate::settings::validate::at_least_one;

settings_group! {
    /// Path tracing.
    #[command(next_help_heading = "Method")]
    pub struct PathTraceSettings: Technique {
        /// Paths per pixel of a path-traced frame, 1 or more [default: 16]
        #[arg(long, value_name = "N")]
        pub samples: u32 = 16,
    }
}

impl Validate for PathTraceSettings {
    fn validate(&self) -> Result<()> {
        at_least_one("samples", self.samples)
    }
}
