//! The report of synthetic pictures.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::*;
use crate::compare::false_color::SCALE_BAR_PX;
use crate::compare::testing::image;
use crate::settings::Size;

const WIDTH: usize = 160;
const HEIGHT: usize = 90;

/// A floor with a bright patch and stripes.
fn radiance(x: usize, y: usize, c: usize) -> f32 {
    let patch = if x.abs_diff(50) < 20 && y.abs_diff(40) < 15 { 4.0 } else { 0.0 };
    let stripe = if (x / 10 + y / 10).is_multiple_of(2) { 0.5 } else { 0.1 };
    patch + stripe * [1.0, 0.8, 0.6][c] * (y + 10) as f32 / 50.0
}

fn side(label: &str, ms: Option<f64>) -> Side {
    Side { label: label.to_owned(), ms, note: None }
}

fn stage(name: &str, reference: Image, test: Image) -> Stage {
    let (reference, test) = ((side("path traced", Some(61_000.0)), reference), (side("VPLs", Some(4.2)), test));
    Stage::measure((name, "Light paths end after three bounces."), reference, test, 0.5, None).unwrap()
}

fn report() -> ErrorReport {
    let reference = image(WIDTH, HEIGHT, radiance);
    let darker = image(WIDTH, HEIGHT, |x, y, c| radiance(x, y, c) * (0.6 + 0.8 * x as f32 / WIDTH as f32));
    let shifted = image(WIDTH, HEIGHT, |x, y, c| radiance(x + 1, y, c));
    let mut spoiled = reference.clone();
    spoiled.rgb[3 * (20 * WIDTH + 100)] = f32::NAN;
    let mut stages = vec![stage("brightness", reference.clone(), darker), stage("shift", reference.clone(), shifted)];
    stages.push(stage("a <b>|`NaN`", reference, spoiled));
    stages[0].notes.push("Noise of the reference: relMSE 2e-5 & more.".to_owned());
    stages[1].reference.note = Some("512 paths per pixel".to_owned());
    ErrorReport {
        schema: SCHEMA,
        program: Program::this(),
        device: Device { name: "some <device>".to_owned(), driver: "driver 1".to_owned(), ..Device::default() },
        machine: Machine { cpu: "a processor".to_owned(), cores: 2, os: "a system".to_owned() },
        scene: SceneInfo { name: "<script>court & yard".to_owned(), triangles: 12, ..SceneInfo::default() },
        settings: Settings::default().changed(|s| s.picture.size = Size { width: 160, height: 90 }),
        reference_samples: 512,
        frames_per_stage: 16,
        exposure: 0.5,
        interrupted: false,
        stages,
    }
}

/// The bytes of the pictures inside a page, and the page without them.
fn split(page: &str) -> (Vec<Vec<u8>>, String) {
    let mut parts = page.split("data:image/png;base64,");
    let mut rest = parts.next().unwrap().to_owned();
    let mut pictures = Vec::new();
    for part in parts {
        let (picture, after) = part.split_once('"').unwrap();
        pictures.push(STANDARD.decode(picture).unwrap());
        rest += after;
    }
    (pictures, rest)
}

#[test]
fn every_picture_decodes_again() {
    let (pictures, _) = split(&report().to_html().unwrap());
    assert_eq!(pictures.len(), 3 * 4);
    for (index, png) in pictures.iter().enumerate() {
        let bar = if index % 4 < 2 { 0 } else { SCALE_BAR_PX };
        let decoded = ::image::load_from_memory(png).unwrap().into_rgb8();
        assert_eq!(decoded.dimensions(), (WIDTH as u32, (HEIGHT + bar) as u32), "picture {index}");
    }
    let spoiled = ::image::load_from_memory(&pictures[9]).unwrap().into_rgb8();
    assert_eq!(spoiled.get_pixel(100, 20).0, [255, 0, 255]);
    // The first stage is darker on the left and brighter on the right.
    let difference = ::image::load_from_memory(&pictures[2]).unwrap().into_rgb8();
    let (left, right) = (difference.get_pixel(5, 5).0, difference.get_pixel(155, 5).0);
    assert!(left[2] > left[0] && right[0] > right[2], "{left:?} {right:?}");
}

#[test]
fn the_page_stands_alone_and_is_escaped() {
    let (_, page) = split(&report().to_html().unwrap());
    for word in ["http", "://", "<script", "<b>", "url(", "@import", "<link"] {
        assert!(!page.contains(word), "{word} in {page}");
    }
    for word in ["&lt;script&gt;court &amp; yard", "some &lt;device&gt;", "a &lt;b&gt;|`NaN`", "2e-5 &amp; more"] {
        assert!(page.contains(word), "no {word} in {page}");
    }
}

#[test]
fn the_page_leads_to_every_stage() {
    let (_, page) = split(&report().to_html().unwrap());
    assert!(page.starts_with("<!DOCTYPE html>"));
    for index in 1..=3 {
        assert_eq!(page.matches(&format!("href=\"#stage-{index}\"")).count(), 1);
        assert_eq!(page.matches(&format!("id=\"stage-{index}\"")).count(), 1);
        assert_eq!(page.matches(&format!("name=\"shown-{index}\"")).count(), 3);
        assert_eq!(page.matches(&format!("id=\"only-test-{index}\"")).count(), 1);
    }
    for word in ["61.0 s", "4.20 ms", "path traced: 512 paths per pixel", "in the test, in no measure: 1"] {
        assert!(page.contains(word), "no {word} in {page}");
    }
}

#[test]
fn an_interrupted_run_says_so() {
    let whole = report();
    let cut = ErrorReport { interrupted: true, stages: Vec::new(), ..whole.clone() };
    assert!(!whole.to_html().unwrap().contains(INTERRUPTED) && !whole.to_markdown().contains(INTERRUPTED));
    assert!(cut.to_html().unwrap().contains(INTERRUPTED) && cut.to_markdown().contains(INTERRUPTED));
}

#[test]
fn json_has_the_numbers_and_not_the_pictures() {
    let json: serde_json::Value = serde_json::from_slice(&report().to_json().unwrap()).unwrap();
    assert_eq!(json["schema"], SCHEMA);
    for key in ["program", "device", "machine", "scene", "settings"] {
        assert!(json[key].is_object(), "{key}");
    }
    assert_eq!(json["exposure"], 0.5);
    assert_eq!(json["interrupted"], false);
    let stage = &json["stages"][2];
    assert_eq!(stage["name"], "a <b>|`NaN`");
    assert_eq!((&stage["reference"]["ms"], &stage["test"]["ms"]), (&61_000.0.into(), &4.2.into()));
    assert_eq!(stage["metrics"]["nonfinite_test_pixels"], 1);
    assert_eq!(stage["metrics"]["flip"], 0.0);
    assert!(stage.get("images").is_none());
    assert!(json["stages"][1]["metrics"]["flip"].as_f64().unwrap() > 0.01);
}

#[test]
fn markdown_is_a_table_with_a_row_for_each_stage() {
    let text = report().to_markdown();
    assert!(text.starts_with("# Error report: &lt;script>court &amp; yard\n"), "{text}");
    let rows: Vec<&str> = text.lines().filter(|line| line.starts_with("| ")).collect();
    assert_eq!(rows.len(), 2 + 3, "{text}");
    assert!(rows[0].starts_with("| stage | what differs | energy ratio | relMSE | relMSE of 8x8 blocks | FLIP |"));
    for row in &rows {
        assert_eq!(row.replace("\\|", "").matches('|').count(), 9, "{row}");
    }
    assert!(
        rows[4].starts_with("| a &lt;b>\\|\\`NaN\\` | Light paths end after three bounces. | 1.0000 | 0 | 0 | 0 |")
    );
    assert!(rows[2].ends_with("| path traced, 61.0 s | VPLs, 4.20 ms |"), "{text}");
    assert!(text.contains("\nbrightness:\n\n- Noise of the reference: relMSE 2e-5 &amp; more.\n"), "{text}");
}

#[test]
fn numbers_for_reading() {
    assert_eq!([None, Some(3.21), Some(321.4), Some(12_345.0)].map(time), ["-", "3.21 ms", "321 ms", "12.3 s"]);
    let found = [None, Some(0.0), Some(0.98765), Some(0.00123), Some(-0.5)].map(measure);
    assert_eq!(found, ["undefined", "0", "0.9877", "1.23e-3", "-0.5000"]);
}
