//! Descent from coarse lights to the lights S0: the tables and the representatives on the GPU.

mod common;

use std::collections::HashMap;

use common::compare::{Verdict, near, within};
use common::hierarchy::{Hierarchy, Options, Readback};
use common::light_sets::uniform;
use glam::{IVec3, Vec3};
use gridlight::cpu::lights::LightList;
use gridlight::settings::{CenterWeight, LevelBuild};

/// Shares are float sums in another order than the light's own.
const SUM_TOLERANCE: f32 = 1e-3;
/// A share is one product, its place among the others one sum of a few of them.
const SHARE_TOLERANCE: f32 = 1e-5;
/// Words of a table and representatives of an S1 light, as in `shaders/descent`.
const TABLE_WORDS: usize = 2 * 27 + 2;
const REPRESENTATIVES: usize = 4;

fn run(lights: &LightList, top: u32, build: LevelBuild) -> Readback {
    let test = common::gpu();
    let options = Options {
        top,
        build,
        center: CenterWeight::Intensity,
        interleave: 1,
        first_level: 1,
        light_capacity: lights.len().max(1) as u32,
        grid_capacity: None,
    };
    Hierarchy::new(&test.gpu, options).run(lights, 5.0)
}

/// The parts of grid light `index`: (luminance up to and with the part, part).
fn parts(gpu: &Readback, index: usize) -> Vec<(f32, usize)> {
    let table = &gpu.tables[(index - gpu.table.range(2).start) * TABLE_WORDS..][..TABLE_WORDS];
    let pairs = table[2..].chunks_exact(2).take(table[0] as usize);
    pairs.map(|pair| (f32::from_bits(pair[0]), pair[1] as usize)).collect()
}

/// The parts that grid light `index` must have: lights at the 27 vertices about its own on the level below, by the
/// hat of its vertex at theirs, which is 1/2 for a step along an axis.
fn expected_parts(gpu: &Readback, by_vertex: &HashMap<u32, usize>, index: usize) -> Vec<(f32, usize)> {
    let light = &gpu.lights[index];
    let below = light.level - 1;
    let middle = 2 * gpu.grid.vertex_from_index(light.vertex, light.level).as_ivec3();
    let last = gpu.grid.levels.vertices_per_axis(below) as i32 - 1;
    let mut cumulative = 0.0;
    let steps = (0..27).map(|i| IVec3::new(i % 3, i / 3 % 3, i / 9) - 1);
    steps
        .filter_map(|step| {
            let vertex = middle + step;
            let inside = vertex.cmpge(IVec3::ZERO).all() && vertex.cmple(IVec3::splat(last)).all();
            let part = *by_vertex.get(&inside.then(|| gpu.grid.vertex_index(vertex.as_uvec3(), below))?)?;
            cumulative += 0.5_f32.powi(step.abs().element_sum()) * gpu.lights[part].luminance;
            Some((cumulative, part))
        })
        .collect()
}

/// Whether the tables of level `level` list what the lights are made of.
fn check_tables(gpu: &Readback, level: u32) -> Verdict {
    let by_vertex: HashMap<u32, usize> =
        gpu.table.range(level - 1).map(|index| (gpu.lights[index].vertex, index)).collect();
    if gpu.table.range(level).is_empty() {
        return Err(format!("level {level} has no lights"));
    }
    for index in gpu.table.range(level) {
        let (found, expected) = (parts(gpu, index), expected_parts(gpu, &by_vertex, index));
        let same = |((a, part), (b, other)): (&(f32, usize), &(f32, usize))| {
            part == other && within(a - b, SHARE_TOLERANCE * b.abs())
        };
        if found.len() != expected.len() || !found.iter().zip(&expected).all(same) {
            return Err(format!("light {index} has the parts {found:?}, not {expected:?}"));
        }
    }
    Ok(())
}

/// Whether every light of level `level` is as bright as its parts together.
fn check_sums(gpu: &Readback, level: u32) -> Verdict {
    for index in gpu.table.range(level) {
        let (light, sum) = (&gpu.lights[index], parts(gpu, index).last().map_or(0.0, |(sum, _)| *sum));
        if !within(sum - light.luminance, SUM_TOLERANCE * light.luminance) {
            return Err(format!("light {index} has luminance {}, its parts {sum}", light.luminance));
        }
    }
    Ok(())
}

#[test]
fn a_light_is_the_sum_of_its_parts() {
    for (count, top) in [(1, 3), (2, 3), (257, 5), (5000, 6)] {
        // With the scatter build the identity of the weights is exact from S1 on; S1 centres stand in for the lights
        // in the gather build, which is exact from level 2 on.
        for (build, first) in [(LevelBuild::Scatter, 2), (LevelBuild::Gather, 3)] {
            let gpu = run(&uniform(count, 5), top, build);
            for level in 2..=top {
                let sums = if level < first { Ok(()) } else { check_sums(&gpu, level) };
                let verdict = check_tables(&gpu, level).and(sums);
                verdict.unwrap_or_else(|e| panic!("{count} lights, {build:?}, level {level}: {e}"));
            }
        }
    }
}

#[test]
fn planted_faults_are_noticed() {
    let gpu = run(&uniform(257, 5), 5, LevelBuild::Scatter);
    let parts = gpu.tables[0] as usize;
    assert!(parts > 2);
    let fails = |what: &str, check: &dyn Fn(&Readback, u32) -> Verdict, plant: &dyn Fn(&mut Readback)| {
        let mut wrong = gpu.clone();
        plant(&mut wrong);
        assert!(check(&gpu, 2).is_ok() && check(&wrong, 2).is_err(), "{what} was not noticed");
    };
    let scale = |word: &mut u32, factor: f32| *word = (f32::from_bits(*word) * factor).to_bits();
    fails("a wrong share", &check_tables, &|gpu| scale(&mut gpu.tables[2], 1.001));
    fails("a share that is no number", &check_tables, &|gpu| gpu.tables[2] = f32::NAN.to_bits());
    fails("a part of another level", &check_tables, &|gpu| gpu.tables[3] += 2000);
    fails("a lost part", &check_tables, &|gpu| gpu.tables[0] -= 1);
    fails("a wrong sum", &check_sums, &|gpu| scale(&mut gpu.tables[2 * parts], 1.01));
    fails("a sum that is no number", &check_sums, &|gpu| gpu.tables[2 * parts] = f32::NAN.to_bits());
    let first = gpu.table.range(2).start;
    fails("a light that is no number", &check_sums, &|gpu| gpu.lights[first].luminance = f32::NAN);
    fails("a level without lights", &check_tables, &|gpu| gpu.table.0[5] = 0);
}

#[test]
fn every_s1_light_has_representatives_of_its_own_cells() {
    for count in [1, 2, 255, 257, 3000] {
        let lights = uniform(count, 6);
        let gpu = run(&lights, 5, LevelBuild::Gather);
        let n = gpu.grid.levels.vertices_per_axis(1);
        let h = gpu.grid.cell_size(1);
        let origin = Vec3::from(gpu.grid.placement.origin_ws);
        assert!(!gpu.table.range(1).is_empty());
        for index in gpu.table.range(1) {
            let vertex = gpu.lights[index].vertex;
            let at = origin + Vec3::new((vertex % n) as f32, (vertex / n % n) as f32, (vertex / n / n) as f32) * h;
            for word in &gpu.representatives[index * REPRESENTATIVES..][..REPRESENTATIVES] {
                assert_ne!(*word, u32::MAX, "{count} lights: S1 light {index} has none");
                let light = (word & ((1 << gpu.index_bits) - 1)) as usize;
                assert!(light < count, "{count} lights: S1 light {index} names {light}");
                let position = Vec3::from_array(std::array::from_fn(|i| f32::from_bits(lights.positions[light][i])));
                assert!(
                    near(position, at, h * 1.0001),
                    "{count} lights: {light} is at {position}, S1 light {index} {at}"
                );
            }
        }
    }
}

#[test]
fn representatives_follow_luminance() {
    // Pairs of lights at one point, the first three times as bright: it must represent three times of four.
    let mut lights = uniform(4000, 7);
    for pair in 0..2000 {
        lights.positions[2 * pair + 1] = lights.positions[2 * pair];
        lights.fluxes[2 * pair] = [3.0, 3.0, 3.0, 1.0];
        lights.fluxes[2 * pair + 1] = [1.0, 1.0, 1.0, 1.0];
    }
    let gpu = run(&lights, 7, LevelBuild::Gather);
    let range = gpu.table.range(1);
    let words = &gpu.representatives[range.start * REPRESENTATIVES..range.end * REPRESENTATIVES];
    let bright = words.iter().filter(|word| *word & 1 == 0).count();
    let share = bright as f64 / words.len() as f64;
    // Some 50,000 draws, partly from the same pairs: a standard deviation near 0.003.
    assert!((share - 0.75).abs() < 0.012, "{share} of {} draws", words.len());
}
