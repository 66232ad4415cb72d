//! Lights that a frame has no room for: counted, told, and no harm to the rest of the picture.

mod common;

use common::rooms::furnished_room;
use gridlight::passes::lgh_shape::LghShape;
use gridlight::renderer::{Job, Renderer, UploadedScene};
use gridlight::settings::{LevelBuild, LightingMode, Settings, Size, Technique};
use gridlight::techniques::{BruteForceShape, Shapes};

fn settings() -> Settings {
    Settings::default().changed(|s| {
        s.picture.size = Size { width: 37, height: 21 };
        s.many_lights.vpls = 2000;
    })
}

/// A rendered frame.
struct Rendered {
    /// What it says of lights without room.
    complaint: Option<String>,
    /// Virtual point lights with and without room.
    vpls: [u32; 2],
    /// Grid lights of all levels, the same.
    grid_lights: [u32; 2],
    radiance: Vec<f32>,
}

/// Renders a frame of a changed shape.
fn render(settings: &Settings, change: impl Fn(&mut Shapes)) -> Rendered {
    let test = common::gpu();
    let scene = furnished_room();
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    let job = Job::new(&test.gpu, &uploaded, &scene.cameras[0], settings);
    let mut shapes = Renderer::new(&job).unwrap().shapes().clone();
    change(&mut shapes);
    let mut renderer = Renderer::with_shapes(&job, shapes).unwrap();
    let ticket = renderer.submit().unwrap();
    renderer.wait(ticket).unwrap();
    let radiance = renderer.read_radiance().unwrap();
    assert!(radiance.iter().all(|v| v.is_finite() && *v >= 0.0), "the picture is no picture");
    let counters = renderer.read_counters().unwrap();
    let counts = counters.first().map_or(&[0; 4][..], Vec::as_slice);
    let table = counters.get(1).map_or(&[0][..], Vec::as_slice);
    let kept = table[..table.len() - 1].iter().skip(1).step_by(2).sum();
    let grid_lights = [kept, table[table.len() - 1]];
    Rendered { complaint: renderer.complaint().unwrap(), vpls: [counts[1], counts[2]], grid_lights, radiance }
}

#[test]
fn nothing_is_left_out_with_the_measured_room() {
    for technique in [Technique::Lgh, Technique::BruteForce, Technique::PathTrace, Technique::Direct] {
        let frame = render(&settings().changed(|s| s.render.technique = technique), |_| ());
        assert_eq!(frame.complaint, None, "{technique:?}");
        let has_lights = matches!(technique, Technique::Lgh | Technique::BruteForce);
        assert_eq!(frame.vpls[0] > 1000, has_lights, "{technique:?}: {:?}", frame.vpls);
        assert_eq!(frame.grid_lights[0] > 500, technique == Technique::Lgh, "{technique:?}: {:?}", frame.grid_lights);
    }
}

#[test]
fn vpls_without_room_are_told() {
    for technique in [Technique::Lgh, Technique::BruteForce] {
        let settings = settings().changed(|s| s.render.technique = technique);
        let whole = render(&settings, |_| ());
        let dark = render(&settings, |shapes| {
            if let Some(shape) = shapes.of_mut::<LghShape>() {
                shape.lights.vpl_capacity = 700;
            }
            if let Some(BruteForceShape(lights)) = shapes.of_mut() {
                lights.vpl_capacity = 700;
            }
        });
        assert_eq!(dark.vpls, [700, whole.vpls[0] - 700], "{technique:?}");
        let sentence = dark.complaint.unwrap();
        let numbers = format!("{} of {} virtual point lights had no room", dark.vpls[1], whole.vpls[0]);
        assert!(sentence.starts_with(&numbers) && sentence.contains("--vpls"), "{sentence}");
        let sum = |picture: &[f32]| picture.iter().sum::<f32>();
        assert!(sum(&dark.radiance) < sum(&whole.radiance), "{technique:?}: lights are left out, but not their light");
    }
}

#[test]
fn grid_lights_without_room_are_told() {
    for build in [LevelBuild::Cascade, LevelBuild::Gather, LevelBuild::Scatter] {
        for lighting in [LightingMode::Gather, LightingMode::Volumes] {
            let settings = settings().changed(|s| {
                s.lgh.build = build;
                s.lgh.lighting = Some(lighting);
            });
            let [all, _] = render(&settings, |_| ()).grid_lights;
            // Room for part of S1 alone, and for nearly all.
            for room in [all / 4, all * 9 / 10] {
                let what = format!("{build:?}, {lighting:?}, room for {room} of {all}");
                let frame = render(&settings, |shapes| {
                    let shape: &mut LghShape = shapes.of_mut().unwrap();
                    shape.grid_capacity = room;
                    shape.upper_capacity = shape.upper_capacity.min(room);
                });
                assert_eq!((frame.vpls[1], frame.grid_lights[0]), (0, room), "{what}");
                let sentence = frame.complaint.unwrap();
                let lost = frame.grid_lights[1];
                assert!(
                    lost > 0 && sentence.starts_with(&format!("{lost} of {} grid lights", lost + room)),
                    "{sentence}"
                );
            }
        }
    }
}
