//! `point_light`: direct light at points, of the environment through micro-buffers, of suns and lamps by rays.

use super::Frame;
use super::micro_buffers::{GatherTables, MicroBuffers, PlacedPoints};
use super::pbgi_shape::PbgiShape;
use super::point_cut::KeyList;
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
    pub list: KeyList,
    /// What sees them.
    pub primaries: &'a PlacedPoints,
    /// The texels of these that do.
    pub seen_texels: Option<BufferHandle>,
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
    let list = secondaries.list;
    let shader = format!("point_light/light_secondaries{suffix}");
    let work = ComputeWork { constants, ..frame.ray_shader(&shader, list.dispatch(POINT_DISPATCH_GROUP_EACH)) };
    let mut pass = frame.compute("point_light/light_secondaries", work);
    if let Some(texels) = secondaries.seen_texels {
        pass = pass
            .bind("seen_texels", texels, Access::ComputeRead)
            .bind("point_primaries", secondaries.primaries.cut.primaries.keys, Access::ComputeRead)
            .bind("primary_leaves", secondaries.primaries.leaves, Access::ComputeRead)
            .bind("primary_table", tables.primary, Access::ComputeRead);
    }
    let pass = pass
        .with(|pass| secondaries.primaries.counted_by(pass))
        .bind("point_needed", list.keys, Access::ComputeRead)
        .with(|pass| tables.secondary_read_by(pass))
        .bind("point_nodes", points.nodes, Access::ComputeSampled)
        .bind("point_irradiance", irradiance, Access::ComputeReadWrite);
    frame.graph.add_pass(pass);
}
