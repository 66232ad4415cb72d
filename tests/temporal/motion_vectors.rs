//! Where surfaces were in the frame before (`gbuffer`, `--view motion-vectors`).

use std::f64::consts::FRAC_1_SQRT_2;

use glam::{Vec2, Vec3};
use gridlight::scene::Scene;
use gridlight::scene::testing::{diffuse, scene_from_quads};
use gridlight::settings::{Settings, Size, View};
use serde_json::json;

use crate::common::gpu;
use crate::common::rooms::{camera, furnished_room};
use crate::run::{Run, colors};
use crate::support::animated::{playing, slide};
use crate::support::quad_glb;

const SIZE: Size = Size { width: 37, height: 21 };
/// Distance of the wall, and of the steps of the camera.
const WALL_M: f32 = 3.0;
const STEP_M: f32 = 0.07;
const YFOV_RAD: f32 = 0.9;

/// A wall that fills the picture.
fn wall() -> Scene {
    let at = |x: f32, y: f32| Vec3::new(x, y, -WALL_M);
    let quad = [at(-9.0, -9.0), at(9.0, -9.0), at(9.0, 9.0), at(-9.0, 9.0)];
    let mut scene = scene_from_quads("wall", &[quad], diffuse("grey", Vec3::splat(0.5)));
    scene.cameras = vec![camera(Vec3::ZERO, Vec3::NEG_Z, YFOV_RAD)];
    scene
}

fn settings() -> Settings {
    Settings::default().changed(|s| {
        s.picture.size = SIZE;
        s.render.view = View::MotionVectors;
    })
}

/// Pixels that a metre across the view has at a metre's distance.
fn focal_px() -> f32 {
    SIZE.height as f32 / (2.0 * (YFOV_RAD * 0.5).tan())
}

#[test]
fn surfaces_move_against_the_camera() {
    let test = gpu();
    let mut run = Run::new(&test.gpu, &wall(), &settings());
    run.next();
    run.step_right(STEP_M);
    run.next();
    // What is in a pixel was further to the right.
    let expected = Vec3::new(focal_px() * STEP_M / WALL_M, 0.0, run.camera.near / WALL_M);
    assert!(expected.x > 0.5);
    for (pixel, motion) in colors(&run.radiance()).into_iter().enumerate() {
        let off = (motion - expected).abs();
        assert!(off.x <= 1e-4 && off.y <= 1e-4 && off.z <= 1e-7, "{pixel}: {motion}, not {expected}");
    }
    // Towards the wall: what is to the right of the middle was nearer to it.
    run.camera.position_ws += run.camera.forward_ws * 0.5;
    run.next();
    for (pixel, motion) in colors(&run.radiance()).into_iter().enumerate() {
        let place = Vec3::new((pixel as u32 % SIZE.width) as f32, (pixel as u32 / SIZE.width) as f32, 0.0);
        let from_middle = place + 0.5 - Vec3::new(SIZE.width as f32, SIZE.height as f32, 1.0) * 0.5;
        let expected = from_middle * ((WALL_M - 0.5) / WALL_M - 1.0);
        assert!((motion - expected).truncate().abs().max_element() <= 1e-3, "{pixel}: {motion}, not {expected}");
    }
}

#[test]
fn what_stands_still_moves_by_exactly_nothing() {
    let test = gpu();
    let mut scene = furnished_room();
    scene.cameras[0].position_ws += Vec3::new(0.123, 0.045, -0.067);
    let mut run = Run::new(&test.gpu, &scene, &settings());
    for frame in 0..3 {
        run.next();
        let motions = colors(&run.radiance());
        assert!(motions.iter().all(|motion| motion.truncate() == Vec2::ZERO && motion.z > 0.0), "frame {frame}");
    }
    // A cut leaves nothing to follow.
    run.step_right(0.3);
    run.renderer.cut();
    run.next();
    assert!(colors(&run.radiance()).iter().all(|motion| motion.truncate() == Vec2::ZERO));
    run.step_right(0.3);
    run.next();
    assert!(colors(&run.radiance()).iter().all(|motion| motion.x > 0.5));
}

/// A quad that a node carries along x before a camera at rest.
fn carried() -> Scene {
    let glb = quad_glb(|document, bin| {
        document["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": YFOV_RAD, "znear": 0.05}}]);
        document["nodes"] = json!([
            {"mesh": 0, "rotation": [FRAC_1_SQRT_2, 0, 0, FRAC_1_SQRT_2], "translation": [-1.0, 0.0, -WALL_M]},
            {"camera": 0}
        ]);
        document["scenes"][0]["nodes"] = json!([0, 1]);
        slide(document, bin, 0);
    });
    playing(&glb)
}

#[test]
fn moved_vertices_carry_their_surfaces() {
    let test = gpu();
    let mut scene = carried();
    let mut run = Run::new(&test.gpu, &scene, &settings());
    run.next();
    let focal_px = focal_px();
    let mut moment_s = 0.0;
    // By how much the scene goes on before each frame, in seconds, which are metres.
    for step_m in [0.2, 0.2, 0.0, 0.35] {
        moment_s += step_m;
        if step_m > 0.0 {
            scene.pose(moment_s);
            run.uploaded.follow(&test.gpu, &scene).unwrap();
        }
        run.next();
        let moved: Vec<Vec3> = colors(&run.radiance()).into_iter().filter(|motion| motion.z > 0.0).collect();
        assert!(moved.len() > 20, "the quad is out of sight");
        let expected = -focal_px * step_m as f32 / WALL_M;
        for motion in moved {
            assert!(
                (motion.x - expected).abs() <= 1e-3 && motion.y.abs() <= 1e-3,
                "at {moment_s} s: {motion}, not {expected}"
            );
        }
    }
}

#[test]
fn moves_that_no_frame_has_shown_end_the_history() {
    let test = gpu();
    let mut scene = carried();
    let mut run = Run::new(&test.gpu, &scene, &settings());
    run.next();
    for moment_s in [0.2, 0.4] {
        scene.pose(moment_s);
        run.uploaded.follow(&test.gpu, &scene).unwrap();
    }
    run.next();
    assert_eq!(run.renderer.frame_data().history_is_valid, 0);
    run.next();
    assert_eq!((run.renderer.frame_data().history_is_valid, run.renderer.frame_data().vertices_moved), (1, 0));
}
