//! Runs the frames of a headless run, one after the other.

use crate::error::{Error, Result};
use crate::gpu::FrameCapture;
use crate::interrupt;
use crate::progress::Progress;
use crate::renderer::{Fresh, Renderer};
use crate::report::timings::FrameTimes;
use crate::settings::Settings;

/// Steps of a progress bar per frame.
pub(super) const SUBDIVISION: u64 = 100;

/// What was rendered.
pub struct Frames {
    /// Times of the measured frames.
    pub times: Vec<FrameTimes>,
    /// How far the run came when it was interrupted.
    pub interrupted: Option<String>,
    /// What the first frame that left something out had no room for.
    pub complaint: Option<String>,
}

/// What happens around the frames of a run.
pub trait AroundFrames {
    /// Before a frame; those that are not measured are frame 0 too.
    ///
    /// # Errors
    /// Whatever stands in the way of the frame.
    fn before(&mut self, renderer: &mut Renderer, frame: u32) -> Result<()>;

    /// Passes that ran before the frame, for it alone, and how long they took in milliseconds: the same ones for all frames.
    fn passes_before(&mut self) -> Vec<(String, f64)> {
        Vec::new()
    }

    /// Whether a frame is thrown away, because it had no room for something that another one will have.
    ///
    /// # Errors
    /// Whatever stands in the way of the other frame.
    fn render_again(&mut self, _renderer: &mut Renderer, _frame: u32) -> Result<bool> {
        Ok(false)
    }

    /// After a measured frame that is whole.
    ///
    /// # Errors
    /// Whatever ends the run.
    fn after(&mut self, renderer: &Renderer, frame: u32) -> Result<()>;
}

/// Nothing happens around them.
impl AroundFrames for () {
    fn before(&mut self, _: &mut Renderer, _: u32) -> Result<()> {
        Ok(())
    }

    fn after(&mut self, _: &Renderer, _: u32) -> Result<()> {
        Ok(())
    }
}

/// Serial frames: each is waited for before the next, so that wall clock and GPU clock can be compared. An
/// interrupted run ends with the frame, or with the round of a reference technique, that it is in.
///
/// # Errors
/// [`Error::Interrupted`] when it was interrupted before anything was measured; device errors, and those of `around`.
pub fn run_frames(
    renderer: &mut Renderer,
    settings: &Settings,
    mut capture: Option<FrameCapture>,
    around: &mut dyn AroundFrames,
    progress: &Progress,
) -> Result<Frames> {
    let names = renderer.pass_names();
    let warmup = u64::from(settings.run.warmup);
    // The last frame of a mean is left to the dump, which runs it in its own way.
    let dumped = u64::from(settings.output.dump.is_some() && settings.render.accumulate > 1);
    let measured = u64::from(settings.run.frames.max(settings.render.accumulate)) - dumped;
    let bar = progress.bar("frames", SUBDIVISION * (warmup + measured));
    let mut times = Vec::new();
    let mut interrupted = None;
    let mut complaint = None;
    for index in 0..warmup + measured {
        let number = index.saturating_sub(warmup) as u32;
        if let Some(capture) = &mut capture {
            capture.begin(index);
        }
        around.before(renderer, number)?;
        let mut pass_ms = around.passes_before();
        if settings.render.accumulate > 1 {
            renderer.set_accumulated_frame(number, Fresh::All);
        }
        let mut on_step = |done: u32, total: u32| {
            bar.set(SUBDIVISION * index + SUBDIVISION * u64::from(done) / u64::from(total.max(1)));
            interrupt::control_flow()
        };
        let max_submit_ms = f64::from(settings.device.max_submit_ms);
        let mut frame = renderer.run_in_steps(max_submit_ms, &mut on_step)?;
        if around.render_again(renderer, number)? {
            frame = renderer.run_in_steps(max_submit_ms, &mut on_step)?;
        }
        if let Some(capture) = &mut capture {
            capture.end(true)?;
        }
        if index >= warmup {
            let gpu_ms = frame.times.gpu_ms() + pass_ms.iter().map(|(_, ms)| ms).sum::<f64>();
            pass_ms.extend(names.iter().cloned().zip(frame.times.pass_ms));
            times.push(FrameTimes { pass_ms, gpu_ms, cpu_ms: frame.times.cpu_ms });
            log::debug!("frame {} of {measured}: {gpu_ms:.1} ms", times.len());
        }
        bar.set(SUBDIVISION * (index + 1));
        // The frames of a mean have lights of their own; others have those of the last one.
        if settings.render.accumulate > 1 && complaint.is_none() {
            complaint = renderer.complaint()?;
        }
        let is_last = index + 1 == warmup + measured;
        let partly = frame.rounds_done < frame.rounds;
        if index >= warmup && !partly {
            around.after(renderer, number)?;
        }
        if interrupt::requested() && (!is_last || partly) {
            let rounds = if partly {
                format!(", of the last {} of {} rounds", frame.rounds_done, frame.rounds)
            } else {
                String::new()
            };
            interrupted = Some(format!("interrupted after {} of {measured} frames{rounds}", times.len()));
            break;
        }
    }
    bar.finish();
    if times.is_empty() {
        return Err(Error::Interrupted("interrupted before the first measured frame; nothing is written".to_owned()));
    }
    Ok(Frames { times, interrupted, complaint })
}
