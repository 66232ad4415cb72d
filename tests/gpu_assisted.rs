//! Small frames under GPU-assisted validation, where the layer's own code in the shaders checks every access to a buffer.

mod common;

use std::process::Command;

use bytemuck::Zeroable;
use common::rooms::furnished_room;
use gridlight::gpu::{Executor, Gpu, GpuOptions};
use gridlight::passes::Frame;
use gridlight::passes::exclusive_scan::{self, ScanRange};
use gridlight::renderer::{Job, Renderer, UploadedScene};
use gridlight::settings::{Settings, Size, Technique};
use gridlight::shader::spirv::{self, Spirv};
use gridlight::shared::FrameData;

/// The layer of Debian 12 (1.3.239), when it assists, waits ten seconds for its own note of a timeline semaphore that has
/// long been signalled, and then reports what it calls most likely a bug of its own (Vulkan-ValidationLayers 4968).
const MUTED: &str = "UNASSIGNED-VkSemaphore-state-timeout";

/// Runs an ignored test in a process of its own, as the layer reads its variables when it is loaded; what it prints.
fn in_own_process(test: &str) -> (bool, String) {
    let output = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", test, "--ignored", "--nocapture"])
        .env("VK_LAYER_ENABLES", "VK_VALIDATION_FEATURE_ENABLE_GPU_ASSISTED_EXT")
        .env("VK_LAYER_MESSAGE_ID_FILTER", MUTED)
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
    (output.status.success(), text.into_owned())
}

/// Whether there is a layer to assist.
fn has_layer() -> bool {
    let options = GpuOptions { validation: true, ..GpuOptions::default() };
    let has_layer = Gpu::new(&options).is_ok();
    if !has_layer {
        println!("skipped: the validation layer is not installed");
    }
    has_layer
}

#[test]
fn no_shader_leaves_its_buffers() {
    if !has_layer() {
        return;
    }
    let (passed, text) = in_own_process("frames_under_validation");
    assert!(passed, "{text}");
}

#[test]
fn a_planted_write_past_a_buffer_is_found() {
    if !has_layer() {
        return;
    }
    let (passed, text) = in_own_process("planted_fault");
    assert!(passed, "{text}");
}

/// The shaders as the layer can take them.
fn use_split_shaders() {
    for name in spirv::names() {
        let words = split_loop_headers(&spirv::words(name).unwrap());
        spirv::replace(name, Some(Spirv::new("split".to_owned(), words, spirv::interface(name).unwrap())));
    }
}

#[test]
#[ignore = "run by another test, in a process of its own"]
fn frames_under_validation() {
    use_split_shaders();
    let test = common::gpu();
    let scene = furnished_room();
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    for technique in [Technique::Direct, Technique::Lgh, Technique::BruteForce, Technique::PathTrace] {
        let settings = Settings::default().changed(|s| {
            s.render.technique = technique;
            s.picture.size = Size { width: 33, height: 21 };
            s.many_lights.vpls = 300;
            s.path_trace.samples = 1;
        });
        let mut renderer = Renderer::new(&Job::new(&test.gpu, &uploaded, &scene.cameras[0], &settings)).unwrap();
        // Waits for the whole device, which costs no ten seconds.
        let _ = renderer.submit().unwrap();
        assert!(renderer.read_radiance().unwrap().iter().all(|v| v.is_finite()), "{technique:?}");
        println!("{technique:?}: {:?}", test.gpu.validation_messages());
    }
}

#[test]
#[ignore = "run by another test, in a process of its own"]
fn planted_fault() {
    use_split_shaders();
    let gpu = Gpu::new(&GpuOptions { select: None, validation: true, ..GpuOptions::default() }).unwrap();
    let mut frame = Frame::without_scene(common::hierarchy::frame_shape());
    let bits = frame.graph.persistent_buffer("bits", 4 * 5000);
    let ranks = frame.graph.persistent_buffer("ranks", 4 * 4000);
    let range = ScanRange { bits, ranks, first_word: 0, word_count: 5000, keep_ranks: true, values: false };
    exclusive_scan::add(&mut frame, "past the end", range);
    let mut executor = Executor::new(&gpu, frame.graph, None).unwrap();
    let _ = executor.submit(bytemuck::bytes_of(&FrameData::zeroed())).unwrap();
    gpu.wait_idle().unwrap();
    let messages = gpu.validation_messages();
    assert!(messages.iter().any(|message| message.contains("out of bounds")), "{messages:#?}");
}

const MAGIC_WORDS: usize = 5;
const OP_LINE: u32 = 8;
const OP_PHI: u32 = 245;
const OP_LOOP_MERGE: u32 = 246;
const OP_LABEL: u32 = 248;
const OP_BRANCH: u32 = 249;
const OP_NO_LINE: u32 = 317;

/// Moves what a loop's first block does besides its merge into a block of its own. The layer of Debian 12 puts its
/// checks between the two, which makes modules that no driver need take, and lavapipe does not (Vulkan-ValidationLayers
/// 4827); unoptimised shaders never have them together.
fn split_loop_headers(words: &[u32]) -> Vec<u32> {
    let mut instructions: Vec<Vec<u32>> = Vec::new();
    let mut rest = &words[MAGIC_WORDS..];
    while let Some(first) = rest.first() {
        let (instruction, after) = rest.split_at((first >> 16) as usize);
        instructions.push(instruction.to_vec());
        rest = after;
    }
    let op = |instruction: &[u32]| instruction[0] & 0xffff;
    let branch = |to: u32| vec![2 << 16 | OP_BRANCH, to];
    let mut next_id = words[3];
    let mut moved: Vec<(u32, u32)> = Vec::new();
    let mut split: Vec<Vec<u32>> = Vec::new();
    let mut header = None;
    for (index, instruction) in instructions.iter().enumerate() {
        let is_start = matches!(op(instruction), OP_PHI | OP_LINE | OP_NO_LINE);
        if op(instruction) == OP_LABEL {
            header = None;
            let end = instructions[index + 1..].iter().position(|i| op(i) == OP_LABEL);
            let block = &instructions[index + 1..end.map_or(instructions.len(), |end| index + 1 + end)];
            if let Some(merge) = block.iter().find(|i| op(i) == OP_LOOP_MERGE) {
                header = Some((instruction[1], next_id, merge.clone(), false));
                moved.push((instruction[1], next_id));
                next_id += 1;
            }
        } else if let Some((label, body, merge, done)) = &mut header {
            if !*done && !is_start {
                if merge[2] == *label {
                    merge[2] = *body;
                }
                split.push(merge.clone());
                split.push(branch(*body));
                split.push(vec![2 << 16 | OP_LABEL, *body]);
                *done = true;
            }
            if op(instruction) == OP_LOOP_MERGE {
                continue;
            }
        }
        split.push(instruction.clone());
    }
    for phi in split.iter_mut().filter(|i| op(i) == OP_PHI) {
        for parent in phi[3..].iter_mut().skip(1).step_by(2) {
            if let Some((_, body)) = moved.iter().find(|(label, _)| label == parent) {
                *parent = *body;
            }
        }
    }
    let mut result = words[..MAGIC_WORDS].to_vec();
    result[3] = next_id;
    result.extend(split.into_iter().flatten());
    result
}
