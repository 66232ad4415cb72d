//! The directional and spot lights of a scene while the window runs: its sun can be turned, the suns of its environment
//! follow the environment.

use glam::Vec3;

use crate::environment;
use crate::scene::Scene;
use crate::settings::{EnvironmentSettings, SunPlace};
use crate::shared::{LIGHT_DIRECTIONAL, PunctualLight};

/// Highest and lowest sun.
const STEEPEST_DEG: f32 = 88.8;
/// A sky is made anew when the sun has moved away from it so far: a texel of its image.
const SKY_STEP_DEG: f32 = 0.7;

/// The lights, and the sun among them.
#[derive(Default)]
pub struct Suns {
    lights: Vec<PunctualLight>,
    steered: Option<Steered>,
    changed: bool,
    /// How often they have changed.
    changes: u64,
}

/// The sun that can be turned.
#[derive(Clone, Copy)]
struct Steered {
    index: usize,
    place: SunPlace,
    /// Where the scene has it, when it was not placed there by a setting.
    own: Option<SunPlace>,
}

impl Suns {
    /// A scene's directional and spot lights as uploaded, those of its environment last. `placed` is where a setting has
    /// put its sun: the first directional light that is the scene's own, or the sun that a sky has brought.
    pub fn new(scene: &Scene, lights: &[PunctualLight], placed: Option<SunPlace>) -> Self {
        let own = if scene.sky_sun.is_some() { lights.len() } else { lights.len() - from_environment(scene, lights) };
        let index = lights[..own].iter().position(|light| light.kind == LIGHT_DIRECTIONAL);
        let steered = index.map(|index| {
            let found = SunPlace::towards(-Vec3::from_array(lights[index].direction_ws));
            Steered { index, place: placed.unwrap_or(found), own: placed.is_none().then_some(found) }
        });
        Self { lights: lights.to_vec(), steered, changed: false, changes: 0 }
    }

    /// The scene has been loaded again: its sun is known to stand where it did.
    pub fn steered_as(&mut self, before: &Self) {
        if let (Some(steered), Some(before)) = (&mut self.steered, &before.steered) {
            steered.own = steered.own.or(before.own);
        }
    }

    /// Direction of the sun as a compass has it (0 along -z, 90 along x) and height, in degrees.
    pub fn angles_deg(&self) -> Option<[f32; 2]> {
        self.steered.map(|sun| [sun.place.azimuth_deg, sun.place.height_deg])
    }

    /// The sun's place as a setting, when it is not where the scene has it.
    pub fn setting(&self) -> Option<SunPlace> {
        self.steered.filter(|sun| sun.own != Some(sun.place)).map(|sun| sun.place)
    }

    /// Puts the sun somewhere, `None` where the scene has it, as far as that is known.
    pub fn put(&mut self, place: Option<SunPlace>) {
        if let Some(sun) = &mut self.steered
            && let Some(place) = place.or(sun.own)
        {
            sun.place = place;
            self.lights[sun.index].direction_ws = place.travel_ws().to_array();
            self.changed = true;
            self.changes += 1;
        }
    }

    /// Turns the sun to the right and up; whether there is one that turns.
    pub fn turn_deg(&mut self, azimuth: f32, elevation: f32) -> bool {
        let Some(Steered { place, .. }) = self.steered.filter(|_| azimuth != 0.0 || elevation != 0.0) else {
            return false;
        };
        self.put(Some(SunPlace {
            azimuth_deg: (place.azimuth_deg + azimuth).rem_euclid(360.0),
            height_deg: (place.height_deg + elevation).clamp(-STEEPEST_DEG, STEEPEST_DEG),
        }));
        true
    }

    /// Turns and scales the suns of the scene's environment with it. A sun that was placed stays there.
    pub fn follow(&mut self, scene: &Scene, settings: &EnvironmentSettings) {
        let first = self.lights.len() - from_environment(scene, &self.lights);
        let suns = scene.environment.iter().flat_map(|environment| &environment.suns);
        for (index, sun) in (first..self.lights.len()).zip(suns) {
            self.lights[index].intensity = (sun.irradiance * settings.scale).to_array();
            let direction_to_sun = environment::turned(sun.direction_to_sun, settings.turn_deg);
            if let Some(steered) = self.steered.as_mut().filter(|steered| steered.index == index) {
                if steered.own != Some(steered.place) {
                    continue;
                }
                steered.place = SunPlace::towards(direction_to_sun);
                steered.own = Some(steered.place);
            }
            self.lights[index].direction_ws = (-direction_to_sun).to_array();
        }
        self.changed = true;
        self.changes += 1;
    }

    /// Whether the sun stands elsewhere than the sky has it that the scene is under, and the sky does not follow it by itself.
    pub fn have_left_their_sky(&self, scene: &Scene, turn_deg: f32) -> bool {
        let stays = scene.sky_sun.filter(|sun| !sun.moves);
        let (Some(sky_sun), Some(steered)) = (stays, &self.steered) else { return false };
        let towards = -Vec3::from_array(self.lights[steered.index].direction_ws);
        towards.angle_between(environment::turned(sky_sun.towards, turn_deg)).to_degrees() > SKY_STEP_DEG
    }

    /// Takes over lights of the scene that its animation has moved. A sun that was turned stays where it is, and so do those
    /// of the environment.
    pub fn carry(&mut self, scene: &Scene, lights: &[PunctualLight]) {
        let own = self.lights.len() - from_environment(scene, &self.lights);
        let turned = self.steered.filter(|steered| steered.own != Some(steered.place));
        let moved = self.lights.iter_mut().zip(lights).take(own).enumerate();
        for (_, (light, moved)) in moved.filter(|(index, _)| turned.is_none_or(|turned| turned.index != *index)) {
            *light = *moved;
        }
        if let Some(steered) = self.steered.as_mut().filter(|steered| turned.is_none() && steered.index < own) {
            steered.place = SunPlace::towards(-Vec3::from_array(self.lights[steered.index].direction_ws));
            steered.own = Some(steered.place);
        }
        // The device has those of the scene alone.
        self.changed = true;
    }

    /// How often the lights have changed.
    pub fn changes(&self) -> u64 {
        self.changes
    }

    /// Whether the lights changed since a frame last showed them.
    pub fn are_changed(&self) -> bool {
        self.changed
    }

    /// The lights when no frame has shown them as they are.
    pub fn changed_lights(&self) -> Option<Vec<PunctualLight>> {
        self.changed.then(|| self.lights.clone())
    }

    /// A frame has shown the lights as they are.
    pub fn mark_shown(&mut self) {
        self.changed = false;
    }
}

/// How many of a scene's directional and spot lights are its environment's: the last ones.
fn from_environment(scene: &Scene, lights: &[PunctualLight]) -> usize {
    scene.environment.as_ref().map_or(0, |environment| environment.suns.len()).min(lights.len())
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::environment::{Environment, EnvironmentSun};
    use crate::scene::SkySun;
    use crate::scene::testing::{diffuse, scene_from_quads};

    const QUAD: [Vec3; 4] = [Vec3::ZERO, Vec3::Z, Vec3::new(1.0, 0.0, 1.0), Vec3::X];

    fn directional(direction_ws: [f32; 3]) -> PunctualLight {
        let mut light: PunctualLight = bytemuck::Zeroable::zeroed();
        (light.kind, light.direction_ws, light.intensity) = (LIGHT_DIRECTIONAL, direction_ws, [1.0; 3]);
        light
    }

    fn scene() -> Scene {
        scene_from_quads("test", &[QUAD], diffuse("white", Vec3::ONE))
    }

    /// A scene whose environment has one sun, along x.
    fn in_environment(is_sky: bool) -> Scene {
        let sun = EnvironmentSun { direction_to_sun: Vec3::X, irradiance: Vec3::ONE };
        let environment = Environment { suns: vec![sun], ..Environment::uniform([1.0; 3]) };
        let sky_sun = SkySun { towards: Vec3::X, irradiance: Vec3::ONE, own: None, moves: false };
        Scene { environment: Some(Arc::new(environment)), sky_sun: is_sky.then_some(sky_sun), ..scene() }
    }

    fn near(found: [f32; 3], expected: [f32; 3]) -> bool {
        found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5)
    }

    #[test]
    fn the_sun_turns_and_tells_once() {
        let mut suns = Suns::new(&scene(), &[directional([0.0, -0.5_f32.sqrt(), 0.5_f32.sqrt()])], None);
        assert!((suns.angles_deg().unwrap()[1] - 45.0).abs() < 1e-3);
        assert!(suns.changed_lights().is_none() && !suns.turn_deg(0.0, 0.0));
        assert!(suns.turn_deg(90.0, 0.0));
        let lights = suns.changed_lights().unwrap();
        assert!(near(lights[0].direction_ws, [-(0.5_f32.sqrt()), -(0.5_f32.sqrt()), 0.0]), "{lights:?}");
        assert!(suns.are_changed() && suns.changed_lights().is_some(), "kept until a frame has shown them");
        suns.mark_shown();
        assert!(suns.changed_lights().is_none());
        assert!(suns.setting().is_some());
        // Loaded again at that place it still knows where the scene has it.
        let mut again = Suns::new(&scene(), &lights, suns.setting());
        again.steered_as(&suns);
        for mut suns in [suns, again] {
            suns.put(None);
            assert!(suns.setting().is_none() && (suns.angles_deg().unwrap()[1] - 45.0).abs() < 1e-3);
        }
        assert!(Suns::new(&scene(), &[], None).angles_deg().is_none());
    }

    #[test]
    fn suns_of_an_environment_follow_it_and_cannot_be_steered() {
        let lights = [directional([0.0, -1.0, 0.0]), directional([-1.0, 0.0, 0.0])];
        let image = in_environment(false);
        assert!(Suns::new(&image, &lights[1..], None).angles_deg().is_none());
        let mut suns = Suns::new(&image, &lights, None);
        suns.follow(&image, &EnvironmentSettings { scale: 3.0, turn_deg: 90.0, ..EnvironmentSettings::default() });
        let lights = suns.changed_lights().unwrap();
        assert!(near(lights[0].direction_ws, [0.0, -1.0, 0.0]) && near(lights[0].intensity, [1.0; 3]));
        assert!(near(lights[1].direction_ws, [0.0, 0.0, 1.0]) && near(lights[1].intensity, [3.0; 3]), "{lights:?}");
        assert!(!suns.have_left_their_sky(&image, 0.0));
    }

    #[test]
    fn a_sky_is_left_by_a_sun_that_is_steered() {
        let sky = in_environment(true);
        let turned = EnvironmentSettings { turn_deg: 50.0, ..EnvironmentSettings::default() };
        let mut suns = Suns::new(&sky, &[directional([-1.0, 0.0, 0.0])], None);
        suns.follow(&sky, &turned);
        assert!(suns.setting().is_none() && !suns.have_left_their_sky(&sky, turned.turn_deg), "both have turned");
        suns.turn_deg(0.5, 0.0);
        assert!(!suns.have_left_their_sky(&sky, turned.turn_deg));
        suns.turn_deg(0.5, 0.0);
        assert!(suns.have_left_their_sky(&sky, turned.turn_deg));
        let follows = SkySun { own: Some(0), moves: true, ..sky.sky_sun.unwrap() };
        let follows = Scene { sky_sun: Some(follows), ..in_environment(true) };
        assert!(!suns.have_left_their_sky(&follows, turned.turn_deg), "this one follows");
        // What was placed stays when the sky turns.
        let place = suns.setting().unwrap();
        suns.follow(&sky, &EnvironmentSettings::default());
        assert_eq!(suns.setting(), Some(place));
        let mut own =
            Suns::new(&Scene { environment: None, ..in_environment(true) }, &[directional([-1.0, 0.0, 0.0])], None);
        own.follow(&Scene { environment: None, ..in_environment(true) }, &turned);
        assert!(own.have_left_their_sky(&sky, turned.turn_deg), "the scene's own sun stays, the sky has turned");
    }
}
