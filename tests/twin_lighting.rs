//! The light volumes and the gather against a sum over all lights on the CPU: blending, lobes, singularity clamp, interleaved
//! viewports. Also that what covers no pixel loses none.

mod common;

use common::compare::{Verdict, all_finite, near};
use common::rooms::{lamp_room, surface};
use glam::Vec3;
use gridlight::cpu::grid::Grid;
use gridlight::cpu::lights::{Clamp, blend_weight, light_response, lobe_of_level};
use gridlight::passes::lgh_shape::LghShape;
use gridlight::renderer::{Job, Renderer, UploadedScene};
use gridlight::scene::Scene;
use gridlight::scene::bvh::build_binary;
use gridlight::settings::{CenterWeight, LightingMode, Lobe, Settings, Size, Switch};
use gridlight::shared::{GridLight, GridPlacement};
use gridlight::techniques::lgh::HierarchyOutputs;

const ALBEDO: f32 = 0.5;

fn room() -> Scene {
    lamp_room(Vec3::splat(ALBEDO))
}

fn settings(lighting: LightingMode, alpha: f32, first_level: u32) -> Settings {
    Settings::default().changed(|s| {
        s.lgh.lighting = Some(lighting);
        s.picture.size = Size { width: 40, height: 26 };
        s.many_lights.vpls = 2000;
        s.lgh.alpha = alpha;
        s.lgh.first_level = first_level;
        s.many_lights.shadow_samples = 0;
        s.render.direct = Switch::Off;
        s.many_lights.clamp = 0.5;
    })
}

/// What lit a frame.
struct Hierarchy {
    lights: Vec<GridLight>,
    grid: Grid,
    clamp: Clamp,
}

/// Radiance of one frame, with the lights that made it.
fn render(scene: &Scene, settings: &Settings) -> (Vec<Vec3>, Hierarchy) {
    let test = common::gpu();
    let uploaded = UploadedScene::new(&test.gpu, scene).unwrap();
    let mut renderer = Renderer::new(&Job::new(&test.gpu, &uploaded, &scene.cameras[0], settings)).unwrap();
    let ticket = renderer.submit().unwrap();
    renderer.wait(ticket).unwrap();
    let radiance = renderer.read_radiance().unwrap().chunks_exact(3).map(Vec3::from_slice).collect();
    let hierarchy = renderer.outputs().technique.of::<HierarchyOutputs>().unwrap();
    let read = |buffer| renderer.executor().read_buffer(buffer).unwrap();
    let sub_images: Vec<u32> = bytemuck::pod_collect_to_vec(&read(hierarchy.merged.sub_images));
    let levels = renderer.shapes().of::<LghShape>().unwrap().levels;
    let mut lights: Vec<GridLight> = bytemuck::pod_collect_to_vec(&read(hierarchy.merged.lights));
    lights.truncate(sub_images[levels.top as usize + 1] as usize);
    let placement: Vec<GridPlacement> = bytemuck::pod_collect_to_vec(&read(hierarchy.placement));
    let grid = Grid { placement: placement[0], levels, center: settings.lgh.center };
    let clamp = Clamp::of(renderer.frame_data());
    assert!(clamp.squared > 0.0 && clamp.squared.is_finite(), "{clamp:?}");
    (radiance, Hierarchy { lights, grid, clamp })
}

/// The lighting of one pixel by every light in turn.
fn lighting(settings: &Settings, by: &Hierarchy, p: Vec3, normal: Vec3) -> Vec3 {
    let top = by.grid.levels.top;
    by.lights
        .iter()
        .map(|light| {
            let offset = Vec3::from(light.position_ws) - p;
            let radius = settings.lgh.alpha * by.grid.cell_size(light.level);
            let weight = blend_weight(offset.length(), radius, light.level, settings.lgh.first_level, top);
            let kind = lobe_of_level(light.level, settings.lgh.lobe);
            let response = light_response(offset, normal, Vec3::from(light.lobe), kind, by.clamp.of_light(light));
            Vec3::from(light.flux) * (weight * response)
        })
        .sum()
}

/// How far a pixel may be off, relative: positions come from depth on one side and from a ray on the other, and a
/// light close to a wall magnifies the difference. A rasteriser that moves corners to few positions per pixel
/// (SwiftShader: 16) moves the depth with them, so walls seen at a flat angle are off by a few hundredths.
fn tolerance() -> f32 {
    if common::gpu().gpu.report().limits.subpixel_bits < 8 { 4e-2 } else { 5e-3 }
}

/// All pixels but the odd one on an edge within the tolerance, and every one a number.
fn compare(gpu: &[Vec3], cpu: &[Vec3]) -> Verdict {
    assert_eq!(gpu.len(), cpu.len());
    all_finite("pixel", gpu)?;
    if !cpu.iter().any(|lighting| lighting.max_element() > 0.0) {
        return Err("nothing is lit".to_owned());
    }
    let tolerance = tolerance();
    let far = |i: &usize| !near(gpu[*i], cpu[*i], tolerance * cpu[*i].max_element());
    let wrong: Vec<usize> = (0..gpu.len()).filter(far).collect();
    if wrong.len() > gpu.len() / 100 {
        let (first, count) = (wrong[0], wrong.len());
        return Err(format!(
            "{count} of {} pixels differ, the first {first}: {} {}",
            gpu.len(),
            gpu[first],
            cpu[first]
        ));
    }
    Ok(())
}

/// Indirect lighting per unit albedo on both sides.
fn both(settings: &Settings) -> (Vec<Vec3>, Vec<Vec3>) {
    let scene = room();
    let (radiance, by) = render(&scene, settings);
    let gpu = radiance.iter().map(|radiance| *radiance / ALBEDO).collect();
    (gpu, sums(settings, &scene, &by))
}

/// The lighting of every pixel by all lights, on the CPU.
fn sums(settings: &Settings, scene: &Scene, by: &Hierarchy) -> Vec<Vec3> {
    let bvh = build_binary(scene);
    let size = settings.picture.size;
    (0..(size.width * size.height) as usize)
        .map(|i| {
            let (position, normal, _) = surface(&bvh, &scene.cameras[0], size, i);
            lighting(settings, by, position, normal)
        })
        .collect()
}

#[test]
fn lighting_is_a_sum_over_all_lights() {
    for (alpha, first_level) in [(0.5, 1), (1.0, 1), (2.0, 1), (1.0, 0)] {
        for mode in [LightingMode::Volumes, LightingMode::Gather] {
            let (gpu, cpu) = both(&settings(mode, alpha, first_level));
            compare(&gpu, &cpu).unwrap_or_else(|e| panic!("{mode:?}, alpha {alpha}, first level {first_level}: {e}"));
        }
    }
}

const LOBES: [Lobe; 4] = [Lobe::Mixture, Lobe::ClampedNormal, Lobe::Sh1, Lobe::Sh1Nonlinear];

#[test]
fn every_lobe_and_centre_is_its_formula() {
    let scene = room();
    for (lobe, center, first_level) in LOBES
        .map(|lobe| (lobe, CenterWeight::Intensity, 1))
        .into_iter()
        .chain([(Lobe::Mixture, CenterWeight::Uniform, 1), (Lobe::Sh1, CenterWeight::Uniform, 0)])
    {
        for mode in [LightingMode::Volumes, LightingMode::Gather] {
            let settings = settings(mode, 1.0, first_level).changed(|s| {
                s.lgh.lobe = lobe;
                s.lgh.center = center;
            });
            let what = format!("{mode:?}, {lobe:?}, {center:?}, first level {first_level}");
            let (radiance, hierarchy) = render(&scene, &settings);
            let gpu: Vec<Vec3> = radiance.iter().map(|radiance| *radiance / ALBEDO).collect();
            let by = |kind| sums(&settings.clone().changed(|s| s.lgh.lobe = kind), &scene, &hierarchy);
            compare(&gpu, &by(lobe)).unwrap_or_else(|e| panic!("{what}: {e}"));
            for other in LOBES.into_iter().filter(|other| *other != lobe) {
                assert!(compare(&gpu, &by(other)).is_err(), "{what}: {other:?} is as good");
            }
        }
    }
}

#[test]
fn vpls_of_much_flux_are_clamped_at_larger_distances() {
    let scene = room();
    for mode in [LightingMode::Volumes, LightingMode::Gather] {
        let settings = settings(mode, 1.0, 0).changed(|s| {
            s.many_lights.clamp = 4.0;
            // The last bounces leave much less flux than the first.
            s.many_lights.bounces = 6;
        });
        let (radiance, mut by) = render(&scene, &settings);
        let gpu: Vec<Vec3> = radiance.iter().map(|radiance| *radiance / ALBEDO).collect();
        compare(&gpu, &sums(&settings, &scene, &by)).unwrap_or_else(|e| panic!("{mode:?}: {e}"));
        by.clamp.large_vpl_luminance = f32::MAX;
        assert!(compare(&gpu, &sums(&settings, &scene, &by)).is_err(), "{mode:?}: one distance for all is as good");
    }
}

#[test]
fn planted_faults_are_noticed() {
    let (gpu, cpu) = both(&settings(LightingMode::Gather, 1.0, 1));
    let brighter: Vec<Vec3> = cpu.iter().map(|v| *v * (1.0 + 2.0 * tolerance())).collect();
    assert!(compare(&gpu, &brighter).is_err(), "wrong by twice the tolerance");
    for value in [f32::NAN, f32::INFINITY] {
        let all = vec![Vec3::splat(value); gpu.len()];
        assert!(compare(&all, &cpu).is_err() && compare(&gpu, &all).is_err(), "every pixel {value}");
        for channel in 0..3 {
            let mut one = gpu.clone();
            one[500][channel] = value;
            assert!(compare(&one, &cpu).is_err(), "one channel of one pixel {value}");
        }
    }
    let black = vec![Vec3::ZERO; gpu.len()];
    assert!(compare(&black, &black).is_err(), "a black picture");
}
