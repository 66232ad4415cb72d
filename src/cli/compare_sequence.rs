//! `gridlight compare-sequence` and its options.

use std::path::PathBuf;

use clap::ArgAction;

use super::commands::{CompareKind, check_exposure, check_extension, check_limits};
use crate::compare::{ImageLimits, SequenceLimits};
use crate::files::FileKind;
use crate::files::sequence::{FRAME_PLACE, is_sequence};
use crate::settings::Exposure;
use crate::{Error, Result};

pub(super) const HELP: &str = "Every frame of the truth needs one of the test; others of the test are not looked at. \
    Flicker and lag are measured in luma as shown, from every frame to the next where the truth has both. The camera is \
    assumed to stand still.";

/// Two sequences of pictures to compare, and what to do with what is found.
#[derive(Clone, Debug, Default, PartialEq, clap::Args)]
#[command(next_help_heading = "Compare sequence")]
pub struct CompareSequenceArgs {
    /// The true pictures, .exr or .png, with {frame} in place of the number
    pub truth: PathBuf,
    /// The pictures to compare with them, of the same kind
    pub test: PathBuf,
    /// The same truth with other noise: then the noise of both has no part in flicker and lag
    #[arg(long, value_name = "FILE-{frame}")]
    pub second_truth: Option<PathBuf>,
    /// Write everything found as JSON
    #[arg(long, value_name = "FILE.json")]
    pub json: Option<PathBuf>,
    /// Print each frame
    #[arg(short, long, conflicts_with = "quiet")]
    pub verbose: bool,
    /// Print nothing but errors
    #[arg(long)]
    pub quiet: bool,
    /// Print this help
    #[arg(short, long, action = ArgAction::Help)]
    pub help: Option<bool>,

    /// Factor on the radiance of all EXR pictures before tone mapping, above 0, or `auto`: 0.18 over the log-average of the
    /// truth's pixels that are not black [default: auto]
    #[arg(long, value_name = "auto|FACTOR", allow_negative_numbers = true)]
    pub exposure: Option<Exposure>,
    /// Fail (exit 3) when pixels flicker more, as a part of the mean luma
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub max_flicker: Option<f64>,
    /// Fail (exit 3) when 16x16 blocks flicker more
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub max_block_flicker: Option<f64>,
    /// Fail (exit 3) when the test is further behind the truth
    #[arg(long, value_name = "FRAMES", allow_negative_numbers = true)]
    pub max_lag: Option<f64>,
    /// Fail (exit 3) when it takes more frames until a tenth of a step is left
    #[arg(long, value_name = "FRAMES", allow_negative_numbers = true)]
    pub max_answer: Option<f64>,
    /// Fail (exit 3) when the mean FLIP error of a frame, 0 to 1, is larger
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub max_flip: Option<f64>,
    /// Fail (exit 3) when the relative mean squared error of a frame is larger
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub max_relmse: Option<f64>,
    /// Fail (exit 3) when the energy ratio of a frame is further from 1
    #[arg(long, value_name = "PERCENT", allow_negative_numbers = true)]
    pub energy_within: Option<f64>,
}

impl CompareSequenceArgs {
    /// The limits.
    #[must_use]
    pub fn limits(&self) -> SequenceLimits {
        SequenceLimits {
            max_flicker: self.max_flicker,
            max_block_flicker: self.max_block_flicker,
            max_lag_frames: self.max_lag,
            max_answer_frames: self.max_answer,
            pictures: ImageLimits {
                max_flip: self.max_flip,
                max_relmse: self.max_relmse,
                energy_within_percent: self.energy_within,
            },
        }
    }

    /// Whether the pictures are of linear radiance.
    ///
    /// # Errors
    /// [`Error::Usage`] when the sequences are of different kinds or of one that cannot be compared.
    pub fn is_linear(&self) -> Result<bool> {
        let kind = CompareKind::of(&self.truth)?;
        for other in [Some(&self.test), self.second_truth.as_ref()].into_iter().flatten() {
            if CompareKind::of(other)? != kind {
                let (truth, other) = (self.truth.display(), other.display());
                return Err(Error::Usage(format!("{truth} and {other} are of different kinds and cannot be compared")));
            }
        }
        match kind {
            CompareKind::Exr => Ok(true),
            CompareKind::Png => Ok(false),
            CompareKind::Timings => {
                Err(Error::Usage(format!("{} must end in .exr or .png: timings are no sequence", self.truth.display())))
            }
        }
    }

    /// Everything that can be found wrong without reading the files.
    pub(super) fn check(&self) -> Result<()> {
        for path in [Some(&self.truth), Some(&self.test), self.second_truth.as_ref()].into_iter().flatten() {
            if !is_sequence(path) {
                let path = path.display();
                return Err(Error::Usage(format!(
                    "{path} must have {FRAME_PLACE} in its name: `gridlight compare` is for single pictures"
                )));
            }
        }
        if !self.is_linear()? && self.exposure.is_some() {
            let truth = self.truth.display();
            return Err(Error::Usage(format!("--exposure applies to EXR pictures only, and {truth} is none")));
        }
        check_limits(&[
            ("--max-flicker", self.max_flicker),
            ("--max-block-flicker", self.max_block_flicker),
            ("--max-lag", self.max_lag),
            ("--max-answer", self.max_answer),
            ("--max-flip", self.max_flip),
            ("--max-relmse", self.max_relmse),
            ("--energy-within", self.energy_within),
        ])?;
        check_exposure(self.exposure)?;
        check_extension("--json", self.json.as_deref(), FileKind::Json)
    }
}
