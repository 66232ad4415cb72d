//! Temporal anti-aliasing (`passes::taa`), against its twin and known answers.

use std::f64::consts::FRAC_1_SQRT_2;
use std::sync::Arc;

use glam::{Vec2, Vec3, Vec4};
use gridlight::cpu::taa::{BLEND, Blend, Input, blend_frames};
use gridlight::environment::Environment;
use gridlight::passes::taa::jitter_px;
use gridlight::renderer::{Fresh, UploadedScene};
use gridlight::scene::testing::{diffuse, scene_from_quads};
use gridlight::scene::{Light, Scene};
use gridlight::settings::{Exposure, IndirectSize, MicroFill, Settings, Size, Switch, Technique, Temporal};
use gridlight::shared::FrameData;
use serde_json::json;

use crate::common::compare::Verdict;
use crate::common::picture::{SIZES, Texel, compare_texels};
use crate::common::rooms::{add_quad, camera, furnished_room};
use crate::common::{GpuTest, gpu};
use crate::run::Run;
use crate::support::animated::{playing, slide};
use crate::support::quad_glb;

/// Sums of 16 products, and divisions by deviations, which are differences.
const TOLERANCE: [f64; 2] = [2e-4, 1e-6];
/// Weights of frames add up to 1 but for rounding.
const MEAN_TOLERANCE: f32 = 1e-5;
const SIZE: Size = SIZES[4];
/// Nothing is clipped.
const UNCLIPPED: Blend = Blend { most_deviations: f32::INFINITY, ..BLEND };

/// Direct light alone, all of it darker than white.
fn settings(size: Size) -> Settings {
    Settings::default().changed(|s| {
        s.picture.size = size;
        s.picture.exposure = Exposure::Fixed(0.05);
        s.render.technique = Technique::Direct;
        s.render.taa = Switch::On;
    })
}

/// What went into the pass, and what came out.
struct Blended {
    data: FrameData,
    radiance: Vec<Vec3>,
    depth: Vec<f32>,
    motion: Vec<Vec4>,
    exposure: f32,
    picture: Vec<Vec4>,
}

impl Blended {
    /// Of the last frame.
    fn of(run: &Run<'_>) -> Self {
        let written = run.last().written;
        let texels = |pass: &str, resource: &str| -> Vec<Vec4> {
            written.all::<[f32; 4]>(pass, resource).into_iter().map(Vec4::from_array).collect()
        };
        Self {
            data: *run.renderer.frame_data(),
            radiance: texels("compose", "radiance").into_iter().map(Vec4::truncate).collect(),
            depth: written.all("gbuffer", "gbuffer_depth"),
            motion: texels("gbuffer", "gbuffer_motion"),
            exposure: written.all::<f32>("tone_map/measure_exposure", "exposure")[0],
            picture: texels("taa", "antialiased"),
        }
    }

    /// The same of the next one.
    fn next(run: &mut Run<'_>) -> Self {
        run.next();
        Self::of(run)
    }

    /// What the twin makes of the frame and of a picture of the frame before.
    fn twin(&self, before: &[Vec4], by: Blend) -> Vec<Vec4> {
        let Self { data, radiance, depth, motion, exposure, .. } = self;
        blend_frames(Input { frame: data, radiance, depth, motion, before, exposure: *exposure }, by)
    }

    fn check(&self, before: &[Vec4], by: Blend) -> Verdict {
        let twin = self.twin(before, by);
        let texels = |picture: &[Vec4], of: fn(&Vec4) -> Vec4| -> Vec<Texel> {
            picture.iter().map(|texel| of(texel).as_dvec4().to_array()).collect()
        };
        let compare = |what: &str, channels: usize, of: fn(&Vec4) -> Vec4| {
            compare_texels(what, &texels(&self.picture, of), &texels(&twin, of), channels, TOLERANCE)
        };
        compare("colors", 3, |texel| *texel)?;
        // By itself: it is larger than all colours.
        compare("frames", 1, |texel| Vec4::splat(texel.w))
    }
}

/// The room, with a wall taken away: the sky is behind it.
fn open_room() -> Scene {
    let mut scene = furnished_room();
    scene.cameras[0] = camera(Vec3::new(0.5, 0.4, 5.5), Vec3::new(-0.1, -0.1, -1.0).normalize(), 0.9);
    scene.environment = Some(Arc::new(Environment::uniform([1.0, 2.0, 3.0])));
    scene
}

/// Frames that follow each other, at rest, after a step, and after another with a turn.
fn frames(test: &GpuTest, scene: &Scene, settings: &Settings) -> Vec<Blended> {
    let mut run = Run::new(&test.gpu, scene, settings);
    let mut frames = vec![Blended::next(&mut run), Blended::next(&mut run)];
    run.step_right(0.07);
    frames.push(Blended::next(&mut run));
    run.camera.position_ws += run.camera.forward_ws * 0.11;
    run.camera.forward_ws = (run.camera.forward_ws + 0.02 * run.camera.right_ws).normalize();
    run.camera.right_ws = run.camera.forward_ws.cross(run.camera.up_ws).normalize();
    frames.push(Blended::next(&mut run));
    frames
}

#[test]
fn frames_are_blended_as_by_the_twin() {
    let test = gpu();
    for size in SIZES {
        for (name, scene) in [("room", furnished_room()), ("open room", open_room())] {
            for pair in frames(&test, &scene, &settings(size)).windows(2) {
                pair[1].check(&pair[0].picture, BLEND).unwrap_or_else(|e| panic!("{name}, {size}: {e}"));
            }
        }
    }
    // With an exposure that makes most of the picture brighter than white.
    let bright = settings(SIZE).changed(|s| s.picture.exposure = Exposure::Fixed(5.0));
    for pair in frames(&test, &open_room(), &bright).windows(2) {
        pair[1].check(&pair[0].picture, BLEND).unwrap();
    }
}

/// What is planted, and how.
type Fault = (&'static str, fn(&mut Blend));

#[test]
fn other_blends_are_noticed() {
    let test = gpu();
    let settings = settings(SIZE).changed(|s| s.picture.exposure = Exposure::Fixed(5.0));
    // Long enough for the least weight to count.
    let settled = |scene: &Scene| {
        let mut run = Run::new(&test.gpu, scene, &settings);
        (0..26).for_each(|_| run.next());
        run
    };
    let mut run = settled(&open_room());
    let before_step = Blended::of(&run);
    run.step_right(0.07);
    let stepped = Blended::next(&mut run);
    // A lamp that is dimmed leaves a history that is clipped at rest.
    let mut run = settled(&wall(9.0));
    let before_dusk = Blended::of(&run);
    run.renderer.update_lights(UploadedScene::new(&test.gpu, &wall(6.0)).unwrap().other_lights()).unwrap();
    let dimmed = Blended::next(&mut run);
    let check = |by: Blend| {
        let verdict = stepped.check(&before_step.picture, by);
        verdict.and_then(|()| dimmed.check(&before_dusk.picture, by))
    };
    check(BLEND).unwrap();
    let faults: [Fault; 7] = [
        ("a longer memory", |by| by.least_weight = 0.098),
        ("a longer memory at rest", |by| by.least_weight_at_rest = 0.039),
        ("another clip at rest", |by| by.clip_at_rest = 0.27),
        ("a wider clip", |by| by.most_deviations = 1.27),
        ("no clip", |by| by.most_deviations = f32::INFINITY),
        ("brightness that counts in full", |by| by.weighs_brightness = false),
        ("motion of each pixel's own surface", |by| by.takes_nearest = false),
    ];
    for (what, plant) in faults {
        let mut blend = BLEND;
        plant(&mut blend);
        assert!(check(blend).is_err(), "{what} was not noticed");
    }
    assert!(stepped.check(&stepped.picture, BLEND).is_err(), "another history was not noticed");
}

/// At rest, where no frame clips its history, the picture is the mean of the frames, each sampled elsewhere.
#[test]
fn a_picture_at_rest_is_the_mean_of_eight_frames() {
    let test = gpu();
    let mut run = Run::new(&test.gpu, &screen(), &settings(SIZE));
    let mut frames: Vec<Blended> = Vec::new();
    let mut is_whole = vec![true; (SIZE.width * SIZE.height) as usize];
    for number in 0..8 {
        let now = Blended::next(&mut run);
        assert_eq!([now.data.jitter_x_px, now.data.jitter_y_px], jitter_px(number).to_array());
        assert!(now.motion.iter().all(|motion| Vec2::new(motion.x, motion.y) == Vec2::ZERO), "frame {number}");
        assert!(now.picture.iter().all(|texel| (texel.w - (number + 1) as f32).abs() < 1e-4), "frame {number}");
        if let Some(before) = frames.last() {
            let [clipped, plain] = [BLEND, UNCLIPPED].map(|by| now.twin(&before.picture, by));
            is_whole.iter_mut().zip(clipped.iter().zip(plain)).for_each(|(whole, (a, b))| *whole &= *a == b);
        }
        frames.push(now);
    }
    let (mut whole, mut edges) = (0, 0);
    for (index, texel) in frames[7].picture.iter().enumerate().filter(|(index, _)| is_whole[*index]) {
        let values: Vec<Vec3> = frames.iter().map(|frame| frame.radiance[index]).collect();
        let mean = values.iter().sum::<Vec3>() / 8.0;
        let off = (texel.truncate() - mean).abs().max_element();
        assert!(off <= MEAN_TOLERANCE * mean.max_element(), "pixel {index}: {texel}, not {mean}");
        let spread = values.iter().fold(0.0_f32, |most, value| most.max((value - mean).abs().max_element()));
        whole += 1;
        edges += usize::from(spread > 0.1 * mean.max_element());
    }
    assert!(whole > 500 && edges >= 4, "{whole} pixels are never clipped, {edges} of them at edges");
}

/// A wall under a lamp, which fills the picture.
fn wall(intensity: f32) -> Scene {
    let at = |x: f32, y: f32| Vec3::new(x, y, -3.0);
    let quad = [at(-9.0, -9.0), at(9.0, -9.0), at(9.0, 9.0), at(-9.0, 9.0)];
    let mut scene = scene_from_quads("wall", &[quad], diffuse("grey", Vec3::splat(0.5)));
    scene.lights = vec![Light::Spot {
        position_ws: Vec3::new(0.2, 0.1, -1.0),
        direction_ws: Vec3::NEG_Z,
        intensity: Vec3::new(1.0, 0.8, 0.5) * intensity,
        inner_cos: 0.999,
        outer_cos: 0.93,
    }];
    scene.cameras = vec![camera(Vec3::ZERO, Vec3::NEG_Z, 0.9)];
    scene
}

#[test]
fn a_step_by_a_pixel_moves_the_history_by_a_pixel() {
    let test = gpu();
    let mut run = Run::new(&test.gpu, &wall(9.0), &settings(SIZE));
    (0..3).for_each(|_| run.next());
    let before = Blended::of(&run);
    run.step_right(3.0 * 2.0 * (0.45_f32).tan() / SIZE.height as f32);
    let now = Blended::next(&mut run);
    let [clipped, plain] = [BLEND, UNCLIPPED].map(|by| now.twin(&before.picture, by));
    let width = SIZE.width as usize;
    let mut compared = 0;
    for index in (0..now.picture.len()).filter(|index| index % width + 1 < width && clipped[*index] == plain[*index]) {
        // Three frames and this one.
        let expected = (3.0 * before.picture[index + 1].truncate() + now.radiance[index]) / 4.0;
        let off = (now.picture[index].truncate() - expected).abs().max_element();
        assert!(off <= 1e-4 * expected.max_element().max(0.1), "pixel {index}: {}, not {expected}", now.picture[index]);
        compared += usize::from(expected.x > 0.05);
    }
    assert!(compared > 50, "{compared} pixels are lit and not clipped");
    // What came into sight at the edge is the frame's own.
    for index in (width - 1..now.picture.len()).step_by(width) {
        assert_eq!(now.picture[index], now.radiance[index].extend(1.0), "pixel {index}");
    }
}

/// Every technique that has it, with every interleave and beside `--temporal`, under validation: the first frame and one after a
/// cut are, to the bit, as without it.
#[test]
fn a_frame_without_history_is_as_with_taa_off() {
    let test = gpu();
    let of = |technique: Technique| {
        settings(SIZE).changed(|s| {
            s.render.technique = technique;
            s.many_lights.vpls = 500;
            s.pbgi.points = 4096;
        })
    };
    let lgh = |temporal: Temporal, interleave: u32| {
        of(Technique::Lgh).changed(|s| (s.lgh.temporal, s.lgh.interleave) = (Some(temporal), interleave))
    };
    let modes = [
        of(Technique::Direct),
        of(Technique::Pbgi),
        of(Technique::Pbgi).changed(|s| s.pbgi.micro = MicroFill::Points),
        of(Technique::FinalGather),
        lgh(Temporal::Off, 1),
        lgh(Temporal::Off, 2),
        lgh(Temporal::Shadows, 4),
        lgh(Temporal::Indirect, 1),
        lgh(Temporal::Off, 1).changed(|s| s.lgh.indirect_size = IndirectSize::Half),
        lgh(Temporal::Shadows, 1).changed(|s| s.lgh.indirect_size = IndirectSize::Half),
    ];
    for settings in modes {
        let technique = settings.render.technique;
        let what = format!("{technique:?}, interleave {}, {:?}", settings.lgh.interleave, settings.lgh.temporal);
        let frames = |taa: Switch| -> Vec<Vec<f32>> {
            let settings = settings.clone().changed(|s| s.render.taa = taa);
            let mut run = with_points(&test, &furnished_room(), &settings);
            let next = |number: u32| {
                if number == 2 {
                    run.renderer.cut();
                }
                run.next_with(Fresh::All);
                run.radiance()
            };
            (0..4).map(next).collect()
        };
        let [plain, smooth] = [Switch::Off, Switch::On].map(frames);
        for (frame, is_alone) in [true, false, true, false].into_iter().enumerate() {
            assert!(smooth[frame].iter().all(|value| value.is_finite()), "{what}, frame {frame}");
            assert_eq!(smooth[frame] == plain[frame], is_alone, "{what}, frame {frame}");
        }
    }
}

/// A run over a scene whose surfaces points stand for, where the technique asks for them.
fn with_points<'a>(test: &'a GpuTest, scene: &Scene, settings: &Settings) -> Run<'a> {
    let direct = settings.clone().changed(|s| s.render.technique = Technique::Direct);
    let mut run = Run::new(&test.gpu, scene, &direct);
    let technique = gridlight::techniques::of(settings).unwrap();
    run.uploaded.spread_points(scene, technique.point_count_log2(settings)).unwrap();
    run.settings = settings.clone();
    let job = gridlight::renderer::Job::new(run.gpu, &run.uploaded, &run.camera, settings);
    run.renderer = gridlight::renderer::Renderer::new(&job).unwrap();
    run
}

/// Light a million times as bright as white beside black, by a camera that moves and stands.
#[test]
fn pictures_are_finite_beside_black_and_blinding_light() {
    let test = gpu();
    let mut scene = wall(4e7);
    let black = |x: f32, y: f32| Vec3::new(0.3 * x - 0.4, 0.4 * y - 0.2, -0.9);
    add_quad(&mut scene, [black(0.0, 0.0), black(1.0, 0.0), black(1.0, 1.0), black(0.0, 1.0)]);
    for exposure in [Exposure::Auto, Exposure::Fixed(1.0), Exposure::Fixed(1e-6)] {
        let settings = settings(SIZE).changed(|s| s.picture.exposure = exposure);
        let mut run = Run::new(&test.gpu, &scene, &settings);
        for frame in 0..12 {
            if frame % 3 > 0 {
                run.step_right(0.043);
            }
            let now = Blended::next(&mut run);
            let brightest = now.radiance.iter().fold(0.0_f32, |most, color| most.max(color.max_element()));
            assert!(brightest > 1e6 && now.radiance.contains(&Vec3::ZERO), "there is no contrast: {brightest}");
            for (index, texel) in now.picture.iter().enumerate() {
                let color = texel.truncate();
                let is_sound =
                    texel.is_finite() && color.min_element() >= 0.0 && color.max_element() <= 2.0 * brightest;
                assert!(is_sound, "{exposure:?}, frame {frame}, pixel {index}: {texel}");
            }
        }
    }
}

/// A bright screen that moves before a dark wall, by metres a second.
fn screen() -> Scene {
    let upright = [FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2];
    playing(&quad_glb(|document, bin| {
        document["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 40.0}]}});
        document["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.9, "znear": 0.05}}]);
        let mut dark = document["meshes"][0].clone();
        dark["primitives"][0]["material"] = json!(1);
        document["meshes"].as_array_mut().unwrap().push(dark);
        let color = json!({"pbrMetallicRoughness": {"baseColorFactor": [0.02, 0.03, 0.04, 1.0]}});
        document["materials"].as_array_mut().unwrap().push(color);
        document["nodes"] = json!([
            {"mesh": 0, "rotation": upright, "scale": [0.15, 1.0, 0.15], "translation": [-0.8, 0.0, -2.0]},
            {"mesh": 1, "rotation": upright, "scale": [9.0, 1.0, 9.0], "translation": [0.0, 0.0, -3.0]},
            {"extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [0.0, 0.5, -0.5]},
            {"camera": 0}
        ]);
        document["scenes"][0]["nodes"] = json!([0, 1, 2, 3]);
        slide(document, bin, 0);
    }))
}

/// How much brighter than the frames' own pixels of the wall are at most that a screen has left behind, over the brightness of
/// the screen: in the picture, and where the history is not clipped.
fn ghosts() -> [f32; 2] {
    let test = gpu();
    let mut scene = screen();
    let mut run = Run::new(&test.gpu, &scene, &settings(SIZE));
    let is_screen = |frame: &Blended, index: usize| (frame.data.near / frame.depth[index] - 2.0).abs() < 0.05;
    let (mut frames, mut unclipped): (Vec<Blended>, Vec<Vec4>) = (Vec::new(), Vec::new());
    for number in 0..10_u32 {
        if number > 0 {
            scene.pose(f64::from(number) * 0.1);
            run.uploaded.follow(&test.gpu, &scene).unwrap();
        }
        let now = Blended::next(&mut run);
        unclipped = if number == 0 { now.picture.clone() } else { now.twin(&unclipped, UNCLIPPED) };
        frames.push(now);
    }
    let last = frames.last().unwrap();
    let was_screen = |index: &usize| frames.iter().any(|frame| is_screen(frame, *index));
    // More than two pixels away from where it is, pixels show the wall alone.
    let width = SIZE.width as usize;
    let apart = |a: usize, b: usize| (a % width).abs_diff(b % width).max((a / width).abs_diff(b / width));
    let here: Vec<usize> = (0..last.picture.len()).filter(|index| is_screen(last, *index)).collect();
    let is_near = |index: usize| here.iter().any(|other| apart(index, *other) <= 2);
    let left: Vec<usize> = (0..last.picture.len()).filter(was_screen).filter(|index| !is_near(*index)).collect();
    assert!(left.len() > 20, "the screen has left {} pixels", left.len());
    let brightness = here.iter().map(|index| last.radiance[*index].x).fold(0.0, f32::max);
    [&last.picture, &unclipped].map(|picture| {
        let ghost = left.iter().map(|index| (picture[*index].x - last.radiance[*index].x) / brightness);
        ghost.fold(0.0, f32::max)
    })
}

#[test]
fn what_moves_leaves_a_ghost_only_where_history_is_not_clipped() {
    let [clipped, unclipped] = ghosts();
    assert!(clipped <= 0.005, "a ghost of {clipped}");
    assert!(unclipped > 0.1, "the fault is not seen: {unclipped}");
}

/// Histories of the shadows go on at rest, although frames sample their pixels elsewhere.
#[test]
fn histories_of_shadows_go_on_at_rest() {
    let test = gpu();
    for half in [IndirectSize::Full, IndirectSize::Half] {
        let settings = crate::run::settings(SIZE, Temporal::Shadows, gridlight::settings::ShadowEstimate::Corrected)
            .changed(|s| (s.render.taa, s.lgh.indirect_size) = (Switch::On, half));
        let mut run = Run::new(&test.gpu, &furnished_room(), &settings);
        (0..12).for_each(|_| run.next());
        let frames = run.last().floats("temporal/blend", "temporal_shadowed");
        let whole = frames.iter().filter(|texel| texel[3].round() == 12.0).count();
        // At edges pixels show now this surface and now that.
        assert!(whole * 100 >= frames.len() * 85, "{half:?}: {whole} of {} go on", frames.len());
    }
}
