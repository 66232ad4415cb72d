//! Descent from coarse lights to the lights S0: the tables and the representatives on the GPU.

mod common;

use common::hierarchy::{Hierarchy, Options, Readback};
use common::light_sets::uniform;
use glam::Vec3;
use gridlight::cpu::lights::LightList;
use gridlight::settings::Build;

/// Words of a table and representatives of an S1 light, as in `shaders/descent`.
const TABLE_WORDS: usize = 2 * 27 + 2;
const REPRESENTATIVES: usize = 4;

fn run(lights: &LightList, top: u32, build: Build) -> Readback {
    let test = common::gpu();
    let options = Options {
        top,
        build,
        interleave: 1,
        first_level: 1,
        light_capacity: lights.len().max(1) as u32,
        grid_capacity: None,
    };
    Hierarchy::new(&test.gpu, options).run(lights, 5.0)
}

/// The parts of grid light `index`: (luminance share, part).
fn parts(gpu: &Readback, index: usize) -> Vec<(f32, usize)> {
    let table = &gpu.tables[(index - gpu.table.range(2).start) * TABLE_WORDS..][..TABLE_WORDS];
    let mut before = 0.0;
    (0..table[0] as usize)
        .map(|part| {
            let cumulative = f32::from_bits(table[2 + 2 * part]);
            let share = cumulative - before;
            before = cumulative;
            (share, table[3 + 2 * part] as usize)
        })
        .collect()
}

/// What is wrong with the tables of level `level`: a light is the sum of its parts.
fn check_tables(gpu: &Readback, level: u32) -> Result<(), String> {
    for index in gpu.table.range(level) {
        let light = &gpu.lights[index];
        let parts = parts(gpu, index);
        let sum: f32 = parts.iter().map(|(share, _)| share).sum();
        // Shares are float sums in another order than the light's own.
        if (sum / light.luminance - 1.0).abs() > 1e-3 {
            return Err(format!("light {index} has luminance {}, its parts {sum}", light.luminance));
        }

        if parts.iter().any(|(_, part)| gpu.lights[*part].level != level - 1) {
            return Err(format!("light {index} has a part that is not of level {}", level - 1));
        }
    }
    Ok(())
}

#[test]
fn a_light_is_the_sum_of_its_parts() {
    for (count, top) in [(1, 3), (2, 3), (257, 5), (5000, 6)] {
        // With the scatter build the identity of the weights is exact from S1 on.
        let gpu = run(&uniform(count, 5), top, Build::Scatter);
        for level in 2..=top {
            check_tables(&gpu, level).unwrap_or_else(|e| panic!("{count} lights, level {level}: {e}"));
        }
        // S1 centres stand in for the lights in the gather build: exact from level 2 on.
        let gpu = run(&uniform(count, 5), top, Build::Gather);
        for level in 3..=top {
            check_tables(&gpu, level).unwrap_or_else(|e| panic!("{count} lights, gather, level {level}: {e}"));
        }
    }
}

#[test]
fn a_wrong_share_is_noticed() {
    let mut gpu = run(&uniform(257, 5), 5, Build::Scatter);
    let last = 2 * gpu.tables[0] as usize;
    gpu.tables[last] = (f32::from_bits(gpu.tables[last]) * 1.01).to_bits();
    assert!(check_tables(&gpu, 2).is_err());
}

#[test]
fn every_s1_light_has_representatives_of_its_own_cells() {
    for count in [1, 2, 255, 257, 3000] {
        let lights = uniform(count, 6);
        let gpu = run(&lights, 5, Build::Gather);
        let n = gpu.grid.levels.vertices_per_axis(1);
        let h = gpu.grid.cell_size(1);
        let origin = Vec3::from(gpu.grid.placement.origin_ws);
        for index in gpu.table.range(1) {
            let vertex = gpu.lights[index].vertex;
            let at = origin + Vec3::new((vertex % n) as f32, (vertex / n % n) as f32, (vertex / n / n) as f32) * h;
            for word in &gpu.representatives[index * REPRESENTATIVES..][..REPRESENTATIVES] {
                assert_ne!(*word, u32::MAX, "{count} lights: S1 light {index} has none");
                let light = (word & ((1 << gpu.index_bits) - 1)) as usize;
                assert!(light < count, "{count} lights: S1 light {index} names {light}");
                let position = Vec3::from_array(std::array::from_fn(|i| f32::from_bits(lights.positions[light][i])));
                let distance = (position - at).abs().max_element();
                assert!(distance <= h * 1.0001, "{count} lights: {light} is {distance} off S1 light {index}");
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
    let gpu = run(&lights, 7, Build::Gather);
    let range = gpu.table.range(1);
    let words = &gpu.representatives[range.start * REPRESENTATIVES..range.end * REPRESENTATIVES];
    let bright = words.iter().filter(|word| *word & 1 == 0).count();
    let share = bright as f64 / words.len() as f64;
    // Some 50,000 draws, partly from the same pairs: a standard deviation near 0.003.
    assert!((share - 0.75).abs() < 0.012, "{share} of {} draws", words.len());
}
