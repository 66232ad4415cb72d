//! Indirect light for every second pixel of every second row (`--indirect-size half`): what is picked, what the smaller frame is
//! told, and what the other pixels take over, each against its formula.

mod common;

use common::compare::{Verdict, exact, within};
use common::picture::{Frame, SIZES, Texel, compare_texels};
use common::rooms::{folding_screen, furnished_room};
use common::{GpuTest, gpu};
use glam::DVec3;
use gridlight::passes::half_picture::halved;
use gridlight::renderer::{Fresh, Job, Renderer, UploadedScene};
use gridlight::scene::Scene;
use gridlight::settings::{IndirectSize, LightingMode, Settings, Size, Switch, Temporal, View};
use gridlight::shared::FrameData;
use gridlight::techniques;

/// Sums of up to 25 products of floats with exponentials and powers.
const TOLERANCE: [f64; 2] = [1e-4, 1e-7];
/// Rounding of a position, relative to its distance from the eye.
const POSITION: f64 = 1e-5;

fn settings(size: Size) -> Settings {
    Settings::default().changed(|s| {
        s.picture.size = size;
        s.render.direct = Switch::Off;
        s.many_lights.vpls = 500;
        s.many_lights.shadow_samples = 1;
        s.lgh.indirect_size = IndirectSize::Half;
    })
}

fn half_size(frame: &Frame) -> [i32; 2] {
    halved([frame.size.width, frame.size.height]).map(|edge| edge as i32)
}

/// Pixels of the half picture, row by row.
fn half_pixels(frame: &Frame) -> impl Iterator<Item = (i32, i32)> + use<> {
    let [width, height] = half_size(frame);
    (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)))
}

/// Depth and normals are those of the pixels at `first`, `first + 2` and so on.
fn check_picked(frame: &Frame, first: i32) -> Verdict {
    let picked = |(x, y): (i32, i32)| frame.surfaces.index(2 * x + first, 2 * y).unwrap_or(0);
    let depth: Vec<u32> = frame.written.all("gbuffer", "gbuffer_depth");
    let expected: Vec<u32> = half_pixels(frame).map(|at| depth[picked(at)]).collect();
    exact("half_depth", &frame.written.all("half_picture/pick_pixels", "half_depth"), &expected)?;
    let normals: Vec<[u32; 2]> = frame.written.all("gbuffer", "gbuffer_normals");
    let expected: Vec<[u32; 4]> =
        half_pixels(frame).map(|at| [normals[picked(at)][0], normals[picked(at)][1], 0, 0]).collect();
    exact("half_normals", &frame.written.all("half_picture/pick_pixels", "half_normals"), &expected)
}

/// The constants of the half picture put its pixels where those of the whole one are. `shift_px` moves them.
fn check_places(frame: &Frame, shift_px: f32) -> Verdict {
    let data = frame.written.all::<FrameData>("half_picture/pick_pixels", "half_frame_data")[0];
    exact("size_px", &data.size_px.map(|edge| edge as i32), &half_size(frame))?;
    let vector = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    for (x, y) in half_pixels(frame) {
        let ndc = |at: i32, jitter_px: f32, size: u32| {
            f64::from(at as f32 + 0.5 + jitter_px + shift_px) / f64::from(size) * 2.0 - 1.0
        };
        let [u, v] = [ndc(x, data.jitter_x_px, data.size_px[0]), ndc(y, data.jitter_y_px, data.size_px[1])];
        let ray = vector(data.forward_ws) + u * vector(data.right_ws) - v * vector(data.up_ws);
        let expected = frame.surfaces.place_ws([f64::from(2 * x), f64::from(2 * y)], 1.0) - vector(data.eye_ws);
        let off = (ray - expected).length();
        if !within(off, POSITION) {
            return Err(format!("pixel ({x}, {y}) is {off} off at distance 1"));
        }
    }
    Ok(())
}

/// How alike two surfaces must be to share their light.
#[derive(Clone, Copy)]
struct Likeness {
    plane_sigma: f64,
    normal_power: i32,
    other_surface: f64,
}

const LIKENESS: Likeness = Likeness { plane_sigma: 2.0, normal_power: 16, other_surface: 1e-4 };

/// What the formula makes of the half picture's light.
struct Twin<'a> {
    frame: &'a Frame,
    light: Vec<Texel>,
    by: Likeness,
}

impl Twin<'_> {
    /// Index of a pixel in the half picture, of the pixel that it was picked from, and how alike that and another are.
    fn likeness(&self, to: (i32, i32, usize), (x, y): (i32, i32)) -> Option<(usize, f64)> {
        let [width, height] = half_size(self.frame);
        let surfaces = &self.frame.surfaces;
        let is_inside = x >= 0 && y >= 0 && x < width && y < height;
        let index = surfaces.surface(2 * x, 2 * y).filter(|_| is_inside)?;
        let offset = surfaces.position_ws(2 * x, 2 * y, index) - surfaces.position_ws(to.0, to.1, to.2);
        let off_plane = offset.dot(surfaces.geometric_normal(to.2)).abs() / surfaces.footprint(to.2);
        let cosine = surfaces.normal(index).dot(surfaces.normal(to.2)).max(0.0);
        let weight = (-off_plane / self.by.plane_sigma).exp() * cosine.powi(self.by.normal_power);
        Some(((y * width + x) as usize, weight + self.by.other_surface))
    }

    /// Mean light of some pixels, each with a weight of its own.
    fn mean(&self, to: (i32, i32, usize), pixels: impl Iterator<Item = ((i32, i32), f64)>) -> Option<Texel> {
        let mut sum = [0.0; 4];
        for (pixel, weight) in pixels.filter(|(_, weight)| *weight > 0.0) {
            let Some((index, likeness)) = self.likeness(to, pixel) else { continue };
            let light = self.light[index];
            let weighted = [light[0], light[1], light[2], 1.0].map(|channel| channel * weight * likeness);
            sum = std::array::from_fn(|channel| sum[channel] + weighted[channel]);
        }
        (sum[3] > 0.0).then(|| [sum[0] / sum[3], sum[1] / sum[3], sum[2] / sum[3], 1.0])
    }

    fn pixel(&self, x: i32, y: i32) -> Texel {
        let Some(index) = self.frame.surfaces.surface(x, y) else { return [0.0; 4] };
        let share = |at: i32, corner: i32| match (at % 2, corner) {
            (0, 0) => 1.0,
            (0, _) => 0.0,
            _ => 0.5,
        };
        let corners = [(0, 0), (1, 0), (0, 1), (1, 1)];
        let around = corners.map(|(i, j)| ((x / 2 + i, y / 2 + j), share(x, i) * share(y, j)));
        let further = (-2..=2).flat_map(|j| (-2..=2).map(move |i| ((x / 2 + i, y / 2 + j), 1.0)));
        let to = (x, y, index);
        self.mean(to, around.into_iter()).or_else(|| self.mean(to, further)).unwrap_or([0.0; 4])
    }
}

fn check_enlarged(frame: &Frame, by: Likeness) -> Verdict {
    let twin = Twin { frame, light: frame.floats("half_picture/apply_shadows", "half_indirect"), by };
    let expected: Vec<Texel> = frame.pixels().map(|(x, y)| twin.pixel(x, y)).collect();
    compare_texels("enlarged", &frame.floats("half_picture/enlarge", "indirect_enlarged"), &expected, 4, TOLERANCE)
}

fn frames(test: &GpuTest) -> Vec<Frame> {
    let of = |scene: &Scene, size| Frame::of(test, scene, &settings(size));
    SIZES.into_iter().map(|size| of(&furnished_room(), size)).chain([of(&folding_screen(), SIZES[4])]).collect()
}

#[test]
fn every_second_pixel_is_picked_and_stays_where_it_is() {
    let test = gpu();
    let frames = frames(&test);
    for frame in &frames {
        check_picked(frame, 0).unwrap();
        check_places(frame, 0.0).unwrap();
    }
    let any = |faulty: &dyn Fn(&Frame) -> Verdict| frames.iter().any(|frame| faulty(frame).is_err());
    assert!(any(&|frame| check_picked(frame, 1)), "the pixels to their right");
    assert!(any(&|frame| check_places(frame, 0.25)), "the middle of four pixels");
}

#[test]
fn pixels_take_the_light_of_their_own_surface() {
    let test = gpu();
    let frames = frames(&test);
    frames.iter().for_each(|frame| check_enlarged(frame, LIKENESS).unwrap());
    let any = |by| frames.iter().any(|frame| check_enlarged(frame, by).is_err());
    assert!(any(Likeness { plane_sigma: 1e9, ..LIKENESS }), "any plane");
    assert!(any(Likeness { normal_power: 0, ..LIKENESS }), "any normal");
    assert!(any(Likeness { other_surface: 0.1, ..LIKENESS }), "light from other surfaces");
}

/// The light of a picture without noise, by either size: the same but for what lies between pixels.
#[test]
fn the_picture_is_as_bright() {
    let test = gpu();
    let scene = furnished_room();
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    let mean = |indirect_size| {
        let settings = settings(Size { width: 96, height: 64 }).changed(|s| {
            s.lgh.indirect_size = indirect_size;
            s.many_lights.shadow_samples = 0;
        });
        let mut renderer = Renderer::new(&Job::new(&test.gpu, &uploaded, &scene.cameras[0], &settings)).unwrap();
        let ticket = renderer.submit().unwrap();
        renderer.wait(ticket).unwrap();
        let radiance = renderer.read_radiance().unwrap();
        radiance.iter().map(|channel| f64::from(*channel)).sum::<f64>() / radiance.len() as f64
    };
    let (full, half) = (mean(IndirectSize::Full), mean(IndirectSize::Half));
    assert!(full > 0.0 && within(half / full - 1.0, 0.02), "{half} instead of {full}");
}

/// Motion is counted in the half picture's pixels, and finds there what the frame before had.
#[test]
fn frames_before_are_found_in_the_half_picture() {
    let test = gpu();
    let scene = furnished_room();
    let settings = settings(Size { width: 65, height: 47 }).changed(|s| s.lgh.temporal = Some(Temporal::Indirect));
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    let mut camera = scene.cameras[0].clone();
    let mut renderer = Renderer::new(&Job::new(&test.gpu, &uploaded, &camera, &settings)).unwrap();
    for number in 0..3 {
        renderer.update(&Job::new(&test.gpu, &uploaded, &camera, &settings));
        renderer.set_accumulated_frame(number, Fresh::Shadows);
        let ticket = renderer.submit().unwrap();
        renderer.wait(ticket).unwrap();
        camera.position_ws += camera.right_ws * 0.05;
    }
    let frame = Frame::by(&renderer, &camera, &settings);
    let motion = frame.floats("gbuffer", "gbuffer_motion");
    let picked: Vec<Texel> = half_pixels(&frame)
        .map(|(x, y)| motion[frame.surfaces.index(2 * x, 2 * y).unwrap()])
        .map(|[x, y, nearness, rest]| [0.5 * x, 0.5 * y, nearness, rest])
        .collect();
    exact("half_motion", &frame.floats("half_picture/pick_pixels", "half_motion"), &picked).unwrap();
    assert!(picked.iter().any(|motion| motion[0].abs() > 0.1), "nothing moves");
    let frames_of = frame.floats("temporal/blend", "temporal_shadowed");
    let found = frames_of.iter().filter(|texel| texel[3] > 1.5).count();
    assert!(found * 10 > frames_of.len() * 8, "{found} of {} pixels are found again", frames_of.len());
}

#[test]
fn what_is_of_every_pixel_is_refused() {
    let refusal = |change: fn(&mut Settings)| {
        let settings = settings(SIZES[4]).changed(change);
        techniques::check(&settings).expect_err("it is refused").to_string()
    };
    assert!(refusal(|s| s.render.view = View::ShadowRatio).contains("--view shadow-ratio"));
    assert!(refusal(|s| s.lgh.lighting = Some(LightingMode::Volumes)).contains("--lighting gather"));
    let inspected = refusal(|s| s.output.inspect = Some("3,2".parse().unwrap()));
    assert!(inspected.contains("--inspect"), "{inspected}");
    techniques::check(&settings(SIZES[4]).changed(|s| s.render.view = View::Normal)).unwrap();
}
