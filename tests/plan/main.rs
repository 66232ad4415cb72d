//! The frame plan, checked without a device: exact barriers, errors, aliasing, and an independent hazard checker.

mod aliasing;
mod checker;
mod errors;
mod history;
mod hoisting;
mod imported;
mod kept;
mod levels;
mod random;
mod scenarios;

use ash::vk::{AccessFlags2 as Mask, Format, ImageLayout, PipelineStageFlags2 as Stage};
use gridlight::graph::{Barrier, Graph, Handle, ImageInfo, Pass, Plan, plan};

/// A graph whose passes record nothing.
type Frame = Graph<()>;

fn pass(name: &str) -> Pass<()> {
    Pass::new(name, ())
}

fn color() -> ImageInfo {
    ImageInfo::new(Format::R16G16B16A16_SFLOAT, 64, 32)
}

fn depth() -> ImageInfo {
    ImageInfo::new(Format::D32_SFLOAT, 64, 32)
}

/// A plan that the checker has passed.
fn planned(frame: &Frame) -> Plan {
    let plan = plan(frame).expect("the graph is right");
    checker::check(frame, &plan, None).expect("the plan has no hazards");
    plan
}

/// A barrier that changes no layout.
fn memory(resource: impl Into<Handle>, layout: ImageLayout, src: (Stage, Mask), dst: (Stage, Mask)) -> Barrier {
    transition(resource, (layout, layout), src, dst)
}

fn transition(
    resource: impl Into<Handle>,
    layouts: (ImageLayout, ImageLayout),
    src: (Stage, Mask),
    dst: (Stage, Mask),
) -> Barrier {
    Barrier {
        resource: resource.into(),
        first_level: 0,
        level_count: 1,
        src_stage: src.0,
        src_access: src.1,
        dst_stage: dst.0,
        dst_access: dst.1,
        old_layout: layouts.0,
        new_layout: layouts.1,
    }
}

/// The linear congruential generator of Knuth's MMIX, high bits only.
struct Lcg(u64);

impl Lcg {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) % end as u64) as usize
    }
}
