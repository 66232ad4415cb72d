//! What the hierarchy tells about an inspected pixel: lights by level, shadow samples.

use super::super::{Cell, InspectorTable};
use crate::passes::lgh_shape::LghShape;
use crate::shared::{InspectedPixel, NO_LIGHT, SAMPLE_BLOCKED, SAMPLE_EMPTY, SAMPLE_UNLIT};
use crate::views::{LEVEL_COLORS, plain_number};

/// Of samples without a light, or whose light does not reach the pixel.
const GRAY: u32 = 0xa0a0a0;
const RED: u32 = 0xff8278;
const GREEN: u32 = 0x8ce68c;

/// The tables of a pixel, without those that have no rows.
pub(super) fn tables(shape: &LghShape, pixel: &InspectedPixel) -> Vec<InspectorTable> {
    [levels(shape, pixel), samples(pixel)].into_iter().filter(|table| !table.rows.is_empty()).collect()
}

fn level_cell(level: u32) -> Cell {
    Cell::colored(format!("■ {level}"), LEVEL_COLORS[level as usize % LEVEL_COLORS.len()])
}

fn percent(part: f32, sum: f32) -> String {
    format!("{:.1} %", 100.0 * part / sum.max(1e-30))
}

fn levels(shape: &LghShape, pixel: &InspectedPixel) -> InspectorTable {
    let sum: f32 = pixel.levels.iter().map(|level| level.lighting).sum();
    let used = pixel.levels.iter().enumerate().take(pixel.level_count as usize).skip(shape.first_level as usize);
    let row = |(number, level): (usize, &crate::shared::InspectedLevel)| {
        let strongest = format!(
            "{:.3} m, {:.2}, {}",
            level.strongest_distance,
            level.strongest_weight,
            percent(level.strongest_lighting, sum)
        );
        vec![
            level_cell(number as u32),
            Cell::plain(level.count.to_string()),
            Cell::plain(level.blended.to_string()),
            Cell::plain(format!("{:.3}", level.weight / level.count.max(1) as f32)),
            Cell::plain(percent(level.lighting, sum)),
            Cell::plain(if level.strongest == NO_LIGHT { String::new() } else { strongest }),
        ]
    };
    InspectorTable {
        name: "inspected levels",
        columns: &[
            ("level", "0 is the lights themselves; higher levels have fewer and larger lights"),
            ("lights", "Lights of the level that contribute to the pixel"),
            ("blending", "Those in the blending range to the next level"),
            ("weight", "Mean blending weight of the lights that contribute"),
            ("share", "Share of the unshadowed lighting"),
            ("strongest", "Distance, weight and share of the light that contributes most"),
        ],
        rows: used.map(row).collect(),
    }
}

fn samples(pixel: &InspectedPixel) -> InspectorTable {
    let row = |(index, sample): (usize, &crate::shared::InspectedSample)| {
        let (text, shade) = match sample.state {
            SAMPLE_EMPTY => ("no light picked", GRAY),
            SAMPLE_UNLIT => ("light faces away", GRAY),
            SAMPLE_BLOCKED => ("blocked", RED),
            _ => ("visible", GREEN),
        };
        let [level, length, estimate] = if sample.state == SAMPLE_EMPTY {
            [Cell::default(), Cell::default(), Cell::default()]
        } else {
            let estimate = plain_number(sample.estimate);
            [
                level_cell(sample.level),
                Cell::plain(format!("{:.3} m", sample.distance)),
                Cell::plain(estimate.trim_start()),
            ]
        };
        vec![Cell::plain((index + 1).to_string()), level, length, estimate, Cell::colored(text, shade)]
    };
    InspectorTable {
        name: "inspected samples",
        columns: &[
            ("sample", "Shadow samples of the pixel, before the filter"),
            ("level", "Level of the selected light"),
            ("length", "Length of the shadow ray"),
            ("estimate", "Estimate of the unshadowed lighting, relative to the sum over all lights"),
            ("shadow ray", "Whether the light is occluded"),
        ],
        rows: pixel.samples.iter().enumerate().take(pixel.sample_count as usize).map(row).collect(),
    }
}
