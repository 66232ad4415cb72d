//! Light of the environment: what shaders draw and read against their twin, and pictures whose answer is known.

mod common;

use std::sync::Arc;

use common::frames::render;
use common::rooms::camera;
use common::written::Written;
use glam::Vec3;
use gridlight::environment::{Environment, SamplingTable, turned};
use gridlight::gpu::{ComputeWork, Executor};
use gridlight::graph::Access;
use gridlight::passes::{Frame, FrameShape, shader, threads};
use gridlight::renderer::{Job, UploadedScene};
use gridlight::scene::Scene;
use gridlight::scene::testing::{box_room, diffuse, plane, scene_from_quads};
use gridlight::settings::{Settings, ShadowFilter, Size, Switch, Technique, View};

/// Numbers of one draw (`tests/sample_environment.comp.glsl`).
type Draw = [f32; 12];
const DRAWS: u32 = 4096;

/// An image of two colours and one bright texel, of odd sizes.
fn uneven(size: [u32; 2]) -> Environment {
    let texel = |i: u32| {
        let (x, y) = (i % size[0], i / size[0]);
        let bright = if [x, y] == [size[0] / 3, size[1] / 4] { 4000.0 } else { 1.0 };
        [bright * (0.2 + 0.8 * (y as f32 / size[1] as f32)), bright * (1 + x % 3) as f32, 0.25]
    };
    Environment { size, radiance: (0..size[0] * size[1]).map(texel).collect(), suns: Vec::new() }
}

fn under(mut scene: Scene, environment: Environment) -> Scene {
    scene.lights.clear();
    scene.environment = Some(Arc::new(environment));
    scene
}

/// What shaders draw from an environment and read of it.
fn draws(environment: &Environment, settings: &Settings) -> Vec<Draw> {
    let test = common::gpu();
    let scene = under(plane(2.0), environment.clone());
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    let job = Job::new(&test.gpu, &uploaded, &scene.cameras[0], settings);
    let mut frame = Frame::new(FrameShape::new(&job));
    let out = frame.graph.persistent_buffer("draws", (size_of::<Draw>() as u32 * DRAWS).into());
    let work = shader("tests/sample_environment", threads(DRAWS));
    let work = ComputeWork { uses_scene: true, push: vec![DRAWS], ..work };
    let pass = frame.compute("draw", work).bind("draws", out, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    let executor = Executor::new(&test.gpu, frame.graph, Some(Arc::clone(uploaded.set()))).unwrap();
    Written::by_graph(&executor, &job.frame_data()).all("draw", "draws")
}

fn close(found: f32, expected: f32, relative: f32, what: &str) -> Result<(), String> {
    let off = (found - expected).abs();
    if off <= relative * expected.abs().max(1e-6) { Ok(()) } else { Err(format!("{what}: {found}, not {expected}")) }
}

/// Whether a draw is what the twin makes of the same numbers.
fn check_draw(
    draw: &Draw,
    environment: &Environment,
    table: &SamplingTable,
    settings: &Settings,
) -> Result<(), String> {
    let [u, v, x, y, z, density, again_u, again_v, density_again, r, g, b] = *draw;
    let (scale, turn_deg) = (settings.environment.scale, settings.environment.turn_deg);
    let expected = table.sample([u, v]);
    let direction = Vec3::new(x, y, z);
    let wanted = turned(expected.direction, turn_deg);
    let found_it = direction.distance(wanted) <= 1e-5;
    if !found_it {
        return Err(format!("{direction} instead of {wanted}"));
    }
    close(density, expected.pdf, 1e-3, "density")?;
    // Next to the edge of a cell the way back may end in the neighbour.
    if (density_again - density).abs() <= 1e-3 * density {
        // Where the lines of longitude lie closer, a direction knows its own less well.
        let across = (1.0 - y * y).sqrt().max(0.01);
        close(1.0 + again_u, 1.0 + u, 1e-4 / across, "1 + u")?;
        close(1.0 + again_v, 1.0 + v, 1e-4, "1 + v")?;
    }
    // Half floats, and texels that are steep.
    let radiance = scale * environment.radiance(expected.direction);
    close(r, radiance.x, 2e-2, "red")?;
    close(g, radiance.y, 2e-2, "green")?;
    close(b, radiance.z, 2e-2, "blue")
}

#[test]
fn shaders_draw_and_read_what_the_twin_does() {
    let settings = Settings::default().changed(|s| (s.environment.turn_deg, s.environment.scale) = (75.0, 0.5));
    for environment in [uneven([37, 19]), uneven([700, 300]), Environment::uniform([1.0, 2.0, 3.0])] {
        let table = SamplingTable::new(&environment);
        let draws = draws(&environment, &settings);
        let again = draws.iter().filter(|d| (d[8] - d[5]).abs() <= 1e-3 * d[5]).count();
        assert!(again * 50 > 49 * draws.len(), "of {} directions {again} have their density", draws.len());
        for draw in &draws {
            check_draw(draw, &environment, &table, &settings).unwrap();
        }
        let mut wrong = draws[0];
        wrong[5] *= 1.01;
        check_draw(&wrong, &environment, &table, &settings).unwrap_err();
        check_draw(&draws[0], &environment, &table, &Settings::default()).unwrap_err();
    }
}

/// A ball of radius 1 as quads.
fn ball(albedo: f32) -> Scene {
    let rings = 24;
    let point = |i: i32, j: i32| {
        let (polar, angle) = (i as f32 / rings as f32, j as f32 / rings as f32);
        let (polar, angle) = (polar * std::f32::consts::PI, angle * std::f32::consts::PI);
        Vec3::new(polar.sin() * angle.cos(), polar.cos(), polar.sin() * angle.sin())
    };
    let quads: Vec<[Vec3; 4]> = (0..rings)
        .flat_map(|i| (0..2 * rings).map(move |j| (i, j)))
        .map(|(i, j)| [point(i, j), point(i, j + 1), point(i + 1, j + 1), point(i + 1, j)])
        .collect();
    let mut scene = scene_from_quads("ball", &quads, diffuse("paint", Vec3::splat(albedo)));
    scene.cameras = vec![camera(Vec3::new(0.0, 0.5, 4.0), Vec3::new(0.0, -0.12, -1.0).normalize(), 0.6)];
    scene
}

fn settings(technique: Technique) -> Settings {
    Settings::default().changed(|s| {
        s.render.technique = technique;
        s.picture.size = Size { width: 64, height: 36 };
        s.many_lights.vpls = 1000;
        s.path_trace.samples = 64;
        s.environment.samples = 16;
    })
}

/// Whether the mean of pixels and each of them are what is expected.
fn check_pixels(pixels: &[f32], expected: f32, of_mean: f32, of_each: f32) -> Result<(), String> {
    let mean = pixels.iter().sum::<f32>() / pixels.len() as f32;
    close(mean, expected, of_mean, "mean")?;
    pixels.iter().try_for_each(|pixel| close(*pixel, expected, of_each, "pixel"))
}

const TECHNIQUES: [Technique; 4] = [Technique::Direct, Technique::PathTrace, Technique::Lgh, Technique::BruteForce];

#[test]
fn a_convex_body_shows_its_albedo_in_front_of_a_white_background() {
    for technique in TECHNIQUES {
        let picture = render(&under(ball(0.5), Environment::uniform([1.0; 3])), &settings(technique));
        let (background, body): (Vec<f32>, Vec<f32>) = picture.iter().map(|p| p.x).partition(|p| *p > 0.95);
        assert!(background.len() > 800 && body.len() > 600, "{technique:?}: {} {}", background.len(), body.len());
        check_pixels(&background, 1.0, 1e-3, 1e-3).unwrap_or_else(|e| panic!("{technique:?}: {e}"));
        check_pixels(&body, 0.5, 0.005, 0.25).unwrap_or_else(|e| panic!("{technique:?}: {e}"));
        check_pixels(&body, 0.51, 0.005, 0.25).unwrap_err();
    }
    check_pixels(&[f32::NAN], 0.5, 1.0, 1.0).unwrap_err();
}

#[test]
fn an_open_plane_receives_pi_times_the_radiance() {
    for technique in TECHNIQUES {
        let mut scene = under(plane(40.0), Environment::uniform([1.0, 0.5, 0.25]));
        scene.materials[0].base_color = [0.8, 0.8, 0.8, 1.0];
        scene.cameras = vec![camera(Vec3::new(0.0, 2.0, 0.0), Vec3::NEG_Y, 1.0)];
        let picture = render(&scene, &settings(technique));
        for (channel, radiance) in [1.0, 0.5, 0.25].into_iter().enumerate() {
            let pixels: Vec<f32> = picture.iter().map(|p| p[channel]).collect();
            check_pixels(&pixels, 0.8 * radiance, 0.005, 0.25).unwrap_or_else(|e| panic!("{technique:?}: {e}"));
        }
    }
}

/// An L of floor and wall under an environment with a bright side.
fn corner() -> Scene {
    let floor =
        [Vec3::new(-2.0, 0.0, 2.0), Vec3::new(2.0, 0.0, 2.0), Vec3::new(2.0, 0.0, -2.0), Vec3::new(-2.0, 0.0, -2.0)];
    let wall =
        [Vec3::new(-2.0, 0.0, -2.0), Vec3::new(2.0, 0.0, -2.0), Vec3::new(2.0, 3.0, -2.0), Vec3::new(-2.0, 3.0, -2.0)];
    let mut scene =
        under(scene_from_quads("corner", &[floor, wall], diffuse("paint", Vec3::splat(0.6))), uneven([37, 19]));
    scene.cameras = vec![camera(Vec3::new(0.5, 1.6, 3.0), Vec3::new(-0.1, -0.3, -1.0).normalize(), 1.0)];
    scene
}

fn mean(picture: &[Vec3]) -> f32 {
    picture.iter().map(|p| p.element_sum()).sum::<f32>() / picture.len() as f32
}

#[test]
fn a_mean_of_direct_light_is_what_paths_without_bounces_find() {
    let paths = settings(Technique::PathTrace).changed(|s| (s.many_lights.bounces, s.path_trace.samples) = (0, 256));
    let direct = settings(Technique::Direct).changed(|s| s.render.accumulate = 16);
    let [paths, direct] = [paths, direct].map(|settings| mean(&render(&corner(), &settings)));
    close(direct, paths, 0.01, "direct light").unwrap();
    let bounced = mean(&render(&corner(), &settings(Technique::PathTrace)));
    close(bounced, paths, 0.01, "light with bounces").unwrap_err();
}

#[test]
fn light_paths_from_the_environment_bring_what_paths_from_the_camera_find() {
    for with_sun in [false, true] {
        let mut scene = corner();
        if with_sun {
            scene.lights = plane(1.0).lights;
        }
        let indirect = |technique: Technique| {
            let settings = settings(technique).changed(|s| {
                s.render.direct = Switch::Off;
                s.many_lights.vpls = 20_000;
                s.many_lights.clamp = 0.0;
                s.path_trace.samples = 256;
                s.lgh.filter = ShadowFilter::None;
                s.lgh.alpha = 2.0;
            });
            mean(&render(&scene, &settings))
        };
        let paths = indirect(Technique::PathTrace);
        close(indirect(Technique::BruteForce), paths, 0.02, "every light").unwrap();
        // As in rooms (tests/references.rs), coarse lights are nearer than what they stand for.
        close(indirect(Technique::Lgh), paths, 0.05, "the hierarchy").unwrap();
        close(0.94 * paths, paths, 0.05, "less").unwrap_err();
    }
}

/// Where floor and wall meet, the hierarchy's lights are nearer than what they stand for. Samples take that out, and the
/// filter, which works per unit of the hierarchy's lighting, brings a part of it back (docs/accuracy.md).
#[test]
fn the_filter_brings_back_a_part_of_the_hierarchys_error() {
    let scene = under(corner(), Environment::uniform([1.0; 3]));
    let energy = |technique: Technique, change: fn(&mut Settings)| {
        let settings = settings(technique).changed(|s| {
            s.render.direct = Switch::Off;
            (s.many_lights.vpls, s.many_lights.clamp) = (20_000, 0.0);
            s.path_trace.samples = 256;
        });
        mean(&render(&scene, &settings.changed(change)))
    };
    let paths = energy(Technique::PathTrace, |_| ());
    let of_paths = |change: fn(&mut Settings)| energy(Technique::Lgh, change) / paths;
    let unshadowed = of_paths(|s| (s.render.accumulate, s.many_lights.shadows) = (16, Switch::Off));
    let unfiltered = of_paths(|s| (s.render.accumulate, s.lgh.filter) = (16, ShadowFilter::None));
    let filtered = of_paths(|s| s.render.accumulate = 16);
    println!("of the energy of paths: {unshadowed} without shadows, {unfiltered} unfiltered, {filtered} filtered");
    close(unfiltered, 1.0, 0.03, "unfiltered").unwrap();
    close(filtered, 1.0, 0.1, "filtered").unwrap();
    close(unshadowed, 1.0, 0.1, "without shadows").unwrap_err();
}

#[test]
fn the_view_of_visibility_tells_what_is_in_the_way() {
    let visible = |scene: Scene| {
        let settings = settings(Technique::Lgh).changed(|s| s.render.view = View::EnvironmentVisibility);
        render(&under(scene, Environment::uniform([1.0; 3])), &settings)
    };
    let (background, body): (Vec<Vec3>, Vec<Vec3>) = visible(ball(0.5)).into_iter().partition(|p| p.y == 0.0);
    assert!(background.len() > 800 && body.len() > 600, "{} {}", background.len(), body.len());
    check_pixels(&body.iter().map(|p| p.x).collect::<Vec<_>>(), 1.0, 1e-3, 1e-3).unwrap();
    let mut room = box_room(4.0, Vec3::splat(0.5));
    room.cameras = vec![camera(Vec3::new(0.0, 0.2, 1.5), Vec3::NEG_Z, 1.2)];
    assert!(visible(room).iter().all(|p| p.x == 0.0 && p.y > 0.0));
    let corner: Vec<Vec3> = visible(corner()).into_iter().filter(|p| p.y > 0.0).collect();
    assert!(corner.iter().any(|p| p.x > 0.0 && p.x < 1.0), "a wall hides a part");
}

#[test]
fn scaling_turning_and_leaving_out() {
    let of = |change: fn(&mut Settings)| render(&corner(), &settings(Technique::Direct).changed(change));
    let plain = of(|_| ());
    let doubled = of(|s| s.environment.scale = 2.0);
    close(mean(&doubled), 2.0 * mean(&plain), 1e-4, "twice the light").unwrap();
    let around = of(|s| s.environment.turn_deg = 360.0);
    close(mean(&around), mean(&plain), 0.01, "a whole turn").unwrap();
    let turned = of(|s| s.environment.turn_deg = 180.0);
    close(mean(&turned), mean(&plain), 0.01, "half a turn").unwrap_err();
    // Without direct light the environment is neither seen nor lights what is seen.
    assert_eq!(mean(&of(|s| s.render.direct = Switch::Off)), 0.0);
    assert_eq!(mean(&of(|s| s.environment.scale = 0.0)), 0.0);
    let unlit = of(|s| s.environment.samples = 0);
    assert!(unlit.iter().any(|p| p.x == 0.0) && unlit.iter().any(|p| p.x > 0.0), "seen, but lighting nothing");
}

#[test]
fn a_black_environment_changes_nothing() {
    let picture = |environment: Option<Environment>| {
        let mut scene = corner();
        scene.lights = plane(1.0).lights;
        scene.environment = environment.map(Arc::new);
        TECHNIQUES.map(|technique| render(&scene, &settings(technique)))
    };
    assert_eq!(picture(None), picture(Some(Environment::uniform([0.0; 3]))));
}
