//! What frames take over from those before them: where surfaces were, and what was known of their light.

mod answers;
mod area_lights;
mod blending;
#[path = "../common/mod.rs"]
mod common;
mod motion_vectors;
mod reprojection;
mod rounds;
mod run;
#[path = "../support/mod.rs"]
mod support;
mod taa;
mod tiles;
