//! Checks of the settings that concern several groups, and what all checks are made of: one sentence for each thing wrong.

use std::ops::RangeInclusive;
use std::path::Path;

use super::{Levels, Settings, Switch};
use crate::files::{FileKind, sequence};
use crate::{Error, Result};

impl Settings {
    /// Checks every value, and every combination that can be checked without a scene, a device or a technique;
    /// `techniques::check` does the rest.
    ///
    /// # Errors
    /// [`Error::Usage`] with one sentence about the first thing wrong.
    pub fn validate(&self) -> Result<()> {
        self.validate_groups()?;
        self.validate_groups_together()?;
        self.validate_inspected()?;
        self.validate_frames()
    }

    /// What groups ask of each other.
    fn validate_groups_together(&self) -> Result<()> {
        let (lgh, many_lights) = (&self.lgh, &self.many_lights);
        if let Levels::Fixed(levels) = lgh.levels {
            require(many_lights.shadow_samples == 0 || lgh.shadow_from <= levels, || {
                format!("--shadow-from {} lies above the top level, which --levels sets to {levels}", lgh.shadow_from)
            })?;
        }
        let (size, side) = (self.picture.size, lgh.interleave);
        require(size.width >= side && size.height >= side, || {
            format!("--size {size} is too small for --interleave {side}: each side needs at least {side} pixels")
        })
    }

    /// Checks that there are shadow samples, which `what` needs.
    ///
    /// # Errors
    /// [`Error::Usage`] with one sentence that names `what` and the setting in its way.
    pub fn require_shadow_samples(&self, what: &str) -> Result<()> {
        let obstacle = match (self.many_lights.shadow_samples, self.many_lights.shadows) {
            (0, _) => "--shadow-samples 0",
            (_, Switch::Off) => "--shadows off",
            (_, Switch::On) => return Ok(()),
        };
        Err(Error::Usage(format!("{what} needs shadow samples, and {obstacle} leaves none")))
    }

    /// Checks that frames follow each other, which `what` needs.
    ///
    /// # Errors
    /// [`Error::Usage`] with one sentence that names `what` and the setting in its way.
    pub fn require_successive_frames(&self, what: &str) -> Result<()> {
        let frames = self.render.accumulate;
        require(frames == 1, || {
            format!(
                "{what} needs frames that follow each other, and --accumulate {frames} takes the mean of independent ones: leave one of them out"
            )
        })
    }

    /// Whether the inspected pixel is one of the picture.
    fn validate_inspected(&self) -> Result<()> {
        let (Some(place), size) = (self.output.inspect, self.picture.size) else { return Ok(()) };
        let [x, y] = place.0;
        require(x < size.width && y < size.height, || {
            format!("--inspect {place} is not in the picture, whose size is {size}")
        })
    }

    /// How many frames there are, and which of them is captured.
    fn validate_frames(&self) -> Result<()> {
        let (run, accumulate) = (&self.run, self.render.accumulate);
        require(run.frames == 1 || accumulate == 1, || {
            "--frames and --accumulate both say how many frames are rendered: give one of them".to_owned()
        })?;
        require(accumulate == 1 || !self.output.is_sequence(), || {
            let place = sequence::FRAME_PLACE;
            format!(
                "--output with {place} writes every frame, and --accumulate makes one picture of all: leave one of them out"
            )
        })?;
        let Some(frame) = self.output.renderdoc_frame.filter(|_| run.headless) else { return Ok(()) };
        let frames = run.warmup + run.frames.max(accumulate);
        require(frame < frames, || {
            format!("--renderdoc-frame {frame} is never reached: the run has {frames} frame(s), counted from 0")
        })
    }
}

pub(super) fn require(holds: bool, sentence: impl FnOnce() -> String) -> Result<()> {
    if holds { Ok(()) } else { Err(Error::Usage(sentence())) }
}

pub(super) fn at_least_one(key: &str, value: u32) -> Result<()> {
    require(value > 0, || format!("--{key} must be at least 1, not 0"))
}

pub(super) fn above_zero(key: &str, value: f32) -> Result<()> {
    require(value.is_finite() && value > 0.0, || format!("--{key} must be a finite number above 0, not {value}"))
}

pub(super) fn within(key: &str, value: u32, range: RangeInclusive<u32>) -> Result<()> {
    require(range.contains(&value), || {
        format!("--{key} must be from {} to {}, not {value}", range.start(), range.end())
    })
}

pub(super) fn has_extension(key: &str, path: &Path, kinds: &[FileKind]) -> Result<()> {
    let fits = FileKind::of(path).is_some_and(|kind| kinds.contains(&kind));
    require(fits, || {
        let names: Vec<_> = kinds.iter().map(|kind| format!(".{}", kind.extension())).collect();
        format!("--{key} {} must end in {}", path.display(), names.join(" or "))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{
        Exposure, FirstLevelBuild, GridUpdate, LevelBuild, LightSet, LightingMode, PixelPlace, RenderScale, Reservoir,
        Size,
    };

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
        let settings = Settings::default().changed(|s| {
            s.many_lights.clamp = 0.0;
            s.many_lights.shadow_samples = 0;
            s.lgh.shadow_from = 10;
            s.lgh.levels = Levels::Fixed(2);
            s.many_lights.lights = LightSet::Scene;
            s.many_lights.bounces = 0;
            s.output.picture = Some("a.EXR".into());
            s.output.timings = vec!["a.csv".into(), "b.json".into()];
        });
        settings.validate().unwrap();
    }

    #[test]
    fn values_out_of_range() {
        assert_eq!(complaint(|s| s.run.frames = 0), "--frames must be at least 1, not 0");
        assert_eq!(complaint(|s| s.many_lights.vpls = 0), "--vpls must be at least 1, not 0");
        for size in [Size { width: 0, height: 9 }, Size { width: 9, height: 0 }] {
            let sentence = format!("--size {size} has no pixels: width and height must be at least 1");
            assert_eq!(complaint(|s| s.picture.size = size), sentence);
        }
        assert_eq!(complaint(|s| s.lgh.levels = Levels::Fixed(1)), "--levels must be from 2 to 10, not 1");
        assert_eq!(complaint(|s| s.lgh.levels = Levels::Fixed(11)), "--levels must be from 2 to 10, not 11");
        assert_eq!(complaint(|s| s.many_lights.bounces = 65), "--bounces must be from 0 to 64, not 65");
        assert_eq!(complaint(|s| s.lgh.first_level = 2), "--first-level must be from 0 to 1, not 2");
        for bad in [0.0, 1.5, f32::NAN] {
            let found = complaint(|s| s.lgh.temporal_weight = Some(bad));
            assert_eq!(found, format!("--temporal-weight must be above 0 and at most 1, not {bad}"));
        }
        for bad in [0, 65] {
            let found = complaint(|s| s.lgh.temporal_rounds = Some(bad));
            assert_eq!(found, format!("--temporal-rounds must be from 1 to 64, not {bad}"));
        }
        assert_eq!(complaint(|s| s.lgh.interleave = 3), "--interleave must be 1, 2 or 4, not 3");
        assert_eq!(complaint(|s| s.many_lights.shadow_samples = 17), "--shadow-samples must be from 0 to 16, not 17");
        assert_eq!(complaint(|s| s.lgh.shadow_from = 11), "--shadow-from must be from 0 to 10, not 11");
    }

    #[test]
    fn numbers_that_make_no_sense() {
        for bad in [f32::NAN, f32::INFINITY, -1.0, 0.0] {
            assert_eq!(complaint(|s| s.lgh.alpha = bad), format!("--alpha must be a finite number above 0, not {bad}"));
            let sentence = format!("--exposure must be a finite number above 0, not {bad}");
            assert_eq!(complaint(|s| s.picture.exposure = Exposure::Fixed(bad)), sentence);
        }
        for bad in [f32::NAN, f32::INFINITY, 32.5, -33.0] {
            let sentence = format!("--exposure-compensation must be from -32 to 32 stops, not {bad}");
            assert_eq!(complaint(|s| s.picture.exposure_compensation = bad), sentence);
        }
        for bad in [f32::NAN, 0.0, 0.04, 1.5] {
            let sentence = format!("--render-scale must be `auto` or from 0.05 to 1, not {bad}");
            assert_eq!(complaint(|s| s.window.render_scale = RenderScale::Fixed(bad)), sentence);
        }
        for bad in [f32::NAN, f32::NEG_INFINITY, -0.5] {
            assert_eq!(
                complaint(|s| s.many_lights.clamp = bad),
                format!("--clamp must be a finite number, 0 or above, not {bad}")
            );
        }
    }

    #[test]
    fn contradictions() {
        let gather = Some(LightingMode::Gather);
        let sentence = complaint(|s| (s.lgh.lighting, s.lgh.reservoir) = (gather, Some(Reservoir::Lock)));
        assert_eq!(
            sentence,
            "--lighting gather has exact reservoirs only: leave --reservoir out, or choose --lighting volumes"
        );
        let sentence =
            complaint(|s| (s.lgh.build, s.lgh.scatter) = (LevelBuild::Scatter, Some(FirstLevelBuild::Sorted)));
        assert_eq!(
            sentence,
            "--build scatter adds lights to every level, by atomic additions only: leave --scatter out, or choose another \
             --build"
        );
        let checked = |s: &mut Settings| s.lgh.grid_update = GridUpdate::Check;
        let expected =
            "--grid-update check compares with lights sorted by cell: leave --build scatter and --scatter atomic out";
        assert_eq!(complaint(|s| (s.lgh.build, _) = (LevelBuild::Scatter, checked(s))), expected);
        assert_eq!(complaint(|s| (s.lgh.scatter, _) = (Some(FirstLevelBuild::Atomic), checked(s))), expected);
        let sentence = complaint(|s| (s.lgh.levels, s.lgh.shadow_from) = (Levels::Fixed(4), 5));
        assert_eq!(sentence, "--shadow-from 5 lies above the top level, which --levels sets to 4");
        let sentence = complaint(|s| (s.picture.size, s.lgh.interleave) = (Size { width: 9, height: 3 }, 4));
        assert_eq!(sentence, "--size 9x3 is too small for --interleave 4: each side needs at least 4 pixels");
    }

    #[test]
    fn files() {
        let sentence = complaint(|s| s.output.inspect = Some(PixelPlace([1280, 3])));
        assert_eq!(sentence, "--inspect 1280,3 is not in the picture, whose size is 1280x720");
        assert_eq!(complaint(|s| s.output.picture = Some("a.jpg".into())), "--output a.jpg must end in .exr or .png");
        assert_eq!(complaint(|s| s.output.picture = Some("png".into())), "--output png must end in .exr or .png");
        assert_eq!(complaint(|s| s.output.timings = vec!["a.png".into()]), "--timings a.png must end in .json or .csv");
        let sentence =
            complaint(|s| (s.output.picture, s.output.timings) = (Some("a.png".into()), vec!["a.png".into()]));
        assert_eq!(sentence, "--output and --timings are the same file, a.png: give two names");
        let sentence = complaint(|s| s.output.picture = Some("f-{frame}/a.png".into()));
        assert_eq!(sentence, "--output f-{frame}/a.png must have {frame} in the file's name, not in its folder's");
        let sentence = complaint(|s| (s.output.picture, s.render.accumulate) = (Some("a-{frame}.png".into()), 2));
        assert!(sentence.starts_with("--output with {frame} writes every frame"), "{sentence}");
        let sentence = complaint(|s| s.output.timings = vec!["a.csv".into(), "b.csv".into()]);
        assert_eq!(sentence, "--timings is given 2 times as .csv: give one");
        let sentence = complaint(|s| (s.output.dump, s.output.picture) = (Some("d".into()), Some("d/a.png".into())));
        assert_eq!(sentence, "--dump d must hold nothing else, and an output would lie in it");
        let sentence = complaint(|s| {
            (s.run.headless, s.run.frames, s.run.warmup, s.output.renderdoc_frame) = (true, 2, 1, Some(3));
        });
        assert_eq!(sentence, "--renderdoc-frame 3 is never reached: the run has 3 frame(s), counted from 0");
    }
}
