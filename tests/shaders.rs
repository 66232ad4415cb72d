//! The committed SPIR-V is that of the sources, and a driver accepts every module in every mode of the frame.

mod common;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

use clap::ValueEnum;
use glam::Vec3;
use gridlight::environment::Environment;
use gridlight::gpu::{Gpu, Work};
use gridlight::passes::lgh_shape::LghShape;
use gridlight::renderer::{Job, Renderer, UploadedScene};
use gridlight::scene::testing::box_room;
use gridlight::scene::{Light, Scene};
use gridlight::settings::{
    Antilag, Coverage, GridUpdate, IndirectSize, LevelBuild, Levels, LightSet, LightingMode, MicroFill, Rays,
    Reservoir, Selection, Settings, ShadowEstimate, ShadowFilter, Size, Switch, Technique, Temporal, View,
};
use gridlight::shader::{source, spirv};

fn shaders_dir() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders"))
}

/// Hash of each source by variant name.
fn source_hashes() -> BTreeMap<String, String> {
    source::all_sources(shaders_dir()).unwrap().into_iter().map(|s| (s.name.clone(), s.hash())).collect()
}

/// Names whose hashes differ or that only one side has.
fn stale(manifest: &BTreeMap<String, String>, sources: &BTreeMap<String, String>) -> Vec<String> {
    let names: BTreeSet<&String> = manifest.keys().chain(sources.keys()).collect();
    names.into_iter().filter(|name| manifest.get(*name) != sources.get(*name)).cloned().collect()
}

#[test]
fn the_committed_spirv_is_that_of_the_sources() {
    let text = std::fs::read_to_string(shaders_dir().join("spirv/manifest.json")).unwrap();
    let manifest: BTreeMap<String, String> = serde_json::from_str(&text).unwrap();
    let stale = stale(&manifest, &source_hashes());
    assert!(stale.is_empty(), "stale SPIR-V, run tools/compile-shaders: {stale:?}");
}

#[test]
fn every_variant_is_embedded_and_nothing_else() {
    let embedded: BTreeSet<String> = spirv::names().map(str::to_owned).collect();
    let sources: BTreeSet<String> = source_hashes().into_keys().collect();
    assert_eq!(embedded, sources, "run tools/compile-shaders");
}

#[test]
fn a_changed_missing_or_extra_source_is_stale() {
    let sources = source_hashes();
    let name = sources.keys().next().unwrap().clone();
    let mut changed = sources.clone();
    changed.insert(name.clone(), "0".repeat(64));
    assert_eq!(stale(&changed, &sources), std::slice::from_ref(&name));
    changed.remove(&name);
    assert_eq!(stale(&changed, &sources), std::slice::from_ref(&name));
    assert_eq!(stale(&sources, &changed), [name]);
}

/// A closed room with a lamp, in an environment: everything has indirect light.
fn room() -> Scene {
    let mut scene = box_room(4.0, Vec3::splat(0.6));
    scene.lights = vec![Light::Point { position_ws: Vec3::new(0.5, 1.2, -0.4), intensity: Vec3::splat(4.0) }];
    scene.environment = Some(Arc::new(Environment::uniform([0.5; 3])));
    let camera = &mut scene.cameras[0];
    camera.position_ws = Vec3::new(0.0, 0.0, 1.5);
    (camera.right_ws, camera.up_ws, camera.forward_ws) = (Vec3::X, Vec3::Y, Vec3::NEG_Z);
    camera.yfov_rad = 1.2;
    camera.near = 0.05;
    scene
}

/// The same with walls that shine.
fn shining_room() -> Scene {
    let mut scene = room();
    scene.materials[0].emission = [0.3, 0.2, 0.1];
    scene
}

fn small() -> Settings {
    Settings::default().changed(|s| {
        s.picture.size = Size { width: 48, height: 27 };
        s.many_lights.vpls = 500;
        s.lgh.levels = Levels::Fixed(3);
        s.pbgi.points = 4096;
    })
}

/// The ways in which lights reach pixels: volumes with each kind of reservoir, and gathering.
fn lightings(reservoirs: &[Reservoir]) -> Vec<(Option<LightingMode>, Option<Reservoir>)> {
    let volumes = reservoirs.iter().map(|reservoir| (Some(LightingMode::Volumes), Some(*reservoir)));
    volumes.chain([(Some(LightingMode::Gather), None)]).collect()
}

/// Every mode at least once; modes that meet in one pass in every combination.
fn modes(reservoirs: &[Reservoir]) -> Vec<Settings> {
    let mut modes = vec![
        small().changed(|s| {
            s.render.technique = Technique::Direct;
            s.render.accumulate = 2;
        }),
        small().changed(|s| {
            s.render.technique = Technique::PathTrace;
            s.path_trace.samples = 2;
        }),
        small().changed(|s| s.render.technique = Technique::BruteForce),
        small().changed(|s| s.render.technique = Technique::Pbgi),
        small().changed(|s| {
            s.render.technique = Technique::Pbgi;
            s.pbgi.micro = MicroFill::Points;
            s.pbgi.coverage = Coverage::Binary;
            s.pbgi.selection = Selection::Paper;
        }),
        small().changed(|s| {
            s.render.technique = Technique::Pbgi;
            s.pbgi.selection = Selection::Arrival;
            s.pbgi.reuse = Switch::On;
        }),
        small().changed(|s| {
            s.render.technique = Technique::Pbgi;
            s.pbgi.micro = MicroFill::Points;
            s.pbgi.reuse = Switch::On;
        }),
        small().changed(|s| {
            s.render.technique = Technique::Pbgi;
            s.pbgi.point_bounces = 3;
            s.pbgi.reuse = Switch::On;
        }),
        small().changed(|s| {
            s.render.technique = Technique::Pbgi;
            s.pbgi.micro = MicroFill::Points;
            s.pbgi.point_bounces = 2;
        }),
        small().changed(|s| s.render.technique = Technique::FinalGather),
        small().changed(|s| {
            s.render.technique = Technique::FinalGather;
            s.pbgi.micro = MicroFill::Points;
            s.many_lights.lights = LightSet::Both;
            s.many_lights.shadows = Switch::Off;
        }),
        small().changed(|s| s.render.technique = Technique::PbgiReference),
        small().changed(|s| {
            s.render.technique = Technique::BruteForce;
            s.many_lights.shadows = Switch::Off;
            s.render.direct = Switch::Off;
        }),
        small().changed(|s| s.many_lights.lights = LightSet::Scene),
        small().changed(|s| {
            s.many_lights.lights = LightSet::Both;
            s.lgh.levels = Levels::Auto;
        }),
    ];
    let mut others = [
        (LevelBuild::Gather, ShadowFilter::Atrous, 1),
        (LevelBuild::Scatter, ShadowFilter::None, 0),
        (LevelBuild::Cascade, ShadowFilter::Atrous, 0),
    ]
    .into_iter()
    .cycle();
    for interleave in [1, 2, 4] {
        for shadow_samples in [0, 1, 16] {
            for (lighting, reservoir) in lightings(reservoirs) {
                if let Some((build, filter, first_level)) = others.next() {
                    modes.push(small().changed(|s| {
                        s.lgh.interleave = interleave;
                        s.many_lights.shadow_samples = shadow_samples;
                        s.lgh.lighting = lighting;
                        s.lgh.reservoir = reservoir;
                        s.lgh.build = build;
                        s.lgh.filter = filter;
                        s.lgh.first_level = first_level;
                    }));
                }
            }
        }
    }
    for estimate in ShadowEstimate::value_variants() {
        for (lighting, reservoir) in lightings(reservoirs) {
            for filter in ShadowFilter::value_variants() {
                modes.push(small().changed(|s| {
                    s.lgh.interleave = 2;
                    s.lgh.lighting = lighting;
                    s.lgh.reservoir = reservoir;
                    s.lgh.filter = *filter;
                    s.lgh.shadow_estimate = Some(*estimate);
                }));
            }
        }
    }
    for temporal in [Temporal::Shadows, Temporal::Indirect] {
        for estimate in ShadowEstimate::value_variants() {
            modes.push(small().changed(|s| {
                s.lgh.temporal = Some(temporal);
                s.lgh.antilag = if temporal == Temporal::Shadows { Antilag::Tiles } else { Antilag::Off };
                s.lgh.shadow_estimate = Some(*estimate);
            }));
        }
        modes.push(small().changed(|s| {
            s.lgh.indirect_size = IndirectSize::Half;
            s.lgh.temporal = Some(temporal);
        }));
    }
    modes.push(small().changed(|s| {
        (s.lgh.first_level, s.lgh.temporal, s.lgh.temporal_rounds) = (0, Some(Temporal::Shadows), Some(2));
    }));
    modes.push(small().changed(|s| s.lgh.indirect_size = IndirectSize::Half));
    modes.push(small().changed(|s| s.lgh.grid_update = GridUpdate::Check));
    modes.push(small().changed(|s| s.render.taa = Switch::On));
    for (build, filter, first_level) in
        [(LevelBuild::Gather, ShadowFilter::None, 0), (LevelBuild::Scatter, ShadowFilter::Atrous, 1)]
    {
        for shadow_samples in [0, 4] {
            modes.push(small().changed(|s| {
                s.lgh.build = build;
                s.lgh.filter = filter;
                s.lgh.first_level = first_level;
                s.many_lights.shadow_samples = shadow_samples;
            }));
        }
    }
    for view in View::value_variants().iter().filter(|view| **view != View::Final) {
        let shown = small().changed(|s| s.render.view = *view);
        if gridlight::techniques::check(&shown).is_err() {
            modes.push(shown.changed(|s| s.render.technique = Technique::Pbgi));
            continue;
        }
        for (lighting, reservoir) in lightings(reservoirs) {
            modes.push(small().changed(|s| {
                s.render.view = *view;
                s.lgh.lighting = lighting;
                s.lgh.reservoir = reservoir;
            }));
        }
    }
    modes
}

/// What surfaces that shine have to do with: every technique, and the G-buffer with and without motion.
fn shining_modes() -> Vec<Settings> {
    let techniques = Technique::value_variants().iter();
    let mut modes: Vec<_> = techniques.map(|technique| small().changed(|s| s.render.technique = *technique)).collect();
    modes.push(small().changed(|s| s.lgh.temporal = Some(Temporal::Indirect)));
    modes.push(small().changed(|s| {
        s.render.technique = Technique::Pbgi;
        s.pbgi.micro = MicroFill::Points;
    }));
    modes
}

/// Renders two frames; gives the names of the shaders that ran.
fn render(
    gpu: &Arc<Gpu>,
    scene: &UploadedScene,
    camera: &gridlight::scene::Camera,
    settings: &Settings,
) -> BTreeSet<String> {
    let mut renderer = Renderer::new(&Job::new(gpu, scene, camera, settings)).unwrap();
    let (count_lights_tested, inspect) = (settings.lgh.first_level == 0, settings.many_lights.shadow_samples != 1);
    if count_lights_tested || inspect {
        let mut shapes = renderer.shapes().clone();
        shapes.frame.inspect = inspect;
        if let Some(lgh) = shapes.of_mut::<LghShape>() {
            lgh.count_lights_tested = count_lights_tested;
        }
        renderer = Renderer::with_shapes(&Job::new(gpu, scene, camera, settings), shapes).unwrap();
    }
    for _ in 0..2 {
        let ticket = renderer.submit().unwrap();
        renderer.wait(ticket).unwrap();
    }
    let radiance = renderer.read_radiance().unwrap();
    let lowest = if matches!(settings.render.view, View::Normal | View::SelectedLevel | View::LevelWeights) {
        -1.0
    } else {
        0.0
    };
    assert!(radiance.iter().all(|value| value.is_finite() && *value >= lowest), "{settings:?}");
    assert!(radiance.iter().any(|value| *value > 0.0), "black: {settings:?}");
    let messages = gpu.validation_messages();
    assert!(messages.is_empty(), "{settings:?}: {messages:#?}");
    let mut names = BTreeSet::new();
    for pass in renderer.executor().graph().passes() {
        match &pass.payload {
            Work::Compute(work) => drop(names.insert(work.shader.clone())),
            Work::Raster(work) => {
                names.extend(work.draws.iter().flat_map(|d| [d.vertex.clone(), d.fragment.clone()]));
            }
            Work::Transfer(_) | Work::BuildStructure { .. } | Work::Overlay => {}
        }
    }
    names
}

/// Every pass that traces rays, by ray queries.
fn query_modes(reservoirs: &[Reservoir]) -> Vec<Settings> {
    let lgh = reservoirs.iter().map(|reservoir| small().changed(|s| s.lgh.reservoir = Some(*reservoir)));
    let of_points = [Technique::Pbgi, Technique::FinalGather];
    let points = modes(&[]).into_iter().filter(move |settings| of_points.contains(&settings.render.technique));
    let others = [Technique::PathTrace, Technique::BruteForce, Technique::PbgiReference]
        .map(|technique| small().changed(|s| s.render.technique = technique));
    lgh.chain(others).chain(points).map(|settings| settings.changed(|s| s.tracing.rays = Rays::Query)).collect()
}

/// Renders a scene in some modes; gives the names of the shaders that ran.
fn render_modes(gpu: &Arc<Gpu>, scene: &Scene, modes: &[Settings]) -> BTreeSet<String> {
    let rays = if gpu.features().ray_query { Rays::Query } else { Rays::Bvh };
    let mut uploaded = UploadedScene::with_rays(gpu, scene, rays).unwrap();
    uploaded.spread_points(scene, Some(12)).unwrap();
    modes.iter().flat_map(|settings| render(gpu, &uploaded, &scene.cameras[0], settings)).collect()
}

fn render_all(gpu: &Arc<Gpu>, reservoirs: &[Reservoir]) -> BTreeSet<String> {
    let (mut modes, mut shining) = (modes(reservoirs), shining_modes());
    if gpu.features().ray_query {
        modes.extend(query_modes(reservoirs));
        shining.extend(shining_modes().into_iter().map(|settings| settings.changed(|s| s.tracing.rays = Rays::Query)));
    }
    let mut names = render_modes(gpu, &room(), &modes);
    names.extend(render_modes(gpu, &shining_room(), &shining));
    names
}

#[test]
fn every_module_runs_in_some_mode() {
    let test = common::gpu();
    let exact = test.gpu.features().int64_atomics;
    let reservoirs = [Reservoir::Race, Reservoir::Lock, Reservoir::Exact];
    let used = render_all(&test.gpu, &reservoirs[..if exact { 3 } else { 2 }]);
    // Only frames of a window have these: tests/window.rs runs them.
    let in_a_window = |name: &str| name.starts_with("present/");
    // What is learnt before the first frame needs these: tests/large_ground.rs runs them.
    let before_frames = |name: &str| name.starts_with("light_starts/");
    // Scenes whose vertices move need this: tests/temporal runs it.
    let of_moving = |name: &str| name.ends_with("_motion_vertices.vert");
    // What moves such a scene between frames: tests/scene_mover.rs runs it.
    let between_frames = |name: &str| name.starts_with("motion/") || name.starts_with("refit/");
    // Passes of tests have these: tests/graph_on_gpu.rs runs them.
    let in_tests = |name: &str| name.starts_with("tests/");
    let query = test.gpu.features().ray_query;
    let can_run = |name: &str| (exact || !name.contains("_exact")) && (query || !name.contains("_query"));
    let unused: Vec<&str> = spirv::names()
        .filter(|name| {
            let elsewhere =
                [in_a_window(name), before_frames(name), of_moving(name), between_frames(name), in_tests(name)];
            !used.contains(*name) && !elsewhere.contains(&true) && can_run(name)
        })
        .collect();
    assert!(unused.is_empty(), "no mode of the frame uses {unused:?}");
}

fn lgh_shape(renderer: &Renderer) -> &LghShape {
    renderer.shapes().of().unwrap()
}

#[test]
fn the_fallbacks_of_the_baseline_run() {
    let test = common::baseline_gpu();
    let used = render_all(&test.gpu, &[Reservoir::Lock]);
    assert!(!used.iter().any(|name| name.contains("_exact")), "{used:?}");
    assert!(used.contains("light_volumes/shade_light_volume_lock.frag"));
    let scene = room();
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    let gathered = Renderer::new(&Job::new(&test.gpu, &uploaded, &scene.cameras[0], &small())).unwrap();
    assert_eq!(lgh_shape(&gathered).reservoir, Reservoir::Exact);
    let volumes = small().changed(|s| s.lgh.lighting = Some(LightingMode::Volumes));
    let defaults = Renderer::new(&Job::new(&test.gpu, &uploaded, &scene.cameras[0], &volumes)).unwrap();
    assert_eq!(lgh_shape(&defaults).reservoir, Reservoir::Lock);
    assert_eq!(lgh_shape(&defaults).lighting_format, ash::vk::Format::R16G16B16A16_SFLOAT);
    let exact = volumes.changed(|s| s.lgh.reservoir = Some(Reservoir::Exact));
    let error = Renderer::new(&Job::new(&test.gpu, &uploaded, &scene.cameras[0], &exact)).err().unwrap();
    assert_eq!(error.exit_code(), 2, "{error}");
    let query = small().changed(|s| s.tracing.rays = Rays::Query);
    let error = Renderer::new(&Job::new(&test.gpu, &uploaded, &scene.cameras[0], &query)).err().unwrap();
    assert_eq!(error.exit_code(), 2, "{error}");
    assert!(error.to_string().contains("--rays query needs VK_KHR_ray_query"), "{error}");
}
