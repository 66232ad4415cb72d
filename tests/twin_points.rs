//! From the cut of primary points to the light of all points that are seen: every pass against its twin, over trees of which
//! many nodes oppose their parents, with random pictures, bits and light.

mod common;

use ash::vk;
use bytemuck::Zeroable;
use clap::ValueEnum;
use common::compare::{self, Verdict};
use common::hierarchy::frame_shape;
use common::light_sets::Random;
use glam::{Vec2, Vec3};
use gridlight::camera::{Camera, View};
use gridlight::cpu::average_children::average_children;
use gridlight::cpu::copy_down::copy_down;
use gridlight::cpu::fill_up::fill_up;
use gridlight::cpu::gather_up::{Gathered, gather_up};
use gridlight::cpu::mark_passing::{Decision, mark_passing};
use gridlight::cpu::mark_primaries::{DepthView, mark_primaries};
use gridlight::cpu::pack_keys::pack_keys;
use gridlight::cpu::point_sides::{PointSides, has_bit};
use gridlight::cpu::spread_down::{borrow_down, spread_down};
use gridlight::gpu::Executor;
use gridlight::graph::{BufferHandle, ImageInfo};
use gridlight::passes::point_cut::Hidden;
use gridlight::passes::point_propagation::Propagation;
use gridlight::passes::points::Points;
use gridlight::passes::{Frame, point_cut, point_propagation, point_selection};
use gridlight::points::PointCloud;
use gridlight::scene::testing::box_room;
use gridlight::settings::Selection;
use gridlight::shared::{FrameData, POINT_DISPATCHES, POINT_IS_TURNED, POINT_LIST_NEEDED, PointCounts};

/// Edges of the picture.
const SIZE_PX: [u32; 2] = [48, 27];
/// Decisions closer than this may be rounded either way.
const CLOSE: f32 = 1e-5;

/// What a run is given.
struct Given {
    cloud: PointCloud,
    data: FrameData,
    depth: Vec<f32>,
    seen: Vec<u32>,
    irradiance: Vec<f32>,
    capacity: u32,
    selection: Selection,
}

/// What it leaves.
#[derive(Clone)]
struct Left {
    passing: Vec<u32>,
    /// Primary points, also those that have no room.
    marked: Vec<u32>,
    primary: Vec<u32>,
    primaries: Vec<u32>,
    under: Vec<u32>,
    borrowed: Vec<u32>,
    known: Vec<u32>,
    derived: Vec<u32>,
    needed: Vec<u32>,
    lending: Vec<u32>,
    averaged: Vec<u32>,
    needed_list: Vec<u32>,
    counts: PointCounts,
    dispatches: Vec<u32>,
    irradiance: Vec<f32>,
}

fn camera_data(leaf_count: u32, leaf_radius: f32) -> FrameData {
    let camera = Camera {
        name: String::new(),
        position_ws: Vec3::new(0.3, 0.2, 0.9),
        right_ws: Vec3::X,
        up_ws: Vec3::Y,
        forward_ws: Vec3::NEG_Z,
        yfov_rad: 1.2,
        near: 0.05,
        set_back: 0.0,
    };
    let view = View::new(&camera, SIZE_PX[0], SIZE_PX[1], Vec2::ZERO);
    FrameData {
        clip_from_world: view.clip_from_world.to_cols_array_2d(),
        eye_ws: view.eye_ws.to_array(),
        near: view.near,
        forward_ws: view.forward_ws.to_array(),
        right_ws: view.right_ws.to_array(),
        up_ws: view.up_ws.to_array(),
        size_px: SIZE_PX,
        point_leaf_count: leaf_count,
        point_leaf_radius: leaf_radius,
        primary_radius_px: 3.0,
        primary_cone_cos: 0.866,
        ..FrameData::zeroed()
    }
}

impl Given {
    fn new(leaf_count_log2: u32, seed: u32) -> Self {
        let mut random = Random::new(seed);
        let mut scene = box_room(2.0, Vec3::new(0.8, 0.0, 0.2));
        // The walls have two sides, so that no node is solid; one of them stays as it is.
        let back: Vec<u32> = scene.indices[6..].chunks_exact(3).flat_map(|t| [t[0], t[2], t[1]]).collect();
        scene.triangle_materials.extend(vec![0; back.len() / 3]);
        scene.indices.extend(back);
        let mut cloud = PointCloud::of_scene(&scene, leaf_count_log2).unwrap();
        for node in &mut cloud.nodes[2..] {
            let is_turned = random.bits().is_multiple_of(3);
            node.leaf_and_flags = node.leaf_and_flags & !POINT_IS_TURNED | if is_turned { POINT_IS_TURNED } else { 0 };
        }
        let data = camera_data(cloud.leaf_count(), cloud.leaf_radius);
        let words = 4 * cloud.leaf_count() / 32;
        let keys = 4 * cloud.leaf_count();
        let depth = (0..SIZE_PX[0] * SIZE_PX[1]).map(|i| {
            // A twentieth of the pixels see nothing.
            if i % 20 == 7 { 0.0 } else { data.near / (0.5 + 2.0 * random.unit()) }
        });
        Self {
            depth: depth.collect(),
            seen: (0..words).map(|word| random.bits() & random.bits() & if word == 0 { !3 } else { !0 }).collect(),
            irradiance: (0..3 * keys).map(|_| random.unit()).collect(),
            data,
            cloud,
            capacity: keys,
            selection: Selection::Levels,
        }
    }

    fn sides(&self) -> PointSides {
        PointSides { leaf_count: self.cloud.leaf_count(), turned_bits: self.cloud.turned_bits() }
    }

    /// Runs the passes.
    fn run(&self) -> Left {
        let keys = 4 * self.cloud.leaf_count();
        // What has no room leaves the sets: what was found before that is what a run with room for all leaves.
        let all = (self.capacity < keys).then(|| self.run_with(keys));
        let left = self.run_with(self.capacity);
        Left { marked: all.map_or_else(|| left.primary.clone(), |all| all.primary), ..left }
    }

    fn run_with(&self, capacity: u32) -> Left {
        let test = common::gpu();
        let mut frame = Frame::without_scene(frame_shape());
        let points = Points::declare(&mut frame, &self.cloud);
        let info = ImageInfo::new(vk::Format::R32_SFLOAT, SIZE_PX[0], SIZE_PX[1]);
        let depth = frame.graph.filled_image("depth", info, bytemuck::cast_slice(&self.depth).into());
        let seen = frame.graph.filled_buffer("seen_bits", bytemuck::cast_slice(&self.seen).into());
        let irradiance = bytemuck::cast_slice(&self.irradiance).into();
        let irradiance = frame.graph.filled_buffer("point_irradiance", irradiance);
        let cut = point_cut::add(&mut frame, depth, &points, capacity, Hidden::Kept);
        let selection = point_selection::add(&mut frame, &points, &cut, seen, self.selection);
        let list = POINT_LIST_NEEDED;
        let needed_list = point_cut::pack_keys(&mut frame, &points, selection.needed, list, capacity, &cut.counts);
        let filled = point_selection::fill_up(&mut frame, &points, &cut, &selection);
        let sides = Propagation { cut: &cut, selection: &selection, seen, lending: None };
        point_propagation::add(&mut frame, &points, &sides, irradiance, "");
        let mut executor = Executor::new(&test.gpu, frame.graph, None).unwrap();
        let ticket = executor.submit(bytemuck::bytes_of(&self.data)).unwrap();
        executor.wait(ticket).unwrap();
        let read = |buffer: BufferHandle| executor.read_buffer(buffer).unwrap();
        let words = |buffer: BufferHandle| bytemuck::pod_collect_to_vec::<u8, u32>(&read(buffer));
        let counts: PointCounts = bytemuck::pod_read_unaligned(&read(cut.counts.counts));
        let list = |buffer: BufferHandle, count: u32| words(buffer)[..count as usize].to_vec();
        Left {
            passing: words(cut.passing),
            marked: Vec::new(),
            primary: words(cut.bits),
            primaries: list(cut.primaries.keys, counts.primary_count),
            under: words(selection.under),
            borrowed: words(selection.borrowed),
            known: words(selection.known),
            derived: words(selection.derived),
            needed: words(selection.needed),
            lending: words(filled.lending),
            averaged: words(filled.averaged),
            needed_list: list(needed_list.keys, counts.needed_count),
            counts,
            dispatches: words(cut.counts.dispatches),
            irradiance: bytemuck::pod_collect_to_vec(&read(irradiance)),
        }
    }
}

/// Bits against decisions that are not close.
fn decided(what: &str, bits: &[u32], decisions: impl IntoIterator<Item = (u32, Decision)>) -> Verdict {
    let clear = decisions.into_iter().filter(|(_, decision)| decision.margin > CLOSE);
    match clear.into_iter().find(|(index, decision)| has_bit(bits, *index) != decision.holds) {
        Some((index, decision)) => Err(format!("{what}: bit {index} is not {decision:?}")),
        None => Ok(()),
    }
}

/// The primary points that were marked, of the nodes that pass.
fn compare_primaries(given: &Given, left: &Left) -> Verdict {
    let view = DepthView { data: &given.data, depth: &given.depth };
    let twin = mark_primaries(&given.cloud, &left.passing, &view);
    decided("primary points", &left.marked, twin.iter().copied())?;
    let is_wrong = |key: &u32| {
        let of_node = twin.iter().find(|(other, _)| other / 2 == key / 2);
        !of_node.is_some_and(|(other, decision)| other == key || decision.margin <= CLOSE)
    };
    match left.primaries.iter().find(|key| is_wrong(key)) {
        Some(key) => Err(format!("key {key} is no primary point")),
        None => Ok(()),
    }
}

/// Everything that was left against the twins, each of which is given what the pass was given.
fn compare_all(given: &Given, left: &Left) -> Verdict {
    let (sides, capacity) = (given.sides(), given.capacity as usize);
    let passing = (0..).zip(mark_passing(&given.cloud, &given.data));
    decided("passing nodes", &left.passing, passing)?;
    compare_primaries(given, left)?;
    let (primaries, primaries_lost, kept) = pack_keys(&left.marked, capacity);
    compare::exact("primary points with room", &left.primary, &kept)?;
    compare::exact("primaries", &left.primaries, &primaries)?;
    compare::exact("under", &left.under, &spread_down(&sides, &left.primary))?;
    let borrowed = match given.selection {
        Selection::Borrow => borrow_down(&sides, &left.under, &given.seen),
        _ => sides.none(),
    };
    compare::exact("borrowed", &left.borrowed, &borrowed)?;
    let gathered = gather_up(
        &sides,
        [&left.under, &left.borrowed],
        &given.seen,
        [given.selection != Selection::Paper, given.selection == Selection::Borrow],
    );
    compare::exact("known", &left.known, &gathered.known)?;
    compare::exact("derived", &left.derived, &gathered.derived)?;
    let (needed, needed_lost, kept) = pack_keys(&gathered.needed, capacity);
    compare::exact("needed", &left.needed, &kept)?;
    compare::exact("list of needed", &left.needed_list, &needed)?;
    let lit = Gathered { needed: kept, ..gathered };
    let filled = fill_up(&sides, &left.primary, [&left.under, &left.borrowed], &lit);
    compare::exact("lending", &left.lending, &filled.lending)?;
    compare::exact("averaged", &left.averaged, &filled.averaged)?;
    let counts = PointCounts {
        primary_count: primaries.len() as u32,
        primaries_lost: primaries_lost as u32,
        needed_count: needed.len() as u32,
        needed_lost: needed_lost as u32,
        seen_count: given.seen.iter().map(|word| word.count_ones()).sum(),
        primaries_kept: 0,
        needed_kept: 0,
    };
    compare::exact("counts", &[left.counts], &[counts])?;
    let groups = |count: u32| [count, count.div_ceil(256), count.div_ceil(4)].map(|x| [x.max(1), x.min(1), 1]);
    let dispatches = [counts.primary_count, counts.needed_count].map(groups);
    compare::exact("dispatches", &left.dispatches, dispatches.as_flattened().as_flattened())?;
    compare_irradiance(given, &sides, left)
}

fn compare_irradiance(given: &Given, sides: &PointSides, left: &Left) -> Verdict {
    let vectors = |numbers: &[f32]| numbers.chunks_exact(3).map(Vec3::from_slice).collect::<Vec<_>>();
    let mut expected = vectors(&given.irradiance);
    average_children(&given.cloud, sides, [&left.derived, &left.known], &mut expected);
    copy_down(sides, &left.primary, [&left.under, &left.borrowed], &given.seen, &mut expected);
    let found = vectors(&left.irradiance);
    match sides.keys().find(|key| !compare::near(found[*key as usize], expected[*key as usize], 1e-5)) {
        Some(key) => {
            Err(format!("irradiance of {key}: {}, {} in the twin", found[key as usize], expected[key as usize]))
        }
        None => Ok(()),
    }
}

#[test]
fn every_pass_is_as_its_twin() {
    for (leaf_count_log2, seed) in [(12, 1), (9, 2), (5, 3), (4, 4)] {
        for selection in Selection::value_variants() {
            let given = Given { selection: *selection, ..Given::new(leaf_count_log2, seed) };
            let left = given.run();
            compare_all(&given, &left).unwrap_or_else(|e| panic!("2^{leaf_count_log2} leaves, {selection:?}: {e}"));
            let passing = left.passing.iter().any(|word| *word != 0);
            // With few leaves none is small enough, and the cut is all of them.
            assert!(left.counts.primary_count > 0 && passing == (leaf_count_log2 >= 9), "{:?}", left.counts);
        }
    }
}

#[test]
fn arrivals_find_the_same_every_time() {
    // Many threads race for the counters here; whoever comes second, the bits are the same.
    let given = Given { selection: Selection::Arrival, ..Given::new(14, 7) };
    for _ in 0..4 {
        compare_all(&given, &given.run()).unwrap();
    }
}

#[test]
fn keys_beyond_the_capacity_are_counted() {
    let given = Given { capacity: 5, ..Given::new(8, 5) };
    let left = given.run();
    compare_all(&given, &left).unwrap();
    assert!(left.primaries.len() == 5 && left.counts.primaries_lost > 0 && left.counts.needed_lost > 0);
}

#[test]
fn planted_faults_are_noticed() {
    let given = Given::new(9, 6);
    let left = given.run();
    compare_all(&given, &left).unwrap();
    let faults: [fn(&mut Left); 14] = [
        |left| left.passing[20] ^= 1 << 20,
        |left| left.marked[left.primaries[3] as usize / 32] ^= 1 << (left.primaries[3] % 32),
        |left| left.primary[9] ^= 1,
        |left| left.primaries.swap(1, 2),
        |left| left.under[9] ^= 1,
        |left| left.known[3] ^= 4,
        |left| left.derived[3] ^= 8,
        |left| left.needed[40] ^= 2,
        |left| left.lending[0] ^= 1 << 9,
        |left| left.averaged[40] ^= 2,
        |left| left.needed_list.truncate(1),
        |left| left.counts.seen_count += 1,
        |left| left.dispatches[(3 * POINT_DISPATCHES * POINT_LIST_NEEDED) as usize] += 1,
        |left| left.irradiance[100] = f32::NAN,
    ];
    for (index, fault) in faults.into_iter().enumerate() {
        let mut wrong = left.clone();
        fault(&mut wrong);
        assert!(compare_all(&given, &wrong).is_err(), "fault {index}");
    }
}
