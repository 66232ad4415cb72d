//! A sunlit room on a ground much larger than it: hardly any light path would reach the room, were they to start anywhere.

mod common;

use std::ops::ControlFlow;

use common::rooms::{add_quad, camera};
use glam::Vec3;
use gridlight::passes::lgh_shape::LghShape;
use gridlight::renderer::{Job, Renderer, UploadedScene};
use gridlight::scene::testing::{diffuse, scene_from_quads};
use gridlight::scene::{Light, Scene, gltf};
use gridlight::settings::{Settings, Size, Switch, Technique, VplImportance};
use gridlight::shared::StartCell;

/// How far the indirect light may be off.
const ENERGY: f64 = 0.05;

/// A floor, two walls and a ceiling, open to the sun, on a ground of this edge.
fn room_on_ground(edge: f32) -> Scene {
    let h = 0.5 * edge;
    let ground = [[-h, h], [h, h], [h, -h], [-h, -h]].map(|[x, z]| Vec3::new(x, -0.2, z));
    let mut scene = scene_from_quads("terrace", &[ground], diffuse("white", Vec3::splat(0.7)));
    let p = Vec3::new;
    add_quad(&mut scene, [p(-2.0, 0.0, 2.0), p(2.0, 0.0, 2.0), p(2.0, 0.0, -2.0), p(-2.0, 0.0, -2.0)]);
    add_quad(&mut scene, [p(-2.0, 0.0, -2.0), p(2.0, 0.0, -2.0), p(2.0, 3.0, -2.0), p(-2.0, 3.0, -2.0)]);
    add_quad(&mut scene, [p(-2.0, 0.0, 2.0), p(-2.0, 0.0, -2.0), p(-2.0, 3.0, -2.0), p(-2.0, 3.0, 2.0)]);
    add_quad(&mut scene, [p(-2.0, 3.0, -2.0), p(2.0, 3.0, -2.0), p(2.0, 3.0, 2.0), p(-2.0, 3.0, 2.0)]);
    scene.bounds.max.y = 3.0;
    let direction_ws = p(-0.2, -0.5, -0.85).normalize();
    scene.lights = vec![Light::Directional { direction_ws, irradiance: Vec3::splat(3.0) }];
    scene.cameras = vec![camera(p(0.6, 1.5, 3.5), p(-0.1, 0.1, -1.0).normalize(), 0.7)];
    scene
}

fn render(scene: &Scene, technique: Technique, importance: VplImportance) -> Vec<f32> {
    let settings = Settings::default().changed(|s| {
        s.render.technique = technique;
        s.render.direct = Switch::Off;
        s.picture.size = Size { width: 32, height: 18 };
        s.many_lights.vpls = 3000;
        s.many_lights.vpl_importance = importance;
        s.path_trace.samples = 512;
    });
    let test = common::gpu();
    let uploaded = UploadedScene::new(&test.gpu, scene).unwrap();
    let mut renderer = Renderer::new(&Job::new(&test.gpu, &uploaded, &scene.cameras[0], &settings)).unwrap();
    renderer.run_in_steps(200.0, &mut |_, _| ControlFlow::Continue(())).unwrap();
    let radiance = renderer.read_radiance().unwrap();
    let messages = test.gpu.validation_messages();
    assert!(messages.is_empty(), "{messages:#?}");
    radiance
}

/// Whether a picture has as much light as another.
fn same_light(found: &[f32], expected: &[f32]) -> Result<(), String> {
    let sum = |picture: &[f32]| picture.iter().map(|value| f64::from(*value)).sum::<f64>();
    let energy = sum(found) / sum(expected);
    if (energy - 1.0).abs() <= ENERGY { Ok(()) } else { Err(format!("energy {energy}")) }
}

#[test]
fn a_room_on_a_kilometre_of_ground_keeps_its_light() {
    let scene = room_on_ground(1000.0);
    let expected = render(&scene, Technique::PathTrace, VplImportance::View);
    same_light(&render(&scene, Technique::BruteForce, VplImportance::View), &expected).unwrap();
    // The fault: with starts anywhere no path comes into the room, or one much too bright.
    let anywhere = render(&scene, Technique::BruteForce, VplImportance::None);
    same_light(&anywhere, &expected).unwrap_err();
    same_light(&vec![f32::NAN; expected.len()], &expected).unwrap_err();
}

#[test]
fn where_all_is_near_nothing_changes() {
    let scene = room_on_ground(6.0);
    for technique in [Technique::BruteForce, Technique::Lgh] {
        let chosen = render(&scene, technique, VplImportance::View);
        assert!(chosen == render(&scene, technique, VplImportance::None), "{technique:?}");
    }
    let far = room_on_ground(1000.0);
    let [view, none] = [VplImportance::View, VplImportance::None].map(|i| render(&far, Technique::BruteForce, i));
    assert!(view != none, "the option arrives");
}

/// Where paths start in the built-in scene while an animation of it plays, learnt at a moment.
fn starts(animation: &str, moment_s: f64) -> Vec<StartCell> {
    let glb = include_bytes!("../assets/courtyard.glb");
    let mut scene = gltf::load_scene_of("courtyard", glb, "courtyard in motion", &|_, _, _| ()).unwrap();
    scene.play(Some(animation)).unwrap();
    scene.pose(moment_s);
    let test = common::gpu();
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    let settings = Settings::default().changed(|s| {
        s.picture.size = Size { width: 32, height: 18 };
        s.many_lights.vpls = 3000;
    });
    let camera = scene.cameras.iter().find(|camera| camera.name == "court").unwrap();
    let renderer = Renderer::new(&Job::new(&test.gpu, &uploaded, camera, &settings)).unwrap();
    let shape = renderer.shapes().of::<LghShape>().unwrap();
    shape.lights.starts.as_ref().map(|starts| starts.cells.clone()).unwrap_or_default()
}

/// The lamp of `switch` shines from the first second on.
#[test]
fn a_lamp_that_is_dark_at_first_has_starts_of_its_own() {
    let [dark, shining] = [0.5, 1.5].map(|moment_s| starts("switch", moment_s));
    assert!(dark.len() > 100, "{} cells", dark.len());
    assert!(dark == shining, "what is learnt depends on when");
    assert!(dark != starts("none", 0.5), "the lamp makes no difference");
}
