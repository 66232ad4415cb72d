//! What path tracing alone has settings for.

use crate::Result;
use crate::settings::group::settings_group;
use crate::settings::validate::at_least_one;

settings_group! {
    /// Path tracing.
    #[command(next_help_heading = "Method")]
    pub struct PathTraceSettings {
        /// Paths per pixel of a path-traced frame, 1 or more [default: 16]
        #[arg(long, value_name = "N")]
        pub samples: u32 = 16,
    }
}

impl PathTraceSettings {
    pub(in crate::settings) fn validate(&self) -> Result<()> {
        at_least_one("samples", self.samples)
    }
}
