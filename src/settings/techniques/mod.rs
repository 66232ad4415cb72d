//! The groups of settings that belong to techniques.

mod lgh;
mod many_lights;
mod path_trace;
mod pbgi;

pub use lgh::{IndirectSize, LghSettings};
pub use many_lights::ManyLightSettings;
pub use path_trace::PathTraceSettings;
pub use pbgi::PbgiSettings;
