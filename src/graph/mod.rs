//! The frame graph: passes declare what they read and write, and the plan (order, barriers, layouts,
//! aliasing of transient images) is computed as plain data before any Vulkan call.
//!
//! Modelled on the ideas of Granite's render graph (plan as data) and kajiya's (declarations are the pass).

mod access;
mod resource;

pub use access::Access;
pub use resource::{BufferHandle, BufferInfo, Handle, ImageHandle, ImageInfo, Lifetime, Resource, ResourceInfo};
