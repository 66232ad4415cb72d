//! What sizes the passes: the settings, the picture, and the primary points that the camera finds in it.

use std::sync::Arc;

use super::super::TechniqueShape;
use crate::Result;
use crate::gpu::Executor;
use crate::job::Job;
use crate::passes::pbgi_shape::PbgiShape;
use crate::passes::point_cut::Hidden;
use crate::passes::points::Points;
use crate::passes::{Frame, FrameShape, gbuffer, point_cut};
use crate::settings::{Settings, Switch};
use crate::shared::{MAX_PRIMARIES, PointCounts};

/// Pixels of the picture for each primary point that there is room for, however few the camera finds at first.
const PIXELS_PER_PRIMARY: u64 = 12;
/// Primary points that there is room for however small the picture is.
const LEAST_PRIMARIES: u64 = 4096;
/// Room for primary points over those that were found.
const CAPACITY_MARGIN: f64 = 1.25;
/// References from tiles for each primary point.
const REFERENCES_PER_PRIMARY: u32 = 64;

/// The shape for a job; `known` was measured before for settings of which [`keeps_measures`] holds.
pub(super) fn shape(job: &Job<'_>, known: Option<&PbgiShape>) -> Result<PbgiShape> {
    let mut shape = base_shape(job)?;
    let capacity = match known {
        Some(known) => known.primary_capacity,
        None => roomy(job, count_primaries(job, &shape)?),
    };
    shape.primary_capacity = capacity;
    shape.reference_capacity = REFERENCES_PER_PRIMARY * capacity;
    Ok(shape)
}

/// Whether as many primary points are to be expected.
pub(super) fn keeps_measures(now: &Settings, before: &Settings) -> bool {
    now.pbgi.points == before.pbgi.points && now.picture.size == before.picture.size
}

/// The shape before anything is measured: modes, and no room.
pub(super) fn base_shape(job: &Job<'_>) -> Result<PbgiShape> {
    let settings = &job.settings.pbgi;
    Ok(PbgiShape {
        cloud: Arc::clone(job.scene.points(settings.points.ilog2())?),
        primary_capacity: 0,
        reference_capacity: 0,
        reuse: settings.reuse == Switch::On,
        micro: settings.micro,
        coverage: settings.coverage,
        hemisphere: settings.hemisphere,
        selection: settings.selection,
        bounces: settings.point_bounces,
        environment_means: job.scene.environment_means(),
    })
}

/// Room for so many primary points, and for those of other cameras.
fn roomy(job: &Job<'_>, found: u32) -> u32 {
    let size = job.settings.picture.size;
    let usual = LEAST_PRIMARIES + u64::from(size.width) * u64::from(size.height) / PIXELS_PER_PRIMARY;
    let measured = (f64::from(found) * CAPACITY_MARGIN) as u64;
    usual.max(measured).min(MAX_PRIMARIES.into()) as u32
}

/// How many primary points the camera finds.
fn count_primaries(job: &Job<'_>, shape: &PbgiShape) -> Result<u32> {
    let mut frame = Frame::new(FrameShape::new(job));
    let gbuffer = gbuffer::add(&mut frame);
    let points = Points::declare(&mut frame, &shape.cloud);
    let cut = point_cut::add(&mut frame, gbuffer.depth, &points, 1, Hidden::Dropped);
    let mut executor = Executor::new(job.gpu, frame.graph, Some(Arc::clone(&job.scene.set)))?;
    let mut data = job.frame_data();
    shape.write_constants(job, &mut data);
    let ticket = executor.submit(bytemuck::bytes_of(&data))?;
    executor.wait(ticket)?;
    let counts: PointCounts = bytemuck::pod_read_unaligned(&executor.read_buffer(cut.counts.counts)?);
    Ok(counts.primary_count + counts.primaries_lost)
}
