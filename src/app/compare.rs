//! `gridlight compare`.

use std::io::Cursor;
use std::path::Path;

use serde::Serialize;

use crate::cli::{CompareArgs, CompareKind};
use crate::compare::{
    Image, ImageLimits, ImageMetrics, TimingComparison, TimingsFile, Tone, auto_exposure, compare_images, heatmap,
    limits, table,
};
use crate::files::OutputFile;
use crate::files::pictures::write_png;
use crate::report::timings::Program;
use crate::report::to_json;
use crate::settings::Exposure;
use crate::{Error, Result};

/// The version of the JSON layout.
const SCHEMA: &str = "gridlight-compare/1";

/// What `--json` writes.
#[derive(Serialize)]
struct Report<'a, T> {
    schema: &'static str,
    program: Program,
    reference: String,
    test: String,
    #[serde(flatten)]
    found: T,
    /// The limits that were exceeded, one clause each.
    exceeded: &'a [String],
}

#[derive(Serialize)]
struct Pictures<'a> {
    metrics: &'a ImageMetrics,
    limits: ImageLimits,
}

#[derive(Serialize)]
struct Timings<'a> {
    timings: &'a TimingComparison,
    max_regression_percent: Option<f64>,
}

/// Compares two files, says what changed unless `--quiet`, writes what is asked for, and only then holds to the limits.
///
/// # Errors
/// [`Error::Threshold`] when a limit is exceeded; else whatever stands in the way.
pub fn compare(args: &CompareArgs) -> Result<()> {
    let kind = args.kind()?;
    let create = |path: &Option<std::path::PathBuf>| path.as_deref().map(OutputFile::create).transpose();
    let (heatmap, json) = (create(&args.heatmap)?, create(&args.json)?);
    match kind {
        CompareKind::Exr | CompareKind::Png => compare_pictures(args, kind, heatmap, json),
        CompareKind::Timings => compare_timings(args, json),
    }
}

fn compare_pictures(
    args: &CompareArgs,
    kind: CompareKind,
    heatmap_file: Option<OutputFile>,
    json: Option<OutputFile>,
) -> Result<()> {
    let (reference, test) = (Image::read(&args.reference)?, Image::read(&args.test)?);
    check_sizes(&args.reference, &reference, &args.test, &test)?;
    let direct = args.direct.as_deref().map(Image::read).transpose()?;
    if let (Some(path), Some(direct)) = (&args.direct, &direct) {
        check_sizes(&args.reference, &reference, path, direct)?;
    }
    let tone = match (kind, args.exposure) {
        (CompareKind::Png, _) => Tone::Srgb,
        (_, Some(Exposure::Fixed(factor))) => Tone::Reinhard { exposure: f64::from(factor) },
        _ => Tone::Reinhard { exposure: auto_exposure(&reference) },
    };
    let limits = args.image_limits();
    if let Some(clause) = fault_of_test(&reference, &test).filter(|_| limits.any()) {
        return hold(&args.reference, &args.test, &[clause]);
    }
    check_something_is_finite(&args.reference, &reference, &args.test, &test)?;
    let found = compare_images(&reference, &test, tone, direct.as_ref())?;
    let exceeded = limits.exceeded(&found.metrics);
    if let Some(file) = json {
        commit_json(file, args, Pictures { metrics: &found.metrics, limits }, &exceeded)?;
    }
    if let Some(file) = heatmap_file {
        let (width, height, rgb) = heatmap(&found.flip_map, reference.width);
        let mut bytes = Cursor::new(Vec::new());
        write_png(&mut bytes, width, height, &rgb, "")?;
        file.commit(&bytes.into_inner())?;
    }
    if !args.quiet {
        super::say(&table::image_table(&found.metrics, &limits, args.verbose))?;
    }
    hold(&args.reference, &args.test, &exceeded)
}

fn compare_timings(args: &CompareArgs, json: Option<OutputFile>) -> Result<()> {
    let found = TimingComparison::new(&TimingsFile::read(&args.reference)?, &TimingsFile::read(&args.test)?);
    let exceeded = args.max_regression.map(|percent| found.regressions(percent)).unwrap_or_default();
    if let Some(file) = json {
        let timings = Timings { timings: &found, max_regression_percent: args.max_regression };
        commit_json(file, args, timings, &exceeded)?;
    }
    if !args.quiet {
        super::say(&table::timing_table(&found, args.max_regression, args.verbose))?;
    }
    hold(&args.reference, &args.test, &exceeded)
}

pub(super) fn check_sizes(reference_path: &Path, reference: &Image, test_path: &Path, test: &Image) -> Result<()> {
    if reference.size() == test.size() {
        return Ok(());
    }
    let ((a, b), (c, d)) = (reference.size(), test.size());
    let (reference, test) = (reference_path.display(), test_path.display());
    Err(Error::Usage(format!("{reference} is {a}x{b} and {test} is {c}x{d}: only pictures of one size compare")))
}

/// The clause about a test that leaves nothing to measure.
pub(super) fn fault_of_test(reference: &Image, test: &Image) -> Option<String> {
    let spoiled = test.pixels().iter().filter(|pixel| !is_finite(pixel)).count();
    limits::not_finite(spoiled).filter(|_| !any_finite(reference, test))
}

/// Nothing can be measured where no pixel is finite in both.
pub(super) fn check_something_is_finite(
    reference_path: &Path,
    reference: &Image,
    test_path: &Path,
    test: &Image,
) -> Result<()> {
    if any_finite(reference, test) {
        return Ok(());
    }
    let (reference, test) = (reference_path.display(), test_path.display());
    Err(Error::Failure(format!("{reference} and {test} have no pixel that is finite in both")))
}

fn any_finite(reference: &Image, test: &Image) -> bool {
    reference.pixels().iter().zip(test.pixels()).any(|(r, t)| is_finite(r) && is_finite(t))
}

fn is_finite(pixel: &[f32; 3]) -> bool {
    pixel.iter().all(|value| value.is_finite())
}

fn commit_json(file: OutputFile, args: &CompareArgs, found: impl Serialize, exceeded: &[String]) -> Result<()> {
    let name = |path: &Path| path.display().to_string();
    let (reference, test) = (name(&args.reference), name(&args.test));
    file.commit(&to_json(&Report { schema: SCHEMA, program: Program::this(), reference, test, found, exceeded })?)
}

/// # Errors
/// [`Error::Threshold`] with all the clauses, if there are any.
pub(super) fn hold(reference: &Path, test: &Path, exceeded: &[String]) -> Result<()> {
    if exceeded.is_empty() {
        return Ok(());
    }
    let (reference, test) = (reference.display(), test.display());
    Err(Error::Threshold(format!("{test} against {reference}: {}", exceeded.join("; "))))
}
