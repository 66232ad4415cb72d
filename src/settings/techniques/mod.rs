//! The groups of settings that belong to techniques.

mod lgh;
mod many_lights;
mod path_trace;

pub use lgh::LghSettings;
pub use many_lights::ManyLightSettings;
pub use path_trace::PathTraceSettings;
