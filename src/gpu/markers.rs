//! Crash markers: one host-visible word per pass, written when the pass is reached, so that after a lost
//! device the last pass can be named on any driver.

use std::sync::Arc;

use ash::vk;

use super::buffer::Buffer;
use super::device::Device;
use crate::error::{Error, Result};

/// The marker words of one frame in flight.
pub(super) struct Markers {
    buffer: Buffer,
    gpu: Arc<Device>,
}

impl Markers {
    pub fn new(gpu: &Arc<Device>, pass_count: usize) -> Result<Self> {
        let size = 4 * pass_count.max(1) as u64;
        let mut buffer = Buffer::host(gpu, "crash markers", size, vk::BufferUsageFlags::TRANSFER_DST)?;
        buffer.mapped_mut().fill(0);
        Ok(Self { buffer, gpu: Arc::clone(gpu) })
    }

    /// Marks that pass `index` was reached in frame `stamp` (never 0).
    pub fn reach(&self, commands: vk::CommandBuffer, index: usize, stamp: u32) {
        // SAFETY: recording outside a rendering scope; each pass writes its own word once per frame and slot.
        unsafe { self.gpu.device.cmd_fill_buffer(commands, self.buffer.raw, 4 * index as u64, 4, stamp) };
    }

    /// Names the last pass reached in frame `stamp`.
    pub fn last_pass<'a>(&self, names: &[&'a str], stamp: u32) -> &'a str {
        let words = self.buffer.mapped().chunks_exact(4).map(|c| u32::from_le_bytes([c[0], c[1], c[2], c[3]]));
        let reached = words.zip(names).take_while(|(word, _)| *word == stamp).last();
        reached.map_or("none", |(_, name)| name)
    }

    /// Replaces the pass in a device-lost error by the last one reached.
    pub fn explain<T>(&self, result: Result<T>, names: &[&str], stamp: u32) -> Result<T> {
        result.map_err(|error| match error {
            Error::DeviceLost { .. } => Error::DeviceLost { pass: self.last_pass(names, stamp).to_owned() },
            other => other,
        })
    }
}
