//! What is owned outside the graph and shared with every other graph on the queue: the scene.

use ash::vk::{AccessFlags2 as Mask, Format, ImageLayout, PipelineStageFlags2 as Stage};
use gridlight::graph::{Access, Graph, Plan, hoist, to_dot};

use crate::{Frame, checker, memory, pass, planned, transition};

const NO_LAYOUT: ImageLayout = ImageLayout::UNDEFINED;
const SAMPLED: ImageLayout = ImageLayout::SHADER_READ_ONLY_OPTIMAL;
const COMPUTE_WRITE: (Stage, Mask) = (Stage::COMPUTE_SHADER, Mask::SHADER_STORAGE_WRITE);
const FILL: (Stage, Mask) = (Stage::ALL_TRANSFER, Mask::TRANSFER_WRITE);
/// Readers of graphs that are not known here.
const ANYONE: (Stage, Mask) = (Stage::ALL_COMMANDS, Mask::NONE);

/// Where contents become visible that graphs without a barrier of their own may read.
fn everyone() -> (Stage, Mask) {
    (Stage::ALL_COMMANDS, Mask::MEMORY_READ | Mask::MEMORY_WRITE)
}

#[test]
fn a_scene_that_nobody_writes_needs_no_barrier() {
    let mut frame = Graph::new();
    let vertices = frame.imported_buffer("vertices");
    let nodes = frame.imported_image("nodes", Format::R32G32B32A32_UINT);
    frame.add_pass(pass("draw").uses(vertices, Access::VertexBuffer));
    frame.add_pass(pass("trace").uses(vertices, Access::ComputeRead).uses(nodes, Access::ComputeSampled));
    let plan = planned(&frame);
    assert_eq!((plan.barrier_count(), plan.batch_count()), (0, 0));
    assert_eq!(plan.initial, [], "its owner has brought it into its layout");
}

/// Skinned vertices that are drawn, and traced once their structure has been built anew.
fn skinning() -> (Frame, Plan) {
    let mut frame = Graph::new();
    let bones = frame.persistent_buffer("bones", 64);
    let vertices = frame.imported_buffer("vertices");
    let structure = frame.imported_buffer("structure");
    frame.add_pass(pass("skin").bind(0, bones, Access::ComputeRead).bind(1, vertices, Access::ComputeReadWrite));
    frame.add_pass(pass("draw").uses(vertices, Access::VertexBuffer));
    frame.add_pass(pass("refit").uses(vertices, Access::StructureInput).uses(structure, Access::StructureBuild));
    frame.add_pass(pass("trace").uses(vertices, Access::ComputeRead).uses(structure, Access::ComputeTrace));
    let plan = planned(&frame);
    (frame, plan)
}

#[test]
fn readers_wait_for_a_pass_that_writes_vertices() {
    let (frame, plan) = skinning();
    let handle = |name: &str| frame.buffer_named(name).unwrap();
    let (vertices, structure) = (handle("vertices"), handle("structure"));
    let both = (Stage::COMPUTE_SHADER, Mask::SHADER_STORAGE_READ | Mask::SHADER_STORAGE_WRITE);
    // Whoever read the vertices in other graphs is done; what they are like now, everybody sees who comes after.
    assert_eq!(plan.passes[0].barriers, [memory(vertices, NO_LAYOUT, ANYONE, both)]);
    assert_eq!(plan.passes[1].barriers, [memory(vertices, NO_LAYOUT, COMPUTE_WRITE, everyone())]);
    let build = (Stage::ACCELERATION_STRUCTURE_BUILD_KHR, Mask::ACCELERATION_STRUCTURE_WRITE_KHR);
    assert_eq!(plan.passes[2].barriers, [memory(structure, NO_LAYOUT, ANYONE, build)]);
    assert_eq!(plan.passes[3].barriers, [memory(structure, NO_LAYOUT, build, everyone())]);
    assert_eq!(plan.release, [], "the frame's own readers have released everything");
}

#[test]
fn every_barrier_of_a_written_scene_is_missed() {
    let (frame, mut plan) = skinning();
    for hoisted in [false, true] {
        if hoisted {
            hoist(&mut plan, &frame);
            checker::check(&frame, &plan, None).expect("moved barriers leave no hazards");
        }
        for index in 0..plan.passes.len() {
            let mut broken = plan.clone();
            if broken.passes[index].barriers.pop().is_some() {
                assert!(checker::check(&frame, &broken, None).is_err(), "nobody misses {:?}", plan.passes[index]);
            }
        }
    }
}

#[test]
fn what_nobody_reads_after_its_last_write_is_released_at_the_end() {
    let mut frame = Graph::new();
    let lights = frame.imported_buffer("lights");
    frame.add_pass(pass("shade").bind(0, lights, Access::ComputeRead));
    frame.add_pass(pass("move").uses(lights, Access::TransferWrite));
    let plan = planned(&frame);
    assert_eq!(plan.passes[0].barriers, [], "the frame before has released them");
    let readers = (Stage::ALL_COMMANDS | Stage::COMPUTE_SHADER, Mask::NONE);
    assert_eq!(plan.passes[1].barriers, [memory(lights, NO_LAYOUT, readers, FILL)]);
    assert_eq!(plan.release, [memory(lights, NO_LAYOUT, FILL, everyone())]);
    let mut broken = plan.clone();
    broken.release.clear();
    let hazard = checker::check(&frame, &broken, None).expect_err("other graphs do not see the new lights");
    assert!(hazard.contains("after its passes, lights"), "{hazard}");
}

#[test]
fn an_image_goes_back_into_the_layout_that_others_expect() {
    let mut frame = Graph::new();
    let nodes = frame.imported_image("nodes", Format::R32G32B32A32_UINT);
    frame.add_pass(pass("refit").bind(0, nodes, Access::ComputeReadWrite));
    let plan = planned(&frame);
    let both = (Stage::COMPUTE_SHADER, Mask::SHADER_STORAGE_READ | Mask::SHADER_STORAGE_WRITE);
    assert_eq!(plan.passes[0].barriers, [transition(nodes, (SAMPLED, ImageLayout::GENERAL), ANYONE, both)]);
    assert_eq!(plan.release, [transition(nodes, (ImageLayout::GENERAL, SAMPLED), COMPUTE_WRITE, everyone())]);
    frame.add_pass(pass("trace").bind(0, nodes, Access::ComputeSampled));
    let plan = planned(&frame);
    assert_eq!(
        plan.passes[1].barriers,
        [transition(nodes, (ImageLayout::GENERAL, SAMPLED), COMPUTE_WRITE, everyone())]
    );
    assert_eq!(plan.release, []);
    let dot = to_dot(&frame, &plan);
    assert!(dot.contains("label=\"nodes\\nas large as its owner made it\\nimported\""), "{dot}");
}
