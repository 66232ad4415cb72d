//! A row for every setting, made of the command line's options: name, values and help are written only there.

use std::collections::BTreeMap;

use egui::{Color32, RichText, Ui};

use super::Action;
use super::facts::Facts;
use super::scene_file::end_of;
use crate::cli::{OptionHelp, option_help};
use crate::settings::{Scope, Settings, plain};
use crate::techniques::why_unused;

/// The groups of the help whose rows can be shown.
const GROUPS: [&str; 4] = ["Picture", "Method", "Shadows", "Window"];
/// What matters most, in this order; their rows come before the groups.
const FIRST: [&str; 7] = ["technique", "view", "vpls", "alpha", "shadow-samples", "environment", "exposure"];
/// The window's own, so that there is no row for it.
const SIZE: &str = "size";
const CHANGED: Color32 = Color32::from_rgb(255, 205, 100);
/// Characters that a line for typing has room for.
const TYPED: usize = 12;
/// What a setting without a value is called.
const NO_VALUE: &str = "auto";

/// The rows and the texts that are being typed into them.
pub struct Rows {
    options: Vec<OptionHelp>,
    defaults: toml::Table,
    typed: BTreeMap<String, String>,
}

impl Rows {
    /// A row for each option.
    pub fn new() -> Self {
        let fits = |o: &OptionHelp| o.key != SIZE && Settings::scope_of(&o.key).is_some_and(Scope::is_in_panel);
        let options = option_help().into_iter().filter(fits).collect();
        Self { options, defaults: Settings::default().table().unwrap_or_default(), typed: BTreeMap::new() }
    }

    /// Shows the rows of what matters most.
    pub fn first(&mut self, ui: &mut Ui, facts: &Facts<'_>, actions: &mut Vec<Action>) {
        let Ok(table) = facts.settings.table() else { return };
        egui::Grid::new("first").num_columns(3).striped(true).show(ui, |ui| {
            for option in FIRST.iter().filter_map(|key| self.options.iter().find(|option| option.key == *key)) {
                let values = Values::of(option, &table, &self.defaults, facts);
                row(ui, option, &values, &mut self.typed, actions);
                ui.end_row();
            }
        });
    }

    /// Shows the other rows in their groups.
    pub fn show(&mut self, ui: &mut Ui, facts: &Facts<'_>, actions: &mut Vec<Action>) {
        let Ok(table) = facts.settings.table() else { return };
        for group in GROUPS {
            egui::CollapsingHeader::new(group).default_open(false).show(ui, |ui| {
                egui::Grid::new(group).num_columns(3).striped(true).show(ui, |ui| {
                    let others = self.options.iter().filter(|option| !FIRST.contains(&option.key.as_str()));
                    for option in others.filter(|option| option.group == group) {
                        let values = Values::of(option, &table, &self.defaults, facts);
                        row(ui, option, &values, &mut self.typed, actions);
                        ui.end_row();
                    }
                });
            });
        }
    }
}

/// What a row is about.
struct Values<'a> {
    /// All settings in use.
    table: &'a toml::Table,
    /// Of all.
    defaults: &'a toml::Table,
    /// Why the row's setting has no effect.
    unused: Option<String>,
}

impl<'a> Values<'a> {
    fn of(option: &OptionHelp, table: &'a toml::Table, defaults: &'a toml::Table, facts: &Facts<'_>) -> Self {
        Self { table, defaults, unused: why_unused(facts.settings, &option.key) }
    }
}

fn row(
    ui: &mut Ui,
    option: &OptionHelp,
    values: &Values<'_>,
    typed: &mut BTreeMap<String, String>,
    actions: &mut Vec<Action>,
) {
    let key = option.key.as_str();
    let (table, defaults, unused) = (values.table, values.defaults, values.unused.as_ref());
    let value = table.get(key).map_or_else(|| NO_VALUE.to_owned(), plain);
    let changed = table.get(key) != defaults.get(key);
    let name = RichText::new(key);
    let name = match unused {
        Some(_) => name.weak(),
        None if changed => name.color(CHANGED).strong(),
        None => name,
    };
    let help = unused.map_or_else(|| option.help.clone(), |why| format!("No effect {why}. {}", option.help));
    ui.label(name).on_hover_text(&help);
    let controls = ui.add_enabled_ui(unused.is_none(), |ui| match table.get(key) {
        _ if !option.values.is_empty() => choice(ui, option, &value, defaults.get(key).is_none()),
        Some(toml::Value::Integer(number)) => integer(ui, *number),
        Some(toml::Value::Float(number)) => float(ui, *number),
        _ => text(ui, key, &value, typed),
    });
    controls.response.on_hover_text(&help).on_disabled_hover_text(&help);
    match controls.inner {
        Some(new) if new == NO_VALUE && defaults.get(key).is_none() => actions.push(Action::Reset(key.to_owned())),
        Some(new) => actions.push(Action::Set(key.to_owned(), new)),
        None => {}
    }
    if changed && ui.small_button("⟲").on_hover_text("Back to the default").clicked() {
        typed.remove(key);
        actions.push(Action::Reset(key.to_owned()));
    }
}

fn choice(ui: &mut Ui, option: &OptionHelp, value: &str, may_be_none: bool) -> Option<String> {
    let mut new = None;
    egui::ComboBox::from_id_salt(&option.key).width(150.0).selected_text(value).show_ui(ui, |ui| {
        let none = may_be_none.then(|| (NO_VALUE.to_owned(), String::new()));
        for (name, help) in none.iter().chain(&option.values) {
            let label = ui.selectable_label(name == value, name);
            let label = if help.is_empty() { label } else { label.on_hover_text(help) };
            if label.clicked() && name != value {
                new = Some(name.clone());
            }
        }
    });
    new
}

fn integer(ui: &mut Ui, number: i64) -> Option<String> {
    let mut new = number;
    let speed = (number as f64 * 0.01).max(0.05);
    let response =
        ui.add(egui::DragValue::new(&mut new).speed(speed).range(0..=i64::from(u32::MAX)).update_while_editing(false));
    (response.changed() && new != number).then(|| new.to_string())
}

fn float(ui: &mut Ui, number: f64) -> Option<String> {
    // The settings hold 32-bit numbers; the digits beyond are not theirs.
    let shown: f64 = (number as f32).to_string().parse().unwrap_or(number);
    let mut new = shown;
    let speed = (shown * 0.01).max(0.000_1);
    let response = ui.add(egui::DragValue::new(&mut new).speed(speed).max_decimals(4).update_while_editing(false));
    (response.changed() && new.to_bits() != shown.to_bits()).then(|| (new as f32).to_string())
}

/// A word or a number, taken over with the Enter key.
fn text(ui: &mut Ui, key: &str, value: &str, typed: &mut BTreeMap<String, String>) -> Option<String> {
    // Of a long path the end tells more, until it is edited.
    let mut line = typed.get(key).cloned().unwrap_or_else(|| end_of(value, TYPED));
    let response = ui.add(egui::TextEdit::singleline(&mut line).desired_width(90.0));
    if response.lost_focus() {
        return typed.remove(key).map(|_| line).filter(|line| line != value);
    }
    if response.has_focus() {
        let line = if typed.contains_key(key) { line } else { value.to_owned() };
        typed.insert(key.to_owned(), line);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_is_of_a_group_that_is_shown() {
        let rows = Rows::new();
        assert!(FIRST.iter().all(|first| rows.options.iter().any(|option| option.key == *first)));
        assert!(rows.options.iter().all(|option| GROUPS.contains(&option.group.as_str())));
        for key in Settings::keys() {
            let has_row = rows.options.iter().any(|option| option.key == key);
            assert_eq!(has_row, key != SIZE && Settings::scope_of(&key).unwrap().is_in_panel(), "{key}");
        }
    }
}
