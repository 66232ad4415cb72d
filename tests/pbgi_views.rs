//! What the views of point-based global illumination show, and what its inspector tells, against what the passes leave.

mod common;

use std::collections::BTreeSet;
use std::f32::consts::PI;

use common::compare::near;
use common::points::{Rendered, render, surface_at, under_sky};
use common::rooms::{add_quad, camera};
use common::written::Written;
use glam::{Vec2, Vec3, Vec3Swizzles};
use gridlight::cpu::point_sides::has_bit;
use gridlight::cpu::radiance_cache::cache_distance;
use gridlight::micro_buffers::table;
use gridlight::renderer::{Job, Renderer, UploadedScene};
use gridlight::report::inspected;
use gridlight::scene::Scene;
use gridlight::scene::bvh::build_binary;
use gridlight::scene::testing::{diffuse, scene_from_quads};
use gridlight::settings::{Hemisphere, Settings, Size, Technique, View};
use gridlight::shared::{
    CACHES_IN_REACH, CACHES_NEAREST, CACHES_NONE, CacheCounts, CachePlace, InspectedPixel, LIGHT_OF_CHILDREN,
    LIGHT_OF_ITS_OWN, LIGHT_OF_PARENT, LIGHT_OF_PRIMARY, PRIMARY_EDGE, PointCounts,
};

const SIZE: Size = Size { width: 96, height: 54 };

fn showing(view: View) -> Settings {
    Settings::default().changed(|s| {
        s.render.technique = Technique::Pbgi;
        s.render.view = view;
        s.picture.size = SIZE;
        s.pbgi.points = 4096;
    })
}

/// A floor, and a wall that leans away behind it.
fn corner() -> Scene {
    let floor = [[-2.0, 2.0], [2.0, 2.0], [2.0, -2.0], [-2.0, -2.0]].map(|[x, z]| Vec3::new(x, 0.0, z));
    let mut scene = scene_from_quads("corner", &[floor], diffuse("grey", Vec3::splat(0.5)));
    add_quad(&mut scene, floor.map(|at| Vec3::new(at.x, 0.5 * (2.0 - at.z), -2.0 - 0.1 * (2.0 - at.z))));
    let mut scene = under_sky(scene);
    scene.cameras = vec![camera(Vec3::new(0.5, 1.2, 3.5), Vec3::new(0.0, -0.2, -1.0).normalize(), 0.7)];
    scene
}

/// What a view tells at a pixel with a point: its number and its key.
type Told = (u32, u32);

fn told(rendered: &Rendered) -> Vec<Told> {
    rendered.radiance.iter().filter(|values| values.z > 0.0).map(|values| (values.x as u32, values.y as u32)).collect()
}

/// Whether every point is in the set and has the number that it must have; gives how many different points there are.
fn check_points(told: &[Told], bits: &[u32], number: impl Fn(u32) -> u32) -> Result<usize, String> {
    for (found, key) in told {
        if !has_bit(bits, *key) {
            return Err(format!("{key} is not in the set"));
        }
        if *found != number(*key) {
            return Err(format!("{key} has {found}, not {}", number(*key)));
        }
    }
    Ok(told.iter().map(|(_, key)| key).collect::<BTreeSet<_>>().len())
}

#[test]
fn primary_points_are_shown_with_their_levels() {
    let height = |key: u32| 12 - (key / 2).ilog2();
    for view in [View::PrimaryPoints, View::PrimaryPointsAbove] {
        let rendered = render(&corner(), &showing(view));
        let bits: Vec<u32> = rendered.written.last("primary_bits");
        let mut told = told(&rendered);
        let different = check_points(&told, &bits, height).unwrap();
        assert!(different > 100 && 2 * different > rendered.primaries().len(), "{view:?}: {different}");
        told[7].0 += 1;
        check_points(&told, &bits, height).unwrap_err();
        told[7] = (0, told[7].1 ^ 1);
        check_points(&told, &bits, height).unwrap_err();
    }
}

#[test]
fn secondary_points_are_shown_with_where_their_light_comes_from() {
    let mut shown = BTreeSet::new();
    for view in [View::SecondaryPoints, View::SecondaryPointsAbove] {
        let rendered = render(&corner(), &showing(view));
        let [seen, needed, under, borrowed] =
            ["seen_bits", "needed_bits", "under_bits", "borrowed_bits"].map(|name| rendered.written.last::<u32>(name));
        let origin = |key: u32| match [&needed, &under, &borrowed].map(|bits| has_bit(bits, key)) {
            [true, ..] => LIGHT_OF_ITS_OWN,
            [_, true, _] => LIGHT_OF_PRIMARY,
            [_, _, true] => LIGHT_OF_PARENT,
            _ => LIGHT_OF_CHILDREN,
        };
        let mut told = told(&rendered);
        let different = check_points(&told, &seen, origin).unwrap();
        assert!(different > 50, "{view:?}: {different}");
        shown.extend(told.iter().map(|(origin, _)| *origin));
        told[7].0 += 1;
        check_points(&told, &seen, origin).unwrap_err();
    }
    assert!(shown.contains(&LIGHT_OF_ITS_OWN) && shown.contains(&LIGHT_OF_PRIMARY), "{shown:?}");
}

/// How many caches light a surface, and the largest of their shares.
fn weighed(places: &[CachePlace], [position, normal]: [Vec3; 2]) -> (f32, f32) {
    let weight = |place: &CachePlace| {
        let [distance, plane] = cache_distance(place, position, normal);
        if distance < 1.0 && plane <= 0.25 { 1.0 / distance.max(0.25) - 1.0 } else { 0.0 }
    };
    let weights: Vec<f32> = places.iter().map(weight).filter(|weight| *weight > 0.0).collect();
    let largest = weights.iter().fold(0.0_f32, |largest, weight| largest.max(*weight));
    (weights.len() as f32, largest / weights.iter().sum::<f32>())
}

#[test]
fn caches_are_counted_as_they_light() {
    let scene = corner();
    let bvh = build_binary(&scene);
    let [count, weights, misses] =
        [View::CacheCount, View::CacheWeights, View::CacheMisses].map(|view| render(&scene, &showing(view)));
    assert!(count.radiance == weights.radiance && count.radiance == misses.radiance);
    let counted = count.written.last::<CacheCounts>("cache_counts")[0];
    let pixels = |way: u32| count.radiance.iter().filter(|values| values.z == way as f32).count() as u32;
    let stretched = (CACHES_IN_REACH + 1..=CACHES_NONE).map(pixels).sum::<u32>();
    assert_eq!(
        [stretched, pixels(CACHES_NEAREST), pixels(CACHES_NONE)],
        [counted.stretched_pixels, counted.nearest_pixels, counted.black_pixels]
    );
    let places: Vec<CachePlace> = count.written.last("cache_places");
    let places = &places[..count.primaries().len()];
    let lit = |index: &usize| count.radiance[*index].x > 0.0 && count.radiance[*index].z == 0.0;
    let (mut compared, mut close) = (0, 0);
    for index in (0..count.radiance.len()).step_by(31).filter(lit) {
        let Some(surface) = surface_at(&scene, &bvh, SIZE, index) else { continue };
        let (expected, share) = weighed(places, surface);
        let found = count.radiance[index];
        // A cache at the end of its reach may be counted or not.
        compared += 1;
        close += u32::from((found.x - expected).abs() <= 1.0 && (found.y - share).abs() <= 0.02);
    }
    assert!(compared > 50 && close * 50 >= compared * 49, "{close} of {compared}");
}

#[test]
fn the_camera_stands_in_the_picture_from_above() {
    let scene = corner();
    let rendered = render(&scene, &showing(View::PrimaryPointsAbove));
    let picture: Vec<[u8; 4]> = rendered.written.last("picture");
    // Of x, z, -x and -z the highest of any point, in the order of floats.
    let bounds: Vec<u32> = rendered.written.last("shown_bounds");
    let float = |ordered: u32| f32::from_bits(if ordered >> 31 == 1 { ordered & 0x7fff_ffff } else { !ordered });
    let eye = scene.cameras[0].position_ws;
    let highest = Vec2::new(float(bounds[0]), float(bounds[1])).max(eye.xz());
    let lowest = (-Vec2::new(float(bounds[2]), float(bounds[3]))).min(eye.xz());
    let size = Vec2::new(SIZE.width as f32, SIZE.height as f32);
    let scale = (0.88 * size / (highest - lowest)).min_element();
    let place = 0.5 * size + scale * (eye.xz() - 0.5 * (highest + lowest));
    let is_white = |at: Vec2| picture[at.y as usize * SIZE.width as usize + at.x as usize] == [255; 4];
    assert!(is_white(place), "{place}");
    // It looks along -z, and has all of the points before it.
    assert!(!is_white(place - 6.0 * Vec2::X) && !is_white(place + 6.0 * Vec2::X));
    assert!(lowest.y < eye.z - 1.0 && highest.y == eye.z, "{lowest} {highest}");
}

/// What the inspector tells against what the passes leave, under a white sky over grey surfaces.
fn check_inspected(pixel: &InspectedPixel, written: &Written, surface: [Vec3; 2]) -> Result<(), String> {
    let count = written.last::<PointCounts>("point_counts")[0].primary_count as usize;
    let places: Vec<CachePlace> = written.last("cache_places");
    let slot = pixel.cache_slot as usize;
    if slot >= count || written.last::<u32>("point_primaries")[slot] != pixel.cache_key {
        return Err(format!("cache {slot} of {count} has another key than {}", pixel.cache_key));
    }
    let (expected, share) = weighed(&places[..count], surface);
    if !((pixel.cache_count as f32 - expected).abs() <= 1.0 && (pixel.cache_share - share).abs() <= 0.02) {
        return Err(format!("{} caches, {}, not {expected}, {share}", pixel.cache_count, pixel.cache_share));
    }
    let irradiance: Vec<[f32; 3]> = written.last("point_irradiance");
    let table = table(PRIMARY_EDGE, Hemisphere::Paraboloid);
    let texels: Vec<u32> = written.last("micro_texels");
    let texels = texels[table.len() * slot..].iter().zip(&table).zip(&pixel.cache_texels);
    for (i, ((seen, of_table), found)) in texels.enumerate() {
        let key = (seen & 0xff_ffff) as usize;
        let (radiance, coverage) = match (of_table.solid_angle > 0.0, key) {
            (false, _) => (Vec3::ZERO, -1.0),
            (true, 0) => (Vec3::ONE, 0.0),
            (true, key) => (0.5 / PI * Vec3::from(irradiance[key]), 1.0),
        };
        if !(near(found.radiance.into(), radiance, 2e-3) && found.coverage == coverage) {
            return Err(format!("texel {i}: {found:?}, not {radiance} and {coverage}"));
        }
    }
    Ok(())
}

#[test]
fn the_inspector_has_what_the_nearest_cache_sees() {
    let test = common::gpu();
    let (scene, settings) = (corner(), showing(View::Final));
    let mut uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    uploaded.spread_points(&scene, Some(12)).unwrap();
    let job = Job::new(&test.gpu, &uploaded, &scene.cameras[0], &settings);
    let mut shapes = Renderer::new(&job).unwrap().shapes().clone();
    shapes.frame.inspect = true;
    let mut renderer = Renderer::with_shapes(&job, shapes).unwrap();
    // Before the wall, so that it sees some of it.
    let at = [48, 32];
    renderer.inspect_pixel(at);
    let written = Written::by(&renderer);
    let pixel = written.last::<InspectedPixel>("inspected_pixel")[0];
    let surface = surface_at(&scene, &build_binary(&scene), SIZE, (at[1] * SIZE.width + at[0]) as usize).unwrap();
    check_inspected(&pixel, &written, surface).unwrap();
    let faults: [fn(&mut InspectedPixel); 4] = [
        |pixel| pixel.cache_slot += 1,
        |pixel| pixel.cache_share += 0.1,
        |pixel| pixel.cache_texels[120].radiance[1] = f32::NAN,
        |pixel| pixel.cache_texels[120].coverage = 0.5,
    ];
    for (index, fault) in faults.into_iter().enumerate() {
        let mut wrong = pixel;
        fault(&mut wrong);
        assert!(check_inspected(&wrong, &written, surface).is_err(), "fault {index}");
    }
    let technique = &renderer.shapes().technique;
    let [seen, surfaces] = <[_; 2]>::try_from(technique.inspector_images(&pixel)).unwrap();
    let count = |colors: &[Option<u32>], of: u32| colors.iter().filter(|color| **color == Some(of)).count();
    let covered = pixel.cache_texels.iter().filter(|texel| texel.coverage == 1.0).count();
    assert!(covered > 10 && count(&surfaces.colors, 0xff_ffff) == covered, "{covered}");
    assert_eq!(seen.colors.iter().flatten().count(), 224);
    let told = inspected::text(&**technique, &pixel);
    assert!(told.contains("micro-buffer:\n") && told.contains(&pixel.cache_key.to_string()), "{told}");
    assert_eq!(technique.inspector_tables(&pixel)[0].rows[0][2].text, pixel.cache_key.to_string());
}
