//! `exclusive_scan`: exclusive prefix sum of set bits, reduce-then-scan in two passes.

use super::{Frame, shader};
use crate::gpu::{ComputeWork, Dispatch};
use crate::graph::{Access, BufferHandle};
use crate::shared::{SCAN_CHUNK, SCAN_MAX_BLOCKS};

/// A range of words of bits, and where the ranks go.
#[derive(Clone, Copy, Debug)]
pub struct ScanRange {
    /// The bits.
    pub bits: BufferHandle,
    /// Per word the number of set bits before it in the range; one more entry than words.
    pub ranks: BufferHandle,
    /// First word.
    pub first_word: u32,
    /// Number of words.
    pub word_count: u32,
    /// Whether `ranks` already holds the ranks of another range.
    pub keep_ranks: bool,
    /// Sum the words as numbers instead of their set bits.
    pub values: bool,
}

impl ScanRange {
    /// Chunks of words that a block has.
    fn block_chunk_count(&self) -> u32 {
        self.word_count.div_ceil(SCAN_CHUNK * SCAN_MAX_BLOCKS).max(1)
    }

    fn block_count(&self) -> u32 {
        self.word_count.div_ceil(SCAN_CHUNK * self.block_chunk_count()).max(1)
    }
}

/// Adds the two passes, named `exclusive_scan/<what>/...`.
pub fn add(frame: &mut Frame, what: &str, range: ScanRange) {
    let sums = declare_sums(frame, what, range);
    add_with(frame, what, range, sums);
}

/// Declares what the two passes hand on, for scans of one range again and again.
pub fn declare_sums(frame: &mut Frame, what: &str, range: ScanRange) -> BufferHandle {
    frame.graph.transient_buffer(&format!("scan_block_sums_{what}"), 4 * u64::from(range.block_count()))
}

/// Adds the two passes with block sums that have been declared.
pub fn add_with(frame: &mut Frame, what: &str, range: ScanRange, sums: BufferHandle) {
    let (block_chunk_count, block_count) = (range.block_chunk_count(), range.block_count());
    let push = vec![range.first_word, range.word_count, block_chunk_count];
    let variant = if range.values { "_values" } else { "" };
    let work = |step: &str| ComputeWork {
        push: push.clone(),
        ..shader(&format!("exclusive_scan/{step}{variant}"), Dispatch::groups(block_count))
    };
    let write_ranks = if range.keep_ranks { Access::ComputeReadWrite } else { Access::ComputeWrite };
    let name = |step: &str| format!("exclusive_scan/{what}/{step}");
    let reduce = frame
        .compute(&name("reduce_blocks"), work("reduce_blocks"))
        .bind("bits", range.bits, Access::ComputeRead)
        .bind("block_sums", sums, Access::ComputeWrite);
    frame.graph.add_pass(reduce);
    let scan = frame
        .compute(&name("scan_blocks"), work("scan_blocks"))
        .bind("bits", range.bits, Access::ComputeRead)
        .bind("block_sums", sums, Access::ComputeRead)
        .bind("ranks", range.ranks, write_ranks);
    frame.graph.add_pass(scan);
}
