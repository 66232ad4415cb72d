//! The table of passes that a run prints on stdout.

use comfy_table::presets::ASCII_MARKDOWN;
use comfy_table::{Cell, CellAlignment, Row, Table};

use super::answer::three_digits;
use super::summary::Summary;
use super::timings::{RayRates, RunTimes};

/// Passes and frames with their median and 95th percentile, each pass's share of the frame, the rates of rays that were
/// traced, and the exposure of the picture where it has one. Plain text.
#[must_use]
pub fn table(times: &RunTimes, rays: &RayRates, exposure: Option<f32>) -> String {
    let mut table = Table::new();
    table.load_style(ASCII_MARKDOWN);
    let frames = times.frame_count() as f64;
    let is_one = times.frame_count() == 1;
    table.set_header(if is_one { vec!["pass", "ms", "share"] } else { vec!["pass", "median ms", "p95 ms", "share"] });
    let row = |name: &str, ms: &Summary, share: String| row(name, ms, is_one, share);
    for pass in &times.passes {
        let mean_per_frame = pass.ms.mean * pass.frames as f64 / frames;
        table.add_row(row(&pass.name, &pass.ms, share(mean_per_frame, times.frame_gpu_ms.mean)));
    }
    table.add_row(row("sum of passes", &times.pass_sum_ms, share(times.pass_sum_ms.mean, times.frame_gpu_ms.mean)));
    table.add_row(row("frame (GPU clock)", &times.frame_gpu_ms, String::new()));
    table.add_row(row("frame (CPU clock)", &times.frame_cpu_ms, String::new()));
    let rates = [
        ("shadow rays", rays.shadow_rays_per_s),
        ("VPL rays", rays.vpl_rays_per_s),
        ("environment rays", rays.environment_rays_per_s),
    ]
    .map(|(name, rate)| rate.map_or_else(String::new, |rate| format!("\n{name}: {:.3} million/s", rate * 1e-6)));
    let exposure = exposure.map_or_else(String::new, |factor| format!("\nexposure: {factor:.4}"));
    table.trim_fmt() + &rates.concat() + &exposure
}

/// One frame is a single sample: it has three digits and no percentile.
fn row(name: &str, ms: &Summary, is_one: bool, share: String) -> Row {
    let right = |text: String| Cell::new(text).set_alignment(CellAlignment::Right);
    let times = if is_one {
        vec![three_digits(ms.median)]
    } else {
        vec![format!("{:.3}", ms.median), format!("{:.3}", ms.p95)]
    };
    Row::from([Cell::new(name)].into_iter().chain(times.into_iter().chain([share]).map(right)).collect::<Vec<_>>())
}

fn share(part: f64, whole: f64) -> String {
    if whole > 0.0 { format!("{:.1} %", 100.0 * part / whole) } else { String::new() }
}

#[cfg(test)]
mod tests {
    use super::super::timings::tests::two_frames;
    use super::*;

    #[test]
    fn the_table_is_plain_and_complete() {
        let rates = RayRates { shadow_rays_per_s: Some(1_234_567.0), ..RayRates::default() };
        let text = table(&RunTimes::of(&two_frames()).unwrap(), &rates, Some(2.5));
        let expected = "\
| pass              | median ms | p95 ms | share   |
|-------------------|-----------|--------|---------|
| gbuffer           |     1.500 |  2.000 |  30.0 % |
| light-volumes     |     3.500 |  4.000 |  70.0 % |
| sum of passes     |     5.000 |  6.000 | 100.0 % |
| frame (GPU clock) |     5.000 |  6.000 |         |
| frame (CPU clock) |     6.000 |  7.000 |         |
shadow rays: 1.235 million/s
exposure: 2.5000";
        assert_eq!(text, expected);
    }

    #[test]
    fn one_frame_has_no_percentile_and_few_digits() {
        let pass_ms = vec![("a".to_owned(), 3186.394), ("b".to_owned(), 0.012_34)];
        let frame = super::super::FrameTimes { pass_ms, gpu_ms: 3186.406, cpu_ms: 3190.2 };
        let text = table(&RunTimes::of(&[frame]).unwrap(), &RayRates::default(), None);
        assert!(text.starts_with("| pass              | ms ") && !text.contains("p95"), "{text}");
        assert!(text.contains("|   3186 | 100.0 % |") && text.contains("| 0.0123 |   0.0 % |"), "{text}");
    }

    #[test]
    fn a_clock_that_stands_still_has_no_shares() {
        let frame = super::super::FrameTimes { pass_ms: vec![("a".to_owned(), 0.0)], gpu_ms: 0.0, cpu_ms: 0.0 };
        let text = table(&RunTimes::of(&[frame]).unwrap(), &RayRates::default(), None);
        assert!(!text.contains("NaN") && !text.contains("exposure"));
    }
}
