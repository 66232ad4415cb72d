//! Final gathering over the lighting grid hierarchy: where the answer is known, against path tracing, and against the twin.

mod common;

use std::f32::consts::PI;

use common::compare::{near, within};
use common::points::{Rendered, render, under_sky};
use common::rooms::{add_quad, camera, inside_of_ball, lamp_room};
use glam::Vec3;
use gridlight::cpu::lights::{blend_weight, light_response, lobe_of_level};
use gridlight::cpu::micro_buffers::{place_of_leaf_key, unpack_leaf};
use gridlight::scene::testing::{diffuse, scene_from_quads};
use gridlight::scene::{Light, Scene};
use gridlight::settings::{Levels, LightSet, MicroFill, Settings, Size, Switch, Technique};
use gridlight::shared::{FrameData, GridLight, GridPlacement};

fn settings() -> Settings {
    Settings::default().changed(|s| {
        s.render.technique = Technique::FinalGather;
        s.render.direct = Switch::Off;
        s.picture.size = Size { width: 64, height: 36 };
        s.pbgi.points = 1 << 12;
        s.many_lights.vpls = 4000;
    })
}

fn mean(radiance: &[Vec3]) -> Vec3 {
    radiance.iter().copied().sum::<Vec3>() / radiance.len() as f32
}

fn check_mean(found: Vec3, expected: Vec3, tolerance: f32) -> Result<(), String> {
    let is_near = within((found / expected - 1.0).abs().max_element(), tolerance);
    if is_near { Ok(()) } else { Err(format!("{found}, not {expected}")) }
}

const ALBEDO: f32 = 0.6;

/// Light of surfaces in a ball after so many bounces, where its walls get an irradiance of pi from the lamp.
fn series(bounces: u32) -> Vec3 {
    Vec3::splat((1..=bounces).map(|bounce| ALBEDO.powi(bounce as i32 + 1)).sum())
}

#[test]
fn in_a_ball_bounces_are_a_geometric_series() {
    let scene = inside_of_ball(ALBEDO);
    // Grid lights are blended by where they are, which loses a few percent of what the hierarchy has here.
    for bounces in [2, 3] {
        let found = mean(&render(&scene, &settings().changed(|s| s.many_lights.bounces = bounces)).radiance);
        check_mean(found, series(bounces), 0.05).unwrap();
        check_mean(found, series(bounces - 1), 0.05).unwrap_err();
    }
}

/// A floor with a roof over a part of it and a wall behind.
fn corner(albedo: Vec3) -> Scene {
    let level = |y: f32, h: f32| [Vec3::new(-h, y, h), Vec3::new(h, y, h), Vec3::new(h, y, -h), Vec3::new(-h, y, -h)];
    let mut scene = scene_from_quads("roof", &[level(0.0, 3.0)], diffuse("paint", albedo));
    add_quad(&mut scene, level(1.0, 0.8));
    let foot = Vec3::new(-3.0, 0.0, -1.0);
    add_quad(&mut scene, [foot, foot + 6.0 * Vec3::X, foot + 6.0 * Vec3::X + 1.5 * Vec3::Y, foot + 1.5 * Vec3::Y]);
    let mut scene = under_sky(scene);
    scene.cameras = vec![camera(Vec3::new(0.0, 0.6, 2.5), Vec3::new(0.0, -0.1, -1.0).normalize(), 0.8)];
    scene
}

fn traced(scene: &Scene, bounces: u32) -> Vec3 {
    let reference = settings().changed(|s| {
        s.render.technique = Technique::PathTrace;
        s.many_lights.bounces = bounces;
        s.path_trace.samples = 256;
    });
    mean(&common::frames::render(scene, &reference))
}

#[test]
fn pictures_are_those_of_as_many_bounces_of_path_tracing() {
    for scene in [corner(Vec3::new(0.4, 0.8, 0.3)), lamp_room(Vec3::new(0.7, 0.5, 0.3))] {
        let found = mean(&render(&scene, &settings()).radiance);
        check_mean(found, traced(&scene, 3), 0.04).unwrap();
        check_mean(found, traced(&scene, 1), 0.04).unwrap_err();
    }
}

#[test]
fn lamps_that_are_looked_up_light_as_those_that_rays_look_for() {
    let scene = lamp_room(Vec3::splat(0.5));
    let [apart, both] = [LightSet::Vpl, LightSet::Both].map(|lights| {
        mean(
            &render(&scene, &settings().changed(|s| (s.many_lights.lights, s.render.direct) = (lights, Switch::On)))
                .radiance,
        )
    });
    check_mean(both, apart, 0.03).unwrap();
    // Alone they leave the first bounce.
    let alone = mean(&render(&scene, &settings().changed(|s| s.many_lights.lights = LightSet::Scene)).radiance);
    check_mean(alone, traced(&scene, 1), 0.05).unwrap();
}

/// Lights of all levels above S0.
fn grid_lights(rendered: &Rendered, data: &FrameData) -> Vec<GridLight> {
    let lights: Vec<GridLight> = rendered.written.last("grid_lights");
    let table: Vec<u32> = rendered.written.last("level_table");
    let range = |level: u32| {
        table[2 * level as usize] as usize..(table[2 * level as usize] + table[2 * level as usize + 1]) as usize
    };
    (1..=data.top_level).flat_map(|level| lights[range(level)].to_vec()).collect()
}

/// Irradiance of a place from every light in turn, without shadows.
fn looked_up(lights: &[GridLight], h_top: f32, data: &FrameData, [position, normal]: [Vec3; 2]) -> Vec3 {
    let sent = |light: &GridLight| {
        let offset = Vec3::from(light.position_ws) - position;
        let radius = data.alpha * h_top * 0.5_f32.powi((data.top_level - light.level) as i32);
        let weight = blend_weight(offset.length(), radius, light.level, 1, data.top_level);
        let kind = lobe_of_level(light.level, settings().lgh.lobe);
        Vec3::from(light.flux)
            * (weight * light_response(offset, normal, Vec3::from(light.lobe), kind, data.clamp_squared))
    };
    PI * lights.iter().map(sent).sum::<Vec3>()
}

/// What primary points have more than the direct light of `plain`, against the twin.
fn compare_lookups(rendered: &Rendered, plain: &Rendered, scale: f32) -> Result<usize, String> {
    let data = rendered.written.last::<FrameData>("frame_data")[0];
    let placement = rendered.written.last::<GridPlacement>("grid_placement")[0];
    let lights = grid_lights(rendered, &data);
    let leaves: Vec<[u32; 4]> = rendered.written.last("primary_leaves");
    let light =
        |rendered: &Rendered| rendered.written.all::<[f32; 3]>("point_light/light_primaries", "point_irradiance");
    let (all, direct) = (light(rendered), light(plain));
    for (key, leaves) in rendered.primaries().into_iter().zip(leaves) {
        let leaf = leaves.into_iter().min().filter(|leaf| *leaf != u32::MAX).ok_or("a point without a leaf")?;
        let (position, normal) =
            place_of_leaf_key(&rendered.cloud, unpack_leaf(&rendered.cloud, leaf), rendered.largest_triangle);
        let expected = scale * looked_up(&lights, placement.h_top, &data, [position, normal]);
        let found = Vec3::from(all[key as usize]) - Vec3::from(direct[key as usize]);
        if !near(found, expected, 2e-3 * expected.max_element().max(1e-3)) {
            return Err(format!("{found} at {key}, {expected} in the twin"));
        }
    }
    Ok(rendered.primaries().len())
}

#[test]
fn lookups_are_those_of_the_twin() {
    for (levels, micro) in [(Levels::Fixed(5), MicroFill::Rays), (Levels::Fixed(2), MicroFill::Points)] {
        let scene = lamp_room(Vec3::splat(0.6));
        let settings = settings().changed(|s| {
            s.many_lights.shadows = Switch::Off;
            s.lgh.levels = levels;
            s.pbgi.micro = micro;
        });
        let rendered = render(&scene, &settings);
        let plain = render(&scene, &settings.changed(|s| s.render.technique = Technique::Pbgi));
        assert_eq!(rendered.primaries(), plain.primaries());
        let compared = compare_lookups(&rendered, &plain, 1.0).unwrap_or_else(|e| panic!("{micro:?}: {e}"));
        assert!(compared > 100, "{compared} points");
        compare_lookups(&rendered, &plain, 1.01).unwrap_err();
    }
}

#[test]
fn the_same_seed_is_the_same_picture() {
    let scene = corner(Vec3::splat(0.7));
    let [first, second] = [0, 1].map(|_| render(&scene, &settings()).radiance);
    assert!(first == second);
    assert!(first != render(&scene, &settings().changed(|s| s.tracing.seed = 2)).radiance);
}

#[test]
fn nothing_comes_of_no_light_and_of_nothing_to_see() {
    let mut dark = corner(Vec3::ONE);
    dark.environment = None;
    dark.lights = vec![Light::DARK];
    let mut away = corner(Vec3::ONE);
    away.cameras = vec![camera(Vec3::new(0.0, 3.0, 2.5), Vec3::Y, 0.8)];
    let black = corner(Vec3::ZERO);
    for scene in [&dark, &away, &black] {
        let radiance = render(scene, &settings()).radiance;
        assert!(radiance.iter().all(|radiance| radiance.is_finite()));
    }
    assert!(render(&dark, &settings()).radiance.iter().all(|radiance| *radiance == Vec3::ZERO));
}
