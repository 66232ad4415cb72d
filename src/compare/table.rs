//! Comparisons as text for reading.

use comfy_table::presets::ASCII_MARKDOWN;
use comfy_table::{Cell, CellAlignment, Table};

use super::limits::ImageLimits;
use super::metrics::ImageMetrics;
use super::timings::{TimePair, TimingComparison};

/// A number with six significant digits, trailing zeros left out; very small and large ones with an exponent.
#[must_use]
pub fn number(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let magnitude = value.abs().log10().floor() as i32;
    if !(-4..6).contains(&magnitude) {
        let text = format!("{value:.5e}");
        let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        return format!("{}e{exponent}", mantissa.trim_end_matches('0').trim_end_matches('.'));
    }
    let decimals = (5 - magnitude) as usize;
    let text = format!("{value:.decimals$}");
    if decimals == 0 { text } else { text.trim_end_matches('0').trim_end_matches('.').to_owned() }
}

/// What changed in one line, the measures with their limits, and lines about what is not as it should be; `all` of the
/// measures, or those that say most and those with a limit. Plain text.
#[must_use]
pub fn image_table(metrics: &ImageMetrics, limits: &ImageLimits, all: bool) -> String {
    let mut table = Table::new();
    table.load_style(ASCII_MARKDOWN);
    table.set_header(["measure", "value", "limit"]);
    let rows = measures(metrics, limits).into_iter().filter(|row| all || row.is_brief || !row.limit.is_empty());
    for MeasureRow { name, value, limit, .. } in rows {
        table.add_row([Cell::new(name), right(value), Cell::new(limit)]);
    }
    let lines = remarks(metrics).into_iter().map(|line| format!("\n{line}"));
    what_changed(metrics) + "\n" + &table.trim_fmt() + &lines.collect::<String>()
}

/// A measure, its value and its limit as text.
struct MeasureRow {
    name: &'static str,
    value: String,
    /// Empty without one.
    limit: String,
    /// Whether the short table has it without a limit too.
    is_brief: bool,
}

fn measures(metrics: &ImageMetrics, limits: &ImageLimits) -> Vec<MeasureRow> {
    let limit = |limit: Option<f64>, clause: Option<String>| verdict(limit.map(|l| l.to_string()), clause.is_some());
    let energy_limit = limits.energy_within_percent.map(|percent| format!("1 within {percent} %"));
    let [red, green, blue] = metrics.energy_ratio_rgb.map(undefined_or);
    let row = |name, value, limit, is_brief| MeasureRow { name, value, limit, is_brief };
    let (plain, none) = (|name, value| row(name, value, String::new(), false), String::new);
    let mut rows = vec![
        row("relMSE", undefined_or(metrics.relmse), limit(limits.max_relmse, limits.relmse(metrics)), true),
        row("relMSE of 8x8 blocks", undefined_or(metrics.smooth_relmse), none(), true),
        plain("highest ratio of 20x20 blocks", undefined_or(metrics.highest_block_ratio)),
        plain("RMSE", number(metrics.rmse)),
        row(
            "energy ratio",
            undefined_or(metrics.energy_ratio),
            verdict(energy_limit, limits.energy(metrics).is_some()),
            true,
        ),
        plain("energy ratio R, G, B", format!("{red}, {green}, {blue}")),
        plain("PSNR", metrics.psnr_db.map_or_else(|| "no difference".to_owned(), |db| format!("{db:.3} dB"))),
        plain("SSIM", undefined_or(metrics.ssim)),
        row("FLIP", number(metrics.flip), limit(limits.max_flip, limits.flip(metrics)), true),
    ];
    if let Some(indirect) = &metrics.indirect {
        rows.push(row("indirect energy ratio", undefined_or(indirect.indirect_ratio), none(), true));
        rows.push(row("indirect relMSE of blocks", undefined_or(indirect.indirect_smooth_relmse), none(), true));
        rows.push(plain("indirect pixels", indirect.indirect_pixels.to_string()));
    }
    rows.extend(metrics.exposure.map(|exposure| plain("exposure", number(exposure))));
    rows
}

/// A limit and whether it holds; empty without a limit.
pub(super) fn verdict(limit: Option<String>, is_exceeded: bool) -> String {
    limit.map_or_else(String::new, |limit| format!("{limit}: {}", if is_exceeded { "EXCEEDED" } else { "holds" }))
}

/// How the test differs from the reference, in one line.
fn what_changed(metrics: &ImageMetrics) -> String {
    if metrics.rmse == 0.0 {
        return "no pixel differs".to_owned();
    }
    let energy =
        metrics.energy_ratio.map_or_else(String::new, |ratio| format!(", {}", percent(ratio, "brighter", "darker")));
    format!("the pictures differ: FLIP {:.3}{energy}", metrics.flip)
}

/// A ratio to 1 in words.
fn percent(ratio: f64, above: &str, below: &str) -> String {
    let percent = 100.0 * (ratio - 1.0);
    match percent {
        p if p.abs() < 0.05 => format!("neither {above} nor {below}"),
        p => format!("{:.1} % {}", p.abs(), if p > 0.0 { above } else { below }),
    }
}

/// What a reader must know before believing the measures.
#[must_use]
pub fn remarks(metrics: &ImageMetrics) -> Vec<String> {
    let mut lines = Vec::new();
    for (name, pixels) in [("reference", metrics.nonfinite_reference_pixels), ("test", metrics.nonfinite_test_pixels)] {
        if pixels > 0 {
            lines.push(format!("pixels that are NaN or infinite in the {name}, in no measure: {pixels}"));
        }
    }
    if metrics.energy_ratio.is_none() {
        lines.push("the reference is black: relative measures are undefined".to_owned());
    }
    lines
}

/// What changed in one line, the passes and the frame of both files, and notes on what else differs; `all` of the passes,
/// or those that take a notable part of either frame, the others as one row. Plain text.
#[must_use]
pub fn timing_table(comparison: &TimingComparison, max_percent: Option<f64>, all: bool) -> String {
    let mut table = Table::new();
    table.load_style(ASCII_MARKDOWN);
    table.set_header(["pass", "reference ms", "test ms", "test / reference", "limit"]);
    let (passes, others) = if all { (comparison.passes.clone(), None) } else { comparison.notable_passes() };
    let frames = [&comparison.frame_gpu, &comparison.frame_cpu];
    for pair in passes.iter().chain(&others).chain(frames) {
        let limit = max_percent.filter(|_| comparison.is_held_to_a_limit(pair));
        let is_exceeded = max_percent.is_some_and(|most| pair.is_slower(most));
        let limit = verdict(limit.map(|most| format!("{most} % slower")), is_exceeded);
        table.add_row([
            Cell::new(&pair.name),
            ms(pair.reference_ms),
            ms(pair.test_ms),
            right(ratio(pair)),
            Cell::new(limit),
        ]);
    }
    let frame = match comparison.frame_gpu.ratio {
        Some(ratio) => format!("the frame is {}\n", percent(ratio, "slower", "faster")),
        None => String::new(),
    };
    let notes = comparison.notes.iter().map(|note| format!("\n{note}"));
    frame + &table.trim_fmt() + &notes.collect::<String>()
}

pub(super) fn right(text: String) -> Cell {
    Cell::new(text).set_alignment(CellAlignment::Right)
}

fn ms(value: Option<f64>) -> Cell {
    right(value.map_or_else(|| "-".to_owned(), |ms| format!("{ms:.3}")))
}

fn ratio(pair: &TimePair) -> String {
    match (pair.reference_ms, pair.test_ms, pair.ratio) {
        (_, _, Some(ratio)) => format!("{ratio:.3}"),
        (None, _, _) => "only in test".to_owned(),
        (_, None, _) => "only in reference".to_owned(),
        _ => "undefined".to_owned(),
    }
}

pub(super) fn undefined_or(value: Option<f64>) -> String {
    value.map_or_else(|| "undefined".to_owned(), number)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::testing::image;
    use crate::compare::{Tone, metrics};

    #[test]
    fn numbers_are_short() {
        let cases = [
            (0.0, "0"),
            (1.0, "1"),
            (1.02, "1.02"),
            (0.123_456_78, "0.123457"),
            (1234.5, "1234.5"),
            (100_000.0, "100000"),
            (1e6, "1e6"),
            (1.25e-7, "1.25e-7"),
            (-0.5, "-0.5"),
        ];
        for (value, text) in cases {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn the_table_has_measures_limits_and_remarks() {
        let (reference, mut test) = (image(16, 16, |_, _, c| (c + 1) as f32), image(16, 16, |_, _, _| 2.0));
        test.rgb[0] = f32::NAN;
        let found = metrics(&reference, &test, Tone::Reinhard { exposure: 0.5 }, Some(&reference)).unwrap();
        let text =
            image_table(&found, &ImageLimits { energy_within_percent: Some(2.0), ..ImageLimits::default() }, true);
        for part in
            ["| relMSE ", "2, 1, 0.666667", "1 within 2 %: holds", "| indirect pixels", "| exposure", "in the test"]
        {
            assert!(text.contains(part), "no `{part}` in\n{text}");
        }
        let black = image(4, 4, |_, _, _| 0.0);
        let text = image_table(&metrics(&black, &black, Tone::Srgb, None).unwrap(), &ImageLimits::default(), true);
        assert!(
            text.contains("undefined") && text.ends_with("the reference is black: relative measures are undefined")
        );
        assert!(!text.contains("exposure") && text.contains("no difference"));
    }

    #[test]
    fn the_short_table_says_what_changed() {
        let (reference, test) = (image(16, 16, |_, _, _| 1.0), image(16, 16, |_, _, _| 1.25));
        let tone = Tone::Reinhard { exposure: 0.5 };
        let found = metrics(&reference, &test, tone, None).unwrap();
        let limits = ImageLimits { max_relmse: Some(0.5), max_flip: Some(0.0), ..ImageLimits::default() };
        let text = image_table(&found, &limits, false);
        assert!(text.starts_with("the pictures differ: FLIP 0.") && text.contains(", 25.0 % brighter\n"), "{text}");
        assert!(text.contains("0.5: holds") && text.contains("0: EXCEEDED"), "{text}");
        assert!(!text.contains("SSIM") && image_table(&found, &limits, true).contains("SSIM"), "{text}");
        let same = metrics(&reference, &reference, tone, None).unwrap();
        assert!(image_table(&same, &limits, false).starts_with("no pixel differs\n"));
    }

    #[test]
    fn timings_side_by_side() {
        let pair = |name: &str, (reference_ms, test_ms, ratio), share| TimePair {
            name: name.to_owned(),
            reference_ms,
            test_ms,
            ratio,
            share_percent: Some(share),
        };
        let comparison = TimingComparison {
            passes: vec![
                pair("gbuffer", (Some(2.0), Some(3.0), Some(1.5)), 99.0),
                pair("bounds", (Some(0.01), Some(0.02), Some(2.0)), 0.5),
                pair("extra", (None, Some(0.1), None), 2.5),
            ],
            frame_gpu: pair("frame (GPU clock)", (Some(2.0), Some(4.0), Some(2.0)), 100.0),
            frame_cpu: pair("frame (CPU clock)", (Some(3.0), Some(3.0), Some(1.0)), 100.0),
            notes: vec!["device not the same: name `a` against `b`".to_owned()],
        };
        let expected = "\
the frame is 100.0 % slower
| pass              | reference ms | test ms | test / reference | limit |
|-------------------|--------------|---------|------------------|-------|
| gbuffer           |        2.000 |   3.000 |            1.500 |       |
| bounds            |        0.010 |   0.020 |            2.000 |       |
| extra             |            - |   0.100 |     only in test |       |
| frame (GPU clock) |        2.000 |   4.000 |            2.000 |       |
| frame (CPU clock) |        3.000 |   3.000 |            1.000 |       |
device not the same: name `a` against `b`";
        assert_eq!(timing_table(&comparison, None, true), expected);
        let expected = "\
the frame is 100.0 % slower
| pass              | reference ms | test ms | test / reference | limit                 |
|-------------------|--------------|---------|------------------|-----------------------|
| gbuffer           |        2.000 |   3.000 |            1.500 | 60 % slower: holds    |
| 2 passes below 5 % |        0.010 |   0.120 |           12.000 |                       |
| frame (GPU clock) |        2.000 |   4.000 |            2.000 | 60 % slower: EXCEEDED |
| frame (CPU clock) |        3.000 |   3.000 |            1.000 |                       |
device not the same: name `a` against `b`";
        let text = timing_table(&comparison, Some(60.0), false);
        let words = |text: &str| text.split([' ', '-']).filter(|word| !word.is_empty()).collect::<Vec<_>>().join(" ");
        assert_eq!(words(&text), words(expected));
    }
}
