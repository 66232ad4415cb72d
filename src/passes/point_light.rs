//! `point_light`: direct light at points, of the environment through micro-buffers, of suns and lamps by rays.

use super::Frame;
use super::micro_buffers::{GatherTables, MicroBuffers, PlacedPoints};
use super::pbgi_shape::PbgiShape;
use super::point_cut::KeyCounts;
use super::point_selection::PointSelection;
use super::points::Points;
use crate::gpu::ComputeWork;
use crate::graph::{Access, BufferHandle};
use crate::settings::MicroFill;
use crate::shared::POINT_DISPATCH_GROUP_EACH;

/// Adds the pass that lights primary points.
pub fn light_primaries(
    frame: &mut Frame,
    points: &Points,
    primaries: &PlacedPoints,
    micro_buffers: &MicroBuffers,
    tables: &GatherTables,
    irradiance: BufferHandle,
) {
    let work = frame.ray_shader("point_light/light_primaries", primaries.per_point());
    let pass = frame
        .compute("point_light/light_primaries", work)
        .with(|pass| primaries.read_by(pass))
        .with(|pass| micro_buffers.read_by(pass, tables))
        .bind("point_nodes", points.nodes, Access::ComputeSampled)
        .bind("point_irradiance", irradiance, Access::ComputeReadWrite);
    frame.graph.add_pass(pass);
}

/// What says which secondary points are lit, and from where.
#[derive(Clone, Copy, Debug)]
pub struct Secondaries<'a> {
    /// Which.
    pub selection: &'a PointSelection,
    /// How many.
    pub counts: KeyCounts,
    /// Leaves of them that are seen.
    pub seen_leaves: BufferHandle,
}

/// Adds the pass that lights the secondary points that need it.
pub fn light_secondaries(
    frame: &mut Frame,
    shape: &PbgiShape,
    points: &Points,
    secondaries: &Secondaries<'_>,
    tables: &GatherTables,
    irradiance: BufferHandle,
) {
    let (suffix, constants) = match shape.micro {
        MicroFill::Rays => ("", Vec::new()),
        MicroFill::Points => ("_points", vec![shape.binary_coverage()]),
    };
    let list = secondaries.selection.needed_list;
    let shader = format!("point_light/light_secondaries{suffix}");
    let work = ComputeWork { constants, ..frame.ray_shader(&shader, list.dispatch(POINT_DISPATCH_GROUP_EACH)) };
    let pass = frame
        .compute("point_light/light_secondaries", work)
        .uses(secondaries.counts.dispatches, Access::IndirectRead)
        .bind("point_counts", secondaries.counts.counts, Access::ComputeRead)
        .bind("point_needed", list.keys, Access::ComputeRead)
        .bind("seen_leaves", secondaries.seen_leaves, Access::ComputeRead)
        .with(|pass| tables.secondary_read_by(pass))
        .bind("point_nodes", points.nodes, Access::ComputeSampled)
        .bind("point_irradiance", irradiance, Access::ComputeReadWrite);
    frame.graph.add_pass(pass);
}
