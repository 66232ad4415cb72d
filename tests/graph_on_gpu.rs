//! Kinds of resources that the frame graph knows, put to work on the GPU by passes of their own.

mod common;

use ash::vk::Format;
use common::counter::Counter;
use common::gpu;
use common::rooms::{add_quad, furnished_room};
use glam::Vec3;
use gridlight::gpu::{ComputeWork, Executor, ScenePart, TransferOp, Work};
use gridlight::graph::{Access, BufferHandle, Graph, ImageHandle, ImageInfo, Pass};
use gridlight::passes::{shader, threads};
use gridlight::renderer::{Job, Renderer, UploadedScene};
use gridlight::scene::{Light, Scene};
use gridlight::settings::{Settings, Size, Technique};
use gridlight::shared::PunctualLight;

fn one_texel_counter(gpu: &common::GpuTest) -> Counter {
    Counter::new(gpu, ImageInfo::new(Format::R32_UINT, 1, 1), 0)
}

#[test]
fn what_each_frame_adds_one_to_counts_frames_from_the_last_cut() {
    let gpu = gpu();
    let mut counter = one_texel_counter(&gpu);
    assert!(!counter.executor.history_is_valid(), "nothing was before the first frame");
    assert_eq!(counter.run(1), [1, 1]);
    assert!(counter.executor.history_is_valid());
    for frames in 2..8 {
        assert_eq!(counter.run(1), [frames; 2]);
        assert_eq!(counter.counts(counter.count.previous, counter.image.previous), [frames - 1; 2]);
    }
    assert_eq!(counter.run(6), [13, 13], "two frames in flight");
    counter.executor.invalidate_history();
    assert_eq!(counter.run(4), [4, 4], "from the cut on");
    let mut other = one_texel_counter(&gpu);
    assert_eq!(other.run(3), [3, 3], "another size is another executor, which starts anew");
}

#[test]
fn a_dump_repeats_the_last_frame_with_the_history_it_had() {
    let gpu = gpu();
    let mut counter = one_texel_counter(&gpu);
    for frames in 1..5 {
        let valid = counter.constants();
        assert_eq!(counter.run(1), [frames; 2]);
        let mut written = Vec::new();
        let visit = |_, left: Vec<gridlight::gpu::Written>| {
            written.extend(left.into_iter().map(|left| (left.resource, left.bytes)));
            Ok(())
        };
        counter.executor.run_and_read(bytemuck::cast_slice(&valid), visit).unwrap();
        let resources = counter.executor.graph().resources();
        let count_of = |name: &str| {
            let (_, bytes) = written.iter().find(|(resource, _)| resources[*resource].name == name).unwrap();
            bytemuck::pod_read_unaligned::<u32>(&bytes[..4])
        };
        assert_eq!([count_of("count"), count_of("count_image")], [frames; 2], "the same frame once more");
    }
}

/// A room under two lamps that only shine to one side.
fn lamps() -> Scene {
    let lamp = |x: f32| Light::Spot {
        position_ws: Vec3::new(x, 1.5, 0.0),
        direction_ws: Vec3::NEG_Y,
        intensity: Vec3::splat(5.0),
        inner_cos: 0.9,
        outer_cos: 0.6,
    };
    Scene { lights: vec![lamp(-0.8), lamp(0.9)], ..furnished_room() }
}

fn direct() -> Settings {
    Settings::default().changed(|s| {
        s.picture.size = Size { width: 64, height: 48 };
        s.render.technique = Technique::Direct;
    })
}

fn picture(renderer: &mut Renderer) -> Vec<f32> {
    let ticket = renderer.submit().unwrap();
    renderer.wait(ticket).unwrap();
    renderer.read_radiance().unwrap()
}

/// A graph that copies new lights into the scene's, then what the scene has into a buffer of its own.
fn light_mover(gpu: &common::GpuTest, uploaded: &UploadedScene, lights: &[PunctualLight]) -> (Executor, BufferHandle) {
    let size_bytes = size_of_val(lights) as u64;
    let mut graph = Graph::new();
    let moved = graph.persistent_buffer("moved", size_bytes);
    let seen = graph.persistent_buffer("seen", size_bytes);
    let scene_lights = graph.imported_buffer(ScenePart::Lights.name());
    let copy = |from, to| Work::Transfer(vec![TransferOp::Copy { from, to, offset_bytes: 0 }]);
    let pass = |name, from, to| {
        Pass::new(name, copy(from, to)).uses(from, Access::TransferRead).uses(to, Access::TransferWrite)
    };
    graph.add_pass(pass("move", moved, scene_lights));
    graph.add_pass(pass("see", scene_lights, seen));
    let executor = Executor::new(&gpu.gpu, graph, Some(uploaded.set().clone())).unwrap();
    executor.write_buffer(moved, bytemuck::cast_slice(lights)).unwrap();
    (executor, seen)
}

#[test]
fn a_pass_that_moves_lights_is_seen_by_the_next_pass_and_by_other_graphs() {
    let gpu = gpu();
    let scene = lamps();
    let upload = || UploadedScene::new(&gpu.gpu, &scene).unwrap();
    let renderer_of = |uploaded| Renderer::new(&Job::new(&gpu.gpu, uploaded, &scene.cameras[0], &direct())).unwrap();
    let uploaded = upload();
    let mut moved = uploaded.other_lights().to_vec();
    assert_eq!(moved.len(), 2);
    moved[0].position_ws = [-0.2, 1.2, 0.6];
    moved[1].intensity = [1.0, 7.0, 2.0];

    let (mut mover, seen) = light_mover(&gpu, &uploaded, &moved);
    let mut renderer = renderer_of(&uploaded);
    let before = picture(&mut renderer);
    let ticket = mover.submit(&[]).unwrap();
    // Nothing waits for the first graph but the barriers.
    let by_pass = picture(&mut renderer);
    mover.wait(ticket).unwrap();
    assert_eq!(mover.read_buffer(seen).unwrap(), bytemuck::cast_slice::<_, u8>(&moved));

    let mut other = renderer_of(&upload());
    assert_eq!(picture(&mut other), before);
    other.update_lights(&moved).unwrap();
    let by_update = picture(&mut other);
    assert!(before != by_update, "the lamps have moved");
    assert!(by_pass == by_update, "a pass of another graph moves them like an update");
    assert!(picture(&mut other) == by_update, "an update lasts");
}

#[test]
fn any_number_of_lights_is_updated_and_more_than_there_are_is_an_error() {
    let gpu = gpu();
    let mut scene = lamps();
    let lamp = scene.lights[0].clone();
    // Two commands and a part of a third.
    scene.lights = vec![lamp; 2500];
    let uploaded = UploadedScene::new(&gpu.gpu, &scene).unwrap();
    let mut lights = uploaded.other_lights().to_vec();
    for (index, light) in lights.iter_mut().enumerate() {
        light.intensity = [index as f32, 0.0, 1.0];
    }
    let small = direct().changed(|s| s.picture.size = Size { width: 4, height: 4 });
    let mut renderer = Renderer::new(&Job::new(&gpu.gpu, &uploaded, &scene.cameras[0], &small)).unwrap();
    renderer.update_lights(&lights).unwrap();
    picture(&mut renderer);
    let on_device = uploaded.read_back(&gpu.gpu).unwrap().lights;
    assert!(on_device == bytemuck::cast_slice::<_, u8>(&lights), "every light of the update is there");
    lights.push(lights[0]);
    let error = renderer.update_lights(&lights).expect_err("there is no room for one more");
    assert!(error.to_string().contains("160064 bytes of lights do not fit into the scene's 160000"), "{error}");
}

/// Texels of the BVH that a test writes: more than a row of them.
const WRITTEN_TEXELS: u32 = 4200;

fn over_texels(name: &str) -> Work {
    Work::Compute(ComputeWork { push: vec![WRITTEN_TEXELS], ..shader(name, threads(WRITTEN_TEXELS)) })
}

/// A pass that copies the first texels of an image of words into the buffer that it declares.
fn add_reader(graph: &mut Graph<Work>, words: ImageHandle) -> BufferHandle {
    let seen = graph.persistent_buffer("seen", 16 * u64::from(WRITTEN_TEXELS));
    let pass = Pass::new("read_words", over_texels("tests/read_words"))
        .bind("words", words, Access::ComputeSampled)
        .bind("seen", seen, Access::ComputeWrite);
    graph.add_pass(pass);
    seen
}

#[test]
fn a_pass_that_writes_the_bvh_is_seen_by_the_next_pass_and_by_other_graphs() {
    let gpu = gpu();
    // Rows of quads, until the nodes and the triangles each have more than a row of texels.
    let mut scene = furnished_room();
    for i in 0..10_000_u32 {
        let corner = Vec3::new((i % 100) as f32, (i / 100) as f32, 2.0);
        add_quad(&mut scene, [corner, corner + Vec3::X, corner + Vec3::X + Vec3::Y, corner + Vec3::Y]);
    }
    let uploaded = UploadedScene::new(&gpu.gpu, &scene).unwrap();
    let expected: Vec<u32> = (0..4 * WRITTEN_TEXELS).collect();
    for part in [ScenePart::Nodes, ScenePart::Triangles] {
        let run = |add_passes: &dyn Fn(&mut Graph<Work>, ImageHandle) -> BufferHandle| {
            let mut graph = Graph::new();
            let words = graph.imported_image(part.name(), Format::R32G32B32A32_UINT);
            let seen = add_passes(&mut graph, words);
            let mut executor = Executor::new(&gpu.gpu, graph, Some(uploaded.set().clone())).unwrap();
            let ticket = executor.submit(&[]).unwrap();
            executor.wait(ticket).unwrap();
            bytemuck::pod_collect_to_vec::<u8, u32>(&executor.read_buffer(seen).unwrap())
        };
        assert!(run(&add_reader) != expected, "{part:?} is as uploaded");
        let write_and_read = |graph: &mut Graph<Work>, words| {
            let pass = Pass::new("write_words", over_texels("tests/write_words"));
            graph.add_pass(pass.bind("words", words, Access::ComputeWrite));
            add_reader(graph, words)
        };
        assert!(run(&write_and_read) == expected, "the next pass reads what has been written to {part:?}");
        assert!(run(&add_reader) == expected, "another graph reads what has been written to {part:?}");
    }
}
