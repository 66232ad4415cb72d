//! `gridlight selftest`: small frames on the device at hand, pass by pass against what another one has left.

use std::sync::Arc;

use super::headless::write_dump;
use super::say;
use super::setup::{find_camera, load_scene, open_gpu, upload};
use crate::cli::{self, Command, SelftestArgs};
use crate::files::OutputFile;
use crate::gpu::Gpu;
use crate::progress::Progress;
use crate::renderer::{Job, Renderer};
use crate::report::dump::folder::DumpTarget;
use crate::report::dump::manifest::Manifest;
use crate::report::selftest::{Case, FileDigest, Record, Scorecard};
use crate::report::timings::{Device, Program};
use crate::settings::{DeviceSettings, Settings};
use crate::{Error, Result, interrupt};

/// What all cases share.
const COMMON: &str = "--size 64x36 --seed 1";
/// A frame of each kind, of the built-in scene.
const CASES: [(&str, &str); 10] = [
    ("direct light", "--technique direct --environment sky"),
    ("hierarchy", "--vpls 2000"),
    ("hierarchy, wide", "--vpls 2000 --alpha 2 --interleave 2 --build gather --lobe sh1"),
    ("hierarchy, volumes", "--vpls 1000 --lighting volumes --reservoir lock"),
    ("hierarchy, atomic", "--vpls 2000 --scatter atomic --build scatter --shadow-points deviation"),
    ("every light", "--technique brute-force --vpls 1000"),
    ("path tracing", "--technique path-trace --samples 2 --environment sky"),
    ("final gathering", "--technique final-gather --points 4096 --vpls 4000 --environment sky"),
    ("points", "--technique pbgi --points 4096 --environment sky"),
    (
        "points, as in the paper",
        "--technique pbgi --points 16384 --size 128x72 --environment 1,1,1 --micro points --coverage binary --selection paper --sun-leaves 1",
    ),
];

/// Renders every case and prints a scorecard, or writes the record.
///
/// # Errors
/// [`Error::Threshold`] when a case differs; device errors.
pub fn selftest(args: &SelftestArgs) -> Result<()> {
    let output = args.record.as_deref().map(OutputFile::create).transpose()?;
    interrupt::listen()?;
    let progress = Progress::new(args.quiet);
    let device = DeviceSettings { gpu: args.gpu.clone(), validation: args.validation, ..DeviceSettings::default() };
    let gpu = open_gpu(&Settings::default().changed(|s| s.device = device))?;
    let recorded = if output.is_some() { None } else { Some(Record::of_program()?) };
    let mut found = Record { made_by: made_by(&gpu), cases: Vec::new() };
    let mut card = Scorecard::default();
    let bar = progress.bar("cases", CASES.len() as u64);
    for (index, (name, options)) in CASES.iter().enumerate() {
        if interrupt::requested() {
            return Err(Error::Interrupted(format!("interrupted after {index} of {} cases", CASES.len())));
        }
        let case = Case { name: (*name).to_owned(), options: (*options).to_owned(), files: digests(&gpu, options)? };
        if let Some(recorded) = &recorded {
            let same = recorded.cases.iter().find(|known| known.name == case.name && known.options == case.options);
            let known =
                same.ok_or_else(|| Error::Failure(format!("the record lacks the case {name}: make it anew")))?;
            card.add(known, &case);
        }
        found.cases.push(case);
        bar.set(index as u64 + 1);
    }
    bar.finish();
    gpu.check_validation()?;
    let Some(recorded) = recorded else {
        let bytes = found.to_json()?;
        return output.map_or(Ok(()), |file| file.commit(&bytes));
    };
    say(&format!("{}\nagainst the record of {}\n\n{}", found.made_by, recorded.made_by, card.table()))?;
    card.complaint().map_or(Ok(()), |sentence| Err(Error::Threshold(sentence)))
}

fn made_by(gpu: &Gpu) -> String {
    let (device, program) = (Device::of(gpu.report()), Program::this());
    format!("{}, {}, gridlight {} ({})", device.name, device.driver, program.version, program.commit)
}

/// What the passes of a frame leave.
fn digests(gpu: &Arc<Gpu>, options: &str) -> Result<Vec<FileDigest>> {
    let line = format!("gridlight --headless {COMMON} {options}");
    let Command::Render { settings, .. } = cli::parse(line.split(' '))? else {
        return Err(Error::Failure(format!("{line} renders nothing")));
    };
    let scene = load_scene(&settings, &Progress::hidden())?;
    let camera = find_camera(&scene, None)?;
    let uploaded = upload(gpu, &scene, &settings, &Progress::hidden())?;
    let job = Job::new(gpu, &uploaded, &camera, &settings);
    let renderer = Renderer::new(&job)?;
    let place = tempfile::tempdir().map_err(|error| Error::Failure(format!("no temporary folder: {error}")))?;
    let dump = write_dump(DumpTarget::prepare(&place.path().join("dump"))?, &job, &scene, &renderer)?;
    let manifest = Manifest::read(dump.path())?;
    // Of what several passes write a part of, only the last has all.
    let is_last = |index: usize| {
        !manifest.files[index + 1..].iter().any(|later| later.resource == manifest.files[index].resource)
    };
    let files = manifest.files.iter().enumerate().filter(|(index, _)| is_last(*index));
    files.map(|(_, file)| FileDigest::of(dump.path(), file)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_record_is_of_these_cases() {
        let recorded = Record::of_program().unwrap();
        let known: Vec<_> = recorded.cases.iter().map(|case| (case.name.as_str(), case.options.as_str())).collect();
        assert_eq!(known, CASES);
    }
}
