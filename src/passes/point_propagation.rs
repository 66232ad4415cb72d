//! `point_propagation`: light from the points that were lit to all others that are seen: upwards the mean of children,
//! downwards that of the primary point above, or of a parent.

use super::point_cut::PointCut;
use super::point_selection::{Lending, PointSelection};
use super::points::Points;
use super::{Frame, shader, threads};
use crate::gpu::ComputeWork;
use crate::graph::{Access, BufferHandle};

/// Declares the irradiance of each key, three floats.
pub fn declare_irradiance(frame: &mut Frame, points: &Points) -> BufferHandle {
    declare_irradiance_named(frame, points, "point_irradiance")
}

/// The same under another name.
pub(super) fn declare_irradiance_named(frame: &mut Frame, points: &Points, name: &str) -> BufferHandle {
    frame.graph.persistent_buffer(name, 12 * 2 * u64::from(points.node_count()))
}

/// Which sides take light from which.
#[derive(Clone, Copy, Debug)]
pub struct Propagation<'a> {
    /// The primary points.
    pub cut: &'a PointCut,
    /// What was decided for each side.
    pub selection: &'a PointSelection,
    /// Sides that are seen.
    pub seen: BufferHandle,
    /// Where sides that nobody sees get light too.
    pub lending: Option<Lending>,
}

/// Adds the passes. `irradiance` has that of primary points and of sides that needed a micro-buffer of their own, and gets
/// that of all that are seen. `suffix` ends the passes' names.
pub fn add(frame: &mut Frame, points: &Points, sides: &Propagation<'_>, irradiance: BufferHandle, suffix: &str) {
    let Propagation { cut, selection, seen, lending } = sides;
    let own = Lending { lending: selection.known, averaged: selection.derived };
    let Lending { lending, averaged } = lending.unwrap_or(own);
    for [first_word, word_count] in points.levels().rev().skip(1) {
        let push = vec![first_word, word_count];
        let work = ComputeWork { push, ..shader("point_propagation/average_children", threads(word_count)) };
        let pass = frame
            .compute(&format!("point_propagation/average_children/{first_word}{suffix}"), work)
            .bind("point_nodes", points.nodes, Access::ComputeSampled)
            .bind("point_albedos", points.albedos, Access::ComputeRead)
            .bind("derived_bits", averaged, Access::ComputeRead)
            .bind("known_bits", lending, Access::ComputeRead)
            .bind("point_irradiance", irradiance, Access::ComputeReadWrite);
        frame.graph.add_pass(pass);
    }
    let word_count = points.side_words();
    let work = ComputeWork { push: vec![word_count], ..shader("point_propagation/copy_down", threads(word_count)) };
    let pass = frame
        .compute(&format!("point_propagation/copy_down{suffix}"), work)
        .bind("point_nodes", points.nodes, Access::ComputeSampled)
        .bind("primary_bits", cut.bits, Access::ComputeRead)
        .bind("under_bits", selection.under, Access::ComputeRead)
        .bind("seen_bits", *seen, Access::ComputeRead)
        .bind("borrowed_bits", selection.borrowed, Access::ComputeRead)
        .bind("point_irradiance", irradiance, Access::ComputeReadWrite);
    frame.graph.add_pass(pass);
}
