//! Where the points lie: evenly over all surfaces that can be seen.

use glam::{Vec2, Vec3};

use super::solid::solid_triangles;
use super::surface::Surface;
use crate::scene::Scene;
use crate::scene::octahedral::{pack_octahedral, unpack_octahedral};

/// Candidates over points where holes leave few of them; with even fewer, points stand for several.
const MOST_CANDIDATES: usize = 16;

/// A point, the disc of a piece of surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leaf {
    /// Position, world space.
    pub position_ws: Vec3,
    /// Normal of the triangle, as it is stored.
    pub normal: Vec3,
    /// Diffuse albedo of its piece of surface.
    pub albedo: Vec3,
    /// Triangle of the scene that it lies on.
    pub triangle: u32,
    /// It lies on a closed surface.
    pub is_solid: bool,
}

/// Points, and the area that each stands for.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// The points.
    pub leaves: Vec<Leaf>,
    /// Area of one.
    pub leaf_area: f32,
}

/// A place that may become a point.
#[derive(Clone, Copy)]
struct Candidate {
    triangle: u32,
    barycentrics: Vec2,
}

/// Spreads `count` points; `None` when there is no surface, or all of it is holes.
pub(super) fn sample(scene: &Scene, count: usize) -> Option<Sample> {
    let surface = Surface::new(scene);
    let ends = area_ends(&surface);
    let area = *ends.last()?;
    let mut candidate_count = count;
    let mut kept = candidates(&surface, &ends, candidate_count);
    while kept.len() < count && candidate_count < MOST_CANDIDATES * count {
        let wanted = candidate_count as f64 * count as f64 / kept.len().max(1) as f64;
        candidate_count = ((1.02 * wanted) as usize + 1).min(MOST_CANDIDATES * count);
        kept = candidates(&surface, &ends, candidate_count);
    }
    if kept.is_empty() {
        return None;
    }
    let leaf_area = (area * kept.len() as f64 / (candidate_count as f64 * count as f64)) as f32;
    let is_solid = solid_triangles(scene);
    let leaf = |i: usize| {
        let Candidate { triangle, barycentrics } = kept[(2 * i + 1) * kept.len() / (2 * count)];
        let corners = surface.triangle(triangle as usize);
        Leaf {
            position_ws: corners.position(barycentrics),
            normal: unpack_octahedral(pack_octahedral(corners.normal())),
            albedo: surface.albedo(&corners, barycentrics, leaf_area),
            triangle,
            is_solid: is_solid[triangle as usize],
        }
    };
    Some(Sample { leaves: (0..count).map(leaf).collect(), leaf_area })
}

/// Area of each triangle and all before it.
fn area_ends(surface: &Surface<'_>) -> Vec<f64> {
    let mut sum = 0.0;
    let areas = (0..surface.triangle_count()).map(|index| surface.triangle(index).area());
    areas
        .map(|area| {
            sum += area;
            sum
        })
        .collect()
}

/// The visible ones of `count` places, which lie on the triangles in proportion to their areas.
fn candidates(surface: &Surface<'_>, ends: &[f64], count: usize) -> Vec<Candidate> {
    let area = ends.last().copied().unwrap_or(0.0);
    if !(area > 0.0 && area.is_finite()) {
        return Vec::new();
    }
    let mut triangle = 0;
    let candidate = |i: usize| {
        let place = (i as f64 + 0.5) * area / count as f64;
        while triangle + 1 < ends.len() && ends[triangle] <= place {
            triangle += 1;
        }
        Candidate { triangle: triangle as u32, barycentrics: place_in_triangle(i) }
    };
    let is_visible = |c: &Candidate| surface.is_visible(&surface.triangle(c.triangle as usize), c.barycentrics);
    (0..count).map(candidate).filter(is_visible).collect()
}

/// How far points stay from each edge of their triangle, over its height.
const EDGE_DISTANCE: f64 = 1e-3;

/// Place i of a sequence that covers a triangle evenly, as do its parts that follow each other (Roberts 2018).
fn place_in_triangle(i: usize) -> Vec2 {
    let [x, y] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_2].map(|step| (0.5 + step * i as f64).fract());
    let folded = if x + y > 1.0 { [1.0 - x, 1.0 - y] } else { [x, y] };
    // Off the edges, where what a point sees would depend on roundings.
    Vec2::from(folded.map(|c| (EDGE_DISTANCE + (1.0 - 3.0 * EDGE_DISTANCE) * c) as f32))
}
