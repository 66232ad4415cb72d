//! The panel: egui over the picture.

mod compare;
mod exposure;
pub mod facts;
mod help;
pub mod history;
mod inspector;
mod legend;
mod progress;
mod rows;
mod scene_file;
mod times;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use egui::{Align2, Color32, Context, RichText, Ui};
use serde_json::Value;
use winit::event::WindowEvent;
use winit::keyboard::{KeyCode, PhysicalKey};
use winit::window::Window;

use self::facts::Facts;
use self::rows::Rows;
use self::scene_file::SceneFile;
use super::action::Action;
use super::presets::PRESETS;
use crate::gpu::PanelPicture;

/// A message stays for so long.
pub const MESSAGE: Duration = Duration::from_secs(4);
/// And an error, which is longer.
const ERROR_STAYS: Duration = Duration::from_secs(12);
/// Time between two pictures of a panel that moves.
const DISPLAY: Duration = Duration::from_millis(16);
/// Width of the panel in points.
const WIDTH: f32 = 380.0;
const ERROR: Color32 = Color32::from_rgb(255, 130, 120);

/// The panel and what it remembers.
pub struct Panel {
    context: Context,
    input: egui_winit::State,
    visible: bool,
    shows_help: bool,
    rows: Rows,
    error: Option<(Instant, String)>,
    message: Option<(Instant, String)>,
    settings_file: String,
    scene_file: SceneFile,
    repaint: bool,
}

impl Panel {
    /// Hidden at first; who sees it for the first time is told how to show it.
    pub fn new(window: &Window, is_first_start: bool) -> Self {
        let context = Context::default();
        context.set_theme(egui::Theme::Dark);
        let scale = Some(window.scale_factor() as f32);
        let input = egui_winit::State::new(context.clone(), egui::ViewportId::ROOT, window, scale, None, None);
        let hello = || (Instant::now(), "Tab: settings    H: keyboard help".to_owned());
        Self {
            context,
            input,
            visible: false,
            shows_help: false,
            rows: Rows::new(),
            error: None,
            message: is_first_start.then(hello),
            settings_file: "gridlight.toml".to_owned(),
            scene_file: SceneFile::new(),
            repaint: true,
        }
    }

    /// Shows or hides the panel.
    pub fn toggle(&mut self) {
        self.visible = !self.visible;
    }

    /// Shows or hides what the keys do.
    pub fn toggle_help(&mut self) {
        self.shows_help = !self.shows_help;
    }

    /// Shows an error until something is changed, or for some seconds.
    pub fn show_error(&mut self, sentence: String) {
        self.error = Some((Instant::now(), sentence));
    }

    /// The error is past.
    pub fn clear_error(&mut self) {
        self.error = None;
    }

    /// Shows a message for a few seconds.
    pub fn say(&mut self, text: String) {
        self.message = Some((Instant::now(), text));
    }

    /// When the panel is to be laid out again, should nothing happen: it moves by itself, or a message is to go.
    pub fn repaint_in(&self) -> Option<Duration> {
        let message = self.message.as_ref().map(|(since, _)| MESSAGE.saturating_sub(since.elapsed()));
        let error = self.error.as_ref().map(|(since, _)| ERROR_STAYS.saturating_sub(since.elapsed()));
        let moves = self.repaint.then_some(DISPLAY);
        moves.into_iter().chain(message).chain(error).min()
    }

    /// Lets egui see an event; true when it is not for the picture.
    pub fn on_event(&mut self, window: &Window, event: &WindowEvent) -> bool {
        if is_tab(event) {
            // It shows and hides the panel; egui would put its focus on a button, which Space then presses.
            return false;
        }
        let response = self.input.on_window_event(window, event);
        match event {
            // Keys that a text or an open list is waiting for are theirs.
            WindowEvent::KeyboardInput { .. } => {
                let is_open = egui::Popup::is_any_open(&self.context) || self.scene_file.asks();
                self.visible && (self.context.egui_wants_keyboard_input() || is_open)
            }
            WindowEvent::MouseInput { .. } | WindowEvent::MouseWheel { .. } => {
                self.context.egui_wants_pointer_input() || self.context.is_pointer_over_egui()
            }
            _ => response.consumed,
        }
    }

    /// Lays the panel out; gives what to draw and what the user wants.
    pub fn run(&mut self, window: &Window, facts: &Facts<'_>) -> (PanelPicture, Vec<Action>) {
        if self.message.as_ref().is_some_and(|(since, _)| since.elapsed() >= MESSAGE) {
            self.message = None;
        }
        if self.error.as_ref().is_some_and(|(since, _)| since.elapsed() >= ERROR_STAYS) {
            self.error = None;
        }
        let input = self.input.take_egui_input(window);
        let mut actions = Vec::new();
        let context = self.context.clone();
        let output = context.run_ui(input, |ui| self.lay_out(ui, facts, &mut actions));
        self.input.handle_platform_output(window, output.platform_output);
        self.repaint = context.has_requested_repaint();
        let picture = PanelPicture {
            primitives: context.tessellate(output.shapes, output.pixels_per_point),
            textures: output.textures_delta,
            pixels_per_point: output.pixels_per_point,
        };
        (picture, actions)
    }

    fn lay_out(&mut self, ui: &mut Ui, facts: &Facts<'_>, actions: &mut Vec<Action>) {
        if self.visible {
            let panel = egui::Panel::right("panel").default_size(WIDTH).resizable(true);
            panel.show(ui, |ui| {
                egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| self.contents(ui, facts, actions));
            });
        }
        self.scene_file.dialog(ui.ctx(), actions);
        compare::overlay(ui, ui.available_rect_before_wrap(), facts, actions);
        progress::mark(ui, facts);
        help::window(ui, &mut self.shows_help);
        self.notes(ui, facts);
    }

    /// Where the cursor is, from the top left corner of the window, 0 to 1; `None` over the panel or outside.
    pub fn cursor(&self) -> Option<[f32; 2]> {
        let window = self.context.content_rect();
        let at = self.context.pointer_hover_pos().filter(|at| window.contains(*at))?;
        let over_panel = self.context.is_pointer_over_egui();
        (!over_panel).then(|| [(at.x - window.left()) / window.width(), (at.y - window.top()) / window.height()])
    }

    /// What is shown over the picture, panel or not.
    fn notes(&self, ui: &Ui, facts: &Facts<'_>) {
        let mut lines = Vec::new();
        lines.extend(facts.loading.clone().map(|text| (text, Color32::LIGHT_YELLOW)));
        lines.extend(self.message.clone().map(|(_, text)| (text, Color32::WHITE)));
        let complaint = facts.main.feedback.and_then(|feedback| feedback.complaint.clone());
        lines.extend(complaint.map(|text| (text, Color32::LIGHT_YELLOW)));
        lines.extend(self.error.clone().map(|(_, text)| (text, ERROR)));
        if lines.is_empty() {
            return;
        }
        egui::Area::new("notes".into()).anchor(Align2::LEFT_BOTTOM, [8.0, -8.0]).interactable(false).show(
            ui.ctx(),
            |ui| {
                egui::Frame::popup(ui.style()).show(ui, |ui| {
                    ui.set_max_width((ui.ctx().content_rect().width() - 40.0).max(40.0));
                    for (text, color) in lines {
                        ui.label(RichText::new(text).color(color));
                    }
                });
            },
        );
    }

    fn contents(&mut self, ui: &mut Ui, facts: &Facts<'_>, actions: &mut Vec<Action>) {
        self.summary(ui, facts, actions);
        self.rows.first(ui, facts, actions);
        egui::CollapsingHeader::new("Compare and inspect").default_open(true).show(ui, |ui| {
            compare::section(ui, facts, actions);
            let mut inspects = facts.inspects;
            let help = "Surface, lights by level with their blending weights, and shadow samples of the pixel under the cursor";
            if ui.checkbox(&mut inspects, "Inspect pixels (I)").on_hover_text(help).changed() {
                actions.push(Action::Inspect);
            }
        });
        egui::CollapsingHeader::new("Times").default_open(false).show(ui, |ui| times::show(ui, facts));
        egui::CollapsingHeader::new("Memory and counts").show(ui, |ui| memory(ui, facts));
        egui::CollapsingHeader::new("Presets and files").default_open(true).show(ui, |ui| {
            self.presets(ui, facts, actions);
        });
        self.rows.show(ui, facts, actions);
        ui.add_space(12.0);
    }

    fn summary(&self, ui: &mut Ui, facts: &Facts<'_>, actions: &mut Vec<Action>) {
        ui.add_space(6.0);
        ui.label(RichText::new(facts.device).small());
        let [width, height] = facts.window_px;
        ui.label(format!(
            "{:.1} frames/s, {} pixels in {width}x{height}",
            facts.history.frames_per_second(),
            facts.picture
        ));
        progress::bar(ui, facts);
        ui.horizontal_wrapped(|ui| {
            if ui
                .button("Screenshot (F6)")
                .on_hover_text(
                    "Saves the picture at full resolution as EXR and PNG, with the settings, in the working directory",
                )
                .clicked()
            {
                actions.push(Action::Render(None));
            }
            let pause = if facts.paused { "Resume (Space)" } else { "Pause (Space)" };
            if ui.button(pause).on_hover_text("Stops time: the animation and the rotation of the sun").clicked() {
                actions.push(Action::Pause);
            }
            if ui.button("Step (.)").on_hover_text("Advances time by 1/30 second").clicked() {
                actions.push(Action::Step);
            }
        });
        time_line(ui, facts, actions);
        sun(ui, facts, actions);
        exposure::show(ui, facts, actions);
        if facts.cameras.len() > 1 {
            ui.horizontal_wrapped(|ui| {
                ui.label("Camera");
                for (index, name) in facts.cameras.iter().enumerate() {
                    if ui.button(*name).on_hover_text(format!("key {}", index + 1)).clicked() {
                        actions.push(Action::Camera(index));
                    }
                }
            });
        }
        ui.separator();
    }

    fn presets(&mut self, ui: &mut Ui, facts: &Facts<'_>, actions: &mut Vec<Action>) {
        ui.horizontal_wrapped(|ui| {
            if ui.button("defaults").on_hover_text("Program defaults").clicked() {
                actions.push(Action::Preset(""));
            }
            for preset in &PRESETS {
                if ui.button(preset.name).on_hover_text(preset.help).clicked() {
                    actions.push(Action::Preset(preset.name));
                }
            }
        });
        ui.horizontal(|ui| {
            ui.label("Settings");
            ui.add(egui::TextEdit::singleline(&mut self.settings_file).desired_width(130.0));
            let path = || PathBuf::from(&self.settings_file);
            if ui.button("Save").on_hover_text("Saves a file for --settings").clicked() {
                actions.push(Action::SaveSettings(path()));
            }
            if ui.button("Load").clicked() {
                actions.push(Action::LoadSettings(path()));
            }
        });
        self.scene_file.show(ui, facts, actions);
        if ui.button("Copy as command line").clicked()
            && let Ok(line) = facts.settings.command_line()
        {
            ui.ctx().copy_text(line);
            self.message = Some((Instant::now(), "copied".to_owned()));
        }
    }
}

fn is_tab(event: &WindowEvent) -> bool {
    matches!(event, WindowEvent::KeyboardInput { event, .. } if event.physical_key == PhysicalKey::Code(KeyCode::Tab))
}

/// Bytes and lights.
fn memory(ui: &mut Ui, facts: &Facts<'_>) {
    let mib = |bytes: u64| format!("{:.1} MiB", bytes as f64 / f64::from(1 << 20));
    let memory = &facts.memory;
    egui::Grid::new("memory").num_columns(2).show(ui, |ui| {
        for (name, bytes) in [
            ("allocated from the driver", facts.reserved_bytes),
            ("persistent", memory.persistent_bytes),
            ("transient, aliased", memory.transient_bytes),
            ("... without aliasing", memory.unaliased_bytes),
        ] {
            ui.label(name);
            ui.label(mib(bytes));
            ui.end_row();
        }
    });
    let Some(feedback) = facts.main.feedback else { return };
    egui::Grid::new("counts").num_columns(2).striped(true).show(ui, |ui| {
        let mut row = |name: String, count: String| {
            ui.label(name);
            ui.label(count);
            ui.end_row();
        };
        for count in &feedback.counts {
            match &count.value {
                Value::Array(levels) => levels
                    .iter()
                    .enumerate()
                    .for_each(|(index, value)| row(format!("{} {}", count.label, index + 1), value.to_string())),
                value => row(count.label.to_owned(), value.to_string()),
            }
        }
        row("rays of light paths".to_owned(), feedback.rays[0].to_string());
        row("shadow rays".to_owned(), feedback.rays[1].to_string());
    });
    if let Some(sentence) = &feedback.complaint {
        ui.colored_label(ERROR, sentence);
    }
}

/// Where in its animation the scene is.
fn time_line(ui: &mut Ui, facts: &Facts<'_>, actions: &mut Vec<Action>) {
    let Some([time_s, duration_s]) = facts.time_s else { return };
    let before = time_s.rem_euclid(duration_s);
    let mut new = before;
    ui.horizontal(|ui| {
        ui.label("Time").on_hover_text("Time of the animation: drag to go to any moment; it repeats at the end");
        let slider =
            egui::Slider::new(&mut new, 0.0..=duration_s).suffix(" s").custom_formatter(|v, _| format!("{v:.2}"));
        if ui.add(slider).changed() {
            actions.push(Action::Time(time_s + new - before));
        }
    });
}

/// Where the sun stands, and its own turn.
fn sun(ui: &mut Ui, facts: &Facts<'_>, actions: &mut Vec<Action>) {
    let Some([azimuth, elevation]) = facts.sun_deg else { return };
    egui::Grid::new("sun").num_columns(2).show(ui, |ui| {
        let mut slider = |name: &str, help: &str, value: f32, range: std::ops::RangeInclusive<f32>| {
            let mut new = value;
            ui.label(name).on_hover_text(help);
            // Only what is shown is rounded: with fewer decimals the slider would round the sun's place when it appears.
            let slider = egui::Slider::new(&mut new, range).suffix("°").custom_formatter(|v, _| format!("{v:.0}"));
            let changed = ui.add(slider).changed();
            ui.end_row();
            changed.then_some(new - value)
        };
        if let Some(turn) = slider("Sun, direction", "Left and right arrow keys", azimuth, 0.0..=360.0) {
            actions.push(Action::Sun([turn, 0.0]));
        }
        if let Some(turn) = slider("Sun, height", "Up and down arrow keys", elevation, -88.0..=88.0) {
            actions.push(Action::Sun([0.0, turn]));
        }
        if let Some(turn) = slider("Sun, turn per second", "Space pauses it", facts.sun_speed, -45.0..=45.0) {
            actions.push(Action::SunSpeed(facts.sun_speed + turn));
        }
    });
}
