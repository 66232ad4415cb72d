//! The finest grid updated by the lights that have changed, against the one that is built anew: the same to the bit.

mod common;
mod support;

use common::compare::{Verdict, exact};
use common::gpu;
use common::hierarchy::{Hierarchy, Options, Readback, shape};
use common::light_sets::Random;
use common::rooms::courtyard;
use gridlight::cpu::grid_update::{SlotLights, apply_changes, find_changes, move_moments};
use gridlight::cpu::lights::LightList;
use gridlight::cpu::scatter_lights::{Moments, Records, Sign, add_light, scatter_lights};
use gridlight::files::pictures::read_exr;
use gridlight::light_grid::anchor::GridAnchor;
use gridlight::passes::grid_update::LIGHTS_PER_CHANGE;
use gridlight::passes::lgh_shape::LghShape;
use gridlight::renderer::{Fresh, Job, Renderer, UploadedScene};
use gridlight::settings::{CenterWeight, GridUpdate, LevelBuild, Settings, Size, VplSeeds};
use support::{program, run, succeed};

const SLOTS: usize = 1000;
const RADIUS: f32 = 5.0;
/// The grids' cube. With this top level a vertex of S1 has one light on average: some lose their last one, some get their first.
const EDGE: f32 = 4.0;
const TOP: u32 = 5;

/// Position, normal, flux, and whether the light shines in all directions.
type Given = ([f32; 3], u32, [f32; 3], bool);

/// A light in the cube. One in four lies so near the vertices at x = 0 that its share of those beside them is about 1e-7, where it
/// shares nothing, or 2e-6, where it does.
fn light(random: &mut Random) -> Given {
    let mut place = EDGE * random.point();
    if random.unit() < 0.25 {
        let cell = EDGE / f32::from(1_u16 << (TOP - 1));
        place.x = cell * if random.unit() < 0.5 { 1e-7 } else { 8e-6 };
    }
    (place.to_array(), random.bits(), (0.1 + 0.8 * random.point()).to_array(), random.unit() < 0.125)
}

/// Slots of which each has a light of its own.
struct Slots(Vec<Option<Given>>);

impl Slots {
    /// Two in three have a light; the first one stays the brightest.
    fn new(random: &mut Random) -> Self {
        let mut slots: Vec<_> = (0..SLOTS).map(|_| (random.unit() < 0.667).then(|| light(random))).collect();
        slots[0] = Some(([1.0, 2.0, 3.0], 0, [0.95; 3], false));
        Self(slots)
    }

    /// Adds, removes or replaces the light of a slot.
    fn change(&mut self, random: &mut Random) {
        let slot = 1 + random.bits() as usize % (SLOTS - 1);
        let becomes_dark = self.0[slot].is_some() && random.unit() < 0.5;
        self.0[slot] = (!becomes_dark).then(|| light(random));
    }

    fn lights(&self) -> SlotLights {
        let mut all = SlotLights::default();
        for slot in &self.0 {
            all.slots.push(slot.map(|_| all.lights.len()));
            if let Some((place, normal, flux, isotropic)) = slot {
                all.lights.push(*place, *normal, *flux, *isotropic);
            }
        }
        all
    }
}

fn hierarchy(test: &common::GpuTest, mode: GridUpdate, change: impl FnOnce(&mut LghShape)) -> Hierarchy {
    let options = Options {
        top: TOP,
        build: LevelBuild::Cascade,
        center: CenterWeight::Intensity,
        interleave: 1,
        first_level: 1,
        light_capacity: SLOTS as u32,
        grid_capacity: None,
    };
    let anchor = Some(GridAnchor { low_ws: [0.0; 3], edge: EDGE });
    let mut shape = LghShape { grid_update: mode, anchor, ..shape(options) };
    change(&mut shape);
    Hierarchy::of_shape(&test.gpu, shape)
}

fn same(a: &Readback, b: &Readback) -> Verdict {
    exact("occupancy", &a.occupancy, &b.occupancy)?;
    exact("level table", &a.table.0, &b.table.0)?;
    exact("grid lights", &a.lights, &b.lights)?;
    exact("merged lights", &a.merged, &b.merged)
}

/// Rounds of a test, and changes in each: a thousand in all.
const ROUNDS: usize = 20;
const CHANGES: usize = 50;

#[test]
fn a_thousand_changes_are_a_new_build_to_the_bit() {
    let test = gpu();
    for center in [CenterWeight::Intensity, CenterWeight::Uniform] {
        let of = |mode| hierarchy(&test, mode, |shape| shape.center = center);
        let [mut anew, mut updated, mut checked] = [GridUpdate::Full, GridUpdate::Auto, GridUpdate::Check].map(of);
        let mut random = Random::new(5);
        let mut slots = Slots::new(&mut random);
        let mut before = SlotLights::default();
        for round in 0..ROUNDS {
            let now = slots.lights();
            let expected = anew.run(&now.lights, RADIUS);
            same(&updated.run_slots(&now, RADIUS), &expected).unwrap_or_else(|e| panic!("round {round}: {e}"));
            same(&checked.run_slots(&now, RADIUS), &expected).unwrap_or_else(|e| panic!("round {round}: {e}"));
            exact("sums", &updated.kept_moments(), &checked.kept_moments()).unwrap();
            let changed = if round == 0 { 0 } else { find_changes(&before, &now).len() as u32 };
            assert!(round == 0 || changed > CHANGES as u32 / 2, "round {round}: {changed} changes");
            for counts in [updated.update_counts(), checked.update_counts()] {
                assert_eq!(counts[1..], [changed, 0], "round {round}");
            }
            before = now;
            (0..CHANGES).for_each(|_| slots.change(&mut random));
        }
    }
}

#[test]
fn a_light_that_is_subtracted_twice_is_found() {
    let test = gpu();
    let mut checked = hierarchy(&test, GridUpdate::Check, |_| ());
    let mut slots = Slots::new(&mut Random::new(6));
    let now = slots.lights();
    let built = checked.run_slots(&now, RADIUS);
    let kept = checked.kept_moments();
    let mut wrong = kept.clone();
    add_light(&mut wrong, &now.lights, 1, &built.grid, &records(&built), 1, Sign::Minus);
    assert_ne!(wrong, kept);
    let slot = now.slots.iter().position(|light| *light == Some(1)).unwrap();
    checked.keep_moments(&wrong);
    slots.0[slot] = None;
    checked.run_slots(&slots.lights(), RADIUS);
    let [changed, applied, differing] = checked.update_counts();
    assert_eq!([changed, applied], [1, 1]);
    // Two words for each of the sums of each vertex that other lights hold, less those that stay the same.
    assert!(differing > 10, "{differing} words differ");
    // What is kept is right again, and what was found is not forgotten.
    checked.run_slots(&slots.lights(), RADIUS);
    assert_eq!(checked.update_counts(), [0, 0, differing]);
}

#[test]
fn what_does_not_pay_or_cannot_go_on_is_built_anew() {
    let test = gpu();
    let mut random = Random::new(7);
    let mut slots = Slots::new(&mut random);
    let mut anew = hierarchy(&test, GridUpdate::Full, |_| ());
    let mut updated = hierarchy(&test, GridUpdate::Auto, |_| ());
    let mut applied = |slots: &Slots| {
        let now = slots.lights();
        same(&updated.run_slots(&now, RADIUS), &anew.run(&now.lights, RADIUS)).unwrap();
        updated.update_counts()
    };
    applied(&slots);
    // As many as pay, and one more.
    let limit = slots.lights().lights.len() as u32 / LIGHTS_PER_CHANGE;
    for (count, expected) in [(limit, [limit, limit]), (limit + 1, [limit + 1, 0])] {
        let taken = slots.0.iter_mut().filter(|slot| slot.is_some()).skip(1).take(count as usize);
        taken.for_each(|slot| *slot = Some(light(&mut random)));
        assert_eq!(applied(&slots)[..2], expected);
    }
    // Another unit of flux.
    slots.0[0] = Some(([1.0, 2.0, 3.0], 0, [3.0; 3], false));
    assert_eq!(applied(&slots)[..2], [1, 0]);
    assert_eq!(applied(&slots)[..2], [0, 0]);
    slots.change(&mut random);
    assert_eq!(applied(&slots)[..2], [1, 1]);
    // Another place: a light outside the cube, which is doubled.
    slots.0[5] = Some(([1.0, 2.0, 1.1 * EDGE], 0, [0.5; 3], false));
    assert_eq!(applied(&slots)[..2], [1, 0]);
    // No lights at all, and some again.
    let all = std::mem::replace(&mut slots, Slots(vec![None; SLOTS]));
    assert_eq!(applied(&slots)[1], 0);
    assert_eq!(applied(&all)[1], 0);
}

#[test]
fn a_build_that_lost_vertices_is_not_gone_on_from() {
    let test = gpu();
    let room = |shape: &mut LghShape| shape.grid_capacity = 1000;
    let [mut anew, mut updated] = [GridUpdate::Full, GridUpdate::Auto].map(|mode| hierarchy(&test, mode, room));
    let mut random = Random::new(8);
    let mut slots = Slots::new(&mut random);
    for round in 0..3 {
        let now = slots.lights();
        let built = updated.run_slots(&now, RADIUS);
        assert!(built.table.overflow() > 0);
        same(&built, &anew.run(&now.lights, RADIUS)).unwrap_or_else(|e| panic!("round {round}: {e}"));
        assert_eq!(updated.update_counts()[1], 0, "round {round}");
        slots.change(&mut random);
    }
}

fn records(built: &Readback) -> Records<'_> {
    Records { occupancy: &built.occupancy, ranks: &built.ranks, table: &built.table }
}

/// Sums of S1 from nothing, by the twin.
fn built_anew(lights: &LightList, built: &Readback) -> Vec<Moments> {
    let mut moments = vec![[0; 14]; built.table.count(1)];
    scatter_lights(&mut moments, lights, &built.grid, &built.occupancy, &built.ranks, &built.table, 1);
    moments
}

#[test]
fn the_twin_goes_on_to_the_bit_and_down_to_nothing() {
    let test = gpu();
    let mut anew = hierarchy(&test, GridUpdate::Full, |_| ());
    let mut random = Random::new(9);
    let mut slots = Slots::new(&mut random);
    let before = slots.lights();
    let first = anew.run(&before.lights, RADIUS);
    let kept = built_anew(&before.lights, &first);
    (0..100).for_each(|_| slots.change(&mut random));
    let now = slots.lights();
    let second = anew.run(&now.lights, RADIUS);
    let (old, new) = (records(&first), records(&second));
    let vertices: Vec<u32> = second.lights[second.table.range(1)].iter().map(|light| light.vertex).collect();
    let changes = find_changes(&before, &now);
    let go_on = |twice: bool| {
        let mut moments = move_moments(&kept, &old, &vertices, &second.grid);
        let removed = changes.iter().find(|[before, now]| before.is_some() && now.is_none()).unwrap();
        let again = if twice { vec![*removed] } else { Vec::new() };
        let all = [changes.clone(), again].concat();
        apply_changes(&mut moments, &all, [&before.lights, &now.lights], &second.grid, &new);
        moments
    };
    assert_eq!(go_on(false), built_anew(&now.lights, &second));
    assert_ne!(go_on(true), built_anew(&now.lights, &second), "a light subtracted twice");
    // All are removed, at the vertices that they had.
    let vertices: Vec<u32> = first.lights[first.table.range(1)].iter().map(|light| light.vertex).collect();
    let mut moments = move_moments(&kept, &old, &vertices, &first.grid);
    let nothing = SlotLights { slots: vec![None; SLOTS], lights: LightList::default() };
    let changes = find_changes(&before, &nothing);
    assert_eq!(changes.len(), before.lights.len());
    apply_changes(&mut moments, &changes, [&before.lights, &nothing.lights], &first.grid, &old);
    assert!(moments.iter().all(|sums| *sums == [0; 14]));
}

fn settings(mode: GridUpdate) -> Settings {
    Settings::default().changed(|s| {
        s.picture.size = Size { width: 48, height: 27 };
        (s.many_lights.vpls, s.many_lights.vpl_seeds) = (2000, Some(VplSeeds::Rolling));
        s.lgh.grid_update = mode;
    })
}

fn counts(renderer: &Renderer) -> Vec<u32> {
    renderer.read_counters().unwrap()[2].clone()
}

#[test]
fn frames_that_renew_some_paths_are_the_same() {
    let test = gpu();
    let scene = courtyard();
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    let renderer = |mode| Renderer::new(&Job::new(&test.gpu, &uploaded, &scene.cameras[0], &settings(mode))).unwrap();
    let [mut anew, mut checked] = [GridUpdate::Full, GridUpdate::Check].map(renderer);
    let mut updates = 0;
    for number in 0..5 {
        let pictures = [&mut anew, &mut checked].map(|renderer| {
            renderer.set_accumulated_frame(number, Fresh::SomePaths);
            let ticket = renderer.submit().unwrap();
            renderer.wait(ticket).unwrap();
            renderer.read_radiance().unwrap().into_iter().map(f32::to_bits).collect::<Vec<_>>()
        });
        assert!(pictures[0] == pictures[1], "frame {number} is another picture");
        updates += u32::from(counts(&checked)[1] > 0);
    }
    assert_eq!(updates, 4, "all but the first frame go on");
    // What the check finds ends the run.
    let kept = checked.executor().graph().buffer_named("kept_moments").unwrap();
    checked.executor().write_buffer(kept, &[0xff; 1024]).unwrap();
    checked.set_accumulated_frame(5, Fresh::SomePaths);
    let ticket = checked.submit().unwrap();
    let error = checked.wait(ticket).unwrap_err();
    assert!(error.to_string().starts_with("--grid-update check: the finest grid updated by"), "{error}");
    assert_eq!(error.exit_code(), 1);
}

/// Frames of a window use again what nothing has changed of, and may be abandoned at any pass.
#[test]
fn frames_of_a_window_go_on_from_whole_ones_alone() {
    let test = gpu();
    let scene = courtyard();
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    let settings = settings(GridUpdate::Check);
    let job = Job::new(&test.gpu, &uploaded, &scene.cameras[0], &settings);
    let mut renderer = Renderer::for_window(&job, false, None).unwrap();
    let mut number = 0;
    let mut run = |renderer: &mut Renderer, pieces: u32, advances: bool| {
        number += u32::from(advances);
        renderer.set_accumulated_frame(number, Fresh::SomePaths);
        let mut frame = renderer.begin_paced(0).unwrap();
        while frame.submissions() < pieces {
            let flow = std::ops::ControlFlow::Continue(());
            if let Some(done) = renderer.advance(&mut frame, 1e-9, flow).unwrap() {
                let feedback = renderer.feedback(&done.times).unwrap();
                assert_eq!(feedback.complaint, None, "frame {number}");
                return done.times.submissions;
            }
        }
        renderer.abandon(frame).unwrap();
        pieces
    };
    let all = run(&mut renderer, u32::MAX, true);
    let (mut updates, mut frames) = (0, 0);
    for pieces in (1..all).step_by(all as usize / 12) {
        run(&mut renderer, pieces, true);
        // The same frame as a whole, and once more, where nothing has changed.
        run(&mut renderer, u32::MAX, false);
        run(&mut renderer, u32::MAX, false);
        assert_eq!(counts(&renderer)[2], 0, "after {pieces} of {all} pieces");
        updates += u32::from(counts(&renderer)[1] > 0);
        frames += 1;
    }
    // Those that were abandoned once all was kept have left nothing to do.
    assert!(updates >= frames / 4 && updates < frames, "{updates} of {frames} frames went on");
}

/// Pictures of the built-in scene in motion, and how many changed lights the last one was updated by.
fn sequence(folder: &std::path::Path, animation: &str, mode: &str) -> (Vec<Vec<f32>>, u64) {
    let path = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let (picture, timings) = (path(&format!("{mode}-{{frame}}.exr")), path(&format!("{mode}.json")));
    let options = format!(
        "--headless --quiet --validation --size 48x27 --vpls 3000 --time 1.2 --fps 24 --frames 3 --animation {animation} \
         --grid-update {mode} --output {picture} --timings {timings}"
    );
    succeed(&options.split_whitespace().collect::<Vec<_>>());
    let report: serde_json::Value = serde_json::from_slice(&std::fs::read(timings).unwrap()).unwrap();
    let pixels = |frame: u32| read_exr(folder.join(format!("{mode}-{frame:04}.exr"))).unwrap().2;
    ((0..3).map(pixels).collect(), report["counts"]["lights_applied"].as_u64().unwrap_or(0))
}

#[test]
fn the_built_in_scene_in_motion_has_the_same_pictures() {
    for animation in ["object", "figure"] {
        let folder = tempfile::tempdir().unwrap();
        let [anew, updated, checked] = ["full", "auto", "check"].map(|mode| sequence(folder.path(), animation, mode));
        assert_eq!(anew.1, 0, "{animation}");
        assert!(updated.1 > 0 && updated.1 == checked.1, "{animation}: {} and {} changes", updated.1, checked.1);
        assert!(anew.0 == updated.0 && anew.0 == checked.0, "{animation}: other pictures");
        assert_ne!(anew.0[0], anew.0[2], "{animation}: nothing moves");
    }
}

#[test]
fn a_check_of_lights_that_are_not_sorted_is_refused() {
    let mut command = program();
    command.args("--headless --size 16x9 --levels 2 --vpls 40000 --grid-update check".split(' '));
    let found = run(command);
    assert_eq!(found.code, Some(2), "{}", found.stderr);
    let words =
        "--grid-update check compares with lights sorted by cell, and so many share a cell here that they are not";
    assert!(found.stderr.contains(words), "{}", found.stderr);
}

#[test]
fn grids_go_on_where_few_lights_change() {
    let test = gpu();
    let scene = courtyard();
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    let mode = |asked, seeds| {
        let settings = settings(asked).changed(|s| s.many_lights.vpl_seeds = seeds);
        let job = Job::new(&test.gpu, &uploaded, &scene.cameras[0], &settings);
        Renderer::new(&job).unwrap().shapes().of::<LghShape>().unwrap().grid_update
    };
    // Nothing moves in this scene.
    for seeds in [None, Some(VplSeeds::Held), Some(VplSeeds::Fresh)] {
        assert_eq!(mode(GridUpdate::Auto, seeds), GridUpdate::Full, "{seeds:?}");
        assert_eq!(mode(GridUpdate::Check, seeds), GridUpdate::Check, "{seeds:?}");
    }
    assert_eq!(mode(GridUpdate::Auto, Some(VplSeeds::Rolling)), GridUpdate::Auto);
    assert_eq!(mode(GridUpdate::Full, Some(VplSeeds::Rolling)), GridUpdate::Full);
}
