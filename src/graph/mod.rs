//! The frame graph: passes declare what they read and write, and the plan (order, barriers, layouts,
//! aliasing of transient images) is computed as plain data before any Vulkan call.
//!
//! Modelled on the ideas of Granite's render graph (plan as data) and kajiya's (declarations are the pass).

mod access;
mod alias;
mod builder;
mod check;
mod dump;
mod hoist;
mod plan;
mod resource;

pub use access::{Access, SyncScope};
pub use alias::{AliasPlan, Placement, Requirement, add_alias_barriers, assign};
pub use builder::{BindingName, Graph, PREVIOUS, Pass, PassId, Use};
pub use check::PlanError;
pub use dump::to_dot;
pub use hoist::hoist;
pub use plan::{Barrier, MemoryBarrier, Plan, PlannedPass, plan};
pub use resource::{
    BufferHandle, BufferInfo, Handle, History, IMPORTED_LAYOUT, ImageDepth, ImageHandle, ImageInfo, ImageLevel, Kind,
    Lifetime, Part, Resource, ResourceInfo,
};
