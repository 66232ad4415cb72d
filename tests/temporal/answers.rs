//! Runs of frames with known answers.

use std::f64::consts::FRAC_1_SQRT_2;

use glam::Vec3;
use gridlight::renderer::Fresh;
use gridlight::scene::testing::{diffuse, scene_from_quads};
use gridlight::scene::{Light, Scene};
use gridlight::settings::{Settings, ShadowEstimate, ShadowFilter, Size, Temporal};
use gridlight::uploaded_scene::UploadedScene;
use serde_json::json;

use crate::common::gpu;
use crate::common::picture::{SIZES, Texel};
use crate::common::rooms::{add_quad, camera, furnished_room};
use crate::run::{Run, settings};
use crate::support::animated::{playing, slide};
use crate::support::quad_glb;

const MODES: [Temporal; 2] = [Temporal::Shadows, Temporal::Indirect];
const ESTIMATES: [ShadowEstimate; 3] = [ShadowEstimate::Ratio, ShadowEstimate::Corrected, ShadowEstimate::Unbiased];
const SIZE: Size = SIZES[4];
/// Distance of a box that moves.
const BOX_M: f32 = 2.0;

#[test]
fn held_light_paths_give_the_mean_of_the_frames() {
    let test = gpu();
    // Nothing is cut where the estimate is unbiased.
    let settings = settings(SIZE, Temporal::Shadows, ShadowEstimate::Unbiased);
    let mut run = Run::new(&test.gpu, &furnished_room(), &settings);
    let mut sums: Vec<Texel> = Vec::new();
    for count in 1..=20 {
        run.next();
        let frame = run.last();
        let traced = frame.floats("shadow_rays", "shadowed");
        sums.resize(traced.len(), [0.0; 4]);
        for (sum, texel) in sums.iter_mut().zip(&traced) {
            (0..3).for_each(|channel| sum[channel] += texel[channel]);
        }
        let kept = frame.floats("temporal/blend", "temporal_shadowed");
        let mut greatest = 0.0_f64;
        for (index, (kept, sum)) in kept.iter().zip(&sums).enumerate() {
            assert_eq!(kept[3].round(), f64::from(count), "pixel {index} has {} frames", kept[3]);
            let mean = sum.map(|channel| channel / f64::from(count));
            greatest = greatest.max(mean[1]);
            for channel in 0..3 {
                let off = (kept[channel] - mean[channel]).abs() / mean[channel].max(1.0);
                assert!(off <= 1e-6, "{count} frames, pixel {index}: {kept:?}, not {mean:?}");
            }
        }
        assert!(greatest > 0.1, "there is no light");
    }
}

/// Frames of a run, with a cut before the third.
fn pictures(scene: &Scene, settings: &Settings, count: u32) -> Vec<Vec<f32>> {
    let test = gpu();
    let mut run = Run::new(&test.gpu, scene, settings);
    let picture = |frame: u32| {
        if frame == 2 {
            run.renderer.cut();
        }
        run.next_with(Fresh::All);
        run.radiance()
    };
    (0..count).map(picture).collect()
}

/// Every mode, under validation: the first frame and one after a cut are as without history, others are not.
#[test]
fn a_frame_without_history_is_as_with_temporal_off() {
    let scene = furnished_room();
    for (estimate, interleave) in ESTIMATES.into_iter().zip([1, 2, 4]).chain([(ShadowEstimate::Corrected, 1)]) {
        let filter = if interleave == 4 { ShadowFilter::None } else { ShadowFilter::Atrous };
        let settings = |mode: Temporal| {
            settings(SIZE, mode, estimate).changed(|s| (s.lgh.interleave, s.lgh.filter) = (interleave, filter))
        };
        let plain = pictures(&scene, &settings(Temporal::Off), 5);
        for mode in MODES {
            let blended = pictures(&scene, &settings(mode), 5);
            let what = format!("{mode:?}, {estimate:?}, interleave {interleave}");
            for (frame, is_alone) in [true, false, true, false, false].into_iter().enumerate() {
                assert!(blended[frame].iter().all(|value| value.is_finite()), "{what}, frame {frame}");
                assert_eq!(blended[frame] == plain[frame], is_alone, "{what}, frame {frame}");
            }
        }
    }
}

/// A wall under a lamp, with a box's face before it.
fn wall(lamp: f32) -> Scene {
    let at = |x: f32, y: f32| Vec3::new(x, y, -3.0);
    let wall = [at(-6.0, -6.0), at(6.0, -6.0), at(6.0, 6.0), at(-6.0, 6.0)];
    let floor = [
        Vec3::new(-6.0, -1.5, 3.0),
        Vec3::new(6.0, -1.5, 3.0),
        Vec3::new(6.0, -1.5, -3.0),
        Vec3::new(-6.0, -1.5, -3.0),
    ];
    let mut scene = scene_from_quads("wall", &[wall, floor], diffuse("grey", Vec3::splat(0.6)));
    let beam = Vec3::new(0.2, -1.0, -0.3).normalize();
    scene.lights = vec![Light::Spot {
        position_ws: Vec3::new(-0.5, 2.5, -1.0),
        direction_ws: beam,
        intensity: Vec3::new(9.0, 7.0, 4.0) * lamp,
        inner_cos: 0.9,
        outer_cos: 0.6,
    }];
    scene.cameras = vec![camera(Vec3::ZERO, Vec3::NEG_Z, 0.9)];
    scene
}

#[test]
fn a_step_by_a_pixel_moves_the_history_by_a_pixel() {
    let test = gpu();
    let settings = settings(SIZE, Temporal::Shadows, ShadowEstimate::Unbiased);
    let mut run = Run::new(&test.gpu, &furnished_room_wall(), &settings);
    (0..3).for_each(|_| run.next());
    let before = run.last().floats("temporal/blend", "temporal_shadowed");
    // On the wall 3 m ahead a pixel is as wide.
    run.step_right(3.0 * 2.0 * (0.45_f32).tan() / SIZE.height as f32);
    run.next();
    let found = run.last().floats("temporal/reproject", "reprojected_shadowed");
    let width = SIZE.width as usize;
    let mut compared = 0;
    for (index, texel) in found.iter().enumerate().filter(|(index, _)| index % width + 1 < width) {
        let expected = before[index + 1];
        for channel in 0..4 {
            let off = (texel[channel] - expected[channel]).abs() / expected[channel].abs().max(1.0);
            assert!(off <= 1e-4, "pixel {index}: {texel:?}, not {expected:?}");
        }
        compared += usize::from(expected[1] > 0.0);
    }
    assert!(compared > 100, "there is no light");
    // What came into sight at the edge has no history.
    assert!(found.iter().skip(width - 1).step_by(width).all(|texel| texel[3] == 0.0));
}

/// The wall alone, lit by what a lamp throws on a floor that is out of sight.
fn furnished_room_wall() -> Scene {
    let mut scene = wall(1.0);
    scene.cameras[0].position_ws.y = 1.2;
    scene
}

/// Light that becomes half as bright does so in the picture of the same frame.
#[test]
fn a_lamp_that_is_dimmed_dims_the_picture_at_once() {
    let test = gpu();
    for estimate in ESTIMATES {
        // VPLs that are brighter than usual would have a clamp of their own.
        let settings = settings(SIZE, Temporal::Shadows, estimate).changed(|s| s.many_lights.clamp = 0.0);
        let dimmed = UploadedScene::new(&test.gpu, &wall(0.5)).unwrap();
        let last = |dims: bool| {
            let mut run = Run::new(&test.gpu, &wall(1.0), &settings);
            (0..6).for_each(|_| run.next());
            if dims {
                run.renderer.update_lights(dimmed.other_lights()).unwrap();
            }
            run.next();
            run.radiance()
        };
        let [bright, dim] = [false, true].map(last);
        assert!(bright.iter().any(|value| *value > 0.01), "there is no light");
        for (index, (bright, dim)) in bright.iter().zip(&dim).enumerate() {
            assert!((dim - 0.5 * bright).abs() <= 1e-6 * bright, "{estimate:?}, value {index}: {dim} of {bright}");
        }
    }
}

/// What a box hid before the camera moved begins anew; everything else goes on.
#[test]
fn what_a_moved_camera_uncovers_begins_anew() {
    let test = gpu();
    let settings = settings(SIZE, Temporal::Shadows, ShadowEstimate::Corrected);
    let mut scene = wall(1.0);
    // The front of a box, 1 m before the eye.
    let (left, edge) = (-0.35, 0.3);
    let face = |x: f32, y: f32| Vec3::new(left + x * edge, -0.15 + y * edge, -1.0);
    add_quad(&mut scene, [face(0.0, 0.0), face(1.0, 0.0), face(1.0, 1.0), face(0.0, 1.0)]);
    let mut run = Run::new(&test.gpu, &scene, &settings);
    (0..5).for_each(|_| run.next());
    let depth_before: Vec<f32> = run.last().written.all("gbuffer", "gbuffer_depth");
    // The camera moves, and with it everything but the box in the picture: what was behind the box comes into sight.
    run.step_right(0.1);
    run.next();
    let (anew, kept) = pixels_that_begin_anew(&run, &depth_before, 1.0);
    assert!(anew >= 5 && kept > 300, "{anew} pixels begin anew, {kept} go on");
}

/// Where a box was that has moved by ten pixels, the wall behind it begins anew; everything else goes on, the box with it.
#[test]
fn what_a_moved_box_uncovers_begins_anew() {
    let test = gpu();
    let settings = settings(SIZE, Temporal::Shadows, ShadowEstimate::Corrected);
    let upright = [FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2];
    let glb = quad_glb(|document, bin| {
        document["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 40.0}]}});
        document["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.9, "znear": 0.05}}]);
        document["nodes"] = json!([
            {"mesh": 0, "rotation": upright, "scale": [0.3, 1.0, 0.3], "translation": [-0.5, 0.0, -BOX_M]},
            {"mesh": 0, "rotation": upright, "scale": [9.0, 1.0, 9.0], "translation": [0.0, 0.0, -3.0]},
            {"extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [0.0, 0.5, -0.5]},
            {"camera": 0}
        ]);
        document["scenes"][0]["nodes"] = json!([0, 1, 2, 3]);
        slide(document, bin, 0);
    });
    let mut scene = playing(&glb);
    let mut run = Run::new(&test.gpu, &scene, &settings);
    (0..5).for_each(|_| run.next());
    let depth_before: Vec<f32> = run.last().written.all("gbuffer", "gbuffer_depth");
    // A metre a second.
    scene.pose(f64::from(10.0 * BOX_M * 2.0 * (0.45_f32).tan() / SIZE.height as f32));
    run.uploaded.follow(&test.gpu, &scene).unwrap();
    run.next();
    let (anew, kept) = pixels_that_begin_anew(&run, &depth_before, BOX_M);
    assert!(anew >= 20 && kept > 300, "{anew} pixels begin anew, {kept} go on");
}

/// Checks which pixels of the last frame begin anew: those whose surface, the box or what is behind it, was not in sight in the
/// frame before. The box is `box_m` away. How many begin anew, and how many go on.
fn pixels_that_begin_anew(run: &Run<'_>, depth_before: &[f32], box_m: f32) -> (usize, usize) {
    let frame = run.last();
    let depth: Vec<f32> = frame.written.all("gbuffer", "gbuffer_depth");
    let motion: Vec<[f32; 4]> = frame.written.all("gbuffer", "gbuffer_motion");
    let frames = frame.floats("temporal/blend", "temporal_shadowed");
    let is_box = |depth: f32| (run.camera.near / depth - box_m).abs() < 0.01;
    let (mut anew, mut kept) = (0, 0);
    for (x, y) in frame.pixels() {
        let index = frame.surfaces.index(x, y).unwrap();
        let [at_x, at_y] = [x as f32 + motion[index][0], y as f32 + motion[index][1]];
        let taps =
            [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| (at_x.floor() as i32 + dx, at_y.floor() as i32 + dy));
        let seen: Vec<bool> = taps
            .iter()
            .filter_map(|(x, y)| frame.surfaces.index(*x, *y))
            .map(|tap| is_box(depth_before[tap]) == is_box(depth[index]))
            .collect();
        // Where some of the four pixels show the same surface, their share decides.
        if seen.iter().all(|same| !same) {
            assert_eq!(frames[index][3], 1.0, "pixel {x}, {y} goes on");
            anew += usize::from(!seen.is_empty());
        } else if seen.len() == 4 && seen.iter().all(|same| *same) && !is_edge(depth_before, &taps, &frame) {
            assert!(frames[index][3] > 5.0, "pixel {x}, {y} has {} frames", frames[index][3]);
            kept += 1;
        }
    }
    (anew, kept)
}

/// Whether a surface of another kind lies among these pixels, such as where wall and floor meet.
fn is_edge(depth: &[f32], taps: &[(i32, i32); 4], frame: &crate::common::picture::Frame) -> bool {
    let normals: Vec<_> = taps
        .iter()
        .filter_map(|(x, y)| frame.surfaces.index(*x, *y))
        .map(|index| (frame.surfaces.normal(index), depth[index]))
        .collect();
    normals.iter().any(|(normal, _)| normal.dot(normals[0].0) < 0.9)
}
