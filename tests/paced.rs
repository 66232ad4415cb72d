//! A frame that goes in pieces, as a window has it: the picture is that of a whole frame, whatever the pieces; one that is
//! abandoned leaves nothing behind; a reference that was stopped goes on where it was.

mod common;

use std::ops::ControlFlow;

use common::rooms::courtyard;
use common::{GpuTest, gpu};
use gridlight::gpu::SteppedFrame;
use gridlight::renderer::{Job, Renderer, UploadedScene};
use gridlight::scene::Scene;
use gridlight::settings::{Settings, Size, Technique};

/// Shorter than any piece, and longer than any frame.
const SHORT_MS: f64 = 1e-9;
const LONG_MS: f64 = 1e9;

fn small(technique: Technique) -> Settings {
    Settings::default().changed(|s| {
        s.render.technique = technique;
        s.picture.size = Size { width: 80, height: 45 };
        s.many_lights.vpls = 300;
        s.path_trace.samples = 4;
    })
}

/// A scene on the device, and frames of it for a window.
struct Windowed {
    test: GpuTest,
    scene: Scene,
    uploaded: UploadedScene,
    settings: Settings,
}

impl Windowed {
    fn new(technique: Technique) -> Self {
        let (test, scene) = (gpu(), courtyard());
        let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
        Self { test, scene, uploaded, settings: small(technique) }
    }

    fn renderer(&self) -> Renderer {
        let job = Job::new(&self.test.gpu, &self.uploaded, &self.scene.cameras[0], &self.settings);
        Renderer::for_window(&job, false, None).unwrap()
    }
}

/// Runs a frame to its end; `flow` is asked before each piece.
fn run(
    renderer: &mut Renderer,
    longest_ms: f64,
    first_round: u32,
    mut flow: impl FnMut() -> ControlFlow<()>,
) -> SteppedFrame {
    let mut frame = renderer.begin_paced(first_round).unwrap();
    loop {
        if let Some(done) = renderer.advance(&mut frame, longest_ms, flow()).unwrap() {
            return done;
        }
    }
}

fn to_the_end() -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn bits(renderer: &Renderer) -> Vec<u32> {
    renderer.read_radiance().unwrap().into_iter().map(f32::to_bits).collect()
}

#[test]
fn pieces_change_nothing() {
    let windowed = Windowed::new(Technique::Lgh);
    let mut renderer = windowed.renderer();
    let ticket = renderer.submit().unwrap();
    let whole = renderer.wait(ticket).unwrap();
    let (picture, passes) = (bits(&renderer), whole.pass_ms.len() as u32);
    assert!(picture.iter().any(|bits| *bits != 0));
    let short = run(&mut renderer, SHORT_MS, 0, to_the_end);
    // The rows of its workgroups make more pieces than there are passes.
    assert!(short.times.submissions > passes, "{} pieces of {passes} passes", short.times.submissions);
    assert!(bits(&renderer) == picture, "another picture in short pieces");
    assert_eq!(short.times.readback, whole.readback);
    assert_eq!(short.times.crash_markers, whole.crash_markers);
    assert!(short.times.pass_ms.iter().all(|ms| ms.is_finite()) && short.times.gpu_ms() > 0.0);
    let long = run(&mut renderer, LONG_MS, 0, to_the_end);
    assert_eq!(long.times.submissions, 1);
    assert!(bits(&renderer) == picture, "another picture in one piece");
    // What the frame after it needs of it, in several pieces, is there in the first one as well.
    let mut fresh = windowed.renderer();
    let first = run(&mut fresh, SHORT_MS, 0, to_the_end);
    assert!(first.times.submissions >= passes && bits(&fresh) == picture);
}

#[test]
fn an_abandoned_frame_leaves_nothing_behind() {
    let windowed = Windowed::new(Technique::Lgh);
    let mut renderer = windowed.renderer();
    let times = run(&mut renderer, SHORT_MS, 0, to_the_end).times;
    let (all, whole_ms) = (times.submissions, times.gpu_ms());
    let picture = bits(&renderer);
    // At its beginning, here and there on the way, and before its last piece.
    for pieces in [0, 1, 2, all / 4, all / 2, 2 * all / 3, all - 1] {
        renderer.forget_lights();
        let mut frame = renderer.begin_paced(0).unwrap();
        while frame.submissions() < pieces {
            assert!(renderer.advance(&mut frame, SHORT_MS, to_the_end()).unwrap().is_none());
        }
        renderer.abandon(frame).unwrap();
        run(&mut renderer, LONG_MS, 0, to_the_end);
        assert!(bits(&renderer) == picture, "another picture after {pieces} pieces of a frame were abandoned");
    }
    // With a third of its passes under way, or all of them.
    for longest_ms in [whole_ms / 3.0, LONG_MS] {
        renderer.forget_lights();
        let mut frame = renderer.begin_paced(0).unwrap();
        assert!(renderer.advance(&mut frame, longest_ms, to_the_end()).unwrap().is_none());
        renderer.abandon(frame).unwrap();
        run(&mut renderer, LONG_MS, 0, to_the_end);
        assert!(bits(&renderer) == picture, "another picture after a piece of {longest_ms} ms was abandoned");
    }
}

/// Rays of the light paths that a frame has traced.
fn path_rays(renderer: &Renderer, frame: &SteppedFrame) -> u32 {
    renderer.feedback(&frame.times).unwrap().rays[0]
}

/// Lights that are used again give the picture that lights made anew give, to the bit, from wherever it is seen, and they are
/// made anew as soon as anything that they follow from is another.
#[test]
fn kept_lights_change_nothing() {
    for technique in [Technique::Lgh, Technique::BruteForce] {
        let windowed = Windowed::new(technique);
        let mut renderer = windowed.renderer();
        let job = |camera: usize, settings: &Settings, renderer: &mut Renderer| {
            renderer.update(&Job::new(
                &windowed.test.gpu,
                &windowed.uploaded,
                &windowed.scene.cameras[camera],
                settings,
            ));
        };
        let first = run(&mut renderer, SHORT_MS, 0, to_the_end);
        assert!(path_rays(&renderer, &first) > 0);
        // Seen from elsewhere, in pieces of any length; after frames that were abandoned before and after the lights.
        for (camera, longest_ms, abandoned) in [(1, SHORT_MS, None), (0, LONG_MS, Some(3)), (1, LONG_MS, Some(60))] {
            if let Some(pieces) = abandoned {
                let mut frame = renderer.begin_paced(0).unwrap();
                while frame.submissions() < pieces
                    && renderer.advance(&mut frame, SHORT_MS, to_the_end()).unwrap().is_none()
                {}
                renderer.abandon(frame).unwrap();
            }
            job(camera, &windowed.settings, &mut renderer);
            let kept = run(&mut renderer, longest_ms, 0, to_the_end);
            let picture = bits(&renderer);
            assert_eq!(path_rays(&renderer, &kept), 0, "{technique:?}: light paths were traced again");
            renderer.forget_lights();
            let anew = run(&mut renderer, LONG_MS, 0, to_the_end);
            assert_eq!(path_rays(&renderer, &anew), path_rays(&renderer, &first), "the lights were to be made anew");
            assert!(bits(&renderer) == picture, "{technique:?}: another picture with kept lights");
        }
        let before = bits(&renderer);
        // Other light paths, and another light of the scene.
        let mut reseeded = windowed.settings.clone();
        reseeded.tracing.seed += 1;
        job(1, &reseeded, &mut renderer);
        changed_like_anew(&mut renderer, &before);
        let mut lights = windowed.uploaded.other_lights().to_vec();
        lights[0].intensity = lights[0].intensity.map(|channel| 0.5 * channel);
        renderer.update_lights(&lights).unwrap();
        let before = bits(&renderer);
        changed_like_anew(&mut renderer, &before);
    }
}

/// The next frame differs from `before`, and is what a frame with lights made anew is.
fn changed_like_anew(renderer: &mut Renderer, before: &[u32]) {
    run(renderer, LONG_MS, 0, to_the_end);
    let picture = bits(renderer);
    assert!(picture != before, "lights of before");
    renderer.forget_lights();
    run(renderer, LONG_MS, 0, to_the_end);
    assert!(bits(renderer) == picture, "another picture with kept lights");
}

#[test]
fn a_reference_goes_on_where_it_was_stopped() {
    for technique in [Technique::PathTrace, Technique::BruteForce] {
        let windowed = Windowed::new(technique);
        let mut renderer = windowed.renderer();
        let whole = run(&mut renderer, SHORT_MS, 0, to_the_end);
        let picture = bits(&renderer);
        assert!(whole.rounds_done == whole.rounds && whole.rounds > 2, "{whole:?}");
        let part = run(&mut renderer, SHORT_MS, 0, || ControlFlow::Break(()));
        assert_eq!((part.rounds_done, part.rounds), (1, whole.rounds));
        let first_round = bits(&renderer);
        assert!(first_round.iter().any(|bits| *bits != 0), "a part is a picture");
        assert!(first_round != picture, "{technique:?}: one round is not the whole");
        let rest = run(&mut renderer, LONG_MS, part.rounds_done, to_the_end);
        assert_eq!((rest.rounds_done, rest.rounds), (whole.rounds, whole.rounds));
        assert!(bits(&renderer) == picture, "{technique:?}: another picture in two parts");
    }
}

/// A dispatch may go in several rows of workgroups, so that no shader may ask how many rows there are.
#[test]
fn no_shader_asks_for_rows() {
    let asks = |text: &str| {
        let uses = text.split("gl_NumWorkGroups").skip(1);
        uses.filter(|rest| !rest.starts_with(".x") || rest[2..].starts_with(['y', 'z'])).count()
    };
    assert_eq!((asks("gl_NumWorkGroups.x * 2"), asks("a.gl_NumWorkGroups.y"), asks("gl_NumWorkGroups;")), (0, 1, 1));
    let shaders = concat!(env!("CARGO_MANIFEST_DIR"), "/shaders");
    let mut count = 0;
    for folder in std::fs::read_dir(shaders).unwrap().map(|entry| entry.unwrap().path()).filter(|path| path.is_dir()) {
        for file in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if file.extension().is_some_and(|extension| extension == "glsl") {
                count += 1;
                assert_eq!(asks(&std::fs::read_to_string(&file).unwrap()), 0, "{}", file.display());
            }
        }
    }
    assert!(count > 50, "{count} sources");
}
