//! Every view on the GPU against what the scene, or a sum on the CPU, says that it must show.

mod common;
mod support;

use std::sync::Arc;

use clap::ValueEnum;
use common::GpuTest;
use common::compare::{all_finite, near};
use common::rooms::{furnished_room, lamp_room, surface};
use glam::Vec3;
use gridlight::app::counts;
use gridlight::color::luminance;
use gridlight::cpu::grid::Grid;
use gridlight::cpu::lights::{Clamp, blend_weight, light_response, lobe_of_level};
use gridlight::environment::Environment;
use gridlight::files::pictures::{read_exr, read_png};
use gridlight::gpu::Gpu;
use gridlight::passes::lgh_shape::LghShape;
use gridlight::renderer::{Job, Renderer, UploadedScene};
use gridlight::scene::bvh::build_binary;
use gridlight::scene::{Camera, Scene};
use gridlight::settings::{Reservoir, Settings, ShadowEstimate, ShadowFilter, Size, Technique, View};
use gridlight::shared::{FrameData, GridLight, GridPlacement, MAX_LEVEL, SUB_IMAGE_STRIDE};
use gridlight::techniques;
use gridlight::techniques::lgh::HierarchyOutputs;
use gridlight::views::{LEVEL_COLORS, NO_VALUE};

const ALBEDO: Vec3 = Vec3::new(0.6, 0.4, 0.2);

fn room() -> Scene {
    lamp_room(ALBEDO)
}

fn settings(view: View) -> Settings {
    Settings::default().changed(|s| {
        s.picture.size = Size { width: 48, height: 32 };
        s.many_lights.vpls = 600;
        s.render.view = view;
    })
}

/// A view of a scene with its picture and the renderer that made it; every value is a number.
struct Seen {
    values: Vec<Vec3>,
    picture: Vec<[u8; 3]>,
    renderer: Renderer,
}

fn see(test: &GpuTest, scene: &Scene, settings: &Settings) -> Seen {
    see_uploaded(&test.gpu, &UploadedScene::new(&test.gpu, scene).unwrap(), &scene.cameras[0], settings)
}

fn see_uploaded(gpu: &Arc<Gpu>, uploaded: &UploadedScene, camera: &Camera, settings: &Settings) -> Seen {
    let mut renderer = Renderer::new(&Job::new(gpu, uploaded, camera, settings)).unwrap();
    let ticket = renderer.submit().unwrap();
    renderer.wait(ticket).unwrap();
    let values: Vec<Vec3> = renderer.read_radiance().unwrap().chunks_exact(3).map(Vec3::from_slice).collect();
    let picture: Vec<_> = renderer.read_srgb().unwrap().chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
    all_finite(&format!("{:?}", settings.render.view), &values).unwrap();
    let pixels = (settings.picture.size.width * settings.picture.size.height) as usize;
    assert_eq!((values.len(), picture.len()), (pixels, pixels));
    Seen { values, picture, renderer }
}

/// Passes unless more than one pixel in a hundred (on an edge between walls) is wrong.
fn nearly_all(pixels: impl Iterator<Item = bool>) -> bool {
    let found: Vec<bool> = pixels.collect();
    assert!(!found.is_empty());
    found.iter().filter(|right| !**right).count() * 100 <= found.len()
}

#[test]
fn surfaces_are_those_of_the_scene() {
    let test = common::gpu();
    let scene = room();
    let bvh = build_binary(&scene);
    let size = settings(View::Albedo).picture.size;
    let expected: Vec<_> =
        (0..(size.width * size.height) as usize).map(|i| surface(&bvh, &scene.cameras[0], size, i)).collect();

    let albedo = see(&test, &scene, &settings(View::Albedo));
    assert!(albedo.values.iter().all(|v| near(*v, ALBEDO, 1e-3)));
    // 0.6, 0.4, 0.2 in sRGB.
    assert!(albedo.picture.iter().all(|p| p.iter().zip([203, 170, 124]).all(|(a, b)| a.abs_diff(b) <= 1)));

    let normal = see(&test, &scene, &settings(View::Normal));
    assert!(nearly_all(normal.values.iter().zip(&expected).map(|(v, (_, n, _))| near(*v, *n, 1e-3))));
    let coded = |v: &Vec3| v.to_array().map(|c| ((c * 0.5 + 0.5) * 255.0).round() as u8);
    assert!(
        normal.values.iter().zip(&normal.picture).all(|(v, p)| coded(v).iter().zip(p).all(|(a, b)| a.abs_diff(*b) < 2))
    );

    let depth = see(&test, &scene, &settings(View::Depth));
    assert!(nearly_all(depth.values.iter().zip(&expected).map(|(v, (_, _, d))| near(*v, Vec3::splat(*d), 0.01 * d))));
    // Near is bright, and the farthest pixel has the darkest colour.
    let farthest = (0..depth.values.len()).max_by(|a, b| depth.values[*a].x.total_cmp(&depth.values[*b].x)).unwrap();
    assert_eq!(depth.picture[farthest], [0x10; 3]);
}

#[test]
fn where_there_is_no_surface_a_view_says_so() {
    let test = common::gpu();
    let mut scene = room();
    // Out of the room, away from it.
    scene.cameras[0].position_ws = Vec3::new(0.0, 0.0, -9.0);
    let none = NO_VALUE.to_be_bytes();
    for (view, value) in [
        (View::Albedo, Vec3::ZERO),
        (View::Normal, Vec3::ZERO),
        (View::Depth, Vec3::ZERO),
        (View::ShadowRatio, Vec3::ONE),
        (View::SelectedLevel, Vec3::NEG_ONE),
        (View::LevelWeights, Vec3::new(-1.0, -1.0, 0.0)),
    ] {
        let seen = see(&test, &scene, &settings(view));
        assert!(seen.values.iter().all(|v| *v == value), "{view:?}: {}", seen.values[0]);
        assert!(seen.picture.iter().all(|p| p.iter().zip(&none[1..]).all(|(a, b)| a.abs_diff(*b) < 2)), "{view:?}");
    }
}

#[test]
fn direct_and_indirect_light_make_the_picture() {
    let test = common::gpu();
    let scene = room();
    for interleave in [1, 2, 4] {
        let unshadowed = |view| {
            settings(view).changed(|s| {
                s.lgh.interleave = interleave;
                s.many_lights.shadow_samples = 0;
            })
        };
        let [whole, direct, indirect] =
            [View::Final, View::Direct, View::Indirect].map(|view| see(&test, &scene, &unshadowed(view)).values);
        let sum = direct.iter().zip(&indirect).map(|(a, b)| *a + *b);
        assert!(whole.iter().zip(sum).all(|(a, b)| near(*a, b, 1e-4 * a.max_element())), "interleave {interleave}");
        assert!(indirect.iter().all(|v| v.min_element() > 0.0));
    }
    let technique = Technique::Direct;
    let alone = see(&test, &scene, &settings(View::Final).changed(|s| s.render.technique = technique));
    let view = see(&test, &scene, &settings(View::Direct).changed(|s| s.render.technique = technique));
    assert_eq!((alone.values, alone.picture), (view.values, view.picture));
}

/// Modes in which the device updates reservoirs.
fn reservoirs(gpu: &Gpu) -> &'static [Reservoir] {
    let all = &[Reservoir::Race, Reservoir::Lock, Reservoir::Exact];
    if gpu.features().int64_atomics { all } else { &all[..2] }
}

#[test]
fn shadow_ratios_and_chosen_levels_are_in_range() {
    let test = common::gpu();
    let scene = room();
    for reservoir in reservoirs(&test.gpu) {
        for interleave in [1, 2, 4] {
            let of = |view| {
                settings(view).changed(|s| {
                    s.lgh.reservoir = Some(*reservoir);
                    s.lgh.interleave = interleave;
                })
            };
            for view in [View::ShadowRatio, View::ShadowRatioFiltered] {
                let seen = see(&test, &scene, &of(view));
                let what = format!("{view:?} {reservoir:?} {interleave}");
                assert!(seen.values.iter().all(|v| v.min_element() >= 0.0 && v.max_element() <= 1.001), "{what}");
                // An empty convex room: only walls met edge-on hide anything.
                let mean = seen.values.iter().map(|v| v.y).sum::<f32>() / seen.values.len() as f32;
                assert!(mean > 0.9, "{what}: {mean}");
            }
            let seen = see(&test, &scene, &of(View::SelectedLevel));
            let top = seen.renderer.shapes().of::<LghShape>().unwrap().levels.top as f32;
            let sound = |v: &Vec3| *v == Vec3::NEG_ONE || (1.0 <= v.y && v.y <= v.x && v.x <= v.z && v.z <= top);
            assert!(seen.values.iter().all(sound), "{reservoir:?} {interleave}");
            assert!(nearly_all(seen.values.iter().map(|v| v.x > 0.0)), "{reservoir:?} {interleave}");
        }
    }
}

#[test]
fn the_ratio_turns_the_unshadowed_light_into_the_picture() {
    let test = common::gpu();
    if !test.gpu.features().int64_atomics {
        eprintln!("skipped: no 64-bit atomics");
        return;
    }
    let scene = room();
    for (filter, view) in [(ShadowFilter::None, View::ShadowRatio), (ShadowFilter::Atrous, View::ShadowRatioFiltered)] {
        let [whole, direct, indirect, ratio] = [View::Final, View::Direct, View::Indirect, view].map(|view| {
            let settings = settings(view).changed(|s| {
                s.lgh.filter = filter;
                s.lgh.shadow_estimate = Some(ShadowEstimate::Ratio);
            });
            see(&test, &scene, &settings).values
        });
        for i in 0..whole.len() {
            let expected = direct[i] + indirect[i] * ratio[i];
            assert!(near(whole[i], expected, 1e-3 * whole[i].max_element()), "{view:?} {i}: {} {expected}", whole[i]);
        }
    }
}

#[test]
fn lights_tested_are_what_the_statistics_count() {
    let test = common::gpu();
    let scene = room();
    for interleave in [1, 2, 4] {
        let seen = see(&test, &scene, &settings(View::LightsTested).changed(|s| s.lgh.interleave = interleave));
        let settings = settings(View::Final).changed(|s| s.lgh.interleave = interleave);
        let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
        let whole = see(&test, &scene, &settings);
        let counts =
            counts::count(&Job::new(&test.gpu, &uploaded, &scene.cameras[0], &settings), &whole.renderer).unwrap();
        let sum: f64 = seen.values.iter().map(|v| f64::from(v.x)).sum();
        let most = seen.values.iter().fold(0.0, |most: f32, v| most.max(v.x));
        let mean = sum / seen.values.len() as f64;
        assert!((mean - counts["lights_tested_mean"].as_f64().unwrap()).abs() < 1e-6, "{mean} {counts:?}");
        assert_eq!(u64::from(most as u32), counts["lights_tested_max"]);
        assert!(mean > 1.0);
    }
}

/// The lights of every sub-image with the grid they belong to.
fn merged_lights(renderer: &Renderer) -> (Vec<Vec<GridLight>>, Grid) {
    let hierarchy = renderer.outputs().technique.of::<HierarchyOutputs>().unwrap();
    let read = |buffer| renderer.executor().read_buffer(buffer).unwrap();
    let starts: Vec<u32> = bytemuck::pod_collect_to_vec(&read(hierarchy.merged.sub_images));
    let lights: Vec<GridLight> = bytemuck::pod_collect_to_vec(&read(hierarchy.merged.lights));
    let placement: Vec<GridPlacement> = bytemuck::pod_collect_to_vec(&read(hierarchy.placement));
    let shape: &LghShape = renderer.shapes().of().unwrap();
    let of_sub_image = |levels: &[u32]| {
        lights[levels[shape.first_level as usize] as usize..levels[shape.levels.top as usize + 1] as usize].to_vec()
    };
    let all = starts.chunks_exact(SUB_IMAGE_STRIDE as usize).map(of_sub_image).collect();
    (all, Grid { placement: placement[0], levels: shape.levels, center: shape.center })
}

/// Number of lights that contribute, and the luminance of each level's lighting.
fn sum(settings: &Settings, frame: &FrameData, lights: &[GridLight], grid: &Grid, at: (Vec3, Vec3)) -> (f32, Vec<f32>) {
    let clamp = Clamp::of(frame);
    let (mut count, mut levels) = (0.0, vec![0.0; MAX_LEVEL as usize + 1]);
    for light in lights {
        let offset = Vec3::from(light.position_ws) - at.0;
        let radius = settings.lgh.alpha * grid.cell_size(light.level);
        let weight = blend_weight(offset.length(), radius, light.level, settings.lgh.first_level, grid.levels.top);
        let kind = lobe_of_level(light.level, settings.lgh.lobe);
        let response = weight * light_response(offset, at.1, Vec3::from(light.lobe), kind, clamp.of_light(light));
        if response > 0.0 {
            count += 1.0;
            levels[light.level as usize] += response * luminance(Vec3::from(light.flux));
        }
    }
    (count, levels)
}

/// Calls `check` with the pixel's value and picture and with the sums on the CPU; most pixels must pass.
fn against_sums(settings: &Settings, check: impl Fn(Vec3, [u8; 3], f32, &[f32]) -> bool) -> bool {
    let test = common::gpu();
    let scene = room();
    let bvh = build_binary(&scene);
    let seen = see(&test, &scene, settings);
    let (lights, grid) = merged_lights(&seen.renderer);
    let n = settings.lgh.interleave as usize;
    nearly_all((0..seen.values.len()).map(|i| {
        let [x, y] = [i % settings.picture.size.width as usize, i / settings.picture.size.width as usize];
        let (position, normal, _) = surface(&bvh, &scene.cameras[0], settings.picture.size, i);
        let (count, levels) =
            sum(settings, seen.renderer.frame_data(), &lights[y % n * n + x % n], &grid, (position, normal));
        check(seen.values[i], seen.picture[i], count, &levels)
    }))
}

#[test]
fn the_lights_that_contribute_are_counted() {
    for (interleave, first_level, alpha) in [(1, 1, 1.0), (1, 0, 0.5), (2, 1, 2.0), (4, 0, 1.0)] {
        let settings = settings(View::LightCount).changed(|s| {
            s.lgh.interleave = interleave;
            s.lgh.first_level = first_level;
            s.lgh.alpha = alpha;
        });
        // A light on a wall's own plane, or at the end of its reach, may be lost to rounding.
        let right =
            |v: Vec3, _: [u8; 3], count: f32, _: &[f32]| (v.x - count).abs() <= 1.0 + 0.02 * count && v.x == v.z;
        assert!(against_sums(&settings, right), "{interleave} {first_level} {alpha}");
        let shifted = |v: Vec3, p: [u8; 3], count: f32, l: &[f32]| right(v, p, 1.1 * count + 3.0, l);
        assert!(!against_sums(&settings, shifted), "a wrong count is noticed");
    }
}

#[test]
fn the_levels_share_the_lighting() {
    for (interleave, first_level) in [(1, 1), (1, 0), (2, 1), (4, 0)] {
        let settings = settings(View::LevelWeights).changed(|s| {
            s.lgh.interleave = interleave;
            s.lgh.first_level = first_level;
        });
        let right = |v: Vec3, picture: [u8; 3], _: f32, levels: &[f32]| {
            let total: f32 = levels.iter().sum();
            let mean = levels.iter().enumerate().map(|(l, s)| l as f32 * s).sum::<f32>() / total;
            let largest = levels.iter().fold(0.0, |most: f32, s| most.max(*s)) / total;
            let dominant = levels[v.y.max(0.0) as usize] / total;
            near(Vec3::new(v.x, dominant, v.z), Vec3::new(mean, largest, largest), 0.02) && mixes(picture, levels)
        };
        assert!(against_sums(&settings, right), "{interleave} {first_level}");
    }
}

/// Whether a colour is that of the levels mixed by their shares, which therefore sum to 1.
fn mixes(picture: [u8; 3], levels: &[f32]) -> bool {
    let decode = |v: u8| (f32::from(v) / 255.0 + 0.055).max(0.0) / 1.055;
    let linear = |[r, g, b]: [u8; 3]| Vec3::new(decode(r), decode(g), decode(b)).powf(2.4);
    let total: f32 = levels.iter().sum();
    let mixed: Vec3 = levels
        .iter()
        .zip(LEVEL_COLORS)
        .map(|(share, color)| {
            let [_, r, g, b] = color.to_be_bytes();
            linear([r, g, b]) * (*share / total)
        })
        .sum();
    near(linear(picture), mixed, 0.03)
}

#[test]
fn points_are_where_the_lights_are_and_hidden_ones_are_not() {
    let test = common::gpu();
    let scene = room();
    let bright = see(&test, &scene, &settings(View::Vpls).changed(|s| s.many_lights.vpls = 60));
    let covered = bright.values.iter().filter(|v| v.max_element() > 0.0).count();
    // Sixty discs of two pixels, about a third of them in front of the camera.
    assert!((10..400).contains(&covered), "{covered}");
    // Only flux and nothing: each coloured pixel has the hue of light that has met no wall or some.
    for v in bright.values.iter().filter(|v| v.max_element() > 0.0) {
        assert!(v.x > v.y && v.y > v.z, "{v}");
    }
    // The wall of a smaller room stands before the lights of none.
    let mut outside = room();
    outside.cameras[0].position_ws = Vec3::new(0.0, 0.0, -9.0);
    let none = see(&test, &outside, &settings(View::Vpls));
    assert!(none.values.iter().all(|v| *v == Vec3::ZERO));
    // From behind, through a wall that is drawn from both sides: what lies on its far side is hidden.
    outside.cameras[0].forward_ws = Vec3::Z;
    outside.cameras[0].right_ws = Vec3::NEG_X;
    outside.cameras[0].up_ws = Vec3::Y;
    let behind = see(&test, &outside, &settings(View::Vpls).changed(|s| s.many_lights.vpls = 20_000));
    let depth = see(&test, &outside, &settings(View::Depth));
    let wall = depth.values.iter().filter(|v| v.x > 0.0).count();
    let dots = behind.values.iter().filter(|v| v.max_element() > 0.0).count();
    assert!(wall > 0 && dots > wall / 2, "lights lie on the nearest wall: {dots} of {wall}");
}

#[test]
fn every_view_gives_values_and_a_picture() {
    let test = common::gpu();
    let mut scene = furnished_room();
    // Without one of its walls, so that light comes in from around.
    scene.environment = Some(Arc::new(Environment::uniform([1.0; 3])));
    scene.indices.drain(..6);
    scene.triangle_materials.drain(..2);
    scene.draws[0].index_count -= 6;
    let mut uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    uploaded.spread_points(&scene, Some(12)).unwrap();
    for view in View::value_variants() {
        let of_points = settings(*view).changed(|s| {
            s.render.technique = Technique::Pbgi;
            s.pbgi.points = 1 << 12;
        });
        let has_view = techniques::of(&of_points).unwrap().has_view(*view);
        let shown = if has_view { of_points } else { settings(*view) };
        let seen = see_uploaded(&test.gpu, &uploaded, &scene.cameras[0], &shown);
        assert!(seen.values.iter().any(|v| *v != seen.values[0]) || *view == View::Albedo, "{view:?} shows one value");
        assert!(seen.picture.iter().any(|p| *p != [0; 3]), "{view:?} is black");
    }
}

#[test]
fn values_that_are_no_numbers_are_noticed() {
    let mut values = vec![Vec3::ONE; 9];
    assert!(all_finite("view", &values).is_ok() && near(values[3], Vec3::ONE, 0.1));
    values[3].y = f32::NAN;
    assert!(all_finite("view", &values).is_err() && !near(values[3], Vec3::ONE, 0.1));
}

#[test]
fn views_that_are_not_there_are_refused() {
    let test = common::gpu();
    let scene = room();
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    for (settings, words) in [
        (settings(View::LightsTested).changed(|s| s.render.technique = Technique::Direct), ["direct", "lights-tested"]),
        (
            settings(View::ShadowRatio).changed(|s| s.many_lights.shadow_samples = 0),
            ["shadow-samples 0", "shadow-ratio"],
        ),
        (
            settings(View::ShadowRatioFiltered).changed(|s| s.lgh.filter = ShadowFilter::None),
            ["filter none", "shadow-ratio-filtered"],
        ),
        (settings(View::Vpls).changed(|s| s.render.technique = Technique::PathTrace), ["path-trace", "vpls"]),
    ] {
        let error = Renderer::new(&Job::new(&test.gpu, &uploaded, &scene.cameras[0], &settings)).err().unwrap();
        assert_eq!(error.exit_code(), 2, "{error}");
        assert!(words.iter().all(|word| error.to_string().contains(word)), "{error}");
    }
}

#[test]
fn the_program_writes_a_view_and_refuses_what_is_not_there() {
    let folder = tempfile::tempdir().unwrap();
    let options = ["--headless", "--validation", "--size", "80x45", "--vpls", "500", "--quiet"];
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (png, exr, none) = (path("a.png"), path("a.exr"), path("no.png"));
    support::succeed(&[&options[..], &["--view", "light-count", "--output", &png]].concat());
    assert_eq!(read_png(&png).map(|(w, h, rgb)| (w, h, rgb.len())).unwrap(), (80, 45, 3 * 80 * 45));
    support::succeed(&[&options[..], &["--view", "level-weights", "--output", &exr]].concat());
    let (width, height, values) = read_exr(&exr).unwrap();
    assert_eq!((width, height, values.len()), (80, 45, 3 * 80 * 45));
    assert!(values.iter().all(|v| v.is_finite()));
    let mut command = support::program();
    command.args(options).args(["--technique", "direct", "--view", "overdraw", "--output", &none]);
    let run = support::run(command);
    assert_eq!((run.code, run.stderr.lines().count()), (Some(2), 1), "{}", run.stderr);
    assert!(["direct", "lights-tested"].iter().all(|word| run.stderr.contains(word)), "{}", run.stderr);
    assert!(!std::path::Path::new(&none).exists());
}
