//! The pixel inspector: what a frame told about one pixel, in words.

use egui::{Color32, Grid, Pos2, Rect, RichText, Sense, Ui, Vec2, vec2};

use super::legend::color;
use crate::report::inspected;
use crate::shared::InspectedPixel;
use crate::techniques::{InspectorImage, InspectorTable, TechniqueShape};

/// Edge of a pixel of a small picture, in points.
const TEXEL: f32 = 9.0;

/// Shows the pixel that was inspected last, if there is one.
pub fn show(ui: &mut Ui, technique: &dyn TechniqueShape, pixel: &InspectedPixel) {
    if pixel.found == 0 {
        ui.label(inspected::no_surface(pixel));
        return;
    }
    surface(ui, pixel);
    for described in technique.inspector_tables(pixel) {
        ui.separator();
        table(ui, &described);
    }
    let images = technique.inspector_images(pixel);
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
    Grid::new("inspected surface").num_columns(2).spacing([10.0, 1.0]).show(ui, |ui| {
        for (name, help, value) in inspected::rows(pixel) {
            ui.label(name).on_hover_text(help);
            ui.monospace(value);
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
