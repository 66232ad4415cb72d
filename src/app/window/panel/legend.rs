//! Legends of views over the picture: the same scales as in saved pictures.

use egui::{Align2, Color32, Pos2, Rect, Sense, Ui, Vec2, pos2, vec2};

use super::facts::SideFacts;
use crate::views::legend::{color_at, ticks};
use crate::views::{self, Patch, Scale};

/// Size of a colour bar in points.
const BAR: Vec2 = Vec2::new(200.0, 14.0);
/// Least size of a patch.
const PATCH: Vec2 = Vec2::new(24.0, 18.0);

/// The colour of `0xRRGGBB`.
pub fn color(rgb: u32) -> Color32 {
    let [_, r, g, b] = rgb.to_be_bytes();
    Color32::from_rgb(r, g, b)
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
        Scale::Patches(of_scale) => patches(ui, &of_scale),
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

fn patches(ui: &mut Ui, patches: &[Patch]) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        for patch in patches {
            let font = egui::TextStyle::Small.resolve(ui.style());
            let text = ui.painter().layout_no_wrap(patch.text.clone(), font, Color32::BLACK);
            let (area, _) = ui.allocate_exact_size(PATCH.max(text.size() + vec2(6.0, 2.0)), Sense::hover());
            ui.painter().rect_filled(area, 2.0, color(patch.color));
            ui.painter().galley(area.center() - 0.5 * text.size(), text, Color32::BLACK);
        }
    });
}
