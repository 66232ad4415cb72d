//! Packing the VPLs of the path slots into S0, on the GPU against its twin.

mod common;

use std::sync::Arc;

use common::compare;
use common::hierarchy::{Options, frame_data, frame_shape, shape};
use common::light_sets::{Random, uniform};
use glam::Vec3;
use gridlight::cpu::compact_vpls::compact_vpls;
use gridlight::cpu::lights::LightList;
use gridlight::gpu::{Executor, SceneData, SceneSet};
use gridlight::passes::light_shape::PathPart;
use gridlight::passes::vpl_trace::VplSlots;
use gridlight::passes::{Frame, compaction};
use gridlight::scene::chunks::chunks;
use gridlight::scene::testing::box_room;
use gridlight::scene::upload::{self, PreparedScene};
use gridlight::scene::{Light, Scene, bvh};
use gridlight::settings::{CenterWeight, LevelBuild};

/// A sun and three lamps.
fn scene() -> Scene {
    let mut scene = box_room(2.0, Vec3::splat(0.5));
    scene.lights.extend((0..3).map(|i| {
        let position_ws = Vec3::new(0.1 * i as f32, 0.0, 0.5);
        Light::Point { position_ws, intensity: Vec3::new(1.0, 2.0, i as f32) }
    }));
    scene
}

fn upload(test: &common::GpuTest, scene: &Scene, prepared: &PreparedScene) -> Arc<SceneSet> {
    let bvh = bvh::build(scene);
    let data = SceneData {
        query: None,
        nodes: bytemuck::cast_slice(&bvh.nodes),
        node_capacity_bytes: 0,
        triangles: bytemuck::cast_slice(&bvh.triangles),
        vertices: bytemuck::cast_slice(&scene.vertices),
        tangents: bytemuck::cast_slice(&scene.tangents),
        vertices_move: false,
        indices: bytemuck::cast_slice(&scene.indices),
        materials: bytemuck::cast_slice(&prepared.materials),
        lights: bytemuck::cast_slice(&prepared.lights),
        emitters: &[],
        environment: &prepared.environment,
        albedo_size_px: prepared.albedo.size_px,
        albedo_layers: &prepared.albedo.layers,
        textures: &prepared.textures,
        material_textures: &prepared.material_textures,
        chunks: chunks(scene),
    };
    Arc::new(SceneSet::new(&test.gpu, &data).unwrap())
}

/// S0 and its counts for VPLs in `slots` where `bits` are set.
fn pack(test: &common::GpuTest, slots: &LightList, bits: &[u32], vpl_capacity: u32) -> (LightList, [u32; 3]) {
    let options = Options {
        top: 2,
        build: LevelBuild::Gather,
        center: CenterWeight::Intensity,
        interleave: 1,
        first_level: 1,
        light_capacity: 1,
        grid_capacity: None,
    };
    let scene = scene();
    let prepared = upload::prepare(&scene, test.gpu.report().limits.array_layers);
    let mut shape = shape(options);
    (shape.lights.vpl_capacity, shape.lights.scene_light_count) = (vpl_capacity, 3);
    let mut frame = Frame::new(frame_shape());
    let count = slots.len() as u32;
    let positions = frame.graph.persistent_buffer("slot_positions", 16 * u64::from(count));
    let fluxes = frame.graph.persistent_buffer("slot_fluxes", 16 * u64::from(count));
    let slot_bits = frame.graph.persistent_buffer("slot_bits", 4 * bits.len() as u64);
    let slots_of_paths = VplSlots { positions, fluxes, bits: slot_bits, count };
    let packing = compaction::begin_lights(&mut frame, &shape.lights, &slots_of_paths);
    let all = PathPart { number: None, paths: 0..0, slots: 0..count };
    compaction::pack_part(&mut frame, &shape.lights, &slots_of_paths, &packing, &all);
    let lights = packing.lights;
    let mut data = frame_data(&shape, 1.0);
    data.first_point_light = prepared.first_point_light;
    let set = upload(test, &scene, &prepared);
    let mut executor = Executor::new(&test.gpu, frame.graph, Some(set)).unwrap();
    executor.write_buffer(positions, bytemuck::cast_slice(&slots.positions)).unwrap();
    executor.write_buffer(fluxes, bytemuck::cast_slice(&slots.fluxes)).unwrap();
    executor.write_buffer(slot_bits, bytemuck::cast_slice(bits)).unwrap();
    let ticket = executor.submit(bytemuck::bytes_of(&data)).unwrap();
    executor.wait(ticket).unwrap();
    let counts: Vec<u32> = bytemuck::pod_collect_to_vec(&executor.read_buffer(lights.counts).unwrap());
    let mut packed = LightList {
        positions: bytemuck::pod_collect_to_vec(&executor.read_buffer(lights.positions).unwrap()),
        fluxes: bytemuck::pod_collect_to_vec(&executor.read_buffer(lights.fluxes).unwrap()),
    };
    packed.positions.truncate(counts[0] as usize);
    packed.fluxes.truncate(counts[0] as usize);
    (packed, [counts[0], counts[1], counts[2]])
}

#[test]
fn slots_are_packed_in_order() {
    let test = common::gpu();
    let prepared = upload::prepare(&scene(), 1);
    let lamps = &prepared.lights[prepared.first_point_light as usize..];
    for (count, capacity) in [(1, 4), (31, 64), (32, 64), (33, 64), (5000, 8000), (5000, 100)] {
        let mut random = Random::new(count);
        let slots = uniform(count as usize, count);
        let past_end = u32::MAX >> ((32 - count % 32) % 32);
        let mut bits: Vec<u32> = (0..count.div_ceil(32)).map(|_| random.bits()).collect();
        *bits.last_mut().unwrap() &= past_end;
        let (gpu, gpu_counts) = pack(&test, &slots, &bits, capacity);
        let (twin, twin_counts) = compact_vpls(&slots, &bits, capacity, lamps);
        compare::exact("light counts", &gpu_counts, &twin_counts).unwrap();
        compare::exact("light positions", &gpu.positions, &twin.positions).unwrap();
        // The lamps' flux is intensity times 4 pi, in whatever order a compiler multiplies.
        let vpls = twin_counts[1] as usize;
        compare::exact("VPL fluxes", &gpu.fluxes[..vpls], &twin.fluxes[..vpls]).unwrap();
        for (a, b) in gpu.fluxes[vpls..].iter().zip(&twin.fluxes[vpls..]) {
            assert!((0..4).all(|i| (a[i] - b[i]).abs() <= 4.0 * f32::EPSILON * b[i]), "{a:?} {b:?}");
        }
        let mut wrong = gpu.positions.clone();
        wrong[0][3] ^= 1;
        assert!(compare::exact("light positions", &wrong, &twin.positions).is_err());
    }
}
