//! Twins of the stages of `grid_update`: S1 from the last one, by the lights that have changed.

use super::grid::Grid;
use super::lights::LightList;
use super::scatter_lights::{Moments, Records, Sign, add_light};

/// Lights S0 and the slots that they are from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SlotLights {
    /// For each slot the light in it, if there is one.
    pub slots: Vec<Option<usize>>,
    /// The lights, in the order of their slots.
    pub lights: LightList,
}

/// A slot whose light is another: which it was, and which it is.
pub type Change = [Option<usize>; 2];

/// The slots whose lights differ to the bit.
#[must_use]
pub fn find_changes(before: &SlotLights, now: &SlotLights) -> Vec<Change> {
    let bits = |of: &SlotLights, light: usize| (of.lights.positions[light], of.lights.fluxes[light].map(f32::to_bits));
    let differ = |[a, b]: &Change| match (a, b) {
        (Some(a), Some(b)) => bits(before, *a) != bits(now, *b),
        (a, b) => a.is_some() != b.is_some(),
    };
    before.slots.iter().zip(&now.slots).map(|(before, now)| [*before, *now]).filter(differ).collect()
}

/// The sums of the last build where the vertices of S1 stand now; 0 for new ones. `vertices` are those of S1.
#[must_use]
pub fn move_moments(kept: &[Moments], kept_records: &Records<'_>, vertices: &[u32], grid: &Grid) -> Vec<Moments> {
    let of_vertex = |vertex: &u32| kept_records.at(grid, grid.vertex_from_index(*vertex, 1), 1);
    vertices.iter().map(|vertex| of_vertex(vertex).map_or([0; 14], |record| kept[record])).collect()
}

/// Takes the lights that have changed out of the sums of S1, and adds them as they are now.
pub fn apply_changes(
    moments: &mut [Moments],
    changes: &[Change],
    [before, now]: [&LightList; 2],
    grid: &Grid,
    records: &Records<'_>,
) {
    for [old, new] in changes {
        if let Some(light) = old {
            add_light(moments, before, *light, grid, records, 1, Sign::Minus);
        }
        if let Some(light) = new {
            add_light(moments, now, *light, grid, records, 1, Sign::Plus);
        }
    }
}
