//! Rays with numbers that are not finite end at once: they hit nothing, and visit no node below the root.

mod common;

use common::rooms::furnished_room;
use gridlight::gpu::{ComputeWork, Dispatch, Executor, Work};
use gridlight::graph::{Access, Graph, Pass};
use gridlight::passes::shader;
use gridlight::renderer::UploadedScene;
use gridlight::scene::{Scene, Vertex};

/// As in the shader.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct TestRay {
    origin: [f32; 3],
    t_max: f32,
    direction: [f32; 3],
    any_hit: u32,
}

const WHOLE: TestRay = TestRay { origin: [0.1, 0.0, 0.2], t_max: 3e38, direction: [0.3, -0.9, 0.2], any_hit: 0 };

/// The room with so many small triangles in the middle that its BVH has several levels.
fn room_with_many_triangles() -> Scene {
    let mut scene = furnished_room();
    let template = scene.vertices[0];
    for i in 0..512_u32 {
        let [x, y, z] = [i % 8, i / 8 % 8, i / 64].map(|step| 0.1 * step as f32 - 0.4);
        let first = scene.vertices.len() as u32;
        let corners = [[x, y, z], [x + 0.05, y, z], [x, y, z + 0.05]];
        scene.vertices.extend(corners.map(|position_ws| Vertex { position_ws, ..template }));
        scene.indices.extend([first, first + 1, first + 2]);
        scene.triangle_materials.push(0);
    }
    scene
}

/// Visits of nodes by each ray, and whether it hits.
fn cast(test: &common::GpuTest, uploaded: &UploadedScene, rays: &[TestRay]) -> Vec<[u32; 2]> {
    let mut graph = Graph::new();
    let given = graph.persistent_buffer("rays", size_of_val(rays) as u64);
    let results = graph.persistent_buffer("results", 8 * rays.len() as u64);
    let work =
        ComputeWork { uses_scene: true, ..shader("tests/count_visits", Dispatch::Groups([rays.len() as u32, 1, 1])) };
    let pass = Pass::new("cast", Work::Compute(work));
    let pass = pass.bind("rays", given, Access::ComputeRead).bind("results", results, Access::ComputeWrite);
    graph.add_pass(pass);
    let mut executor = Executor::new(&test.gpu, graph, Some(uploaded.set().clone())).unwrap();
    executor.write_buffer(given, bytemuck::cast_slice(rays)).unwrap();
    let ticket = executor.submit(&[]).unwrap();
    executor.wait(ticket).unwrap();
    bytemuck::pod_collect_to_vec(&executor.read_buffer(results).unwrap())
}

#[test]
fn rays_that_are_not_finite_end_at_the_root() {
    let test = common::gpu();
    let uploaded = UploadedScene::new(&test.gpu, &room_with_many_triangles()).unwrap();
    let mut rays = vec![WHOLE, TestRay { any_hit: 1, ..WHOLE }];
    for value in [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for any_hit in [0, 1] {
            let ray = TestRay { any_hit, ..WHOLE };
            rays.push(TestRay { t_max: value, ..ray });
            for axis in 0..3 {
                let mut broken = [ray; 2];
                broken[0].origin[axis] = value;
                broken[1].direction[axis] = value;
                rays.extend(broken);
            }
            rays.push(TestRay { origin: [value; 3], direction: [value; 3], ..ray });
        }
    }
    let results = cast(&test, &uploaded, &rays);
    let (whole, broken) = results.split_at(2);
    println!("visits of whole rays: {whole:?}, of others: {broken:?}");
    assert!(whole[0][0] > 1 && whole.iter().all(|[_, hit]| *hit == 1), "whole rays hit, below the root: {whole:?}");
    for (ray, [visits, hit]) in rays[2..].iter().zip(broken) {
        let what = format!("from {:?} along {:?} up to {}", ray.origin, ray.direction, ray.t_max);
        assert!(*visits <= 1 && *hit == 0, "{what}: {visits} visits, hit {hit}");
    }
}

#[test]
fn a_ray_without_length_or_direction_ends() {
    let test = common::gpu();
    let uploaded = UploadedScene::new(&test.gpu, &room_with_many_triangles()).unwrap();
    let rays =
        [TestRay { t_max: 0.0, ..WHOLE }, TestRay { t_max: -1.0, ..WHOLE }, TestRay { direction: [0.0; 3], ..WHOLE }];
    for [_, hit] in cast(&test, &uploaded, &rays) {
        assert_eq!(hit, 0);
    }
}
