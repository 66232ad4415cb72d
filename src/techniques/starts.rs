//! Where light paths start, learnt before the first frame from what the camera sees.

use std::sync::Arc;

use crate::Result;
use crate::gpu::Executor;
use crate::job::Job;
use crate::light_paths::{self, Learnt, StartDensity};
use crate::passes::{Frame, FrameShape, light_starts};
use crate::settings::VplImportance;
use crate::shared::StartSample;

/// Starts are chosen where of so many paths that start anywhere only one counts. In a room where more of them do, what is
/// learnt has more noise than it takes away.
const WORTH_CHOOSING: f64 = 8.0;

/// Where paths start, learnt for a camera; `None` where as many start everywhere.
pub(super) fn learn_starts(job: &Job<'_>) -> Result<Option<StartDensity>> {
    let settings = &job.settings.many_lights;
    let others = [job.has_environment(), job.scene.emitter_count > 0];
    let lights = job.scene.light_count + others.map(u32::from).iter().sum::<u32>();
    if settings.vpl_importance == VplImportance::None || lights == 0 {
        return Ok(None);
    }
    let samples = find_starts(job, settings.bounces)?;
    let Some(learnt) = light_paths::learn(&samples, settings.bounces, lights == 1) else {
        return Ok(None);
    };
    let Learnt { density, concentration } = learnt;
    log::info!("of {concentration:.1} light paths that start anywhere, one counts");
    Ok((concentration > WORTH_CHOOSING).then_some(density))
}

fn find_starts(job: &Job<'_>, bounces: u32) -> Result<Vec<StartSample>> {
    let mut frame = Frame::new(FrameShape::new(job));
    let changing_flux = job.scene.has_moving_lights().then_some(job.scene.light_flux as f32);
    let samples = light_starts::add(&mut frame, bounces, changing_flux);
    let mut executor = Executor::new(job.gpu, frame.graph, Some(Arc::clone(&job.scene.set)))?;
    let mut data = job.frame_data();
    data.bounces = bounces;
    // Where paths start is the same with every seed, so that runs differ by their paths alone.
    data.seed = 0;
    let ticket = executor.submit(bytemuck::bytes_of(&data))?;
    executor.wait(ticket)?;
    Ok(bytemuck::pod_collect_to_vec(&executor.read_buffer(samples)?))
}
