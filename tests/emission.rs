//! Surfaces that shine by themselves: seen, and lighting the scene as closed forms and path tracing have it; unlit surfaces; and
//! backs that the camera looks through.

mod common;

use std::f32::consts::PI;

use common::frames::render;
use common::rooms::{add_quad_of, camera};
use glam::Vec3;
use gridlight::scene::testing::{box_room, diffuse, scene_from_quads};
use gridlight::scene::{Light, LitBy, Material, Scene};
use gridlight::settings::{BackFaces, Settings, ShadowFilter, Size, Technique};

fn settings(technique: Technique) -> Settings {
    Settings::default().changed(|s| {
        s.render.technique = technique;
        s.picture.size = Size { width: 32, height: 18 };
        s.many_lights.clamp = 0.0;
        s.lgh.filter = ShadowFilter::None;
    })
}

fn mean(pixels: &[Vec3]) -> Vec3 {
    pixels.iter().sum::<Vec3>() / pixels.len() as f32
}

fn within(found: f32, expected: f32, relative: f32) -> Result<(), String> {
    let off = found / expected - 1.0;
    if off.abs() <= relative { Ok(()) } else { Err(format!("{found} is {:.2} % off {expected}", 100.0 * off)) }
}

/// A rectangle at this height, so large from its middle along x and z, which faces down.
fn facing_down(y: f32, half: [f32; 2]) -> [Vec3; 4] {
    let [x, z] = half;
    [Vec3::new(-x, y, -z), Vec3::new(x, y, -z), Vec3::new(x, y, z), Vec3::new(-x, y, z)]
}

fn black(emission: Vec3) -> Material {
    Material { emission: emission.to_array(), ..diffuse("lamp", Vec3::ZERO) }
}

/// Without any other light.
fn lit_by_itself(mut scene: Scene) -> Scene {
    (scene.lights, scene.lit_by) = (vec![Light::DARK], LitBy::EmissiveSurfaces);
    scene
}

const PANEL_HEIGHT: f32 = 2.0;
const PANEL_HALF: [f32; 2] = [0.6, 0.4];
const FLOOR_HALF: f32 = 20.0;

/// A grey floor seen from right above, below a panel that the camera is under.
fn floor_under_a_panel(lamp: Material) -> Scene {
    let floor = facing_down(0.0, [FLOOR_HALF; 2]).map(|p| Vec3::new(p.x, 0.0, -p.z));
    let mut scene = scene_from_quads("floor", &[floor], diffuse("grey", Vec3::splat(0.5)));
    add_quad_of(&mut scene, facing_down(PANEL_HEIGHT, PANEL_HALF), lamp);
    scene.cameras = vec![camera(Vec3::new(0.0, 1.9, 0.0), Vec3::NEG_Y, 1.0)];
    lit_by_itself(scene)
}

/// The form factor from a place on the floor to the panel, from four rectangles with a corner right above the place.
fn form_factor(place: [f32; 2]) -> f32 {
    // Howell, configuration C-3: a rectangle parallel to an element of area below one of its corners.
    let corner = |a: f32, b: f32| {
        let [x, y] = [a / PANEL_HEIGHT, b / PANEL_HEIGHT];
        let part = |x: f32, y: f32| x / (1.0 + x * x).sqrt() * (y / (1.0 + x * x).sqrt()).atan();
        (part(x, y) + part(y, x)) / (2.0 * PI)
    };
    let [across, along] = [0, 1].map(|axis| [PANEL_HALF[axis] - place[axis], PANEL_HALF[axis] + place[axis]]);
    across.iter().flat_map(|a| along.iter().map(move |b| corner(*a, *b))).sum()
}

/// Of each pixel's centre the place that [`floor_under_a_panel`]'s camera sees there.
fn places(size: Size) -> impl Iterator<Item = [f32; 2]> {
    let half = 0.5_f32.tan() * 1.9;
    let at = |p: u32, n: u32| (p as f32 + 0.5) / n as f32 * 2.0 - 1.0;
    (0..size.width * size.height).map(move |i| {
        let aspect = size.width as f32 / size.height as f32;
        // The panel and the floor are the same seen from either side.
        [half * aspect * at(i % size.width, size.width), half * at(i / size.width, size.height)]
    })
}

/// Compares a picture of the floor: all of it within 1 % of the closed form, and each pixel within 5 %, which is what 1,024 points
/// a pixel leave of noise.
fn compare_floor(radiance: &[Vec3], size: Size, panel: f32) -> Result<(), String> {
    let expected: Vec<f32> = places(size).map(|place| 0.5 * panel * form_factor(place)).collect();
    within(mean(radiance).x, expected.iter().sum::<f32>() / expected.len() as f32, 0.01)?;
    radiance.iter().zip(&expected).try_for_each(|(found, expected)| within(found.x, *expected, 0.05))
}

#[test]
fn a_panel_over_a_floor_has_its_form_factor() {
    let scene = floor_under_a_panel(black(Vec3::splat(7.0)));
    let direct = settings(Technique::Direct).changed(|s| {
        s.environment.samples = 64;
        s.render.accumulate = 16;
    });
    let traced = settings(Technique::PathTrace).changed(|s| s.path_trace.samples = 1024);
    for settings in [direct, traced] {
        let radiance = render(&scene, &settings);
        let technique = settings.render.technique;
        println!("{technique:?}: mean {}", mean(&radiance).x);
        compare_floor(&radiance, settings.picture.size, 7.0).unwrap_or_else(|e| panic!("{technique:?}: {e}"));
        compare_floor(&radiance, settings.picture.size, 7.0 * 1.03).unwrap_err();
        compare_floor(&vec![Vec3::NAN; radiance.len()], settings.picture.size, 7.0).unwrap_err();
    }
}

/// What a filtered frame makes of the few points of each pixel keeps their light.
#[test]
fn a_filtered_frame_keeps_the_light_of_a_panel() {
    let scene = floor_under_a_panel(black(Vec3::splat(7.0)));
    let settings = settings(Technique::Direct).changed(|s| s.lgh.filter = ShadowFilter::Atrous);
    let radiance = render(&scene, &settings);
    let expected: f32 = places(settings.picture.size).map(|place| 0.5 * 7.0 * form_factor(place)).sum();
    within(mean(&radiance).x, expected / radiance.len() as f32, 0.03).unwrap();
}

/// A back shines where a surface has two sides, and not otherwise.
#[test]
fn single_sided_surfaces_shine_in_front_alone() {
    let above = |double_sided: bool| {
        let lamp = Material { double_sided, ..black(Vec3::splat(7.0)) };
        let mut scene = floor_under_a_panel(lamp);
        // From above the panel covers the middle of the picture; beside it there is floor.
        scene.cameras = vec![camera(Vec3::new(0.0, 2.5, 0.0), Vec3::NEG_Y, 1.0)];
        let settings = settings(Technique::Direct);
        render(&scene, &settings)[(9 * 32 + 16) as usize].x
    };
    assert_eq!((above(false), above(true)), (0.0, 7.0));
    // Light that goes up doubles the flux and not what arrives below.
    let both = floor_under_a_panel(Material { double_sided: true, ..black(Vec3::splat(7.0)) });
    let traced = settings(Technique::PathTrace).changed(|s| s.path_trace.samples = 1024);
    compare_floor(&render(&both, &traced), traced.picture.size, 7.0).unwrap();
}

/// A closed room with a block in it, lit by a panel below the ceiling.
fn box_with_a_panel(panel: f32) -> Scene {
    let mut scene = box_room(4.0, Vec3::new(0.7, 0.5, 0.3));
    add_quad_of(&mut scene, facing_down(1.95, [0.7, 0.5]), black(Vec3::new(1.0, 0.9, 0.75) * panel));
    let side =
        [Vec3::new(0.5, -2.0, 0.4), Vec3::new(1.3, -2.0, 0.0), Vec3::new(1.3, -0.5, 0.0), Vec3::new(0.5, -0.5, 0.4)];
    add_quad_of(&mut scene, side, diffuse("screen", Vec3::splat(0.6)));
    scene.cameras = vec![camera(Vec3::new(-1.7, 0.2, 1.8), Vec3::new(0.8, -0.15, -0.9).normalize(), 1.2)];
    lit_by_itself(scene)
}

/// Energies of two pictures within a part of each other.
fn agree(found: Vec3, expected: Vec3, relative: f32) -> Result<(), String> {
    (0..3).try_for_each(|axis| within(found[axis], expected[axis], relative))
}

#[test]
fn a_room_lit_by_its_panel_is_as_bright_as_path_traced() {
    let scene = box_with_a_panel(15.0);
    let traced = settings(Technique::PathTrace).changed(|s| s.path_trace.samples = 1024);
    let truth = mean(&render(&scene, &traced));
    for technique in [Technique::BruteForce, Technique::Lgh] {
        let settings = settings(technique).changed(|s| {
            s.many_lights.vpls = 4000;
            s.render.accumulate = 16;
            s.environment.samples = 16;
            s.lgh.alpha = 2.0;
        });
        let found = mean(&render(&scene, &settings));
        println!("{technique:?}: {found}, path tracing {truth}");
        agree(found, truth, 0.01).unwrap_or_else(|e| panic!("{technique:?}: {e}"));
        agree(found, 1.03 * truth, 0.01).unwrap_err();
    }
    assert!(agree(Vec3::NAN, truth, 0.01).is_err());
}

/// Points of point-based global illumination are lit by the panel; the reference for one bounce is path tracing.
#[test]
fn points_are_lit_by_a_panel() {
    let scene = box_with_a_panel(15.0);
    let one_bounce = |technique| {
        let settings = settings(technique).changed(|s| {
            s.many_lights.bounces = 1;
            s.path_trace.samples = 256;
            s.environment.samples = 16;
            s.pbgi.points = 16_384;
        });
        let test = common::gpu();
        let gpu = &test.gpu;
        let mut uploaded = gridlight::renderer::UploadedScene::new(gpu, &scene).unwrap();
        let log2 = (technique == Technique::Pbgi).then_some(14);
        uploaded.spread_points(&scene, log2).unwrap();
        let job = gridlight::renderer::Job::new(gpu, &uploaded, &scene.cameras[0], &settings);
        let mut renderer = gridlight::renderer::Renderer::new(&job).unwrap();
        renderer.run_in_steps(200.0, &mut |_, _| std::ops::ControlFlow::Continue(())).unwrap();
        let radiance: Vec<Vec3> = renderer.read_radiance().unwrap().chunks_exact(3).map(Vec3::from_slice).collect();
        mean(&radiance)
    };
    let (found, truth) = (one_bounce(Technique::Pbgi), one_bounce(Technique::PathTrace));
    println!("points: {found}, path tracing {truth}");
    agree(found, truth, 0.05).unwrap();
}

/// Unlit surfaces have their colour in whatever light, and light nothing.
#[test]
fn unlit_surfaces_are_their_colour() {
    let mut scene = floor_under_a_panel(Material { is_unlit: true, ..diffuse("sign", Vec3::new(0.2, 0.4, 0.8)) });
    scene.cameras = vec![camera(Vec3::new(0.0, 2.5, 0.0), Vec3::NEG_Y, 1.0)];
    let middle =
        |scene: &Scene| render(scene, &settings(Technique::Lgh).changed(|s| s.many_lights.vpls = 1000))[9 * 32 + 16];
    let radiance = middle(&scene);
    assert!(radiance.distance(Vec3::new(0.2, 0.4, 0.8)) < 1e-3, "{radiance}");
    scene.lights = vec![Light::Directional { direction_ws: Vec3::NEG_Y, irradiance: Vec3::splat(100.0) }];
    assert_eq!(middle(&scene), radiance);
    // Nothing comes from it: without a light the floor below is black.
    scene.lights = vec![Light::DARK];
    scene.cameras = vec![camera(Vec3::new(0.0, 1.9, 0.0), Vec3::NEG_Y, 1.0)];
    assert_eq!(middle(&scene), Vec3::ZERO);
}

/// The camera looks into a room through the backs of its walls, which light still meets.
#[test]
fn backs_are_kept_or_looked_through() {
    let mut room = box_room(2.0, Vec3::splat(0.5));
    room.lights = vec![Light::Point { position_ws: Vec3::ZERO, intensity: Vec3::ONE }];
    room.cameras = vec![camera(Vec3::new(0.0, 0.0, 3.0), Vec3::NEG_Z, 0.4)];
    let seen = |room: &Scene, technique, back_faces| {
        let settings = settings(technique).changed(|s| {
            s.picture.back_faces = back_faces;
            s.many_lights.vpls = 1000;
            s.path_trace.samples = 64;
        });
        mean(&render(room, &settings)).x
    };
    for technique in [Technique::PathTrace, Technique::Lgh] {
        assert_eq!(seen(&room, technique, BackFaces::Keep), 0.0, "the outside is dark");
        let inside = seen(&room, technique, BackFaces::Cull);
        // From within, at the place where the wall is that is looked through, the picture is nearly the same.
        let mut within_room = box_room(2.0, Vec3::splat(0.5));
        within_room.lights.clone_from(&room.lights);
        within_room.cameras.clone_from(&room.cameras);
        within_room.cameras[0].near = 2.01;
        let cut = seen(&within_room, technique, BackFaces::Keep);
        within(inside, cut, 0.02).unwrap_or_else(|e| panic!("{technique:?}: {e}"));
        assert!(inside > 0.05, "{inside}");
    }
    room.materials[0].double_sided = true;
    assert_eq!(seen(&room, Technique::PathTrace, BackFaces::Cull), 0.0, "two sides have no back");
}
