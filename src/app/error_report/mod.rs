//! `gridlight error-report`: renders in stages, and splits the error of the method by cause.

mod folder;
mod renders;
pub mod stages;

use std::rc::Rc;

use super::setup::{find_camera, load_scene, open_gpu, scene_info, upload};
use crate::cli::ErrorReportOptions;
use crate::compare::{Image, auto_exposure};
use crate::progress::Progress;
use crate::renderer::Job;
use crate::report::error_report::{ErrorReport, SCHEMA, Side, Stage};
use crate::report::machine::Machine;
use crate::report::timings::{Device, Program};
use crate::settings::{Exposure, Settings};
use crate::techniques::lgh;
use crate::{Error, Result, interrupt};
use folder::ReportFolder;
use renders::{Noise, Rendered, Studio};
use stages::{Picture, StagePlan};

/// Renders every stage, writes the report and prints its table. An interrupted run reports the stages it finished.
///
/// # Errors
/// [`Error::Interrupted`] when the user stopped the run; else whatever stands in the way, and nothing is written.
pub fn report(settings: &Settings, options: &ErrorReportOptions, quiet: bool) -> Result<()> {
    let folder = options.folder.as_deref().map(ReportFolder::prepare).transpose()?;
    interrupt::listen()?;
    let progress = Progress::new(quiet);
    let gpu = open_gpu(settings)?;
    let scene = load_scene(settings, &progress)?;
    let camera = &find_camera(&scene, settings.scene.camera.as_deref())?;
    let uploaded = upload(&gpu, &scene, settings, &progress)?;
    // What `None` stood for.
    let reservoir = lgh::reservoir_mode(&gpu, settings)?;
    let settings = settings.clone().changed(|s| s.lgh.reservoir = Some(reservoir));
    let has_environment = Job::new(&gpu, &uploaded, camera, &settings).has_environment();
    let plan = stages::plan(&settings, options, has_environment);
    let mut studio = Studio::new(&gpu, &uploaded, camera, progress);
    let (stages, exposure) = run_stages(&mut studio, &plan, settings.picture.exposure)?;
    let report = ErrorReport {
        schema: SCHEMA,
        program: Program::this(),
        device: Device::of(gpu.report()),
        machine: Machine::here(),
        scene: scene_info(&settings, &scene, camera),
        settings,
        reference_samples: options.reference_samples,
        frames_per_stage: options.frames_per_stage,
        exposure,
        interrupted: stages.len() < plan.len(),
        stages,
    };
    // Nothing is written before everything has gone well.
    gpu.check_validation()?;
    publish(&report, folder, quiet)?;
    if report.interrupted {
        let (finished, all) = (report.stages.len(), plan.len());
        return Err(Error::Interrupted(format!("interrupted after {finished} of {all} stages; that much is reported")));
    }
    Ok(())
}

/// Writes the report, and prints its table; `quiet` leaves it out where it is in a file.
fn publish(report: &ErrorReport, folder: Option<ReportFolder>, quiet: bool) -> Result<()> {
    let is_printed = !quiet || folder.is_none();
    if let Some(folder) = folder {
        folder.commit(report)?;
    }
    if is_printed {
        super::say(&report.to_markdown())?;
    }
    Ok(())
}

/// The stages in order, and the exposure of their pictures; fewer stages when the user stops the run.
///
/// # Errors
/// [`Error::Interrupted`] when it is stopped before the first stage is finished; device errors.
fn run_stages(studio: &mut Studio, plan: &[StagePlan], exposure: Exposure) -> Result<(Vec<Stage>, f64)> {
    let mut factor = match exposure {
        Exposure::Auto => None,
        Exposure::Fixed(factor) => Some(f64::from(factor)),
    };
    let mut stages = Vec::new();
    for (index, planned) in plan.iter().enumerate() {
        let bar = format!("{}/{} {}", index + 1, plan.len(), planned.name);
        match run_stage(studio, planned, &bar, &mut factor) {
            Ok(stage) => stages.push(stage),
            Err(Error::Interrupted(_)) if !stages.is_empty() => break,
            Err(Error::Interrupted(_)) => {
                let sentence = "interrupted before the first stage was finished; nothing is written";
                return Err(Error::Interrupted(sentence.to_owned()));
            }
            Err(error) => return Err(error),
        }
        log::info!("stage {} of {} is finished: {}", index + 1, plan.len(), planned.name);
    }
    Ok((stages, factor.unwrap_or(1.0)))
}

/// The first reference decides on the exposure where nothing else has.
fn run_stage(studio: &mut Studio, planned: &StagePlan, bar: &str, exposure: &mut Option<f64>) -> Result<Stage> {
    let reference = Shot::take(studio, &planned.reference, bar)?;
    let test = Shot::take(studio, &planned.test, bar)?;
    let exposure = *exposure.get_or_insert_with(|| auto_exposure(&reference.image));
    let direct = reference.direct.as_deref().map(|direct| &direct.image);
    let names = (planned.name.as_str(), planned.cause.as_str());
    let (reference_side, test_side) = ((reference.side, reference.image.clone()), (test.side, test.image));
    let mut stage = Stage::measure(names, reference_side, test_side, exposure, direct)?;
    stage.notes.clone_from(&planned.notes);
    Ok(stage)
}

/// A side of a stage, rendered.
struct Shot {
    side: Side,
    image: Image,
    direct: Option<Rc<Rendered>>,
}

impl Shot {
    fn take(studio: &mut Studio, picture: &Picture, bar: &str) -> Result<Self> {
        let rendered = studio.picture(&picture.recipe, bar)?;
        let direct = picture.direct.as_ref().map(|recipe| studio.picture(recipe, bar)).transpose()?;
        let image = match &direct {
            None => rendered.image.clone(),
            Some(direct) => renders::sum(&rendered.image, &direct.image)?,
        };
        let ms = rendered.ms + direct.as_ref().map_or(0.0, |direct| direct.ms);
        // The noise is relative to the light that it was measured in.
        let note = rendered.noise.filter(|_| direct.is_none()).map(noise_note);
        Ok(Self { side: Side { label: picture.label.clone(), ms: Some(ms), note }, image, direct })
    }
}

fn noise_note(noise: Noise) -> String {
    let blocks = noise.smooth_relmse.map_or_else(String::new, |blocks| format!(", {blocks:.1e} of 8x8 blocks"));
    format!("its own noise is about relMSE {:.1e}{blocks}", noise.relmse)
}
