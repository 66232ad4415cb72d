//! How the default frame is cut by barriers: few batches, and what is cleared is cleared together.

mod common;

use common::rooms::furnished_room;
use gridlight::gpu::{ScenePart, TransferOp, Work};
use gridlight::graph::{Barrier, BufferHandle, Graph, Plan};
use gridlight::renderer::{Job, Renderer, UploadedScene};
use gridlight::settings::{LightingMode, Settings, Size, Technique};

/// Barrier batches that the default frame may have.
const MOST_BATCHES: usize = 40;

fn settings() -> Settings {
    Settings::default().changed(|s| {
        s.picture.size = Size { width: 64, height: 48 };
        s.many_lights.vpls = 20_000;
    })
}

fn with_frame(settings: &Settings, check: impl FnOnce(&Graph<Work>, &Plan)) {
    let test = common::gpu();
    let scene = furnished_room();
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    let renderer = Renderer::new(&Job::new(&test.gpu, &uploaded, &scene.cameras[0], settings)).unwrap();
    check(renderer.executor().graph(), renderer.executor().plan());
}

/// Passes that fill buffers, and the fills in them.
fn fills(graph: &Graph<Work>) -> (usize, usize) {
    let counts = graph.passes().iter().map(|pass| match &pass.payload {
        Work::Transfer(ops) => ops.iter().filter(|op| matches!(op, TransferOp::Fill { .. })).count(),
        _ => 0,
    });
    let counts: Vec<usize> = counts.filter(|count| *count > 0).collect();
    (counts.len(), counts.iter().sum())
}

#[test]
fn the_default_frame_has_few_batches_of_barriers() {
    with_frame(&settings(), |graph, plan| {
        let (filling, fill_count) = fills(graph);
        println!(
            "{} passes, {} batches, {} barriers, {fill_count} fills in {filling} passes",
            graph.passes().len(),
            plan.batch_count(),
            plan.barrier_count()
        );
        assert!(plan.batch_count() <= MOST_BATCHES, "{} batches", plan.batch_count());
        assert_eq!(filling, 1, "all buffers are cleared in one pass");
        assert_eq!(fill_count, 9);
    });
}

#[test]
fn buffers_of_the_size_of_the_picture_are_cleared_where_they_are_used() {
    let settings = settings().changed(|s| s.lgh.lighting = Some(LightingMode::Volumes));
    with_frame(&settings, |graph, plan| {
        assert!(plan.batch_count() <= MOST_BATCHES, "{} batches", plan.batch_count());
        assert_eq!(fills(graph).0, 2);
    });
}

/// Barriers of one resource, and batches that have nothing else in them.
fn cost_of(resource: BufferHandle, plan: &Plan) -> (usize, usize) {
    let is_its = |barrier: &Barrier| barrier.resource == resource.into();
    let batches = plan.passes.iter().map(|pass| (&pass.barriers, pass.takeover.is_some()));
    let batches: Vec<_> = batches.chain([(&plan.release, false)]).collect();
    let barriers = batches.iter().flat_map(|(barriers, _)| *barriers).filter(|barrier| is_its(barrier)).count();
    let own = |(barriers, takeover): &&(&Vec<Barrier>, bool)| {
        !takeover && !barriers.is_empty() && barriers.iter().all(is_its)
    };
    (barriers, batches.iter().filter(own).count())
}

/// Lights that the host changes are written by `frame_setup`, whose batches every frame has anyway.
#[test]
fn lights_that_may_change_cost_no_batch() {
    for technique in [Technique::Lgh, Technique::Direct, Technique::BruteForce, Technique::PathTrace] {
        with_frame(&settings().changed(|s| s.render.technique = technique), |graph, plan| {
            let lights = graph.buffer_named(ScenePart::Lights.name()).expect("the scene's lights");
            let (barriers, batches) = cost_of(lights, plan);
            println!("{technique:?}: {barriers} of {} barriers, {batches} batches", plan.barrier_count());
            assert!(barriers > 0, "{technique:?}: their readers wait for the write");
            assert_eq!(batches, 0, "{technique:?}");
            let mut apart = plan.clone();
            apart.release.extend(plan.passes.iter().flat_map(|p| &p.barriers).filter(|b| b.resource == lights.into()));
            assert_eq!(cost_of(lights, &apart).1, 1, "{technique:?}: a batch of their own is noticed");
        });
    }
}
