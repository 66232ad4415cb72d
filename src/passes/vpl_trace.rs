//! `vpl_trace`: light paths from the scene's lights, a VPL at every diffuse hit (section 4, Keller 1997).

use super::light_shape::LightShape;
use super::{Frame, threads};
use crate::graph::{Access, BufferHandle};
use crate::light_paths::StartDensity;

/// VPLs where the paths left them: path p, bounce b in slot p * bounces + b.
#[derive(Clone, Copy, Debug)]
pub struct VplSlots {
    /// Position and octahedral normal.
    pub positions: BufferHandle,
    /// Flux and 1.
    pub fluxes: BufferHandle,
    /// One bit per slot: whether it holds a VPL.
    pub bits: BufferHandle,
    /// Number of slots.
    pub count: u32,
}

/// Adds the passes.
pub fn add(frame: &mut Frame, shape: &LightShape) -> VplSlots {
    let count = shape.slot_count();
    let positions = frame.graph.transient_buffer("vpl_slot_positions", 16 * u64::from(count));
    let fluxes = frame.graph.transient_buffer("vpl_slot_fluxes", 16 * u64::from(count));
    let bits = frame.graph.transient_buffer("vpl_slot_bits", 4 * u64::from(count.div_ceil(32)));
    frame.clear(&[(bits, 0)]);
    let everywhere = StartDensity::default();
    let density = shape.starts.as_deref().unwrap_or(&everywhere);
    let cells = frame.graph.filled_buffer("start_cells", bytemuck::cast_slice(&density.cells).into());
    let work = frame.ray_shader("vpl_trace/trace_paths", threads(shape.path_count));
    let pass = frame
        .compute("vpl_trace", work)
        .bind("slot_positions", positions, Access::ComputeWrite)
        .bind("slot_fluxes", fluxes, Access::ComputeWrite)
        .bind("slot_bits", bits, Access::ComputeReadWrite)
        .bind("start_cells", cells, Access::ComputeRead)
        .bind("ray_count", frame.ray_count, Access::ComputeReadWrite);
    frame.graph.add_pass(pass);
    VplSlots { positions, fluxes, bits, count }
}
