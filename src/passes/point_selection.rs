//! `point_selection`: of the sides that primary points see, those that need a micro-buffer of their own. What lies under a
//! primary point takes its light, and what both children are known of takes their mean.

use super::point_cut::{self, KeyList, PointCut};
use super::points::Points;
use super::{Frame, shader, threads};
use crate::gpu::ComputeWork;
use crate::graph::{Access, BufferHandle};
use crate::shared::POINT_LIST_NEEDED;

/// What is to be done for each side, a bit for each key.
#[derive(Clone, Copy, Debug)]
pub struct PointSelection {
    /// Sides that are primary points or lie under one.
    pub under: BufferHandle,
    /// Sides whose light is known in the end.
    pub known: BufferHandle,
    /// Sides whose light is the mean of their children's.
    pub derived: BufferHandle,
    /// Sides that need a micro-buffer of their own.
    pub needed: BufferHandle,
    /// The same as a list.
    pub needed_list: KeyList,
}

/// What a side that is not seen, but lies under a primary point, counts as when the levels above are looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnderPrimary {
    /// Known, as the levels have been followed downwards first.
    Known,
    /// Unknown, as in the paper, which looks upwards first.
    Unknown,
}

/// Adds the passes, a dispatch for each level of the tree. `seen` are the sides that micro-buffers of primary points see.
pub fn add(
    frame: &mut Frame,
    points: &Points,
    cut: &PointCut,
    seen: BufferHandle,
    capacity: u32,
    under_primary: UnderPrimary,
) -> PointSelection {
    let under = spread_down(frame, points, cut);
    let [known, derived, needed] =
        ["known_bits", "derived_bits", "needed_bits"].map(|name| points.side_bits(frame, name));
    let last_word = points.levels().last();
    for [first_word, word_count] in points.levels().rev() {
        let is_leaf_level = last_word == Some([first_word, word_count]);
        let work = ComputeWork {
            push: vec![first_word, word_count, is_leaf_level.into()],
            constants: vec![("UNDER_IS_KNOWN", (under_primary == UnderPrimary::Known).into())],
            ..shader("point_selection/gather_up", threads(word_count))
        };
        let pass = frame
            .compute(&format!("point_selection/gather_up/{first_word}"), work)
            .bind("turned_bits", points.turned, Access::ComputeRead)
            .bind("under_bits", under, Access::ComputeRead)
            .bind("seen_bits", seen, Access::ComputeRead)
            .bind("known_bits", known, Access::ComputeReadWrite)
            .bind("derived_bits", derived, Access::ComputeReadWrite)
            .bind("needed_bits", needed, Access::ComputeReadWrite)
            .bind("counts", cut.counts.counts, Access::ComputeReadWrite);
        frame.graph.add_pass(pass);
    }
    let needed_list = point_cut::pack_keys(frame, points, needed, POINT_LIST_NEEDED, capacity, &cut.counts);
    PointSelection { under, known, derived, needed, needed_list }
}

/// Adds the passes that find what lies under primary points.
fn spread_down(frame: &mut Frame, points: &Points, cut: &PointCut) -> BufferHandle {
    let under = points.side_bits(frame, "under_bits");
    for [first_word, word_count] in points.levels() {
        let push = vec![first_word, word_count];
        let work = ComputeWork { push, ..shader("point_selection/spread_down", threads(word_count)) };
        let pass = frame
            .compute(&format!("point_selection/spread_down/{first_word}"), work)
            .bind("turned_bits", points.turned, Access::ComputeRead)
            .bind("primary_bits", cut.bits, Access::ComputeRead)
            .bind("under_bits", under, Access::ComputeReadWrite);
        frame.graph.add_pass(pass);
    }
    under
}
