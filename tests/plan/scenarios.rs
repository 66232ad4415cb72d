//! Small frames and the exact barriers they must get.

use ash::vk::{AccessFlags2 as Mask, BufferUsageFlags, ImageLayout, ImageUsageFlags, PipelineStageFlags2 as Stage};
use gridlight::graph::{Access, Barrier, Graph, Plan, to_dot};

use crate::{color, depth, memory, pass, planned, transition};

const NO_LAYOUT: ImageLayout = ImageLayout::UNDEFINED;
const COMPUTE_READ: (Stage, Mask) = (Stage::COMPUTE_SHADER, Mask::SHADER_STORAGE_READ);
const COMPUTE_WRITE: (Stage, Mask) = (Stage::COMPUTE_SHADER, Mask::SHADER_STORAGE_WRITE);
const COMPUTE_SAMPLED: (Stage, Mask) = (Stage::COMPUTE_SHADER, Mask::SHADER_SAMPLED_READ);
const FRAGMENT_READ: (Stage, Mask) = (Stage::FRAGMENT_SHADER, Mask::SHADER_STORAGE_READ);
const FRAGMENT_SAMPLED: (Stage, Mask) = (Stage::FRAGMENT_SHADER, Mask::SHADER_SAMPLED_READ);
const COLOR_WRITE: (Stage, Mask) = (Stage::COLOR_ATTACHMENT_OUTPUT, Mask::COLOR_ATTACHMENT_WRITE);
const FILL: (Stage, Mask) = (Stage::ALL_TRANSFER, Mask::TRANSFER_WRITE);

fn barriers(plan: &Plan) -> Vec<&[Barrier]> {
    plan.passes.iter().map(|pass| pass.barriers.as_slice()).collect()
}

fn only_order(stages: Stage) -> (Stage, Mask) {
    (stages, Mask::NONE)
}

#[test]
fn write_then_read_and_the_next_frame() {
    let mut frame = Graph::new();
    let buffer = frame.transient_buffer("counts", 64);
    frame.add_pass(pass("count").bind(0, buffer, Access::ComputeWrite));
    frame.add_pass(pass("shade").bind(0, buffer, Access::FragmentRead));
    let plan = planned(&frame);
    let wrap = memory(buffer, NO_LAYOUT, only_order(Stage::FRAGMENT_SHADER), COMPUTE_WRITE);
    let read = memory(buffer, NO_LAYOUT, COMPUTE_WRITE, FRAGMENT_READ);
    assert_eq!(barriers(&plan), [&[wrap], &[read]]);
    assert_eq!(plan.lifetimes, [Some((0, 1))]);
    assert_eq!(plan.barrier_count(), 2);
}

#[test]
fn reads_only_need_no_barrier() {
    let mut frame = Graph::new();
    let scene = frame.imported_buffer("vertices");
    let kept = frame.persistent_buffer("table", 64);
    let unused = frame.transient_buffer("unused", 64);
    for name in ["a", "b"] {
        frame.add_pass(pass(name).uses(scene, Access::VertexBuffer).bind(0, kept, Access::ComputeRead).bind(
            1,
            kept,
            Access::GraphicsRead,
        ));
    }
    let plan = planned(&frame);
    assert_eq!(plan.barrier_count(), 0);
    assert_eq!(plan.lifetimes[gridlight::graph::Handle::from(unused).index()], None);
}

#[test]
fn each_new_reader_gets_one_barrier() {
    let mut frame = Graph::new();
    let buffer = frame.transient_buffer("lights", 64);
    frame.add_pass(pass("write").bind(0, buffer, Access::ComputeWrite));
    frame.add_pass(pass("read").bind(0, buffer, Access::ComputeRead));
    frame.add_pass(pass("again").bind(0, buffer, Access::ComputeRead));
    frame.add_pass(pass("elsewhere").bind(0, buffer, Access::FragmentRead));
    frame.add_pass(pass("back").bind(0, buffer, Access::ComputeRead).bind(1, buffer, Access::FragmentRead));
    frame.add_pass(pass("otherwise").bind(0, buffer, Access::ComputeUniform));
    let plan = planned(&frame);
    let readers = only_order(Stage::COMPUTE_SHADER | Stage::FRAGMENT_SHADER);
    let wrap = memory(buffer, NO_LAYOUT, readers, COMPUTE_WRITE);
    let read = memory(buffer, NO_LAYOUT, COMPUTE_WRITE, COMPUTE_READ);
    let elsewhere = memory(buffer, NO_LAYOUT, COMPUTE_WRITE, FRAGMENT_READ);
    let otherwise = memory(buffer, NO_LAYOUT, COMPUTE_WRITE, (Stage::COMPUTE_SHADER, Mask::UNIFORM_READ));
    assert_eq!(barriers(&plan), [&[wrap][..], &[read], &[], &[elsewhere], &[], &[otherwise]]);
}

#[test]
fn write_after_write() {
    let mut frame = Graph::new();
    let buffer = frame.persistent_buffer("counts", 64);
    frame.add_pass(pass("fill").uses(buffer, Access::TransferWrite));
    frame.add_pass(pass("overwrite").bind(0, buffer, Access::ComputeWrite));
    let plan = planned(&frame);
    let wrap = memory(buffer, NO_LAYOUT, COMPUTE_WRITE, FILL);
    let overwrite = memory(buffer, NO_LAYOUT, FILL, COMPUTE_WRITE);
    assert_eq!(barriers(&plan), [&[wrap], &[overwrite]]);
}

#[test]
fn write_after_read_only_waits() {
    let mut frame = Graph::new();
    let buffer = frame.persistent_buffer("history", 64);
    frame.add_pass(pass("use").bind(0, buffer, Access::ComputeRead));
    frame.add_pass(pass("draw").bind(0, buffer, Access::FragmentRead));
    frame.add_pass(pass("renew").uses(buffer, Access::TransferWrite));
    let plan = planned(&frame);
    let wrap = memory(buffer, NO_LAYOUT, FILL, COMPUTE_READ);
    let draw = memory(buffer, NO_LAYOUT, FILL, FRAGMENT_READ);
    let renew = memory(buffer, NO_LAYOUT, only_order(Stage::COMPUTE_SHADER | Stage::FRAGMENT_SHADER), FILL);
    assert_eq!(barriers(&plan), [&[wrap], &[draw], &[renew]]);
}

#[test]
fn read_write_chain_across_frames() {
    let mut frame = Graph::new();
    let buffer = frame.persistent_buffer("sum", 64);
    frame.add_pass(pass("add").bind(0, buffer, Access::ComputeReadWrite));
    let plan = planned(&frame);
    let both = (Stage::COMPUTE_SHADER, Mask::SHADER_STORAGE_READ | Mask::SHADER_STORAGE_WRITE);
    assert_eq!(barriers(&plan), [&[memory(buffer, NO_LAYOUT, COMPUTE_WRITE, both)]]);
}

#[test]
fn layouts_from_sampled_to_storage_to_attachment() {
    let mut frame = Graph::new();
    let image = frame.persistent_image("radiance", color());
    frame.add_pass(pass("sample").bind(0, image, Access::FragmentSampled));
    frame.add_pass(pass("filter").bind(0, image, Access::ComputeReadWrite));
    frame.add_pass(pass("draw").uses(image, Access::ColorAttachmentBlend));
    let plan = planned(&frame);
    let (sampled, attachment) = (ImageLayout::SHADER_READ_ONLY_OPTIMAL, ImageLayout::COLOR_ATTACHMENT_OPTIMAL);
    let wrap = transition(image, (attachment, sampled), COLOR_WRITE, FRAGMENT_SAMPLED);
    let filter = transition(
        image,
        (sampled, ImageLayout::GENERAL),
        only_order(Stage::FRAGMENT_SHADER),
        (Stage::COMPUTE_SHADER, Mask::SHADER_STORAGE_READ | Mask::SHADER_STORAGE_WRITE),
    );
    let draw = transition(
        image,
        (ImageLayout::GENERAL, attachment),
        COMPUTE_WRITE,
        (Stage::COLOR_ATTACHMENT_OUTPUT, Mask::COLOR_ATTACHMENT_READ | Mask::COLOR_ATTACHMENT_WRITE),
    );
    assert_eq!(barriers(&plan), [&[wrap], &[filter], &[draw]]);
    assert_eq!(plan.initial, [(image.level(0), attachment)]);
}

#[test]
fn readers_after_a_transition_follow_it() {
    let mut frame = Graph::new();
    let image = frame.transient_image("albedo", color());
    frame.add_pass(pass("draw").uses(image, Access::ColorAttachmentWrite));
    frame.add_pass(pass("shade").bind(0, image, Access::ComputeSampled));
    frame.add_pass(pass("show").bind(0, image, Access::FragmentSampled));
    let plan = planned(&frame);
    let (sampled, attachment) = (ImageLayout::SHADER_READ_ONLY_OPTIMAL, ImageLayout::COLOR_ATTACHMENT_OPTIMAL);
    let readers = only_order(Stage::COMPUTE_SHADER | Stage::FRAGMENT_SHADER);
    let wrap = transition(image, (NO_LAYOUT, attachment), readers, COLOR_WRITE);
    let shade = transition(image, (attachment, sampled), COLOR_WRITE, COMPUTE_SAMPLED);
    let show = memory(image, sampled, only_order(Stage::COMPUTE_SHADER), FRAGMENT_SAMPLED);
    assert_eq!(barriers(&plan), [&[wrap], &[shade], &[show]]);
    assert_eq!(plan.initial, []);
}

#[test]
fn indirect_arguments_written_by_compute() {
    let mut frame = Graph::new();
    let arguments = frame.transient_buffer("arguments", 12);
    frame.add_pass(pass("args").bind(0, arguments, Access::ComputeWrite));
    frame.add_pass(pass("dispatch").uses(arguments, Access::IndirectRead));
    let plan = planned(&frame);
    let wrap = memory(arguments, NO_LAYOUT, only_order(Stage::DRAW_INDIRECT), COMPUTE_WRITE);
    let read = memory(arguments, NO_LAYOUT, COMPUTE_WRITE, (Stage::DRAW_INDIRECT, Mask::INDIRECT_COMMAND_READ));
    assert_eq!(barriers(&plan), [&[wrap], &[read]]);
    assert_eq!(frame.buffer_usage(arguments), BufferUsageFlags::STORAGE_BUFFER | BufferUsageFlags::INDIRECT_BUFFER);
}

#[test]
fn depth_written_then_tested_and_sampled() {
    let mut frame = Graph::new();
    let image = frame.transient_image("depth", depth());
    frame.add_pass(pass("gbuffer").uses(image, Access::DepthAttachmentWrite));
    frame.add_pass(pass("decals").bind(0, image, Access::DepthAttachmentReadSampled));
    frame.add_pass(pass("points").uses(image, Access::DepthAttachmentRead));
    frame.add_pass(pass("shade").bind(0, image, Access::ComputeSampled));
    let plan = planned(&frame);
    let tests = Stage::EARLY_FRAGMENT_TESTS | Stage::LATE_FRAGMENT_TESTS;
    let (read, write) = (Mask::DEPTH_STENCIL_ATTACHMENT_READ, Mask::DEPTH_STENCIL_ATTACHMENT_WRITE);
    let attachment = ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
    let tested = ImageLayout::DEPTH_STENCIL_READ_ONLY_OPTIMAL;
    let wrap = transition(image, (NO_LAYOUT, attachment), only_order(Stage::COMPUTE_SHADER), (tests, read | write));
    let decals = transition(
        image,
        (attachment, tested),
        (tests, write),
        (tests | Stage::FRAGMENT_SHADER, read | Mask::SHADER_SAMPLED_READ),
    );
    let shade = transition(
        image,
        (tested, ImageLayout::SHADER_READ_ONLY_OPTIMAL),
        only_order(tests | Stage::FRAGMENT_SHADER),
        COMPUTE_SAMPLED,
    );
    assert_eq!(barriers(&plan), [&[wrap][..], &[decals], &[], &[shade]]);
    let usage = ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT | ImageUsageFlags::SAMPLED;
    assert_eq!(frame.image_usage(image), usage);
}

#[test]
fn one_pass_using_a_resource_twice_gets_one_barrier() {
    let mut frame = Graph::new();
    let buffer = frame.persistent_buffer("particles", 64);
    frame.add_pass(pass("fill").uses(buffer, Access::TransferWrite));
    frame.add_pass(pass("draw").bind(0, buffer, Access::VertexRead).uses(buffer, Access::IndirectRead));
    let plan = planned(&frame);
    let stages = Stage::VERTEX_SHADER | Stage::DRAW_INDIRECT;
    let wrap = memory(buffer, NO_LAYOUT, only_order(stages), FILL);
    let draw = memory(buffer, NO_LAYOUT, FILL, (stages, Mask::SHADER_STORAGE_READ | Mask::INDIRECT_COMMAND_READ));
    assert_eq!(barriers(&plan), [&[wrap], &[draw]]);
}

#[test]
fn read_back_by_the_host() {
    let mut frame = Graph::new();
    let image = frame.persistent_image("radiance", color());
    let buffer = frame.persistent_buffer("readback", 64);
    frame.add_pass(pass("copy").uses(image, Access::TransferRead).uses(buffer, Access::TransferWrite));
    frame.add_pass(pass("host").uses(buffer, Access::HostRead));
    let plan = planned(&frame);
    let wrap = memory(buffer, NO_LAYOUT, only_order(Stage::HOST), FILL);
    let host = memory(buffer, NO_LAYOUT, FILL, (Stage::HOST, Mask::HOST_READ));
    assert_eq!(barriers(&plan), [&[wrap], &[host]]);
    assert_eq!(plan.initial, [(image.level(0), ImageLayout::TRANSFER_SRC_OPTIMAL)]);
}

#[test]
fn drawing_names_everything() {
    let mut frame = Graph::new();
    let buffer = frame.transient_buffer("cell \"counts\"", 4096);
    let image = frame.persistent_image("radiance", color());
    frame.add_pass(pass("count").bind(2, buffer, Access::ComputeWrite));
    frame.add_pass(pass("shade").bind(0, buffer, Access::FragmentRead).uses(image, Access::ColorAttachmentBlend));
    let dot = to_dot(&frame, &planned(&frame));
    for line in [
        r#"r0 [shape=ellipse, style=dashed, label="cell \"counts\"\n4096 bytes\ntransient"];"#,
        r#"r1 [shape=ellipse, style=solid, label="radiance\n64x32 R16G16B16A16_SFLOAT\npersistent"];"#,
        r#"p0 [shape=box, label="count\n1 barrier"];"#,
        r#"p1 [shape=box, label="shade\n2 barriers"];"#,
        r#"p0 -> r0 [label="ComputeWrite @2"];"#,
        r#"r0 -> p1 [label="FragmentRead @0"];"#,
        r#"r1 -> p1 [label="ColorAttachmentBlend"];"#,
        r#"p1 -> r1 [label="ColorAttachmentBlend"];"#,
    ] {
        assert!(dot.contains(line), "`{line}` is missing from\n{dot}");
    }
}

#[test]
fn a_repeated_pass_waits_for_its_own_writes() {
    let mut frame = Graph::new();
    let sum = frame.persistent_image("sum", color());
    let counts = frame.persistent_buffer("counts", 64);
    let lights = frame.transient_buffer("lights", 64);
    frame.add_pass(pass("trace").bind(0, lights, Access::ComputeWrite));
    let shade = pass("shade").bind(0, lights, Access::ComputeRead).bind(1, sum, Access::ComputeReadWrite);
    frame.add_pass(shade.bind(2, counts, Access::ComputeWrite).repeated());
    let plan = planned(&frame);
    let both = (Stage::COMPUTE_SHADER, Mask::SHADER_STORAGE_READ | Mask::SHADER_STORAGE_WRITE);
    let general = ImageLayout::GENERAL;
    let between = [memory(sum, general, COMPUTE_WRITE, both), memory(counts, NO_LAYOUT, COMPUTE_WRITE, COMPUTE_WRITE)];
    assert_eq!(plan.passes[1].between, between, "what it only reads needs no barrier");
    assert!(plan.passes[0].between.is_empty(), "other passes run once");
}

#[test]
fn an_acquired_image_is_another_one_in_every_frame() {
    let mut frame = Graph::new();
    let picture = frame.transient_image("picture", color());
    let shown = frame.acquired_image("window", color());
    frame.add_pass(pass("shade").bind(0, picture, Access::ComputeWrite));
    let draw = pass("draw").bind(0, picture, Access::FragmentSampled);
    frame.add_pass(draw.uses(shown, Access::ColorAttachmentWrite));
    frame.add_pass(pass("panel").uses(shown, Access::ColorAttachmentBlend));
    frame.add_pass(pass("present").uses(shown, Access::Present));
    let plan = planned(&frame);
    let attachment = ImageLayout::COLOR_ATTACHMENT_OPTIMAL;
    // The stage at which the acquisition's semaphore is waited for; the contents are dropped in every frame.
    let acquired = only_order(Stage::COLOR_ATTACHMENT_OUTPUT);
    let first = transition(shown, (NO_LAYOUT, attachment), acquired, COLOR_WRITE);
    assert!(plan.passes[1].barriers.contains(&first), "{:?}", plan.passes[1]);
    let blend = (COLOR_WRITE.0, Mask::COLOR_ATTACHMENT_READ | Mask::COLOR_ATTACHMENT_WRITE);
    assert_eq!(plan.passes[2].barriers, [memory(shown, attachment, COLOR_WRITE, blend)]);
    let last =
        transition(shown, (attachment, ImageLayout::PRESENT_SRC_KHR), COLOR_WRITE, only_order(Stage::ALL_COMMANDS));
    assert_eq!(plan.passes[3].barriers, [last]);
    assert!(plan.initial.is_empty());
}

#[test]
fn a_continued_image_goes_on_where_another_graph_left_it() {
    let mut frame = Graph::new();
    let picture = frame.transient_image("picture", color());
    let shown = frame.continued_image("window", color());
    frame.add_pass(pass("shade").bind(0, picture, Access::ComputeWrite));
    let draw = pass("draw").bind(0, picture, Access::FragmentSampled);
    frame.add_pass(draw.uses(shown, Access::ColorAttachmentBlend));
    frame.add_pass(pass("present").uses(shown, Access::Present));
    let plan = planned(&frame);
    let attachment = ImageLayout::COLOR_ATTACHMENT_OPTIMAL;
    // What the other graph has drawn is kept and waited for, in every frame.
    let blend = (COLOR_WRITE.0, Mask::COLOR_ATTACHMENT_READ | Mask::COLOR_ATTACHMENT_WRITE);
    let first = memory(shown, attachment, COLOR_WRITE, blend);
    assert!(plan.passes[1].barriers.contains(&first), "{:?}", plan.passes[1]);
    let last =
        transition(shown, (attachment, ImageLayout::PRESENT_SRC_KHR), COLOR_WRITE, only_order(Stage::ALL_COMMANDS));
    assert_eq!(plan.passes[2].barriers, [last]);
}

#[test]
fn a_readback_buffer_is_another_one_for_each_frame_in_flight() {
    let mut frame = Graph::new();
    let counts = frame.persistent_buffer("counts", 64);
    let host = frame.readback_buffer("host", 64);
    frame.add_pass(pass("count").bind(0, counts, Access::ComputeWrite));
    frame.add_pass(pass("copy").uses(counts, Access::TransferRead).uses(host, Access::TransferWrite));
    frame.add_pass(pass("read").uses(host, Access::HostRead));
    let plan = planned(&frame);
    let of_host = |pass: usize| plan.passes[pass].barriers.iter().filter(|b| b.resource == host.into()).count();
    // The frame before has another buffer, so that nothing waits for the host to have read it.
    assert_eq!((of_host(1), of_host(2)), (0, 1), "{:?}", plan.passes);
    let visible = plan.passes[2].barriers[0];
    assert_eq!((visible.dst_stage, visible.dst_access), (Stage::HOST, Mask::HOST_READ));
}
