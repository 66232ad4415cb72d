//! The pixel inspector against what the frame itself has of the pixel: lighting, reservoirs, shadow estimates.

mod common;

use std::sync::Arc;

use common::GpuTest;
use common::compare::{Verdict, within};
use common::rooms::{lamp_room, roofed_floor};
use common::written::Written;
use glam::{Mat4, Vec3};
use gridlight::color::luminance;
use gridlight::environment::Environment;
use gridlight::renderer::{Job, Renderer, UploadedScene};
use gridlight::scene::{Light, Scene};
use gridlight::settings::{LightSet, Settings, ShadowFilter, ShadowPoints, Size, Switch, Technique, View};
use gridlight::shared::{
    FrameData, GridLight, InspectedPixel, NO_LIGHT, SAMPLE_BLOCKED, SAMPLE_EMPTY, SAMPLE_UNLIT, SAMPLE_VISIBLE,
};

const ALBEDO: Vec3 = Vec3::new(0.6, 0.4, 0.2);
const SIZE: Size = Size { width: 48, height: 32 };
/// Relative difference of sums of the same terms in another order.
const SUM_TOLERANCE: f32 = 1e-4;
/// Sums of the same few numbers.
const ESTIMATE_TOLERANCE: f32 = 1e-4;
const PIXELS: [[u32; 2]; 5] = [[0, 0], [47, 31], [24, 16], [7, 25], [40, 3]];

/// Frames of one room and settings that tell about a pixel.
struct Inspector {
    renderer: Renderer,
    _test: GpuTest,
}

/// What a frame said about a pixel.
struct Looked<'a> {
    pixel: InspectedPixel,
    /// What the passes of such a frame have left.
    written: &'a Written,
    data: FrameData,
    sample_count: u32,
}

impl Inspector {
    fn new(settings: &Settings) -> Self {
        Self::over(&lamp_room(ALBEDO), settings)
    }

    fn over(scene: &Scene, settings: &Settings) -> Self {
        let test = common::gpu();
        let uploaded = UploadedScene::new(&test.gpu, scene).unwrap();
        let camera = &scene.cameras[0];
        let mut shapes = Renderer::new(&Job::new(&test.gpu, &uploaded, camera, settings)).unwrap().shapes().clone();
        shapes.frame.inspect = true;
        let renderer = Renderer::with_shapes(&Job::new(&test.gpu, &uploaded, camera, settings), shapes).unwrap();
        Self { renderer, _test: test }
    }

    /// What the passes leave; the same whichever pixel is asked for.
    fn written(&self) -> Written {
        Written::by(&self.renderer)
    }

    /// What a frame says about a pixel.
    fn pixel(&mut self, at: [u32; 2]) -> InspectedPixel {
        self.renderer.inspect_pixel(at);
        let ticket = self.renderer.submit().unwrap();
        self.renderer.wait(ticket).unwrap();
        let inspected = self.renderer.outputs().inspected.unwrap();
        bytemuck::pod_read_unaligned(&self.renderer.executor().read_buffer(inspected).unwrap())
    }

    fn look<'a>(&mut self, written: &'a Written, at: [u32; 2]) -> Looked<'a> {
        let pixel = self.pixel(at);
        let (data, sample_count) = (*self.renderer.frame_data(), self.renderer.frame_data().shadow_samples);
        Looked { pixel, written, data, sample_count }
    }
}

fn settings() -> Settings {
    Settings::default().changed(|s| {
        s.picture.size = SIZE;
        s.many_lights.vpls = 600;
    })
}

fn near(a: f32, b: f32, relative: f32) -> bool {
    within(a - b, relative * a.abs().max(b.abs()).max(1e-6))
}

/// Why what is said about the pixel is not what the frame did at `at`, if it is not.
fn compare(looked: &Looked, at: [u32; 2]) -> Verdict {
    let Looked { pixel, written, data, .. } = looked;
    let index = (at[1] * SIZE.width + at[0]) as usize;
    let position = Vec3::from(pixel.position_ws);
    let clip = Mat4::from_cols_array_2d(&data.clip_from_world) * position.extend(1.0);
    let x = (clip.x / clip.w * 0.5 + 0.5) * SIZE.width as f32 - 0.5;
    let y = (clip.y / clip.w * 0.5 + 0.5) * SIZE.height as f32 - 0.5;
    if !within(x - at[0] as f32, 0.01) || !within(y - at[1] as f32, 0.01) {
        return Err(format!("its position is that of pixel {x}, {y}"));
    }
    let lighting: [f32; 4] = written.all::<[f32; 4]>("light_gather", "lighting")[index];
    let sum: f32 = pixel.levels.iter().map(|level| level.lighting).sum();
    let expected = luminance(Vec3::from_slice(&lighting));
    if !near(sum, expected, SUM_TOLERANCE) || !near(pixel.total, lighting[3], SUM_TOLERANCE) {
        return Err(format!("the levels sum to {sum}, not {expected}; total {}", pixel.total));
    }
    if pixel.sample_count != looked.sample_count {
        return Err(format!("{} samples, not {}", pixel.sample_count, looked.sample_count));
    }
    let count = pixel.sample_count as usize;
    let reservoirs: Vec<[u32; 2]> = written.all("light_gather", "reservoirs");
    let picks = reservoirs[index * count..][..count].iter().map(|[light, _]| *light);
    if !pixel.samples.iter().take(count).map(|sample| sample.light).eq(picks) {
        return Err("other lights were picked".to_owned());
    }
    let estimates = ["shadowed", "unshadowed"].map(|name| written.all::<[f32; 4]>("shadow_rays", name)[index]);
    let luminances = estimates.map(|rgb| luminance(Vec3::from_slice(&rgb)));
    let sum = |states: &[u32]| -> f32 {
        pixel.samples.iter().take(count).filter(|s| states.contains(&s.state)).map(|s| s.estimate).sum()
    };
    let found = [sum(&[SAMPLE_VISIBLE]), sum(&[SAMPLE_VISIBLE, SAMPLE_BLOCKED])];
    if (0..2).any(|i| !near(found[i], luminances[i], ESTIMATE_TOLERANCE)) {
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
            s.tracing.seed = 7;
        }),
    ] {
        let mut inspector = Inspector::new(&settings);
        let written = inspector.written();
        for at in PIXELS {
            let looked = inspector.look(&written, at);
            assert_eq!((looked.pixel.pixel, looked.pixel.found), (at, 1));
            compare(&looked, at).unwrap_or_else(|what| panic!("pixel {at:?}: {what}"));
        }
    }
}

#[test]
fn planted_faults_are_noticed() {
    let at = PIXELS[2];
    let mut inspector = Inspector::new(&settings());
    let written = inspector.written();
    let looked = inspector.look(&written, at);
    let fails = |what: &str, plant: &dyn Fn(&mut InspectedPixel)| {
        let mut pixel = looked.pixel;
        plant(&mut pixel);
        assert!(compare(&Looked { pixel, ..looked }, at).is_err(), "{what}");
    };
    compare(&looked, at).unwrap();
    let lit = looked.pixel.samples.iter().position(|s| s.estimate > 0.0).unwrap();
    fails("the position", &|pixel| pixel.position_ws[0] += 0.1);
    fails("a level's lighting", &|pixel| pixel.levels[2].lighting *= 1.01);
    fails("a lost sample", &|pixel| pixel.sample_count -= 1);
    fails("no samples", &|pixel| pixel.sample_count = 0);
    fails("a sample's light", &|pixel| pixel.samples[1].light ^= 1);
    fails("an estimate", &|pixel| pixel.samples[lit].estimate *= 1.2);
    fails("a shadow", &|pixel| pixel.samples[lit].state ^= SAMPLE_VISIBLE ^ SAMPLE_BLOCKED);
    for value in [f32::NAN, f32::INFINITY] {
        fails("a position that is no number", &|pixel| pixel.position_ws[1] = value);
        fails("lighting that is no number", &|pixel| pixel.levels[2].lighting = value);
        fails("a total that is no number", &|pixel| pixel.total = value);
        fails("an estimate that is no number", &|pixel| pixel.samples[lit].estimate = value);
    }
    assert!(compare(&looked, PIXELS[3]).is_err(), "another pixel");
}

/// The lights that it counts, one by one on the CPU, with their weights.
#[test]
fn lights_are_counted_by_level() {
    let mut inspector = Inspector::new(&settings());
    let lights: Vec<GridLight> = inspector.written().all("merge", "merged_lights");
    let pixel = inspector.pixel(PIXELS[2]);
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
    let mut inspector = Inspector::new(&settings().changed(|s| s.lgh.interleave = 2));
    for at in [[24, 16], [25, 16], [25, 17]] {
        let pixel = inspector.pixel(at);
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
        let pixel = Inspector::new(&settings).pixel(PIXELS[2]);
        assert_eq!((pixel.found, pixel.sample_count), (1, 0), "{settings:?}");
        assert!((Vec3::from(pixel.normal).length() - 1.0).abs() < 1e-3);
        assert!(pixel.shadow_ratio[0] == 1.0, "{:?}", pixel.shadow_ratio);
        let albedo = Vec3::from(pixel.albedo);
        assert!(albedo.distance(ALBEDO) < 4e-3, "{albedo}");
    }
}

#[test]
fn samples_that_are_none_have_a_state_of_their_own() {
    // A light that no other can hide behind: every state is one of the four, and empty ones have no light.
    let mut inspector = Inspector::new(&settings().changed(|s| s.many_lights.shadow_samples = 16));
    for at in PIXELS {
        let pixel = inspector.pixel(at);
        assert_eq!(pixel.sample_count, 16);
        for sample in &pixel.samples {
            assert!([SAMPLE_EMPTY, SAMPLE_UNLIT, SAMPLE_VISIBLE, SAMPLE_BLOCKED].contains(&sample.state));
            assert_eq!(sample.state == SAMPLE_EMPTY, sample.light == NO_LIGHT);
            assert_eq!(sample.estimate > 0.0, [SAMPLE_VISIBLE, SAMPLE_BLOCKED].contains(&sample.state));
        }
    }
}

/// The environment's part of the direct light, and all of it where nothing else shines.
#[test]
fn light_of_the_environment_has_a_line_of_its_own() {
    let scene = |has_sun: bool| {
        let mut scene = roofed_floor();
        if !has_sun {
            scene.lights = vec![Light::DARK];
        }
        scene.environment = Some(Arc::new(Environment::uniform([1.0, 2.0, 3.0])));
        scene
    };
    let filtered = settings().changed(|s| s.render.technique = Technique::Direct);
    for (settings, resource) in [
        (settings().changed(|s| s.lgh.filter = ShadowFilter::None), "environment_shadowed"),
        (filtered, "environment_shadowed_5"),
    ] {
        for has_sun in [true, false] {
            let mut inspector = Inspector::over(&scene(has_sun), &settings);
            let (at, written) = ([24, 26], inspector.written());
            let pixel = inspector.pixel(at);
            assert_eq!(pixel.found, 1);
            let rgb = |of: [f32; 4]| Vec3::from_slice(&of);
            let lighting: Vec<[f32; 4]> = written.last(resource);
            let expected = Vec3::from(pixel.albedo) * rgb(lighting[(at[1] * SIZE.width + at[0]) as usize]);
            let found = rgb(pixel.environment);
            let is_near = |a: Vec3| a.distance(found) <= 1e-5 * a.length();
            assert!(expected.min_element() > 0.0 && is_near(expected), "{found}, not {expected}");
            assert_eq!(is_near(rgb(pixel.direct)), !has_sun, "{found} of {:?}, sun: {has_sun}", pixel.direct);
        }
    }
    assert_eq!(Inspector::new(&settings()).pixel(PIXELS[2]).environment, [0.0; 4]);
}
