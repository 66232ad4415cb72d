//! gridlight: many-light rendering with the Lighting Grid Hierarchy on explicit Vulkan 1.3.

pub mod app;
pub mod cli;
pub mod error;
pub mod gpu;
pub mod graph;
pub mod progress;
pub mod report;
pub mod scene;
pub mod settings;
pub mod shader;
pub mod shared;

pub use error::{Error, Result};
