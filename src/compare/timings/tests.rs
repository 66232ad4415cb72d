//! Timings files with planted differences.

use serde_json::json;

use super::*;
use crate::report::timings::tests::report;

/// A file as the program writes it: gbuffer 1.5 ms, light-volumes 3.5 ms, frame 5 ms; then changed.
fn file(change: impl FnOnce(&mut Value)) -> TimingsFile {
    let mut json = serde_json::from_slice(&report().to_json().unwrap()).unwrap();
    change(&mut json);
    TimingsFile::parse(json.to_string().as_bytes()).unwrap()
}

fn compare(change: impl FnOnce(&mut Value)) -> TimingComparison {
    TimingComparison::new(&file(|_| ()), &file(change))
}

#[test]
fn equal_files_have_nothing_to_say() {
    let found = compare(|_| ());
    assert_eq!(found.notes, Vec::<String>::new());
    assert_eq!(found.regressions(0.0), Vec::<String>::new());
    assert!(found.passes.iter().all(|pass| pass.ratio == Some(1.0)));
    let gbuffer = &found.passes[0];
    assert_eq!(
        (gbuffer.name.as_str(), gbuffer.reference_ms, gbuffer.share_percent),
        ("gbuffer", Some(1.5), Some(30.0))
    );
}

#[test]
fn a_slower_pass_and_a_slower_frame() {
    let found = compare(|json| {
        json["passes"][1]["ms"]["median"] = json!(4.2);
        json["frame_gpu_ms"]["median"] = json!(5.7);
    });
    let clauses = found.regressions(10.0);
    assert_eq!(
        clauses,
        [
            "frame (GPU clock) is 14 % slower (5.7 against 5 ms), over the limit 10 %",
            "light-volumes is 20 % slower (4.2 against 3.5 ms), over the limit 10 %"
        ]
    );
    assert_eq!(found.regressions(15.0).len(), 1);
    assert_eq!(found.regressions(20.5), Vec::<String>::new());
    assert_eq!(TimingComparison::new(&file(|_| ()), &file(|_| ())).regressions(0.0), Vec::<String>::new());
}

#[test]
fn small_passes_are_not_held_to_the_limit() {
    // 0.2 of 5 ms is 4 %; 0.25 ms is 5 %.
    let small = |ms: f64| file(|json| json["passes"][0]["ms"]["median"] = json!(ms));
    assert!(TimingComparison::new(&small(0.1), &small(0.2)).regressions(10.0).is_empty());
    let clauses = TimingComparison::new(&small(0.2), &small(0.25)).regressions(10.0);
    assert_eq!(clauses.len(), 1, "{clauses:?}");
}

#[test]
fn passes_in_one_file_only() {
    let found = compare(|json| json["passes"][0]["name"] = json!("rasterise"));
    let names: Vec<_> = found.passes.iter().map(|pass| pass.name.as_str()).collect();
    assert_eq!(names, ["gbuffer", "light-volumes", "rasterise"]);
    assert_eq!((found.passes[0].test_ms, found.passes[2].reference_ms), (None, None));
    assert!(found.passes[0].ratio.is_none() && found.regressions(0.0).is_empty());
}

#[test]
fn a_pass_that_took_no_time() {
    let still = file(|json| json["passes"][0]["ms"]["median"] = json!(0.0));
    let found = TimingComparison::new(&still, &file(|_| ()));
    assert_eq!(found.passes[0].ratio, None);
    assert_eq!(found.regressions(10.0), ["gbuffer is slower (1.5 against 0 ms), over the limit 10 %"]);
    let still = |json: &mut Value| json["frame_gpu_ms"]["median"] = json!(0.0);
    let found = TimingComparison::new(&file(still), &file(still));
    assert!(found.passes[0].share_percent.is_none() && found.regressions(0.0).is_empty());
}

#[test]
fn what_makes_files_less_comparable_is_said() {
    let found = compare(|json| {
        json["device"]["name"] = json!("another device");
        json["scene"]["name"] = json!("atrium");
        json["scene"]["path"] = json!("/elsewhere/atrium.glb");
        json["settings"]["vpls"] = json!(7);
        json["settings"]["camera"] = json!("door");
        json["settings"]["output"] = json!("elsewhere.png");
        json["program"]["commit"] = json!("0123456");
    });
    assert_eq!(
        found.notes,
        [
            "device not the same: name `some device` against `another device`",
            "scene not the same: name `courtyard` against `atrium`",
            "settings not the same: camera unset against `door`, vpls 100000 against 7"
        ]
    );
}

#[test]
fn other_files_are_refused() {
    let complaint = |text: &str| TimingsFile::parse(text.as_bytes()).unwrap_err();
    assert!(complaint("{").starts_with("not a JSON file"));
    assert_eq!(complaint("[1, 2]"), "not a timings file of gridlight: it has no schema");
    assert!(complaint(r#"{"schema": "gridlight-timings/9"}"#).contains("gridlight-timings/9"));
    let sentence = complaint(&json!({"schema": SCHEMA}).to_string());
    assert!(sentence.starts_with("not a whole timings file") && !sentence.contains('\n'), "{sentence}");
    assert_eq!(TimingsFile::read(Path::new("/no/such.json")).unwrap_err().exit_code(), 1);
}
