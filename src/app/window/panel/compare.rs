//! The split view: its section of the panel, its divider, and what is written over each side.

use egui::{Align2, Area, Color32, CursorIcon, Order, Rect, RichText, Sense, Ui, Vec2, pos2, vec2};

use super::facts::{Facts, HeldFacts};
use super::{inspector, legend};
use crate::app::window::action::Action;
use crate::settings::Exposure;

/// Width of the strip that takes the divider, in points.
const GRIP: f32 = 14.0;
/// Most settings that are named over a side.
const NAMED: usize = 4;

/// The section of the panel.
pub fn section(ui: &mut Ui, facts: &Facts<'_>, actions: &mut Vec<Action>) {
    let Some(held) = &facts.held else {
        let help = "Keeps the current settings on the left; later changes apply to the right";
        if ui.button("Split the view (C)").on_hover_text(help).clicked() {
            actions.push(Action::Split);
        }
        return;
    };
    ui.horizontal(|ui| {
        if ui.button("End (C)").on_hover_text("Ends the split view and keeps the right side's settings").clicked() {
            actions.push(Action::Split);
        }
        let help = "Swaps the sides; the panel controls the right one";
        if ui.button("Swap sides (X)").on_hover_text(help).clicked() {
            actions.push(Action::Swap);
        }
    });
    ui.label(format!("left side: GPU {:.1} ms per frame", held.ms));
    if held.differences.is_empty() {
        ui.label("Both sides are the same: change any setting, or apply a preset.");
    }
    egui::Grid::new("differences").num_columns(3).striped(true).show(ui, |ui| {
        for (key, [left, right]) in &held.differences {
            ui.label(key);
            ui.label(shown(left));
            ui.label(shown(right));
            ui.end_row();
        }
    });
    if facts.settings.picture.exposure == Exposure::Auto {
        ui.label(
            RichText::new("Each side has its own automatic exposure; a fixed exposure makes them comparable.").small(),
        );
    }
}

fn shown(value: &str) -> &str {
    if value.is_empty() { "auto" } else { value }
}

/// The divider, and what is written over the sides. `free` is what the panel leaves of the window.
pub fn overlay(ui: &mut Ui, free: Rect, facts: &Facts<'_>, actions: &mut Vec<Action>) {
    let window = ui.ctx().content_rect();
    if let Some(held) = &facts.held {
        let x = window.left() + held.divider * window.width();
        divider(ui, window, x, actions);
        corner(ui, "left side", pos2(window.left() + 8.0, window.top() + 8.0), |ui| {
            names(ui, held, 0);
            legend::show(ui, &held.side);
        });
        corner(ui, "right side", pos2(x + 8.0, window.top() + 8.0), |ui| {
            names(ui, held, 1);
            legend::show(ui, &facts.main);
        });
    } else if legend::of(&facts.main).is_some() {
        corner(ui, "legend", pos2(window.left() + 8.0, window.top() + 8.0), |ui| legend::show(ui, &facts.main));
    }
    if facts.inspects {
        inspect(ui, free, facts);
    }
}

/// What was told about the inspected pixel, by the side that it is on.
fn inspect(ui: &Ui, free: Rect, facts: &Facts<'_>) {
    let Some(pixel) = facts.main.feedback.and_then(|feedback| feedback.inspected) else { return };
    let window = ui.ctx().content_rect();
    let [x, y] = pixel.pixel.map(|at| at as f32 + 0.5);
    let at = pos2(x / facts.picture.width as f32, y / facts.picture.height as f32);
    let at = window.lerp_inside(at.to_vec2());
    inspector::mark(ui, at);
    let on_left = |held: &&HeldFacts<'_>| at.x < window.left() + held.divider * window.width();
    let side = facts.held.as_ref().filter(on_left).map_or(&facts.main, |held| &held.side);
    let (Some(shapes), Some(pixel)) = (side.shapes, side.feedback.and_then(|feedback| feedback.inspected)) else {
        return;
    };
    // Away from the pixel.
    let (place, pivot) = if at.x < free.center().x {
        (free.right_center() - vec2(8.0, 0.0), Align2::RIGHT_CENTER)
    } else {
        (free.left_center() + vec2(8.0, 0.0), Align2::LEFT_CENTER)
    };
    Area::new("inspector".into()).pivot(pivot).fixed_pos(place).interactable(false).show(ui.ctx(), |ui| {
        egui::Frame::popup(ui.style()).show(ui, |ui| inspector::show(ui, &*shapes.technique, &pixel));
    });
}

fn corner(ui: &Ui, name: &'static str, at: egui::Pos2, contents: impl FnOnce(&mut Ui)) {
    Area::new(name.into()).fixed_pos(at).constrain(false).interactable(false).show(ui.ctx(), |ui| {
        egui::Frame::popup(ui.style()).show(ui, contents);
    });
}

/// The settings of one side that the other has not.
fn names(ui: &mut Ui, held: &HeldFacts<'_>, side: usize) {
    ui.set_max_width(240.0);
    if held.differences.is_empty() {
        ui.label(["left", "right"][side]);
    }
    for (key, values) in held.differences.iter().take(NAMED) {
        ui.label(format!("{key} {}", shown(&values[side])));
    }
    if held.differences.len() > NAMED {
        ui.label(format!("and {} more", held.differences.len() - NAMED));
    }
}

fn divider(ui: &Ui, window: Rect, x: f32, actions: &mut Vec<Action>) {
    let area = Area::new("divider".into()).order(Order::Middle).constrain(false);
    area.fixed_pos(pos2(x - 0.5 * GRIP, window.top())).show(ui.ctx(), |ui| {
        let (strip, response) = ui.allocate_exact_size(vec2(GRIP, window.height()), Sense::drag());
        let response = response.on_hover_and_drag_cursor(CursorIcon::ResizeHorizontal);
        if response.dragged()
            && let Some(pointer) = ui.ctx().pointer_latest_pos()
        {
            actions.push(Action::Divider(((pointer.x - window.left()) / window.width()).clamp(0.0, 1.0)));
        }
        let middle = strip.center();
        let line = [pos2(middle.x, strip.top()), pos2(middle.x, strip.bottom())];
        ui.painter().line_segment(line, (3.0, Color32::BLACK));
        ui.painter().line_segment(line, (1.0, Color32::WHITE));
        let handle = Rect::from_center_size(middle, Vec2::new(10.0, 34.0));
        let lit = response.hovered() || response.dragged();
        let fill = if lit { Color32::WHITE } else { Color32::from_gray(190) };
        ui.painter().rect(handle, 4.0, fill, (1.0, Color32::BLACK), egui::StrokeKind::Outside);
    });
}
