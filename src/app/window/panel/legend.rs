//! Legends of views over the picture: the same scales as in saved pictures.

use egui::{Align2, Color32, Pos2, Rect, Sense, Ui, Vec2, pos2, vec2};

use super::facts::SideFacts;
use crate::views::legend::{color_at, ticks};
use crate::views::{self, LEVEL_COLORS, Scale};

/// Size of a colour bar in points.
const BAR: Vec2 = Vec2::new(200.0, 14.0);
/// Size of a level's patch.
const PATCH: Vec2 = Vec2::new(24.0, 18.0);

/// The colour of `0xRRGGBB`.
pub fn color(rgb: u32) -> Color32 {
    let [_, r, g, b] = rgb.to_be_bytes();
    Color32::from_rgb(r, g, b)
}

/// The colour of a level.
fn level_color(level: u32) -> Color32 {
    color(LEVEL_COLORS[level as usize % LEVEL_COLORS.len()])
}

/// Title and scale of a side's view, when it has one.
pub fn of(side: &SideFacts<'_>) -> Option<(&'static str, Scale)> {
    let (shapes, feedback) = (side.shapes?, side.feedback?);
    views::legend_of(shapes.frame.view, shapes.technique.level_range(), feedback.exposure_or_scale)
}

/// Shows the legend of a side's view, when it has one.
pub fn show(ui: &mut Ui, side: &SideFacts<'_>) {
    let Some((title, scale)) = of(side) else { return };
    ui.label(title);
    match scale {
        Scale::Bar { map, end, whole } => bar(ui, map.colors, &ticks(end, whole)),
        Scale::Levels { first, last } => levels(ui, first, last),
    }
}

fn bar(ui: &mut Ui, colors: &[u32], ticks: &[String; 3]) {
    let font = egui::TextStyle::Small.resolve(ui.style());
    let (area, _) = ui.allocate_exact_size(BAR + vec2(0.0, font.size + 3.0), Sense::hover());
    let columns = BAR.x as u32;
    for column in 0..columns {
        let left = area.left() + column as f32;
        let fill = color(color_at(colors, column as f32 / (columns - 1) as f32));
        ui.painter().rect_filled(Rect::from_min_size(pos2(left, area.top()), vec2(1.5, BAR.y)), 0.0, fill);
    }
    let below = |x: f32| Pos2::new(x, area.top() + BAR.y + 2.0);
    let positions = [
        (area.left(), Align2::LEFT_TOP),
        (area.left() + 0.5 * BAR.x, Align2::CENTER_TOP),
        (area.left() + BAR.x, Align2::RIGHT_TOP),
    ];
    for (tick, (x, align)) in ticks.iter().zip(positions) {
        ui.painter().text(below(x), align, tick, font.clone(), ui.visuals().text_color());
    }
}

fn levels(ui: &mut Ui, first: u32, last: u32) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        for level in first..=last {
            let (patch, _) = ui.allocate_exact_size(PATCH, Sense::hover());
            ui.painter().rect_filled(patch, 2.0, level_color(level));
            let font = egui::TextStyle::Small.resolve(ui.style());
            ui.painter().text(patch.center(), Align2::CENTER_CENTER, level.to_string(), font, Color32::BLACK);
        }
    });
}
