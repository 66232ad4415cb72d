//! Pairs that change places between frames. The checker plays four frames, so that each of a pair has been in each
//! place twice.

use ash::vk::{AccessFlags2 as Mask, ImageLayout, ImageUsageFlags, PipelineStageFlags2 as Stage};
use gridlight::graph::{Access, Graph, PlanError, hoist, plan, to_dot};

use crate::{Frame, checker, color, memory, pass, planned, transition};

const NO_LAYOUT: ImageLayout = ImageLayout::UNDEFINED;
const SAMPLED: ImageLayout = ImageLayout::SHADER_READ_ONLY_OPTIMAL;
const COMPUTE_READ: (Stage, Mask) = (Stage::COMPUTE_SHADER, Mask::SHADER_STORAGE_READ);
const COMPUTE_WRITE: (Stage, Mask) = (Stage::COMPUTE_SHADER, Mask::SHADER_STORAGE_WRITE);
const COMPUTE_SAMPLED: (Stage, Mask) = (Stage::COMPUTE_SHADER, Mask::SHADER_SAMPLED_READ);
const FRAGMENT_SAMPLED: (Stage, Mask) = (Stage::FRAGMENT_SHADER, Mask::SHADER_SAMPLED_READ);
const COLOR_WRITE: (Stage, Mask) = (Stage::COLOR_ATTACHMENT_OUTPUT, Mask::COLOR_ATTACHMENT_WRITE);

#[test]
fn a_buffer_is_read_after_the_frame_before_wrote_it() {
    let mut frame = Graph::new();
    let count = frame.history_buffer("count", 64);
    frame.add_pass(pass("add").bind(0, count.previous, Access::ComputeRead).bind(
        1,
        count.current,
        Access::ComputeWrite,
    ));
    let plan = planned(&frame);
    let read = memory(count.previous, NO_LAYOUT, COMPUTE_WRITE, COMPUTE_READ);
    // The frame before has read what is now written.
    let renew = memory(count.current, NO_LAYOUT, (Stage::COMPUTE_SHADER, Mask::NONE), COMPUTE_WRITE);
    assert_eq!(plan.passes[0].barriers, [read, renew]);
    assert_eq!(plan.initial, []);
}

#[test]
fn an_image_comes_in_the_layout_that_the_frame_before_left_it_in() {
    let mut frame = Graph::new();
    let sum = frame.history_image("sum", color());
    frame.add_pass(pass("add").bind(0, sum.previous, Access::ComputeSampled).bind(
        1,
        sum.current,
        Access::ComputeWrite,
    ));
    let plan = planned(&frame);
    let read = transition(sum.previous, (ImageLayout::GENERAL, SAMPLED), COMPUTE_WRITE, COMPUTE_SAMPLED);
    let order = (Stage::COMPUTE_SHADER, Mask::NONE);
    let renew = transition(sum.current, (NO_LAYOUT, ImageLayout::GENERAL), order, COMPUTE_WRITE);
    assert_eq!(plan.passes[0].barriers, [read, renew]);
    assert_eq!(plan.initial, [(sum.previous.level(0), ImageLayout::GENERAL)], "what is written comes without contents");
}

#[test]
fn what_the_frame_before_has_read_itself_needs_no_barrier() {
    let mut frame = Graph::new();
    let radiance = frame.history_image("radiance", color());
    let blend = pass("blend").bind(0, radiance.previous, Access::FragmentSampled);
    frame.add_pass(blend.uses(radiance.current, Access::ColorAttachmentWrite));
    frame.add_pass(pass("show").bind(0, radiance.current, Access::FragmentSampled));
    let plan = planned(&frame);
    let attachment = ImageLayout::COLOR_ATTACHMENT_OPTIMAL;
    let order = (Stage::FRAGMENT_SHADER, Mask::NONE);
    let draw = transition(radiance.current, (NO_LAYOUT, attachment), order, COLOR_WRITE);
    let show = transition(radiance.current, (attachment, SAMPLED), COLOR_WRITE, FRAGMENT_SAMPLED);
    assert_eq!(plan.passes[0].barriers, [draw]);
    assert_eq!(plan.passes[1].barriers, [show]);
    assert_eq!(plan.initial, [(radiance.previous.level(0), SAMPLED)]);
}

/// A frame with a buffer and an image that each frame hands to the next.
fn two_histories() -> Frame {
    let mut frame = Graph::new();
    let count = frame.history_buffer("count", 64);
    let sum = frame.history_image("sum", color());
    let lights = frame.transient_buffer("lights", 64);
    frame.add_pass(pass("trace").bind(0, lights, Access::ComputeWrite));
    let add = pass("add").bind(0, lights, Access::ComputeRead).bind(1, sum.previous, Access::ComputeSampled);
    let add = add.bind(2, sum.current, Access::ComputeWrite).bind(3, count.previous, Access::ComputeRead);
    frame.add_pass(add.bind(4, count.current, Access::ComputeWrite));
    frame.add_pass(pass("show").bind(0, sum.current, Access::FragmentSampled));
    frame
}

#[test]
fn every_barrier_of_a_history_is_missed() {
    let frame = two_histories();
    let mut plan = planned(&frame);
    for hoisted in [false, true] {
        if hoisted {
            hoist(&mut plan, &frame);
            checker::check(&frame, &plan, None).expect("moved barriers leave no hazards");
        }
        let mut removed = 0;
        for pass in 0..plan.passes.len() {
            for barrier in 0..plan.passes[pass].barriers.len() {
                let mut broken = plan.clone();
                let gone = broken.passes[pass].barriers.remove(barrier);
                assert!(checker::check(&frame, &broken, None).is_err(), "nobody misses {gone:?}");
                removed += 1;
            }
        }
        assert_eq!(removed, 7);
    }
    let mut broken = plan.clone();
    broken.initial.clear();
    let hazard = checker::check(&frame, &broken, None).expect_err("the first frame's layout");
    assert!(hazard.contains("frame 0"), "{hazard}");
}

#[test]
fn what_was_before_is_only_read_and_what_comes_is_always_written() {
    let refused = |change: &dyn Fn(&mut Frame)| {
        let mut frame = Graph::new();
        change(&mut frame);
        plan(&frame).expect_err("a wrong history")
    };
    let write_previous = refused(&|frame| {
        let count = frame.history_buffer("count", 64);
        frame.add_pass(pass("add").bind(0, count.previous, Access::ComputeReadWrite));
    });
    assert_eq!(
        write_previous,
        PlanError::WriteToPrevious { pass: "add".to_owned(), resource: "previous_count".to_owned() }
    );
    let never_written = refused(&|frame| {
        let count = frame.history_buffer("count", 64);
        frame.add_pass(pass("show").bind(0, count.previous, Access::ComputeRead));
    });
    assert_eq!(never_written, PlanError::HistoryNotWritten { resource: "count".to_owned() });
    let too_old = refused(&|frame| {
        let count = frame.history_buffer("count", 64);
        frame.add_pass(pass("add").bind(0, count.current, Access::ComputeReadWrite));
    });
    assert_eq!(too_old, PlanError::ReadBeforeWrite { pass: "add".to_owned(), resource: "count".to_owned() });
}

#[test]
fn the_drawing_says_which_is_which() {
    let frame = two_histories();
    let dot = to_dot(&frame, &planned(&frame));
    for label in ["previous_count\\n64 bytes\\nof the frame before", "count\\n64 bytes\\nfor the next frame"] {
        assert!(dot.contains(&format!("label=\"{label}\"")), "`{label}` is missing from\n{dot}");
    }
}

#[test]
fn both_of_a_pair_can_be_used_in_either_place() {
    let mut frame = Graph::new();
    let sum = frame.history_image("sum", color());
    frame.add_pass(pass("add").bind(0, sum.previous, Access::ComputeSampled).bind(
        1,
        sum.current,
        Access::ComputeWrite,
    ));
    let both = ImageUsageFlags::SAMPLED | ImageUsageFlags::STORAGE;
    assert_eq!([sum.previous, sum.current].map(|image| frame.image_usage(image)), [both; 2]);
}
