//! A frame in one submission, in many, in steps and pass by pass: how many there are, and that the picture is the same.

mod common;

use std::ops::ControlFlow;
use std::path::Path;

use common::gpu;
use gridlight::gpu::SteppedFrame;
use gridlight::renderer::{Job, Renderer, UploadedScene};
use gridlight::scene::{Scene, gltf};
use gridlight::settings::{Settings, Size, Technique};

/// Longer than any frame, and shorter than any pass.
const LONG_MS: f64 = 1e9;
const SHORT_MS: f64 = 1e-9;

fn courtyard() -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/courtyard.glb");
    gltf::load(&path, &|_: &str, _, _| ()).unwrap()
}

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

    let (first, _) = run(&mut renderer, LONG_MS);
    assert_eq!(first.times.submissions, passes, "times are not known before the first frame");
    let picture = bits(&renderer);
    assert!(picture.iter().any(|bits| *bits != 0));
    let same = |what: &str, found: u32, expected: u32, renderer: &Renderer| {
        assert_eq!(found, expected, "submissions {what}");
        assert!(bits(renderer) == picture, "another picture {what}");
    };
    let (whole, _) = run(&mut renderer, LONG_MS);
    same("in one", whole.times.submissions, 1, &renderer);
    let (split, _) = run(&mut renderer, SHORT_MS);
    same("each pass", split.times.submissions, passes, &renderer);

    // Half of the last frame's time: more than one, unless a pass takes all of it, and fewer than passes.
    let (some, _) = run(&mut renderer, split.times.gpu_ms() / 2.0);
    let submissions = some.times.submissions;
    assert!(submissions > 1 && submissions < passes, "{submissions} of {passes}");
    same("by time", submissions, submissions, &renderer);

    let mut visited = Vec::new();
    renderer.run_and_read(|pass, _| Ok(visited.push(pass))).unwrap();
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
    assert_eq!(long.times.submissions, 2 + long_steps, "what comes before and what comes after");
    assert!(bits(&renderer) == picture, "another picture in other steps");
}
