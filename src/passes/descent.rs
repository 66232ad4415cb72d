//! `descent`: what every grid light above S1 is made of, so that a shadow ray towards a coarse light can end on
//! one of the surfaces that it stands for.
//!
//! The paper jitters the ray's end about the light's centre by its deviation. A coarse light covers several
//! walls, and most points of its box lie inside or behind them: those rays are blocked, which darkens the
//! indirect light (`docs/accuracy.md` has the numbers). Descending to a light of S0, at every level with a
//! probability proportional to luminance, keeps the distribution and stays on the surfaces.

use super::compaction::{GridLights, Lights};
use super::lgh_shape::LghShape;
use super::rounds::Round;
use super::shadow_rays::Samples;
use super::{Frame, shader, threads};
use crate::gpu::{ComputeWork, Dispatch, Work};
use crate::graph::{Access, BufferHandle, Pass};
use crate::shared::{DESCENT_STRIDE, REPRESENTATIVES};

/// Bytes of one table (`descent/tables.glsl`).
pub const TABLE_BYTES: u64 = 4 * DESCENT_STRIDE as u64;

/// The way from a coarse light to the lights it is made of.
#[derive(Clone, Copy, Debug)]
pub struct Descent {
    /// For every grid light above S1 its parts one level below.
    pub tables: BufferHandle,
    /// For every S1 light some lights of S0.
    pub representatives: BufferHandle,
    /// Low bits of a representative that hold its index.
    pub index_bits: u32,
}

/// Adds the passes.
pub fn add(
    frame: &mut Frame,
    shape: &LghShape,
    lights: &Lights,
    placement: BufferHandle,
    grid: &GridLights,
) -> Descent {
    let tables = build_tables(frame, shape, grid);
    let index_bits = shape.lights.light_capacity().next_power_of_two().trailing_zeros().max(1);
    let representatives = frame.graph.persistent_buffer("representatives", representative_bytes(shape));
    frame.clear(&[(representatives, u32::MAX)]);
    let work = ComputeWork {
        push: vec![index_bits],
        ..shader("descent/draw_representatives", threads(shape.lights.light_capacity()))
    };
    let pass = frame.compute("descent/draw_representatives", work);
    draw(frame, pass, lights, placement, grid, representatives);
    Descent { tables, representatives, index_bits }
}

fn representative_bytes(shape: &LghShape) -> u64 {
    4 * u64::from(REPRESENTATIVES) * u64::from(shape.grid_capacity)
}

fn draw(
    frame: &mut Frame,
    pass: Pass<Work>,
    lights: &Lights,
    placement: BufferHandle,
    grid: &GridLights,
    representatives: BufferHandle,
) {
    let pass = pass
        .with(|pass| lights.read_by(pass))
        .bind("grid", placement, Access::ComputeRead)
        .with(|pass| grid.looked_up_by(pass))
        .bind("representatives", representatives, Access::ComputeReadWrite);
    frame.graph.add_pass(pass);
}

/// Declares the representatives of further rounds of samples, in frames that have no history.
pub fn declare_round_representatives(frame: &mut Frame, shape: &LghShape) -> BufferHandle {
    frame.graph.transient_buffer("round_representatives", representative_bytes(shape))
}

/// Adds the passes that draw those of one round.
pub fn add_round(
    frame: &mut Frame,
    shape: &LghShape,
    samples: &Samples,
    descent: &Descent,
    representatives: BufferHandle,
    round: Round,
) {
    frame.clear_here(&format!("descent/clear/{}", round.number), &[(representatives, u32::MAX)]);
    let work = ComputeWork {
        push: vec![descent.index_bits, round.number],
        ..shader("descent/draw_representatives_round", threads(shape.lights.light_capacity()))
    };
    let pass = frame.compute(&format!("descent/draw_representatives/{}", round.number), work);
    draw(frame, pass, &samples.lights, samples.placement, &samples.grid, representatives);
}

fn build_tables(frame: &mut Frame, shape: &LghShape, grid: &GridLights) -> BufferHandle {
    let tables = frame.graph.persistent_buffer("descent_tables", TABLE_BYTES * u64::from(shape.upper_capacity.max(1)));
    let dispatch = Dispatch::Indirect { buffer: grid.dispatches, offset_bytes: 0 };
    let pass = frame
        .compute("descent/build_tables", shader("descent/build_tables", dispatch))
        .bind("grid_lights", grid.lights, Access::ComputeRead)
        .with(|pass| grid.looked_up_by(pass))
        .bind("descent", tables, Access::ComputeWrite)
        .uses(grid.dispatches, Access::IndirectRead);
    frame.graph.add_pass(pass);
    tables
}
