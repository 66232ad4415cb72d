//! The order of the leaves, which is the tree.

use std::cmp::Ordering;
use std::ops::Range;

use glam::Vec3;

use super::Leaf;

/// Leaves that are worth a thread of their own.
const PARALLEL_LEAVES: usize = 4096;

/// Orders leaves, a power of two of them, so that each half of a node's leaves lies on one side along the longest axis of
/// their positions.
pub(super) fn order(leaves: &mut [Leaf]) {
    if leaves.len() < 2 {
        return;
    }
    let (min, max) = leaves
        .iter()
        .fold((Vec3::MAX, Vec3::MIN), |(min, max), leaf| (min.min(leaf.position_ws), max.max(leaf.position_ws)));
    let axis = (max - min).max_position();
    // All numbers of a position decide, and then the triangle, so that the order is always the same.
    let compare = |a: &Leaf, b: &Leaf| {
        let [p, q] = [a, b].map(|leaf| leaf.position_ws.to_array());
        let by_axis = [axis, 0, 1, 2].map(|i| p[i].total_cmp(&q[i]));
        by_axis.into_iter().fold(Ordering::Equal, Ordering::then).then(a.triangle.cmp(&b.triangle))
    };
    let half = leaves.len() / 2;
    leaves.select_nth_unstable_by(half, compare);
    let (first, second) = leaves.split_at_mut(half);
    if half >= PARALLEL_LEAVES {
        rayon::join(|| order(first), || order(second));
    } else {
        order(first);
        order(second);
    }
}

/// The leaves of a node, counted from the first, in a tree of `leaf_count`.
#[must_use]
pub fn leaves_of(node: u32, leaf_count: u32) -> Range<u32> {
    let below = leaf_count.ilog2() - node.ilog2();
    (node << below) - leaf_count..((node + 1) << below) - leaf_count
}

/// The node after the subtree of a node in the order in which parents come before their children; 1 after the last.
#[must_use]
pub fn after_subtree(node: u32) -> u32 {
    (node + 1) >> (node + 1).trailing_zeros()
}
