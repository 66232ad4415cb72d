//! Seeded sets of lights: ordinary and degenerate.

use glam::Vec3;
use gridlight::cpu::lights::LightList;
use gridlight::random::{hash, unit_float};
use gridlight::scene::octahedral::pack_octahedral;

/// A stream of random numbers.
pub struct Random(u32);

impl Random {
    /// Starts a stream.
    pub fn new(seed: u32) -> Self {
        Self(hash(seed))
    }

    /// 32 random bits.
    pub fn bits(&mut self) -> u32 {
        self.0 = hash(self.0.wrapping_add(0x9e37_79b9));
        self.0
    }

    /// A number between 0 and 1.
    pub fn unit(&mut self) -> f32 {
        unit_float(self.bits())
    }

    /// A point of the unit cube.
    pub fn point(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit())
    }
}

/// `count` VPLs in a box that is longest along x; every eighth shines in all directions.
pub fn uniform(count: usize, seed: u32) -> LightList {
    shaped(count, seed, |p| Vec3::new(8.0, 4.0, 2.0) * p - Vec3::new(3.0, 0.0, 1.0))
}

/// VPLs at `place` of points of the unit cube.
pub fn shaped(count: usize, seed: u32, place: impl Fn(Vec3) -> Vec3) -> LightList {
    let mut random = Random::new(seed);
    let mut lights = LightList::default();
    for index in 0..count {
        let position = place(random.point());
        let normal = pack_octahedral((random.point() - 0.5).normalize_or(Vec3::Y));
        let flux = 0.1 + random.point();
        lights.push(position.to_array(), normal, flux.to_array(), index % 8 == 7);
    }
    lights
}

/// A set of lights and the radius of the scene around it.
pub struct Case {
    /// What it is.
    pub name: &'static str,
    /// The lights.
    pub lights: LightList,
    /// Radius of the scene.
    pub scene_radius: f32,
}

/// Fluxes from 10^-decades to 10^decades.
pub fn wide_fluxes(decades: u8) -> Case {
    let mut random = Random::new(8);
    let mut lights = uniform(2000, 8);
    for flux in &mut lights.fluxes {
        let factor = 10.0_f32.powf(f32::from(decades) * (2.0 * random.unit() - 1.0));
        (0..3).for_each(|channel| flux[channel] *= factor);
    }
    Case { name: "wide fluxes", lights, scene_radius: 5.0 }
}

/// Sets that are easy to get wrong.
pub fn degenerate() -> Vec<Case> {
    let case = |name, lights, scene_radius| Case { name, lights, scene_radius };
    let mut isotropic = uniform(600, 7);
    isotropic.fluxes.iter_mut().for_each(|flux| flux[3] = 0.0);
    // The lowest corner of the bounds is vertex (0, 0, 0) of every level.
    let mut on_vertex = uniform(64, 9);
    on_vertex.push([-3.0, 0.0, -1.0], pack_octahedral(Vec3::X), [1.0; 3], false);
    vec![
        case("one point", shaped(500, 1, |_| Vec3::new(1.0, -2.0, 3.0)), 5.0),
        case("a plane", shaped(700, 2, |p| Vec3::new(p.x, 0.5, p.z)), 1.0),
        case("a line", shaped(700, 3, |p| Vec3::new(0.1, p.y * 4.0, 0.2)), 4.0),
        case("huge", shaped(900, 4, |p| (p - 0.5) * 1e6), 1e6),
        case("tiny", shaped(900, 5, |p| (p - 0.5) * 1e-6), 1e-6),
        case("isotropic", isotropic, 5.0),
        Case { name: "fluxes from 1e-2 to 1e2", ..wide_fluxes(2) },
        case("one on a vertex", on_vertex, 5.0),
        case("a cluster far away", shaped(800, 6, |p| if p.x < 0.01 { p } else { 100.0 + p * 0.01 }), 100.0),
    ]
}
