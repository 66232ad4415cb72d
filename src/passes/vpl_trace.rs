//! `vpl_trace`: light paths from the scene's lights, a VPL at every diffuse hit (section 4, Keller 1997).

use super::light_shape::{LightShape, PathPart};
use super::{Frame, threads};
use crate::gpu::ComputeWork;
use crate::graph::{Access, BufferHandle};
use crate::light_paths::StartDensity;

/// VPLs where the paths left them: path p, bounce b in slot p * bounces + b. The slots of one part are in memory.
#[derive(Clone, Copy, Debug)]
pub struct VplSlots {
    /// Position and octahedral normal.
    pub positions: BufferHandle,
    /// Flux and 1.
    pub fluxes: BufferHandle,
    /// One bit per slot, of all parts: whether it holds a VPL.
    pub bits: BufferHandle,
    /// Number of slots of all parts together.
    pub count: u32,
}

/// Declares the slots of `parts`.
pub fn declare(frame: &mut Frame, shape: &LightShape, parts: &[PathPart]) -> VplSlots {
    let count = shape.slot_count();
    let at_once = parts.iter().map(|part| part.slots.len() as u64).max().unwrap_or(1);
    let slots = VplSlots {
        positions: frame.graph.transient_buffer("vpl_slot_positions", 16 * at_once),
        fluxes: frame.graph.transient_buffer("vpl_slot_fluxes", 16 * at_once),
        bits: frame.graph.transient_buffer("vpl_slot_bits", 4 * u64::from(count.div_ceil(32))),
        count,
    };
    frame.clear(&[(slots.bits, 0)]);
    slots
}

/// Declares where light paths start.
pub fn declare_starts(frame: &mut Frame, shape: &LightShape) -> BufferHandle {
    let everywhere = StartDensity::default();
    let density = shape.starts.as_deref().unwrap_or(&everywhere);
    frame.graph.filled_buffer("start_cells", bytemuck::cast_slice(&density.cells).into())
}

/// Adds the pass that traces a part of the paths.
pub fn add(frame: &mut Frame, part: &PathPart, slots: &VplSlots, start_cells: BufferHandle) {
    let work = ComputeWork {
        push: vec![part.paths.start, part.paths.end],
        ..frame.ray_shader("vpl_trace/trace_paths", threads(part.paths.len() as u32))
    };
    let pass = frame
        .compute(&part.named("vpl_trace", '/'), work)
        .bind("slot_positions", slots.positions, Access::ComputeWrite)
        .bind("slot_fluxes", slots.fluxes, Access::ComputeWrite)
        .bind("slot_bits", slots.bits, Access::ComputeReadWrite)
        .bind("start_cells", start_cells, Access::ComputeRead)
        .bind("ray_count", frame.ray_count, Access::ComputeReadWrite);
    frame.graph.add_pass(pass);
}
