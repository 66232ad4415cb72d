//! `point_propagation`: light from the points that were lit to all others that are seen: upwards the mean of children,
//! downwards that of the primary point above, or of a parent.

use super::point_cut::PointCut;
use super::point_selection::PointSelection;
use super::points::Points;
use super::{Frame, shader, threads};
use crate::gpu::ComputeWork;
use crate::graph::{Access, BufferHandle};

/// Declares the irradiance of each key, three floats.
pub fn declare_irradiance(frame: &mut Frame, points: &Points) -> BufferHandle {
    frame.graph.persistent_buffer("point_irradiance", 12 * 2 * u64::from(points.node_count()))
}

/// Adds the passes. `irradiance` has that of primary points and of sides that needed a micro-buffer of their own, and gets
/// that of all that `seen` has.
pub fn add(
    frame: &mut Frame,
    points: &Points,
    cut: &PointCut,
    selection: &PointSelection,
    seen: BufferHandle,
    irradiance: BufferHandle,
) {
    for [first_word, word_count] in points.levels().rev().skip(1) {
        let push = vec![first_word, word_count];
        let work = ComputeWork { push, ..shader("point_propagation/average_children", threads(word_count)) };
        let pass = frame
            .compute(&format!("point_propagation/average_children/{first_word}"), work)
            .bind("point_nodes", points.nodes, Access::ComputeSampled)
            .bind("point_albedos", points.albedos, Access::ComputeRead)
            .bind("derived_bits", selection.derived, Access::ComputeRead)
            .bind("known_bits", selection.known, Access::ComputeRead)
            .bind("point_irradiance", irradiance, Access::ComputeReadWrite);
        frame.graph.add_pass(pass);
    }
    let word_count = points.side_words();
    let work = ComputeWork { push: vec![word_count], ..shader("point_propagation/copy_down", threads(word_count)) };
    let pass = frame
        .compute("point_propagation/copy_down", work)
        .bind("point_nodes", points.nodes, Access::ComputeSampled)
        .bind("primary_bits", cut.bits, Access::ComputeRead)
        .bind("under_bits", selection.under, Access::ComputeRead)
        .bind("seen_bits", seen, Access::ComputeRead)
        .bind("borrowed_bits", selection.borrowed, Access::ComputeRead)
        .bind("point_irradiance", irradiance, Access::ComputeReadWrite);
    frame.graph.add_pass(pass);
}
