//! The reference techniques against known answers and against each other, and accumulation.

mod common;

use std::f32::consts::PI;
use std::ops::ControlFlow;

use common::frames::render;
use common::rooms::{add_quad, camera};
use glam::Vec3;
use gridlight::renderer::{Job, Renderer, UploadedScene};
use gridlight::scene::testing::{box_room, diffuse, scene_from_quads};
use gridlight::scene::{Light, Scene};
use gridlight::settings::{Settings, ShadowFilter, Size, Switch, Technique};

fn settings(technique: Technique) -> Settings {
    Settings::default().changed(|s| {
        s.render.technique = technique;
        s.picture.size = Size { width: 32, height: 18 };
        s.many_lights.vpls = 1000;
        s.many_lights.clamp = 0.0;
        s.path_trace.samples = 64;
        s.lgh.filter = ShadowFilter::None;
        s.lgh.alpha = 2.0;
    })
}

fn mean(pixels: &[Vec3]) -> Vec3 {
    pixels.iter().sum::<Vec3>() / pixels.len() as f32
}

fn within(found: f32, expected: f32, relative: f32) -> Result<(), String> {
    let off = found / expected - 1.0;
    if off.abs() <= relative { Ok(()) } else { Err(format!("{found} is {:.2} % off {expected}", 100.0 * off)) }
}

/// A sphere of radius 2 seen from inside, as `4 * rings * rings` quads: an integrating sphere.
fn sphere(albedo: f32) -> Scene {
    let rings = 24;
    let point = |i: i32, j: i32| {
        let (polar, angle) = (i as f32 / rings as f32 * PI, j as f32 / (2 * rings) as f32 * 2.0 * PI);
        2.0 * Vec3::new(polar.sin() * angle.cos(), polar.cos(), polar.sin() * angle.sin())
    };
    let quads: Vec<[Vec3; 4]> = (0..rings)
        .flat_map(|i| (0..2 * rings).map(move |j| (i, j)))
        .map(|(i, j)| [point(i, j), point(i, j + 1), point(i + 1, j + 1), point(i + 1, j)])
        .collect();
    let mut scene = scene_from_quads("sphere", &quads, diffuse("paint", Vec3::splat(albedo)));
    scene.lights = vec![Light::Point { position_ws: Vec3::ZERO, intensity: Vec3::splat(4.0) }];
    scene.cameras = vec![camera(Vec3::new(-1.0, 0.2, 0.0), Vec3::new(1.0, -0.1, 0.2).normalize(), 1.0)];
    scene
}

/// Radiance in the sphere of albedo 1/2 after three bounces: a lamp of 4 W/sr two metres from every point gives the
/// irradiance 1, and each bounce of an integrating sphere gives albedo times the irradiance before it.
const FURNACE: f32 = 0.5 / PI * (1.0 + 0.5 + 0.25 + 0.125);

/// The facets lie up to 0.5 % inside the sphere, and their corners outside their planes see a little less.
const FACETS: f32 = 0.015;

#[test]
fn white_furnace_by_path_tracing_and_brute_force() {
    for technique in [Technique::PathTrace, Technique::BruteForce] {
        let radiance = mean(&render(&sphere(0.5), &settings(technique))).x;
        within(radiance, FURNACE, FACETS).unwrap_or_else(|e| panic!("{technique:?}: {e}"));
    }
}

#[test]
fn white_furnace_by_the_hierarchy() {
    // Coarse lights of a sphere lie inside it, nearer than the surfaces they stand for: 4 % at alpha 2.
    for shadows in [Switch::On, Switch::Off] {
        let settings = settings(Technique::Lgh).changed(|s| s.many_lights.shadows = shadows);
        let radiance = mean(&render(&sphere(0.5), &settings)).x;
        within(radiance, FURNACE, 0.05).unwrap_or_else(|e| panic!("shadows {shadows:?}: {e}"));
    }
}

#[test]
fn a_furnace_with_one_bounce_less_is_noticed() {
    let settings = settings(Technique::PathTrace).changed(|s| s.many_lights.bounces = 2);
    let radiance = mean(&render(&sphere(0.5), &settings)).x;
    assert!(radiance < FURNACE * (1.0 - FACETS), "{radiance}");
    assert!(within(radiance, FURNACE, FACETS).is_err() && within(f32::NAN, FURNACE, FACETS).is_err());
}

/// The spot is 3 cm wide at a metre; its brightness rises with the square of the cosine between these two.
const OUTER_COS: f32 = 1.0 - 5e-4;
const INNER_COS: f32 = OUTER_COS + 1e-4;

/// A white floor under a white ceiling two metres above it, on which a spot light makes one small bright spot.
fn spot_on_the_ceiling() -> Scene {
    let (h, y) = (20.0, 2.0);
    let floor = [Vec3::new(-h, 0.0, h), Vec3::new(h, 0.0, h), Vec3::new(h, 0.0, -h), Vec3::new(-h, 0.0, -h)];
    let ceiling = [Vec3::new(-h, y, -h), Vec3::new(h, y, -h), Vec3::new(h, y, h), Vec3::new(-h, y, h)];
    let mut scene = scene_from_quads("spot", &[floor, ceiling], diffuse("white", Vec3::splat(0.8)));
    scene.lights = vec![Light::Spot {
        position_ws: Vec3::new(0.0, 1.0, 0.0),
        direction_ws: Vec3::Y,
        intensity: Vec3::splat(1e4),
        inner_cos: INNER_COS,
        outer_cos: OUTER_COS,
    }];
    scene.cameras = vec![camera(Vec3::new(0.0, 0.9, 0.0), Vec3::NEG_Y, 1.0)];
    scene
}

/// Indirect radiance of the floor `r` metres from the point below the spot.
fn floor_radiance(r: f32) -> f32 {
    // Flux into the cone times the ceiling's albedo; radiant intensity cos / pi; irradiance cos / d^2.
    let flux = 1e4 * 2.0 * PI * ((INNER_COS - OUTER_COS) / 3.0 + 1.0 - INNER_COS) * 0.8;
    let distance_squared = 4.0 + r * r;
    let cosine_squared = 4.0 / distance_squared;
    0.8 / PI * flux / PI * cosine_squared / distance_squared
}

/// The worst pixel against the formula.
fn compare_floor(radiance: &[Vec3], size: Size, expected: impl Fn(f32) -> f32) -> Result<(), String> {
    assert_eq!(radiance.len(), (size.width * size.height) as usize);
    let half = 0.5_f32.tan() * 0.9;
    for (i, found) in radiance.iter().enumerate() {
        let (x, y) = (i as u32 % size.width, i as u32 / size.width);
        let at = |p: u32, n: u32| (p as f32 + 0.5) / n as f32 * 2.0 - 1.0;
        let aspect = size.width as f32 / size.height as f32;
        let r = half * (at(x, size.width) * aspect).hypot(at(y, size.height));
        within(found.x, expected(r), 0.01).map_err(|e| format!("pixel {x}, {y}: {e}"))?;
    }
    Ok(())
}

#[test]
fn a_single_light_over_a_plane_follows_the_formula() {
    let scene = spot_on_the_ceiling();
    for (technique, shadows) in
        [(Technique::BruteForce, Switch::On), (Technique::BruteForce, Switch::Off), (Technique::Lgh, Switch::Off)]
    {
        // One bounce, so that only the spot shines; all its VPLs are within a centimetre.
        let settings = settings(technique).changed(|s| {
            s.many_lights.bounces = 1;
            s.many_lights.vpls = 64;
            s.lgh.first_level = 0;
            s.render.direct = Switch::Off;
            s.many_lights.shadows = shadows;
        });
        let radiance = render(&scene, &settings);
        compare_floor(&radiance, settings.picture.size, floor_radiance)
            .unwrap_or_else(|e| panic!("{technique:?}, shadows {shadows:?}: {e}"));
        assert!(compare_floor(&radiance, settings.picture.size, |r| 1.03 * floor_radiance(r)).is_err());
    }
}

/// A room with a lamp in a corner and a wall that divides it.
fn divided_room() -> Scene {
    let mut scene = box_room(4.0, Vec3::new(0.7, 0.5, 0.3));
    let wall =
        [Vec3::new(0.0, -2.0, -2.0), Vec3::new(0.0, -2.0, 0.5), Vec3::new(0.0, 2.0, 0.5), Vec3::new(0.0, 2.0, -2.0)];
    add_quad(&mut scene, wall);
    scene.lights = vec![Light::Point { position_ws: Vec3::new(-1.0, 0.9, -1.0), intensity: Vec3::splat(5.0) }];
    scene.cameras = vec![camera(Vec3::new(1.8, 0.3, 1.6), Vec3::new(-0.7, -0.2, -0.9).normalize(), 1.0)];
    scene
}

#[test]
fn references_agree_with_each_other() {
    let scene = divided_room();
    let traced = settings(Technique::PathTrace).changed(|s| {
        s.path_trace.samples = 512;
        s.render.direct = Switch::Off;
    });
    let brute = settings(Technique::BruteForce).changed(|s| {
        s.many_lights.vpls = 500;
        s.render.accumulate = 8;
        s.render.direct = Switch::Off;
    });
    let (traced, brute) = (mean(&render(&scene, &traced)), mean(&render(&scene, &brute)));
    for axis in 0..3 {
        // Noise of about 0.5 % on either side.
        within(brute[axis], traced[axis], 0.02).unwrap();
    }
    let open = settings(Technique::BruteForce).changed(|s| {
        s.many_lights.vpls = 500;
        s.render.direct = Switch::Off;
        s.many_lights.shadows = Switch::Off;
    });
    let open = mean(&render(&scene, &open));
    assert!(open.x > 1.02 * traced.x, "without shadows the wall lets light through: {} {}", open.x, traced.x);
}

#[test]
fn path_tracing_noise_falls_as_one_over_the_samples() {
    let scene = divided_room();
    let with = |samples, seed| {
        let settings = settings(Technique::PathTrace).changed(|s| {
            s.path_trace.samples = samples;
            s.tracing.seed = seed;
            s.render.direct = Switch::Off;
        });
        render(&scene, &settings)
    };
    let variance = |samples| {
        let (a, b) = (with(samples, 1), with(samples, 2));
        a.iter().zip(&b).map(|(a, b)| (*a - *b).length_squared()).sum::<f32>()
    };
    let ratio = variance(16) / variance(64);
    // 4 for independent samples; stratified first bounces do a little better.
    assert!((3.0..8.0).contains(&ratio), "four times the samples divide the variance by {ratio}");
}

#[test]
fn accumulated_frames_are_antialiased_and_keep_the_energy() {
    let mut scene = box_room(4.0, Vec3::splat(0.6));
    // Light from behind an edge: half of the wall is lit.
    let shade =
        [Vec3::new(-2.0, 0.5, -1.0), Vec3::new(-2.0, 0.5, 0.3), Vec3::new(0.2, 0.5, 0.3), Vec3::new(0.2, 0.5, -1.0)];
    add_quad(&mut scene, shade);
    scene.lights = vec![Light::Point { position_ws: Vec3::new(0.0, 1.5, 0.0), intensity: Vec3::splat(5.0) }];
    scene.cameras = vec![camera(Vec3::new(1.5, 1.2, 1.5), Vec3::new(-0.7, -0.6, -0.9).normalize(), 1.0)];
    let direct = settings(Technique::Direct).changed(|s| s.render.technique = Technique::Direct);
    let one = render(&scene, &direct);
    let many = render(&scene, &direct.changed(|s| s.render.accumulate = 64));
    within(mean(&many).x, mean(&one).x, 0.03).unwrap();
    // A pixel in the shadow is black in every frame; one that the shadow's edge crosses is neither black nor lit.
    let black = |pixels: &[Vec3]| pixels.iter().filter(|p| p.x == 0.0).count();
    assert!(black(&many) > 0 && black(&many) < black(&one), "{} of {}", black(&many), black(&one));
}

#[test]
fn a_stopped_reference_keeps_its_brightness() {
    let test = common::gpu();
    let scene = sphere(0.5);
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    for technique in [Technique::PathTrace, Technique::BruteForce] {
        let mut renderer =
            Renderer::new(&Job::new(&test.gpu, &uploaded, &scene.cameras[0], &settings(technique))).unwrap();
        let frame = renderer.run_in_steps(0.001, &mut |_, _| ControlFlow::Break(())).unwrap();
        assert!(frame.rounds_done > 0 && frame.rounds_done < frame.rounds, "{frame:?}");
        let pixels: Vec<Vec3> = renderer.read_radiance().unwrap().chunks_exact(3).map(Vec3::from_slice).collect();
        within(mean(&pixels).x, FURNACE, 0.1).unwrap_or_else(|e| panic!("{technique:?}: {e}"));
    }
}
