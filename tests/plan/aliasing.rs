//! Memory shared between transients.

use ash::vk::{AccessFlags2 as Mask, ImageLayout, PipelineStageFlags2 as Stage};
use gridlight::graph::{Access, Graph, MemoryBarrier, Placement, Requirement, add_alias_barriers, assign};

use crate::{Lcg, checker, color, memory, pass, planned, transition};

fn requirement(size_bytes: u64, alignment: u64, class: u32) -> Option<Requirement> {
    Some(Requirement { size_bytes, alignment, class })
}

#[test]
fn disjoint_lifetimes_share() {
    let alias = assign(
        &[Some((0, 1)), Some((2, 3)), Some((4, 4)), None, Some((0, 4))],
        &[requirement(100, 64, 0), requirement(300, 64, 0), requirement(200, 64, 0), requirement(50, 64, 0), None],
    );
    let start = Some(Placement { class: 0, offset_bytes: 0 });
    assert_eq!(alias.placements, [start, start, start, None, None]);
    assert_eq!(alias.aliased_bytes(), 300);
    assert_eq!(alias.unaliased_bytes, 128 + 320 + 256);
}

#[test]
fn gaps_are_filled_and_classes_kept_apart() {
    let alias = assign(
        &[Some((0, 3)), Some((0, 1)), Some((2, 3)), Some((3, 3)), Some((0, 3))],
        &[
            requirement(400, 256, 0),
            requirement(300, 256, 0),
            requirement(100, 16, 0),
            requirement(60, 64, 0),
            requirement(10, 1, 7),
        ],
    );
    let at = |offset_bytes| Some(Placement { class: 0, offset_bytes });
    let apart = Some(Placement { class: 7, offset_bytes: 0 });
    assert_eq!(alias.placements, [at(0), at(512), at(400), at(512), apart]);
    assert_eq!(alias.class_sizes.into_iter().collect::<Vec<_>>(), [(0, 812), (7, 10)]);
}

#[test]
fn no_two_live_resources_overlap() {
    let mut random = Lcg(3);
    for round in 0..3000 {
        let count = 1 + random.below(16);
        let lifetimes: Vec<_> = (0..count)
            .map(|_| {
                let first = random.below(12);
                (random.below(8) > 0).then(|| (first, first + random.below(5)))
            })
            .collect();
        let requirements: Vec<_> = (0..count)
            .map(|_| {
                let size_bytes = 1 + random.below(5000) as u64;
                requirement(size_bytes, 1 << random.below(13), random.below(2) as u32).filter(|_| random.below(8) > 0)
            })
            .collect();
        let alias = assign(&lifetimes, &requirements);
        let mut sizes = std::collections::BTreeMap::new();
        for a in 0..count {
            let (Some(life_a), Some(need_a)) = (lifetimes[a], requirements[a]) else {
                assert_eq!(alias.placements[a], None, "round {round}");
                continue;
            };
            let at_a = alias.placements[a].expect("everything used is placed");
            let end_a = at_a.offset_bytes + need_a.size_bytes;
            assert_eq!(at_a.class, need_a.class, "round {round}");
            assert_eq!(at_a.offset_bytes % need_a.alignment, 0, "round {round}");
            let size = sizes.entry(at_a.class).or_insert(0);
            *size = end_a.max(*size);
            for b in a + 1..count {
                let (Some(life_b), Some(need_b), Some(at_b)) = (lifetimes[b], requirements[b], alias.placements[b])
                else {
                    continue;
                };
                let alive = (life_a.0..=life_a.1).any(|pass| (life_b.0..=life_b.1).contains(&pass));
                let apart = end_a <= at_b.offset_bytes || at_b.offset_bytes + need_b.size_bytes <= at_a.offset_bytes;
                assert!(!alive || at_a.class != at_b.class || apart, "round {round}: {a} and {b} overlap");
            }
        }
        assert_eq!(alias.class_sizes, sizes, "round {round}");
    }
}

#[test]
fn first_use_waits_for_what_lay_there_before() {
    let mut frame = Graph::new();
    let image = frame.transient_image("image", color());
    let buffer = frame.transient_buffer("buffer", 64);
    frame.add_pass(pass("draw").uses(image, Access::ColorAttachmentWrite));
    frame.add_pass(pass("show").bind(0, image, Access::FragmentSampled));
    frame.add_pass(pass("fill").uses(buffer, Access::TransferWrite));
    frame.add_pass(pass("sum").bind(0, buffer, Access::ComputeReadWrite));
    let mut plan = planned(&frame);
    let requirements = [requirement(64, 64, 0), requirement(64, 64, 0)];
    let alias = assign(&plan.lifetimes, &requirements);
    assert_eq!(alias.aliased_bytes(), 64);
    let placed = Some((&alias, requirements.as_slice()));
    assert!(checker::check(&frame, &plan, placed).is_err(), "shared memory needs the alias barriers");
    let unshared = plan.clone();
    add_alias_barriers(&mut plan, &frame, &requirements, &alias);
    checker::check(&frame, &plan, placed).expect("with them there is no hazard");
    // The image's transition is ordered after the buffer's last use; the memory barrier has the memory side.
    assert_eq!(
        plan.passes[0].barriers,
        [transition(
            image,
            (ImageLayout::UNDEFINED, ImageLayout::COLOR_ATTACHMENT_OPTIMAL),
            (Stage::FRAGMENT_SHADER | Stage::COMPUTE_SHADER, Mask::SHADER_STORAGE_WRITE),
            (Stage::COLOR_ATTACHMENT_OUTPUT, Mask::COLOR_ATTACHMENT_WRITE),
        )]
    );
    let of_buffer = MemoryBarrier {
        src_stage: Stage::COMPUTE_SHADER,
        src_access: Mask::SHADER_STORAGE_WRITE,
        dst_stage: Stage::COLOR_ATTACHMENT_OUTPUT,
        dst_access: Mask::COLOR_ATTACHMENT_WRITE,
    };
    // The image was last read, after a transition that made all it held available.
    let of_image = MemoryBarrier {
        src_stage: Stage::FRAGMENT_SHADER,
        src_access: Mask::NONE,
        dst_stage: Stage::ALL_TRANSFER,
        dst_access: Mask::TRANSFER_WRITE,
    };
    let takeovers: Vec<_> = plan.passes.iter().map(|pass| pass.takeover).collect();
    assert_eq!(takeovers, [Some(of_buffer), None, Some(of_image), None]);
    assert_eq!(plan.passes[2].barriers, unshared.passes[2].barriers, "a buffer's own barrier stays as it is");
    for index in [0, 2] {
        let mut broken = plan.clone();
        broken.passes[index].takeover = None;
        assert!(checker::check(&frame, &broken, placed).is_err(), "nobody misses the memory barrier of pass {index}");
    }
}

#[test]
fn a_barrier_of_one_resource_says_nothing_of_another() {
    let mut frame = Graph::new();
    let first = frame.transient_buffer("first", 64);
    let second = frame.transient_buffer("second", 64);
    frame.add_pass(pass("fill").uses(first, Access::TransferWrite));
    frame.add_pass(pass("sum").bind(0, second, Access::ComputeWrite));
    let mut plan = planned(&frame);
    let requirements = [requirement(64, 64, 0), requirement(64, 64, 0)];
    let alias = assign(&plan.lifetimes, &requirements);
    add_alias_barriers(&mut plan, &frame, &requirements, &alias);
    let placed = Some((&alias, requirements.as_slice()));
    checker::check(&frame, &plan, placed).expect("memory barriers between the two");
    // The same scopes as a barrier of the second buffer: what the first wrote stays unavailable.
    let MemoryBarrier { src_stage, src_access, dst_stage, dst_access } = plan.passes[1].takeover.take().unwrap();
    let own = memory(second, ImageLayout::UNDEFINED, (src_stage, src_access), (dst_stage, dst_access));
    plan.passes[1].barriers = vec![own];
    let hazard = checker::check(&frame, &plan, placed).expect_err("the planted fault");
    assert!(hazard.contains("not available"), "{hazard}");
}
