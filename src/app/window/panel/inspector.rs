//! The pixel inspector: what a frame told about one pixel, in words.

use egui::{Color32, Grid, Pos2, RichText, Ui};

use super::legend::level_color;
use crate::passes::FrameShape;
use crate::shared::{InspectedPixel, NO_LIGHT, SAMPLE_BLOCKED, SAMPLE_EMPTY, SAMPLE_UNLIT};

/// Shows the pixel that was inspected last, if there is one.
pub fn show(ui: &mut Ui, shape: &FrameShape, inspected: &InspectedPixel) {
    let [x, y] = inspected.pixel;
    if inspected.found == 0 {
        ui.label(format!("pixel {x}, {y}: no surface"));
        return;
    }
    surface(ui, inspected);
    if inspected.level_count > 0 {
        ui.separator();
        levels(ui, shape, inspected);
    }
    if inspected.sample_count > 0 {
        ui.separator();
        samples(ui, inspected);
    }
}

/// A ring about the inspected pixel.
pub fn mark(ui: &Ui, at: Pos2) {
    let layer = egui::LayerId::new(egui::Order::Middle, "inspected".into());
    let painter = ui.ctx().layer_painter(layer);
    painter.circle_stroke(at, 6.0, (2.5, Color32::BLACK));
    painter.circle_stroke(at, 6.0, (1.0, Color32::WHITE));
}

fn surface(ui: &mut Ui, pixel: &InspectedPixel) {
    let indirect = [0, 1, 2].map(|i| pixel.albedo[i] * pixel.lighting[i] * pixel.shadow_ratio[i]);
    let rgb = |v: [f32; 4]| three([v[0], v[1], v[2]]);
    Grid::new("inspected surface").num_columns(2).spacing([10.0, 1.0]).show(ui, |ui| {
        let mut row = |name: &str, help: &str, value: String| {
            ui.label(name).on_hover_text(help);
            ui.monospace(value);
            ui.end_row();
        };
        let [x, y] = pixel.pixel;
        row("pixel", "Counted from the top left corner of the picture", format!("{x}, {y}"));
        row("distance", "Along the viewing direction, in metres", format!("{:.4} m", pixel.depth));
        row("position", "World space, in metres", three(pixel.position_ws));
        row("normal", "Shading normal, normal map included", three(pixel.normal));
        row("triangle", "Normal of the triangle", three(pixel.geometric_normal));
        row("albedo", "Linear base colour", three(pixel.albedo));
        row("radiance", "What the pixel shows before exposure; the values of a view", rgb(pixel.radiance));
        row("direct", "Part of it that comes straight from the scene's lights", rgb(pixel.direct));
        row("indirect", "Albedo times lighting times shadow ratio", three(indirect));
        row("lighting", "Unshadowed indirect lighting for a white surface", rgb(pixel.lighting));
        row("shadow ratio", "Filtered S / U; 1 is no shadow", rgb(pixel.shadow_ratio));
    });
}

/// A number with as many digits as tell something.
fn number(v: f32) -> String {
    match v.abs() {
        a if a >= 1000.0 || (a > 0.0 && a < 0.001) => format!("{v:>9.2e}"),
        _ => format!("{v:>9.4}"),
    }
}

fn three(v: [f32; 3]) -> String {
    v.map(number).join(" ")
}

fn levels(ui: &mut Ui, shape: &FrameShape, pixel: &InspectedPixel) {
    let sum: f32 = pixel.levels.iter().map(|level| level.lighting).sum();
    Grid::new("inspected levels").num_columns(6).striped(true).spacing([10.0, 1.0]).show(ui, |ui| {
        headings(
            ui,
            &[
                ("level", "0 are the lights themselves, higher levels have fewer and larger ones"),
                ("lights", "Lights of the level that contribute to the pixel"),
                ("blending", "Those of them that fade into the next level, being half in reach"),
                ("weight", "Mean blending weight of the lights that contribute"),
                ("share", "Of the unshadowed lighting"),
                ("strongest", "Distance of the light that contributes most, its weight and its share"),
            ],
        );
        for (number, level) in pixel.levels.iter().enumerate().take(pixel.level_count as usize) {
            if (number as u32) < shape.first_level {
                continue;
            }
            level_label(ui, number as u32);
            ui.monospace(level.count.to_string());
            ui.monospace(level.blended.to_string());
            ui.monospace(format!("{:.3}", level.weight / level.count.max(1) as f32));
            ui.monospace(percent(level.lighting, sum));
            let strongest = format!(
                "{:.3} m, {:.2}, {}",
                level.strongest_distance,
                level.strongest_weight,
                percent(level.strongest_lighting, sum)
            );
            ui.monospace(if level.strongest == NO_LIGHT { String::new() } else { strongest });
            ui.end_row();
        }
    });
}

/// Names of columns, with a word on each.
fn headings(ui: &mut Ui, columns: &[(&str, &str)]) {
    for (name, help) in columns {
        ui.label(RichText::new(*name).strong()).on_hover_text(*help);
    }
    ui.end_row();
}

fn level_label(ui: &mut Ui, level: u32) {
    ui.colored_label(level_color(level), format!("■ {level}"));
}

fn percent(part: f32, sum: f32) -> String {
    format!("{:.1} %", 100.0 * part / sum.max(1e-30))
}

fn samples(ui: &mut Ui, pixel: &InspectedPixel) {
    Grid::new("inspected samples").num_columns(5).striped(true).spacing([10.0, 1.0]).show(ui, |ui| {
        headings(
            ui,
            &[
                ("sample", "Shadow samples of the pixel, before the filter"),
                ("level", "Level of the light that was picked"),
                ("length", "Of the shadow ray"),
                ("estimate", "Of the unshadowed lighting, relative to the sum over all lights"),
                ("shadow ray", "Whether something stands before the light"),
            ],
        );
        for (index, sample) in pixel.samples.iter().enumerate().take(pixel.sample_count as usize) {
            ui.monospace((index + 1).to_string());
            let (text, shade) = match sample.state {
                SAMPLE_EMPTY => ("no light picked", Color32::GRAY),
                SAMPLE_UNLIT => ("light faces away", Color32::GRAY),
                SAMPLE_BLOCKED => ("blocked", Color32::from_rgb(255, 130, 120)),
                _ => ("visible", Color32::from_rgb(140, 230, 140)),
            };
            if sample.state != SAMPLE_EMPTY {
                level_label(ui, sample.level);
                ui.monospace(format!("{:.3} m", sample.distance));
                ui.monospace(number(sample.estimate).trim_start());
            } else {
                (0..3).for_each(|_| drop(ui.label("")));
            }
            ui.colored_label(shade, text);
            ui.end_row();
        }
    });
}
