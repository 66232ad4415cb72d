//! More threads than one row of workgroups holds.

mod common;

use common::rooms::lamp_room;
use glam::Vec3;
use gridlight::passes::lgh_shape::LghShape;
use gridlight::renderer::{Job, Renderer, UploadedScene};
use gridlight::settings::{Levels, Settings, Size};
use gridlight::shared::DISPATCH_WIDTH;
use gridlight::techniques::lgh::HierarchyOutputs;

/// In a closed room every path leaves a light at its only hit, so that a path that is not traced is missed.
#[test]
fn every_path_beyond_a_row_of_workgroups_is_traced() {
    let test = common::gpu();
    // A row too many, numbered as if workgroups had one thread, would cover another DISPATCH_WIDTH paths.
    let paths = DISPATCH_WIDTH * 66;
    let scene = lamp_room(Vec3::splat(0.5));
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    let size = Size { width: 8, height: 8 };
    let levels = Levels::Fixed(2);
    let settings = Settings::default().changed(|s| {
        s.picture.size = size;
        s.many_lights.vpls = paths;
        s.many_lights.bounces = 1;
        s.lgh.levels = levels;
        s.many_lights.shadow_samples = 0;
    });
    let mut renderer = Renderer::new(&Job::new(&test.gpu, &uploaded, &scene.cameras[0], &settings)).unwrap();
    let ticket = renderer.submit().unwrap();
    renderer.wait(ticket).unwrap();
    let lights = renderer.outputs().technique.of::<HierarchyOutputs>().unwrap().lights;
    let path_count = renderer.shapes().of::<LghShape>().unwrap().lights.path_count;
    let counts: Vec<u32> = bytemuck::pod_collect_to_vec(&renderer.executor().read_buffer(lights.counts).unwrap());
    assert!(path_count > DISPATCH_WIDTH * 64, "too few paths for this test");
    assert_eq!(counts[1], path_count);
    assert_eq!(counts[2], 0, "lights that did not fit");
}
