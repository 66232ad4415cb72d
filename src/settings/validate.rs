//! The one place where the values of the settings are checked, one sentence for each thing wrong.

use std::ops::RangeInclusive;
use std::path::Path;

use super::{
    Build, Exposure, Levels, LightSet, LightingMode, RenderScale, Reservoir, Scatter, Settings, SunPlace, Technique,
    name,
};
use crate::report::files::FileKind;
use crate::{Error, Result};

impl Settings {
    /// Checks every value and every combination that can be checked without a scene or a device.
    ///
    /// # Errors
    /// [`Error::Usage`] with one sentence about the first thing wrong.
    pub fn validate(&self) -> Result<()> {
        self.validate_picture()?;
        self.validate_method()?;
        self.validate_shadows()?;
        self.validate_combinations()?;
        self.validate_view()?;
        self.validate_files()
    }

    fn validate_picture(&self) -> Result<()> {
        at_least_one("frames", self.frames)?;
        let size = self.size;
        require(size.width > 0 && size.height > 0, || {
            format!("size {size} has no pixels: width and height must be at least 1")
        })?;
        if let Exposure::Fixed(factor) = self.exposure {
            above_zero("exposure", factor)?;
        }
        if let RenderScale::Fixed(scale) = self.render_scale {
            require((0.05..=1.0).contains(&scale), || {
                format!("render-scale must be `auto` or from 0.05 to 1, not {scale}")
            })?;
        }
        Ok(())
    }

    fn validate_method(&self) -> Result<()> {
        at_least_one("vpls", self.vpls)?;
        at_least_one("samples", self.samples)?;
        at_least_one("accumulate", self.accumulate)?;
        above_zero("max-submit-ms", self.max_submit_ms)?;
        within("bounces", self.bounces, 0..=64)?;
        if let Levels::Fixed(levels) = self.levels {
            within("levels", levels, 2..=10)?;
        }
        above_zero("alpha", self.alpha)?;
        within("first-level", self.first_level, 0..=1)?;
        require(matches!(self.interleave, 1 | 2 | 4), || {
            format!("interleave must be 1, 2 or 4, not {}", self.interleave)
        })?;
        require(self.clamp.is_finite() && self.clamp >= 0.0, || {
            format!("clamp must be a finite number, 0 or above, not {}", self.clamp)
        })
    }

    fn validate_shadows(&self) -> Result<()> {
        within("shadow-samples", self.shadow_samples, 0..=16)?;
        within("shadow-from", self.shadow_from, 0..=10)
    }

    fn validate_combinations(&self) -> Result<()> {
        require(self.frames == 1 || self.accumulate == 1, || {
            "frames and accumulate both say how many frames are rendered: give one of them".to_owned()
        })?;
        let name = name(&self.technique);
        require(self.technique == Technique::Lgh || self.reservoir.is_none(), || {
            format!("technique {name} has no reservoirs: leave reservoir out, or choose technique lgh")
        })?;
        require(self.technique == Technique::Lgh || self.lighting.is_none(), || {
            format!("technique {name} has no lights of a hierarchy: leave lighting out, or choose technique lgh")
        })?;
        let picks_otherwise = matches!(self.reservoir, Some(Reservoir::Race | Reservoir::Lock));
        require(!picks_otherwise || self.lighting != Some(LightingMode::Gather), || {
            "lighting gather has exact reservoirs only: leave reservoir out, or choose lighting volumes".to_owned()
        })?;
        require(self.build != Build::Scatter || self.scatter != Some(Scatter::Sorted), || {
            "build scatter adds lights to every level, by atomic additions only: leave scatter out, or choose another \
             build"
                .to_owned()
        })?;
        let traced = matches!(self.technique, Technique::Lgh | Technique::BruteForce) && self.lights != LightSet::Scene;
        require(!traced || self.bounces > 0, || {
            "bounces 0 leaves no virtual point lights: give at least 1, or choose lights scene".to_owned()
        })?;
        if let Levels::Fixed(levels) = self.levels {
            require(self.shadow_samples == 0 || self.shadow_from <= levels, || {
                format!("shadow-from {} lies above the top level, which levels sets to {levels}", self.shadow_from)
            })?;
        }
        let (size, side) = (self.size, self.interleave);
        require(size.width >= side && size.height >= side, || {
            format!("size {size} is too small for interleave {side}: each side needs at least {side} pixels")
        })
    }

    fn validate_files(&self) -> Result<()> {
        if let (Some(output), Some(timings)) = (&self.output, &self.timings) {
            require(output != timings, || {
                format!("output and timings are the same file, {}: give two names", output.display())
            })?;
        }
        if let Some(path) = &self.output {
            has_extension("output", path, &[FileKind::Exr, FileKind::Png])?;
        }
        if let Some(path) = &self.timings {
            has_extension("timings", path, &[FileKind::Json, FileKind::Csv])?;
        }
        if let Some(SunPlace { azimuth_deg, height_deg }) = self.sun {
            require(azimuth_deg.is_finite() && height_deg.abs() <= 90.0, || {
                format!("sun {azimuth_deg},{height_deg} needs a finite azimuth and a height from -90 to 90")
            })?;
        }
        if let Some(frame) = self.renderdoc_frame.filter(|_| self.headless) {
            let frames = self.warmup + self.frames.max(self.accumulate);
            require(frame < frames, || {
                format!("renderdoc-frame {frame} is never reached: the run has {frames} frame(s), counted from 0")
            })?;
        }
        if let Some(dump) = &self.dump {
            let inside = self.output.iter().chain(&self.timings).find(|path| path.starts_with(dump));
            require(inside.is_none(), || {
                format!("dump {} must hold nothing else, and an output would lie in it", dump.display())
            })?;
        }
        Ok(())
    }
}

pub(super) fn require(holds: bool, sentence: impl FnOnce() -> String) -> Result<()> {
    if holds { Ok(()) } else { Err(Error::Usage(sentence())) }
}

fn at_least_one(key: &str, value: u32) -> Result<()> {
    require(value > 0, || format!("{key} must be at least 1, not 0"))
}

fn above_zero(key: &str, value: f32) -> Result<()> {
    require(value.is_finite() && value > 0.0, || format!("{key} must be a finite number above 0, not {value}"))
}

fn within(key: &str, value: u32, range: RangeInclusive<u32>) -> Result<()> {
    require(range.contains(&value), || format!("{key} must be from {} to {}, not {value}", range.start(), range.end()))
}

fn has_extension(key: &str, path: &Path, kinds: &[FileKind]) -> Result<()> {
    let fits = FileKind::of(path).is_some_and(|kind| kinds.contains(&kind));
    require(fits, || {
        let names: Vec<_> = kinds.iter().map(|kind| format!(".{}", kind.extension())).collect();
        format!("{key} {} must end in {}", path.display(), names.join(" or "))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Size;

    fn complaint(change: impl FnOnce(&mut Settings)) -> String {
        let mut settings = Settings::default();
        change(&mut settings);
        match settings.validate() {
            Err(error @ Error::Usage(_)) => error.to_string(),
            other => panic!("expected a usage error, got {other:?}"),
        }
    }

    #[test]
    fn defaults_and_extremes_are_valid() {
        Settings::default().validate().unwrap();
        let settings = Settings {
            clamp: 0.0,
            shadow_samples: 0,
            shadow_from: 10,
            levels: Levels::Fixed(2),
            lights: LightSet::Scene,
            bounces: 0,
            output: Some("a.EXR".into()),
            timings: Some("a.csv".into()),
            ..Settings::default()
        };
        settings.validate().unwrap();
    }

    #[test]
    fn values_out_of_range() {
        assert_eq!(complaint(|s| s.frames = 0), "frames must be at least 1, not 0");
        assert_eq!(complaint(|s| s.vpls = 0), "vpls must be at least 1, not 0");
        for size in [Size { width: 0, height: 9 }, Size { width: 9, height: 0 }] {
            let sentence = format!("size {size} has no pixels: width and height must be at least 1");
            assert_eq!(complaint(|s| s.size = size), sentence);
        }
        assert_eq!(complaint(|s| s.levels = Levels::Fixed(1)), "levels must be from 2 to 10, not 1");
        assert_eq!(complaint(|s| s.levels = Levels::Fixed(11)), "levels must be from 2 to 10, not 11");
        assert_eq!(complaint(|s| s.bounces = 65), "bounces must be from 0 to 64, not 65");
        assert_eq!(complaint(|s| s.first_level = 2), "first-level must be from 0 to 1, not 2");
        assert_eq!(complaint(|s| s.interleave = 3), "interleave must be 1, 2 or 4, not 3");
        assert_eq!(complaint(|s| s.shadow_samples = 17), "shadow-samples must be from 0 to 16, not 17");
        assert_eq!(complaint(|s| s.shadow_from = 11), "shadow-from must be from 0 to 10, not 11");
    }

    #[test]
    fn numbers_that_make_no_sense() {
        for bad in [f32::NAN, f32::INFINITY, -1.0, 0.0] {
            assert_eq!(complaint(|s| s.alpha = bad), format!("alpha must be a finite number above 0, not {bad}"));
            let sentence = format!("exposure must be a finite number above 0, not {bad}");
            assert_eq!(complaint(|s| s.exposure = Exposure::Fixed(bad)), sentence);
        }
        for bad in [f32::NAN, 0.0, 0.04, 1.5] {
            let sentence = format!("render-scale must be `auto` or from 0.05 to 1, not {bad}");
            assert_eq!(complaint(|s| s.render_scale = RenderScale::Fixed(bad)), sentence);
        }
        for bad in [f32::NAN, f32::NEG_INFINITY, -0.5] {
            assert_eq!(complaint(|s| s.clamp = bad), format!("clamp must be a finite number, 0 or above, not {bad}"));
        }
    }

    #[test]
    fn contradictions() {
        let sentence = complaint(|s| (s.technique, s.reservoir) = (Technique::Direct, Some(Reservoir::Race)));
        assert_eq!(sentence, "technique direct has no reservoirs: leave reservoir out, or choose technique lgh");
        let sentence = complaint(|s| (s.technique, s.lighting) = (Technique::Direct, Some(LightingMode::Volumes)));
        assert_eq!(
            sentence,
            "technique direct has no lights of a hierarchy: leave lighting out, or choose technique lgh"
        );
        let gather = Some(LightingMode::Gather);
        let sentence = complaint(|s| (s.lighting, s.reservoir) = (gather, Some(Reservoir::Lock)));
        assert_eq!(
            sentence,
            "lighting gather has exact reservoirs only: leave reservoir out, or choose lighting volumes"
        );
        let sentence = complaint(|s| (s.build, s.scatter) = (Build::Scatter, Some(Scatter::Sorted)));
        assert_eq!(
            sentence,
            "build scatter adds lights to every level, by atomic additions only: leave scatter out, or choose another \
             build"
        );
        for lights in [LightSet::Vpl, LightSet::Both] {
            let sentence = complaint(|s| (s.bounces, s.lights) = (0, lights));
            assert_eq!(sentence, "bounces 0 leaves no virtual point lights: give at least 1, or choose lights scene");
        }
        let sentence = complaint(|s| (s.levels, s.shadow_from) = (Levels::Fixed(4), 5));
        assert_eq!(sentence, "shadow-from 5 lies above the top level, which levels sets to 4");
        let sentence = complaint(|s| (s.size, s.interleave) = (Size { width: 9, height: 3 }, 4));
        assert_eq!(sentence, "size 9x3 is too small for interleave 4: each side needs at least 4 pixels");
    }

    #[test]
    fn files() {
        assert_eq!(complaint(|s| s.output = Some("a.jpg".into())), "output a.jpg must end in .exr or .png");
        assert_eq!(complaint(|s| s.output = Some("png".into())), "output png must end in .exr or .png");
        assert_eq!(complaint(|s| s.timings = Some("a.png".into())), "timings a.png must end in .json or .csv");
        let sentence = complaint(|s| (s.output, s.timings) = (Some("a.png".into()), Some("a.png".into())));
        assert_eq!(sentence, "output and timings are the same file, a.png: give two names");
        let sentence = complaint(|s| (s.dump, s.output) = (Some("d".into()), Some("d/a.png".into())));
        assert_eq!(sentence, "dump d must hold nothing else, and an output would lie in it");
        let sentence = complaint(|s| (s.headless, s.frames, s.warmup, s.renderdoc_frame) = (true, 2, 1, Some(3)));
        assert_eq!(sentence, "renderdoc-frame 3 is never reached: the run has 3 frame(s), counted from 0");
    }
}
