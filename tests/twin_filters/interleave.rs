//! Edges and the blur that takes the n x n pattern out of the lighting (`shaders/interleave`).

use gridlight::settings::{Settings, Size};

use crate::common;
use crate::common::compare::{Verdict, exact};
use crate::common::picture::{Frame, SIZES, Texel, compare_texels};
use crate::common::rooms::{folding_screen, furnished_room};

/// Sums of up to five floats, some in another order.
const TOLERANCE: [f64; 2] = [1e-5, 1e-30];
/// How near its limit a cosine or a distance may round to either side.
const UNDECIDED: f64 = 1e-4;

/// Surfaces that turn by more than this cosine, or leave each other's plane by more than this fraction of the distance to
/// the eye, are different ones.
#[derive(Clone, Copy)]
struct Limits {
    min_cosine: f64,
    max_plane_distance: f64,
}

const LIMITS: Limits = Limits { min_cosine: 0.9, max_plane_distance: 0.01 };

/// Whether the surface breaks between two pixels; `None` where rounding decides.
fn is_edge(frame: &Frame, limits: Limits, a: (i32, i32), b: (i32, i32)) -> Option<bool> {
    let surfaces = &frame.surfaces;
    let (Some(ia), Some(ib)) = (surfaces.surface(a.0, a.1), surfaces.surface(b.0, b.1)) else { return Some(true) };
    let (na, nb) = (surfaces.normal(ia), surfaces.normal(ib));
    let offset = surfaces.position_ws(b.0, b.1, ib) - surfaces.position_ws(a.0, a.1, ia);
    let off_plane = offset.dot(na).abs().max(offset.dot(nb).abs());
    let turned = limits.min_cosine - na.dot(nb);
    let apart = off_plane / surfaces.view_z(ia).min(surfaces.view_z(ib)) - limits.max_plane_distance;
    let undecided = turned.abs() < UNDECIDED || apart.abs() < UNDECIDED * limits.max_plane_distance;
    let surely = turned >= UNDECIDED || apart >= UNDECIDED * limits.max_plane_distance;
    (surely || !undecided).then_some(surely)
}

fn found_edges(frame: &Frame) -> Vec<u32> {
    frame.written.all("interleave/find_edges", "discontinuities")
}

/// Bit 0 where the surface breaks to the right of a pixel, bit 1 where below it.
fn check_edges(frame: &Frame, limits: Limits) -> Verdict {
    let gpu = found_edges(frame);
    let mut undecided = 0;
    let twin: Vec<u32> = frame
        .pixels()
        .zip(&gpu)
        .map(|((x, y), found)| {
            let bit = |bit: u32, other: (i32, i32)| match is_edge(frame, limits, (x, y), other) {
                Some(edge) => u32::from(edge) << bit,
                None => {
                    undecided += 1;
                    found & 1 << bit
                }
            };
            let mut bit = bit;
            bit(0, (x + 1, y)) | bit(1, (x, y + 1))
        })
        .collect();
    exact("edges", &gpu, &twin)?;
    if undecided > gpu.len() / 100 { Err(format!("{undecided} of {} edges are undecided", gpu.len())) } else { Ok(()) }
}

/// One pass of the blur.
struct Blur<'a> {
    frame: &'a Frame,
    edges: Vec<u32>,
    input: Vec<Texel>,
    n: i32,
    /// 0: along x; 1: along y.
    axis: u32,
    /// The input is in the interleaved layout.
    reads_interleaved: bool,
    /// Values count as much as their alpha.
    is_weighted: bool,
    /// Edges stop it.
    stops: bool,
}

impl<'a> Blur<'a> {
    /// The blur of `lighting`, `shadowed` or `unshadowed` along an axis, with what goes into it.
    fn of(frame: &'a Frame, what: &str, axis: u32) -> Self {
        let is_lighting = what == "lighting";
        let input = match axis {
            0 if is_lighting => frame.floats("light_gather", "lighting"),
            0 => frame.floats("shadow_rays", what),
            _ => frame.floats(&format!("interleave/blur_{what}_x"), &format!("{what}_blurred_x")),
        };
        Self {
            frame,
            edges: found_edges(frame),
            input,
            n: frame.n,
            axis,
            reads_interleaved: is_lighting && axis == 0,
            is_weighted: !is_lighting,
            stops: true,
        }
    }

    fn step(&self, x: i32, y: i32, by: i32) -> (i32, i32) {
        if self.axis == 0 { (x + by, y) } else { (x, y + by) }
    }

    /// The value at a pixel of the picture times its weight, with the weight in alpha where values are weighted.
    fn value(&self, (x, y): (i32, i32)) -> Texel {
        let interleaved = self.frame.interleaved_index(x, y);
        let pixel = self.frame.surfaces.index(x, y).unwrap();
        let value = self.input[if self.reads_interleaved { interleaved } else { pixel }];
        let weight = if self.is_weighted { value[3] } else { 1.0 };
        [value[0] * weight, value[1] * weight, value[2] * weight, value[3]]
    }

    /// Pixels up to n that can be reached in a direction without crossing an edge.
    fn reach(&self, x: i32, y: i32, direction: i32) -> i32 {
        let breaks = |steps: &i32| {
            let (a, b) = (self.step(x, y, *steps * direction), self.step(x, y, (*steps + 1) * direction));
            let (Some(_), Some(_)) = (self.frame.surfaces.index(a.0, a.1), self.frame.surfaces.index(b.0, b.1)) else {
                return true;
            };
            // The edge is kept by the pixel before it.
            let before = if direction > 0 { a } else { b };
            let index = self.frame.surfaces.index(before.0, before.1).unwrap();
            self.stops && self.edges[index] & 1 << self.axis != 0
        };
        (0..self.n).find(breaks).unwrap_or(self.n)
    }

    /// Weighted mean of the pixels from `first` to `last` steps away, the outermost by `end_weight`.
    fn mean(&self, (x, y): (i32, i32), first: i32, last: i32, end_weight: f64, only_surfaces: bool) -> Texel {
        let (mut sum, mut total) = ([0.0; 4], 0.0);
        for i in first..=last {
            let at = self.step(x, y, i);
            let there = self.frame.surfaces.surface(at.0, at.1).is_some();
            if only_surfaces && !there {
                continue;
            }
            let weight = if i == first || i == last { end_weight } else { 1.0 };
            let value = self.value(at);
            (0..4).for_each(|channel| sum[channel] += weight * value[channel]);
            total += weight;
        }
        sum.map(|channel| if total > 0.0 { channel / total } else { 0.0 })
    }

    fn blurred(&self, x: i32, y: i32) -> Texel {
        let (n, half) = (self.n, self.n / 2);
        let (back, ahead) = (self.reach(x, y, -1), self.reach(x, y, 1));
        let mut mean = if back >= half && ahead >= half {
            self.mean((x, y), -half, half, 0.5, false)
        } else {
            // Near an edge: n pixels that begin or end there, or all there are.
            let first = if back < half { -back } else { (ahead + 1 - n).max(-back) };
            let last = (first + n - 1).min(ahead);
            let count = last - first + 1;
            let inside = self.mean((x, y), first, last, 1.0, false);
            let across = self.mean((x, y), -half, half, 0.5, true);
            let share = f64::from(count) / f64::from(n);
            if count < n { std::array::from_fn(|i| inside[i] * share + across[i] * (1.0 - share)) } else { inside }
        };
        if self.is_weighted {
            let weight = mean[3].max(1e-30);
            mean[..3].iter_mut().for_each(|channel| *channel /= weight);
        }
        mean
    }

    fn all(&self) -> Vec<Texel> {
        self.frame.pixels().map(|(x, y)| self.blurred(x, y)).collect()
    }
}

const IMAGES: [&str; 3] = ["lighting", "shadowed", "unshadowed"];

fn output(frame: &Frame, what: &str, axis: u32) -> Vec<Texel> {
    let axis = ["x", "y"][axis as usize];
    frame.floats(&format!("interleave/blur_{what}_{axis}"), &format!("{what}_blurred_{axis}"))
}

fn check_blur(blur: &Blur<'_>, what: &str) -> Verdict {
    compare_texels(
        &format!("{what} along {}", blur.axis),
        &output(blur.frame, what, blur.axis),
        &blur.all(),
        4,
        TOLERANCE,
    )
}

fn settings(size: Size, n: u32) -> Settings {
    Settings::default().changed(|s| {
        s.picture.size = size;
        s.lgh.interleave = n;
        s.many_lights.vpls = 500;
        s.many_lights.shadow_samples = 2;
    })
}

#[test]
fn edges_and_blur_are_their_formulas() {
    let test = common::gpu();
    for (name, scene) in [("room", furnished_room()), ("screen", folding_screen())] {
        for (size, n) in SIZES.into_iter().flat_map(|size| [2, 4].map(|n| (size, n))) {
            let frame = Frame::of(&test, &scene, &settings(size, n));
            check_edges(&frame, LIMITS).unwrap_or_else(|e| panic!("{name}, {size}, n {n}: {e}"));
            for (what, axis) in IMAGES.into_iter().flat_map(|what| [(what, 0), (what, 1)]) {
                let verdict = check_blur(&Blur::of(&frame, what, axis), what);
                verdict.unwrap_or_else(|e| panic!("{name}, {size}, n {n}: {e}"));
            }
        }
    }
}

#[test]
fn nothing_is_blurred_without_interleaving() {
    let test = common::gpu();
    let frame = Frame::of(&test, &furnished_room(), &settings(SIZES[4], 1));
    assert!(frame.written.get::<u32>("interleave/find_edges", "discontinuities").is_none());
    assert!(frame.written.get::<[f32; 4]>("interleave/blur_lighting_x", "lighting_blurred_x").is_none());
}

#[test]
fn other_edges_and_blurs_are_noticed() {
    let test = common::gpu();
    let frame = Frame::of(&test, &folding_screen(), &settings(SIZES[4], 4));
    let edges = |limits: Limits| check_edges(&frame, limits).is_err();
    assert!(edges(Limits { min_cosine: -2.0, ..LIMITS }), "no edges where surfaces turn");
    assert!(edges(Limits { max_plane_distance: 0.5, ..LIMITS }), "no edges where surfaces leave their plane");
    let fails = |what: &str, plant: &dyn Fn(&mut Blur<'_>)| {
        for (image, axis) in [("lighting", 0), ("lighting", 1), ("shadowed", 0), ("unshadowed", 1)] {
            let mut blur = Blur::of(&frame, image, axis);
            plant(&mut blur);
            assert!(check_blur(&blur, image).is_err(), "{what} was not noticed in {image} along {axis}");
        }
    };
    fails("a narrower window", &|blur| blur.n = 2);
    fails("a wider window", &|blur| blur.n = 6);
    fails("the other axis", &|blur| blur.axis = 1 - blur.axis);
    fails("edges that do not stop", &|blur| blur.stops = false);
    fails("values wrong by a ten-thousandth", &|blur| blur.input.iter_mut().for_each(|texel| texel[1] *= 1.0001));
    fails("not a number", &|blur| blur.input.iter_mut().step_by(30).for_each(|texel| texel[1] = f64::NAN));
}
