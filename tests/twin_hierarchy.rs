//! The hierarchy on the GPU against its CPU twins, stage by stage: each twin starts from what the GPU made before
//! it, so that a fault shows in its own stage.

mod common;

use common::compare::{self, Verdict};
use common::hierarchy::{Hierarchy, Options, Readback};
use common::light_sets::{Case, degenerate, uniform, wide_fluxes};
use glam::{DVec3, Vec3};
use gridlight::color::luminance;
use gridlight::cpu::count_lights::{LevelTable, count_lights};
use gridlight::cpu::deal_lights::deal_lights;
use gridlight::cpu::exclusive_scan::exclusive_scan;
use gridlight::cpu::gather_below::gather_below;
use gridlight::cpu::gather_vertex::gather_vertex;
use gridlight::cpu::lights::LightList;
use gridlight::cpu::list_vertices::list_vertices;
use gridlight::cpu::mark_grid_lights::mark_grid_lights;
use gridlight::cpu::mark_lights::mark_lights;
use gridlight::cpu::merge_lights::merge_lights;
use gridlight::cpu::place_grid::place_grid;
use gridlight::cpu::reduce_bounds::reduce_bounds;
use gridlight::cpu::resolve_moments::resolve_moments;
use gridlight::cpu::scatter_lights::scatter_lights;
use gridlight::light_grid::anchor::GridAnchor;
use gridlight::passes::lgh_shape::LghShape;
use gridlight::settings::{CenterWeight, LevelBuild};
use gridlight::shared::{GridLight, GridPlacement};

const CAPACITY: u32 = 20_000;
/// Negative fixed-point terms are stored to this part of the largest flux.
const RESOLUTION: f32 = gridlight::cpu::fixed_point::SMALLEST;

fn options(top: u32, build: LevelBuild) -> Options {
    Options {
        top,
        build,
        center: CenterWeight::Intensity,
        interleave: 1,
        first_level: 1,
        light_capacity: CAPACITY,
        grid_capacity: None,
    }
}

/// Placement: all but the reciprocal is exact; a division may be 2.5 ulp off.
fn compare_placement(gpu: &GridPlacement, twin: &GridPlacement) -> Verdict {
    let division = 3.0 * f32::EPSILON * twin.inverse_h_top;
    let near = (gpu.inverse_h_top - twin.inverse_h_top).abs() <= division;
    let same = GridPlacement { inverse_h_top: twin.inverse_h_top, ..*gpu } == *twin;
    if near && same { Ok(()) } else { Err(format!("placement: {gpu:?} on the GPU, {twin:?} in the twin")) }
}

/// Occupancy, ranks and level table, exactly; then the grid lights.
fn compare_with_twin(gpu: &Readback, lights: &LightList, build: LevelBuild, capacity: u32, radius: f32) -> Verdict {
    compare_placement(&gpu.grid.placement, &place_grid(&reduce_bounds(lights), lights.len() as u32, radius, None))?;
    let (grid, levels, top) = (&gpu.grid, gpu.grid.levels, gpu.grid.levels.top);
    let words = levels.total_words() as usize;
    let mut occupancy = vec![0; words + 1];
    let scattered = if build == LevelBuild::Scatter { top } else { 1 };
    mark_lights(&mut occupancy, grid, lights, 1..=scattered);
    if build != LevelBuild::Scatter {
        mark_grid_lights(&mut occupancy, grid, &gpu.lights[gpu.table.range(1)]);
    }
    compare::exact("occupancy", &gpu.occupancy, &occupancy)?;
    let ranges = if build == LevelBuild::Scatter { vec![1..=top] } else { vec![1..=1, 2..=top] };
    let mut ranks = vec![u32::MAX; words + 1];
    let mut table = LevelTable::default();
    let mut twin = vec![bytemuck::Zeroable::zeroed(); gpu.lights.len()];
    for range in ranges {
        let (first, end) = (levels.first_word(*range.start()) as usize, levels.end_word(*range.end()) as usize);
        ranks[first..=end].copy_from_slice(&exclusive_scan(&occupancy[first..end]));
        count_lights(&mut table, &ranks, levels, range.clone(), capacity);
        list_vertices(&mut twin, &occupancy, &ranks, &table, levels, range);
    }
    compare::exact("ranks", &gpu.ranks, &ranks)?;
    compare::exact("level table", &gpu.table.0, &table.0)?;
    let mut moments = vec![[0; 14]; twin.len()];
    for level in 1..=scattered {
        scatter_lights(&mut moments, lights, grid, &occupancy, &ranks, &table, level);
        resolve_moments(&mut twin, &moments, grid, &table, level);
    }
    if build == LevelBuild::Gather {
        // From the S1 of the GPU, so that its rounding does not count twice.
        let s1 = table.range(1);
        let computed = twin[s1.clone()].to_vec();
        twin[s1.clone()].copy_from_slice(&gpu.lights[s1.clone()]);
        (2..=top).for_each(|level| gather_vertex(&mut twin, grid, &occupancy, &ranks, &table, level));
        twin[s1].copy_from_slice(&computed);
    }
    if build == LevelBuild::Cascade {
        for level in 2..=top {
            let mut lights = gpu.lights.clone();
            gather_below(&mut lights, grid, &table, level);
            twin[table.range(level)].copy_from_slice(&lights[table.range(level)]);
        }
    }
    compare::grid_lights(&gpu.lights, &twin, grid, 0)?;
    compare_merged(gpu, lights)
}

fn compare_merged(gpu: &Readback, lights: &LightList) -> Verdict {
    let sub_images = deal_lights(&gpu.table, gpu.deal);
    // Entries of unused levels are never written.
    for (sub_image, entries) in sub_images.chunks_exact(gridlight::cpu::deal_lights::SUB_IMAGE_STRIDE).enumerate() {
        let used = gpu.deal.first_level as usize..=gpu.deal.top_level as usize + 1;
        let first = sub_image * entries.len();
        compare::exact("sub_images", &gpu.sub_images[first..][used.clone()], &entries[used])?;
    }
    let twin = merge_lights(&gpu.lights, lights, &gpu.table, &sub_images, gpu.deal);
    compare::grid_lights(&gpu.merged, &twin, &gpu.grid, 0)
}

fn check_invariants(gpu: &Readback, lights: &LightList) -> Verdict {
    compare::flux_is_kept(lights, &gpu.lights, &gpu.table, gpu.grid.levels.top, 1e-4)?;
    compare::none_is_empty_or_astray(&gpu.lights, &gpu.grid, RESOLUTION)
}

const BUILDS: [LevelBuild; 3] = [LevelBuild::Cascade, LevelBuild::Gather, LevelBuild::Scatter];

/// All builds, for agreement with the twin, the invariants, and agreement with each other.
fn check(hierarchies: &mut [(LevelBuild, Hierarchy)], case: &Case) -> Verdict {
    let mut s1 = Vec::new();
    for (build, hierarchy) in hierarchies {
        let capacity = hierarchy.grid_capacity();
        let gpu = hierarchy.run(&case.lights, case.scene_radius);
        let what = |e: String| format!("{}, {build:?}, Lmax {}: {e}", case.name, gpu.grid.levels.top);
        compare_with_twin(&gpu, &case.lights, *build, capacity, case.scene_radius).map_err(what)?;
        check_invariants(&gpu, &case.lights).map_err(what)?;
        s1.push(gpu.lights[gpu.table.range(1)].to_vec());
    }
    // The finest level is the same to the bit, summed by cell or by atomic additions: the sums are of integers.
    s1.windows(2).try_for_each(|pair| compare::exact(&format!("{}: S1 of two builds", case.name), &pair[0], &pair[1]))
}

fn check_all(top: u32, cases: &[Case]) {
    let test = common::gpu();
    let mut hierarchies = BUILDS.map(|b| (b, Hierarchy::new(&test.gpu, options(top, b))));
    let failures: Vec<String> = cases.iter().filter_map(|case| check(&mut hierarchies, case).err()).collect();
    assert!(failures.is_empty(), "{failures:#?}");
}

fn sizes() -> Vec<Case> {
    [20_000, 0, 1, 2, 255, 256, 257, 1000]
        .map(|n: usize| Case { name: "uniform", lights: uniform(n, n as u32), scene_radius: 5.0 })
        .into()
}

#[test]
fn sizes_with_two_levels() {
    check_all(2, &sizes());
}

#[test]
fn sizes_with_three_levels() {
    check_all(3, &sizes());
}

#[test]
fn sizes_with_five_levels() {
    check_all(5, &sizes());
}

#[test]
fn sizes_with_seven_levels() {
    check_all(7, &sizes());
}

#[test]
fn degenerate_sets_with_two_levels() {
    check_all(2, &degenerate());
}

#[test]
fn degenerate_sets_with_five_levels() {
    check_all(5, &degenerate());
}

#[test]
fn degenerate_sets_with_seven_levels() {
    check_all(7, &degenerate());
}

#[test]
fn fluxes_over_twelve_decades_match_the_twin() {
    let test = common::gpu();
    let case = wide_fluxes(6);
    for top in [2, 5, 7] {
        for build in BUILDS {
            let mut hierarchy = Hierarchy::new(&test.gpu, options(top, build));
            let gpu = hierarchy.run(&case.lights, case.scene_radius);
            let capacity = hierarchy.grid_capacity();
            compare_with_twin(&gpu, &case.lights, build, capacity, case.scene_radius).unwrap();
            compare::flux_is_kept(&case.lights, &gpu.lights, &gpu.table, top, 1e-4).unwrap();
        }
    }
}

#[test]
fn the_dimmest_lights_stay_within_a_cell() {
    let test = common::gpu();
    for top in [2, 5, 7] {
        let mut hierarchy = Hierarchy::new(&test.gpu, options(top, LevelBuild::Gather));
        let case = wide_fluxes(6);
        let gpu = hierarchy.run(&case.lights, case.scene_radius);
        compare::none_is_empty_or_astray(&gpu.lights, &gpu.grid, RESOLUTION).unwrap();
    }
}

#[test]
fn unweighted_centres_match_the_twin() {
    let test = common::gpu();
    let cases = [
        Case { name: "uniform", lights: uniform(1000, 14), scene_radius: 5.0 },
        Case { name: "fluxes from 1e-2 to 1e2", ..wide_fluxes(2) },
    ];
    for build in BUILDS {
        let mut hierarchy = Hierarchy::new(&test.gpu, Options { center: CenterWeight::Uniform, ..options(5, build) });
        let capacity = hierarchy.grid_capacity();
        for case in &cases {
            let mut gpu = hierarchy.run(&case.lights, case.scene_radius);
            let twin = |gpu: &Readback| compare_with_twin(gpu, &case.lights, build, capacity, case.scene_radius);
            twin(&gpu).unwrap_or_else(|e| panic!("{}, {build:?}: {e}", case.name));
            gpu.grid.center = CenterWeight::Intensity;
            assert!(twin(&gpu).is_err(), "{}, {build:?}: weighted centres are the same", case.name);
        }
    }
}

/// In cells of the level: a position keeps 24 bits of up to 64 cells, and the sums some 40 bits of the largest flux.
const CENTRE_TOLERANCE: f32 = 1e-4;

/// The centres of all grid lights by their formula: the mean position of the lights about a vertex, each by its
/// trilinear weight and, with [`CenterWeight::Intensity`], its luminance.
fn compare_centres(gpu: &Readback, lights: &LightList) -> Verdict {
    for level in 1..=gpu.grid.levels.top {
        let cells: Vec<Vec3> =
            (0..lights.len()).map(|light| gpu.grid.grid_position(lights.position(light), level)).collect();
        for light in &gpu.lights[gpu.table.range(level)] {
            let vertex = gpu.grid.vertex_from_index(light.vertex, level).as_dvec3();
            let (mut sum, mut total) = (DVec3::ZERO, 0.0);
            for (index, cells) in cells.iter().enumerate() {
                let offset = cells.as_dvec3() - vertex;
                let hat = (DVec3::ONE - offset.abs()).max(DVec3::ZERO).element_product();
                let counts = match gpu.grid.center {
                    CenterWeight::Intensity => hat * f64::from(luminance(lights.flux(index))),
                    CenterWeight::Uniform => hat,
                };
                sum += counts * offset;
                total += counts;
            }
            let h = gpu.grid.cell_size(level);
            let found = (Vec3::from(light.position_ws) - Vec3::from(gpu.grid.placement.origin_ws)) / h;
            let wanted = (vertex + sum / total).as_vec3();
            if !compare::near(found, wanted, CENTRE_TOLERANCE) {
                return Err(format!("level {level}: {light:?} lies at {found}, not {wanted}"));
            }
        }
    }
    Ok(())
}

#[test]
fn centres_are_weighted_means() {
    let test = common::gpu();
    let lights = uniform(700, 15);
    for (center, other) in
        [(CenterWeight::Intensity, CenterWeight::Uniform), (CenterWeight::Uniform, CenterWeight::Intensity)]
    {
        // Only scattering is the formula at every level; gathering goes by the centres below.
        let mut hierarchy = Hierarchy::new(&test.gpu, Options { center, ..options(5, LevelBuild::Scatter) });
        let mut gpu = hierarchy.run(&lights, 5.0);
        compare_centres(&gpu, &lights).unwrap_or_else(|e| panic!("{center:?}: {e}"));
        let mut moved = gpu.clone();
        moved.lights[17].position_ws[1] += 3.0 * CENTRE_TOLERANCE * gpu.grid.cell_size(1);
        assert!(compare_centres(&moved, &lights).is_err(), "a moved centre");
        gpu.grid.center = other;
        assert!(compare_centres(&gpu, &lights).is_err(), "{center:?} centres are {other:?} ones too");
    }
}

#[test]
fn a_vertex_holds_no_share_that_would_not_mark_it() {
    let test = common::gpu();
    let mut lights = LightList::default();
    // With cells of edge 1, the second light marks vertex (2, 2, 2), and of the third 1.2e-7 would fall to it.
    for position in [[0.0; 3], [2.0; 3], [1.0 + f32::EPSILON, 2.0, 2.0]] {
        lights.push(position, 0, [1.0; 3], false);
    }
    for build in BUILDS {
        let anchor = Some(GridAnchor { low_ws: [0.0; 3], edge: 4.0 });
        let shape = LghShape { anchor, ..common::hierarchy::shape(options(3, build)) };
        let gpu = Hierarchy::of_shape(&test.gpu, shape).run(&lights, 5.0);
        let s1: Vec<(u32, f32)> = gpu.lights[gpu.table.range(1)].iter().map(|l| (l.vertex, l.weight)).collect();
        assert_eq!(s1.iter().map(|(vertex, _)| *vertex).collect::<Vec<_>>(), [0, 61, 62], "{build:?}");
        assert_eq!(s1[2].1, 1.0, "{build:?}: {s1:?}");
    }
}

#[test]
fn lights_are_dealt_to_sub_images() {
    let test = common::gpu();
    for (interleave, first_level) in [(2, 1), (4, 1), (2, 0), (1, 0)] {
        let options = Options { interleave, first_level, light_capacity: 600, ..options(4, LevelBuild::Gather) };
        let mut hierarchy = Hierarchy::new(&test.gpu, options);
        for count in [600, 3, 0] {
            let lights = uniform(count, 11);
            let gpu = hierarchy.run(&lights, 5.0);
            let verdict = compare_with_twin(&gpu, &lights, LevelBuild::Gather, hierarchy.grid_capacity(), 5.0);
            verdict.unwrap_or_else(|e| panic!("interleave {interleave}, first level {first_level}, {count}: {e}"));
        }
    }
}

#[test]
fn lights_past_the_capacity_are_counted_not_written() {
    let test = common::gpu();
    let lights = uniform(300, 12);
    for build in BUILDS {
        let options = Options { light_capacity: 300, grid_capacity: Some(400), ..options(5, build) };
        let gpu = Hierarchy::new(&test.gpu, options).run(&lights, 5.0);
        assert!(gpu.table.overflow() > 0);
        assert_eq!(gpu.lights.len(), 400);
        compare_with_twin(&gpu, &lights, build, 400, 5.0).unwrap();
    }
}

#[test]
fn planted_faults_are_noticed() {
    let test = common::gpu();
    let lights = uniform(257, 13);
    let mut hierarchy = Hierarchy::new(&test.gpu, Options { light_capacity: 257, ..options(3, LevelBuild::Gather) });
    let capacity = hierarchy.grid_capacity();
    let mut fails = |what: &str, plant: &dyn Fn(&mut Readback), check: &dyn Fn(&Readback) -> Verdict| {
        let mut gpu = hierarchy.run(&lights, 5.0);
        check(&gpu).unwrap_or_else(|e| panic!("{what}, before the fault: {e}"));
        plant(&mut gpu);
        assert!(check(&gpu).is_err(), "{what}: not noticed");
    };
    let twin = |gpu: &Readback| compare_with_twin(gpu, &lights, LevelBuild::Gather, capacity, 5.0);
    fails("an occupancy bit", &|gpu| gpu.occupancy[3] ^= 1, &twin);
    fails("a rank off by one", &|gpu| gpu.ranks[7] += 1, &twin);
    fails("a count off by one", &|gpu| gpu.table.0[5] -= 1, &twin);
    fails("the overflow off by one", &|gpu| gpu.table.0[24] += 1, &twin);
    fails("a weight 1.01 times", &|gpu| gpu.lights[40].weight *= 1.01, &twin);
    fails("a flux 1.001 times", &|gpu| gpu.lights[40].flux[1] *= 1.001, &twin);
    fails("swapped moments", &|gpu| gpu.lights[9].lobe.swap(0, 1), &twin);
    fails("a swapped variance", &|gpu| gpu.lights[9].variance.swap(0, 2), &twin);
    fails("a moved centre", &|gpu| gpu.lights[9].position_ws[2] += 1e-3, &twin);
    fails("swapped merged lights", &|gpu| gpu.merged.swap(3, 4), &twin);
    fails("a sub-image off by one", &|gpu| gpu.sub_images[2] += 1, &twin);
    fails("the placement", &|gpu| gpu.grid.placement.h_top *= 1.001, &twin);
    let invariants = |gpu: &Readback| check_invariants(gpu, &lights);
    let brightest = |gpu: &Readback| {
        let brighter = |a: &usize, b: &usize| gpu.lights[*a].flux[0].total_cmp(&gpu.lights[*b].flux[0]);
        gpu.table.range(2).max_by(brighter).unwrap()
    };
    let dim = |gpu: &mut Readback| {
        let light = brightest(gpu);
        gpu.lights[light].flux = gpu.lights[light].flux.map(|f| f * 0.99);
    };
    fails("a lost hundredth of a light", &dim, &invariants);
    fails("an empty light", &|gpu| gpu.lights[5].weight = 0.0, &invariants);
    fails("a light astray", &|gpu| gpu.lights[5].position_ws[0] += 9.0, &invariants);
    fails("not a number", &|gpu| gpu.lights[5].luminance = f32::NAN, &invariants);
}

#[test]
fn lights_of_both_comparators_must_be_as_many() {
    let light: GridLight = bytemuck::Zeroable::zeroed();
    let grid = gridlight::cpu::grid::Grid {
        placement: bytemuck::Zeroable::zeroed(),
        levels: gridlight::light_grid::Levels::new(2),
        center: CenterWeight::Intensity,
    };
    assert!(compare::grid_lights(&[light], &[], &grid, 0).is_err());
    assert!(compare::exact("words", &[1, 2], &[1]).is_err());
}
