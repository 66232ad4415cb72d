//! How far the automatic exposure follows into the dark: as far as the scene's faintest light calls for.

mod common;

use std::f32::consts::PI;
use std::sync::Arc;

use common::rooms::camera;
use glam::Vec3;
use gridlight::environment::Environment;
use gridlight::renderer::{Job, Renderer, UploadedScene};
use gridlight::scene::testing::{diffuse, scene_from_quads};
use gridlight::scene::{Light, Scene};
use gridlight::settings::{Exposure, Settings, Size, Technique};

/// Exposure that shows as middle grey what is ten stops below a white surface in irradiance 1.
const MOST: f32 = 0.18 * 1024.0 * PI;

fn sun(irradiance: f32) -> Light {
    Light::Directional { direction_ws: Vec3::NEG_Y, irradiance: Vec3::splat(irradiance) }
}

/// A point light of the flux that such a sun has in a scene of this radius.
fn lamp(irradiance: f32, scene_radius: f32) -> Light {
    let intensity = Vec3::splat(0.25 * irradiance * scene_radius * scene_radius);
    Light::Point { position_ws: Vec3::Y, intensity }
}

/// A floor that fills the picture, seen from above.
fn floor(albedo: f32, lights: &[Light]) -> Scene {
    let floor = [[-8.0, 8.0], [8.0, 8.0], [8.0, -8.0], [-8.0, -8.0]].map(|[x, z]| Vec3::new(x, 0.0, z));
    let mut scene = scene_from_quads("floor", &[floor], diffuse("grey", Vec3::splat(albedo)));
    scene.cameras = vec![camera(2.0 * Vec3::Y, Vec3::NEG_Y, 1.0)];
    scene.lights = lights.to_vec();
    scene
}

fn settings() -> Settings {
    Settings::default().changed(|s| {
        s.render.technique = Technique::Direct;
        s.picture.size = Size { width: 16, height: 9 };
    })
}

fn with_job<T>(scene: &Scene, settings: &Settings, ask: impl FnOnce(&Job<'_>) -> T) -> T {
    let test = common::gpu();
    let uploaded = UploadedScene::new(&test.gpu, scene).unwrap();
    ask(&Job::new(&test.gpu, &uploaded, &scene.cameras[0], settings))
}

fn most(lights: &[Light]) -> f32 {
    with_job(&floor(0.5, lights), &settings(), |job| job.most_exposure())
}

/// The exposure of a rendered frame, and whether it is the most.
fn rendered(scene: &Scene, settings: &Settings) -> (f32, bool) {
    with_job(scene, settings, |job| {
        let mut renderer = Renderer::new(job).unwrap();
        let ticket = renderer.submit().unwrap();
        renderer.wait(ticket).unwrap();
        let exposure = renderer.read_exposure().unwrap();
        (exposure.unwrap(), job.is_most_exposed(exposure))
    })
}

fn is_near(found: f32, expected: f32, relative: f32) -> bool {
    (found / expected - 1.0).abs() <= relative
}

#[test]
fn the_most_follows_from_the_faintest_light_that_shines() {
    let radius = floor(0.5, &[]).bounds.radius();
    // Fluxes pass through a share in single precision.
    let is = |lights: &[Light], expected: f32| is_near(most(lights), expected, 1e-5);
    assert!(is(&[sun(1.0)], MOST));
    assert!(!is(&[sun(1.0)], 1.001 * MOST));
    // The moon's light is as good as the sun's.
    assert!(is(&[sun(1e-6)], 1e6 * MOST));
    // A lamp beside the sun, and another that is off.
    assert!(is(&[sun(1.0), lamp(1e-3, radius)], 1e3 * MOST));
    assert!(is(&[sun(1e-3), lamp(1.0, radius)], 1e3 * MOST));
    assert!(is(&[sun(1.0), lamp(0.0, radius)], MOST));
    // Without any light there is none.
    assert_eq!(most(&[sun(0.0)]), f32::MAX);
}

#[test]
fn an_environment_is_one_of_the_lights() {
    let sky = Environment::uniform([0.01; 3]);
    let mut scene = floor(0.5, &[sun(1.0)]);
    scene.environment = Some(Arc::new(sky));
    let found = |scale: f32| {
        let settings = settings().changed(|s| s.environment.scale = scale);
        with_job(&scene, &settings, |job| job.most_exposure())
    };
    // One that is off is none, and a bright one is not the faintest.
    assert!(is_near(found(0.0), MOST, 1e-5) && is_near(found(1e4), MOST, 1e-5));
    // Radiance from all around; the image's texels are summed in single precision.
    let faint = MOST / (PI * 0.01);
    assert!(is_near(found(1.0), faint, 0.01) && is_near(found(0.1), 10.0 * faint, 0.01), "{}", found(1.0) / faint);
}

#[test]
fn a_night_is_exposed_like_a_day_and_what_is_all_but_black_stays_dark() {
    // A grey surface lies between middle grey and white, however faint its light; a bin is a sixteenth of a stop.
    let grey = |irradiance: f32| 0.18_f32.sqrt() / (0.5 * irradiance / PI);
    for irradiance in [1.0, 1e-6] {
        let (exposure, is_most) = rendered(&floor(0.5, &[sun(irradiance)]), &settings());
        assert!(is_near(exposure, grey(irradiance), 0.05) && !is_most, "{exposure} in {irradiance}");
    }
    // Twenty stops below a white surface.
    let black = floor(1e-6, &[sun(1.0)]);
    for compensation in [0.0, 1.5, -2.0] {
        let settings = settings().changed(|s| s.picture.exposure_compensation = compensation);
        let (exposure, is_most) = rendered(&black, &settings);
        assert!(is_near(exposure, compensation.exp2() * MOST, 1e-5) && is_most, "{exposure} with {compensation}");
    }
    // A given exposure is used as it is.
    let given = settings().changed(|s| s.picture.exposure = Exposure::Fixed(1e6));
    assert_eq!(rendered(&black, &given), (1e6, false));
}
