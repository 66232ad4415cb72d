//! `gridlight compare-sequence`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::compare::{check_sizes, check_something_is_finite, fault_of_test, hold};
use crate::cli::CompareSequenceArgs;
use crate::compare::sequence::limits::FrameFaults;
use crate::compare::sequence::table::sequence_table;
use crate::compare::{Image, LogAverage, SequenceLimits, SequenceMeter, SequenceMetrics, Tone};
use crate::files::OutputFile;
use crate::files::sequence::frames_of;
use crate::report::timings::Program;
use crate::report::to_json;
use crate::settings::Exposure;
use crate::{Error, Result};

/// The version of the JSON layout.
const SCHEMA: &str = "gridlight-compare-sequence/1";

/// What `--json` writes.
#[derive(Serialize)]
struct Report<'a> {
    schema: &'static str,
    program: Program,
    truth: String,
    second_truth: Option<String>,
    test: String,
    metrics: &'a SequenceMetrics,
    limits: SequenceLimits,
    /// The limits that were exceeded, one clause each.
    exceeded: &'a [String],
}

/// Compares two sequences, says what was found unless `--quiet`, writes what is asked for, and only then holds to the limits.
///
/// # Errors
/// [`Error::Threshold`] when a limit is exceeded; else whatever stands in the way.
pub fn compare(args: &CompareSequenceArgs) -> Result<()> {
    let json = args.json.as_deref().map(OutputFile::create).transpose()?;
    let frames = frames(args)?;
    let limits = args.limits();
    let (metrics, faults) = measure(args, &frames, &limits)?;
    let exceeded: Vec<String> = limits.exceeded(&metrics).into_iter().chain(faults.clause()).collect();
    if let Some(file) = json {
        let name = |path: &Path| path.display().to_string();
        file.commit(&to_json(&Report {
            schema: SCHEMA,
            program: Program::this(),
            truth: name(&args.truth),
            second_truth: args.second_truth.as_deref().map(name),
            test: name(&args.test),
            metrics: &metrics,
            limits,
            exceeded: &exceeded,
        })?)?;
    }
    if !args.quiet {
        super::say(&sequence_table(&metrics, &limits, args.verbose))?;
    }
    hold(&args.truth, &args.test, &exceeded)
}

/// The files of a frame.
struct FrameFiles {
    frame: u32,
    truth: PathBuf,
    second_truth: Option<PathBuf>,
    test: PathBuf,
}

/// The frames that the truth has. The other sequences must have them too.
fn frames(args: &CompareSequenceArgs) -> Result<Vec<FrameFiles>> {
    let truths = frames_of(&args.truth)?;
    let (tests, seconds) = (frames_of(&args.test)?, args.second_truth.as_deref().map(frames_of).transpose()?);
    let find = |of: &Path, files: &BTreeMap<u32, PathBuf>, frame: u32| {
        let truth = args.truth.display();
        let missing = || Error::file(of, format_args!("frame {frame} is missing, which {truth} has"));
        files.get(&frame).cloned().ok_or_else(missing)
    };
    let mut frames = Vec::new();
    for (frame, truth) in truths {
        let test = find(&args.test, &tests, frame)?;
        let second = args.second_truth.as_deref().zip(seconds.as_ref());
        let second_truth = second.map(|(of, files)| find(of, files, frame)).transpose()?;
        frames.push(FrameFiles { frame, truth, second_truth, test });
    }
    Ok(frames)
}

/// Reads and measures all frames; also the limits on pictures that any of them exceeds.
fn measure(
    args: &CompareSequenceArgs,
    frames: &[FrameFiles],
    limits: &SequenceLimits,
) -> Result<(SequenceMetrics, FrameFaults)> {
    let mut meter = SequenceMeter::new(tone(args, frames)?);
    let (mut faults, mut size) = (FrameFaults::default(), None);
    for FrameFiles { frame, truth, second_truth, test } in frames {
        let (true_picture, tested) = (Image::read(truth)?, Image::read(test)?);
        let (first_path, first_size): &(&PathBuf, (usize, usize)) =
            size.get_or_insert_with(|| (truth, true_picture.size()));
        if true_picture.size() != *first_size {
            let ((a, b), (c, d)) = (*first_size, true_picture.size());
            let (first, other) = (first_path.display(), truth.display());
            return Err(Error::Usage(format!("{first} is {a}x{b} and {other} is {c}x{d}: frames must be of one size")));
        }
        check_sizes(truth, &true_picture, test, &tested)?;
        let second = second_truth.as_deref().map(Image::read).transpose()?;
        if let (Some(path), Some(second)) = (second_truth, &second) {
            check_sizes(truth, &true_picture, path, second)?;
        }
        if let Some(clause) = fault_of_test(&true_picture, &tested).filter(|_| limits.any()) {
            hold(&args.truth, &args.test, &[format!("frame {frame}: {clause}")])?;
        }
        check_something_is_finite(truth, &true_picture, test, &tested)?;
        let found = meter.add(*frame, &true_picture, second.as_ref(), &tested)?;
        faults.add(*frame, &limits.pictures.exceeded(found));
    }
    Ok((meter.finish()?, faults))
}

/// How all frames are shown.
fn tone(args: &CompareSequenceArgs, frames: &[FrameFiles]) -> Result<Tone> {
    if !args.is_linear()? {
        return Ok(Tone::Srgb);
    }
    if let Some(Exposure::Fixed(factor)) = args.exposure {
        return Ok(Tone::Reinhard { exposure: f64::from(factor) });
    }
    let mut average = LogAverage::default();
    for frame in frames {
        average.add(&Image::read(&frame.truth)?);
    }
    Ok(Tone::Reinhard { exposure: average.exposure() })
}
