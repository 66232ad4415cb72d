//! Rendering every view of a scene into files of their own.

use super::frames::run_frames;
use super::headless::{answer, note};
use super::outputs::Outputs;
use super::setup::{find_camera, load_scene, open_gpu, upload};
use crate::cli::Verbosity;
use crate::progress::Progress;
use crate::renderer::{Job, Renderer};
use crate::report::timings::RunTimes;
use crate::settings::Settings;
use crate::{Error, Result, interrupt};

/// Renders the same frame with each of these settings, which differ in their view and its file, and writes the pictures.
///
/// # Errors
/// Whatever stands in the way; files are then as they were, unless the run was interrupted: views that are finished stay.
pub fn render(each: &[Settings], verbosity: Verbosity) -> Result<()> {
    let Some(first) = each.first() else { return Ok(()) };
    let progress = Progress::new(verbosity.quiet);
    let outputs = each.iter().map(Outputs::prepare).collect::<Result<Vec<_>>>()?;
    interrupt::listen()?;
    let gpu = open_gpu(first)?;
    let scene = load_scene(first, &progress)?;
    let camera = &find_camera(&scene, first.scene.camera.as_deref())?;
    let uploaded = upload(&gpu, &scene, first, &progress)?;
    let mut pictures = Vec::new();
    let mut said = None;
    let mut interrupted = None;
    let bar = progress.bar("views", each.len() as u64);
    for (settings, outputs) in each.iter().zip(outputs) {
        if interrupt::requested() {
            interrupted = Some(format!("interrupted after {} of {} views", pictures.len(), each.len()));
            break;
        }
        let job = Job::new(&gpu, &uploaded, camera, settings);
        let mut renderer = Renderer::new(&job)?;
        let frames = run_frames(&mut renderer, settings, None, &mut (), &Progress::hidden())?;
        let picture = renderer.read_picture(note(settings, frames.times.len(), None))?;
        pictures.extend(outputs.picture.map(|file| (file, picture)));
        bar.set(pictures.len() as u64);
        if let (None, Some(times)) = (&said, RunTimes::of(&frames.times)) {
            said = Some(answer(&job, &scene, &renderer, (&times, renderer.read_exposure()?), &[])?);
        }
    }
    bar.finish();
    gpu.check_validation()?;
    let mut text = said.unwrap_or_default();
    for (file, picture) in pictures {
        text += &format!("\nwritten: {}", file.path().display());
        file.commit_picture(&picture)?;
    }
    if !verbosity.quiet {
        super::say(&text)?;
    }
    interrupted.map_or(Ok(()), |sentence| Err(Error::Interrupted(format!("{sentence}; that much is written"))))
}
