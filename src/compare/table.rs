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

/// The measures with their limits, and lines about what is not as it should be. Plain text.
#[must_use]
pub fn image_table(metrics: &ImageMetrics, limits: &ImageLimits) -> String {
    let mut table = Table::new();
    table.load_style(ASCII_MARKDOWN);
    table.set_header(["measure", "value", "limit"]);
    let energy_limit = limits.energy_within_percent.map(|percent| format!("1 within {percent} %"));
    let limit = |limit: Option<f64>| limit.map(|limit| limit.to_string());
    let [red, green, blue] = metrics.energy_ratio_rgb.map(undefined_or);
    let mut rows = vec![
        ("relMSE", undefined_or(metrics.relmse), limit(limits.max_relmse)),
        ("relMSE of 8x8 blocks", undefined_or(metrics.smooth_relmse), None),
        ("highest ratio of 20x20 blocks", undefined_or(metrics.highest_block_ratio), None),
        ("RMSE", number(metrics.rmse), None),
        ("energy ratio", undefined_or(metrics.energy_ratio), energy_limit),
        ("energy ratio R, G, B", format!("{red}, {green}, {blue}"), None),
        ("PSNR", metrics.psnr_db.map_or_else(|| "no difference".to_owned(), |db| format!("{db:.3} dB")), None),
        ("SSIM", undefined_or(metrics.ssim), None),
        ("FLIP", number(metrics.flip), limit(limits.max_flip)),
    ];
    if let Some(indirect) = &metrics.indirect {
        rows.push(("indirect energy ratio", undefined_or(indirect.indirect_ratio), None));
        rows.push(("indirect relMSE of blocks", undefined_or(indirect.indirect_smooth_relmse), None));
        rows.push(("indirect pixels", indirect.indirect_pixels.to_string(), None));
    }
    rows.extend(metrics.exposure.map(|exposure| ("exposure", number(exposure), None)));
    for (name, value, limit) in rows {
        table.add_row([Cell::new(name), right(value), Cell::new(limit.unwrap_or_default())]);
    }
    let lines = remarks(metrics).into_iter().map(|line| format!("\n{line}"));
    table.trim_fmt() + &lines.collect::<String>()
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

/// The passes and the frame of both files, and notes on what else differs. Plain text.
#[must_use]
pub fn timing_table(comparison: &TimingComparison) -> String {
    let mut table = Table::new();
    table.load_style(ASCII_MARKDOWN);
    table.set_header(["pass", "reference ms", "test ms", "test / reference"]);
    for pair in comparison.passes.iter().chain([&comparison.frame_gpu, &comparison.frame_cpu]) {
        table.add_row([Cell::new(&pair.name), ms(pair.reference_ms), ms(pair.test_ms), right(ratio(pair))]);
    }
    let notes = comparison.notes.iter().map(|note| format!("\n{note}"));
    table.trim_fmt() + &notes.collect::<String>()
}

fn right(text: String) -> Cell {
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

fn undefined_or(value: Option<f64>) -> String {
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
        let text = image_table(&found, &ImageLimits { energy_within_percent: Some(2.0), ..ImageLimits::default() });
        for part in ["| relMSE ", "2, 1, 0.666667", "1 within 2 %", "| indirect pixels", "| exposure", "in the test"] {
            assert!(text.contains(part), "no `{part}` in\n{text}");
        }
        let black = image(4, 4, |_, _, _| 0.0);
        let text = image_table(&metrics(&black, &black, Tone::Srgb, None).unwrap(), &ImageLimits::default());
        assert!(
            text.contains("undefined") && text.ends_with("the reference is black: relative measures are undefined")
        );
        assert!(!text.contains("exposure") && text.contains("no difference"));
    }

    #[test]
    fn timings_side_by_side() {
        let pair = |name: &str, reference_ms, test_ms, ratio| TimePair {
            name: name.to_owned(),
            reference_ms,
            test_ms,
            ratio,
            share_percent: None,
        };
        let comparison = TimingComparison {
            passes: vec![pair("gbuffer", Some(2.0), Some(3.0), Some(1.5)), pair("extra", None, Some(1.0), None)],
            frame_gpu: pair("frame (GPU clock)", Some(2.0), Some(4.0), Some(2.0)),
            frame_cpu: pair("frame (CPU clock)", Some(3.0), Some(3.0), Some(1.0)),
            notes: vec!["device not the same: name `a` against `b`".to_owned()],
        };
        let expected = "\
| pass              | reference ms | test ms | test / reference |
|-------------------|--------------|---------|------------------|
| gbuffer           |        2.000 |   3.000 |            1.500 |
| extra             |            - |   1.000 |     only in test |
| frame (GPU clock) |        2.000 |   4.000 |            2.000 |
| frame (CPU clock) |        3.000 |   3.000 |            1.000 |
device not the same: name `a` against `b`";
        assert_eq!(timing_table(&comparison), expected);
    }
}
