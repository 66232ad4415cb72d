//! Where the grids of the hierarchy stand while lights change: at an anchor that does not follow them.

mod common;
mod support;

use std::sync::Arc;

use common::gpu;
use common::hierarchy::{self, Hierarchy, Options};
use common::rooms::courtyard;
use gridlight::cpu::lights::LightList;
use gridlight::cpu::place_grid::place_grid;
use gridlight::cpu::reduce_bounds::reduce_bounds;
use gridlight::gpu::Gpu;
use gridlight::light_grid::anchor::GridAnchor;
use gridlight::passes::lgh_shape::LghShape;
use gridlight::renderer::{Fresh, Job, Renderer, UploadedScene};
use gridlight::scene::Scene;
use gridlight::settings::{CenterWeight, LevelBuild, LightSet, Settings, Size, VplSeeds};
use gridlight::shared::GridPlacement;
use gridlight::techniques::lgh::HierarchyOutputs;
use support::animated::carried;

const FRAMES: u32 = 6;

fn settings(seeds: Option<VplSeeds>) -> Settings {
    Settings::default().changed(|s| {
        s.picture.size = Size { width: 32, height: 24 };
        (s.many_lights.vpls, s.many_lights.vpl_seeds) = (2000, seeds);
    })
}

fn placement(renderer: &Renderer) -> GridPlacement {
    let buffer = renderer.outputs().technique.of::<HierarchyOutputs>().unwrap().placement;
    bytemuck::pod_collect_to_vec(&renderer.executor().read_buffer(buffer).unwrap())[0]
}

fn next(renderer: &mut Renderer, frame: u32, fresh: Fresh) -> GridPlacement {
    renderer.set_accumulated_frame(frame, fresh);
    let ticket = renderer.submit().unwrap();
    renderer.wait(ticket).unwrap();
    placement(renderer)
}

/// Placements of frames with light paths of their own, of a shape that `change` has been made to.
fn placements(gpu: &Arc<Gpu>, scene: &Scene, change: impl FnOnce(&mut LghShape)) -> Vec<GridPlacement> {
    let settings = settings(Some(VplSeeds::Fresh));
    let uploaded = UploadedScene::new(gpu, scene).unwrap();
    let job = Job::new(gpu, &uploaded, &scene.cameras[0], &settings);
    let mut shapes = Renderer::new(&job).unwrap().shapes().clone();
    change(shapes.of_mut::<LghShape>().unwrap());
    let mut renderer = Renderer::with_shapes(&job, shapes).unwrap();
    (0..FRAMES).map(|frame| next(&mut renderer, frame, Fresh::All)).collect()
}

/// Whether all grids stand at one place.
fn stand_still(placements: &[GridPlacement]) -> bool {
    placements.windows(2).all(|pair| pair[0].origin_ws == pair[1].origin_ws && pair[0].h_top == pair[1].h_top)
}

#[test]
fn fresh_paths_do_not_move_the_grid() {
    let test = gpu();
    let scene = courtyard();
    let anchored = placements(&test.gpu, &scene, |_| ());
    assert!(stand_still(&anchored), "{anchored:?}");
    let anchor = GridAnchor::around(scene.bounds.min.to_array(), scene.bounds.max.to_array()).unwrap();
    assert_eq!((anchored[0].origin_ws, anchored[0].h_top), (anchor.low_ws, anchor.edge));
    let scales = anchored.iter().map(|placement| placement.flux_scale);
    assert!(scales.clone().all(|scale| scale.to_bits() & 0x7f_ffff == 0), "{:?}", scales.collect::<Vec<_>>());
    // The comparison sees grids that follow the lights.
    assert!(!stand_still(&placements(&test.gpu, &scene, |shape| shape.anchor = None)));
}

#[test]
fn grids_of_paths_at_rest_follow_their_lights() {
    let test = gpu();
    let scene = courtyard();
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    for seeds in [None, Some(VplSeeds::Held)] {
        let settings = settings(seeds);
        let renderer = Renderer::new(&Job::new(&test.gpu, &uploaded, &scene.cameras[0], &settings)).unwrap();
        assert_eq!(renderer.shapes().of::<LghShape>().unwrap().anchor, None);
    }
}

/// Placements of frames of a scene that moves on by 0.6 s from one to the next.
fn swept(gpu: &Arc<Gpu>, mut scene: Scene, settings: &Settings, is_anchored: bool) -> Vec<GridPlacement> {
    let mut uploaded = UploadedScene::new(gpu, &scene).unwrap();
    let camera = scene.cameras[0].clone();
    let job = Job::new(gpu, &uploaded, &camera, settings);
    let mut shapes = Renderer::new(&job).unwrap().shapes().clone();
    let anchor = &mut shapes.of_mut::<LghShape>().unwrap().anchor;
    assert!(anchor.is_some());
    *anchor = anchor.filter(|_| is_anchored);
    let mut renderer = Renderer::with_shapes(&job, shapes).unwrap();
    let frame = |number| {
        scene.pose(0.6 * f64::from(number));
        uploaded.follow(gpu, &scene).unwrap();
        renderer.update(&Job::new(gpu, &uploaded, &camera, settings));
        renderer.expect_another_scene();
        next(&mut renderer, number, Fresh::Shadows)
    };
    (0..FRAMES).map(frame).collect()
}

/// The screen and the lamp of [`carried`].
const MOVING_NODES: [usize; 2] = [1, 2];

#[test]
fn what_moves_does_not_move_the_grid() {
    let test = gpu();
    // The lamp is a light of the hierarchy itself.
    let settings = settings(None).changed(|s| s.many_lights.lights = LightSet::Both);
    for node in MOVING_NODES {
        let anchored = swept(&test.gpu, carried(node), &settings, true);
        assert!(stand_still(&anchored), "node {node}: {anchored:?}");
        let followed = swept(&test.gpu, carried(node), &settings, false);
        assert!(!stand_still(&followed), "node {node}: grids around the lights of each frame stand still as well");
    }
}

#[test]
fn a_camera_that_moves_leaves_the_grid_to_the_lights() {
    let test = gpu();
    let scene = carried(3);
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    assert!(uploaded.is_animated());
    let settings = settings(None);
    let renderer = Renderer::new(&Job::new(&test.gpu, &uploaded, &scene.cameras[0], &settings)).unwrap();
    assert_eq!(renderer.shapes().of::<LghShape>().unwrap().anchor, None);
}

#[test]
fn lights_outside_the_anchor_are_inside_a_larger_one() {
    let test = gpu();
    let options = Options {
        top: 4,
        build: LevelBuild::Cascade,
        center: CenterWeight::Intensity,
        interleave: 1,
        first_level: 1,
        light_capacity: 8,
        grid_capacity: None,
    };
    let anchor = Some(GridAnchor { low_ws: [-1.0; 3], edge: 2.0 });
    let mut hierarchy = Hierarchy::of_shape(&test.gpu, LghShape { anchor, ..hierarchy::shape(options) });
    let list = |positions: &[[f32; 3]]| {
        let mut lights = LightList::default();
        positions.iter().for_each(|position| lights.push(*position, 0, [3.0, 1.0, 0.5], false));
        lights
    };
    let sets: [&[[f32; 3]]; 5] =
        [&[[0.1, 0.2, -0.3]], &[[-1.001, 1.0015, 0.5]], &[[0.0; 3], [5.0, -1.5, 0.0]], &[[-1e6, 3.0, 1e5]], &[]];
    for positions in sets {
        let lights = list(positions);
        let gpu = hierarchy.run(&lights, 1.0).grid.placement;
        let twin = place_grid(&reduce_bounds(&lights), lights.len() as u32, 1.0, anchor);
        // The reciprocal may be 2.5 ulp off; the edge is a power of two here.
        assert_eq!(gpu, twin, "{positions:?}");
        for position in positions {
            for axis in 0..3 {
                let cells = (position[axis] - gpu.origin_ws[axis]) / gpu.h_top;
                assert!((-0.001..=1.001).contains(&cells), "{position:?} is outside of {gpu:?}");
            }
        }
    }
}
