//! What sizes the passes that trace virtual point lights and shade with them.

use std::ops::Range;
use std::sync::Arc;

use crate::light_paths::StartDensity;

/// Slots of light paths in memory at once: with 16 bytes each, the 128 MiB that a storage buffer may have on every device.
pub const SLOTS_AT_ONCE: u32 = 1 << 23;

/// How many light paths and lights there are.
#[derive(Clone, Debug, PartialEq)]
pub struct LightShape {
    /// Light paths.
    pub path_count: u32,
    /// Where they start; `None` is as many everywhere.
    pub starts: Option<Arc<StartDensity>>,
    /// Whether the VPLs asked for would take more paths than are traced, as most hit nothing.
    pub lacks_paths: bool,
    /// Most VPLs per path.
    pub bounces: u32,
    /// Most slots of light paths in memory at once: [`SLOTS_AT_ONCE`], fewer in tests.
    pub slots_at_once: u32,
    /// VPLs that fit into S0.
    pub vpl_capacity: u32,
    /// Lights of the scene in S0.
    pub scene_light_count: u32,
    /// Shadow rays per pixel; 0 is no shadows of indirect light.
    pub shadow_samples: u32,
    /// Radius of the disc that a VPL stands for, in metres; 0 where there are none.
    pub vpl_radius: f32,
    /// Flux that half of the VPLs exceed, as a share of what all lights emit (luminances); 0 where there are none.
    pub vpl_flux_share: f32,
}

impl LightShape {
    /// Lights that fit into S0.
    #[must_use]
    pub fn light_capacity(&self) -> u32 {
        (self.vpl_capacity + self.scene_light_count).max(1)
    }

    /// Slots that light paths write VPLs to, those of all parts together.
    #[must_use]
    pub fn slot_count(&self) -> u32 {
        (self.path_count * self.bounces).max(1)
    }

    /// The light paths in parts that are traced one after the other, so that their slots fit into memory.
    #[must_use]
    pub fn path_parts(&self) -> Vec<PathPart> {
        let most_paths = match self.slot_count() <= self.slots_at_once {
            true => self.path_count.max(1),
            // Whole words of bits.
            false => (self.slots_at_once / self.bounces / 32 * 32).max(32),
        };
        let count = self.path_count.div_ceil(most_paths).max(1);
        let part = |index: u32| {
            let paths = index * most_paths..((index + 1) * most_paths).min(self.path_count);
            let slots = paths.start * self.bounces..(paths.end * self.bounces).max(1);
            PathPart { number: (count > 1).then_some(index + 1), paths, slots }
        };
        (0..count).map(part).collect()
    }
}

/// Light paths whose slots are in memory at once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PathPart {
    /// Its number from 1 on, where there are several parts.
    pub number: Option<u32>,
    /// The light paths.
    pub paths: Range<u32>,
    /// Their slots.
    pub slots: Range<u32>,
}

impl PathPart {
    /// Name of something that there is for each part.
    #[must_use]
    pub fn named(&self, name: &str, separator: char) -> String {
        self.number.map_or_else(|| name.to_owned(), |number| format!("{name}{separator}{number}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parts(path_count: u32, bounces: u32, slots_at_once: u32) -> Vec<PathPart> {
        let shape = LightShape {
            path_count,
            starts: None,
            lacks_paths: false,
            bounces,
            slots_at_once,
            vpl_capacity: 1,
            scene_light_count: 0,
            shadow_samples: 0,
            vpl_radius: 0.0,
            vpl_flux_share: 0.0,
        };
        shape.path_parts()
    }

    #[test]
    fn paths_that_fit_are_one_part() {
        assert_eq!(parts(1000, 3, 3000), [PathPart { number: None, paths: 0..1000, slots: 0..3000 }]);
        assert_eq!(parts(0, 0, 8), [PathPart { number: None, paths: 0..0, slots: 0..1 }]);
    }

    #[test]
    fn more_paths_go_in_parts_of_whole_words() {
        let found = parts(1001, 3, 3000);
        assert_eq!(found.iter().map(|part| part.paths.clone()).collect::<Vec<_>>(), [0..992, 992..1001]);
        assert_eq!(found.iter().map(|part| part.slots.clone()).collect::<Vec<_>>(), [0..2976, 2976..3003]);
        assert_eq!(found[1].named("vpl_trace", '/'), "vpl_trace/2");
        for (paths, bounces, at_once) in [(100_000, 3, 4096), (5000, 7, 1), (33, 1, 32)] {
            let found = parts(paths, bounces, at_once);
            assert!(found.windows(2).all(|p| p[0].slots.end == p[1].slots.start && p[0].slots.end % 32 == 0));
            assert_eq!(found.last().map(|part| part.slots.end), Some(paths * bounces));
            assert!(found.iter().all(|part| part.slots.len() as u32 <= at_once.max(32 * bounces)));
        }
    }
}
