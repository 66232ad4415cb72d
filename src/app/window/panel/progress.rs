//! How far the picture of a window at rest has come.

use egui::{Align2, Color32, Stroke, Ui, Vec2};

use super::facts::{Facts, Progress};
use crate::app::window::quality::Quality;

/// Diameter of the mark in points.
const SIZE: f32 = 14.0;

/// Share that is done, and what that is, in a few words.
fn done(progress: &Progress) -> (f32, String) {
    let Progress { quality, accumulated, goal, part, .. } = *progress;
    match (quality, part) {
        (Some(Quality::Full), Some([done, all])) => {
            (done as f32 / all.max(1) as f32, format!("{done} of {all} rounds"))
        }
        (Some(Quality::Full), None) if accumulated > 0 => {
            (accumulated as f32 / goal.max(1) as f32, format!("{accumulated} of {goal} frames accumulated"))
        }
        _ => (0.0, "rendering the full picture".to_owned()),
    }
}

/// A small circle in the corner that fills, and is gone once there will be no better picture.
pub fn mark(ui: &Ui, facts: &Facts<'_>) {
    let progress = &facts.progress;
    if progress.is_done || progress.quality.is_none() || !facts.scale_is_chosen && progress.goal == 1 {
        return;
    }
    let (share, words) = done(progress);
    let corner = ui.available_rect_before_wrap().right_bottom() - Vec2::splat(8.0);
    let area = egui::Area::new("progress".into()).fixed_pos(corner).pivot(Align2::RIGHT_BOTTOM);
    area.interactable(false).show(ui.ctx(), |ui| {
        let (rect, response) = ui.allocate_exact_size(Vec2::splat(SIZE), egui::Sense::hover());
        let (center, radius) = (rect.center(), 0.5 * SIZE - 1.0);
        let painter = ui.painter();
        painter.circle(
            center,
            radius,
            Color32::from_black_alpha(120),
            Stroke::new(1.5, Color32::from_white_alpha(110)),
        );
        let steps = (share.clamp(0.0, 1.0) * 32.0).round() as usize;
        let rim = (0..=steps).map(|step| {
            let angle = std::f32::consts::TAU * (step as f32 / 32.0 - 0.25);
            center + (radius - 3.0) * Vec2::angled(angle)
        });
        let pie: Vec<_> = std::iter::once(center).chain(rim).collect();
        if steps > 0 {
            // A fan of triangles: the shape need not be convex.
            for corners in pie[1..].windows(2) {
                let triangle = vec![center, corners[0], corners[1]];
                painter.add(egui::Shape::convex_polygon(triangle, Color32::from_white_alpha(200), Stroke::NONE));
            }
        }
        response.on_hover_text(words);
    });
}

/// The same as a bar in the panel, always there so that nothing below it moves.
pub fn bar(ui: &mut Ui, facts: &Facts<'_>) {
    let (share, words) = done(&facts.progress);
    ui.add(egui::ProgressBar::new(share).text(words));
}
