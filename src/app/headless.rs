//! Rendering without a window.

use std::path::Path;

use super::counts;
use super::frames::{Frames, run_frames};
use super::outputs::Outputs;
use super::sequence::Sequence;
use super::setup::{cpu_note, find_camera, load_scene, open_gpu, scene_info, upload};
use crate::cli::Verbosity;
use crate::files::FileKind;
use crate::gpu::FrameCapture;
use crate::graph::to_dot;
use crate::progress::Progress;
use crate::renderer::{Fresh, Job, Renderer};
use crate::report::answer::Answer;
use crate::report::dump;
use crate::report::dump::folder::{DumpFolder, DumpTarget};
use crate::report::machine::{Machine, peak_resident_bytes};
use crate::report::table::table;
use crate::report::timings::{Device, Memory, Program, RayRates, RunReport, RunTimes, SCHEMA, to_csv};
use crate::report::{emptiness, inspected};
use crate::scene::Scene;
use crate::scene_mover::SceneMover;
use crate::settings::{Settings, View};
use crate::{Error, Result, interrupt};

/// Renders the frames that the settings ask for, writes the outputs and says what was done: in a few lines, with `-v` all
/// passes in a table.
///
/// # Errors
/// Whatever stands in the way; the outputs are then as they were, but for frames of a sequence that were done.
pub fn render(settings: &Settings, verbosity: Verbosity) -> Result<()> {
    let progress = Progress::new(verbosity.quiet);
    let outputs = Outputs::prepare(settings)?;
    let dump = settings.output.dump.as_deref().map(DumpTarget::prepare).transpose()?;
    interrupt::listen()?;
    let capture = FrameCapture::load(settings.output.renderdoc_frame)?;
    let gpu = FrameCapture::opened(capture.as_ref(), open_gpu(settings))?;
    if let Some(note) = cpu_note(&gpu, settings) {
        progress.note(&format!("{} is {note}", gpu.report().name));
    }
    let mut scene = load_scene(settings, &progress)?;
    let mut uploaded = upload(&gpu, &scene, settings, &progress)?;
    let seen = |scene: &Scene| find_camera(scene, settings.scene.camera.as_deref());
    let mut renderer = Renderer::new(&Job::new(&gpu, &uploaded, &seen(&scene)?, settings))?;
    let mut sequence = Sequence {
        gpu: &gpu,
        settings,
        mover: SceneMover::new(&gpu, &scene, &uploaded)?,
        scene: &mut scene,
        uploaded: &mut uploaded,
        shown_s: settings.motion.time_s,
        files: outputs.sequence,
    };
    let Frames { times: frames, interrupted, complaint } =
        run_frames(&mut renderer, settings, capture, &mut sequence, &progress)?;
    scene.pose_vertices();
    let camera = &seen(&scene)?;
    let job = Job::new(&gpu, &uploaded, camera, settings);
    let times = RunTimes::of(&frames).ok_or_else(|| Error::Failure("no frame was measured".to_owned()))?;
    let mut frame_count = frames.len();
    let dump = match dump {
        Some(target) if interrupted.is_none() => {
            if settings.render.accumulate > 1 {
                renderer.set_accumulated_frame(frame_count as u32, Fresh::All);
                frame_count += 1;
            }
            Some(write_dump(target, &job, &scene, &renderer)?)
        }
        _ => None,
    };
    let rays = RayRates::of(&times, counts::rays(&renderer)?);
    let complaint = complaint.map_or_else(|| renderer.complaint(), |first| Ok(Some(first)))?;
    // One reason is enough for a picture that lacks something.
    let told = match complaint {
        None if settings.render.view == View::Final => {
            emptiness::sentence(&scene, camera, settings.picture.size, &renderer.read_radiance()?)
        }
        complaint => complaint,
    };
    told.iter().for_each(|sentence| log::warn!("{sentence}"));
    let exposure = renderer.read_exposure()?;
    let printed = match verbosity {
        Verbosity { quiet: true, .. } => None,
        Verbosity { verbose: 0, .. } => {
            let files: Vec<_> = settings.output.files().map(|(_, path)| path).collect();
            Some(answer(&job, &scene, &renderer, (&times, exposure), &files)?)
        }
        _ => Some(table(&times, &rays, exposure)),
    };
    let told = renderer.read_inspected()?.map(|pixel| inspected::text(&*renderer.shapes().technique, &pixel));
    let picture = match outputs.picture {
        None => None,
        Some(file) => Some((file, renderer.read_picture(note(settings, frame_count, interrupted.as_deref()))?)),
    };
    let json = || -> Result<Vec<u8>> {
        let counts = counts::count(&job, &renderer)?;
        let mut report = report(&job, &scene, &renderer, times.clone(), counts);
        report.rays = rays;
        report.exposure = exposure;
        report.frames = frames.len() as u32;
        report.interrupted.clone_from(&interrupted);
        report.to_json()
    };
    let mut timings = Vec::new();
    for file in outputs.timings {
        let bytes = if file.kind() == FileKind::Csv { to_csv(&frames)? } else { json()? };
        timings.push((file, bytes));
    }
    // Nothing is written before everything has gone well.
    gpu.check_validation()?;
    if let Some((file, picture)) = picture {
        file.commit_picture(&picture)?;
    }
    for (file, bytes) in timings {
        file.commit(&bytes)?;
    }
    dump.map_or(Ok(()), DumpFolder::commit)?;
    printed.into_iter().chain(told).try_for_each(|text| super::say(&text))?;
    interrupted.map_or(Ok(()), |sentence| Err(Error::Interrupted(format!("{sentence}; that much is written"))))
}

/// What the run says at its end.
pub(super) fn answer(
    job: &Job<'_>,
    scene: &Scene,
    renderer: &Renderer,
    (times, exposure): (&RunTimes, Option<f32>),
    files: &[&Path],
) -> Result<String> {
    let answer = Answer {
        scene: &scene_info(job.settings, scene, job.camera),
        device: &Device::of(job.gpu.report()),
        device_note: cpu_note(job.gpu, job.settings),
        settings: job.settings,
        times,
        counts: &renderer.shapes().technique.counts(&renderer.read_counters()?),
        exposure,
        is_most_exposed: job.is_most_exposed(exposure),
        files,
    };
    Ok(answer.text())
}

/// What a picture says of itself.
pub(super) fn note(settings: &Settings, frame_count: usize, interrupted: Option<&str>) -> String {
    let made_by = Program::this().note(settings);
    let mean = if settings.render.accumulate > 1 { format!(", mean of {frame_count} frames") } else { String::new() };
    let end = interrupted.map_or_else(String::new, |sentence| format!(", {sentence}"));
    format!("{made_by}{mean}{end}")
}

/// Prints the frame graph of the settings as Graphviz.
///
/// # Errors
/// When the graph cannot be planned.
pub fn print_graph(settings: &Settings) -> Result<()> {
    let gpu = open_gpu(settings)?;
    let scene = load_scene(settings, &Progress::hidden())?;
    let camera = &find_camera(&scene, settings.scene.camera.as_deref())?;
    let uploaded = upload(&gpu, &scene, settings, &Progress::hidden())?;
    let renderer = Renderer::new(&Job::new(&gpu, &uploaded, camera, settings))?;
    super::say(&to_dot(renderer.executor().graph(), renderer.executor().plan()))
}

/// Renders a frame into a dump that has no name yet: the last of a mean, else one more like the last. Pictures are of
/// that frame too.
pub(super) fn write_dump(target: DumpTarget, job: &Job<'_>, scene: &Scene, renderer: &Renderer) -> Result<DumpFolder> {
    let mut folder = target.begin()?;
    let settings = &settings_as_used(job.settings, renderer);
    let scene_info = &scene_info(settings, scene, job.camera);
    let sources = dump::Sources { gpu: job.gpu, scene, uploaded: job.scene, renderer, settings, scene_info };
    dump::write(&mut folder, &sources)?;
    Ok(folder)
}

fn report(
    job: &Job<'_>,
    scene: &Scene,
    renderer: &Renderer,
    times: RunTimes,
    counts: crate::report::timings::Counts,
) -> RunReport {
    let settings = settings_as_used(job.settings, renderer);
    RunReport {
        schema: SCHEMA,
        program: Program::this(),
        device: Device::of(job.gpu.report()),
        machine: Machine::here(),
        scene: scene_info(&settings, scene, job.camera),
        frames: settings.run.frames,
        interrupted: None,
        warmup: settings.run.warmup,
        settings,
        times,
        memory: Memory { device_bytes: job.gpu.reserved_bytes(), peak_resident_bytes: peak_resident_bytes() },
        counts,
        rays: RayRates::default(),
        exposure: None,
    }
}

/// The settings with what `None` stood for.
fn settings_as_used(settings: &Settings, renderer: &Renderer) -> Settings {
    settings.clone().changed(|s| renderer.shapes().technique.note_choices(s))
}
