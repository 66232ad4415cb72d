//! The lights S0 listed by cell of S1 on the GPU: every light once, in the list of its own cell.

mod common;

use std::collections::BTreeMap;

use common::compare::{Verdict, exact};
use common::hierarchy::{Options, frame_data, frame_shape, shape};
use common::light_sets::{degenerate, shaped, uniform};
use common::written::Written;
use glam::Vec3;
use gridlight::cpu::exclusive_scan::exclusive_scan;
use gridlight::cpu::grid::Grid;
use gridlight::cpu::lights::LightList;
use gridlight::gpu::Executor;
use gridlight::light_grid::Levels;
use gridlight::passes::{Frame, bounds, compaction, light_buckets};
use gridlight::settings::{CenterWeight, LevelBuild};
use gridlight::shared::GridPlacement;

/// Lists that hold fewer lights than they have room for.
const SPARE: u32 = 37;

/// What the passes leave.
#[derive(Clone)]
struct Lists {
    grid: Grid,
    /// One bit per cell.
    cells: Vec<u32>,
    /// Set bits before each word.
    ranks: Vec<u32>,
    /// By rank of the cell, where its lights start.
    starts: Vec<u32>,
    /// The lights by cell.
    listed: Vec<u32>,
    /// The same after sorting.
    sorted: Vec<u32>,
}

fn list(test: &common::GpuTest, lights: &LightList, top: u32) -> Lists {
    let count = lights.len() as u32;
    let options = Options {
        top,
        build: LevelBuild::Cascade,
        center: CenterWeight::Intensity,
        interleave: 1,
        first_level: 1,
        light_capacity: count + SPARE,
        grid_capacity: None,
    };
    let shape = shape(options);
    let mut frame = Frame::without_scene(frame_shape());
    let s0 = compaction::declare_lights(&mut frame, &shape.lights);
    let placement = bounds::add(&mut frame, &s0, &shape.lights, None);
    let buckets = light_buckets::add(&mut frame, &shape, &s0, placement);
    light_buckets::sort(&mut frame, &shape, &buckets);
    let data = frame_data(&shape, 5.0);
    let executor = Executor::new(&test.gpu, frame.graph, None).unwrap();
    executor.write_buffer(s0.positions, bytemuck::cast_slice(&lights.positions)).unwrap();
    executor.write_buffer(s0.fluxes, bytemuck::cast_slice(&lights.fluxes)).unwrap();
    executor.write_buffer(s0.counts, bytemuck::cast_slice(&[count, count, 0, 0])).unwrap();
    let written = Written::by_graph(&executor, &data);
    let placement: Vec<GridPlacement> = written.last("grid_placement");
    Lists {
        grid: Grid { placement: placement[0], levels: Levels::new(top), center: CenterWeight::Intensity },
        cells: written.last("light_bucket_cells"),
        ranks: written.last("light_bucket_ranks"),
        starts: written.last("light_bucket_starts"),
        listed: written.all("light_buckets/list_lights", "light_bucket_lights"),
        sorted: written.all("light_buckets/sort_bucket", "light_bucket_lights"),
    }
}

/// The lights by word and bit of their cell, which is the order of the lists.
fn by_cell(grid: &Grid, lights: &LightList) -> BTreeMap<(usize, u32), Vec<u32>> {
    let mut lists: BTreeMap<_, Vec<u32>> = BTreeMap::new();
    for light in 0..lights.len() {
        let cell = grid.cell_of(grid.grid_position(lights.position(light), 1), 1);
        lists.entry((grid.occupancy_word(cell, 1), cell.x % 32)).or_default().push(light as u32);
    }
    lists
}

fn check(lists: &Lists, lights: &LightList) -> Verdict {
    let expected = by_cell(&lists.grid, lights);
    let mut cells = vec![0; lists.grid.levels.end_word(1) as usize];
    expected.keys().for_each(|(word, bit)| cells[*word] |= 1 << bit);
    exact("cells", &lists.cells, &cells)?;
    exact("ranks", &lists.ranks, &exclusive_scan(&cells))?;
    // Lists that no cell has are empty and lie at the end.
    let mut starts = vec![lights.len() as u32; lists.starts.len()];
    let mut start = 0;
    for (slot, list) in starts.iter_mut().zip(expected.values()) {
        *slot = start;
        start += list.len() as u32;
    }
    exact("starts", &lists.starts, &starts)?;
    for (list, first) in expected.values().zip(starts) {
        let range = first as usize..first as usize + list.len();
        let mut listed = lists.listed[range.clone()].to_vec();
        listed.sort_unstable();
        exact(&format!("the list from {first}"), &listed, list)?;
        exact(&format!("the sorted list from {first}"), &lists.sorted[range], list)?;
    }
    Ok(())
}

#[test]
fn every_light_is_in_the_list_of_its_cell() {
    let test = common::gpu();
    for top in [2, 5, 7] {
        for count in [0, 1, 63, 64, 65, 255, 256, 257, 9000] {
            let lights = uniform(count, 20 + count as u32);
            let verdict = check(&list(&test, &lights, top), &lights);
            verdict.unwrap_or_else(|e| panic!("{count} lights, Lmax {top}: {e}"));
        }
    }
}

#[test]
fn all_lights_may_share_a_cell() {
    let test = common::gpu();
    for count in [2, 3, 256, 257, 20_000] {
        let point = shaped(count, 21, |_| Vec3::new(1.0, -2.0, 3.0));
        // The other light spans the grid.
        let mut cluster = shaped(count, 21, |p| Vec3::splat(1.0) + 1e-3 * p);
        cluster.push([9.0; 3], 0, [1.0; 3], true);
        for (what, lights, used_cells) in [("one point", point, 1), ("a cluster", cluster, 2)] {
            let lists = list(&test, &lights, 5);
            check(&lists, &lights).unwrap_or_else(|e| panic!("{what} of {count} lights: {e}"));
            assert_eq!(by_cell(&lists.grid, &lights).len(), used_cells, "{what} of {count} lights");
        }
    }
}

#[test]
fn degenerate_sets_are_listed() {
    let test = common::gpu();
    for case in degenerate() {
        let verdict = check(&list(&test, &case.lights, 6), &case.lights);
        verdict.unwrap_or_else(|e| panic!("{}: {e}", case.name));
    }
}

#[test]
fn planted_faults_are_noticed() {
    let test = common::gpu();
    let lights = uniform(500, 22);
    let lists = list(&test, &lights, 3);
    check(&lists, &lights).unwrap();
    let second = lists.starts[1] as usize;
    assert!(second > 1 && lists.starts[2] as usize > second + 1, "the first lists are too short for the faults");
    let fails = |what: &str, plant: &dyn Fn(&mut Lists)| {
        let mut wrong = lists.clone();
        plant(&mut wrong);
        assert!(check(&wrong, &lights).is_err(), "{what} was not noticed");
    };
    fails("lost cells", &|lists| lists.cells.iter_mut().for_each(|word| *word &= word.wrapping_sub(1)));
    fails("a rank off by one", &|lists| lists.ranks[3] += 1);
    fails("a start off by one", &|lists| lists.starts[2] -= 1);
    fails("a light in another's list", &|lists| lists.listed.swap(0, second));
    fails("a light twice", &|lists| lists.listed[0] = lists.listed[1]);
    fails("a light in another's sorted list", &|lists| lists.sorted.swap(0, second));
    fails("a list that is not sorted", &|lists| lists.sorted.swap(0, 1));
}
