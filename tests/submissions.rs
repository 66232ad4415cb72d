//! A frame in one submission, in many, in steps and pass by pass: how many there are, and that the picture is the same;
//! and the crash markers on its way.

mod common;
mod support;

use std::ops::{ControlFlow, Range};

use common::rooms::courtyard;
use common::{GpuTest, gpu};
use gridlight::gpu::{MarkerScheme, SteppedFrame};
use gridlight::renderer::{Job, Renderer, UploadedScene};
use gridlight::settings::{Settings, Size, Technique};

/// Words of crash markers that a frame writes.
fn crash_markers(test: &GpuTest, renderer: &Renderer) -> u32 {
    let plan = renderer.executor().plan();
    match MarkerScheme::of(test.gpu.features(), false) {
        MarkerScheme::Fills => plan.batch_count() as u32,
        MarkerScheme::BufferMarkers => 2 * plan.passes.len() as u32,
        MarkerScheme::Checkpoints => 0,
    }
}

/// Longer than any frame, and shorter than any pass.
const LONG_MS: f64 = 1e9;
const SHORT_MS: f64 = 1e-9;

fn small(technique: Technique) -> Settings {
    Settings::default().changed(|s| {
        s.render.technique = technique;
        s.picture.size = Size { width: 64, height: 36 };
        s.many_lights.vpls = 500;
        s.path_trace.samples = 4;
    })
}

/// Runs a frame as headless runs do; with the steps that there were.
fn run(renderer: &mut Renderer, max_submit_ms: f64) -> (SteppedFrame, u32) {
    let mut steps = 0;
    let frame = renderer.run_in_steps(max_submit_ms, &mut |_, _| {
        steps += 1;
        ControlFlow::Continue(())
    });
    (frame.unwrap(), steps)
}

/// Whether what a frame told of itself rises step by step to all of its passes.
fn rises_to_the_end(told: &[(u32, u32)], passes: u32) -> bool {
    told.is_sorted_by(|a, b| a.0 < b.0)
        && told.iter().all(|(_, all)| *all == passes)
        && told.last() == Some(&(passes, passes))
}

#[test]
fn a_frame_tells_how_far_it_is() {
    let test = gpu();
    let scene = courtyard();
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    let settings = small(Technique::Direct);
    let mut renderer = Renderer::new(&Job::new(&test.gpu, &uploaded, &scene.cameras[0], &settings)).unwrap();
    let passes = renderer.pass_names().len() as u32;
    for (limit_ms, steps) in [(LONG_MS, passes), (LONG_MS, 1), (SHORT_MS, passes)] {
        let mut told = Vec::new();
        let mut on_step = |done, all| {
            told.push((done, all));
            ControlFlow::Continue(())
        };
        renderer.run_in_steps(limit_ms, &mut on_step).unwrap();
        assert!(rises_to_the_end(&told, passes) && told.len() as u32 == steps, "{told:?}");
    }
    assert!(!rises_to_the_end(&[(1, 3), (1, 3), (3, 3)], 3) && !rises_to_the_end(&[(1, 3), (2, 3)], 3));
}

fn bits(renderer: &Renderer) -> Vec<u32> {
    renderer.read_radiance().unwrap().into_iter().map(f32::to_bits).collect()
}

#[test]
fn submissions_change_nothing() {
    let test = gpu();
    let scene = courtyard();
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    let settings = small(Technique::Lgh);
    let mut renderer = Renderer::new(&Job::new(&test.gpu, &uploaded, &scene.cameras[0], &settings)).unwrap();
    let passes = renderer.pass_names().len() as u32;

    let markers = crash_markers(&test, &renderer);
    let (first, _) = run(&mut renderer, LONG_MS);
    assert_eq!(first.times.crash_markers, markers);
    assert_eq!(first.times.submissions, passes, "times are not known before the first frame");
    let picture = bits(&renderer);
    assert!(picture.iter().any(|bits| *bits != 0));
    let same = |what: &str, found: u32, expected: u32, renderer: &Renderer| {
        assert_eq!(found, expected, "submissions {what}");
        assert!(bits(renderer) == picture, "another picture {what}");
    };
    let (whole, _) = run(&mut renderer, LONG_MS);
    assert_eq!(whole.times.crash_markers, markers);
    same("in one", whole.times.submissions, 1, &renderer);
    let (split, _) = run(&mut renderer, SHORT_MS);
    same("each pass", split.times.submissions, passes, &renderer);

    // Half of the last frame's time: more than one, unless a pass takes all of it, and fewer than passes.
    let (some, _) = run(&mut renderer, split.times.gpu_ms() / 2.0);
    let submissions = some.times.submissions;
    assert!(submissions > 1 && submissions < passes, "{submissions} of {passes}");
    same("by time", submissions, submissions, &renderer);

    let mut visited = Vec::new();
    let visit = |pass, _| {
        visited.push(pass);
        Ok(())
    };
    renderer.run_and_read(visit).unwrap();
    assert_eq!(visited, (0..passes as usize).collect::<Vec<_>>());
    same("pass by pass", visited.len() as u32, passes, &renderer);
}

#[test]
fn a_repeated_pass_has_a_submission_for_each_step() {
    let test = gpu();
    let scene = courtyard();
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    let settings = small(Technique::PathTrace);
    let mut renderer = Renderer::new(&Job::new(&test.gpu, &uploaded, &scene.cameras[0], &settings)).unwrap();
    let passes = renderer.pass_names().len() as u32;

    let (short, short_steps) = run(&mut renderer, SHORT_MS);
    let picture = bits(&renderer);
    assert!(short_steps > 1, "{short:?}");
    assert_eq!(short.times.submissions, passes - 1 + short_steps, "every other pass is one");
    assert_eq!(short.rounds_done, short.rounds);

    let (long, long_steps) = run(&mut renderer, LONG_MS);
    assert!(long_steps < short_steps, "{long_steps} steps with a long limit, {short_steps} with a short one");
    assert_eq!(long.times.crash_markers, crash_markers(&test, &renderer), "not one for each step");
    assert_eq!(long.times.submissions, 2 + long_steps, "what comes before and what comes after");
    assert!(bits(&renderer) == picture, "another picture in other steps");
}

/// The passes that the device's markers do not tell from this one, as an error message lists them.
fn group_of(pass: usize, test: &GpuTest, renderer: &Renderer) -> (Range<usize>, String) {
    let passes = &renderer.executor().plan().passes;
    let begins = |index: usize| match MarkerScheme::of(test.gpu.features(), true) {
        MarkerScheme::Fills => passes[index].has_batch(),
        MarkerScheme::BufferMarkers | MarkerScheme::Checkpoints => true,
    };
    let first = (0..=pass).rev().find(|&index| begins(index)).unwrap();
    let end = (pass + 1..passes.len()).find(|&index| begins(index)).unwrap_or(passes.len());
    let names: Vec<String> = passes[first..end].iter().map(|pass| format!("`{}`", pass.name)).collect();
    let what = if names.len() == 1 { "pass" } else { "one of the passes" };
    let after = if end == passes.len() { " or after the frame" } else { "" };
    (first..end, format!("error: the Vulkan device was lost in {what} {}{after}\n", names.join(", ")))
}

#[test]
fn a_lost_device_names_the_passes_it_was_at() {
    let settings = small(Technique::Lgh);
    let (names, groups) = {
        let test = gpu();
        let scene = courtyard();
        let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
        let renderer = Renderer::new(&Job::new(&test.gpu, &uploaded, &scene.cameras[0], &settings)).unwrap();
        let names = renderer.pass_names();
        let groups: Vec<_> = (0..names.len()).map(|pass| group_of(pass, &test, &renderer)).collect();
        (names, groups)
    };
    let single = groups.iter().rposition(|(group, _)| group.len() == 1).unwrap();
    let several = groups.iter().rposition(|(group, _)| group.len() > 1);
    for pass in [Some(single), several, Some(names.len() - 1)].into_iter().flatten() {
        let mut command = support::program();
        command.args(["--headless", "--size", "64x36", "--vpls", "500", "--warmup", "1"]);
        command.env("GRIDLIGHT_LOSE_DEVICE", &names[pass]);
        let run = support::run(command);
        assert_eq!((run.code, run.stderr.as_str()), (Some(5), groups[pass].1.as_str()));
    }
}
