//! Shadow rays by ray queries against shadow rays over the BVH: the same rays, one for each pixel.

mod common;
mod support;

use common::rooms::{add_quad, camera, furnished_room};
use glam::Vec3;
use gridlight::gpu::{Executor, TransferOp, Work};
use gridlight::graph::{Access, Graph, Pass};
use gridlight::passes::scene::SceneParts;
use gridlight::passes::structures;
use gridlight::renderer::{Job, Renderer, UploadedScene};
use gridlight::scene::bvh::{self, SceneBvh};
use gridlight::scene::refit::MovingBvh;
use gridlight::scene::testing::{box_room, shared_dir};
use gridlight::scene::{Draw, Light, Material, Scene, Texture, Vertex, gltf};
use gridlight::scene_mover::SceneMover;
use gridlight::settings::{LightSet, Rays, Settings, ShadowPoints, Size, Technique, View};
use support::animated::screens_that_change_places;

/// Share of shadow rays that must agree.
const AGREEMENT: f64 = 0.999;

/// A room full of lamps with an opaque shelf, and a screen whose texture has holes where `alpha_cutoff` is set.
fn room_with_a_screen(alpha_cutoff: Option<f32>) -> Scene {
    let quad = |origin: Vec3, u: Vec3, v: Vec3| [origin, origin + u, origin + u + v, origin + v];
    let mut scene = box_room(4.0, Vec3::splat(0.6));
    add_quad(&mut scene, quad(Vec3::new(-1.2, 0.4, -1.2), Vec3::X * 1.5, Vec3::new(0.0, 0.3, 1.4)));
    let opaque = scene.indices.len();
    add_quad(&mut scene, quad(Vec3::new(0.1, -1.9, -0.8), Vec3::new(0.3, 0.0, 1.8), Vec3::Y * 2.4));
    let texel = |i: u32| [200, 180, 160, if (i / 8 + i).is_multiple_of(2) { 255 } else { 0 }];
    scene.textures =
        vec![Texture { name: "screen".into(), width: 8, height: 8, rgba: (0..64).flat_map(texel).collect() }];
    let screen = Material { base_color_texture: Some(0), alpha_cutoff, ..scene.materials[0].clone() };
    scene.materials.push(screen);
    scene.triangle_materials[opaque / 3..].fill(1);
    let (first, count) = (opaque as u32, (scene.indices.len() - opaque) as u32);
    scene.draws = vec![
        Draw { first_index: 0, index_count: first, material: 0 },
        Draw { first_index: first, index_count: count, material: 1 },
    ];
    scene.lights = (0..64_u32)
        .map(|i| {
            let place = Vec3::new((i % 4) as f32, (i / 4 % 4) as f32, (i / 16) as f32);
            Light::Point { position_ws: place * 1.1 - Vec3::new(1.7, 1.6, 1.65), intensity: Vec3::splat(1.0) }
        })
        .collect();
    scene.cameras = vec![camera(Vec3::new(-1.7, 0.9, 1.7), Vec3::new(0.8, -0.4, -0.9).normalize(), 1.3)];
    scene
}

/// What one shadow ray of each pixel lets through; lights that no ray has placed, so that both kinds of rays start
/// and end at the same points.
fn one_ray_each(rays: Rays) -> Settings {
    Settings::default().changed(|s| {
        s.picture.size = Size { width: 256, height: 192 };
        s.many_lights.lights = LightSet::Scene;
        s.many_lights.shadow_samples = 1;
        s.lgh.shadow_points = ShadowPoints::Deviation;
        s.render.view = View::ShadowRatio;
        s.tracing.rays = rays;
    })
}

fn render(test: &common::GpuTest, uploaded: &UploadedScene, scene: &Scene, settings: &Settings) -> Vec<f32> {
    let mut renderer = Renderer::new(&Job::new(&test.gpu, uploaded, &scene.cameras[0], settings)).unwrap();
    let ticket = renderer.submit().unwrap();
    renderer.wait(ticket).unwrap();
    renderer.read_radiance().unwrap()
}

/// The share of pixels that hold the same in both pictures.
fn agreement(a: &[f32], b: &[f32]) -> f64 {
    let same = a.chunks_exact(3).zip(b.chunks_exact(3)).filter(|(a, b)| a.iter().zip(*b).all(|(a, b)| a == b)).count();
    same as f64 / (a.len() / 3) as f64
}

/// The share of pixels that are not black.
fn lit(picture: &[f32]) -> f64 {
    picture.chunks_exact(3).filter(|pixel| pixel.iter().any(|value| *value > 0.0)).count() as f64
        / (picture.len() / 3) as f64
}

/// The test's device, where it has ray queries.
fn gpu_with_queries() -> Option<common::GpuTest> {
    let test = common::gpu();
    let found = test.gpu.features().ray_query;
    if !found {
        eprintln!("skipped: this device has no ray queries");
    }
    found.then_some(test)
}

#[test]
fn shadow_rays_agree_with_the_bvh() {
    let Some(test) = gpu_with_queries() else { return };
    let scene = room_with_a_screen(Some(0.5));
    let uploaded = UploadedScene::with_rays(&test.gpu, &scene, Rays::Query).unwrap();
    let [bvh, query] = [Rays::Bvh, Rays::Query].map(|rays| render(&test, &uploaded, &scene, &one_ray_each(rays)));
    let agreeing = agreement(&bvh, &query);
    eprintln!("room: {:.4} % of shadow rays agree, {:.1} % are not blocked", 100.0 * agreeing, 100.0 * lit(&bvh));
    assert!((0.3..0.95).contains(&lit(&bvh)), "too little shadow, or too much: {}", lit(&bvh));
    assert!(agreeing >= AGREEMENT, "{agreeing}");
    // A structure over another scene, with the holes filled: the comparison must tell.
    let filled = room_with_a_screen(None);
    let wrong = UploadedScene::with_rays(&test.gpu, &filled, Rays::Query).unwrap();
    let wrong = agreement(&bvh, &render(&test, &wrong, &filled, &one_ray_each(Rays::Query)));
    eprintln!("room with the holes filled: {:.4} %", 100.0 * wrong);
    assert!(wrong < AGREEMENT, "a screen without holes is not noticed: {wrong}");
}

#[test]
fn sun_shadows_in_a_large_scene_agree() {
    let Some(test) = gpu_with_queries() else { return };
    let Some(shared) = shared_dir() else {
        eprintln!("skipped: no shared assets");
        return;
    };
    let mut scene = gltf::load(&shared.join("assets/sponza/sponza-sun.gltf"), &|_, _, _| ()).unwrap();
    scene.cameras.sort_by_key(|camera| camera.name != "atrium");
    let uploaded = UploadedScene::with_rays(&test.gpu, &scene, Rays::Query).unwrap();
    let settings = |rays| {
        one_ray_each(rays).changed(|s| {
            s.render.technique = Technique::Direct;
            s.render.view = View::Direct;
        })
    };
    let [bvh, query] = [Rays::Bvh, Rays::Query].map(|rays| {
        render(&test, &uploaded, &scene, &settings(rays).changed(|s| s.many_lights.lights = LightSet::Vpl))
    });
    let agreeing = agreement(&bvh, &query);
    eprintln!("Sponza: {:.4} % of sun rays agree, {:.1} % are not blocked", 100.0 * agreeing, 100.0 * lit(&bvh));
    assert!(lit(&bvh) > 0.02 && agreeing >= AGREEMENT, "{agreeing}");
}

#[test]
fn rays_without_structures_are_an_error() {
    let test = common::baseline_gpu();
    let scene = room_with_a_screen(Some(0.5));
    let error = UploadedScene::with_rays(&test.gpu, &scene, Rays::Query).err().unwrap();
    assert_eq!(error.exit_code(), 2, "{error}");
    assert!(error.to_string().contains("VK_KHR_ray_query"), "{error}");
}

/// A room with a lamp over a table that is raised by so much.
fn room_with_a_table(raised: f32) -> Scene {
    let mut scene = furnished_room();
    // Before the shelf, the last quad.
    let table = scene.vertices.len() - 8..scene.vertices.len() - 4;
    scene.vertices[table].iter_mut().for_each(|vertex| vertex.position_ws[1] += raised);
    scene
}

/// A graph that moves the scene's vertices, and builds the structures anew where it is asked to.
fn vertex_mover(test: &common::GpuTest, uploaded: &UploadedScene, vertices: &[Vertex], rebuilds: bool) -> Executor {
    let mut graph = Graph::new();
    let scene = SceneParts::declare(&mut graph, Rays::Query);
    let moved = graph.persistent_buffer("moved", size_of_val(vertices) as u64);
    let copy = Work::Transfer(vec![TransferOp::Copy { from: moved, to: scene.vertices, offset_bytes: 0 }]);
    let pass = Pass::new("move", copy).uses(moved, Access::TransferRead).uses(scene.vertices, Access::TransferWrite);
    graph.add_pass(pass);
    if rebuilds {
        structures::add(&mut graph, &scene, uploaded.set());
    }
    let executor = Executor::new(&test.gpu, graph, Some(uploaded.set().clone())).unwrap();
    executor.write_buffer(moved, bytemuck::cast_slice(vertices)).unwrap();
    executor
}

#[test]
fn structures_follow_vertices_that_a_pass_moves() {
    let Some(test) = gpu_with_queries() else { return };
    let [scene, raised] = [0.0, 0.6].map(room_with_a_table);
    let settings = one_ray_each(Rays::Query).changed(|s| {
        s.render.technique = Technique::Direct;
        s.render.view = View::Direct;
    });
    let upload = |scene| UploadedScene::with_rays(&test.gpu, scene, Rays::Query).unwrap();
    let expected = render(&test, &upload(&raised), &raised, &settings);
    for rebuilds in [true, false] {
        let uploaded = upload(&scene);
        assert!(render(&test, &uploaded, &scene, &settings) != expected, "the table's shadow moves");
        let mut mover = vertex_mover(&test, &uploaded, &raised.vertices, rebuilds);
        let ticket = mover.submit(&[]).unwrap();
        // Nothing waits for the new structures but the barriers.
        let moved = render(&test, &uploaded, &scene, &settings);
        mover.wait(ticket).unwrap();
        assert_eq!(moved == expected, rebuilds, "old structures are noticed");
    }
}

/// The triangles of a tree in its order.
fn order(tree: &SceneBvh) -> Vec<u32> {
    tree.triangles.iter().map(|triangle| triangle.triangle_index).collect()
}

#[test]
fn structures_follow_a_scene_in_motion() {
    let mut scene = screens_that_change_places();
    let built = bvh::build(&scene);
    let mut keeps_order = |time_s: f64| {
        scene.pose(time_s);
        order(&MovingBvh::new(&built).at(&scene)) == order(&built)
    };
    assert_eq!([0.05, 1.9].map(&mut keeps_order), [true, false], "a tree that is built anew is to be among them");
    scene.pose(0.0);
    let Some(test) = gpu_with_queries() else { return };
    let settings = |rays| {
        one_ray_each(rays).changed(|s| {
            s.render.technique = Technique::Direct;
            s.render.view = View::Direct;
        })
    };
    for on_device in [false, true] {
        scene.pose(0.0);
        let mut uploaded = UploadedScene::with_rays(&test.gpu, &scene, Rays::Query).unwrap();
        let mut mover = SceneMover::new(&test.gpu, &scene, &uploaded).unwrap();
        let at_rest = render(&test, &uploaded, &scene, &settings(Rays::Query));
        for time_s in [0.05, 1.0, 1.9, 0.05] {
            if on_device {
                scene.pose_without_vertices(time_s);
                mover.follow(&mut uploaded, &mut scene).unwrap();
            } else {
                scene.pose(time_s);
                uploaded.follow(&test.gpu, &scene).unwrap();
            }
            let [bvh, query] = [Rays::Bvh, Rays::Query].map(|rays| render(&test, &uploaded, &scene, &settings(rays)));
            let agreeing = agreement(&bvh, &query);
            eprintln!("{time_s} s: {:.4} % of shadow rays agree", 100.0 * agreeing);
            assert!(agreeing >= AGREEMENT, "{time_s} s: {agreeing}");
            let still = agreement(&at_rest, &bvh);
            assert!(still < AGREEMENT, "{time_s} s: shadows of a scene at rest are not noticed: {still}");
        }
    }
}
