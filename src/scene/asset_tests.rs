//! The large shared scenes, where they are at hand: counts, bounds, and how long loading takes.

use std::time::Instant;

use glam::Vec3;

use super::albedo_array::{build_albedo_array, mip_chains};
use super::testing::shared_dir;
use super::{Light, Scene, Texture, bvh, gltf};

fn asset(path: &str) -> Option<Scene> {
    let Some(folder) = shared_dir() else {
        println!("skipped: no shared assets (set GRIDLIGHT_SHARED)");
        return None;
    };
    Some(gltf::load(&folder.join("assets").join(path), &|_, _, _| ()).unwrap())
}

#[test]
fn cornell_loads() {
    let Some(scene) = asset("cornell/cornell.gltf") else { return };
    assert_eq!((scene.name.as_str(), scene.indices.len() / 3, scene.draws.len()), ("cornell", 30, 3));
    assert_eq!(scene.materials[1].base_color, [0.65, 0.05, 0.05, 1.0]);
    let camera = &scene.cameras[0];
    assert_eq!((camera.name.as_str(), camera.position_ws), ("front", Vec3::new(0.0, 2.73, 8.0)));
    assert_eq!((camera.forward_ws, camera.up_ws), (Vec3::NEG_Z, Vec3::Y));
    let lamp = Light::Point { position_ws: Vec3::new(0.0, 4.6, -2.8), intensity: Vec3::splat(60.0) };
    assert_eq!(scene.lights, [lamp]);
}

#[test]
fn sponza_loads_and_builds_quickly() {
    let start = Instant::now();
    let Some(scene) = asset("sponza/sponza-sun.gltf") else { return };
    let load = start.elapsed();
    let names: Vec<_> = scene.cameras.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["atrium", "gallery"]);
    assert_eq!(scene.draws.len(), 25);
    assert!((262_000..=262_267).contains(&(scene.indices.len() / 3)), "{}", scene.indices.len() / 3);
    assert!((scene.bounds.min - Vec3::new(-15.4, -1.0, -9.5)).abs().max_element() < 0.06, "{:?}", scene.bounds);
    assert!((scene.bounds.max - Vec3::new(14.4, 11.4, 8.8)).abs().max_element() < 0.06, "{:?}", scene.bounds);
    let Light::Directional { direction_ws, irradiance } = &scene.lights[0] else { panic!("{:?}", scene.lights) };
    assert!((*direction_ws - Vec3::new(0.2, -1.0, 0.15).normalize()).length() < 1e-5);
    assert_eq!(*irradiance, Vec3::splat(16.0));

    let bvh = bvh::build_binary(&scene);
    let wide = bvh::build(&scene);
    let start = Instant::now();
    let array = build_albedo_array(&scene, 2048);
    let albedo = start.elapsed();
    let start = Instant::now();
    let all: Vec<(&Texture, bool)> = scene.textures.iter().map(|t| (t, true)).collect();
    let chains = mip_chains(&all);
    let mips = start.elapsed();
    assert_eq!((array.size_px, array.layers.len(), chains.len()), (1024, scene.textures.len(), scene.textures.len()));

    let camera = &scene.cameras[0];
    let (mut hits, start) = (0u32, Instant::now());
    for i in 0..100_000 {
        let (x, y) = (i % 316, i / 316);
        let offset = camera.right_ws * (x as f32 / 158.0 - 1.0) + camera.up_ws * (y as f32 / 316.0 - 0.5);
        let direction = camera.forward_ws + offset;
        let ray = bvh::Ray { origin: camera.position_ws, direction, t_min: 1e-4, t_max: f32::INFINITY };
        hits += u32::from(bvh.trace_closest(&ray).is_some());
    }
    println!(
        "sponza: {} triangles, {} textures; load {load:.2?}, bvh {:.0} ms ({} nodes, depth {}), cwbvh {:.0} ms \
         ({} nodes), albedo array {albedo:.2?}, mip chains {mips:.2?}, 100k camera rays {:.2?} ({hits} hits)",
        scene.indices.len() / 3,
        scene.textures.len(),
        bvh.build_ms,
        bvh.nodes.len(),
        bvh.depth,
        wide.build_ms,
        wide.nodes.len(),
        start.elapsed(),
    );
    assert!(hits > 90_000);
}
