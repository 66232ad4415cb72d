//! What point-based global illumination keeps from the frame before: pictures stay the same to the bit, and nothing is kept
//! that lights or settings have changed.

mod common;

use std::sync::Arc;

use common::points::under_sky;
use common::rooms::{add_quad, camera};
use glam::Vec3;
use gridlight::environment::{self, Environment};
use gridlight::gpu::Gpu;
use gridlight::renderer::{Job, Renderer, UploadedScene};
use gridlight::scene::testing::{diffuse, scene_from_quads, shared_dir};
use gridlight::scene::{Camera, Light, Scene, gltf};
use gridlight::settings::{MicroFill, Settings, Size, Switch, Technique};
use gridlight::shared::PointCounts;

fn settings(micro: MicroFill) -> Settings {
    Settings::default().changed(|s| {
        s.render.technique = Technique::Pbgi;
        s.picture.size = Size { width: 96, height: 54 };
        s.pbgi.points = 4096;
        s.pbgi.micro = micro;
        s.pbgi.reuse = Switch::On;
    })
}

/// A floor, a roof over a part of it, and a wall, in the sun.
fn scene() -> Scene {
    let level = |y: f32, h: f32| [Vec3::new(-h, y, h), Vec3::new(h, y, h), Vec3::new(h, y, -h), Vec3::new(-h, y, -h)];
    let mut scene = scene_from_quads("roof", &[level(0.0, 3.0)], diffuse("grey", Vec3::new(0.7, 0.5, 0.3)));
    add_quad(&mut scene, level(1.0, 0.8));
    add_quad(&mut scene, level(0.0, 3.0).map(|corner| Vec3::new(corner.x, 1.0 + corner.z / 3.0, -2.0)));
    let mut scene = under_sky(scene);
    scene.environment = Some(Arc::new(Environment::uniform([0.5, 0.7, 1.0])));
    scene.lights = vec![sun(Vec3::new(0.3, -1.0, -0.4))];
    scene.cameras = vec![eye(0.0)];
    scene
}

fn sun(direction: Vec3) -> Light {
    Light::Directional { direction_ws: direction.normalize(), irradiance: Vec3::new(3.0, 2.5, 2.0) }
}

/// A step of a camera that moves.
fn eye(step: f32) -> Camera {
    let forward = Vec3::new(0.05 * step, -0.2, -1.0).normalize();
    camera(Vec3::new(0.06 * step, 0.6, 2.5 - 0.05 * step), forward, 0.8)
}

fn upload(gpu: &Arc<Gpu>, scene: &Scene) -> UploadedScene {
    let mut uploaded = UploadedScene::new(gpu, scene).unwrap();
    uploaded.spread_points(scene, Some(12)).unwrap();
    uploaded
}

fn run(renderer: &mut Renderer) -> Vec<f32> {
    let ticket = renderer.submit().unwrap();
    renderer.wait(ticket).unwrap();
    renderer.read_radiance().unwrap()
}

fn counts(renderer: &Renderer) -> PointCounts {
    bytemuck::pod_read_unaligned(bytemuck::cast_slice(&renderer.read_counters().unwrap()[0]))
}

/// The picture of one frame by itself, with nothing kept.
fn alone(gpu: &Arc<Gpu>, uploaded: &UploadedScene, camera: &Camera, settings: &Settings) -> Vec<f32> {
    let settings = settings.clone().changed(|s| s.pbgi.reuse = Switch::Off);
    run(&mut Renderer::new(&Job::new(gpu, uploaded, camera, &settings)).unwrap())
}

#[test]
fn a_moving_camera_sees_the_same_picture_to_the_bit() {
    let test = common::gpu();
    let uploaded = upload(&test.gpu, &scene());
    for micro in [MicroFill::Rays, MicroFill::Points] {
        let settings = settings(micro);
        let mut renderer = Renderer::new(&Job::new(&test.gpu, &uploaded, &eye(0.0), &settings)).unwrap();
        for step in 0..4 {
            let camera = eye(step as f32);
            renderer.update(&Job::new(&test.gpu, &uploaded, &camera, &settings));
            let picture = run(&mut renderer);
            assert!(picture == alone(&test.gpu, &uploaded, &camera, &settings), "{micro:?}, step {step}");
            let counts = counts(&renderer);
            let needed = counts.needed_count + counts.needed_kept;
            let is_kept = counts.primaries_kept * 2 > counts.primary_count && counts.needed_kept * 2 > needed;
            assert_eq!(is_kept, step > 0, "{micro:?}, step {step}: {counts:?}");
        }
    }
}

#[test]
fn a_standing_camera_keeps_everything() {
    let test = common::gpu();
    let uploaded = upload(&test.gpu, &scene());
    let settings = settings(MicroFill::Rays);
    let mut renderer = Renderer::new(&Job::new(&test.gpu, &uploaded, &eye(0.0), &settings)).unwrap();
    let first = run(&mut renderer);
    let lit = counts(&renderer).needed_count;
    assert!(run(&mut renderer) == first);
    let counts = counts(&renderer);
    assert_eq!((counts.needed_count, counts.needed_kept), (0, lit));
    assert_eq!(counts.primaries_kept, counts.primary_count);
}

#[test]
fn nothing_is_kept_of_other_lights_or_settings() {
    let test = common::gpu();
    let mut scene = scene();
    let uploaded = upload(&test.gpu, &scene);
    let first = settings(MicroFill::Rays);
    let mut renderer = Renderer::new(&Job::new(&test.gpu, &uploaded, &eye(0.0), &first)).unwrap();
    let before = run(&mut renderer);
    // The environment is turned down: a constant of the frame.
    let darker = first.clone().changed(|s| s.environment.scale = 0.5);
    renderer.update(&Job::new(&test.gpu, &uploaded, &eye(0.0), &darker));
    let dark = run(&mut renderer);
    assert_eq!(counts(&renderer).needed_kept, 0);
    assert!(dark == alone(&test.gpu, &uploaded, &eye(0.0), &darker) && dark != before);
    // The sun is moved: a light of the scene.
    scene.lights = vec![sun(Vec3::new(-0.6, -1.0, -0.2))];
    let moved = upload(&test.gpu, &scene);
    renderer.update_lights(moved.other_lights()).unwrap();
    let lit = run(&mut renderer);
    assert_eq!(counts(&renderer).needed_kept, 0);
    assert!(lit == alone(&test.gpu, &moved, &eye(0.0), &darker) && lit != dark);
    // And once nothing changes any more, all is kept.
    assert!(run(&mut renderer) == lit && counts(&renderer).needed_count == 0);
}

/// A camera that has walked so many metres to its right and turned as many times 20 degrees.
fn walked(camera: &Camera, metres: f32) -> Camera {
    let mut camera = camera.clone();
    let turn = glam::Quat::from_rotation_y(metres * 20.0_f32.to_radians());
    camera.position_ws += metres * camera.right_ws;
    for axis in [&mut camera.right_ws, &mut camera.up_ws, &mut camera.forward_ws] {
        *axis = turn * *axis;
    }
    camera
}

/// Prints what frames of a moving camera cost in the castle of the shared folder.
#[test]
#[ignore = "takes a minute and prints times: for measuring"]
fn frames_of_a_moving_camera_cost_less() {
    let folder = shared_dir().expect("the shared folder").join("assets/env");
    let mut scene = gltf::load(&folder.join("castle.gltf"), &|_: &str, _, _| ()).unwrap();
    scene.environment = Some(Arc::new(environment::file::read(&folder.join("sky.exr")).unwrap()));
    let yard = scene.cameras.iter().find(|camera| camera.name == "yard").expect("the camera").clone();
    let settings = settings(MicroFill::Rays).changed(|s| {
        s.picture.size = Size { width: 640, height: 360 };
        s.pbgi.points = 1 << 19;
    });
    let test = common::gpu();
    let mut uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    uploaded.spread_points(&scene, Some(19)).unwrap();
    let mut renderer = Renderer::new(&Job::new(&test.gpu, &uploaded, &yard, &settings)).unwrap();
    let mut first_ms = f64::INFINITY;
    // A step each frame: 25 mm, 50 mm and 100 mm, and half a degree, one and two.
    for (frame, metres) in [0.0, 0.025, 0.05, 0.1, 0.15, 0.25].into_iter().enumerate() {
        renderer.update(&Job::new(&test.gpu, &uploaded, &walked(&yard, metres), &settings));
        let ticket = renderer.submit().unwrap();
        let ms = renderer.wait(ticket).unwrap().gpu_ms();
        first_ms = if frame == 0 { ms } else { first_ms };
        let found = counts(&renderer);
        println!("{metres} m: {ms:.0} ms, {:.0} % of the first frame, {found:?}", 100.0 * ms / first_ms);
        assert!(frame == 0 || ms < first_ms, "{ms} ms after {first_ms} ms");
    }
}
