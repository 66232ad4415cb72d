//! `point_cut`: which points are primary, those that stand for what is seen: nodes of the tree that are small and flat
//! enough in the picture, with none above them that is. Counts stay on the GPU.

use super::exclusive_scan::{self, ScanRange};
use super::points::Points;
use super::{Frame, shader, threads};
use crate::gpu::{ComputeWork, Dispatch};
use crate::graph::{Access, BufferHandle, ImageHandle};
use crate::shared::{POINT_DISPATCHES, POINT_LIST_NEEDED, POINT_LIST_PRIMARIES, PointCounts};

/// What lists of keys share.
#[derive(Clone, Copy, Debug)]
pub struct KeyCounts {
    /// [`PointCounts`].
    pub counts: BufferHandle,
    /// Indirect dispatches over the lists.
    pub dispatches: BufferHandle,
}

/// Keys in ascending order.
#[derive(Clone, Copy, Debug)]
pub struct KeyList {
    /// The keys.
    pub keys: BufferHandle,
    /// Keys that have room.
    pub capacity: u32,
    /// Which list it is, one of `POINT_LIST_*`.
    pub list: u32,
    dispatches: BufferHandle,
}

impl KeyList {
    /// Workgroups over the keys, of a kind of `POINT_DISPATCH_*`; the pass declares [`Access::IndirectRead`] of
    /// [`KeyCounts::dispatches`].
    #[must_use]
    pub fn dispatch(&self, kind: u32) -> Dispatch {
        let slot = u64::from(POINT_DISPATCHES * self.list + kind);
        Dispatch::Indirect { buffer: self.dispatches, offset_bytes: 12 * slot }
    }
}

/// The primary points.
#[derive(Clone, Copy, Debug)]
pub struct PointCut {
    /// A bit for each node: whether it is small and flat enough.
    pub passing: BufferHandle,
    /// A bit for each key.
    pub bits: BufferHandle,
    /// The same as a list.
    pub primaries: KeyList,
    /// How many there are, and of what follows from them.
    pub counts: KeyCounts,
}

/// Declares what lists of keys share.
fn declare_counts(frame: &mut Frame) -> KeyCounts {
    let lists = POINT_LIST_NEEDED + 1;
    let counts = frame.graph.persistent_buffer("point_counts", size_of::<PointCounts>() as u64);
    let dispatches = frame.graph.persistent_buffer("point_dispatches", 12 * u64::from(POINT_DISPATCHES * lists));
    frame.clear(&[(counts, 0), (dispatches, 0)]);
    KeyCounts { counts, dispatches }
}

/// Whether sides of which the eye sees no leaf are taken out of the cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hidden {
    /// They are, by rays to the eye.
    Dropped,
    /// They are not, and no scene is needed.
    Kept,
}

/// Adds the passes. `depth` is that of the surfaces that are seen.
pub fn add(frame: &mut Frame, depth: ImageHandle, points: &Points, capacity: u32, hidden: Hidden) -> PointCut {
    let counts = declare_counts(frame);
    let passing = frame.graph.persistent_buffer("passing_bits", 4 * u64::from(points.node_count().div_ceil(32)));
    let bits = points.side_bits(frame, "primary_bits");
    frame.clear(&[(bits, 0)]);
    let over_nodes = threads(points.node_count());
    let pass = frame
        .compute("point_cut/mark_passing", shader("point_cut/mark_passing", over_nodes))
        .bind("point_nodes", points.nodes, Access::ComputeSampled)
        .bind("passing_bits", passing, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    let pass = frame
        .compute("point_cut/mark_primaries", shader("point_cut/mark_primaries", over_nodes))
        .bind("point_nodes", points.nodes, Access::ComputeSampled)
        .bind("depth_image", depth, Access::ComputeSampled)
        .bind("passing_bits", passing, Access::ComputeRead)
        .bind("primary_bits", bits, Access::ComputeReadWrite);
    frame.graph.add_pass(pass);
    if hidden == Hidden::Dropped {
        drop_hidden(frame, points, bits);
    }
    let primaries = pack_keys(frame, points, bits, POINT_LIST_PRIMARIES, capacity, &counts);
    PointCut { passing, bits, primaries, counts }
}

/// Adds the pass that takes sides of which the eye sees no leaf out of the cut.
fn drop_hidden(frame: &mut Frame, points: &Points, bits: BufferHandle) {
    let work = frame.ray_shader("point_cut/drop_hidden", threads(2 * points.node_count()));
    let pass = frame
        .compute("point_cut/drop_hidden", work)
        .bind("point_nodes", points.nodes, Access::ComputeSampled)
        .bind("primary_bits", bits, Access::ComputeReadWrite);
    frame.graph.add_pass(pass);
}

/// Adds the passes that list the keys of a set of sides; those that have no room leave it.
pub fn pack_keys(
    frame: &mut Frame,
    points: &Points,
    bits: BufferHandle,
    list: u32,
    capacity: u32,
    counts: &KeyCounts,
) -> KeyList {
    let what = if list == POINT_LIST_PRIMARIES { "primaries" } else { "needed" };
    let word_count = points.side_words();
    let ranks = frame.graph.transient_buffer(&format!("{what}_ranks"), 4 * u64::from(word_count + 1));
    let keys = frame.graph.persistent_buffer(&format!("point_{what}"), 4 * u64::from(capacity.max(1)));
    let range = ScanRange { bits, ranks, first_word: 0, word_count, keep_ranks: false, values: false };
    exclusive_scan::add(frame, what, range);
    let push = vec![word_count, capacity, list];
    let work = ComputeWork { push, ..shader("point_cut/pack_keys", threads(word_count)) };
    let pass = frame
        .compute(&format!("point_cut/pack_keys/{what}"), work)
        .bind("bits", bits, Access::ComputeReadWrite)
        .bind("ranks", ranks, Access::ComputeRead)
        .bind("keys", keys, Access::ComputeWrite)
        .bind("counts", counts.counts, Access::ComputeReadWrite)
        .bind("dispatches", counts.dispatches, Access::ComputeReadWrite);
    frame.graph.add_pass(pass);
    KeyList { keys, capacity, list, dispatches: counts.dispatches }
}
