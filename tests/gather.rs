//! `light_gather` against `light_volumes` with exact reservoirs: the same lighting, the same picks.

mod common;

use common::compare::{Verdict, within};
use common::rooms::{camera, furnished_room, lamp_room};
use common::written::Written;
use glam::Vec3;
use gridlight::renderer::{Job, Renderer, UploadedScene};
use gridlight::scene::gltf;
use gridlight::scene::testing::{box_room, shared_dir};
use gridlight::scene::{Camera, Light, Scene};
use gridlight::settings::{LightSet, LightingMode, Reservoir, Settings, Size};

/// Relative difference of a pixel's lighting: sums of the same terms in another order.
const LIGHTING_TOLERANCE: f32 = 1e-4;
/// Share of reservoirs that may hold another light: near ties, as the two compilers round differently.
const OTHER_PICKS: f64 = 1e-3;

/// What lighting leaves behind, in the interleaved layout.
#[derive(Clone)]
struct Lit {
    /// Radiance per unit albedo; sum of weights.
    lighting: Vec<[f32; 4]>,
    /// The light of each reservoir.
    picks: Vec<u32>,
}

fn render(scene: &UploadedScene, camera: &Camera, settings: &Settings, lighting: LightingMode) -> Lit {
    let test = common::gpu();
    let reservoir = (settings.many_lights.shadow_samples > 0).then_some(Reservoir::Exact);
    let settings = settings.clone().changed(|s| {
        s.lgh.lighting = Some(lighting);
        s.lgh.reservoir = reservoir;
    });
    let renderer = Renderer::new(&Job::new(&test.gpu, scene, camera, &settings)).unwrap();
    let pass = match lighting {
        LightingMode::Volumes => "light_volumes",
        LightingMode::Gather => "light_gather",
    };
    let written = Written::by(&renderer);
    let words: Vec<[u32; 2]> = written.get(pass, "reservoirs").unwrap_or_default();
    let lit = Lit { lighting: written.all(pass, "lighting"), picks: words.iter().map(|[light, _]| *light).collect() };
    assert_eq!(lit.picks.len(), lit.lighting.len() * settings.many_lights.shadow_samples as usize);
    lit
}

fn compare(volumes: &Lit, gather: &Lit) -> Verdict {
    assert_eq!(volumes.lighting.len(), gather.lighting.len());
    assert_eq!(volumes.picks.len(), gather.picks.len());
    // Radiance by its brightest channel; the sum of weights by itself.
    let near = |a: &[f32; 4], b: &[f32; 4]| {
        let brightest = a[0].max(a[1]).max(a[2]);
        let scale = [brightest, brightest, brightest, a[3]];
        (0..4).all(|i| within(a[i] - b[i], LIGHTING_TOLERANCE * scale[i]))
    };
    let wrong = volumes.lighting.iter().zip(&gather.lighting).position(|(a, b)| !near(a, b));
    if let Some(pixel) = wrong {
        return Err(format!("lighting of {pixel}: {:?} {:?}", volumes.lighting[pixel], gather.lighting[pixel]));
    }
    let others = volumes.picks.iter().zip(&gather.picks).filter(|(a, b)| a != b).count();
    if others as f64 > OTHER_PICKS * volumes.picks.len() as f64 {
        return Err(format!("{others} of {} reservoirs hold another light", volumes.picks.len()));
    }
    Ok(())
}

/// Both ways of a scene; `None` where the device cannot do the volumes' reservoirs.
fn both(scene: &Scene, settings: &Settings) -> Option<(Lit, Lit)> {
    let (uploaded, exact) = {
        let test = common::gpu();
        (UploadedScene::new(&test.gpu, scene).unwrap(), test.gpu.features().int64_atomics)
    };
    if settings.many_lights.shadow_samples > 0 && !exact {
        println!("skipped: light volumes with exact reservoirs need 64-bit buffer atomics");
        return None;
    }
    let render = |mode| render(&uploaded, &scene.cameras[0], settings, mode);
    Some((render(LightingMode::Volumes), render(LightingMode::Gather)))
}

fn check(what: &str, scene: &Scene, settings: &Settings) {
    if let Some((volumes, gather)) = both(scene, settings) {
        let lit = volumes.lighting.iter().filter(|p| p[3] > 0.0 || p[0] > 0.0).count();
        assert!(lit > 0, "{what}: nothing is lit");
        compare(&volumes, &gather).unwrap_or_else(|error| panic!("{what}: {error}"));
    }
}

fn settings() -> Settings {
    Settings::default().changed(|s| {
        s.picture.size = Size { width: 65, height: 37 };
        s.many_lights.vpls = 2000;
    })
}

#[test]
fn gathering_equals_volumes_in_every_mode() {
    let scene = furnished_room();
    for interleave in [1, 2, 4] {
        for first_level in [0, 1] {
            let settings = settings().changed(|s| {
                s.lgh.interleave = interleave;
                s.lgh.first_level = first_level;
            });
            check(&format!("interleave {interleave}, first level {first_level}"), &scene, &settings);
        }
    }
    for alpha in [0.3, 2.0, 6.0] {
        check(&format!("alpha {alpha}"), &scene, &settings().changed(|s| s.lgh.alpha = alpha));
    }
    for shadow_samples in [0, 1, 16] {
        for first_level in [0, 1] {
            let what = format!("{shadow_samples} shadow samples, first level {first_level}");
            check(
                &what,
                &scene,
                &settings().changed(|s| {
                    s.many_lights.shadow_samples = shadow_samples;
                    s.lgh.first_level = first_level;
                }),
            );
        }
    }
    check("shadows from level 3", &scene, &settings().changed(|s| s.lgh.shadow_from = 3));
}

#[test]
fn gathering_equals_volumes_at_awkward_sizes() {
    let scene = furnished_room();
    for (width, height) in [(1, 1), (7, 9), (8, 8), (9, 17), (64, 3)] {
        let size = Size { width, height };
        check(
            &format!("{size}"),
            &scene,
            &settings().changed(|s| {
                s.picture.size = size;
                s.many_lights.vpls = 500;
            }),
        );
    }
}

/// Seen from a corner in few pixels: tiles with so many candidates that they are found in several rounds.
#[test]
fn gathering_equals_volumes_where_tiles_reach_thousands_of_lights() {
    let mut scene = furnished_room();
    scene.cameras = vec![camera(Vec3::new(-1.9, -1.9, 1.9), Vec3::new(1.0, 0.95, -1.0).normalize(), 2.4)];
    let settings = settings().changed(|s| {
        s.picture.size = Size { width: 16, height: 9 };
        s.many_lights.vpls = 60_000;
        s.lgh.alpha = 3.0;
    });
    check("wide tiles", &scene, &settings);
    check(
        "wide tiles from the lights on",
        &scene,
        &settings.changed(|s| {
            s.lgh.first_level = 0;
            s.many_lights.vpls = 20_000;
        }),
    );
}

#[test]
fn gathering_equals_volumes_with_degenerate_lights() {
    let lamps = |positions: &[Vec3]| {
        let mut scene = box_room(4.0, Vec3::splat(0.5));
        scene.cameras = lamp_room(Vec3::ONE).cameras;
        let intensity = Vec3::new(3.0, 2.0, 1.0);
        scene.lights = positions.iter().map(|p| Light::Point { position_ws: *p, intensity }).collect();
        scene
    };
    let line: Vec<Vec3> = (0..300_u16).map(|i| Vec3::new(f32::from(i) * 0.01 - 1.5, 0.2, 0.1)).collect();
    let plane: Vec<Vec3> = (0..400_u16).map(|i| Vec3::new(f32::from(i % 20), 0.0, f32::from(i / 20)) * 0.1).collect();
    for (what, positions) in [
        ("one light", vec![Vec3::ZERO]),
        ("one point", vec![Vec3::splat(0.25); 300]),
        ("a line", line),
        ("a plane", plane),
    ] {
        for first_level in [0, 1] {
            let settings = settings().changed(|s| {
                s.many_lights.lights = LightSet::Scene;
                s.lgh.first_level = first_level;
            });
            check(&format!("{what}, first level {first_level}"), &lamps(&positions), &settings);
        }
    }
}

#[test]
fn gathering_equals_volumes_in_sponza() {
    let Some(folder) = shared_dir() else {
        println!("skipped: the shared scenes are not there");
        return;
    };
    let mut scene = gltf::load(&folder.join("assets/sponza/sponza-sun.gltf"), &|_, _, _| ()).unwrap();
    let atrium = scene.cameras.iter().position(|c| c.name == "atrium").unwrap();
    scene.cameras.swap(0, atrium);
    check(
        "Sponza",
        &scene,
        &settings().changed(|s| {
            s.picture.size = Size { width: 160, height: 90 };
            s.many_lights.vpls = 20_000;
        }),
    );
}

#[test]
fn planted_faults_are_noticed() {
    let Some((volumes, gather)) = both(&furnished_room(), &settings()) else { return };
    let fails = |what: &str, change: &dyn Fn(&mut Lit)| {
        for side in ["volumes", "gather"] {
            let (mut a, mut b) = (volumes.clone(), gather.clone());
            change(if side == "volumes" { &mut a } else { &mut b });
            assert!(compare(&a, &b).is_err(), "{what} in {side} was not noticed");
        }
    };
    fails("a pixel too bright", &|lit| lit.lighting[700][1] *= 1.0 + 3.0 * LIGHTING_TOLERANCE);
    fails("a wrong sum of weights", &|lit| lit.lighting[700][3] *= 1.0 + 3.0 * LIGHTING_TOLERANCE);
    for value in [f32::NAN, f32::INFINITY] {
        for channel in 0..4 {
            fails(&format!("{value} in channel {channel}"), &|lit| lit.lighting[700][channel] = value);
        }
        fails(&format!("all {value}"), &|lit| lit.lighting.fill([value; 4]));
    }
    fails("other picks", &|lit| lit.picks.iter_mut().step_by(500).for_each(|light| *light ^= 1));
}
