//! Light that comes straight from the environment and from surfaces that shine.

use std::sync::Arc;

use glam::Vec3;
use gridlight::environment::Environment;
use gridlight::renderer::Fresh;
use gridlight::scene::testing::{diffuse, scene_from_quads};
use gridlight::scene::{Light, LitBy, Material, Scene};
use gridlight::settings::{Antilag, Settings, ShadowEstimate, Size, Switch, Temporal, View};

use crate::common::gpu;
use crate::common::picture::{SIZES, Texel};
use crate::common::rooms::{add_quad, add_quad_of, camera};
use crate::run::{Run, settings};

/// Whose light it is.
#[derive(Clone, Copy)]
pub struct AreaLight {
    /// Begins the names of its passes and images.
    pub label: &'static str,
}

pub const AREA_LIGHTS: [AreaLight; 2] = [AreaLight { label: "environment_" }, AreaLight { label: "emitter_" }];

/// A floor and a wall under a sky that is bright on one side, a table before them, and a panel that shines down.
pub fn lit_scene() -> Scene {
    let level = |y: f32, half: f32, middle: [f32; 2]| {
        let [x, z] = middle;
        [[-half, half], [half, half], [half, -half], [-half, -half]].map(|[dx, dz]| Vec3::new(x + dx, y, z + dz))
    };
    let at = |x: f32, y: f32| Vec3::new(x, y, -2.0);
    let wall = [at(-3.0, -1.0), at(3.0, -1.0), at(3.0, 2.0), at(-3.0, 2.0)];
    let grey = diffuse("grey", Vec3::new(0.7, 0.5, 0.3));
    let mut scene = scene_from_quads("lit", &[level(-1.0, 3.0, [0.0, 0.0]), wall], grey);
    add_quad(&mut scene, level(-0.5, 0.5, [-0.3, -1.0]));
    let mut panel = level(0.9, 0.3, [0.7, -1.0]);
    panel.reverse();
    let shines = Material { emission: [2.0, 3.0, 1.0], ..diffuse("panel", Vec3::ZERO) };
    add_quad_of(&mut scene, panel, shines);
    let texel = |i: u32| if i % 32 < 10 { [5.0, 4.0, 2.0] } else { [0.2, 0.3, 0.6] };
    let sky = Environment { size: [32, 16], radiance: (0..32 * 16).map(texel).collect(), suns: Vec::new() };
    scene.environment = Some(Arc::new(sky));
    (scene.lights, scene.lit_by) = (vec![Light::DARK], LitBy::EmissiveSurfaces);
    scene.cameras = vec![camera(Vec3::new(0.0, 0.3, 2.0), Vec3::new(0.0, -0.25, -1.0).normalize(), 0.9)];
    scene
}

/// Frames with direct light, one ray to each light, whose tiles are compared.
pub fn area_settings(size: Size, temporal: Temporal) -> Settings {
    settings(size, temporal, ShadowEstimate::Corrected).changed(|s| {
        (s.render.direct, s.environment.samples, s.lgh.antilag) = (Switch::On, 1, Antilag::Tiles);
    })
}

#[test]
fn the_mean_of_the_frames_is_kept() {
    let test = gpu();
    let settings = area_settings(SIZES[4], Temporal::Shadows).changed(|s| s.lgh.antilag = Antilag::Off);
    let mut run = Run::new(&test.gpu, &lit_scene(), &settings);
    let mut sums = [(); 2].map(|()| Vec::<Texel>::new());
    for count in 1..=20 {
        run.next();
        let frame = run.last();
        for (AreaLight { label }, sums) in AREA_LIGHTS.iter().zip(&mut sums) {
            let traced = frame.floats(&format!("{label}light"), &format!("{label}shadowed"));
            let kept = frame.floats(&format!("temporal/{label}blend"), &format!("{label}temporal_shadowed"));
            sums.resize(traced.len(), [0.0; 4]);
            let mut greatest = 0.0_f64;
            for (index, ((sum, traced), kept)) in sums.iter_mut().zip(&traced).zip(&kept).enumerate() {
                // A camera that stands still loses nothing but the background.
                let surface = frame.surfaces.surface(index as i32 % 37, index as i32 / 37).is_some();
                assert_eq!(kept[3].round(), f64::from(count) * f64::from(u8::from(surface)), "{label} pixel {index}");
                for channel in 0..3 {
                    sum[channel] += traced[channel];
                    let mean = sum[channel] / f64::from(count);
                    let off = (kept[channel] - mean).abs() / mean.max(1.0);
                    assert!(off <= 1e-6, "{label} pixel {index}, {count} frames: {kept:?}, not {mean}");
                    greatest = greatest.max(mean);
                }
            }
            assert!(greatest > 0.1, "{label}: there is no light");
        }
    }
}

/// Pictures of a run, with a cut before the third.
fn pictures(settings: &Settings) -> Vec<Vec<f32>> {
    let test = gpu();
    let mut run = Run::new(&test.gpu, &lit_scene(), settings);
    let picture = |frame: u32| {
        if frame == 2 {
            run.renderer.cut();
        }
        run.next_with(Fresh::All);
        run.radiance()
    };
    (0..5).map(picture).collect()
}

/// Under validation, in the whole picture and in the view of direct light: the first frame and one after a cut are as without
/// history, others are not.
#[test]
fn a_frame_without_history_is_as_with_temporal_off() {
    for (view, interleave) in [(View::Final, 1), (View::Direct, 1), (View::Final, 2), (View::Final, 4)] {
        let settings = |mode: Temporal| {
            area_settings(SIZES[4], mode).changed(|s| {
                (s.render.view, s.lgh.interleave, s.lgh.temporal_rounds) = (view, interleave, Some(1));
            })
        };
        let plain = pictures(&settings(Temporal::Off));
        for mode in [Temporal::Shadows, Temporal::Indirect] {
            let blended = pictures(&settings(mode));
            for (frame, is_alone) in [true, false, true, false, false].into_iter().enumerate() {
                let what = format!("{view:?}, {mode:?}, interleave {interleave}, frame {frame}");
                assert!(blended[frame].iter().all(|value| value.is_finite()), "{what}");
                assert_eq!(blended[frame] == plain[frame], is_alone, "{what}");
            }
        }
    }
}

/// An environment that is so much fainter gives the same picture so much darker: no limit of the filter is one of brightness.
#[test]
fn faint_light_is_filtered_like_bright_light() {
    let test = gpu();
    let last = |scale: f32| {
        let mut scene = lit_scene();
        // The environment alone has a scale.
        scene.materials.iter_mut().for_each(|material| material.emission = [0.0; 3]);
        let settings = area_settings(SIZES[4], Temporal::Shadows)
            .changed(|s| (s.render.view, s.environment.scale) = (View::Direct, scale));
        let mut run = Run::new(&test.gpu, &scene, &settings);
        (0..12).for_each(|_| run.next());
        run.radiance()
    };
    let faint = 2.0_f32.powi(-12);
    let [bright, dark] = [1.0, faint].map(last);
    assert!(bright.iter().any(|value| *value > 0.01), "there is no light");
    for (index, (bright, dark)) in bright.iter().zip(&dark).enumerate() {
        let off = (dark / faint - bright).abs();
        assert!(off <= 1e-4 * bright, "value {index}: {} of {bright}", dark / faint);
    }
}

/// A size of whole tiles.
const TILED: Size = Size { width: 64, height: 40 };

/// How far the picture is from one that has always been under the environment of now, as a share of it, four frames after that was
/// another number of times as bright; and the share of tiles that give something up.
fn lag(antilag: Antilag, scale_before: f32) -> [f64; 2] {
    let test = gpu();
    let label = AREA_LIGHTS[0].label;
    let run = |antilag: Antilag, scale_before: f32| {
        let settings = area_settings(TILED, Temporal::Shadows).changed(|s| {
            (s.render.view, s.lgh.antilag) = (View::Direct, antilag);
            (s.environment.samples, s.environment.scale) = (4, scale_before);
        });
        let mut run = Run::new(&test.gpu, &lit_scene(), &settings);
        let mut given_up = 0.0;
        for frame in 0..28 {
            if frame == 24 {
                run.settings.environment.scale = 2.0;
            }
            run.next();
            let (pass, image) = (format!("temporal/{label}compare_tiles"), format!("{label}given_up"));
            let tiles: Vec<[f32; 4]> = run.last().written.get(&pass, &image).unwrap_or_default();
            if frame >= 8 && !tiles.is_empty() {
                given_up += tiles.iter().filter(|tile| tile[0] > 0.0).count() as f64 / tiles.len() as f64 / 20.0;
            }
        }
        (run.radiance(), given_up)
    };
    let (truth, _) = run(Antilag::Off, 2.0);
    let (found, given_up) = run(antilag, scale_before);
    let apart: f32 = found.iter().zip(&truth).map(|(a, b)| (a - b).abs()).sum();
    [f64::from(apart / truth.iter().sum::<f32>()), given_up]
}

#[test]
fn an_environment_that_has_changed_is_noticed_and_noise_is_not() {
    let [[without, _], [with, _], [_, alarms]] =
        [(Antilag::Off, 1.0), (Antilag::Tiles, 1.0), (Antilag::Tiles, 2.0)].map(|(tiles, before)| lag(tiles, before));
    eprintln!("lag {without} without and {with} with tiles, {alarms} of tiles at rest");
    assert!(with <= 0.5 * without && without > 0.1, "{with} with tiles, {without} without");
    assert!(alarms <= 0.02, "{alarms} of the tiles give up light at rest");
}
