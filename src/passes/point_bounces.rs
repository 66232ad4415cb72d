//! `point_bounces`: more bounces of light. In each the points that were lit look once more at what they saw when they were lit,
//! with the light that it had a bounce before: no ray is cast, and no other point is lit.

use super::micro_buffers::{GatherTables, MicroBuffers, PRIMARY_TEXELS, PlacedPoints};
use super::pbgi_shape::PbgiShape;
use super::point_cut::KeyList;
use super::point_propagation::{self, Propagation, declare_irradiance_named};
use super::point_selection::Lending;
use super::points::Points;
use super::{Frame, shader};
use crate::gpu::ComputeWork;
use crate::graph::{Access, BufferHandle};
use crate::shared::{POINT_DISPATCH_GROUP_EACH, SECONDARY_EDGE};

/// Texels of a secondary point's micro-buffer.
const SECONDARY_TEXELS: u32 = SECONDARY_EDGE * SECONDARY_EDGE;

/// Declares what secondary points see; `None` where one bounce is all.
pub fn declare_texels(frame: &mut Frame, shape: &PbgiShape) -> Option<BufferHandle> {
    let bytes = 4 * u64::from(SECONDARY_TEXELS) * u64::from(shape.kept_secondaries());
    (shape.bounces > 1).then(|| frame.graph.transient_buffer("secondary_texels", bytes))
}

/// The points that have been lit, and what they see.
#[derive(Clone, Copy, Debug)]
pub struct LitPoints<'a> {
    /// Primary points.
    pub primaries: &'a PlacedPoints,
    /// What they see.
    pub micro_buffers: &'a MicroBuffers,
    /// Secondary points.
    pub secondaries: KeyList,
    /// What they see, [`declare_texels`].
    pub secondary_texels: BufferHandle,
}

/// One list of them.
struct Seeing {
    what: &'static str,
    list: KeyList,
    texels: BufferHandle,
    texel_count: u32,
    table: BufferHandle,
}

/// Adds the passes of all bounces after the first; gives the light of all. `direct` is that of the first.
pub fn add(
    frame: &mut Frame,
    shape: &PbgiShape,
    points: &Points,
    lit: &LitPoints<'_>,
    tables: &GatherTables,
    propagation: &Propagation<'_>,
    direct: BufferHandle,
) -> BufferHandle {
    let Some(lending) = propagation.lending else { return direct };
    let lists = [
        Seeing {
            what: "primaries",
            list: lit.primaries.cut.primaries,
            texels: lit.micro_buffers.texels,
            texel_count: PRIMARY_TEXELS,
            table: tables.primary,
        },
        Seeing {
            what: "secondaries",
            list: lit.secondaries,
            texels: lit.secondary_texels,
            texel_count: SECONDARY_TEXELS,
            table: tables.secondary,
        },
    ];
    let names = ["bounced_irradiance_even", "bounced_irradiance_odd"];
    let bounced = names.map(|name| declare_irradiance_named(frame, points, name));
    let mut before = direct;
    for bounce in 2..=shape.bounces {
        let after = bounced[bounce as usize % 2];
        for seeing in &lists {
            let name = format!("point_bounces/{}/{bounce}", seeing.what);
            gather(frame, points, lit, seeing, &name, lending, [direct, before, after]);
        }
        point_propagation::add(frame, points, propagation, after, &format!("/{bounce}"));
        before = after;
    }
    before
}

/// Adds the pass of a bounce at the points of one list.
fn gather(
    frame: &mut Frame,
    points: &Points,
    lit: &LitPoints<'_>,
    seeing: &Seeing,
    name: &str,
    lending: Lending,
    [direct, before, after]: [BufferHandle; 3],
) {
    let push = vec![seeing.list.list, seeing.texel_count];
    let dispatch = seeing.list.dispatch(POINT_DISPATCH_GROUP_EACH);
    let work = ComputeWork { push, ..shader("point_bounces/gather_bounce", dispatch) };
    let pass = frame
        .compute(name, work)
        .with(|pass| lit.primaries.counted_by(pass))
        .bind("keys", seeing.list.keys, Access::ComputeRead)
        .bind("texels", seeing.texels, Access::ComputeRead)
        .bind("micro_table", seeing.table, Access::ComputeRead)
        .bind("point_nodes", points.nodes, Access::ComputeSampled)
        .bind("point_albedos", points.albedos, Access::ComputeRead)
        .bind("lending_bits", lending.lending, Access::ComputeRead)
        .bind("direct_irradiance", direct, Access::ComputeRead)
        .bind("point_irradiance", before, Access::ComputeRead)
        .bind("bounced_irradiance", after, Access::ComputeReadWrite);
    frame.graph.add_pass(pass);
}
