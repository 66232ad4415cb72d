//! The scene's first directional light, turned while the window runs.

use glam::Vec3;

use crate::shared::{LIGHT_DIRECTIONAL, PunctualLight};

/// Highest and lowest sun.
const STEEPEST_RAD: f32 = 1.55;

/// Where the sun stands, and the lights that it is one of.
pub struct Sun {
    lights: Vec<PunctualLight>,
    index: usize,
    azimuth_rad: f32,
    elevation_rad: f32,
    changed: bool,
}

impl Sun {
    /// The sun among a scene's directional and spot lights, if there is one.
    pub fn new(lights: &[PunctualLight]) -> Option<Self> {
        let index = lights.iter().position(|light| light.kind == LIGHT_DIRECTIONAL)?;
        let towards = -Vec3::from_array(lights[index].direction_ws);
        Some(Self {
            lights: lights.to_vec(),
            index,
            azimuth_rad: towards.x.atan2(-towards.z),
            elevation_rad: towards.y.clamp(-1.0, 1.0).asin(),
            changed: false,
        })
    }

    /// Direction as a compass has it (0 along -z, 90 along x) and height, in degrees.
    pub fn angles_deg(&self) -> [f32; 2] {
        [self.azimuth_rad.to_degrees().rem_euclid(360.0), self.elevation_rad.to_degrees()]
    }

    /// Turns to the right and up.
    pub fn turn_deg(&mut self, azimuth: f32, elevation: f32) {
        if azimuth == 0.0 && elevation == 0.0 {
            return;
        }
        self.azimuth_rad += azimuth.to_radians();
        self.elevation_rad = (self.elevation_rad + elevation.to_radians()).clamp(-STEEPEST_RAD, STEEPEST_RAD);
        let (sin_a, cos_a) = self.azimuth_rad.sin_cos();
        let (sin_e, cos_e) = self.elevation_rad.sin_cos();
        let towards = Vec3::new(sin_a * cos_e, sin_e, -cos_a * cos_e);
        self.lights[self.index].direction_ws = (-towards).to_array();
        self.changed = true;
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
        let mut sun = Sun::new(&[light]).unwrap();
        assert!((sun.angles_deg()[0]).abs() < 1e-3 && (sun.angles_deg()[1] - 45.0).abs() < 1e-3);
        assert!(sun.changed_lights().is_none());
        sun.turn_deg(90.0, 0.0);
        let lights = sun.changed_lights().unwrap();
        let expected = [-(0.5_f32.sqrt()), -(0.5_f32.sqrt()), 0.0];
        assert!(lights[0].direction_ws.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{lights:?}");
        assert!(sun.is_changed() && sun.changed_lights().is_some(), "kept until a frame has shown them");
        sun.mark_shown();
        assert!(sun.changed_lights().is_none());
        assert!(Sun::new(&[]).is_none());
    }
}
