//! Shadows of coloured lights: no colour comes out that no light has.

mod common;

use common::rooms::{add_quad, camera};
use glam::Vec3;
use gridlight::renderer::{Job, Renderer, UploadedScene};
use gridlight::scene::testing::{box_room, diffuse};
use gridlight::scene::{Draw, Light, Scene};
use gridlight::settings::{Settings, ShadowEstimate, ShadowFilter, Size, View};

/// Difference between the shadows of two channels that must be one: a quotient of floats.
const TOLERANCE: f32 = 1e-4;

/// A closed room with a table under a lamp.
fn room(albedo: Vec3, intensity: Vec3) -> Scene {
    let mut scene = box_room(4.0, albedo);
    let h = 0.7;
    add_quad(
        &mut scene,
        [Vec3::new(-h, -1.0, h), Vec3::new(h, -1.0, h), Vec3::new(h, -1.0, -h), Vec3::new(-h, -1.0, -h)],
    );
    scene.lights = vec![Light::Point { position_ws: Vec3::new(0.3, 0.9, 0.2), intensity }];
    scene.cameras = vec![camera(Vec3::new(-1.5, 0.3, 1.4), Vec3::new(0.7, -0.6, -0.9).normalize(), 1.2)];
    scene
}

/// The room with every other triangle red and the rest green, so that a light has one colour or the other: what light
/// falls from one on the other ends there.
fn red_and_green() -> Scene {
    let mut scene = room(Vec3::X, Vec3::splat(9.0));
    scene.materials.push(diffuse("green", Vec3::Y));
    let triangles = scene.triangle_materials.len() as u32;
    scene.triangle_materials = (0..triangles).map(|i| i % 2).collect();
    scene.draws = (0..triangles).map(|i| Draw { first_index: 3 * i, index_count: 3, material: i % 2 }).collect();
    scene
}

/// The shadow of each pixel, per channel.
fn shadows(scene: &Scene, settings: &Settings) -> Vec<Vec3> {
    let test = common::gpu();
    let uploaded = UploadedScene::new(&test.gpu, scene).unwrap();
    let mut renderer = Renderer::new(&Job::new(&test.gpu, &uploaded, &scene.cameras[0], settings)).unwrap();
    let ticket = renderer.submit().unwrap();
    renderer.wait(ticket).unwrap();
    renderer.read_radiance().unwrap().chunks_exact(3).map(Vec3::from_slice).collect()
}

fn settings() -> Settings {
    Settings::default().changed(|s| {
        s.picture.size = Size { width: 64, height: 36 };
        s.many_lights.vpls = 2000;
        s.render.view = View::ShadowRatio;
        s.lgh.filter = ShadowFilter::None;
    })
}

/// Pixels among `shadows` whose channels `a` and `b` differ.
fn differing(shadows: &[Vec3], [a, b]: [usize; 2]) -> usize {
    shadows.len() - shadows.iter().filter(|s| (s[a] - s[b]).abs() <= TOLERANCE).count()
}

fn some_are_dark(shadows: &[Vec3]) -> bool {
    shadows.iter().filter(|s| s.max_element() < 0.5).count() > shadows.len() / 50
}

#[test]
fn a_channel_without_samples_has_the_shadow_of_the_others() {
    // One sample has one colour, and says nothing of the other one. Where it carries no light at all, the samples of the
    // pixels around take its place, which may have both: with the ratio, whose samples are of lights that shine here,
    // those are few.
    let one_sample = settings().changed(|s| {
        s.many_lights.shadow_samples = 1;
        s.lgh.shadow_estimate = Some(ShadowEstimate::Ratio);
    });
    let shadows = shadows(&red_and_green(), &one_sample);
    assert!(some_are_dark(&shadows));
    let found = differing(&shadows, [0, 1]);
    assert!(found < shadows.len() / 20, "{found} of {} pixels", shadows.len());
}

#[test]
fn channels_with_samples_have_shadows_of_their_own() {
    let many_samples = settings().changed(|s| s.many_lights.shadow_samples = 16);
    let shadows = shadows(&red_and_green(), &many_samples);
    assert!(differing(&shadows, [0, 1]) > shadows.len() / 10);
}

#[test]
fn a_dim_channel_has_the_shadow_of_a_bright_one() {
    // Every light has the lamp's colour, whose channels are further apart than half floats reach.
    let shadows = shadows(&room(Vec3::splat(0.6), Vec3::new(9.0, 9e-7, 9e-12)), &settings());
    assert!(some_are_dark(&shadows));
    assert_eq!((differing(&shadows, [0, 1]), differing(&shadows, [0, 2])), (0, 0), "of {} pixels", shadows.len());
    assert_eq!(differing(&[Vec3::ONE, Vec3::new(1.0, f32::NAN, 1.0)], [0, 1]), 1, "no number goes unnoticed");
}
