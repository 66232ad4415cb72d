//! The report as Markdown.

use std::fmt::Write as _;

use super::{ErrorReport, INTERRUPTED, Stage, measure, time};

const COLUMNS: [&str; 8] =
    ["stage", "what differs", "energy ratio", "relMSE", "relMSE of 8x8 blocks", "FLIP", "reference", "test"];

/// Facts, a row for each stage, and the notes.
pub fn page(report: &ErrorReport) -> String {
    let mut text = format!("# Error report: {}\n\n", escaped(&report.scene.name));
    for (name, value) in report.facts() {
        let _ = writeln!(text, "- {name}: {}", escaped(&value));
    }
    if report.interrupted {
        let _ = write!(text, "\n**{INTERRUPTED}**\n");
    }
    let _ = write!(text, "\n{}{}", row(&COLUMNS.map(str::to_owned)), row(&COLUMNS.map(|_| "---".to_owned())));
    text.extend(report.stages.iter().map(|stage| row(&cells(stage))));
    text.extend(report.stages.iter().map(notes));
    text
}

fn cells(stage: &Stage) -> [String; COLUMNS.len()] {
    let metrics = &stage.metrics;
    let side = |side: &super::Side| format!("{}, {}", escaped(&side.label), time(side.ms));
    [
        escaped(&stage.name),
        escaped(&stage.cause),
        measure(metrics.energy_ratio),
        measure(metrics.relmse),
        measure(metrics.smooth_relmse),
        measure(Some(metrics.flip)),
        side(&stage.reference),
        side(&stage.test),
    ]
}

fn row(cells: &[String; COLUMNS.len()]) -> String {
    format!("| {} |\n", cells.join(" | "))
}

fn notes(stage: &Stage) -> String {
    let lines: String = stage.remarks().iter().map(|note| format!("- {}\n", escaped(note))).collect();
    if lines.is_empty() { lines } else { format!("\n{}:\n\n{lines}", escaped(&stage.name)) }
}

/// Text that stays in its cell and is taken literally.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '<' => escaped.push_str("&lt;"),
            '&' => escaped.push_str("&amp;"),
            '|' | '\\' | '`' | '*' | '_' | '[' | ']' => escaped.extend(['\\', character]),
            other if other.is_control() => escaped.push(' '),
            other => escaped.push(other),
        }
    }
    escaped
}
