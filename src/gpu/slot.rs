//! What one frame in flight has for itself.

use std::cell::Cell;
use std::sync::Arc;

use ash::vk;

use super::check;
use super::device::Device;
use super::loss::MarkerScheme;
use super::markers::Markers;
use super::timers::Timers;
use crate::error::Result;
use crate::graph::Plan;

/// Command buffers and queries of one frame in flight.
pub(super) struct Slot {
    /// As many as a frame can have submissions under way.
    pub commands: Vec<vk::CommandBuffer>,
    pub timers: Timers,
    pub markers: Markers,
    /// What the crash markers of its last frame hold: frames have rising ones, from 1 on.
    pub stamp: Cell<u32>,
    /// The submission that its last frame ends with.
    pub busy_until: u64,
}

impl Slot {
    /// For frames of a plan; the pool frees the command buffers.
    pub fn new(gpu: &Arc<Device>, pool: vk::CommandPool, plan: &Plan, markers: MarkerScheme) -> Result<Self> {
        let pass_count = plan.passes.len();
        let info =
            vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(pass_count.max(1) as u32);
        // SAFETY: the pool is alive.
        let commands = check("command buffers", unsafe { gpu.device.allocate_command_buffers(&info) })?;
        let timers = Timers::new(gpu, pass_count)?;
        let markers = Markers::new(gpu, plan, markers)?;
        Ok(Self { commands, timers, markers, stamp: Cell::new(0), busy_until: 0 })
    }
}
