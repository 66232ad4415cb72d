//! The commands beside rendering, and their options.

use std::path::{Path, PathBuf};

use clap::ArgAction;

use super::compare_sequence::CompareSequenceArgs;
use super::error_report::ErrorReportArgs;
use crate::compare::ImageLimits;
use crate::files::FileKind;
use crate::settings::Exposure;
use crate::{Error, Result};

const COMPARE_HELP: &str = "Both files are of one kind. EXR pictures are linear radiance, shown with one exposure, \
    Reinhard's tone mapping and sRGB for PSNR, SSIM and FLIP. PNG pictures are taken as they are shown, and decoded from \
    sRGB for the other measures.";

/// The commands beside rendering.
#[derive(Debug, clap::Subcommand)]
pub(super) enum Subcommand {
    /// Compare a picture or a timings file with a reference
    #[command(after_help = COMPARE_HELP)]
    Compare(CompareArgs),
    /// Compare a sequence of pictures with the true one: flicker, lag, the answer to a step, and the error of each frame
    #[command(after_help = super::compare_sequence::HELP)]
    CompareSequence(CompareSequenceArgs),
    /// Compare two dumps pass by pass and name the first pass that differs (exit 3 when one does)
    DiffDumps(DiffDumpsArgs),
    /// Render in stages, and split the error of the method by cause
    #[command(after_help = super::error_report::HELP)]
    ErrorReport(Box<ErrorReportArgs>),
    /// Render small frames and compare what every pass leaves with a record of another device (exit 3 when one differs)
    Selftest(SelftestArgs),
    /// Print shell completions: gridlight completions bash > /etc/bash_completion.d/gridlight
    Completions(CompletionsArgs),
    /// Print a manual page: gridlight man > gridlight.1
    Man(ManArgs),
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Completions")]
pub(super) struct CompletionsArgs {
    /// The shell
    pub shell: clap_complete::Shell,
    /// Print this help
    #[arg(short, long, action = ArgAction::Help)]
    pub help: Option<bool>,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Man")]
pub(super) struct ManArgs {
    /// The command to document [default: rendering]
    pub command: Option<String>,
    /// Print this help
    #[arg(short, long, action = ArgAction::Help)]
    pub help: Option<bool>,
}

/// The files to compare, and what to do with what is found.
#[derive(Clone, Debug, Default, PartialEq, clap::Args)]
#[command(next_help_heading = "Compare")]
pub struct CompareArgs {
    /// The reference: .exr, .png, or .json of --timings
    pub reference: PathBuf,
    /// The file to compare with it, of the same kind
    pub test: PathBuf,
    /// Write everything found as JSON
    #[arg(long, value_name = "FILE.json")]
    pub json: Option<PathBuf>,
    /// Print all measures, and all passes
    #[arg(short, long, conflicts_with = "quiet")]
    pub verbose: bool,
    /// Print nothing but errors
    #[arg(long)]
    pub quiet: bool,
    /// Print this help
    #[arg(short, long, action = ArgAction::Help)]
    pub help: Option<bool>,

    /// Factor on the radiance of both EXR pictures before tone mapping, above 0, or `auto`: 0.18 over the
    /// log-average of the reference's pixels that are not black [default: auto]
    #[arg(long, value_name = "auto|FACTOR", allow_negative_numbers = true, help_heading = "Pictures")]
    pub exposure: Option<Exposure>,
    /// Direct light of the reference alone: measures indirect light where no direct light arrives
    #[arg(long, value_name = "FILE.exr", help_heading = "Pictures")]
    pub direct: Option<PathBuf>,
    /// Write a false-colour map of the FLIP error with a scale bar
    #[arg(long, value_name = "FILE.png", help_heading = "Pictures")]
    pub heatmap: Option<PathBuf>,
    /// Fail (exit 3) when the mean FLIP error, 0 to 1, is larger
    #[arg(long, value_name = "X", allow_negative_numbers = true, help_heading = "Pictures")]
    pub max_flip: Option<f64>,
    /// Fail (exit 3) when the relative mean squared error is larger
    #[arg(long, value_name = "X", allow_negative_numbers = true, help_heading = "Pictures")]
    pub max_relmse: Option<f64>,
    /// Fail (exit 3) when the energy ratio is further from 1
    #[arg(long, value_name = "PERCENT", allow_negative_numbers = true, help_heading = "Pictures")]
    pub energy_within: Option<f64>,

    /// Fail (exit 3) when the frame, or a pass of at least 5 % of it, is slower by more
    #[arg(long, value_name = "PERCENT", allow_negative_numbers = true, help_heading = "Timings")]
    pub max_regression: Option<f64>,
}

/// What two files are compared as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CompareKind {
    /// Linear radiance.
    Exr,
    /// Display-ready pictures.
    Png,
    /// Timings files.
    Timings,
}

impl CompareKind {
    pub(super) fn of(path: &Path) -> Result<Self> {
        match FileKind::of(path) {
            Some(FileKind::Exr) => Ok(Self::Exr),
            Some(FileKind::Png) => Ok(Self::Png),
            Some(FileKind::Json) => Ok(Self::Timings),
            _ => {
                Err(Error::Usage(format!("{} cannot be compared: it must end in .exr, .png or .json", path.display())))
            }
        }
    }
}

impl CompareArgs {
    /// What the files are, by their names.
    ///
    /// # Errors
    /// [`Error::Usage`] when they are of different kinds or of one that cannot be compared.
    pub fn kind(&self) -> Result<CompareKind> {
        let kind = CompareKind::of(&self.reference)?;
        if CompareKind::of(&self.test)? != kind {
            let (reference, test) = (self.reference.display(), self.test.display());
            return Err(Error::Usage(format!("{reference} and {test} are of different kinds and cannot be compared")));
        }
        Ok(kind)
    }

    /// The limits on pictures.
    #[must_use]
    pub fn image_limits(&self) -> ImageLimits {
        ImageLimits { max_flip: self.max_flip, max_relmse: self.max_relmse, energy_within_percent: self.energy_within }
    }

    /// Everything that can be found wrong without reading the files.
    pub(super) fn check(&self) -> Result<()> {
        let kind = self.kind()?;
        self.check_that_options_apply(kind)?;
        let limits = [
            ("--max-flip", self.max_flip),
            ("--max-relmse", self.max_relmse),
            ("--energy-within", self.energy_within),
            ("--max-regression", self.max_regression),
        ];
        check_limits(&limits)?;
        check_exposure(self.exposure)?;
        check_extension("--heatmap", self.heatmap.as_deref(), FileKind::Png)?;
        check_extension("--json", self.json.as_deref(), FileKind::Json)?;
        check_extension("--direct", self.direct.as_deref(), FileKind::Exr)?;
        self.check_that_inputs_stay()
    }

    fn check_that_options_apply(&self, kind: CompareKind) -> Result<()> {
        let (exr, pictures, timings) =
            (kind == CompareKind::Exr, kind != CompareKind::Timings, kind == CompareKind::Timings);
        let options = [
            ("--exposure", self.exposure.is_some(), exr, "EXR pictures"),
            ("--direct", self.direct.is_some(), exr, "EXR pictures"),
            ("--heatmap", self.heatmap.is_some(), pictures, "pictures"),
            ("--max-flip", self.max_flip.is_some(), pictures, "pictures"),
            ("--max-relmse", self.max_relmse.is_some(), pictures, "pictures"),
            ("--energy-within", self.energy_within.is_some(), pictures, "pictures"),
            ("--max-regression", self.max_regression.is_some(), timings, "timings files"),
        ];
        match options.into_iter().find(|(_, given, applies, _)| *given && !applies) {
            None => Ok(()),
            Some((option, _, _, wanted)) => {
                let reference = self.reference.display();
                Err(Error::Usage(format!("{option} applies to {wanted} only, and {reference} is none")))
            }
        }
    }

    fn check_that_inputs_stay(&self) -> Result<()> {
        let real = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
        let inputs = [Some(&self.reference), Some(&self.test), self.direct.as_ref()];
        for (option, output) in [("--heatmap", &self.heatmap), ("--json", &self.json)] {
            let Some(output) = output else { continue };
            if inputs.iter().flatten().any(|input| real(input) == real(output)) {
                let output = output.display();
                return Err(Error::Usage(format!("{option} {output} would overwrite what is compared")));
            }
        }
        Ok(())
    }
}

/// Limits are finite and at least 0.
pub(super) fn check_limits(limits: &[(&str, Option<f64>)]) -> Result<()> {
    let bad = |value: f64| !value.is_finite() || value < 0.0;
    match limits.iter().find_map(|(option, value)| Some((option, value.filter(|value| bad(*value))?))) {
        None => Ok(()),
        Some((option, value)) => {
            Err(Error::Usage(format!("{option} must be a finite number of at least 0, not {value}")))
        }
    }
}

pub(super) fn check_exposure(exposure: Option<Exposure>) -> Result<()> {
    match exposure {
        Some(Exposure::Fixed(factor)) if !factor.is_finite() || factor <= 0.0 => {
            Err(Error::Usage(format!("--exposure must be a finite number above 0, not {factor}")))
        }
        _ => Ok(()),
    }
}

pub(super) fn check_extension(option: &str, path: Option<&Path>, wanted: FileKind) -> Result<()> {
    match path.filter(|path| FileKind::of(path) != Some(wanted)) {
        None => Ok(()),
        Some(path) => Err(Error::Usage(format!("{option} {} must end in .{}", path.display(), wanted.extension()))),
    }
}

/// The device to test.
#[derive(Clone, Debug, Default, PartialEq, clap::Args)]
#[command(next_help_heading = "Selftest")]
pub struct SelftestArgs {
    /// Device, by its index in --list-gpus or by a part of its name [default: the most capable]
    #[arg(long, value_name = "INDEX|NAME")]
    pub gpu: Option<String>,
    /// Run under the Vulkan validation layers; any message is a failure (exit 4)
    #[arg(long)]
    pub validation: bool,
    /// Write what this device leaves, which then is what others are compared with, instead of comparing
    #[arg(long, value_name = "FILE.json")]
    pub record: Option<PathBuf>,
    /// Print no progress
    #[arg(long)]
    pub quiet: bool,
    /// Print this help
    #[arg(short, long, action = ArgAction::Help)]
    pub help: Option<bool>,
}

impl SelftestArgs {
    /// Everything that can be found wrong without a device.
    pub(super) fn check(&self) -> Result<()> {
        check_extension("--record", self.record.as_deref(), FileKind::Json)
    }
}

/// Two dumps to compare.
#[derive(Clone, Debug, Default, PartialEq, clap::Args)]
#[command(next_help_heading = "Diff dumps")]
pub struct DiffDumpsArgs {
    /// Folder of a dump
    #[arg(value_name = "A")]
    pub a: PathBuf,
    /// Folder of another dump of the same settings
    #[arg(value_name = "B")]
    pub b: PathBuf,
    /// Largest relative difference at which numbers count as equal; 0 compares bits
    #[arg(long, value_name = "REL", default_value_t = 0.0, allow_negative_numbers = true)]
    pub tolerance: f64,
    /// Compare dumps of different settings
    #[arg(long)]
    pub ignore_settings: bool,
    /// Print this help
    #[arg(short, long, action = ArgAction::Help)]
    pub help: Option<bool>,
}

impl DiffDumpsArgs {
    /// Everything that can be found wrong without reading the dumps.
    pub(super) fn check(&self) -> Result<()> {
        if self.tolerance.is_finite() && self.tolerance >= 0.0 {
            return Ok(());
        }
        Err(Error::Usage(format!("--tolerance must be a finite number, 0 or above, not {}", self.tolerance)))
    }
}
