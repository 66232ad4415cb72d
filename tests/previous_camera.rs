//! What a frame's constants tell of the frame before it.

mod common;

use common::rooms::furnished_room;
use gridlight::Result;
use gridlight::gpu::{TransferOp, Work};
use gridlight::graph::{Access, Pass};
use gridlight::passes::Frame;
use gridlight::passes::gbuffer::GBuffer;
use gridlight::renderer::{Fresh, Job, Renderer, UploadedScene};
use gridlight::settings::{Settings, Size, Technique as TechniqueName};
use gridlight::techniques::{Added, Technique, TechniqueOutputs, TechniqueShape};

/// Direct light alone, and something that is handed on from frame to frame.
struct Remembering;

#[derive(Clone, Debug, PartialEq)]
struct RememberingShape;

impl Technique for Remembering {
    fn name(&self) -> &'static str {
        "remembering"
    }

    fn shape(&self, _job: &Job<'_>, _known: Option<&dyn TechniqueShape>) -> Result<Box<dyn TechniqueShape>> {
        Ok(Box::new(RememberingShape))
    }
}

impl TechniqueShape for RememberingShape {
    fn technique(&self) -> &'static dyn Technique {
        &Remembering
    }

    fn add_passes(&self, frame: &mut Frame, _gbuffer: &GBuffer) -> Added {
        let kept = frame.graph.history_buffer("kept", 16);
        let copy = TransferOp::Copy { from: kept.previous, to: kept.current, offset_bytes: 0 };
        let pass = Pass::new("keep", Work::Transfer(vec![copy]));
        frame.graph.add_pass(pass.uses(kept.previous, Access::TransferRead).uses(kept.current, Access::TransferWrite));
        Added { indirect: None, outputs: TechniqueOutputs::default(), inspect: None }
    }
}

/// Frames of a mean, each sampled elsewhere; without a technique those of direct light.
fn renderer(test: &common::GpuTest, technique: Option<&dyn Technique>) -> Renderer {
    let scene = furnished_room();
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    let settings = Settings::default().changed(|s| {
        s.picture.size = Size { width: 16, height: 9 };
        s.render.technique = TechniqueName::Direct;
        s.render.accumulate = 4;
    });
    let job = Job::new(&test.gpu, &uploaded, &scene.cameras[0], &settings);
    technique.map_or_else(|| Renderer::new(&job), |technique| Renderer::with_technique(technique, &job)).unwrap()
}

#[test]
fn a_frame_knows_the_camera_of_the_frame_before_unless_there_was_a_cut() {
    let test = common::gpu();
    let mut renderer = renderer(&test, Some(&Remembering));
    let mut places = Vec::new();
    for (number, valid) in [(0, false), (1, true), (2, true), (3, false)] {
        if number == 3 {
            renderer.cut();
        }
        renderer.set_accumulated_frame(number, Fresh::All);
        let ticket = renderer.submit().unwrap();
        renderer.wait(ticket).unwrap();
        let data = renderer.frame_data();
        places.push([data.jitter_x_px, data.jitter_y_px]);
        let before = places[if valid { number as usize - 1 } else { number as usize }];
        assert_eq!(data.history_is_valid, u32::from(valid), "frame {number}");
        assert_eq!((data.previous_jitter_px, data.previous_eye_ws), (before, data.eye_ws), "frame {number}");
    }
    assert!(places.windows(2).all(|pair| pair[0] != pair[1]), "the frames differ in where they sample");
}

#[test]
fn a_frame_that_keeps_nothing_is_the_same_whatever_came_before() {
    let test = common::gpu();
    let mut renderer = renderer(&test, None);
    let first = *renderer.frame_data();
    for _ in 0..2 {
        let ticket = renderer.submit().unwrap();
        renderer.wait(ticket).unwrap();
        assert_eq!(renderer.frame_data().history_is_valid, 0);
        assert_eq!(renderer.frame_data().previous_forward_ws, first.forward_ws);
    }
}
