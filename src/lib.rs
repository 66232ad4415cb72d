//! gridlight: many-light rendering with the Lighting Grid Hierarchy on explicit Vulkan 1.3.

pub mod app;
pub mod camera;
pub mod cli;
pub mod color;
pub mod compare;
pub mod cpu;
pub mod dump;
pub mod environment;
pub mod error;
pub mod files;
pub mod frame;
pub mod gpu;
pub mod graph;
pub mod interrupt;
pub mod job;
pub mod light_grid;
pub mod light_paths;
pub mod micro_buffers;
pub mod passes;
pub mod points;
pub mod progress;
pub mod random;
pub mod renderer;
pub mod report;
pub mod scene;
pub mod scene_mover;
pub mod settings;
pub mod shader;
pub mod shared;
pub mod techniques;
pub mod uploaded_scene;
pub mod views;

pub use error::{Error, Result};
