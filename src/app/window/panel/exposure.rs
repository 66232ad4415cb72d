//! The exposure that the picture has, and its compensation.

use egui::Ui;

use super::facts::Facts;
use crate::app::window::action::Action;
use crate::settings::Exposure;

/// Most stops that the slider gives; the row of the setting takes more.
const SLIDER_STOPS: f32 = 8.0;

/// Shows what the last completed frame had, and a slider; views with a scale of their own have none.
pub fn show(ui: &mut Ui, facts: &Facts<'_>, actions: &mut Vec<Action>) {
    let Some(exposure) = facts.main.feedback.and_then(|feedback| feedback.exposure()) else { return };
    let picture = &facts.settings.picture;
    egui::Grid::new("exposure").num_columns(2).show(ui, |ui| {
        ui.label("Exposure").on_hover_text("Factor on the radiance, including compensation");
        let how = if picture.exposure == Exposure::Auto { "automatic" } else { "fixed" };
        ui.label(format!("{exposure:.4}, {how}"));
        ui.end_row();
        ui.label("Compensation, stops").on_hover_text("Page Up and Page Down keys, a quarter stop each");
        let mut stops = picture.exposure_compensation;
        let range = -SLIDER_STOPS..=SLIDER_STOPS;
        let slider = egui::Slider::new(&mut stops, range).clamping(egui::SliderClamping::Edits).step_by(0.25);
        if ui.add(slider).changed() && stops != picture.exposure_compensation {
            actions.push(Action::Set("exposure-compensation".to_owned(), stops.to_string()));
        }
        ui.end_row();
    });
}
