//! Explicit Vulkan: the only module with `unsafe` code. Everything above it is plain data and safe calls.

mod acceleration;
mod batches;
mod buffer;
mod capture;
mod compiled;
mod context;
mod descriptors;
mod device;
mod diagnostics;
mod environment;
mod executor;
mod features;
mod image;
mod instance;
mod interfaces;
mod loss;
mod markers;
mod paced;
#[cfg(feature = "window")]
mod panel;
mod physical;
mod pipeline;
mod pipeline_file;
mod pipelines;
mod readback;
mod recorder;
mod resources;
mod runner;
mod scene_set;
mod shared_image;
mod slot;
mod stage_limits;
mod steps;
#[cfg(feature = "window")]
mod surface;
#[cfg(feature = "window")]
mod swapchain;
mod target;
mod timeline;
mod timers;
mod transfer;
mod word_image;
mod work;

pub use buffer::Buffer;
pub use capture::FrameCapture;
pub use context::Gpu;
pub use device::{Device, GpuOptions, ValidationLog};
pub use environment::FORMAT as ENVIRONMENT_FORMAT;
pub use executor::{Executor, FrameResult, FrameTicket, SteppedFrame};
pub use features::{DeviceReport, Limits, OptionalFeatures, list_gpus};
pub use image::Image;
pub use instance::Instance;
pub use interfaces::{Fault, InterfaceError, check_interfaces};
pub use loss::MarkerScheme;
pub use paced::PacedFrame;
#[cfg(feature = "window")]
pub use panel::{PanelPainter, PanelPicture};
pub use readback::{SceneBytes, Written};
pub use resources::MemoryUse;
pub use runner::OnStep;
pub use scene_set::{SceneData, ScenePart, SceneSet};
pub use shared_image::SharedImage;
pub use stage_limits::{StageLimits, check_stage_limits};
#[cfg(feature = "window")]
pub use surface::{Surface, WindowSource};
#[cfg(feature = "window")]
pub use swapchain::{Acquired, Presented, Renewals, Swapchain, is_srgb};
pub use target::{FRAMES_IN_FLIGHT, Overlay, Target, WindowTarget};
pub use work::{
    ColorTarget, ComputeWork, Constants, DepthTarget, Dispatch, DrawCall, RasterDraw, RasterState, RasterWork, Repeat,
    StructureLevel, TransferOp, Viewport, Work,
};

use crate::error::Error;
use ash::vk;

/// Turns a failed Vulkan call into an [`Error`] that names what was attempted.
pub(crate) fn check<T>(what: &str, result: std::result::Result<T, vk::Result>) -> crate::Result<T> {
    result.map_err(|result| match result {
        vk::Result::ERROR_DEVICE_LOST => Error::DeviceLost { place: format!("at {what}") },
        result => Error::Vulkan { what: what.to_owned(), result },
    })
}
