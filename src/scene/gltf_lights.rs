//! Lights of `KHR_lights_punctual`.

use ::gltf::json::extensions::scene::khr_lights_punctual::{Light as JsonLight, Type as LightType};
use ::gltf::json::scene::Node;
use ::gltf::json::validation::Checked;
use glam::{Mat4, Vec3};

use super::Light;
use super::gltf_buffers::Document;
use super::gltf_nodes::forward;
use crate::Result;

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

/// The light that a node carries, and its index in the file.
pub(super) fn light(document: &Document, node: &Node, world: &Mat4) -> Result<Option<(Light, usize)>> {
    let reference = node.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
    let Some(index) = reference.map(|r| r.light.value()) else { return Ok(None) };
    let Some(light) = lights(document).get(index) else {
        return Err(document.error(format_args!("light {index} does not exist")));
    };
    let parts = LightParts::of(light);
    let power = parts.power();
    if !power.is_finite() || power.min_element() < 0.0 {
        return Err(document.error(format_args!("light {index} has an intensity that is negative or not finite")));
    }
    let (position_ws, direction_ws) = (world.w_axis.truncate(), forward(world));
    let light = match light.type_ {
        Checked::Valid(LightType::Directional) => Light::Directional { direction_ws, irradiance: power },
        Checked::Valid(LightType::Point) => Light::Point { position_ws, intensity: power },
        Checked::Valid(LightType::Spot) => {
            let (inner_cos, outer_cos) = parts.cone();
            Light::Spot { position_ws, direction_ws, intensity: power, inner_cos, outer_cos }
        }
        Checked::Invalid => return Err(document.error(format_args!("light {index} has an unknown type"))),
    };
    Ok(Some((light, index)))
}
