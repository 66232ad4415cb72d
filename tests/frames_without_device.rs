//! Every frame against the interfaces of its shaders, without a device: all techniques, modes and views.

mod common;

use std::collections::BTreeSet;

use clap::ValueEnum;
use common::hierarchy::{Options, frame_shape, shape};
use gridlight::frame;
use gridlight::gpu::{Work, check_interfaces};
use gridlight::graph::{Graph, plan};
use gridlight::passes::half_picture::halved;
use gridlight::passes::lgh_shape::LghShape;
use gridlight::passes::present::{self, Part, WindowFormat};
use gridlight::passes::temporal::{Estimated, Reuse};
use gridlight::passes::{AreaLightShape, FrameShape, SurfaceMotion};
use gridlight::settings::{
    Antilag, CenterWeight, FirstLevelBuild, GridUpdate, IndirectSize, LevelBuild, LightingMode, Rays, Reservoir,
    ShadowFilter, ShadowPoints, View,
};
use gridlight::techniques::brute_force::BruteForceShape;
use gridlight::techniques::direct::Direct;
use gridlight::techniques::path_trace::PathTraceShape;
use gridlight::techniques::{Shapes, TechniqueShape};

/// A frame, for a window where it has a picture of its own to show there.
fn build(frame: &FrameShape, technique: &dyn TechniqueShape) -> Graph<Work> {
    let shapes = Shapes { frame: frame.clone(), technique: technique.boxed() };
    let (mut graph, outputs) = frame::build(&shapes);
    if frame.view == View::Final {
        present::publish(&mut graph, outputs.tone_mapped.picture);
    }
    graph
}

fn check(frame: &FrameShape, technique: &dyn TechniqueShape) {
    let graph = build(frame, technique);
    plan(&graph).unwrap_or_else(|error| panic!("{frame:?}, {technique:?}: {error}"));
    check_interfaces(&graph).unwrap_or_else(|error| panic!("{frame:?}, {technique:?}: {error}"));
}

fn hierarchy(build: LevelBuild, interleave: u32, first_level: u32) -> LghShape {
    let center = CenterWeight::Intensity;
    let options = Options { top: 4, build, center, interleave, first_level, light_capacity: 1000, grid_capacity: None };
    shape(options)
}

/// Shapes of the hierarchy, each mode with each other that it meets in a shader.
fn hierarchies() -> Vec<LghShape> {
    let mut shapes = Vec::new();
    for build in [LevelBuild::Cascade, LevelBuild::Gather, LevelBuild::Scatter] {
        for (interleave, first_level, shadow_samples) in [(1, 0, 1), (2, 1, 0), (4, 1, 16), (1, 0, 0), (2, 0, 1)] {
            let mut shape = hierarchy(build, interleave, first_level);
            shape.lights.shadow_samples = shadow_samples;
            shape.count_lights_tested = first_level == 0;
            shape.filter = if interleave == 2 { ShadowFilter::None } else { ShadowFilter::Atrous };
            shape.shadow_points = if interleave == 4 { ShadowPoints::Deviation } else { ShadowPoints::Descent };
            let gathered = LghShape { lighting: LightingMode::Gather, reservoir: Reservoir::Exact, ..shape.clone() };
            let picture_px = halved(gathered.picture_px);
            shapes.push(LghShape { indirect_size: IndirectSize::Half, picture_px, ..gathered.clone() });
            shapes.push(gathered);
            for reservoir in [Reservoir::Race, Reservoir::Lock, Reservoir::Exact] {
                shapes.push(LghShape { lighting: LightingMode::Volumes, reservoir, ..shape.clone() });
            }
        }
    }
    let atomic = LghShape { scatter: FirstLevelBuild::Atomic, ..hierarchy(LevelBuild::Cascade, 1, 1) };
    shapes.push(atomic);
    for (grid_update, first_level) in [(GridUpdate::Auto, 1), (GridUpdate::Auto, 0), (GridUpdate::Check, 1)] {
        shapes.push(LghShape { grid_update, ..hierarchy(LevelBuild::Cascade, 1, first_level) });
    }
    shapes
}

/// Frames that take something over from those before.
fn following() -> Vec<(SurfaceMotion, LghShape)> {
    let modes = [(Estimated::Shadows, Antilag::Tiles), (Estimated::Light, Antilag::Off)];
    let modes = modes.into_iter().zip([SurfaceMotion::Camera, SurfaceMotion::Vertices]);
    let shapes = modes.flat_map(|((of, antilag), motion)| {
        let shapes = hierarchies().into_iter().filter(|shape| shape.lights.shadow_samples > 0);
        shapes.map(move |shape| {
            let has_rounds = shape.lighting == LightingMode::Gather && shape.interleave == 1;
            let rounds = if has_rounds { 3 } else { 1 };
            let reuse = Some(Reuse { of, least_weight: 0.05, antilag, step_px: shape.interleave, rounds });
            (motion, LghShape { reuse, ..shape })
        })
    });
    shapes.collect()
}

#[test]
fn a_window_shows_a_picture_or_none() {
    let window = WindowFormat { format: ash::vk::Format::B8G8R8A8_UNORM, driver_encodes: false };
    for part in [Part::Whole, Part::Left, Part::Right] {
        for has_picture in [true, false] {
            let graph = present::show(window, part, has_picture);
            plan(&graph).unwrap();
            check_interfaces(&graph).unwrap();
        }
    }
}

#[test]
fn every_frame_fits_its_shaders() {
    let lights = hierarchy(LevelBuild::Cascade, 1, 1).lights;
    let references = [0, 1].map(|shadow_samples| {
        let mut lights = lights.clone();
        (lights.path_count, lights.bounces, lights.shadow_samples) = (100, 2, shadow_samples);
        BruteForceShape(lights)
    });
    for rays in [Rays::Bvh, Rays::Query] {
        for inspect in [false, true] {
            let environment = Some(AreaLightShape { samples: 4, is_filtered: inspect, reuse: None });
            let emitters = environment.filter(|_| inspect);
            let (accumulate, direct, has_emission) = (inspect, !inspect, emitters.is_some());
            let lit = FrameShape { environment, emitters, has_emission, ..frame_shape() };
            let frame = FrameShape { rays, inspect, accumulate, direct: direct || has_emission, ..lit };
            hierarchies().iter().for_each(|shape| check(&frame, shape));
            following().iter().for_each(|(motion, shape)| {
                let reusing = |light: Option<AreaLightShape>| light.map(|l| AreaLightShape { reuse: shape.reuse, ..l });
                let (environment, emitters) = (reusing(environment), reusing(emitters));
                let (surface_motion, taa) = (Some(*motion), !inspect);
                check(&FrameShape { surface_motion, taa, environment, emitters, ..frame.clone() }, shape);
            });
            references.iter().for_each(|shape| check(&frame, shape));
            check(&frame, &PathTraceShape { samples: 4 });
            check(&frame, &Direct);
        }
    }
}

#[test]
fn every_view_fits_its_shaders() {
    for view in View::value_variants() {
        let environment = Some(AreaLightShape { samples: 4, is_filtered: true, reuse: None });
        let surface_motion = (*view == View::MotionVectors).then_some(SurfaceMotion::Vertices);
        let frame = FrameShape { view: *view, inspect: true, environment, surface_motion, ..frame_shape() };
        for mut shape in hierarchies() {
            shape.lights.shadow_samples = shape.lights.shadow_samples.max(1);
            check(&frame, &shape);
        }
    }
}

/// Names of passes without their steps, of frames with every technique and mode.
fn names_of_passes() -> BTreeSet<String> {
    let environment = Some(AreaLightShape { samples: 4, is_filtered: false, reuse: None });
    let lit = FrameShape { environment, emitters: environment, has_emission: true, ..frame_shape() };
    let frame = FrameShape { inspect: true, accumulate: true, ..lit };
    let view = FrameShape { view: View::Normal, ..frame_shape() };
    let mut graphs: Vec<_> = hierarchies().iter().map(|shape| build(&frame, shape)).collect();
    let moving = FrameShape { surface_motion: Some(SurfaceMotion::Camera), taa: true, ..frame.clone() };
    graphs.extend(following().iter().map(|(_, shape)| build(&moving, shape)));
    graphs.push(build(&frame, &BruteForceShape(hierarchy(LevelBuild::Cascade, 1, 1).lights)));
    graphs.push(build(&frame, &PathTraceShape { samples: 4 }));
    graphs.push(build(&view, &Direct));
    let names = graphs.iter().flat_map(|graph| graph.passes()).map(|pass| pass.name.split('/').next().unwrap());
    names.map(str::to_owned).collect()
}

/// Passes that the table of passes or the page about porting does not have.
fn missing_on_pages(names: &BTreeSet<String>) -> Vec<&str> {
    let table = include_str!("../docs/passes.md");
    let headings: Vec<&str> =
        include_str!("../docs/porting.md").lines().filter(|line| line.starts_with("### ")).collect();
    let is_missing = |name: &str| {
        let name = format!("`{name}`");
        !table.contains(&name) || !headings.iter().any(|heading| heading.contains(&name))
    };
    names.iter().map(String::as_str).filter(|name| is_missing(name)).collect()
}

#[test]
fn every_pass_is_in_the_table_and_on_the_page_about_porting() {
    let mut names = names_of_passes();
    assert!(names.contains("light_gather") && names.contains("debug_view") && names.len() > 20, "{names:?}");
    assert_eq!(missing_on_pages(&names), [""; 0]);
    names.insert("nowhere".to_owned());
    assert_eq!(missing_on_pages(&names), ["nowhere"]);
}
