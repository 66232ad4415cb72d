//! Bindings of each stage against a device's limits: pretended limits, the table on the page about porting, and the
//! scene's set of a device against the shaders' declarations.

mod common;

use std::collections::BTreeMap;

use common::hierarchy::{Options, frame_shape, shape};
use gridlight::Error;
use gridlight::frame;
use gridlight::gpu::{StageLimits, Work, check_stage_limits};
use gridlight::graph::Graph;
use gridlight::renderer::UploadedScene;
use gridlight::scene::testing::box_room;
use gridlight::settings::{CenterWeight, LevelBuild};
use gridlight::shader::interface::{self, BindingKind, Interface};
use gridlight::techniques::{AnyShape, Shapes};

/// What Vulkan 1.3 guarantees of each limit, in the order of the rows.
const LEAST: [u32; 6] = [12, 4, 16, 4, 16, 128];

/// The scene's set as the shaders declare it, by binding; those of ray queries are left out without them.
fn scene_set(with_queries: bool) -> BTreeMap<u32, BindingKind> {
    let bindings = interface::embedded().values().flat_map(|interface| &interface.bindings);
    let kept = |binding: u32| with_queries || !(7..=8).contains(&binding);
    bindings.filter(|b| b.set == 1 && kept(b.binding)).map(|b| (b.binding, b.kind)).collect()
}

fn scene_kinds(with_queries: bool) -> Vec<BindingKind> {
    scene_set(with_queries).into_values().collect()
}

/// A frame of the hierarchy with all that is on by default.
fn frame_graph() -> Graph<Work> {
    let (center, build) = (CenterWeight::Intensity, LevelBuild::Cascade);
    let options =
        Options { top: 4, build, center, interleave: 1, first_level: 1, light_capacity: 1000, grid_capacity: None };
    frame::build(&Shapes { frame: frame_shape(), technique: shape(options).boxed() }).0
}

/// What a device refuses that allows one binding of a kind fewer than it needs.
fn refusal(set: impl Fn(&mut StageLimits) -> &mut u32, allowed: u32) -> String {
    let mut limits =
        StageLimits { uniform_buffers: 99, storage_buffers: 99, sampled_images: 99, ..StageLimits::default() };
    (limits.storage_images, limits.samplers, limits.resources) = (99, 99, 999);
    let graph = frame_graph();
    assert!(check_stage_limits(&graph, &scene_kinds(true), &limits).is_ok());
    *set(&mut limits) = allowed;
    match check_stage_limits(&graph, &scene_kinds(true), &limits) {
        Err(Error::NoDevice(message)) => message,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_pass_beyond_a_limit_is_refused_by_name() {
    let storage = refusal(|limits| &mut limits.storage_buffers, 4);
    assert!(storage.starts_with("pass `gbuffer` binds 8 storage buffers"), "{storage}");
    assert!(
        storage.ends_with("storage buffers in one stage, this device allows 4 (maxPerStageDescriptorStorageBuffers)")
    );
    for (refused, kind, name) in [
        (refusal(|limits| &mut limits.uniform_buffers, 0), "1 uniform buffers", "maxPerStageDescriptorUniformBuffers"),
        (refusal(|limits| &mut limits.sampled_images, 3), "sampled images", "maxPerStageDescriptorSampledImages"),
        (refusal(|limits| &mut limits.storage_images, 0), "storage images", "maxPerStageDescriptorStorageImages"),
        (refusal(|limits| &mut limits.samplers, 2), "3 samplers", "maxPerStageDescriptorSamplers"),
        (refusal(|limits| &mut limits.resources, 5), "resources", "maxPerStageResources"),
    ] {
        assert!(refused.contains(kind) && refused.contains(name), "{refused}");
    }
}

#[test]
fn what_every_device_allows_suffices_but_for_storage_buffers() {
    let [uniform_buffers, storage_buffers, sampled_images, storage_images, samplers, resources] = LEAST;
    let least = StageLimits { uniform_buffers, storage_buffers, sampled_images, storage_images, samplers, resources };
    for ((kind, _, _), (highest, shader)) in least.rows().into_iter().zip(highest_counts()) {
        let allowed = least.rows().into_iter().find(|(name, _, _)| *name == kind).unwrap().2;
        assert!(kind == "storage buffers" || highest <= allowed, "{shader}: {highest} {kind} of {allowed}");
    }
}

/// Bindings that a shader's stage has in the pipeline of its pass.
fn counts_of(name: &str, interface: &Interface) -> StageLimits {
    let own = interface.bindings.iter().filter(|b| b.set != 1).map(|b| b.kind);
    let uses_scene = interface.bindings.iter().any(|b| b.set > 0);
    let scene = scene_kinds(name.contains("_query")).into_iter().filter(|_| uses_scene);
    StageLimits::of(own.chain(scene))
}

/// The highest count of each kind, and the first shader that has it.
fn highest_counts() -> Vec<(u32, String)> {
    let mut highest = vec![(0, String::new()); LEAST.len()];
    for (name, interface) in interface::embedded() {
        for (best, (_, _, count)) in highest.iter_mut().zip(counts_of(name, interface).rows()) {
            if count > best.0 {
                *best = (count, name.clone());
            }
        }
    }
    highest
}

#[test]
fn the_page_about_porting_has_the_highest_counts() {
    let page = include_str!("../docs/porting.md");
    let rows = StageLimits::default().rows();
    for (((_, limit, _), (count, shader)), least) in rows.into_iter().zip(highest_counts()).zip(LEAST) {
        let row = format!("| `{limit}` | {count} | `{shader}` | {least} |");
        println!("{row}");
        assert!(page.contains(&row), "docs/porting.md lacks the row\n{row}");
    }
}

#[test]
fn the_scene_of_a_device_binds_what_shaders_declare() {
    let test = common::gpu();
    let scene = box_room(4.0, glam::Vec3::splat(0.5));
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    let mut bound = uploaded.set().binding_kinds();
    let mut declared = scene_kinds(false);
    bound.sort_by_key(|kind| format!("{kind:?}"));
    declared.sort_by_key(|kind| format!("{kind:?}"));
    assert_eq!(bound, declared);
    let limits = test.gpu.report().limits.stage;
    assert!(check_stage_limits(&frame_graph(), &bound, &limits).is_ok(), "{limits:?}");
}
