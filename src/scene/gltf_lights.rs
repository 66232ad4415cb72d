//! Lights of `KHR_lights_punctual`.

use ::gltf::json::extensions::scene::khr_lights_punctual::{Light as JsonLight, Type as LightType};
use ::gltf::json::scene::Node;
use ::gltf::json::validation::Checked;
use glam::{Mat4, Vec3};

use super::Light;
use super::gltf_buffers::Document;
use super::gltf_lenient::NO_INDEX;
use super::gltf_nodes::forward;
use super::gltf_notes::Thing;

/// What of a light animations change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LightParts {
    /// Linear RGB.
    pub color: Vec3,
    /// Lux or candela, read as W/m² or W/sr.
    pub intensity: f32,
    /// In radians, of a spot.
    pub inner_cone_angle_rad: f32,
    /// In radians, of a spot.
    pub outer_cone_angle_rad: f32,
}

impl LightParts {
    /// Those of a light of a file.
    pub fn of(light: &JsonLight) -> Self {
        let quarter = std::f32::consts::FRAC_PI_4;
        let cone = light.spot.as_ref().map_or((0.0, quarter), |spot| (spot.inner_cone_angle, spot.outer_cone_angle));
        Self {
            color: Vec3::from_array(light.color),
            intensity: light.intensity,
            inner_cone_angle_rad: cone.0,
            outer_cone_angle_rad: cone.1,
        }
    }

    /// Color times intensity.
    pub fn power(&self) -> Vec3 {
        self.color * self.intensity
    }

    /// Whether the cone angles are those of a spot light.
    fn has_cone(&self) -> bool {
        let (inner, outer) = (self.inner_cone_angle_rad, self.outer_cone_angle_rad);
        inner >= 0.0 && outer > 0.0 && outer <= std::f32::consts::FRAC_PI_2 + 1e-5
    }

    /// Cosines of the inner and outer cone angles, the outer one strictly smaller.
    fn cone(&self) -> (f32, f32) {
        let quarter = std::f32::consts::FRAC_PI_4;
        let (inner, outer) = (self.inner_cone_angle_rad, self.outer_cone_angle_rad);
        let outer = if outer.is_finite() { outer.clamp(0.01, 2.0 * quarter) } else { quarter };
        let inner = if inner.is_finite() { inner.clamp(0.0, outer - 0.005) } else { 0.0 };
        (inner.cos(), outer.cos())
    }
}

impl Light {
    /// The same light where it is, with these parts.
    pub(super) fn with(&self, parts: &LightParts) -> Self {
        let (mut light, power) = (self.clone(), parts.power());
        match &mut light {
            Self::Directional { irradiance, .. } => *irradiance = power,
            Self::Point { intensity, .. } => *intensity = power,
            Self::Spot { intensity, inner_cos, outer_cos, .. } => {
                *intensity = power;
                (*inner_cos, *outer_cos) = parts.cone();
            }
        }
        light
    }

    /// The same light turned off.
    pub(super) fn off(&self) -> Self {
        let mut light = self.clone();
        let (Self::Directional { irradiance: power, .. }
        | Self::Point { intensity: power, .. }
        | Self::Spot { intensity: power, .. }) = &mut light;
        *power = Vec3::ZERO;
        light
    }
}

/// The lights of a file, which nodes refer to by their indices.
pub(super) fn lights<'a>(document: &'a Document<'_>) -> &'a [JsonLight] {
    let extension = document.root.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
    extension.map_or(&[], |extension| &extension.lights)
}

/// The light that a node carries, and its index in the file. One that cannot be used is left out.
pub(super) fn light(document: &Document, (i, node): (usize, &Node), world: &Mat4) -> Option<(Light, usize)> {
    let reference = node.extensions.as_ref()?.khr_lights_punctual.as_ref()?;
    let index = reference.light.value();
    let Some(light) = lights(document).get(index) else {
        let why = match index == NO_INDEX as usize {
            true => "it does not say which".to_owned(),
            false => format!("light {index} does not exist"),
        };
        document.fault(Thing::new("node", i, node.name.as_ref()), format!("is read without its light: {why}"));
        return None;
    };
    let thing = Thing::new("light", index, light.name.as_ref());
    let parts = LightParts::of(light);
    let power = parts.power();
    if !power.is_finite() || power.min_element() < 0.0 {
        document.leave_out(thing, "its intensity or its colour is negative or not finite");
        return None;
    }
    let (position_ws, direction_ws) = (world.w_axis.truncate(), forward(world));
    let light = match light.type_ {
        Checked::Valid(LightType::Directional) => Light::Directional { direction_ws, irradiance: power },
        Checked::Valid(LightType::Point) => Light::Point { position_ws, intensity: power },
        Checked::Valid(LightType::Spot) => {
            if !parts.has_cone() {
                document.fault(thing, "has cone angles that no spot light has: the nearest are taken");
            }
            let (inner_cos, outer_cos) = parts.cone();
            Light::Spot { position_ws, direction_ws, intensity: power, inner_cos, outer_cos }
        }
        Checked::Invalid => {
            document.leave_out(thing, "its type is neither directional nor point nor spot");
            return None;
        }
    };
    Some((light, index))
}
