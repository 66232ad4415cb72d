//! What is found of a sequence as text for reading.

use comfy_table::presets::ASCII_MARKDOWN;
use comfy_table::{Cell, Table};

use super::{Answer, SequenceLimits, SequenceMetrics};
use crate::compare::table::{number, right, undefined_or, verdict};

/// What was compared in one line, the measures with their limits, each frame when `all` is asked for, and what a reader must
/// know before believing it. Plain text.
#[must_use]
pub fn sequence_table(metrics: &SequenceMetrics, limits: &SequenceLimits, all: bool) -> String {
    let mut parts = vec![what_was_compared(metrics), measures(metrics, limits)];
    if all {
        parts.push(String::new());
        parts.push(frames(metrics));
    }
    parts.extend(remarks(metrics));
    parts.join("\n")
}

fn what_was_compared(metrics: &SequenceMetrics) -> String {
    let frames = match &metrics.frames[..] {
        [frame] => format!("1 frame, {}", frame.frame),
        [first, .., last] => format!("{} frames, {} to {}", metrics.frames.len(), first.frame, last.frame),
        [] => "no frames".to_owned(),
    };
    let pairs = if metrics.pairs == 1 { "1 follows".to_owned() } else { format!("{} follow", metrics.pairs) };
    format!("{frames}, of which {pairs} another; a still camera is assumed")
}

fn measures(metrics: &SequenceMetrics, limits: &SequenceLimits) -> String {
    let limit = |limit: Option<f64>, clause: Option<String>| verdict(limit.map(|l| l.to_string()), clause.is_some());
    let rows = [
        ("flicker", undefined_or(metrics.flicker), limit(limits.max_flicker, limits.flicker(metrics))),
        (
            "flicker of 16x16 blocks",
            undefined_or(metrics.block_flicker),
            limit(limits.max_block_flicker, limits.block_flicker(metrics)),
        ),
        (
            "lag in frames",
            metrics.lag_frames.map_or_else(|| "the truth stands still".to_owned(), number),
            limit(limits.max_lag_frames, limits.lag(metrics)),
        ),
        (
            "answer in frames",
            metrics.answer.as_ref().map_or_else(|| "no step".to_owned(), answer),
            limit(limits.max_answer_frames, limits.answer(metrics)),
        ),
        ("relMSE, mean", undefined_or(metrics.relmse), String::new()),
        ("FLIP, mean", number(metrics.flip), String::new()),
        ("energy ratio", undefined_or(metrics.energy_ratio), String::new()),
    ];
    let mut table = Table::new();
    table.load_style(ASCII_MARKDOWN);
    table.set_header(["measure", "value", "limit"]);
    for (name, value, limit) in rows {
        table.add_row([Cell::new(name), right(value), Cell::new(limit)]);
    }
    table.trim_fmt()
}

fn answer(answer: &Answer) -> String {
    match answer.frames {
        Some(frames) => frames.to_string(),
        None => format!("more than {}", answer.left.len() - 1),
    }
}

fn frames(metrics: &SequenceMetrics) -> String {
    let mut table = Table::new();
    table.load_style(ASCII_MARKDOWN);
    table.set_header(["frame", "relMSE", "FLIP", "energy ratio", "flicker", "of blocks"]);
    for frame in &metrics.frames {
        let [flicker, of_blocks] =
            [frame.flicker, frame.block_flicker].map(|value| value.map_or_else(String::new, number));
        table.add_row([
            Cell::new(frame.frame),
            right(undefined_or(frame.relmse)),
            right(number(frame.flip)),
            right(undefined_or(frame.energy_ratio)),
            right(flicker),
            right(of_blocks),
        ]);
    }
    table.trim_fmt()
}

fn remarks(metrics: &SequenceMetrics) -> Vec<String> {
    let counts = [("truth", metrics.nonfinite_truth_pixels), ("test", metrics.nonfinite_test_pixels)];
    let spoiled = counts.into_iter().filter(|(_, pixels)| *pixels > 0);
    let mut lines: Vec<String> = spoiled
        .map(|(name, pixels)| format!("pixels that are NaN or infinite in the {name}, in no measure: {pixels}"))
        .collect();
    if metrics.mean_luma == 0.0 {
        lines.push("the truth is black: relative measures are undefined".to_owned());
    }
    lines
}
