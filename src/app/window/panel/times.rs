//! Milliseconds of the passes: a stacked graph of the last frames, and a table.

use colorous::{SET3, TABLEAU10};
use egui::{Color32, Rect, Sense, Ui, Vec2, pos2};

use super::facts::Facts;
use super::history::KEPT;
use crate::gpu::FrameResult;

/// Height of the graph in points.
const HEIGHT: f32 = 90.0;

/// Passes of one name together: those before the `/`.
struct Group {
    name: String,
    passes: Vec<usize>,
    color: Color32,
}

/// Shows graph and table.
pub fn show(ui: &mut Ui, facts: &Facts<'_>) {
    let groups = groups(&facts.pass_names);
    graph(ui, facts, &groups);
    let mean = facts.history.mean_ms();
    let sum: f64 = mean.iter().sum();
    let wall = facts.history.frames().last().map_or(0.0, |frame| frame.cpu_ms);
    ui.label(format!("GPU {sum:.1} ms per frame, mean of 10; submission to completion {wall:.1} ms"));
    // In the order of the frame, so that nothing jumps.
    let rows: Vec<(&Group, f64)> = groups.iter().map(|g| (g, ms(&g.passes, &mean))).collect();
    egui::Grid::new("times").num_columns(4).striped(true).min_col_width(20.0).show(ui, |ui| {
        for (group, ms) in rows {
            ui.colored_label(group.color, "■");
            let steps: Vec<String> = group
                .passes
                .iter()
                .map(|i| format!("{}  {:.3} ms", facts.pass_names[*i], mean.get(*i).copied().unwrap_or(0.0)))
                .collect();
            ui.label(&group.name).on_hover_text(steps.join("\n"));
            ui.label(format!("{ms:.2} ms"));
            ui.label(format!("{:.0} %", 100.0 * ms / sum.max(1e-9)));
            ui.end_row();
        }
    });
}

fn groups(names: &[String]) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for (index, name) in names.iter().enumerate() {
        let name = name.split('/').next().unwrap_or(name);
        match groups.iter_mut().find(|group| group.name == name) {
            Some(group) => group.passes.push(index),
            None => {
                let color = color(groups.len());
                groups.push(Group { name: name.to_owned(), passes: vec![index], color });
            }
        }
    }
    groups
}

/// Colours that are told apart, as many as there are passes in most frames.
fn color(index: usize) -> Color32 {
    let palette: Vec<_> = TABLEAU10.iter().chain(SET3.iter()).collect();
    let colorous::Color { r, g, b } = palette[index % palette.len()];
    Color32::from_rgb(*r, *g, *b)
}

fn ms(passes: &[usize], times: &[f64]) -> f64 {
    passes.iter().filter_map(|pass| times.get(*pass)).sum()
}

/// One column for each frame, the newest at the right.
fn graph(ui: &mut Ui, facts: &Facts<'_>, groups: &[Group]) {
    let (area, _) = ui.allocate_exact_size(Vec2::new(ui.available_width(), HEIGHT), Sense::hover());
    let painter = ui.painter_at(area);
    painter.rect_filled(area, 2.0, Color32::from_gray(20));
    let frames = facts.history.frames();
    let most = facts.history.frames().map(FrameResult::gpu_ms).fold(1e-3, f64::max);
    let column = area.width() / KEPT as f32;
    let first = KEPT - frames.len();
    for (index, frame) in frames.enumerate() {
        let left = area.left() + (first + index) as f32 * column;
        let mut bottom = area.bottom();
        for group in groups {
            let height = (ms(&group.passes, &frame.pass_ms) / most) as f32 * (HEIGHT - 14.0);
            let bar = Rect::from_min_max(pos2(left, bottom - height), pos2(left + column, bottom));
            painter.rect_filled(bar, 0.0, group.color);
            bottom -= height;
        }
    }
    let text = format!("maximum {most:.1} ms, last {KEPT} frames");
    let font = egui::TextStyle::Small.resolve(ui.style());
    painter.text(area.left_top() + Vec2::new(4.0, 1.0), egui::Align2::LEFT_TOP, text, font, Color32::LIGHT_GRAY);
}
