//! `--inspect`: which pixel is told about.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::values::from_word;

/// A pixel, written `X,Y` and counted from the upper left corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelPlace(pub [u32; 2]);

impl fmt::Display for PixelPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y] = self.0;
        write!(f, "{x},{y}")
    }
}

impl FromStr for PixelPlace {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once(',').and_then(|(x, y)| Some([x.trim().parse().ok()?, y.trim().parse().ok()?]));
        numbers.map(Self).ok_or_else(|| format!("`{text}` is not X,Y in pixels"))
    }
}

impl Serialize for PixelPlace {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for PixelPlace {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        from_word(deserializer, "X,Y in pixels")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_read_as_they_are_written() {
        assert_eq!("3,17".parse(), Ok(PixelPlace([3, 17])));
        assert_eq!(PixelPlace([3, 17]).to_string(), "3,17");
        for text in ["", "3", "-1,2", "1.5,2", "1,2,3"] {
            assert!(text.parse::<PixelPlace>().is_err(), "{text}");
        }
    }
}
