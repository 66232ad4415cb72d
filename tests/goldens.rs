//! Small pictures of the built-in scene against those in `tests/golden/`.
//!
//! The comparison is loose: it finds a picture that is broken, not one that another driver rounds differently.
//! `GRIDLIGHT_BLESS=1 cargo test --release --test goldens` writes the pictures anew; look at them before a commit.

mod support;

use std::path::Path;

use gridlight::files::pictures::write_png;
use support::golden::{Picture, SIZE, compare, golden, load};
use support::succeed;

/// A golden is small enough to live in the repository.
const MOST_BYTES: u64 = 40 << 10;

/// Renders to `path`. The exposure is fixed, lest it hide a change of brightness, and so is the tone curve: these are
/// pictures of the light.
fn render(path: &Path, camera: &str, technique: &str, seed: &str) -> Picture {
    let options = "--headless --size 160x90 --vpls 2000 --shadow-samples 16 --tone-map reinhard --quiet";
    let mut arguments: Vec<&str> = options.split(' ').collect();
    // Bright enough for the shade, or for the sun alone.
    arguments.extend(["--exposure", if technique == "direct" { "1" } else { "4" }]);
    arguments.extend(["--camera", camera, "--technique", technique, "--seed", seed]);
    arguments.extend(["--output", path.to_str().unwrap()]);
    succeed(&arguments);
    load(path).unwrap()
}

/// Renders, then compares or blesses.
fn check(camera: &str, technique: &str) {
    let name = format!("{camera}-{technique}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    let picture = render(&path, camera, technique, "1");
    if std::env::var_os("GRIDLIGHT_BLESS").is_some_and(|value| value == "1") {
        std::fs::copy(&path, golden(&name)).unwrap();
    }
    assert!(std::fs::metadata(golden(&name)).map_or(0, |file| file.len()) <= MOST_BYTES, "{name} is too large");
    if let Err(complaint) = compare(&picture, &golden(&name)) {
        panic!("{complaint}");
    }
}

#[test]
fn another_seed_passes() {
    let folder = tempfile::tempdir().unwrap();
    let picture = render(&folder.path().join("a.png"), "arcade", "lgh", "2");
    compare(&picture, &golden("arcade-lgh")).unwrap();
}

#[test]
fn court_lgh() {
    check("court", "lgh");
}

#[test]
fn court_direct() {
    check("court", "direct");
}

#[test]
fn arcade_lgh() {
    check("arcade", "lgh");
}

#[test]
fn arcade_direct() {
    check("arcade", "direct");
}

const NAMES: [&str; 4] = ["court-lgh", "court-direct", "arcade-lgh", "arcade-direct"];

/// The comparator must refuse every golden with this fault in it.
fn must_fail(fault: &str, plant: impl Fn(&[u8]) -> Picture) {
    for name in NAMES {
        let path = golden(name);
        let faulty = plant(&load(&path).unwrap());
        assert!(compare(&faulty, &path).is_err(), "{name} {fault} passes");
    }
}

fn rows(picture: &[u8]) -> impl DoubleEndedIterator<Item = &[u8]> {
    picture.chunks_exact(3 * SIZE.0 as usize)
}

#[test]
fn planted_shift_by_eight_pixels() {
    let shift = |row: &[u8]| [&row[3 * 8..], &row[..3 * 8]].concat();
    must_fail("shifted", |picture| rows(picture).flat_map(shift).collect());
}

#[test]
fn planted_darkening_by_a_fifth() {
    must_fail("darkened", |picture| picture.iter().map(|v| (f32::from(*v) * 0.8) as u8).collect());
}

#[test]
fn planted_upside_down() {
    must_fail("upside down", |picture| rows(picture).rev().flatten().copied().collect());
}

#[test]
fn a_golden_passes_against_itself_and_a_missing_one_fails() {
    for name in NAMES {
        compare(&load(&golden(name)).unwrap(), &golden(name)).unwrap();
    }
    let picture = load(&golden(NAMES[0])).unwrap();
    assert!(compare(&picture, &golden("there-is-none")).unwrap_err().contains("there-is-none"));
}

#[test]
fn a_golden_of_another_size_fails() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    let mut bytes = Vec::new();
    write_png(&mut bytes, 90, 160, &vec![0; 3 * 90 * 160], "").unwrap();
    std::fs::write(&path, bytes).unwrap();
    assert!(compare(&vec![0; 3 * 90 * 160], &path).unwrap_err().contains("90x160"));
}
