//! What sizes the passes: the settings and the picture.

use std::sync::Arc;

use crate::Result;
use crate::job::Job;
use crate::passes::pbgi_shape::PbgiShape;
use crate::shared::MAX_PRIMARIES;

/// Pixels of the picture for each primary point that there is room for.
const PIXELS_PER_PRIMARY: u64 = 12;
/// Primary points that there is room for however small the picture is.
const LEAST_PRIMARIES: u64 = 4096;
/// References from tiles for each primary point.
const REFERENCES_PER_PRIMARY: u32 = 64;

/// The shape for a job.
pub(super) fn shape(job: &Job<'_>) -> Result<PbgiShape> {
    let settings = &job.settings.pbgi;
    let size = job.settings.picture.size;
    let pixels = u64::from(size.width) * u64::from(size.height);
    let primary_capacity = (LEAST_PRIMARIES + pixels / PIXELS_PER_PRIMARY).min(MAX_PRIMARIES.into()) as u32;
    Ok(PbgiShape {
        cloud: Arc::clone(job.scene.points(settings.points.ilog2())?),
        primary_capacity,
        reference_capacity: REFERENCES_PER_PRIMARY * primary_capacity,
        micro: settings.micro,
        coverage: settings.coverage,
        hemisphere: settings.hemisphere,
        selection: settings.selection,
        environment_means: job.scene.environment_means(),
    })
}
