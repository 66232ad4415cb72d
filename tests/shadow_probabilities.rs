//! Which lights the samples of `shadow_rays/all_ways.glsl` end at: how often, against probabilities summed on the CPU way by
//! way, and what the shader takes the probability of each for.

mod common;

use common::compare::{Verdict, within};
use common::rooms::{lamp_room, surface};
use glam::{IVec3, UVec3, Vec3};
use gridlight::color::luminance;
use gridlight::cpu::count_lights::{LevelTable, TABLE_WORDS};
use gridlight::cpu::grid::{Grid, corner, trilinear_weight};
use gridlight::cpu::lights::{Clamp, LightList, blend_weight, light_response};
use gridlight::cpu::merge_lights::original_light;
use gridlight::passes::lgh_shape::LghShape;
use gridlight::renderer::{Fresh, Job, Renderer, UploadedScene};
use gridlight::scene::bvh::build_binary;
use gridlight::scene::{Light, Scene};
use gridlight::settings::{LightSet, Lobe, Settings, ShadowEstimate, ShadowFilter, Size, Switch};
use gridlight::shared::{GridLight, GridPlacement};
use gridlight::techniques::lgh::HierarchyOutputs;

const ALBEDO: f32 = 0.5;
const LIGHTS: usize = 40;
const FRAMES: u32 = 150;
/// Ratio of green to red from light to light, by which a sample tells its light.
const HUE_STEP: f32 = 1.06;
/// Share of the samples that start elsewhere than at a reservoir's light (`ELSEWHERE_SHARE`).
const ELSEWHERE: f64 = 0.125;
/// 40 degrees of freedom: exceeded once in ten thousand times. The draws are fixed by the seed.
const CHI_SQUARE_LIMIT: f64 = 81.0;
/// Positions come from depth on one side and from a ray on the other.
const PROBABILITY_TOLERANCE: f64 = 5e-3;

/// A room with many lamps of different colours, some of them in one cell of the finest grid. Nothing stands in their light.
fn room() -> Scene {
    let mut scene = lamp_room(Vec3::splat(ALBEDO));
    let part = |i: usize, factor: f32| (i as f32 * factor).fract();
    scene.lights = (0..LIGHTS)
        .map(|i| {
            // Every fourth lamp hangs right beside the one before it.
            let at = if i % 4 == 3 { i - 1 } else { i };
            let place = Vec3::new(part(at, 0.618_034), part(at, 0.754_878), part(at, 0.569_84)) * 3.0 - 1.5;
            let brightness = 10.0_f32.powf(part(i, 0.3));
            let hue = Vec3::new(1.0, HUE_STEP.powi(i as i32 - LIGHTS as i32 / 2), 1.0);
            Light::Point { position_ws: place + Vec3::splat(0.05 * (i - at) as f32), intensity: hue * brightness }
        })
        .collect();
    scene
}

fn settings(alpha: f32) -> Settings {
    Settings::default().changed(|s| {
        s.picture.size = Size { width: 24, height: 16 };
        s.render.direct = Switch::Off;
        s.many_lights.lights = LightSet::Scene;
        s.many_lights.shadow_samples = 1;
        s.lgh.alpha = alpha;
        s.lgh.shadow_estimate = Some(ShadowEstimate::Unbiased);
        s.lgh.filter = ShadowFilter::None;
    })
}

/// What lit the frames.
struct Hierarchy {
    grid: Grid,
    table: LevelTable,
    lights: Vec<GridLight>,
    originals: LightList,
    clamp: Clamp,
}

impl Hierarchy {
    fn read(renderer: &Renderer, settings: &Settings) -> Self {
        let outputs = renderer.outputs().technique.of::<HierarchyOutputs>().unwrap();
        let read = |buffer| renderer.executor().read_buffer(buffer).unwrap();
        let placement: Vec<GridPlacement> = bytemuck::pod_collect_to_vec(&read(outputs.placement));
        let words: Vec<u32> = bytemuck::pod_collect_to_vec(&read(outputs.grid.level_table));
        let levels = renderer.shapes().of::<LghShape>().unwrap().levels;
        let mut originals = LightList {
            positions: bytemuck::pod_collect_to_vec(&read(outputs.lights.positions)),
            fluxes: bytemuck::pod_collect_to_vec(&read(outputs.lights.fluxes)),
        };
        originals.positions.truncate(LIGHTS);
        originals.fluxes.truncate(LIGHTS);
        Self {
            grid: Grid { placement: placement[0], levels, center: settings.lgh.center },
            table: LevelTable(words[..TABLE_WORDS].try_into().unwrap()),
            lights: bytemuck::pod_collect_to_vec(&read(outputs.grid.lights)),
            originals,
            clamp: Clamp::of(renderer.frame_data()),
        }
    }

    fn at_vertex(&self, vertex: UVec3, level: u32) -> Option<usize> {
        let index = self.grid.vertex_index(vertex, level);
        self.table.range(level).find(|light| self.lights[*light].vertex == index)
    }

    /// The lights around a position on a level, with the position's trilinear weights.
    fn around(&self, position_ws: [f32; 3], level: u32) -> Vec<(usize, f64)> {
        let cells = self.grid.grid_position(position_ws, level);
        let cell = self.grid.cell_of(cells, level);
        let fraction = cells - cell.as_vec3();
        let weighted =
            |i| Some((self.at_vertex(cell + corner(i), level)?, trilinear_weight(fraction, corner(i)).into()));
        (0..8).filter_map(weighted).collect()
    }

    /// With which probability the way down from each grid light ends at each light.
    fn ways_down(&self) -> Vec<[f64; LIGHTS]> {
        let mut ends = vec![[0.0; LIGHTS]; self.lights.len()];
        (0..LIGHTS).for_each(|j| {
            for (light, weight) in self.around(self.originals.position(j), 1) {
                ends[light][j] = weight * f64::from(luminance(self.originals.flux(j)));
            }
        });
        self.table.range(1).for_each(|light| normalise(&mut ends[light]));
        for level in 2..=self.grid.levels.top {
            for light in self.table.range(level) {
                let mut sum = [0.0; LIGHTS];
                for (part, share) in self.parts(light, level) {
                    let weight = share * f64::from(self.lights[part].luminance);
                    (0..LIGHTS).for_each(|j| sum[j] += weight * ends[part][j]);
                }
                normalise(&mut sum);
                ends[light] = sum;
            }
        }
        ends
    }

    /// The lights of the level below that a light is made of, with their shares.
    fn parts(&self, light: usize, level: u32) -> Vec<(usize, f64)> {
        let middle = 2 * self.grid.vertex_from_index(self.lights[light].vertex, level).as_ivec3();
        let last = self.grid.levels.vertices_per_axis(level - 1) as i32 - 1;
        let steps = (0..27).map(|i| IVec3::new(i % 3, i / 3 % 3, i / 9) - 1);
        let inside =
            steps.filter(|step| ((middle + step).cmpge(IVec3::ZERO) & (middle + step).cmple(IVec3::splat(last))).all());
        let part = |step: IVec3| {
            let part = self.at_vertex((middle + step).as_uvec3(), level - 1)?;
            Some((part, 0.5_f64.powi(step.abs().element_sum())))
        };
        inside.filter_map(part).collect()
    }

    /// What every grid light is chosen for at a receiver: its luminance times what it sends.
    fn weights(&self, position: Vec3, normal: Vec3, alpha: f32) -> Vec<f64> {
        let top = self.grid.levels.top;
        let weight = |light: &GridLight| {
            let offset = Vec3::from(light.position_ws) - position;
            let radius = alpha * self.grid.cell_size(light.level);
            let blended = blend_weight(offset.length(), radius, light.level, 1, top);
            let response =
                light_response(offset, normal, Vec3::from(light.lobe), Lobe::Mixture, self.clamp.of_light(light));
            f64::from(light.luminance * blended * response)
        };
        self.lights[..self.table.range(top).end].iter().map(weight).collect()
    }

    /// With which probability a sample at a receiver is each light.
    fn probabilities(&self, ends: &[[f64; LIGHTS]], weights: &[f64], position: Vec3) -> [f64; LIGHTS] {
        let mut sum = [0.0; LIGHTS];
        let mut add = |light: usize, p: f64| (0..LIGHTS).for_each(|j| sum[j] += p * ends[light][j]);
        let all: f64 = weights.iter().sum();
        let elsewhere = if all > 0.0 { ELSEWHERE } else { 1.0 };
        if all > 0.0 {
            weights.iter().enumerate().for_each(|(light, f)| add(light, (1.0 - elsewhere) * f / all));
        }
        let top = self.grid.levels.top;
        let of_level = elsewhere / f64::from(top);
        for level in 1..top {
            self.around(position.to_array(), level).iter().for_each(|(light, weight)| add(*light, of_level * weight));
        }
        let brightness = |light: usize| f64::from(self.lights[light].luminance);
        let all: f64 = self.table.range(top).map(brightness).sum();
        self.table.range(top).for_each(|light| add(light, of_level * brightness(light) / all));
        sum
    }

    /// What light `j` sends to a receiver, in red.
    fn sent(&self, j: usize, position: Vec3, normal: Vec3) -> f64 {
        let light = original_light(&self.originals, j);
        let offset = Vec3::from(light.position_ws) - position;
        let clamp_squared = self.clamp.of_light(&light);
        let response = light_response(offset, normal, Vec3::from(light.lobe), Lobe::Mixture, clamp_squared);
        f64::from(ALBEDO * response * light.flux[0])
    }
}

fn normalise(values: &mut [f64]) {
    let sum: f64 = values.iter().sum();
    assert!(sum > 0.0, "a grid light without lights");
    values.iter_mut().for_each(|value| *value /= sum);
}

/// What was drawn, and what should have been.
struct Draws {
    /// Per frame how many pixels drew each light.
    counts: Vec<[f64; LIGHTS]>,
    /// Per pixel the probability of each light that sends it something.
    expected: Vec<[f64; LIGHTS]>,
    /// Of each sample pixel, light, and the probability that the shader took it for.
    taken_for: Vec<(usize, usize, f64)>,
}

/// The light that a sample of this colour is, if it is any.
fn light_of(radiance: &[f32]) -> Option<usize> {
    let ratio = (radiance[0] > 0.0).then(|| (radiance[1] / radiance[0]).ln() / HUE_STEP.ln())?;
    let index = ratio + (LIGHTS / 2) as f32;
    assert!((index - index.round()).abs() < 0.1, "a colour that no light has: {radiance:?}");
    Some(index.round() as usize)
}

fn draw(alpha: f32) -> Draws {
    let (test, scene, settings) = (common::gpu(), room(), settings(alpha));
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    let mut renderer = Renderer::new(&Job::new(&test.gpu, &uploaded, &scene.cameras[0], &settings)).unwrap();
    let pictures: Vec<Vec<f32>> = (0..FRAMES)
        .map(|number| {
            renderer.set_accumulated_frame(number, Fresh::Shadows);
            let ticket = renderer.submit().unwrap();
            renderer.wait(ticket).unwrap();
            renderer.read_radiance().unwrap()
        })
        .collect();
    let hierarchy = Hierarchy::read(&renderer, &settings);
    let (bvh, ends, size) = (build_binary(&scene), hierarchy.ways_down(), settings.picture.size);
    let receivers: Vec<(Vec3, Vec3, f32)> =
        (0..(size.width * size.height) as usize).map(|i| surface(&bvh, &scene.cameras[0], size, i)).collect();
    let expected = receivers.iter().map(|(position, normal, _)| {
        let weights = hierarchy.weights(*position, *normal, alpha);
        let all = hierarchy.probabilities(&ends, &weights, *position);
        std::array::from_fn(|j| if hierarchy.sent(j, *position, *normal) > 0.0 { all[j] } else { 0.0 })
    });
    let mut draws = Draws { expected: expected.collect(), counts: Vec::new(), taken_for: Vec::new() };
    for picture in pictures {
        let mut counts = [0.0; LIGHTS];
        for (pixel, radiance) in picture.chunks_exact(3).enumerate() {
            let Some(light) = light_of(radiance) else { continue };
            counts[light] += 1.0;
            let (position, normal, _) = receivers[pixel];
            let sent = hierarchy.sent(light, position, normal);
            draws.taken_for.push((pixel, light, sent / f64::from(radiance[0])));
        }
        draws.counts.push(counts);
    }
    draws
}

/// Whether lights are drawn as often as expected. Samples of one frame share the representatives of cells, so frames are what
/// is independent: each light's mean over them, in units of its own standard error.
fn check_counts(draws: &Draws) -> Verdict {
    let frames = draws.counts.len() as f64;
    let chi_square: f64 = (0..LIGHTS)
        .map(|j| {
            let expected: f64 = draws.expected.iter().map(|pixel| pixel[j]).sum();
            let mean = draws.counts.iter().map(|counts| counts[j]).sum::<f64>() / frames;
            let variance = draws.counts.iter().map(|counts| (counts[j] - mean).powi(2)).sum::<f64>() / (frames - 1.0);
            (mean - expected).powi(2) * frames / variance
        })
        .sum();
    if within(chi_square, CHI_SQUARE_LIMIT) { Ok(()) } else { Err(format!("chi-square {chi_square}")) }
}

/// Whether the shader takes lights for as probable as they are, but at the odd pixel on an edge.
fn check_probabilities(draws: &Draws) -> Verdict {
    let wrong = |&&(pixel, light, p): &&(usize, usize, f64)| {
        let expected = draws.expected[pixel][light];
        !within(p - expected, PROBABILITY_TOLERANCE * expected)
    };
    let count = draws.taken_for.iter().filter(wrong).count();
    let first = draws.taken_for.iter().find(wrong).map(|(pixel, light, p)| (p, draws.expected[*pixel][*light]));
    let all = draws.taken_for.len();
    if all > 0 && count <= all / 200 { Ok(()) } else { Err(format!("{count} of {all} are wrong, first {first:?}")) }
}

#[test]
fn lights_are_drawn_with_the_probabilities_that_they_are_weighted_by() {
    for alpha in [0.5, 2.0] {
        let draws = draw(alpha);
        check_probabilities(&draws).unwrap_or_else(|e| panic!("alpha {alpha}: {e}"));
        check_counts(&draws).unwrap_or_else(|e| panic!("alpha {alpha}: {e}"));
    }
}

#[test]
fn planted_faults_are_noticed() {
    let mut draws = draw(1.0);
    check_probabilities(&draws).unwrap();
    let brightest = |draws: &Draws| {
        let sum = |j: usize| draws.expected.iter().map(|pixel| pixel[j]).sum::<f64>();
        (0..LIGHTS).max_by(|a, b| sum(*a).total_cmp(&sum(*b))).unwrap()
    };
    let j = brightest(&draws);
    draws.expected.iter_mut().for_each(|pixel| pixel[j] *= 1.25);
    assert!(check_counts(&draws).is_err(), "a light that is drawn too seldom");
    draws.expected.iter_mut().for_each(|pixel| pixel[j] /= 1.25);
    check_counts(&draws).unwrap();
    for (fault, factor) in [("a weight that is wrong by a hundredth", 1.01), ("no number", f64::NAN)] {
        draws.taken_for.iter_mut().for_each(|(_, _, p)| *p *= factor);
        assert!(check_probabilities(&draws).is_err(), "{fault}");
    }
    draws.expected[0][j] = f64::NAN;
    assert!(check_counts(&draws).is_err(), "an expectation that is no number");
}
