//! `point_light`: direct light at points, of the environment through micro-buffers, of suns and lamps by rays; with a lighting
//! grid hierarchy light of all bounces.

use super::Frame;
use super::compaction::{GridLights, Lights};
use super::descent::Descent;
use super::lgh_shape::LghShape;
use super::micro_buffers::{GatherTables, MicroBuffers, PlacedPoints};
use super::pbgi_shape::PbgiShape;
use super::point_cut::KeyList;
use super::points::Points;
use crate::gpu::{ComputeWork, Work};
use crate::graph::{Access, BufferHandle, Pass};
use crate::settings::MicroFill;
use crate::shared::POINT_DISPATCH_GROUP_EACH;

/// A hierarchy that points look light up in.
#[derive(Clone, Debug)]
pub struct LookedUp {
    /// Its sizes.
    pub shape: LghShape,
    /// The lights S0.
    pub lights: Lights,
    /// Grid placement.
    pub placement: BufferHandle,
    /// Its levels.
    pub grid: GridLights,
    /// The way from coarse lights to S0.
    pub descent: Descent,
}

impl LookedUp {
    /// Work of a pass that looks light up.
    fn lighting(&self, mut work: ComputeWork) -> ComputeWork {
        work.constants.push(("LOBE", self.shape.lobe.code()));
        work.push.push(self.descent.index_bits);
        work
    }

    /// A pass that looks light up.
    fn read_by(&self, pass: Pass<Work>) -> Pass<Work> {
        pass.bind("grid", self.placement, Access::ComputeRead)
            .bind("grid_lights", self.grid.lights, Access::ComputeRead)
            .bind("descent", self.descent.tables, Access::ComputeRead)
            .bind("representatives", self.descent.representatives, Access::ComputeRead)
            .with(|pass| self.grid.looked_up_by(pass))
            .with(|pass| self.lights.read_by(pass))
    }
}

/// Adds the pass that lights primary points.
pub fn light_primaries(
    frame: &mut Frame,
    points: &Points,
    primaries: &PlacedPoints,
    micro_buffers: &MicroBuffers,
    tables: &GatherTables,
    hierarchy: Option<&LookedUp>,
    irradiance: BufferHandle,
) {
    let suffix = if hierarchy.is_some() { "_lights" } else { "" };
    let mut work = frame.ray_shader(&format!("point_light/light_primaries{suffix}"), primaries.per_point());
    if let Some(hierarchy) = hierarchy {
        work = hierarchy.lighting(work);
    }
    let mut pass = frame
        .compute("point_light/light_primaries", work)
        .with(|pass| primaries.read_by(pass))
        .with(|pass| micro_buffers.read_by(pass, tables))
        .bind("point_nodes", points.nodes, Access::ComputeSampled)
        .bind("point_irradiance", irradiance, Access::ComputeReadWrite);
    if let Some(hierarchy) = hierarchy {
        pass = hierarchy.read_by(pass);
    }
    frame.graph.add_pass(pass);
}

/// What says which secondary points are lit, from where, and by what.
#[derive(Clone, Copy, Debug)]
pub struct Secondaries<'a> {
    /// Which.
    pub list: KeyList,
    /// What sees them.
    pub primaries: &'a PlacedPoints,
    /// The texels of these that do.
    pub seen_texels: Option<BufferHandle>,
    /// Where what they see is kept for more bounces.
    pub kept_texels: Option<BufferHandle>,
    /// What has light of more bounces.
    pub hierarchy: Option<&'a LookedUp>,
}

impl Secondaries<'_> {
    /// Work of the pass that lights them.
    fn work(&self, frame: &Frame, shape: &PbgiShape) -> ComputeWork {
        let (filled, constants) = match shape.micro {
            MicroFill::Rays => ("", Vec::new()),
            MicroFill::Points => ("_points", vec![shape.binary_coverage()]),
        };
        let more = match (self.kept_texels, self.hierarchy) {
            (_, Some(_)) => "_lights",
            (Some(_), None) => "_keys",
            (None, None) => "",
        };
        let shader = format!("point_light/light_secondaries{filled}{more}");
        let work =
            ComputeWork { constants, ..frame.ray_shader(&shader, self.list.dispatch(POINT_DISPATCH_GROUP_EACH)) };
        match self.hierarchy {
            Some(hierarchy) => hierarchy.lighting(work),
            None => work,
        }
    }
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
    let mut pass = frame.compute("point_light/light_secondaries", secondaries.work(frame, shape));
    if let Some(texels) = secondaries.seen_texels {
        pass = pass
            .bind("seen_texels", texels, Access::ComputeRead)
            .bind("point_primaries", secondaries.primaries.cut.primaries.keys, Access::ComputeRead)
            .bind("primary_leaves", secondaries.primaries.leaves, Access::ComputeRead)
            .bind("primary_table", tables.primary, Access::ComputeRead);
    }
    if let Some(texels) = secondaries.kept_texels {
        pass = pass.bind("secondary_texels", texels, Access::ComputeWrite);
        if shape.micro == MicroFill::Rays {
            pass = points.hit_by(pass);
        }
    }
    if let Some(hierarchy) = secondaries.hierarchy {
        pass = hierarchy.read_by(pass);
    }
    let pass = pass
        .with(|pass| secondaries.primaries.counted_by(pass))
        .bind("point_needed", secondaries.list.keys, Access::ComputeRead)
        .with(|pass| tables.secondary_read_by(pass))
        .bind("point_nodes", points.nodes, Access::ComputeSampled)
        .bind("point_irradiance", irradiance, Access::ComputeReadWrite);
    frame.graph.add_pass(pass);
}
