//! The exclusive scan alone against its twin, at the sizes where its three steps change.

mod common;

use common::compare;
use common::hierarchy::{Options, frame_data, frame_shape, shape};
use common::light_sets::Random;
use gridlight::cpu::exclusive_scan::exclusive_scan;
use gridlight::gpu::Executor;
use gridlight::passes::Frame;
use gridlight::passes::exclusive_scan::{self as pass, ScanRange};
use gridlight::passes::lgh_shape::LghShape;
use gridlight::settings::{CenterWeight, LevelBuild};

/// Words before the scanned range, which must stay as they are.
const BEFORE: usize = 5;

fn any_shape() -> LghShape {
    shape(Options {
        top: 2,
        build: LevelBuild::Gather,
        center: CenterWeight::Intensity,
        interleave: 1,
        first_level: 1,
        light_capacity: 1,
        grid_capacity: None,
    })
}

/// Ranks of `bits` on the GPU, or sums where they are `values`.
fn scan_as(test: &common::GpuTest, bits: &[u32], values: bool) -> Vec<u32> {
    let mut frame = Frame::without_scene(frame_shape());
    let bytes = 4 * (BEFORE + bits.len() + 1) as u64;
    let input = frame.graph.persistent_buffer("bits", bytes);
    let ranks = frame.graph.persistent_buffer("ranks", bytes);
    let (first_word, word_count) = (BEFORE as u32, bits.len() as u32);
    let range = ScanRange { bits: input, ranks, first_word, word_count, keep_ranks: true, values };
    pass::add(&mut frame, "alone", range);
    let data = frame_data(&any_shape(), 1.0);
    let mut executor = Executor::new(&test.gpu, frame.graph, None).unwrap();
    let padded: Vec<u32> = [u32::MAX; BEFORE].iter().chain(bits).chain(&[u32::MAX]).copied().collect();
    executor.write_buffer(input, bytemuck::cast_slice(&padded)).unwrap();
    executor.write_buffer(ranks, &vec![0xff; bytes as usize]).unwrap();
    let ticket = executor.submit(bytemuck::bytes_of(&data)).unwrap();
    executor.wait(ticket).unwrap();
    let found: Vec<u32> = bytemuck::pod_collect_to_vec(&executor.read_buffer(ranks).unwrap());
    assert_eq!(found[..BEFORE], [u32::MAX; BEFORE], "written before the range");
    found[BEFORE..].to_vec()
}

/// Ranks of `bits` on the GPU.
fn scan(test: &common::GpuTest, bits: &[u32]) -> Vec<u32> {
    scan_as(test, bits, false)
}

fn random_bits(count: usize) -> Vec<u32> {
    let mut random = Random::new(count as u32);
    (0..count).map(|_| if random.bits().is_multiple_of(3) { 0 } else { random.bits() }).collect()
}

#[test]
fn reference_and_gpu_on_five_words_by_hand() {
    let bits = [0b1011, 0, u32::MAX, 1 << 31, 0b11];
    let ranks = [0, 3, 3, 35, 36, 38];
    assert_eq!(exclusive_scan(&bits), ranks);
    let test = common::gpu();
    assert_eq!(scan(&test, &bits), ranks);
}

#[test]
fn sizes_around_every_step() {
    let test = common::gpu();
    let block = 1024 * 256;
    for count in [1, 2, 255, 256, 257, 1023, 1024, 1025, block - 1, block, block + 1, 300_000, 1024 * 1024 + 1] {
        let bits = random_bits(count);
        compare::exact(&format!("ranks of {count} words"), &scan(&test, &bits), &exclusive_scan(&bits)).unwrap();
    }
}

#[test]
fn numbers_are_summed_as_they_are() {
    let test = common::gpu();
    assert_eq!(scan_as(&test, &[3, 0, 70_000, 1], true), [0, 3, 3, 70_003, 70_004]);
    for count in [1023, 1024, 1025, 300_000, 1024 * 1024 + 1] {
        let values: Vec<u32> = random_bits(count).iter().map(|word| word % 100).collect();
        let sums: Vec<u32> = std::iter::once(0)
            .chain(values.iter().scan(0, |sum, value| {
                *sum += value;
                Some(*sum)
            }))
            .collect();
        compare::exact(&format!("sums of {count} words"), &scan_as(&test, &values, true), &sums).unwrap();
    }
}

#[test]
fn all_bits_and_none() {
    let test = common::gpu();
    for word in [0, u32::MAX] {
        let bits = vec![word; 5000];
        compare::exact("ranks", &scan(&test, &bits), &exclusive_scan(&bits)).unwrap();
    }
}

#[test]
fn a_rank_off_by_one_is_noticed() {
    let ranks = exclusive_scan(&random_bits(3000));
    let mut wrong = ranks.clone();
    wrong[2999] += 1;
    let verdict = compare::exact("ranks", &wrong, &ranks);
    assert!(verdict.is_err_and(|e| e.contains("ranks[2999]")));
}
