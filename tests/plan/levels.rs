//! Images with mip levels, layers and three dimensions: each level is tracked for itself.

use ash::vk::{AccessFlags2 as Mask, ImageLayout, PipelineStageFlags2 as Stage};
use gridlight::graph::{
    Access, Barrier, Graph, Handle, ImageHandle, ImageInfo, PlanError, Requirement, add_alias_barriers, assign, hoist,
    plan, to_dot,
};

use crate::{Frame, checker, color, depth, pass, planned, transition};

const SAMPLED: ImageLayout = ImageLayout::SHADER_READ_ONLY_OPTIMAL;
const WRITTEN: (Stage, Mask) = (Stage::COMPUTE_SHADER, Mask::SHADER_STORAGE_WRITE);
const READ: (Stage, Mask) = (Stage::COMPUTE_SHADER, Mask::SHADER_SAMPLED_READ);

/// A pyramid of three levels, each made from the one before, then sampled as a whole.
fn pyramid(frame: &mut Frame, info: ImageInfo) -> ImageHandle {
    let image = frame.transient_image("pyramid", info.with_levels(3));
    frame.add_pass(pass("base").bind(0, image.level(0), Access::ComputeWrite));
    for level in 1..3 {
        let reduce = pass(&format!("reduce to {level}")).bind(0, image.level(level - 1), Access::ComputeSampled).bind(
            1,
            image.level(level),
            Access::ComputeWrite,
        );
        frame.add_pass(reduce);
    }
    frame.add_pass(pass("use").bind(0, image, Access::ComputeSampled));
    image
}

fn of_levels(barrier: Barrier, first_level: u32, level_count: u32) -> Barrier {
    Barrier { first_level, level_count, ..barrier }
}

#[test]
fn each_level_changes_its_layout_when_it_is_its_turn() {
    for info in [color(), color().with_layers(6), color().with_depth(8)] {
        let mut frame = Graph::new();
        let image = pyramid(&mut frame, info);
        let plan = planned(&frame);
        // What all levels were last used for is the sampling at the end of the frame before.
        let begin = |level| {
            let layouts = (ImageLayout::UNDEFINED, ImageLayout::GENERAL);
            of_levels(transition(image, layouts, (Stage::COMPUTE_SHADER, Mask::NONE), WRITTEN), level, 1)
        };
        let sample = |level| of_levels(transition(image, (ImageLayout::GENERAL, SAMPLED), WRITTEN, READ), level, 1);
        let barriers: Vec<_> = plan.passes.iter().map(|pass| pass.barriers.clone()).collect();
        assert_eq!(
            barriers,
            [
                vec![begin(0)],
                vec![sample(0), begin(1)],
                vec![sample(1), begin(2)],
                // The others are already there.
                vec![sample(2)],
            ]
        );
    }
}

#[test]
fn levels_that_need_the_same_share_a_barrier() {
    let mut frame = Graph::new();
    let image = frame.persistent_image("pyramid", color().with_levels(4));
    frame.add_pass(pass("fill").uses(image, Access::TransferWrite));
    let mut draw = pass("draw");
    for level in [0, 1, 3] {
        draw.declare(image.level(level), Access::ColorAttachmentWrite);
    }
    frame.add_pass(draw);
    let plan = planned(&frame);
    let drawn = (Stage::COLOR_ATTACHMENT_OUTPUT, Mask::COLOR_ATTACHMENT_WRITE);
    let copied = (Stage::ALL_TRANSFER, Mask::TRANSFER_WRITE);
    let (attachment, target) = (ImageLayout::COLOR_ATTACHMENT_OPTIMAL, ImageLayout::TRANSFER_DST_OPTIMAL);
    let back = transition(image, (attachment, target), drawn, copied);
    let again = of_levels(transition(image, (target, target), copied, copied), 2, 1);
    assert_eq!(plan.passes[0].barriers, [of_levels(back, 0, 2), again, of_levels(back, 3, 1)]);
    let there = transition(image, (target, attachment), copied, drawn);
    assert_eq!(plan.passes[1].barriers, [of_levels(there, 0, 2), of_levels(there, 3, 1)]);
    let initial = [attachment, attachment, target, attachment];
    assert_eq!(plan.initial, (0..4).map(|level| (image.level(level), initial[level as usize])).collect::<Vec<_>>());
}

#[test]
fn every_barrier_of_a_pyramid_is_missed() {
    let mut frame = Graph::new();
    pyramid(&mut frame, color());
    for hoisted in [false, true] {
        let mut plan = planned(&frame);
        if hoisted {
            hoist(&mut plan, &frame);
            checker::check(&frame, &plan, None).expect("moved barriers leave no hazards");
        }
        for (pass, barrier) in (0..4).flat_map(|pass| (0..plan.passes[pass].barriers.len()).map(move |b| (pass, b))) {
            let mut broken = plan.clone();
            let gone = broken.passes[pass].barriers.remove(barrier);
            checker::check(&frame, &broken, None).expect_err(&format!("nobody misses {gone:?}"));
            let mut broken = plan.clone();
            let level = &mut broken.passes[pass].barriers[barrier].first_level;
            *level = (*level + 1) % 3;
            checker::check(&frame, &broken, None).expect_err(&format!("{gone:?} may be for another level"));
        }
    }
}

#[test]
fn a_later_level_takes_over_memory_too() {
    let mut frame = Graph::new();
    let buffer = frame.transient_buffer("buffer", 64);
    let image = frame.transient_image("pyramid", color().with_levels(2));
    frame.add_pass(pass("sum").bind(0, buffer, Access::ComputeWrite));
    frame.add_pass(pass("base").uses(image.level(0), Access::ColorAttachmentWrite));
    frame.add_pass(pass("copy").uses(image.level(0), Access::TransferRead).uses(image.level(1), Access::TransferWrite));
    let mut plan = planned(&frame);
    let requirement = Some(Requirement { size_bytes: 64, alignment: 64, class: 0 });
    let requirements = [requirement, requirement];
    let alias = assign(&plan.lifetimes, &requirements);
    assert_eq!(alias.aliased_bytes(), 64);
    let placed = Some((&alias, requirements.as_slice()));
    checker::check(&frame, &plan, placed).expect_err("shared memory needs the alias barriers");
    add_alias_barriers(&mut plan, &frame, &requirements, &alias);
    checker::check(&frame, &plan, placed).expect("with them there is no hazard");
    let takeovers: Vec<bool> = plan.passes.iter().map(|pass| pass.takeover.is_some()).collect();
    assert_eq!(takeovers, [true, true, false], "the image takes over all its memory at once");
    for index in 0..2 {
        let mut broken = plan.clone();
        broken.passes[index].takeover = None;
        checker::check(&frame, &broken, placed).expect_err("nobody misses a memory barrier");
    }
    let begin = plan.passes[2].barriers.iter_mut().find(|barrier| barrier.first_level == 1).expect("level 1 begins");
    assert_eq!(begin.src_stage, Stage::ALL_TRANSFER | WRITTEN.0, "of its last use, and of the buffer's");
    begin.src_stage = Stage::ALL_TRANSFER;
    let hazard = checker::check(&frame, &plan, placed).expect_err("the planted fault");
    assert!(hazard.contains("pass copy, pyramid: transition not ordered"), "{hazard}");
}

#[test]
fn a_history_keeps_its_levels() {
    let mut frame = Graph::new();
    let depths = frame.history_image("depths", depth().with_levels(2));
    frame.add_pass(pass("compare").bind(0, depths.previous, Access::ComputeSampled));
    frame.add_pass(pass("draw").uses(depths.current.level(0), Access::DepthAttachmentWrite));
    frame.add_pass(
        pass("reduce")
            .bind(0, depths.current.level(0), Access::ComputeSampled)
            .uses(depths.current.level(1), Access::DepthAttachmentWrite),
    );
    let plan = planned(&frame);
    let attachment = ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
    assert_eq!(plan.initial, [(depths.previous.level(0), SAMPLED), (depths.previous.level(1), attachment)]);
    let read = plan.passes[0].barriers.iter().map(|barrier| (barrier.levels(), barrier.old_layout));
    assert_eq!(read.collect::<Vec<_>>(), [(1..2, attachment)]);
}

fn error(make: impl FnOnce(&mut Frame)) -> PlanError {
    let mut frame = Graph::new();
    make(&mut frame);
    plan(&frame).expect_err("the graph is wrong")
}

#[test]
fn levels_that_are_not_there() {
    let wrong = error(|frame| {
        let image = frame.persistent_image("pyramid", color().with_levels(3));
        frame.add_pass(pass("reduce").bind(0, image.level(3), Access::ComputeWrite));
    });
    assert_eq!(wrong.to_string(), "pass `reduce` uses level 3 of `pyramid`, which has 3");
    let most = |info: ImageInfo| info.with_levels(99).most_levels();
    assert_eq!([most(color()), most(color().with_layers(512)), most(color().with_depth(128))], [7, 7, 8]);
    for (info, sentence) in [
        (color().with_levels(8), "image `pyramid` has 8 levels, but only 7 fit its size"),
        (color().with_levels(0), "resource `pyramid` has no size"),
        (color().with_layers(0), "resource `pyramid` has no size"),
        (color().with_depth(0), "resource `pyramid` has no size"),
    ] {
        let wrong = error(|frame| {
            frame.persistent_image("pyramid", info);
        });
        assert_eq!(wrong.to_string(), sentence);
    }
    assert_eq!(color().with_depth(9).level_size_px(3), [8, 4, 1], "each level is half as large, rounded down");
    assert_eq!(color().with_layers(9).level_size_px(6), [1, 1, 1], "and never smaller than a texel");
}

#[test]
fn uses_that_do_not_fit_an_image_of_several_levels() {
    for (access, one_level) in
        [(Access::ComputeWrite, false), (Access::ColorAttachmentWrite, false), (Access::ComputeSampled, true)]
    {
        let use_whole = |frame: &mut Frame| {
            let image: Handle = frame.persistent_image("pyramid", color().with_levels(2)).into();
            frame.add_pass(pass("reduce").uses(image, access));
        };
        let mut frame = Graph::new();
        use_whole(&mut frame);
        assert_eq!(plan(&frame).is_ok(), one_level, "{access:?}");
    }
    let not_named = error(|frame| {
        let image = frame.persistent_image("pyramid", color().with_levels(2));
        frame.add_pass(pass("reduce").bind(0, image, Access::ComputeWrite));
    });
    assert_eq!(not_named.to_string(), "pass `reduce` uses `pyramid` as ComputeWrite, which takes one of its levels");
    for info in [color().with_layers(2), color().with_depth(2)] {
        let not_flat = error(|frame| {
            let image = frame.persistent_image("stack", info);
            frame.add_pass(pass("draw").uses(image, Access::ColorAttachmentWrite));
        });
        let sentence = "pass `draw` uses `stack` as ColorAttachmentWrite, but only flat images can be attachments";
        assert_eq!(not_flat.to_string(), sentence);
    }
}

#[test]
fn a_level_is_written_before_it_is_read() {
    let half_written = error(|frame| {
        let image = frame.transient_image("pyramid", color().with_levels(2));
        frame.add_pass(pass("base").bind(0, image.level(0), Access::ComputeWrite));
        frame.add_pass(pass("use").bind(0, image, Access::ComputeSampled));
    });
    assert_eq!(half_written, PlanError::ReadBeforeWrite { pass: "use".into(), resource: "pyramid".into() });
    let conflict = error(|frame| {
        let image = frame.persistent_image("pyramid", color().with_levels(2));
        frame.add_pass(pass("reduce").bind(0, image, Access::ComputeSampled).bind(
            1,
            image.level(1),
            Access::ComputeWrite,
        ));
    });
    let (first, second) = (Access::ComputeSampled, Access::ComputeWrite);
    assert_eq!(conflict, PlanError::Conflict { pass: "reduce".into(), resource: "pyramid".into(), first, second });
    let history = error(|frame| {
        let pair = frame.history_image("depths", color().with_levels(2));
        frame.add_pass(pass("compare").bind(0, pair.previous, Access::ComputeSampled));
        frame.add_pass(pass("write").bind(0, pair.current.level(0), Access::ComputeWrite));
    });
    assert_eq!(history, PlanError::HistoryNotWritten { resource: "depths".into() });
}

#[test]
fn the_drawing_says_sizes_and_levels() {
    let mut frame = Graph::new();
    pyramid(&mut frame, color().with_depth(8));
    frame.persistent_image("stack", color().with_layers(5));
    let dot = to_dot(&frame, &planned(&frame));
    assert!(dot.contains("64x32x8, 3 levels R16G16B16A16_SFLOAT"), "{dot}");
    assert!(dot.contains("64x32, 5 layers R16G16B16A16_SFLOAT"), "{dot}");
    assert!(dot.contains("p1 -> r0 [label=\"ComputeWrite level 1 @1\"]"), "{dot}");
}
