//! `point_selection`: of the sides that primary points see, those that need a micro-buffer of their own. What lies under a
//! primary point takes its light, and what both children are known of takes their mean.

use super::point_cut::PointCut;
use super::points::Points;
use super::{Frame, shader, threads};
use crate::gpu::{ComputeWork, Work};
use crate::graph::{Access, BufferHandle, Pass};
use crate::settings::Selection;

/// What is to be done for each side, a bit for each key.
#[derive(Clone, Copy, Debug)]
pub struct PointSelection {
    /// Sides that are primary points or lie under one.
    pub under: BufferHandle,
    /// Sides that borrow their parent's light.
    pub borrowed: BufferHandle,
    /// Sides that those above can take light from.
    pub known: BufferHandle,
    /// Sides whose light is the mean of those of their children that are known.
    pub derived: BufferHandle,
    /// Sides that need a micro-buffer of their own.
    pub needed: BufferHandle,
}

impl PointSelection {
    /// A pass that looks upwards.
    fn found_by(&self, pass: Pass<Work>, points: &Points, cut: &PointCut, seen: BufferHandle) -> Pass<Work> {
        pass.bind("turned_bits", points.turned, Access::ComputeRead)
            .bind("under_bits", self.under, Access::ComputeRead)
            .bind("seen_bits", seen, Access::ComputeRead)
            .bind("known_bits", self.known, Access::ComputeReadWrite)
            .bind("derived_bits", self.derived, Access::ComputeReadWrite)
            .bind("needed_bits", self.needed, Access::ComputeReadWrite)
            .bind("counts", cut.counts.counts, Access::ComputeReadWrite)
    }
}

/// Adds the passes. `seen` are the sides that micro-buffers of primary points see.
pub fn add(
    frame: &mut Frame,
    points: &Points,
    cut: &PointCut,
    seen: BufferHandle,
    selection: Selection,
) -> PointSelection {
    let [under, borrowed] = spread_down(frame, points, cut, seen, selection);
    let [known, derived, needed] =
        ["known_bits", "derived_bits", "needed_bits"].map(|name| points.side_bits(frame, name));
    let found = PointSelection { under, borrowed, known, derived, needed };
    match selection {
        Selection::Borrow | Selection::Levels | Selection::Paper => {
            gather_up(frame, points, cut, seen, &found, selection);
        }
        Selection::Arrival => climb_arrivals(frame, points, cut, seen, &found),
    }
    found
}

/// Adds the passes that look upwards, a dispatch for each level of the tree.
fn gather_up(
    frame: &mut Frame,
    points: &Points,
    cut: &PointCut,
    seen: BufferHandle,
    found: &PointSelection,
    selection: Selection,
) {
    let last_word = points.levels().last();
    for [first_word, word_count] in points.levels().rev() {
        let is_leaf_level = last_word == Some([first_word, word_count]);
        let work = ComputeWork {
            push: vec![first_word, word_count, is_leaf_level.into()],
            constants: vec![
                ("UNDER_IS_KNOWN", (selection != Selection::Paper).into()),
                ("BORROWS", (selection == Selection::Borrow).into()),
            ],
            ..shader("point_selection/gather_up", threads(word_count))
        };
        let pass = frame
            .compute(&format!("point_selection/gather_up/{first_word}"), work)
            .with(|pass| found.found_by(pass, points, cut, seen))
            .bind("borrowed_bits", found.borrowed, Access::ComputeRead);
        frame.graph.add_pass(pass);
    }
}

/// Adds the pass that looks upwards from all leaves at once.
fn climb_arrivals(frame: &mut Frame, points: &Points, cut: &PointCut, seen: BufferHandle, found: &PointSelection) {
    let arrivals = frame.graph.transient_buffer("point_arrivals", 4 * u64::from(points.leaf_count()));
    let cleared = [found.known, found.derived, found.needed, arrivals].map(|buffer| (buffer, 0));
    frame.clear_here("point_selection/clear", &cleared);
    let pass = frame
        .compute(
            "point_selection/climb_arrivals",
            shader("point_selection/climb_arrivals", threads(points.leaf_count())),
        )
        .with(|pass| found.found_by(pass, points, cut, seen))
        .bind("arrivals", arrivals, Access::ComputeReadWrite);
    frame.graph.add_pass(pass);
}

/// Which sides have light, those with them that no primary point sees.
#[derive(Clone, Copy, Debug)]
pub struct Lending {
    /// Sides that have light before it is copied downwards.
    pub lending: BufferHandle,
    /// Those of them whose light is the mean of those of their children that have any.
    pub averaged: BufferHandle,
}

/// Adds the passes that find light for what primary points do not see, from whatever lies below it.
pub fn fill_up(frame: &mut Frame, points: &Points, cut: &PointCut, selection: &PointSelection) -> Lending {
    let [lending, averaged] = ["lending_bits", "averaged_bits"].map(|name| points.side_bits(frame, name));
    let last_word = points.levels().last();
    for [first_word, word_count] in points.levels().rev() {
        let is_leaf_level = last_word == Some([first_word, word_count]);
        let push = vec![first_word, word_count, is_leaf_level.into()];
        let work = ComputeWork { push, ..shader("point_selection/fill_up", threads(word_count)) };
        let pass = frame
            .compute(&format!("point_selection/fill_up/{first_word}"), work)
            .bind("turned_bits", points.turned, Access::ComputeRead)
            .bind("under_bits", selection.under, Access::ComputeRead)
            .bind("primary_bits", cut.bits, Access::ComputeRead)
            .bind("derived_bits", selection.derived, Access::ComputeRead)
            .bind("needed_bits", selection.needed, Access::ComputeRead)
            .bind("borrowed_bits", selection.borrowed, Access::ComputeRead)
            .bind("lending_bits", lending, Access::ComputeReadWrite)
            .bind("averaged_bits", averaged, Access::ComputeWrite);
        frame.graph.add_pass(pass);
    }
    Lending { lending, averaged }
}

/// Adds the passes that find what lies under primary points, and then what borrows light.
fn spread_down(
    frame: &mut Frame,
    points: &Points,
    cut: &PointCut,
    seen: BufferHandle,
    selection: Selection,
) -> [BufferHandle; 2] {
    let [under, borrowed] = ["under_bits", "borrowed_bits"].map(|name| points.side_bits(frame, name));
    let constants = vec![("BORROWS", (selection == Selection::Borrow).into())];
    for [first_word, word_count] in points.levels() {
        let push = vec![first_word, word_count];
        let work = ComputeWork {
            push,
            constants: constants.clone(),
            ..shader("point_selection/spread_down", threads(word_count))
        };
        let pass = frame
            .compute(&format!("point_selection/spread_down/{first_word}"), work)
            .bind("turned_bits", points.turned, Access::ComputeRead)
            .bind("primary_bits", cut.bits, Access::ComputeRead)
            .bind("under_bits", under, Access::ComputeReadWrite)
            .bind("seen_bits", seen, Access::ComputeRead)
            .bind("borrowed_bits", borrowed, Access::ComputeReadWrite);
        frame.graph.add_pass(pass);
    }
    [under, borrowed]
}
