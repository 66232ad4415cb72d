//! Point-based global illumination where the answer is known, and its stages against their twins.

mod common;

use std::f32::consts::PI;

use common::compare::near;
use common::points::{Rendered, render, surface_at, under_sky};
use common::rooms::{add_quad, camera};
use glam::{Vec2, Vec3};
use gridlight::cpu::micro_buffers::{Looking, micro_frame, place_of_leaf_key, seen_key, unpack_leaf};
use gridlight::cpu::radiance_cache::{convolve_lobes, gather};
use gridlight::micro_buffers::{LOBES, table};
use gridlight::scene::bvh::{BinaryBvh, Ray, build_binary};
use gridlight::scene::testing::{diffuse, plane, scene_from_quads};
use gridlight::scene::{Light, Scene};
use gridlight::settings::{Hemisphere, MicroFill, Settings, Size, Switch, Technique};
use gridlight::shared::{CacheCounts, CachePlace, MicroTexel, PRIMARY_EDGE};

const POINTS_LOG2: u32 = 12;

fn small() -> Settings {
    Settings::default().changed(|s| {
        s.render.technique = Technique::Pbgi;
        s.picture.size = Size { width: 96, height: 54 };
        s.pbgi.points = 1 << POINTS_LOG2;
    })
}

/// Looks down on the origin.
fn from_above(scene: &mut Scene, distance: f32) {
    scene.cameras = vec![camera(Vec3::new(0.0, distance, 0.4 * distance), Vec3::new(0.0, -1.0, -0.4).normalize(), 0.8)];
}

fn open_plane() -> Scene {
    let mut scene = under_sky(plane(4.0));
    scene.materials[0] = diffuse("grey", Vec3::splat(0.5));
    from_above(&mut scene, 4.0);
    scene
}

/// Whether every primary point has this irradiance.
fn check_lit(rendered: &Rendered, expected: f32, tolerance: f32) -> Result<(), String> {
    let lit = rendered.lit();
    if lit.len() < 20 {
        return Err(format!("{} primary points", lit.len()));
    }
    match lit.iter().find(|(_, irradiance)| !near(*irradiance, Vec3::splat(expected), tolerance)) {
        Some((position, irradiance)) => Err(format!("{irradiance} at {position}, not {expected}")),
        None => Ok(()),
    }
}

#[test]
fn an_open_plane_gets_all_of_the_sky() {
    for micro in [MicroFill::Rays, MicroFill::Points] {
        let rendered = render(&open_plane(), &small().changed(|s| s.pbgi.micro = micro));
        check_lit(&rendered, PI, 1e-4).unwrap();
        check_lit(&rendered, 1.01 * PI, 1e-4).unwrap_err();
        let centre = rendered.radiance[27 * 96 + 48];
        assert!(near(centre, Vec3::splat(0.5), 1e-4), "{centre}");
        let counts = rendered.written.last::<CacheCounts>("cache_counts")[0];
        assert_eq!((counts.black_pixels, counts.lost_references), (0, 0));
    }
}

/// A ball of flat faces about the origin.
fn ball(radius: f32) -> Scene {
    let (columns, rows) = (24, 12);
    let at = |x: u32, y: u32| {
        let (around, down) = (x as f32 / columns as f32 * 2.0 * PI, y as f32 / rows as f32 * PI);
        radius * Vec3::new(down.sin() * around.cos(), down.cos(), down.sin() * around.sin())
    };
    let quad = |i: u32| {
        let (x, y) = (i % columns, i / columns);
        [at(x + 1, y), at(x + 1, y + 1), at(x, y + 1), at(x, y)]
    };
    let quads: Vec<_> = (0..columns * rows).map(quad).collect();
    let mut scene = under_sky(scene_from_quads("ball", &quads, diffuse("white", Vec3::ONE)));
    from_above(&mut scene, 4.0 * radius);
    scene
}

#[test]
fn a_convex_ball_does_not_shadow_itself() {
    check_lit(&render(&ball(1.0), &small()), PI, 1e-4).unwrap();
}

/// A white floor with a white roof over a part of it.
fn under_a_roof() -> Scene {
    let level = |y: f32, h: f32| [Vec3::new(-h, y, h), Vec3::new(h, y, h), Vec3::new(h, y, -h), Vec3::new(-h, y, -h)];
    let mut scene = scene_from_quads("roof", &[level(0.0, 3.0)], diffuse("white", Vec3::ONE));
    add_quad(&mut scene, level(1.0, 0.8));
    let mut scene = under_sky(scene);
    scene.cameras = vec![camera(Vec3::new(0.0, 0.6, 2.5), Vec3::new(0.0, -0.1, -1.0).normalize(), 0.8)];
    scene
}

/// A floor that tiles a little above it hide but for narrow joints, before a wall that it lights.
fn tiled_floor() -> Scene {
    let level = |x: f32, y: f32, z: f32, edge: f32| {
        let corner = Vec3::new(x, y, z);
        [corner, corner + edge * Vec3::Z, corner + edge * (Vec3::X + Vec3::Z), corner + edge * Vec3::X]
    };
    let mut scene = scene_from_quads("tiles", &[level(-2.0, 0.0, -2.0, 4.0)], diffuse("grey", Vec3::splat(0.5)));
    for i in 0..64 {
        let [x, z] = [i % 8, i / 8].map(|step| 0.5 * step as f32 - 1.97);
        add_quad(&mut scene, level(x, TILE_HEIGHT, z, 0.44));
    }
    let corner = Vec3::new(-2.0, 0.0, -2.0);
    add_quad(&mut scene, [corner, corner + 4.0 * Vec3::X, corner + 4.0 * Vec3::X + Vec3::Y, corner + Vec3::Y]);
    let mut scene = under_sky(scene);
    from_above(&mut scene, 4.0);
    scene
}

/// Height of the tiles over the floor.
const TILE_HEIGHT: f32 = 0.02;

#[test]
fn what_lies_behind_what_is_seen_is_no_primary_point() {
    let rendered = render(&tiled_floor(), &small());
    assert_eq!(rendered.lit().len(), rendered.primaries().len());
    // A hair inside of a tile's edges, as the eye looks at them aslant.
    let under_tile = |x: f32| (0.015..0.425).contains(&(x + 1.97).rem_euclid(0.5));
    let is_hidden = |place: Vec3| place.y < 0.5 * TILE_HEIGHT && under_tile(place.x) && under_tile(place.z);
    assert!(is_hidden(Vec3::new(0.25, 0.0, 0.25)) && !is_hidden(Vec3::new(-0.01, 0.0, 0.25)));
    assert_eq!(rendered.lit().into_iter().find(|(position, _)| is_hidden(*position)), None);
}

/// Whether the mean light of a picture is that of one bounce of path tracing to this share.
fn check_bounce(scene: &Scene, tolerance: f32) -> Result<(), String> {
    let mean = |radiance: &[Vec3]| radiance.iter().copied().sum::<Vec3>() / radiance.len() as f32;
    let settings = small().changed(|s| s.render.direct = Switch::Off);
    let found = mean(&render(scene, &settings).radiance);
    let traced = settings.changed(|s| {
        s.render.technique = Technique::PathTrace;
        s.many_lights.bounces = 1;
        s.path_trace.samples = 256;
    });
    let expected = mean(&common::frames::render(scene, &traced));
    if (found / expected - 1.0).abs().max_element() <= tolerance {
        Ok(())
    } else {
        Err(format!("{found}, traced {expected}"))
    }
}

#[test]
fn what_lies_behind_what_is_seen_does_not_darken_it() {
    let mut scene = tiled_floor();
    // The wall alone, so that the floor is lit for it.
    scene.cameras = vec![camera(Vec3::new(0.0, 0.5, -0.5), Vec3::NEG_Z, 0.5)];
    check_bounce(&scene, 0.05).unwrap();
    check_bounce(&scene, 1e-4).unwrap_err();
}

#[test]
fn one_bounce_never_exceeds_the_sky() {
    let all = render(&under_a_roof(), &small());
    let bounce = render(&under_a_roof(), &small().changed(|s| s.render.direct = Switch::Off));
    let most = all.radiance.iter().fold(0.0_f32, |most, radiance| most.max(radiance.max_element()));
    assert!(most <= 1.0 + 1e-3 && most > 0.99, "{most}");
    let brightest = bounce.radiance.iter().fold(0.0_f32, |most, radiance| most.max(radiance.max_element()));
    assert!(brightest > 0.1 && brightest < 0.9, "{brightest}");
}

#[test]
fn pictures_are_those_of_one_bounce_of_path_tracing() {
    let mut scene = under_a_roof();
    scene.materials[0] = diffuse("green", Vec3::new(0.4, 0.8, 0.3));
    // What both miss of the bounce is noise of the reference; the rest is the method's.
    check_bounce(&scene, 0.04).unwrap();
}

#[test]
fn suns_light_points_as_they_light_pixels() {
    let mut scene = open_plane();
    let direction_ws = Vec3::new(0.3, -1.0, 0.2).normalize();
    scene.lights = vec![Light::Directional { direction_ws, irradiance: Vec3::new(3.0, 2.0, 1.0) }];
    let rendered = render(&scene, &small());
    let expected = Vec3::new(3.0, 2.0, 1.0) * -direction_ws.y + PI;
    for (position, irradiance) in rendered.lit() {
        assert!(near(irradiance, expected, 1e-3), "{irradiance} at {position}, not {expected}");
    }
    let centre = rendered.radiance[27 * 96 + 48];
    assert!(near(centre, 0.5 / PI * expected, 1e-3), "{centre}");
}

#[test]
fn the_same_seed_is_the_same_picture() {
    let scene = under_a_roof();
    let [first, second] = [0, 1].map(|_| render(&scene, &small()).radiance);
    assert!(first == second);
    assert!(first != render(&scene, &small().changed(|s| s.tracing.seed = 2)).radiance);
}

/// Lobes of a cache and its place.
type Cache = (CachePlace, Vec<Vec3>);

/// The caches as they were left, with the light of both kinds together.
fn caches(rendered: &Rendered) -> Vec<Cache> {
    let places: Vec<CachePlace> = rendered.written.last("cache_places");
    let lobes: Vec<[[f32; 3]; 2]> = rendered.written.last("cache_lobes");
    let light = |[sky, bounce]: &[[f32; 3]; 2]| Vec3::from(*sky) + Vec3::from(*bounce);
    let count = rendered.primaries().len();
    let own = lobes.chunks_exact(LOBES as usize).map(|own| own.iter().map(light).collect());
    places.into_iter().zip(own).take(count).collect()
}

#[test]
fn lobes_are_those_of_the_twin() {
    let rendered = render(&under_a_roof(), &small());
    let caches = caches(&rendered);
    let texels: Vec<u32> = rendered.written.last("micro_texels");
    let table = table(PRIMARY_EDGE, Hemisphere::Paraboloid);
    let irradiance = rendered.irradiance();
    let mut covered = 0;
    for ((place, lobes), texels) in caches.iter().zip(texels.chunks_exact(table.len())) {
        // Everything is white under a white sky.
        let radiance: Vec<Vec3> = texels
            .iter()
            .map(|texel| if texel >> 24 == 0 { Vec3::ONE } else { irradiance[(texel & 0xff_ffff) as usize] / PI })
            .collect();
        covered += texels.iter().filter(|texel| **texel != 0).count();
        for (i, (found, expected)) in lobes.iter().zip(convolve_lobes(&table, &radiance)).enumerate() {
            assert!(near(*found, expected, 1e-4), "lobe {i} of {place:?}: {found}, not {expected}");
        }
    }
    assert!(covered > 1000, "{covered} texels see anything");
}

/// What a primary point sees in each texel, and how near each decision on the way was to going the other way.
fn traced(rendered: &Rendered, scene: &Scene, bvh: &BinaryBvh, key: u32, leaves: &[u32]) -> Vec<(u32, f32)> {
    let cloud = &rendered.cloud;
    let leaf = *leaves.iter().min().unwrap();
    if leaf == u32::MAX {
        return Vec::new();
    }
    let (position, normal) = place_of_leaf_key(cloud, unpack_leaf(cloud, leaf), rendered.largest_triangle);
    let to_world = micro_frame(normal, key, small().tracing.seed);
    let radius = cloud.node(key >> 1).radius;
    let texel = |texel: &MicroTexel| {
        let direction = to_world * Vec3::from(texel.direction);
        let ray = Ray { origin: position, direction, t_min: 0.0, t_max: f32::MAX };
        let hit = (texel.solid_angle > 0.0).then(|| bvh.trace_closest(&ray)).flatten();
        let Some(hit) = hit else { return (0, f32::INFINITY) };
        let corner = |i: u32| scene.vertices[scene.indices[(3 * hit.triangle_index + i) as usize] as usize].position_ws;
        let [a, b, c] = [0, 1, 2].map(|i| Vec3::from(corner(i)));
        let geometric = (b - a).cross(c - a);
        let leaf = cloud.leaf_of_hit(hit.triangle_index, Vec2::new(hit.u, hit.v));
        let faces = geometric.dot(direction) * geometric.dot(cloud.node(cloud.leaf_count() + leaf).normal) < 0.0;
        let leaf_key = 2 * (cloud.leaf_count() + leaf) + u32::from(!faces);
        let (key, margin) = seen_key(cloud, leaf_key, Looking { position, solid_angle: texel.solid_angle, radius });
        (0xff00_0000 | key, margin)
    };
    table(PRIMARY_EDGE, Hemisphere::Paraboloid).iter().map(texel).collect()
}

#[test]
fn micro_buffers_are_those_of_the_twin() {
    let scene = under_a_roof();
    let rendered = render(&scene, &small());
    let bvh = build_binary(&scene);
    let texels: Vec<u32> = rendered.written.last("micro_texels");
    let leaves: Vec<u32> = rendered.written.last("primary_leaves");
    let (mut compared, mut covered, mut different) = (0, 0, 0);
    for (slot, key) in rendered.primaries().into_iter().enumerate().step_by(3) {
        let expected = traced(&rendered, &scene, &bvh, key, &leaves[4 * slot..][..4]);
        for (found, (expected, margin)) in texels[256 * slot..].iter().zip(expected) {
            if margin > 1e-4 {
                compared += 1;
                covered += u32::from(expected != 0);
                different += u32::from(*found != expected);
            }
        }
    }
    // Rays through edges of triangles and of cells may go either way.
    assert!(covered > 1000 && different * 200 <= covered, "{different} of {compared}, of which {covered} see anything");
}

#[test]
fn pixels_are_those_of_the_twin() {
    let scene = under_a_roof();
    let rendered = render(&scene, &small());
    let caches = caches(&rendered);
    let bvh = build_binary(&scene);
    let size = small().picture.size;
    let mut compared = 0;
    for index in (0..rendered.radiance.len()).step_by(37) {
        let Some([position, normal]) = surface_at(&scene, &bvh, size, index) else { continue };
        let Some(light) = gather(&caches, [position, normal, normal], 1.0) else { continue };
        let found = rendered.radiance[index];
        assert!(near(found, light / PI, 2e-3), "pixel {index}: {found}, not {}", light / PI);
        compared += 1;
    }
    assert!(compared > 30, "{compared} pixels");
}
