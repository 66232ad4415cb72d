//! GPU timestamps: one at the start of the frame, or of a piece of it, and one after every pass.

use std::ops::Range;
use std::sync::Arc;

use ash::vk;

use super::check;
use super::device::Device;
use crate::error::Result;

/// A query pool for the timestamps of one frame in flight.
pub(super) struct Timers {
    pool: vk::QueryPool,
    count: u32,
    gpu: Arc<Device>,
}

impl Timers {
    pub fn new(gpu: &Arc<Device>, pass_count: usize) -> Result<Self> {
        let count = pass_count as u32 + 1;
        let info = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(count);
        // SAFETY: valid create info.
        let pool = check("the timestamp pool", unsafe { gpu.device.create_query_pool(&info, None) })?;
        gpu.set_name(pool, "timestamps");
        Ok(Self { pool, count, gpu: Arc::clone(gpu) })
    }

    /// Resets the pool and writes the first timestamp.
    pub fn begin(&self, commands: vk::CommandBuffer) {
        // SAFETY: recording outside a rendering scope; the pool's last frame has been waited for.
        unsafe { self.gpu.device.cmd_reset_query_pool(commands, self.pool, 0, self.count) };
        self.write(commands, 0);
    }

    /// Begins a piece of a frame that has some of its passes: what was written before has been read.
    pub fn begin_piece(&self, commands: vk::CommandBuffer, passes: &Range<usize>) {
        let (first, count) = (passes.start as u32, passes.len() as u32 + 1);
        // SAFETY: recording outside a rendering scope; the piece before has been waited for.
        unsafe { self.gpu.device.cmd_reset_query_pool(commands, self.pool, first, count) };
        self.write(commands, first);
    }

    /// Writes the timestamp after pass `index`.
    pub fn after_pass(&self, commands: vk::CommandBuffer, index: usize) {
        self.write(commands, index as u32 + 1);
    }

    /// `ALL_COMMANDS` on both ends: a pass's time is from the completion of everything before it to its own.
    fn write(&self, commands: vk::CommandBuffer, query: u32) {
        // SAFETY: recording outside a rendering scope; the query was reset in `begin`.
        unsafe {
            self.gpu.device.cmd_write_timestamp2(commands, vk::PipelineStageFlags2::ALL_COMMANDS, self.pool, query);
        }
    }

    /// Milliseconds of each pass; call after the frame's completion.
    pub fn read_ms(&self) -> Result<Vec<f64>> {
        self.read_piece_ms(&(0..self.count as usize - 1))
    }

    /// Milliseconds of some passes; call after the completion of the piece, or of the frame, that has them.
    pub fn read_piece_ms(&self, passes: &Range<usize>) -> Result<Vec<f64>> {
        let mut ticks = vec![0_u64; passes.len() + 1];
        let first = passes.start as u32;
        // SAFETY: what wrote the queries has completed, so all results are available.
        check("reading timestamps", unsafe {
            self.gpu.device.get_query_pool_results(self.pool, first, &mut ticks, vk::QueryResultFlags::TYPE_64)
        })?;
        let limits = &self.gpu.report().limits;
        let ms_per_tick = f64::from(limits.timestamp_period_ns) * 1e-6;
        let elapsed = |t: &[u64]| elapsed_ticks(t[0], t[1], limits.timestamp_bits);
        Ok(ticks.windows(2).map(|t| elapsed(t) as f64 * ms_per_tick).collect())
    }
}

/// Ticks from one timestamp to the next, of which only the lowest `valid_bits` mean anything and start again at 0. 36 bits
/// of nanoseconds do so every 69 seconds. More than half of what they can tell apart is a step back, which counts as none.
fn elapsed_ticks(from: u64, to: u64, valid_bits: u32) -> u64 {
    let mask = u64::MAX >> (64 - valid_bits.clamp(1, 64));
    let ticks = to.wrapping_sub(from) & mask;
    if ticks > mask / 2 { 0 } else { ticks }
}

impl Drop for Timers {
    fn drop(&mut self) {
        // SAFETY: the executor waits for the GPU before it drops its slots.
        unsafe { self.gpu.device.destroy_query_pool(self.pool, None) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn timestamps_start_again_where_their_valid_bits_end() {
        for (bits, from, to, ticks) in [
            (64, 1000, 1250, 250),
            (64, u64::MAX - 9, 20, 30),
            (36, (1 << 36) - 100, 50, 150),
            // What the bits above hold is undefined.
            (36, 0xabcd_0000_0000_0010, 0x1234_0000_0000_0030, 0x20),
            (32, u64::from(u32::MAX), 0, 1),
        ] {
            assert_eq!(elapsed_ticks(from, to, bits), ticks, "{bits} bits from {from} to {to}");
        }
        for bits in [32, 36, 64] {
            assert_eq!(elapsed_ticks(1000, 999, bits), 0, "a step back of {bits} bits");
        }
    }
}
