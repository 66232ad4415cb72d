//! The pixel inspector: what a frame told about one pixel, in words.

use egui::{Color32, Grid, Pos2, Rect, RichText, Sense, Ui, Vec2, vec2};

use super::legend::color;
use crate::shared::InspectedPixel;
use crate::techniques::{InspectorImage, InspectorTable, TechniqueShape};
use crate::views::plain_number;

/// Edge of a pixel of a small picture, in points.
const TEXEL: f32 = 9.0;

/// Shows the pixel that was inspected last, if there is one.
pub fn show(ui: &mut Ui, technique: &dyn TechniqueShape, inspected: &InspectedPixel) {
    let [x, y] = inspected.pixel;
    if inspected.found == 0 {
        ui.label(format!("pixel {x}, {y}: no surface"));
        return;
    }
    surface(ui, inspected);
    for described in technique.inspector_tables(inspected) {
        ui.separator();
        table(ui, &described);
    }
    let images = technique.inspector_images(inspected);
    ui.horizontal(|ui| images.iter().for_each(|described| image(ui, described)));
}

fn image(ui: &mut Ui, image: &InspectorImage) {
    ui.vertical(|ui| {
        ui.label(image.name).on_hover_text(image.help);
        let (area, _) = ui.allocate_exact_size(Vec2::splat(TEXEL * image.edge as f32), Sense::hover());
        for (i, shade) in image.colors.iter().enumerate() {
            let Some(shade) = shade else { continue };
            let [column, row] = [i as u32 % image.edge, i as u32 / image.edge].map(|at| TEXEL * at as f32);
            let texel = Rect::from_min_size(area.min + vec2(column, row), Vec2::splat(TEXEL));
            ui.painter().rect_filled(texel, 0.0, color(*shade));
        }
    });
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
        row("direct", "Part of it that comes straight from the scene's lights and the environment", rgb(pixel.direct));
        row("environment", "Part of the direct light that comes from the environment", rgb(pixel.environment));
        row("indirect", "Albedo times lighting times shadow ratio", three(indirect));
        row("lighting", "Unshadowed indirect lighting for a white surface", rgb(pixel.lighting));
        row("shadow ratio", "Filtered S / U; 1 is no shadow", rgb(pixel.shadow_ratio));
    });
}

fn three(v: [f32; 3]) -> String {
    v.map(plain_number).join(" ")
}

/// Names of columns, with a word on each.
fn headings(ui: &mut Ui, columns: &[(&str, &str)]) {
    for (name, help) in columns {
        ui.label(RichText::new(*name).strong()).on_hover_text(*help);
    }
    ui.end_row();
}

fn table(ui: &mut Ui, table: &InspectorTable) {
    let grid = Grid::new(table.name).num_columns(table.columns.len()).striped(true).spacing([10.0, 1.0]);
    grid.show(ui, |ui| {
        headings(ui, table.columns);
        for row in &table.rows {
            for cell in row {
                match cell.color {
                    Some(shade) => ui.colored_label(color(shade), &cell.text),
                    None => ui.monospace(&cell.text),
                };
            }
            ui.end_row();
        }
    });
}
