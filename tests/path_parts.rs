//! Light paths that are traced in parts, as their slots do not fit into memory at once, leave the same lights bit for bit.

mod common;

use common::rooms::lamp_room;
use glam::Vec3;
use gridlight::passes::lgh_shape::LghShape;
use gridlight::renderer::{Job, Renderer, UploadedScene};
use gridlight::scene::Scene;
use gridlight::settings::{LightSet, Settings, Size};
use gridlight::techniques::lgh::HierarchyOutputs;

/// What a frame leaves: counts of lights, the lights themselves, rays, the picture.
#[derive(PartialEq)]
struct Frame {
    counts: Vec<u32>,
    lights: [Vec<u32>; 2],
    radiance: Vec<f32>,
    traced: Vec<String>,
}

fn render(test: &common::GpuTest, scene: &Scene, slots_at_once: Option<u32>) -> Frame {
    let uploaded = UploadedScene::new(&test.gpu, scene).unwrap();
    let settings = Settings::default().changed(|s| {
        s.picture.size = Size { width: 32, height: 24 };
        (s.many_lights.vpls, s.many_lights.bounces) = (3000, 3);
        s.many_lights.lights = LightSet::Both;
    });
    let job = Job::new(&test.gpu, &uploaded, &scene.cameras[0], &settings);
    let mut shapes = Renderer::new(&job).unwrap().shapes().clone();
    if let Some(slots_at_once) = slots_at_once {
        shapes.of_mut::<LghShape>().unwrap().lights.slots_at_once = slots_at_once;
    }
    let mut renderer = Renderer::with_shapes(&job, shapes).unwrap();
    let ticket = renderer.submit().unwrap();
    renderer.wait(ticket).unwrap();
    let lights = renderer.outputs().technique.of::<HierarchyOutputs>().unwrap().lights;
    let read = |buffer| bytemuck::pod_collect_to_vec(&renderer.executor().read_buffer(buffer).unwrap());
    let counts: Vec<u32> = read(lights.counts);
    let in_use = |mut words: Vec<u32>| {
        words.truncate(4 * counts[0] as usize);
        words
    };
    let names = renderer.executor().graph().passes().iter().map(|pass| pass.name.clone());
    Frame {
        lights: [lights.positions, lights.fluxes].map(|buffer| in_use(read(buffer))),
        radiance: renderer.read_radiance().unwrap(),
        traced: names.filter(|name| name.starts_with("vpl_trace")).collect(),
        counts,
    }
}

#[test]
fn paths_in_parts_leave_the_same_lights_and_picture() {
    let test = common::gpu();
    let scene = lamp_room(Vec3::splat(0.6));
    let whole = render(&test, &scene, None);
    assert_eq!(whole.traced, ["vpl_trace"]);
    assert!(whole.counts[1] > 2000 && whole.counts[0] > whole.counts[1], "VPLs and lamps: {:?}", whole.counts);
    let mut part_counts = Vec::new();
    for slots_at_once in [96, 500, 1500] {
        let parts = render(&test, &scene, Some(slots_at_once));
        part_counts.push(parts.traced.len());
        assert_eq!(parts.traced.last().unwrap(), &format!("vpl_trace/{}", parts.traced.len()));
        assert_eq!(parts.counts, whole.counts, "{slots_at_once}");
        assert!(parts.lights == whole.lights, "{slots_at_once} slots at once: other lights");
        assert!(parts.radiance == whole.radiance, "{slots_at_once} slots at once: another picture");
    }
    assert!(part_counts.windows(2).all(|p| p[0] > p[1]) && part_counts[2] > 1, "{part_counts:?} parts");
}

/// Other lights would be noticed: those of another surface colour.
#[test]
fn other_lights_are_noticed() {
    let test = common::gpu();
    let whole = render(&test, &lamp_room(Vec3::splat(0.6)), None);
    let other = render(&test, &lamp_room(Vec3::splat(0.5)), Some(1000));
    assert!(whole.lights != other.lights && whole.radiance != other.radiance);
}
