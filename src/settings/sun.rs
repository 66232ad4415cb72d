//! `--sun`: where a scene's sun stands.

use std::fmt;
use std::str::FromStr;

use glam::Vec3;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::values::from_word;
use crate::camera::{compass_rad, direction};

/// Direction of the sun in degrees, written `AZIMUTH,HEIGHT`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunPlace {
    /// As a compass has it: 0 along -z, 90 along x.
    pub azimuth_deg: f32,
    /// Above the horizon, -90 to 90.
    pub height_deg: f32,
}

impl SunPlace {
    /// The place of a sun whose light comes from this unit direction.
    #[must_use]
    pub fn towards(direction_ws: Vec3) -> Self {
        let [azimuth_deg, height_deg] = compass_rad(direction_ws).map(f32::to_degrees);
        Self { azimuth_deg: azimuth_deg.rem_euclid(360.0), height_deg }
    }

    /// Unit direction in which the sun's light travels.
    #[must_use]
    pub fn travel_ws(self) -> Vec3 {
        -direction(self.azimuth_deg.to_radians(), self.height_deg.to_radians())
    }
}

impl fmt::Display for SunPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.4},{:.4}", self.azimuth_deg, self.height_deg)
    }
}

impl FromStr for SunPlace {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once(',').and_then(|(a, h)| Some((a.trim().parse().ok()?, h.trim().parse().ok()?)));
        match numbers {
            Some((azimuth_deg, height_deg)) => Ok(Self { azimuth_deg, height_deg }),
            None => Err(format!("`{text}` is not AZIMUTH,HEIGHT in degrees")),
        }
    }
}

impl Serialize for SunPlace {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for SunPlace {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        from_word(deserializer, "AZIMUTH,HEIGHT in degrees")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_a_direction_and_back() {
        let place = SunPlace { azimuth_deg: 90.0, height_deg: 30.0 };
        let travel = place.travel_ws();
        assert!(travel.distance(Vec3::new(-0.75_f32.sqrt(), -0.5, 0.0)) < 1e-6, "{travel}");
        let again = SunPlace::towards(-travel);
        assert!((again.azimuth_deg - 90.0).abs() < 1e-3 && (again.height_deg - 30.0).abs() < 1e-3, "{again}");
        assert_eq!("90, 30".parse(), Ok(place));
        assert_eq!(place.to_string().parse(), Ok(place));
        for wrong in ["", "90", "90,x", "90,30,1"] {
            assert!(wrong.parse::<SunPlace>().is_err(), "{wrong}");
        }
    }
}
