//! The scene's first directional light, turned while the window runs.

use glam::Vec3;

use crate::settings::SunPlace;
use crate::shared::{LIGHT_DIRECTIONAL, PunctualLight};

/// Highest and lowest sun.
const STEEPEST_DEG: f32 = 88.8;

/// Where the sun stands, and the lights that it is one of.
pub struct Sun {
    lights: Vec<PunctualLight>,
    index: usize,
    place: SunPlace,
    /// Where the scene has it, when it was not placed there by a setting.
    own: Option<SunPlace>,
    changed: bool,
}

impl Sun {
    /// The sun among a scene's directional and spot lights, if there is one. `placed` is where a setting has put it.
    pub fn new(lights: &[PunctualLight], placed: Option<SunPlace>) -> Option<Self> {
        let index = lights.iter().position(|light| light.kind == LIGHT_DIRECTIONAL)?;
        let found = SunPlace::towards(-Vec3::from_array(lights[index].direction_ws));
        let own = placed.is_none().then_some(found);
        Some(Self { lights: lights.to_vec(), index, place: placed.unwrap_or(found), own, changed: false })
    }

    /// Direction as a compass has it (0 along -z, 90 along x) and height, in degrees.
    pub fn angles_deg(&self) -> [f32; 2] {
        [self.place.azimuth_deg, self.place.height_deg]
    }

    /// Its place as a setting, when it is not where the scene has it.
    pub fn setting(&self) -> Option<SunPlace> {
        (self.own != Some(self.place)).then_some(self.place)
    }

    /// Puts it somewhere, `None` where the scene has it, as far as that is known.
    pub fn put(&mut self, place: Option<SunPlace>) {
        if let Some(place) = place.or(self.own) {
            self.place = place;
            self.lights[self.index].direction_ws = place.travel_ws().to_array();
            self.changed = true;
        }
    }

    /// Turns to the right and up.
    pub fn turn_deg(&mut self, azimuth: f32, elevation: f32) {
        if azimuth == 0.0 && elevation == 0.0 {
            return;
        }
        let SunPlace { azimuth_deg, height_deg } = self.place;
        self.put(Some(SunPlace {
            azimuth_deg: (azimuth_deg + azimuth).rem_euclid(360.0),
            height_deg: (height_deg + elevation).clamp(-STEEPEST_DEG, STEEPEST_DEG),
        }));
    }

    /// Whether the lights changed since a frame last showed them.
    pub fn is_changed(&self) -> bool {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_turns_and_tells_once() {
        let mut light: PunctualLight = bytemuck::Zeroable::zeroed();
        light.kind = LIGHT_DIRECTIONAL;
        light.direction_ws = [0.0, -0.5_f32.sqrt(), 0.5_f32.sqrt()];
        let mut sun = Sun::new(&[light], None).unwrap();
        assert!((sun.angles_deg()[1] - 45.0).abs() < 1e-3);
        assert!(sun.changed_lights().is_none());
        sun.turn_deg(90.0, 0.0);
        let lights = sun.changed_lights().unwrap();
        let expected = [-(0.5_f32.sqrt()), -(0.5_f32.sqrt()), 0.0];
        assert!(lights[0].direction_ws.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{lights:?}");
        assert!(sun.is_changed() && sun.changed_lights().is_some(), "kept until a frame has shown them");
        sun.mark_shown();
        assert!(sun.changed_lights().is_none());
        assert!(sun.setting().is_some());
        sun.put(None);
        assert!(sun.setting().is_none() && (sun.angles_deg()[1] - 45.0).abs() < 1e-3, "back where the scene has it");
        assert!(Sun::new(&[], None).is_none());
    }
}
