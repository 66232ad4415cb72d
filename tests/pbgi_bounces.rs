//! More than one bounce of point-based global illumination: where the answer is known, against path tracing, and against the
//! twin.

mod common;

use std::collections::BTreeSet;
use std::sync::Arc;

use common::compare::{near, within};
use common::points::{Rendered, render, under_sky};
use common::rooms::{add_quad, camera, inside_of_ball};
use glam::Vec3;
use gridlight::cpu::gather_bounce::gather_bounce;
use gridlight::cpu::point_sides::{PointSides, has_bit};
use gridlight::environment;
use gridlight::micro_buffers::table;
use gridlight::scene::testing::{diffuse, scene_from_quads, shared_dir};
use gridlight::scene::{Scene, gltf};
use gridlight::settings::{Hemisphere, MicroFill, Settings, Size, Switch, Technique};
use gridlight::shared::{MicroTexel, PRIMARY_EDGE, SECONDARY_EDGE};

fn settings(bounces: u32) -> Settings {
    Settings::default().changed(|s| {
        s.render.technique = Technique::Pbgi;
        s.render.direct = Switch::Off;
        s.picture.size = Size { width: 64, height: 36 };
        s.pbgi.points = 1 << 12;
        s.pbgi.point_bounces = bounces;
    })
}

fn mean(radiance: &[Vec3]) -> Vec3 {
    radiance.iter().copied().sum::<Vec3>() / radiance.len() as f32
}

const ALBEDO: f32 = 0.6;

/// Light of surfaces in a ball after so many bounces, where its walls get an irradiance of pi from the lamp.
fn series(bounces: u32) -> f32 {
    (1..=bounces).map(|bounce| ALBEDO.powi(bounce as i32 + 1)).sum()
}

fn check_ball(bounces: u32, micro: MicroFill, expected: f32) -> Result<(), String> {
    let rendered = render(&inside_of_ball(ALBEDO), &settings(bounces).changed(|s| s.pbgi.micro = micro));
    let found = mean(&rendered.radiance).x;
    if within(found / expected - 1.0, 0.02) { Ok(()) } else { Err(format!("{micro:?}: {found}, not {expected}")) }
}

#[test]
fn in_a_ball_bounces_are_a_geometric_series() {
    for bounces in [1, 2, 3, 8] {
        check_ball(bounces, MicroFill::Rays, series(bounces)).unwrap();
    }
    check_ball(3, MicroFill::Rays, series(2)).unwrap_err();
    // The splatted way loses a few percent each time.
    check_ball(2, MicroFill::Points, series(1)).unwrap_err();
}

/// A white floor with a white roof over a part of it and a wall behind, all of it in sight of the sky.
fn corner() -> Scene {
    let level = |y: f32, h: f32| [Vec3::new(-h, y, h), Vec3::new(h, y, h), Vec3::new(h, y, -h), Vec3::new(-h, y, -h)];
    let mut scene = scene_from_quads("roof", &[level(0.0, 3.0)], diffuse("white", Vec3::ONE));
    add_quad(&mut scene, level(1.0, 0.8));
    let foot = Vec3::new(-3.0, 0.0, -1.0);
    add_quad(&mut scene, [foot, foot + 6.0 * Vec3::X, foot + 6.0 * Vec3::X + 1.5 * Vec3::Y, foot + 1.5 * Vec3::Y]);
    let mut scene = under_sky(scene);
    scene.cameras = vec![camera(Vec3::new(0.0, 0.6, 2.5), Vec3::new(0.0, -0.1, -1.0).normalize(), 0.8)];
    scene
}

#[test]
fn white_surfaces_close_in_on_the_white_sky() {
    let mut missing = f32::INFINITY;
    for bounces in [1, 2, 4, 8, 16] {
        let radiance = render(&corner(), &settings(bounces).changed(|s| s.render.direct = Switch::On)).radiance;
        let most = radiance.iter().fold(0.0_f32, |most, radiance| most.max(radiance.max_element()));
        assert!(most <= 1.0 + 2e-3, "{bounces} bounces: {most}");
        let left = 1.0 - mean(&radiance).x;
        assert!(left < 0.8 * missing, "{bounces} bounces: {left} missing, before {missing}");
        missing = left;
    }
    assert!(missing < 0.01, "{missing} missing");
}

/// Whether the mean light of a picture is that of as many bounces of path tracing to this share.
fn check_traced(scene: &Scene, [bounces, traced]: [u32; 2], tolerance: f32) -> Result<(), String> {
    let found = mean(&render(scene, &settings(bounces)).radiance);
    let reference = settings(1).changed(|s| {
        s.render.technique = Technique::PathTrace;
        s.many_lights.bounces = traced;
        s.path_trace.samples = 256;
    });
    let expected = mean(&common::frames::render(scene, &reference));
    let is_near = (found / expected - 1.0).abs().max_element() <= tolerance;
    if is_near { Ok(()) } else { Err(format!("{bounces} bounces: {found}, traced {expected}")) }
}

#[test]
fn pictures_are_those_of_as_many_bounces_of_path_tracing() {
    let mut scene = corner();
    scene.materials[0] = diffuse("green", Vec3::new(0.4, 0.8, 0.3));
    check_traced(&scene, [3, 3], 0.04).unwrap();
    check_traced(&scene, [1, 3], 0.04).unwrap_err();
}

/// What each lit point has after the second bounce against the twin.
fn compare_bounce(rendered: &Rendered, after: &[[f32; 3]]) -> Result<usize, String> {
    let written = &rendered.written;
    let vectors = |numbers: Vec<[f32; 3]>| numbers.into_iter().map(Vec3::from).collect::<Vec<_>>();
    let direct = vectors(written.last("point_irradiance"));
    let lending: Vec<u32> = written.last("lending_bits");
    let cloud = &rendered.cloud;
    let sides = PointSides { leaf_count: cloud.leaf_count(), turned_bits: cloud.turned_bits() };
    let needed: Vec<u32> = written.last::<u32>("point_needed")[..rendered.counts().needed_count as usize].to_vec();
    let lists: [(Vec<u32>, Vec<u32>, Vec<MicroTexel>); 2] = [
        (rendered.primaries(), written.last("micro_texels"), table(PRIMARY_EDGE, Hemisphere::Paraboloid)),
        (needed, written.last("secondary_texels"), table(SECONDARY_EDGE, Hemisphere::Paraboloid)),
    ];
    let mut bounced = 0;
    for (keys, texels, table) in &lists {
        for (key, texels) in keys.iter().zip(texels.chunks_exact(table.len())) {
            let light = gather_bounce(cloud, &sides, &lending, &direct, table, texels);
            let expected = direct[*key as usize] + light;
            let found = Vec3::from(after[*key as usize]);
            if !near(found, expected, 1e-4) {
                return Err(format!("{found} at {key}, {expected} in the twin"));
            }
            bounced += usize::from(light.max_element() > 0.0);
        }
    }
    Ok(bounced)
}

#[test]
fn a_bounce_is_as_its_twin() {
    for micro in [MicroFill::Rays, MicroFill::Points] {
        let rendered = render(&corner(), &settings(2).changed(|s| s.pbgi.micro = micro));
        let mut after: Vec<[f32; 3]> = rendered.written.last("bounced_irradiance_even");
        let bounced = compare_bounce(&rendered, &after).unwrap_or_else(|e| panic!("{micro:?}: {e}"));
        assert!(bounced > 300, "{bounced} points get light from surfaces");
        after[rendered.primaries()[5] as usize][1] = f32::NAN;
        compare_bounce(&rendered, &after).unwrap_err();
    }
}

#[test]
fn no_other_point_is_lit_and_one_bounce_stays_as_it_was() {
    let [one, three] = [1, 3].map(|bounces| render(&corner(), &settings(bounces)));
    assert_eq!(one.counts(), three.counts());
    let needed = |rendered: &Rendered| rendered.written.last::<u32>("needed_bits");
    assert!(needed(&one) == needed(&three));
    let [first, again] = [0, 1].map(|_| render(&corner(), &settings(3)).radiance);
    assert!(first == again && first == three.radiance);
}

#[test]
fn what_is_kept_from_the_frame_before_does_not_show() {
    let kept = render(&corner(), &settings(2).changed(|s| s.pbgi.reuse = Switch::On)).radiance;
    assert!(kept == render(&corner(), &settings(2)).radiance);
}

#[test]
fn nothing_comes_of_no_light_and_of_nothing_to_see() {
    let mut dark = corner();
    dark.environment = None;
    let mut away = corner();
    away.cameras = vec![camera(Vec3::new(0.0, 3.0, 2.5), Vec3::Y, 0.8)];
    for scene in [dark, away] {
        let radiance = render(&scene, &settings(3)).radiance;
        assert!(radiance.iter().all(|radiance| radiance.is_finite()));
    }
}

/// Points that are lit, keys that these see, and those of them whose light is that of a node above.
fn count_seen_by_lit(rendered: &Rendered) -> [usize; 3] {
    let written = &rendered.written;
    let needed = rendered.counts().needed_count as usize;
    let texels: Vec<u32> = written.last("secondary_texels");
    let seen: BTreeSet<u32> =
        texels[..(SECONDARY_EDGE * SECONDARY_EDGE) as usize * needed].iter().map(|t| t & 0xff_ffff).collect();
    let has_light = ["lending_bits", "under_bits", "seen_bits"].map(|name| written.last::<u32>(name));
    let seen = seen.into_iter().filter(|key| *key != 0);
    let (lit, other): (Vec<u32>, Vec<u32>) = seen.partition(|key| has_light.iter().any(|bits| has_bit(bits, *key)));
    [needed, lit.len() + other.len(), other.len()]
}

/// Prints by how much the points that need light would grow if what these see were lit too, in the castle of the shared folder.
#[test]
#[ignore = "takes a minute and prints counts: for measuring"]
fn points_that_only_secondary_points_see() {
    let folder = shared_dir().expect("the shared folder").join("assets/env");
    let mut scene = gltf::load(&folder.join("castle.gltf"), &|_: &str, _, _| ()).unwrap();
    scene.environment = Some(Arc::new(environment::file::read(&folder.join("sky.exr")).unwrap()));
    scene.cameras.retain(|camera| camera.name == "yard");
    let settings = settings(2).changed(|s| {
        s.picture.size = Size { width: 640, height: 360 };
        s.pbgi.points = 1 << 19;
    });
    let [needed, seen, more] = count_seen_by_lit(&render(&scene, &settings));
    println!("{needed} secondary points are lit and see {seen} keys, of which {more} have no light of their own");
    assert!(more > 0 && more < seen);
}
