//! `exclusive_scan`: exclusive prefix sum of set bits, reduce-then-scan in two passes.

use super::{Frame, read_dispatch, shader};
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

/// Chunks of words that a block has.
fn block_chunk_count(word_count: u32) -> u32 {
    word_count.div_ceil(SCAN_CHUNK * SCAN_MAX_BLOCKS).max(1)
}

/// Blocks of a range of so many words: as many workgroups the passes have.
#[must_use]
pub fn block_count(word_count: u32) -> u32 {
    word_count.div_ceil(SCAN_CHUNK * block_chunk_count(word_count)).max(1)
}

/// Adds the two passes, named `exclusive_scan/<what>/...`.
pub fn add(frame: &mut Frame, what: &str, range: ScanRange) {
    add_where(frame, what, range, Dispatch::groups(block_count(range.word_count)));
}

/// The same with a dispatch of [`block_count`] workgroups, or of none.
pub fn add_where(frame: &mut Frame, what: &str, range: ScanRange, dispatch: Dispatch) {
    let sums = declare_sums(frame, what, range);
    add_dispatched(frame, what, range, sums, dispatch);
}

/// Declares what the two passes hand on, for scans of one range again and again.
pub fn declare_sums(frame: &mut Frame, what: &str, range: ScanRange) -> BufferHandle {
    frame.graph.transient_buffer(&format!("scan_block_sums_{what}"), 4 * u64::from(block_count(range.word_count)))
}

/// Adds the two passes with block sums that have been declared.
pub fn add_with(frame: &mut Frame, what: &str, range: ScanRange, sums: BufferHandle) {
    add_dispatched(frame, what, range, sums, Dispatch::groups(block_count(range.word_count)));
}

fn add_dispatched(frame: &mut Frame, what: &str, range: ScanRange, sums: BufferHandle, dispatch: Dispatch) {
    let push = vec![range.first_word, range.word_count, block_chunk_count(range.word_count)];
    let variant = if range.values { "_values" } else { "" };
    let work =
        |step: &str| ComputeWork { push: push.clone(), ..shader(&format!("exclusive_scan/{step}{variant}"), dispatch) };
    let write_ranks = if range.keep_ranks { Access::ComputeReadWrite } else { Access::ComputeWrite };
    let name = |step: &str| format!("exclusive_scan/{what}/{step}");
    let reduce = frame
        .compute(&name("reduce_blocks"), work("reduce_blocks"))
        .bind("bits", range.bits, Access::ComputeRead)
        .bind("block_sums", sums, Access::ComputeWrite)
        .with(read_dispatch);
    frame.graph.add_pass(reduce);
    let scan = frame
        .compute(&name("scan_blocks"), work("scan_blocks"))
        .bind("bits", range.bits, Access::ComputeRead)
        .bind("block_sums", sums, Access::ComputeRead)
        .bind("ranks", range.ranks, write_ranks)
        .with(read_dispatch);
    frame.graph.add_pass(scan);
}
