//! One room in metres, in millimetres, in kilometres, far from the origin, and with something far from it: the same picture
//! each time. Rays that start too near to a surface for the numbers there meet it again, which shows as dark pixels; rays
//! that start too far from it pass what stands on it, which shows as light.

mod common;

use std::ops::ControlFlow;

use common::rooms::{add_quad, furnished_room};
use glam::Vec3;
use gridlight::renderer::{Job, Renderer, UploadedScene};
use gridlight::scene::{Light, Scene};
use gridlight::settings::{Settings, ShadowEstimate, Size, Technique};

/// The mean may be off by this.
const ENERGY: f32 = 0.005;
/// A pixel that is off by more than this is another one.
const PIXEL: f32 = 0.05;
/// So many of the pixels may be others: those at edges, whose corners fall on other subpixels.
const OTHERS: f32 = 0.02;

/// The room `scale` times as large, with lamps to match, and then moved.
fn room(scale: f32, by: Vec3) -> Scene {
    let mut scene = furnished_room();
    let placed = |p: Vec3| p * scale + by;
    for vertex in &mut scene.vertices {
        vertex.position_ws = placed(vertex.position_ws.into()).to_array();
    }
    for light in &mut scene.lights {
        if let Light::Point { position_ws, intensity } = light {
            *position_ws = placed(*position_ws);
            *intensity *= scale * scale;
        }
    }
    for camera in &mut scene.cameras {
        camera.position_ws = placed(camera.position_ws);
        camera.near *= scale;
    }
    (scene.bounds.min, scene.bounds.max) = (placed(scene.bounds.min), placed(scene.bounds.max));
    scene
}

fn render(scene: &Scene, technique: Technique) -> Vec<Vec3> {
    let settings = Settings::default().changed(|s| {
        s.render.technique = technique;
        s.picture.size = Size { width: 64, height: 36 };
        s.many_lights.vpls = 500;
        s.path_trace.samples = 64;
        s.lgh.alpha = 2.0;
        // Pixels whose rounded positions choose another light differ by their noise, which the ratio hides.
        s.lgh.shadow_estimate = Some(ShadowEstimate::Ratio);
    });
    let test = common::gpu();
    let uploaded = UploadedScene::new(&test.gpu, scene).unwrap();
    let mut renderer = Renderer::new(&Job::new(&test.gpu, &uploaded, &scene.cameras[0], &settings)).unwrap();
    renderer.run_in_steps(200.0, &mut |_, _| ControlFlow::Continue(())).unwrap();
    renderer.read_radiance().unwrap().chunks_exact(3).map(Vec3::from_slice).collect()
}

/// Whether a picture is that of the room at the origin.
fn same(found: &[Vec3], expected: &[Vec3]) -> Result<(), String> {
    let sum = |pixels: &[Vec3]| pixels.iter().map(|p| p.element_sum()).sum::<f32>();
    let energy = sum(found) / sum(expected);
    let is_same = |(a, b): &(&Vec3, &Vec3)| (**a - **b).abs().max_element() <= PIXEL * b.max_element();
    let others = 1.0 - found.iter().zip(expected).filter(is_same).count() as f32 / expected.len() as f32;
    let told = format!("energy {energy}, other pixels {others}");
    if (energy - 1.0).abs() <= ENERGY && others <= OTHERS { Ok(()) } else { Err(told) }
}

fn check(scale: f32, by: Vec3) {
    for technique in [Technique::Direct, Technique::PathTrace, Technique::BruteForce, Technique::Lgh] {
        let expected = render(&room(1.0, Vec3::ZERO), technique);
        let found = render(&room(scale, by), technique);
        same(&found, &expected).unwrap_or_else(|e| panic!("{technique:?}: {e}"));
    }
}

#[test]
fn a_room_of_millimetres() {
    check(1e-3, Vec3::ZERO);
}

#[test]
fn a_room_of_kilometres() {
    check(1e3, Vec3::ZERO);
}

#[test]
fn a_room_far_from_the_origin() {
    check(1.0, Vec3::new(1e4, -1e4, 1e4));
}

#[test]
fn a_board_kilometres_away() {
    let room = room(1.0, Vec3::ZERO);
    let mut with_board = furnished_room();
    let [x, y] = [3000.0, 4.0];
    add_quad(&mut with_board, [[x, 0.0], [x, y], [x + 9.0, y], [x + 9.0, 0.0]].map(|[x, y]| Vec3::new(x, y, 0.0)));
    with_board.bounds.max.x = x + 9.0;
    for technique in [Technique::BruteForce, Technique::Lgh] {
        let expected = render(&room, technique);
        same(&render(&with_board, technique), &expected).unwrap_or_else(|e| panic!("{technique:?}: {e}"));
    }
}

#[test]
fn dark_pixels_and_lost_energy_are_noticed() {
    let expected = vec![Vec3::ONE; 1000];
    let mut speckled = expected.clone();
    speckled[..30].fill(Vec3::splat(0.9));
    assert!(same(&speckled, &expected).is_err(), "3 % of the pixels are darker");
    assert!(same(&vec![Vec3::splat(0.99); 1000], &expected).is_err(), "1 % of the energy is lost");
    assert!(same(&vec![Vec3::NAN; 1000], &expected).is_err());
    same(&expected, &expected).unwrap();
}
