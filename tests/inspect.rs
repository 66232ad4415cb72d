//! The pixel inspector against what the frame itself has of the pixel: lighting, reservoirs, shadow estimates.

mod common;

use std::collections::BTreeMap;

use common::rooms::lamp_room;
use glam::{Mat4, Vec3};
use gridlight::cpu::lights::luminance;
use gridlight::passes::FrameShape;
use gridlight::renderer::{Renderer, UploadedScene};
use gridlight::settings::{LightSet, Settings, ShadowPoints, Size, Switch, Technique, View};
use gridlight::shared::{
    FrameData, GridLight, InspectedPixel, NO_LIGHT, SAMPLE_BLOCKED, SAMPLE_EMPTY, SAMPLE_UNLIT, SAMPLE_VISIBLE,
};
use half::f16;

const SIZE: Size = Size { width: 48, height: 32 };
/// Relative difference of sums of the same terms in another order.
const SUM_TOLERANCE: f32 = 1e-4;
/// The estimates are kept as halves.
const HALF_TOLERANCE: f32 = 2e-3;
const PIXELS: [[u32; 2]; 5] = [[0, 0], [47, 31], [24, 16], [7, 25], [40, 3]];

/// What a frame has left of each resource, by pass and name, and what it said about the pixel.
struct Looked {
    written: BTreeMap<(String, String), Vec<u8>>,
    pixel: InspectedPixel,
    data: FrameData,
}

impl Looked {
    fn all<T: bytemuck::Pod>(&self, pass: &str, name: &str) -> Vec<T> {
        let bytes = self.written.get(&(pass.to_owned(), name.to_owned()));
        bytemuck::pod_collect_to_vec(bytes.unwrap_or_else(|| panic!("{pass} leaves no {name}")))
    }
}

fn look(settings: &Settings, pixel: [u32; 2]) -> Looked {
    let test = common::gpu();
    let scene = lamp_room(Vec3::new(0.6, 0.4, 0.2));
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    let camera = &scene.cameras[0];
    let measured = Renderer::new(&test.gpu, &uploaded, camera, settings).unwrap();
    let shape = FrameShape { inspect: true, ..measured.shape().clone() };
    let mut renderer = Renderer::with_shape(&test.gpu, &uploaded, camera, settings, shape).unwrap();
    renderer.inspect_pixel(pixel);
    let names: Vec<String> = renderer.executor().graph().resources().iter().map(|r| r.name.clone()).collect();
    let passes = renderer.pass_names();
    let mut written = BTreeMap::new();
    let visit = |pass: usize, resources: Vec<gridlight::gpu::Written>| {
        for resource in resources {
            written.insert((passes[pass].clone(), names[resource.resource].clone()), resource.bytes);
        }
        Ok(())
    };
    renderer.run_and_read(visit).unwrap();
    let bytes = &written[&("inspect".to_owned(), "inspected_pixel".to_owned())];
    let pixel = bytemuck::pod_read_unaligned(bytes);
    Looked { written, pixel, data: *renderer.frame_data() }
}

fn settings() -> Settings {
    Settings::default().changed(|s| {
        s.picture.size = SIZE;
        s.many_lights.vpls = 600;
    })
}

fn near(a: f32, b: f32, relative: f32) -> bool {
    (a - b).abs() <= relative * a.abs().max(b.abs()).max(1e-6)
}

/// Why what is said about the pixel is not what the frame did at `at`, if it is not.
fn compare(looked: &Looked, at: [u32; 2]) -> Result<(), String> {
    let Looked { pixel, data, .. } = looked;
    let index = (at[1] * SIZE.width + at[0]) as usize;
    let position = Vec3::from(pixel.position_ws);
    let clip = Mat4::from_cols_array_2d(&data.clip_from_world) * position.extend(1.0);
    let x = (clip.x / clip.w * 0.5 + 0.5) * SIZE.width as f32 - 0.5;
    let y = (clip.y / clip.w * 0.5 + 0.5) * SIZE.height as f32 - 0.5;
    if (x - at[0] as f32).abs() > 0.01 || (y - at[1] as f32).abs() > 0.01 {
        return Err(format!("its position is that of pixel {x}, {y}"));
    }
    let lighting: [f32; 4] = looked.all::<[f32; 4]>("light_gather", "lighting")[index];
    let sum: f32 = pixel.levels.iter().map(|level| level.lighting).sum();
    let expected = luminance(Vec3::from_slice(&lighting));
    if !near(sum, expected, SUM_TOLERANCE) || !near(pixel.total, lighting[3], SUM_TOLERANCE) {
        return Err(format!("the levels sum to {sum}, not {expected}; total {}", pixel.total));
    }
    let count = pixel.sample_count as usize;
    let reservoirs: Vec<[u32; 2]> = looked.all("light_gather", "reservoirs");
    let picks = reservoirs[index * count..][..count].iter().map(|[light, _]| *light);
    if !pixel.samples.iter().take(count).map(|sample| sample.light).eq(picks) {
        return Err("other lights were picked".to_owned());
    }
    let estimates = ["shadowed", "unshadowed"]
        .map(|name| looked.all::<[u16; 4]>("shadow_rays", name)[index].map(|bits| f16::from_bits(bits).to_f32()));
    let luminances = estimates.map(|rgb| luminance(Vec3::from_slice(&rgb)));
    let sum = |states: &[u32]| -> f32 {
        pixel.samples.iter().filter(|s| states.contains(&s.state)).map(|s| s.estimate).sum()
    };
    let found = [sum(&[SAMPLE_VISIBLE]), sum(&[SAMPLE_VISIBLE, SAMPLE_BLOCKED])];
    if (0..2).any(|i| !near(found[i], luminances[i], HALF_TOLERANCE)) {
        return Err(format!("S and U of the samples are {found:?}, not {luminances:?}"));
    }
    Ok(())
}

#[test]
fn it_says_what_the_frame_did() {
    for settings in [
        settings(),
        settings().changed(|s| {
            s.many_lights.shadow_samples = 16;
            s.lgh.alpha = 2.0;
        }),
        settings().changed(|s| {
            s.lgh.shadow_points = ShadowPoints::Deviation;
            s.lgh.first_level = 0;
        }),
        settings().changed(|s| {
            s.many_lights.lights = LightSet::Both;
            s.many_lights.shadow_samples = 1;
            s.picture.seed = 7;
        }),
    ] {
        for at in PIXELS {
            let looked = look(&settings, at);
            assert_eq!((looked.pixel.pixel, looked.pixel.found), (at, 1));
            compare(&looked, at).unwrap_or_else(|what| panic!("pixel {at:?}: {what}"));
        }
    }
}

#[test]
fn planted_faults_are_noticed() {
    let at = PIXELS[2];
    let faulty = |plant: &dyn Fn(&mut InspectedPixel)| {
        let mut looked = look(&settings(), at);
        plant(&mut looked.pixel);
        compare(&looked, at).is_err()
    };
    assert!(faulty(&|pixel| pixel.position_ws[0] += 0.1), "the position");
    assert!(faulty(&|pixel| pixel.levels[2].lighting *= 1.01), "a level's lighting");
    assert!(faulty(&|pixel| pixel.samples[1].light ^= 1), "a sample's light");
    let lit = |pixel: &InspectedPixel| pixel.samples.iter().position(|s| s.estimate > 0.0).unwrap();
    assert!(faulty(&|pixel| pixel.samples[lit(pixel)].estimate *= 1.2), "an estimate");
    assert!(
        faulty(&|pixel| {
            let sample = lit(pixel);
            pixel.samples[sample].state ^= SAMPLE_VISIBLE ^ SAMPLE_BLOCKED;
        }),
        "a shadow"
    );
    assert!(compare(&look(&settings(), at), PIXELS[3]).is_err(), "another pixel");
}

/// The lights that it counts, one by one on the CPU, with their weights.
#[test]
fn lights_are_counted_by_level() {
    let looked = look(&settings(), PIXELS[2]);
    let lights: Vec<GridLight> = looked.all("merge", "merged_lights");
    let pixel = &looked.pixel;
    assert!(pixel.level_count >= 3, "{}", pixel.level_count);
    for (level, found) in pixel.levels.iter().enumerate() {
        assert!(found.blended <= found.count && found.weight <= found.count as f32 * (1.0 + 1e-6));
        assert!(found.weight + 1e-6 >= (found.count - found.blended) as f32, "a weight is at most 1");
        assert_eq!(found.strongest == NO_LIGHT, found.count == 0);
        if found.count > 0 {
            let strongest = &lights[found.strongest as usize];
            assert_eq!(strongest.level as usize, level);
            let distance = Vec3::from(strongest.position_ws).distance(Vec3::from(pixel.position_ws));
            assert!(near(distance, found.strongest_distance, 1e-5), "{distance}");
            assert!(found.strongest_lighting <= found.lighting * (1.0 + 1e-6));
        }
    }
    assert!(pixel.levels.iter().map(|level| level.count).sum::<u32>() > 10);
}

#[test]
fn interleaved_pixels_have_their_own_lights() {
    for at in [[24, 16], [25, 16], [25, 17]] {
        let pixel = look(&settings().changed(|s| s.lgh.interleave = 2), at).pixel;
        assert_eq!((pixel.pixel, pixel.found), (at, 1));
        let states: Vec<u32> = pixel.samples.iter().take(4).map(|sample| sample.state).collect();
        assert!(states.iter().any(|s| [SAMPLE_VISIBLE, SAMPLE_BLOCKED].contains(s)), "{states:?}");
        assert!(pixel.levels.iter().any(|level| level.count > 0));
    }
}

#[test]
fn every_technique_and_view_has_a_surface() {
    for settings in [
        settings().changed(|s| s.render.technique = Technique::Direct),
        settings().changed(|s| {
            s.render.technique = Technique::PathTrace;
            s.path_trace.samples = 1;
        }),
        settings().changed(|s| {
            s.render.technique = Technique::BruteForce;
            s.many_lights.vpls = 50;
        }),
        settings().changed(|s| s.many_lights.shadows = Switch::Off),
        settings().changed(|s| s.render.view = View::LightCount),
        settings().changed(|s| s.render.view = View::Normal),
    ] {
        let pixel = look(&settings, PIXELS[2]).pixel;
        assert_eq!((pixel.found, pixel.sample_count), (1, 0), "{settings:?}");
        assert!((Vec3::from(pixel.normal).length() - 1.0).abs() < 1e-3);
        assert!(pixel.shadow_ratio[0] == 1.0, "{:?}", pixel.shadow_ratio);
        let albedo = Vec3::from(pixel.albedo);
        assert!(albedo.distance(Vec3::new(0.6, 0.4, 0.2)) < 4e-3, "{albedo}");
    }
}

#[test]
fn samples_that_are_none_have_a_state_of_their_own() {
    // A light that no other can hide behind: every state is one of the four, and empty ones have no light.
    for at in PIXELS {
        let pixel = look(&settings().changed(|s| s.many_lights.shadow_samples = 16), at).pixel;
        for sample in &pixel.samples {
            assert!([SAMPLE_EMPTY, SAMPLE_UNLIT, SAMPLE_VISIBLE, SAMPLE_BLOCKED].contains(&sample.state));
            assert_eq!(sample.state == SAMPLE_EMPTY, sample.light == NO_LIGHT);
            assert_eq!(sample.estimate > 0.0, [SAMPLE_VISIBLE, SAMPLE_BLOCKED].contains(&sample.state));
        }
    }
}
