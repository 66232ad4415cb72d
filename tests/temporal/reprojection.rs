//! What is found of a surface in the frame before (`shaders/temporal/reproject.comp.glsl`), against its formula.

use gridlight::scene::Scene;
use gridlight::settings::{ShadowEstimate, Size, Temporal};

use crate::common::compare::Verdict;
use crate::common::picture::{Frame, SIZES, Texel, compare_texels};
use crate::common::rooms::{folding_screen, furnished_room};
use crate::common::{GpuTest, gpu};
use crate::run::{Run, settings};

/// Sums of four products of floats.
const TOLERANCE: [f64; 2] = [1e-5, 1e-7];
/// How near its limit a cosine or a share of the reach may round to either side, and a place in pixels.
const UNDECIDED: f64 = 1e-4;

/// What is looked for in the frame before.
#[derive(Clone, Copy)]
struct Search {
    least_cosine: f64,
    plane_footprints: f64,
    least_weight: f64,
    /// Taps beyond the nearest count.
    is_bilinear: bool,
}

const SEARCH: Search =
    Search { least_cosine: 0.906_307_79, plane_footprints: 2.0, least_weight: 0.01, is_bilinear: true };

/// Two frames, between which the camera has moved, and what of the first lasts.
struct Pair {
    before: Frame,
    now: Frame,
}

impl Pair {
    fn of(test: &GpuTest, scene: &Scene, size: Size, mode: Temporal) -> Self {
        let mut run = Run::new(&test.gpu, scene, &settings(size, mode, ShadowEstimate::Corrected));
        run.next();
        run.next();
        let before = run.last();
        run.step_right(0.11);
        run.camera.position_ws += run.camera.forward_ws * 0.07;
        run.next();
        Self { before, now: run.last() }
    }

    /// Histories in the frame before, and what was found of them.
    fn images(&self) -> Vec<(&'static str, Vec<Texel>, Vec<Texel>)> {
        let image = |what: &'static str, pass: &str| {
            let kept: Option<Vec<[f32; 4]>> = self.before.written.get(pass, &format!("temporal_{what}"));
            let kept = kept?.iter().map(|texel| texel.map(f64::from)).collect();
            Some((what, kept, self.now.floats("temporal/reproject", &format!("reprojected_{what}"))))
        };
        let (blend, lighting) = ("temporal/blend", "temporal/blend_lighting");
        [image("shadowed", blend), image("unshadowed", blend), image("lighting", lighting)]
            .into_iter()
            .flatten()
            .collect()
    }

    /// Pixels of the frame before and their weights, which add up to 1; `None` where rounding decides.
    fn taps(&self, by: Search, x: i32, y: i32) -> Option<Vec<(usize, f64)>> {
        let motion: Vec<[f32; 4]> = self.now.written.all("gbuffer", "gbuffer_motion");
        let Some(index) = self.now.surfaces.surface(x, y) else { return Some(Vec::new()) };
        let [dx, dy, nearness, _] = motion[index].map(f64::from);
        if nearness <= 0.0 {
            return Some(Vec::new());
        }
        let surfaces = &self.before.surfaces;
        let at = [f64::from(x) + dx, f64::from(y) + dy];
        let view_z = surfaces.view_z_of(nearness);
        let place = surfaces.place_ws(at, view_z);
        let reach = by.plane_footprints * surfaces.footprint_at(view_z);
        let (normal, plane_normal) = (self.now.surfaces.normal(index), self.now.surfaces.geometric_normal(index));
        let first = at.map(f64::floor);
        let mut taps = Vec::new();
        for corner in [[0, 0], [1, 0], [0, 1], [1, 1]] {
            let along = |axis: usize| {
                let share = at[axis] - first[axis];
                if corner[axis] == 0 { 1.0 - share } else { share }
            };
            let weight = if by.is_bilinear { along(0) * along(1) } else { f64::from(u8::from(corner == [0, 0])) };
            let [px, py] = [0, 1].map(|axis| first[axis] as i32 + corner[axis]);
            let Some(tap) = surfaces.surface(px, py) else { continue };
            let cosine = surfaces.normal(tap).dot(normal) - by.least_cosine;
            let apart = (surfaces.position_ws(px, py, tap) - place).dot(plane_normal).abs() / reach - 1.0;
            if weight > UNDECIDED && (cosine.abs() < UNDECIDED || apart.abs() < 100.0 * UNDECIDED) {
                return None;
            }
            if cosine >= 0.0 && apart <= 0.0 {
                taps.push((tap, weight));
            }
        }
        let total: f64 = taps.iter().map(|(_, weight)| weight).sum();
        if (total - by.least_weight).abs() < UNDECIDED {
            return None;
        }
        let found = if total > by.least_weight { taps } else { Vec::new() };
        Some(found.into_iter().map(|(tap, weight)| (tap, weight / total)).collect())
    }

    /// How many pixels are found, and how many are not.
    fn check(&self, by: Search) -> Result<[usize; 2], String> {
        let taps: Vec<_> = self.now.pixels().map(|(x, y)| self.taps(by, x, y)).collect();
        let undecided = taps.iter().filter(|taps| taps.is_none()).count();
        if undecided > taps.len() / 20 + 1 {
            return Err(format!("{undecided} of {} pixels are undecided", taps.len()));
        }
        for (what, kept, found) in self.images() {
            let twin: Vec<Texel> = taps
                .iter()
                .zip(&found)
                .map(|(taps, found)| taps.as_ref().map_or(*found, |taps| mean(&kept, taps)))
                .collect();
            compare_texels(what, &found, &twin, 4, TOLERANCE)?;
        }
        let hits = taps.iter().flatten().filter(|taps| !taps.is_empty()).count();
        Ok([hits, taps.len() - undecided - hits])
    }
}

fn mean(kept: &[Texel], taps: &[(usize, f64)]) -> Texel {
    let mut sum = [0.0; 4];
    for (tap, weight) in taps {
        (0..4).for_each(|channel| sum[channel] += weight * kept[*tap][channel]);
    }
    sum
}

fn verdict(pair: &Pair, by: Search) -> Verdict {
    pair.check(by).map(|_| ())
}

/// What is planted, and how.
type Fault = (&'static str, fn(&mut Search));

#[test]
fn surfaces_are_found_where_they_were() {
    let test = gpu();
    let (mut hits, mut misses) = (0, 0);
    for size in SIZES {
        for (mode, scene) in [(Temporal::Shadows, furnished_room()), (Temporal::Indirect, folding_screen())] {
            let found = Pair::of(&test, &scene, size, mode).check(SEARCH);
            let [hit, missed] = found.unwrap_or_else(|e| panic!("{size}, {mode:?}: {e}"));
            (hits, misses) = (hits + hit, misses + missed);
        }
    }
    assert!(hits > 500 && misses > 50, "{hits} pixels are found, {misses} are not: the scenes are of no use");
}

#[test]
fn other_searches_are_noticed() {
    let test = gpu();
    let pair = Pair::of(&test, &folding_screen(), SIZES[4], Temporal::Shadows);
    let faults: [Fault; 4] = [
        ("normals that do not matter", |by| by.least_cosine = -2.0),
        ("planes that do not matter", |by| by.plane_footprints = 1e9),
        ("planes that are thinner", |by| by.plane_footprints = 0.02),
        ("the nearest pixel alone", |by| by.is_bilinear = false),
    ];
    for (what, plant) in faults {
        let mut search = SEARCH;
        plant(&mut search);
        assert!(verdict(&pair, search).is_err(), "{what} were not noticed");
    }
    assert!(verdict(&pair, SEARCH).is_ok());
}
