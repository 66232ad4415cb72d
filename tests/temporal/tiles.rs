//! Where the light of tiles has changed (`shaders/temporal/sum_tiles.comp.glsl`, `compare_tiles.comp.glsl`).

use glam::Vec3;
use gridlight::scene::{Light, Scene};
use gridlight::settings::{Antilag, LghSettings, Settings, ShadowEstimate, Size, Temporal};
use gridlight::uploaded_scene::UploadedScene;

use crate::area_lights::{AREA_LIGHTS, AreaLight, area_settings, lit_scene};
use crate::common::compare::Verdict;
use crate::common::picture::{Frame, SIZES, Texel, compare_texels};
use crate::common::rooms::furnished_room;
use crate::common::{GpuTest, gpu};
use crate::run::{Run, settings};

/// Sums of 64 floats, and a difference of two of them over its noise.
const TOLERANCE: [f64; 2] = [1e-4, 1e-4];

/// How tiles are compared.
#[derive(Clone, Copy)]
struct Comparison {
    least_weight: f64,
    known_frames: f64,
    most_deviation: f64,
    /// Standard deviations that are no noise in part, and wholly: of a frame, and of a drift.
    limits: [[f64; 2]; 2],
    /// What standard deviations of a single tile and frame count.
    of_one: f64,
    /// What a tile counts at most among those around another, and a frame in the drift.
    most_counted: f64,
    /// Weight of the newest frame in the drift, and what a drift gives up at most.
    drift_weight: f64,
    most_by_drift: f64,
    /// Tiles on either side of one that are looked at together with it.
    reach: i32,
    /// Squared difference that is noise, in variances.
    noise: f64,
}

impl Comparison {
    /// How far a tile's light is above its history, and how far the last few frames are, in standard deviations.
    fn difference(&self, sum: Texel, before: Texel) -> [f64; 2] {
        let of_frame = (sum[0] - sum[1]) / deviation_of(sum, before);
        [of_frame, before[2] + self.drift_weight * (self.counted(of_frame) - before[2])]
    }

    fn counted(&self, deviations: f64) -> f64 {
        deviations.clamp(-self.most_counted, self.most_counted)
    }

    /// Standard deviation of a drift that is noise.
    fn drift_deviation(&self, [_, _, unit, per_frame]: Texel) -> f64 {
        let of_history = per_frame / unit;
        ((self.drift_weight / (2.0 - self.drift_weight) + of_history) / (1.0 + of_history)).sqrt()
    }

    /// What is given up for a frame's difference of so many standard deviations, and for that of a drift.
    fn given_up(&self, deviations: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|of| {
            let [least, most] = self.limits[of];
            let along = ((deviations[of].abs() - least) / (most - least)).clamp(0.0, 1.0);
            along * along * (3.0 - 2.0 * along)
        })
    }
}

const COMPARISON: Comparison = Comparison {
    least_weight: 0.1,
    known_frames: 8.0,
    most_deviation: 9.0,
    limits: [[4.0, 6.0], [3.0, 5.0]],
    of_one: 0.3,
    most_counted: 4.0,
    drift_weight: 0.25,
    most_by_drift: 0.2,
    reach: 1,
    noise: 1.0,
};

/// While lights or surfaces move.
const IN_MOTION: Comparison =
    Comparison { limits: [COMPARISON.limits[0], [1.5, 3.5]], most_by_drift: 0.5, ..COMPARISON };

/// Two frames that follow each other.
struct Pair {
    before: Frame,
    now: Frame,
    keeps_light: bool,
    /// Begins the names of passes and images; empty for shadows.
    label: &'static str,
}

fn luminance(color: Texel) -> f64 {
    0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2]
}

impl Pair {
    /// The twelfth frame and the one before it, between which the camera moves.
    fn of(test: &GpuTest, size: Size, mode: Temporal) -> Self {
        let settings = settings(size, mode, ShadowEstimate::Corrected).changed(|s| s.lgh.antilag = Antilag::Tiles);
        let mut run = Run::new(&test.gpu, &furnished_room(), &settings);
        (0..11).for_each(|_| run.next());
        let before = run.last();
        run.step_right(0.08);
        run.next();
        Self { before, now: run.last(), keeps_light: mode == Temporal::Indirect, label: "" }
    }

    /// The same of the light that comes straight from the environment, or from surfaces that shine.
    fn of_area_light(test: &GpuTest, size: Size, light: AreaLight) -> Self {
        let mut run = Run::new(&test.gpu, &lit_scene(), &area_settings(size, Temporal::Shadows));
        (0..11).for_each(|_| run.next());
        let before = run.last();
        run.step_right(0.08);
        run.next();
        Self { before, now: run.last(), keeps_light: false, label: light.label }
    }

    /// The twelfth frame, before which the lamp has turned, and the one before it.
    fn of_a_turned_lamp(test: &GpuTest) -> Self {
        let mut run = Run::new(&test.gpu, &lit_from(-1.0), &lamp_settings(Antilag::Tiles));
        (0..11).for_each(|_| run.next());
        let before = run.last();
        let turned = UploadedScene::new(&test.gpu, &lit_from(1.0)).unwrap();
        run.renderer.update_lights(turned.other_lights()).unwrap();
        run.next();
        Self { before, now: run.last(), keeps_light: false, label: "" }
    }

    /// The fourteenth frame and the one before it, while the lamp turns little by little.
    fn of_a_turning_lamp(test: &GpuTest) -> Self {
        let mut run = Run::new(&test.gpu, &lit_from(-1.0), &lamp_settings(Antilag::Tiles));
        (0..10).for_each(|_| run.next());
        let mut before = run.last();
        for step in 1..=4 {
            before = run.last();
            let turned = UploadedScene::new(&test.gpu, &lit_from(0.1 * step as f32 - 1.0)).unwrap();
            run.renderer.update_lights(turned.other_lights()).unwrap();
            run.next();
        }
        Self { before, now: run.last(), keeps_light: false, label: "" }
    }

    fn tiles(&self, frame: &Frame) -> Vec<Texel> {
        frame.floats(&format!("temporal/{}compare_tiles", self.label), &format!("{}temporal_tiles", self.label))
    }

    /// An image that a pass of the last frame left.
    fn left(&self, pass: &str, image: &str) -> Vec<Texel> {
        self.now.floats(&format!("temporal/{}{pass}", self.label), &format!("{}{image}", self.label))
    }

    /// Both estimates of the last frame.
    fn estimates(&self) -> [Vec<Texel>; 2] {
        let pass = if self.label.is_empty() { "shadow_rays" } else { &format!("{}light", self.label) };
        ["shadowed", "unshadowed"].map(|what| self.now.floats(pass, &format!("{}{what}", self.label)))
    }

    fn size(&self) -> [i32; 2] {
        [self.now.size.width, self.now.size.height].map(|edge| edge as i32)
    }

    /// Light of the frame, of the history, their unit, and that over the frames in the history, of all tiles.
    fn sums(&self) -> Vec<Texel> {
        self.sums_per(&self.left("reproject", "reprojected_unshadowed"))
    }

    /// The same; the unit of light by itself is `arrived`.
    fn sums_per(&self, arrived: &[Texel]) -> Vec<Texel> {
        let now = &self.now;
        let [shadowed, unshadowed] = self.estimates();
        let before = self.left("reproject", "reprojected_shadowed");
        let is_radiance = !self.label.is_empty();
        let sum = |(column, row): (i32, i32)| {
            let pixels = (0..64).filter_map(|i| now.surfaces.index(8 * column + i % 8, 8 * row + i / 8));
            pixels.filter(|i| before[*i][3] > 0.0).fold([0.0; 4], |[light, kept, units, per_frame], i| {
                let unit = if is_radiance { luminance(arrived[i]) } else { unshadowed[i][3] };
                let of_history = luminance(before[i]) * if self.keeps_light || is_radiance { 1.0 } else { unit };
                [
                    light + luminance(shadowed[i]) * if is_radiance { 1.0 } else { unit },
                    kept + of_history,
                    units + unit,
                    per_frame + unit / before[i][3],
                ]
            })
        };
        self.all_tiles().map(sum).collect()
    }

    /// Columns and rows of tiles.
    fn tile_count(&self) -> [i32; 2] {
        self.size().map(|edge| (edge as u32).div_ceil(8) as i32)
    }

    fn all_tiles(&self) -> impl Iterator<Item = (i32, i32)> {
        let [columns, rows] = self.tile_count();
        (0..rows).flat_map(move |row| (0..columns).map(move |column| (column, row)))
    }

    /// What the frame before knows of where the middle of a tile was.
    fn tile_before(&self, column: i32, row: i32) -> Texel {
        let [width, height] = self.size();
        let middle = [(8 * column + 4).min(width - 1), (8 * row + 4).min(height - 1)];
        let index = self.now.surfaces.index(middle[0], middle[1]).unwrap();
        let motion = self.now.floats("gbuffer", "gbuffer_motion")[index];
        let [x, y] = [0, 1].map(|axis| f64::from(middle[axis]) + motion[axis]);
        let inside = x >= 0.0 && y >= 0.0 && x < f64::from(width) && y < f64::from(height);
        let tile = y as usize / 8 * (width as usize).div_ceil(8) + x as usize / 8;
        if inside { self.tiles(&self.before)[tile] } else { [0.0; 4] }
    }

    /// What a tile gives up for those around it: for their frames, and for their drift.
    fn given_up_by_group(&self, sums: &[Texel], (column, row): (i32, i32), by: Comparison) -> [f64; 2] {
        let [columns, rows] = self.tile_count();
        let steps = -by.reach..=by.reach;
        let around = steps.clone().flat_map(|y| steps.clone().map(move |x| (column + x, row + y)));
        let inside = around.filter(|(x, y)| (0..columns).contains(x) && (0..rows).contains(y));
        let known: Vec<_> = inside
            .filter_map(|(x, y)| {
                let (sum, before) = (sums[(y * columns + x) as usize], self.tile_before(x, y));
                let [of_frame, drift] = by.difference(sum, before);
                let deviations = [by.counted(of_frame), drift / by.drift_deviation(sum)];
                (sum[2] > 0.0 && before[3] >= by.known_frames).then(|| (deviations, deviation_of(sum, before)))
            })
            .collect();
        let variance: f64 = known.iter().map(|(_, deviation)| deviation * deviation).sum();
        if variance <= 0.0 {
            return [0.0; 2];
        }
        let sums_of = |of: usize| {
            let above: f64 = known.iter().map(|(deviations, deviation)| deviations[of] * deviation).sum();
            let squares: f64 = known.iter().map(|(deviations, _)| deviations[of] * deviations[of]).sum();
            let no_noise = (1.0 - by.noise * known.len() as f64 / squares.max(1e-30)).max(0.0);
            (above / variance.sqrt(), no_noise)
        };
        let [frame, drift] = [0, 1].map(sums_of);
        let [for_frame, for_drift] = by.given_up([frame.0, drift.0]);
        [for_frame * frame.1, for_drift * drift.1]
    }

    /// The tiles, and what they give up.
    fn twin(&self, sums: &[Texel], by: Comparison) -> [Vec<Texel>; 2] {
        let tile = |((column, row), sum): ((i32, i32), &Texel)| {
            let [light, _, unit, _] = *sum;
            if unit <= 0.0 {
                return ([0.0; 4], [0.0; 4]);
            }
            let mean = light / unit;
            let before = self.tile_before(column, row);
            let [mean_before, variance, _, frames] = before;
            if frames <= 0.0 {
                return ([mean, 0.0, 0.0, 1.0], [0.0; 4]);
            }
            let is_known = frames >= by.known_frames;
            let deviation = 0.5 * (mean - mean_before).powi(2);
            let at_most = if is_known { by.most_deviation * variance.max(1e-6) } else { f64::INFINITY };
            let [of_frame, drift] = if is_known { by.difference(*sum, before) } else { [0.0; 2] };
            let of_tile = by.given_up([by.of_one * of_frame, drift / by.drift_deviation(*sum)]);
            let of_group = self.given_up_by_group(sums, (column, row), by);
            let [for_frame, for_drift] = [0, 1].map(|of| of_tile[of].max(of_group[of]));
            let given_up = for_frame.max(for_drift.min(by.most_by_drift));
            let weight = (1.0 / frames).max(by.least_weight);
            let variance = variance + weight * (deviation.min(at_most) - variance);
            let known = [mean, variance, drift * (1.0 - given_up), frames + 1.0];
            (known, [given_up, 0.0, 0.0, 0.0])
        };
        self.all_tiles().zip(sums).map(tile).collect::<(Vec<_>, Vec<_>)>().into()
    }

    fn check(&self, by: Comparison) -> Verdict {
        let sums = self.sums();
        compare_texels("sums", &self.left("sum_tiles", "tile_sums"), &sums, 4, TOLERANCE)?;
        let [tiles, given_up] = self.twin(&sums, by);
        compare_texels("tiles", &self.tiles(&self.now), &tiles, 4, TOLERANCE)?;
        compare_texels("given up", &self.left("compare_tiles", "given_up"), &given_up, 4, TOLERANCE)
    }
}

/// Standard deviation of the difference between a tile's light and its history, which has noise of its own.
fn deviation_of([_, _, unit, per_frame]: Texel, [_, variance, _, _]: Texel) -> f64 {
    unit * ((variance + 1e-6) * (1.0 + per_frame / unit)).sqrt()
}

/// What is planted, and how.
type Fault = (&'static str, fn(&mut Comparison));

#[test]
fn tiles_are_compared_by_the_formula() {
    let test = gpu();
    for (size, mode) in SIZES.into_iter().zip([Temporal::Shadows, Temporal::Indirect].into_iter().cycle()) {
        Pair::of(&test, size, mode).check(COMPARISON).unwrap_or_else(|e| panic!("{size}, {mode:?}: {e}"));
    }
}

#[test]
fn tiles_of_light_by_itself_are_compared_by_the_formula() {
    let test = gpu();
    for (size, light) in SIZES.into_iter().flat_map(|size| AREA_LIGHTS.map(|light| (size, light))) {
        let verdict = Pair::of_area_light(&test, size, light).check(COMPARISON);
        verdict.unwrap_or_else(|e| panic!("{size}, {}: {e}", light.label));
    }
    // Its unit is what arrives without shadow, as the frames before have it.
    for light in AREA_LIGHTS {
        let pair = Pair::of_area_light(&test, SIZES[4], light);
        let sums = pair.sums_per(&pair.estimates()[1]);
        let found = compare_texels("sums", &pair.left("sum_tiles", "tile_sums"), &sums, 4, TOLERANCE);
        assert!(found.is_err(), "{}: a unit of the frame itself was not noticed", light.label);
    }
}

#[test]
fn other_comparisons_are_noticed() {
    let test = gpu();
    let moved = Pair::of(&test, SIZES[4], Temporal::Shadows);
    let [turned, turning] = [Pair::of_a_turned_lamp(&test), Pair::of_a_turning_lamp(&test)];
    turned.check(IN_MOTION).unwrap();
    turning.check(IN_MOTION).unwrap();
    assert!(turning.check(COMPARISON).is_err(), "the limits of what stands were not noticed");
    let faults: [Fault; 7] = [
        ("a shorter memory", |by| by.least_weight = 0.2),
        ("variances that are known later", |by| by.known_frames = 20.0),
        ("steps that count less", |by| by.most_deviation = 0.01),
        ("lower limits of a frame", |by| by.limits[0] = [0.0, 0.5]),
        ("lower limits of a drift", |by| by.limits[1] = [0.0, 0.5]),
        ("single frames that count more", |by| by.of_one = 9.0),
        ("a drift of fewer frames", |by| by.drift_weight = 0.3),
    ];
    let of_steps: [Fault; 3] = [
        ("differences that are all change", |by| by.noise = 0.0),
        ("tiles without those around them", |by| by.reach = 0),
        ("tiles that count less in their group", |by| by.most_counted = 1.0),
    ];
    let of_drifts: [Fault; 1] = [("drifts that give up less", |by| by.most_by_drift = 0.1)];
    let faults = faults.map(|fault| (&moved, COMPARISON, fault)).into_iter();
    let faults = faults.chain(of_steps.map(|fault| (&turned, IN_MOTION, fault)));
    for (pair, mut comparison, (what, plant)) in faults.chain(of_drifts.map(|fault| (&turning, IN_MOTION, fault))) {
        plant(&mut comparison);
        assert!(pair.check(comparison).is_err(), "{what} were not noticed");
    }
}

#[test]
fn lighting_stands_while_only_the_camera_moves() {
    let test = gpu();
    let mut run = Run::new(&test.gpu, &lit_from(-1.0), &lamp_settings(Antilag::Tiles));
    let mut stands = |change: &dyn Fn(&mut Run)| {
        change(&mut run);
        run.next();
        run.renderer.frame_data().lighting_stands
    };
    assert_eq!(stands(&|_| ()), 0, "a first frame follows nothing");
    assert_eq!(stands(&|_| ()), 1);
    assert_eq!(stands(&|run| run.step_right(0.08)), 1);
    let turned = UploadedScene::new(&test.gpu, &lit_from(1.0)).unwrap();
    assert_eq!(stands(&|run| run.renderer.update_lights(turned.other_lights()).unwrap()), 0);
}

/// The furnished room under a lamp that shines on one of its sides.
pub fn lit_from(side: f32) -> Scene {
    let mut scene = furnished_room();
    scene.lights = vec![Light::Spot {
        position_ws: Vec3::new(0.0, 0.2, 0.0),
        direction_ws: Vec3::new(side, -0.9, 0.0).normalize(),
        intensity: Vec3::new(9.0, 7.0, 4.0),
        inner_cos: 0.95,
        outer_cos: 0.8,
    }];
    scene
}

/// Means of the picture's blocks of 8x8 pixels, in a size of whole blocks.
fn blocks(radiance: &[f32], size: Size) -> Vec<f64> {
    let columns = size.width as usize / 8;
    let mut sums = vec![0.0; columns * (size.height as usize / 8)];
    for (index, color) in radiance.chunks_exact(3).enumerate() {
        let (x, y) = (index % size.width as usize, index / size.width as usize);
        sums[y / 8 * columns + x / 8] += f64::from(color[1]) / 64.0;
    }
    sums
}

/// A size of whole tiles.
const LAMP_SIZE: Size = Size { width: 64, height: 40 };

/// Frames that show the lamp.
pub fn lamp_settings(antilag: Antilag) -> Settings {
    settings(LAMP_SIZE, Temporal::Shadows, ShadowEstimate::Ratio).changed(|s| {
        (s.lgh.antilag, s.many_lights.shadow_samples) = (antilag, 4);
        s.many_lights.vpls = 2000;
    })
}

/// How far the picture is from that of frames which have always had the light there is, some frames after the lamp has
/// turned, or in the same frame where it has not, as a share of it; and the share of tiles that give something up there.
fn lag(test: &GpuTest, antilag: Antilag, turns: bool) -> [f64; 2] {
    let settings = lamp_settings(antilag);
    let [left, right] = [-1.0, 1.0].map(lit_from);
    let lamps = UploadedScene::new(&test.gpu, &right).unwrap();
    let picture = |from: &Scene, turns: bool| {
        let mut run = Run::new(&test.gpu, from, &settings);
        let mut given_up = 0.0;
        for frame in 0..28 {
            if turns && frame == 24 {
                run.renderer.update_lights(lamps.other_lights()).unwrap();
            }
            run.next();
            let tiles: Option<Vec<[f32; 4]>> = run.last().written.get("temporal/compare_tiles", "given_up");
            let tiles = tiles.unwrap_or_default();
            if frame >= 8 && !tiles.is_empty() {
                let share = tiles.iter().filter(|tile| tile[0] > 0.0).count() as f64 / tiles.len() as f64;
                given_up += share / 20.0;
            }
        }
        (blocks(&run.radiance(), LAMP_SIZE), given_up)
    };
    let plain = Settings { lgh: LghSettings { antilag: Antilag::Off, ..settings.lgh.clone() }, ..settings.clone() };
    let mut run = Run::new(&test.gpu, if turns { &left } else { &right }, &plain);
    for frame in 0..28 {
        if turns && frame == 0 {
            run.renderer.update_lights(lamps.other_lights()).unwrap();
        }
        run.next();
    }
    let truth = blocks(&run.radiance(), LAMP_SIZE);
    let (found, given_up) = picture(if turns { &left } else { &right }, turns);
    let apart: f64 = found.iter().zip(&truth).map(|(a, b)| (a - b).abs()).sum();
    [apart / truth.iter().sum::<f64>(), given_up]
}

#[test]
fn light_that_has_changed_is_noticed_and_noise_is_not() {
    let test = gpu();
    let [without, _] = lag(&test, Antilag::Off, true);
    let [with, _] = lag(&test, Antilag::Tiles, true);
    eprintln!("lag {without} without and {with} with tiles");
    assert!(with <= 0.5 * without && without > 0.02, "{with} with tiles, {without} without");
    let [_, alarms] = lag(&test, Antilag::Tiles, false);
    eprintln!("{alarms} of tiles at rest");
    assert!(alarms <= 0.02, "{alarms} of the tiles give up light at rest");
}
