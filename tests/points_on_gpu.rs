//! The points' tree as shaders read it, against the same on the CPU.

mod common;

use bytemuck::Zeroable;
use common::compare;
use common::hierarchy::frame_shape;
use glam::{Vec2, Vec3};
use gridlight::gpu::{ComputeWork, Executor};
use gridlight::graph::Access;
use gridlight::passes::points::Points;
use gridlight::passes::{Frame, shader, threads};
use gridlight::points::{Node, PointCloud, after_subtree, unpack_rgb9e5};
use gridlight::random::r2_sequence;
use gridlight::scene::testing::box_room;
use gridlight::shared::FrameData;

/// Hits of each triangle.
const HITS: u32 = 50;

/// What the shader tells: five texels a node, keys, leaves of hits.
#[derive(Clone, Debug, PartialEq)]
struct Told {
    nodes: Vec<[[f32; 4]; 5]>,
    keys: Vec<[u32; 4]>,
    leaves: Vec<u32>,
}

fn cloud() -> PointCloud {
    let mut scene = box_room(2.0, Vec3::new(0.8, 0.4, 0.2));
    // Walls of several thicknesses meet here, so that some nodes oppose their parents.
    let back: Vec<u32> = scene.indices.chunks_exact(3).flat_map(|t| [t[0], t[2], t[1]]).collect();
    scene.indices.extend(back);
    scene.triangle_materials.extend([0; 12]);
    PointCloud::of_scene(&scene, 10).unwrap()
}

fn hits() -> Vec<[f32; 4]> {
    let hit = |i: u32| {
        let [x, y] = r2_sequence(i, 3);
        let [x, y] = if x + y > 1.0 { [1.0 - x, 1.0 - y] } else { [x, y] };
        [x, y, (i % 24) as f32, 0.0]
    };
    (0..24 * HITS).map(hit).collect()
}

fn told_by_gpu(cloud: &PointCloud) -> Told {
    let test = common::gpu();
    let mut frame = Frame::without_scene(frame_shape());
    let points = Points::declare(&mut frame, cloud);
    let (nodes, hits) = (u64::from(points.node_count()), hits());
    let given = frame.graph.filled_buffer("hits", bytemuck::cast_slice(&hits).into());
    let seen = frame.graph.persistent_buffer("seen", 80 * nodes);
    let keys = frame.graph.persistent_buffer("keys", 16 * nodes);
    let leaves = frame.graph.persistent_buffer("hit_leaves", 4 * hits.len() as u64);
    let count = points.node_count().max(hits.len() as u32);
    let work = ComputeWork { push: vec![hits.len() as u32], ..shader("tests/read_points", threads(count)) };
    let pass = frame
        .compute("read_points", work)
        .bind("point_nodes", points.nodes, Access::ComputeSampled)
        .bind("point_albedos", points.albedos, Access::ComputeRead)
        .bind("triangle_cells", points.triangle_cells, Access::ComputeRead)
        .bind("leaf_cells", points.leaf_cells, Access::ComputeRead)
        .bind("hits", given, Access::ComputeRead)
        .bind("seen", seen, Access::ComputeWrite)
        .bind("keys", keys, Access::ComputeWrite)
        .bind("hit_leaves", leaves, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    let data = FrameData { point_leaf_count: cloud.leaf_count(), ..FrameData::zeroed() };
    let mut executor = Executor::new(&test.gpu, frame.graph, None).unwrap();
    let ticket = executor.submit(bytemuck::bytes_of(&data)).unwrap();
    executor.wait(ticket).unwrap();
    let read = |buffer| executor.read_buffer(buffer).unwrap();
    Told {
        nodes: bytemuck::pod_collect_to_vec(&read(seen)),
        keys: bytemuck::pod_collect_to_vec(&read(keys)),
        leaves: bytemuck::pod_collect_to_vec(&read(leaves)),
    }
}

fn told_by_cpu(cloud: &PointCloud) -> Told {
    let bit = |is_set: bool| if is_set { 1.0 } else { 0.0 };
    let count = cloud.leaf_count();
    let four = |v: Vec3, w: f32| v.extend(w).to_array();
    let texels = |i: u32| {
        let n: Node = cloud.node(i);
        [
            four(n.centroid_ws, n.radius),
            four(n.normal, n.area),
            [n.normal_length, n.cone_cos, n.half_thickness, bit(n.is_solid)],
            four(cloud.node(count + n.leaf).centroid_ws, bit(n.is_turned)),
            four(unpack_rgb9e5(cloud.albedos[i as usize]), i.ilog2() as f32),
        ]
    };
    let turned = |i: u32| u32::from(cloud.node(i).is_turned);
    let keys = |i: u32| {
        let child = |c: u32| if i < count { 2 * (2 * i + c) + turned(2 * i + c) } else { 0 };
        [2 * (i / 2) + (1 ^ turned(i)), child(0), child(1), after_subtree(i)]
    };
    let leaf = |[x, y, triangle, _]: [f32; 4]| cloud.leaf_of_hit(triangle as u32, Vec2::new(x, y));
    Told {
        nodes: (1..2 * count).map(texels).collect(),
        keys: (1..2 * count).map(keys).collect(),
        leaves: hits().into_iter().map(leaf).collect(),
    }
}

/// The first difference between what the two tell.
fn compare_told(gpu: &Told, cpu: &Told) -> Result<(), String> {
    let numbers = |told: &Told| told.nodes.iter().flatten().flatten().copied().collect::<Vec<f32>>();
    let (found, expected) = (numbers(gpu), numbers(cpu));
    for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
        let is_near = (found - expected).abs() <= 1e-5 * (1.0 + expected.abs());
        if !is_near {
            return Err(format!("number {} of node {}: {found} instead of {expected}", i % 20, i / 20 + 1));
        }
    }
    let words = |told: &Told| told.keys.iter().flatten().copied().collect::<Vec<u32>>();
    compare::exact("keys", &words(gpu), &words(cpu))?;
    compare::exact("leaves of hits", &gpu.leaves, &cpu.leaves)
}

#[test]
fn shaders_read_the_tree_that_was_made() {
    let cloud = cloud();
    let (mut gpu, cpu) = (told_by_gpu(&cloud), told_by_cpu(&cloud));
    gpu.nodes.remove(0);
    gpu.keys.remove(0);
    assert!(cpu.nodes.iter().any(|texels| texels[3][3] == 1.0), "no node is turned");
    compare_told(&gpu, &cpu).unwrap();
    let faults: [fn(&mut Told); 4] = [
        |told| told.nodes[3][1][0] += 1e-3,
        |told| told.nodes[9][2][2] = f32::NAN,
        |told| told.keys[70][0] ^= 1,
        |told| told.leaves[5] += 1,
    ];
    for fault in faults {
        let mut wrong = gpu.clone();
        fault(&mut wrong);
        assert!(compare_told(&wrong, &cpu).is_err());
    }
}
