//! What the keys do.

use egui::{Align2, RichText, Ui};

use crate::app::window::keys::HELP;

/// Shows the keys, as long as that is wanted.
pub fn window(ui: &Ui, shows: &mut bool) {
    let window = egui::Window::new("Keys").open(shows).collapsible(false).resizable(false);
    window.anchor(Align2::CENTER_CENTER, [0.0, 0.0]).show(ui.ctx(), |ui| {
        egui::Grid::new("keys").num_columns(2).striped(true).show(ui, |ui| {
            for (keys, what) in HELP {
                ui.label(RichText::new(keys).strong());
                ui.label(what);
                ui.end_row();
            }
        });
    });
}
