//! The line that opens scenes: by name, by a dialog, or one that was opened before.

use std::path::{Path, PathBuf};

use egui::{Context, RichText, Ui};
use egui_file_dialog::{DialogState, FileDialog};

use super::Action;
use super::facts::Facts;

/// What a dialog offers.
const SCENES: &str = "Scenes (glTF, GLB)";
/// And instead.
const ENVIRONMENTS: &str = "Environments (EXR, HDR)";

/// Characters of a path that are shown.
const SHOWN: usize = 44;

/// What is typed, and the dialog.
pub struct SceneFile {
    typed: String,
    dialog: FileDialog,
}

impl SceneFile {
    pub fn new() -> Self {
        let dialog = FileDialog::new()
            .title("Open a scene or an environment image")
            .add_file_filter_extensions(SCENES, vec!["gltf", "glb"])
            .add_file_filter_extensions(ENVIRONMENTS, vec!["exr", "hdr"])
            .default_file_filter(SCENES);
        Self { typed: String::new(), dialog }
    }

    /// The line, and what is shown.
    pub fn show(&mut self, ui: &mut Ui, facts: &Facts<'_>, actions: &mut Vec<Action>) {
        ui.horizontal(|ui| {
            ui.label("Scene");
            let line = egui::TextEdit::singleline(&mut self.typed).desired_width(140.0).hint_text("glTF or GLB file");
            let entered = ui.add(line).lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
            let opened = ui.button("Open").on_hover_text("Enter key; or drop a file on the window").clicked();
            if (opened || entered) && !self.typed.is_empty() {
                actions.push(Action::Open(PathBuf::from(&self.typed)));
            }
            if ui.button("Browse…").on_hover_text("Choose a scene or an environment image").clicked() {
                if let Some(folder) = facts.settings.scene.file.as_deref().and_then(folder_of) {
                    self.dialog.config_mut().initial_directory = folder;
                }
                self.dialog.pick_file();
            }
            recent(ui, facts, actions);
        });
        let shown = facts.settings.scene.file.as_deref();
        let path = shown.map_or("the built-in courtyard".to_owned(), |path| path.display().to_string());
        // The end of a long path tells more than its beginning.
        ui.label(RichText::new(format!("Shown: {}", end_of(&path, SHOWN))).small()).on_hover_text(path);
    }

    /// The dialog is open.
    pub fn asks(&self) -> bool {
        *self.dialog.state() == DialogState::Open
    }

    /// Lays the dialog out while it is open.
    pub fn dialog(&mut self, context: &Context, actions: &mut Vec<Action>) {
        self.dialog.update(context);
        if let Some(path) = self.dialog.take_picked() {
            self.typed = path.display().to_string();
            actions.push(Action::Open(path));
        }
    }
}

fn recent(ui: &mut Ui, facts: &Facts<'_>, actions: &mut Vec<Action>) {
    ui.add_enabled_ui(!facts.recent.is_empty(), |ui| {
        let menu = ui.menu_button("Recent", |ui| {
            for path in facts.recent {
                let whole = path.display().to_string();
                if ui.button(end_of(&whole, SHOWN)).on_hover_text(whole.as_str()).clicked() {
                    actions.push(Action::Open(path.clone()));
                    ui.close();
                }
            }
        });
        menu.response.on_disabled_hover_text("No scene has been opened yet");
    });
}

/// Where a file lies.
fn folder_of(file: &Path) -> Option<PathBuf> {
    file.canonicalize().ok()?.parent().map(Path::to_owned)
}

/// The last `most` characters of a text, the first of them "…" where some are left out.
pub fn end_of(text: &str, most: usize) -> String {
    let count = text.chars().count();
    let kept = || text.chars().skip(count - most + 1);
    if count <= most { text.to_owned() } else { std::iter::once('…').chain(kept()).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_paths_keep_their_ends() {
        assert_eq!(end_of("a.glb", 5), "a.glb");
        let long = format!("/{}/größe/castle.gltf", "x".repeat(60));
        let end = end_of(&long, 30);
        assert!(end.starts_with('…') && end.ends_with("größe/castle.gltf") && end.chars().count() == 30, "{end}");
    }
}
