//! Barriers moved to earlier passes, so that there are fewer batches of them.

use ash::vk::{AccessFlags2 as Mask, ImageLayout, PipelineStageFlags2 as Stage};
use gridlight::graph::{Access, Graph, Plan, Requirement, add_alias_barriers, assign, hoist};

use crate::{Frame, checker, color, memory, pass, planned};

/// The plan with its barriers moved, judged again.
fn hoisted(frame: &Frame) -> Plan {
    let mut plan = planned(frame);
    hoist(&mut plan, frame);
    checker::check(frame, &plan, None).expect("moved barriers leave no hazards");
    plan
}

/// Passes that have barriers before them, with how many.
fn batches(plan: &Plan) -> Vec<(&str, usize)> {
    let with_batch = plan.passes.iter().filter(|pass| pass.has_batch());
    with_batch.map(|pass| (pass.name.as_str(), pass.barriers.len())).collect()
}

#[test]
fn independent_passes_stand_behind_one_batch() {
    let mut frame = Graph::new();
    let names = ["a", "b", "c"];
    let buffers = names.map(|name| frame.transient_buffer(name, 64));
    for (name, buffer) in names.iter().zip(buffers) {
        frame.add_pass(pass(&format!("write {name}")).bind(0, buffer, Access::ComputeWrite));
    }
    for (name, buffer) in names.iter().zip(buffers) {
        frame.add_pass(pass(&format!("read {name}")).bind(0, buffer, Access::ComputeRead));
    }
    assert_eq!(planned(&frame).batch_count(), 6);
    let plan = hoisted(&frame);
    assert_eq!(batches(&plan), [("write a", 3), ("read a", 3)]);
    assert_eq!((plan.batch_count(), plan.barrier_count()), (2, 6));
}

#[test]
fn a_chain_keeps_its_batches() {
    let mut frame = Graph::new();
    let buffer = frame.persistent_buffer("sum", 64);
    for name in ["one", "two", "three"] {
        frame.add_pass(pass(name).bind(0, buffer, Access::ComputeReadWrite));
    }
    assert_eq!(hoisted(&frame).passes, planned(&frame).passes);
}

#[test]
fn readers_at_different_stages_share_a_barrier() {
    let mut frame = Graph::new();
    let buffer = frame.transient_buffer("lights", 64);
    frame.add_pass(pass("write").uses(buffer, Access::TransferWrite));
    frame.add_pass(pass("compute").bind(0, buffer, Access::ComputeRead));
    frame.add_pass(pass("draw").bind(0, buffer, Access::FragmentRead));
    let plan = hoisted(&frame);
    let both = (Stage::COMPUTE_SHADER | Stage::FRAGMENT_SHADER, Mask::SHADER_STORAGE_READ);
    let fill = (Stage::ALL_TRANSFER, Mask::TRANSFER_WRITE);
    assert_eq!(plan.passes[1].barriers, [memory(buffer, ImageLayout::UNDEFINED, fill, both)]);
    assert_eq!(batches(&plan), [("write", 1), ("compute", 1)]);
}

#[test]
fn a_reader_behind_a_layout_transition_waits_for_it() {
    let mut frame = Graph::new();
    let image = frame.transient_image("radiance", color());
    frame.add_pass(pass("shade").bind(0, image, Access::ComputeWrite));
    frame.add_pass(pass("filter").bind(0, image, Access::ComputeSampled));
    frame.add_pass(pass("draw").bind(0, image, Access::FragmentSampled));
    // The first reader's transition is what the second one follows: no batch is saved.
    assert_eq!(batches(&hoisted(&frame)), [("shade", 1), ("filter", 1), ("draw", 1)]);
}

#[test]
fn transitions_do_not_pass_earlier_uses() {
    let mut frame = Graph::new();
    let image = frame.persistent_image("radiance", color());
    let buffer = frame.transient_buffer("counts", 64);
    frame.add_pass(pass("draw").uses(image, Access::ColorAttachmentWrite));
    frame.add_pass(pass("count").bind(0, buffer, Access::ComputeWrite));
    frame.add_pass(pass("sum").bind(0, buffer, Access::ComputeReadWrite));
    frame.add_pass(pass("sample").bind(0, image, Access::ComputeSampled));
    assert_eq!(batches(&hoisted(&frame)), [("draw", 2), ("sum", 2)]);
}

#[test]
fn a_window_image_is_not_touched_before_its_first_pass() {
    let mut frame = Graph::new();
    let buffer = frame.transient_buffer("counts", 64);
    let shown = frame.acquired_image("window", color());
    frame.add_pass(pass("count").bind(0, buffer, Access::ComputeWrite));
    frame.add_pass(pass("draw").uses(shown, Access::ColorAttachmentWrite));
    let plan = hoisted(&frame);
    assert_eq!(batches(&plan), [("count", 1), ("draw", 1)]);
}

#[test]
fn an_imported_image_stays_as_others_find_it_until_its_own_pass() {
    let mut frame = Graph::new();
    let buffer = frame.transient_buffer("counts", 64);
    let shown = frame.imported_image("shown", color().format);
    frame.add_pass(pass("count").bind(0, buffer, Access::ComputeWrite));
    frame.add_pass(pass("sum").bind(0, buffer, Access::ComputeReadWrite));
    frame.add_pass(pass("copy").uses(shown, Access::TransferWrite));
    let plan = hoisted(&frame);
    assert_eq!(batches(&plan), [("count", 1), ("sum", 1), ("copy", 1)]);
    assert_eq!(plan.release.len(), 1, "and it is left as they find it");
}

#[test]
fn memory_is_taken_over_after_its_last_owner() {
    let mut frame = Graph::new();
    let first = frame.transient_buffer("first", 64);
    let second = frame.transient_buffer("second", 64);
    let apart = frame.persistent_buffer("apart", 64);
    frame.add_pass(pass("start").bind(0, first, Access::ComputeWrite));
    frame.add_pass(pass("finish").bind(0, first, Access::ComputeReadWrite).bind(1, apart, Access::ComputeWrite));
    frame.add_pass(pass("tell").bind(0, apart, Access::ComputeReadWrite));
    frame.add_pass(pass("again").bind(0, second, Access::ComputeWrite));
    let mut plan = planned(&frame);
    let requirement = |class| Some(Requirement { size_bytes: 64, alignment: 64, class });
    let requirements = [requirement(0), requirement(0), None];
    let alias = assign(&plan.lifetimes, &requirements);
    add_alias_barriers(&mut plan, &frame, &requirements, &alias);
    let before = plan.passes[3].takeover;
    assert!(before.is_some());
    hoist(&mut plan, &frame);
    checker::check(&frame, &plan, Some((&alias, &requirements))).expect("moved barriers leave no hazards");
    // To `tell`, which waits anyway once the memory is free, and no further.
    let takeovers: Vec<_> = plan.passes.iter().map(|pass| pass.takeover.is_some()).collect();
    assert_eq!(takeovers, [true, false, true, false]);
    assert_eq!(plan.batch_count(), 3);
}

/// Two chains of two and three passes over a buffer each; the second one's last pass uses `shared`.
fn two_chains(shared: bool) -> Frame {
    let mut frame = Graph::new();
    let [one, other] = ["one", "other"].map(|name| frame.persistent_buffer(name, 64));
    for name in ["one 1", "one 2"] {
        frame.add_pass(pass(name).bind(0, one, Access::ComputeReadWrite));
    }
    for name in ["other 1", "other 2"] {
        frame.add_pass(pass(name).bind(0, other, Access::ComputeReadWrite));
    }
    let last = if shared { one } else { other };
    frame.add_pass(pass("other 3").bind(0, last, Access::ComputeRead));
    frame
}

#[test]
fn chains_side_by_side_share_their_batches() {
    let mut frame = two_chains(false);
    assert_eq!(hoisted(&frame).batch_count(), 4);
    frame.lay_side_by_side(0, 2);
    let plan = hoisted(&frame);
    let names: Vec<_> = plan.passes.iter().map(|pass| pass.name.as_str()).collect();
    assert_eq!(names, ["one 1", "other 1", "one 2", "other 2", "other 3"]);
    assert_eq!(plan.batch_count(), 3);
}

#[test]
#[should_panic(expected = "share what one of them writes")]
fn chains_that_depend_on_each_other_do_not_go_side_by_side() {
    two_chains(true).lay_side_by_side(0, 2);
}
