//! The shape of a frame: what every frame has, and the technique's part of it.

use super::Job;
use crate::error::{Error, Result};
use crate::passes::{FrameShape, SurfaceMotion};
use crate::settings::{Rays, View};
use crate::techniques::{Shapes, Technique, TechniqueShape, check_with};
use crate::uploaded_scene::check_rays;

/// More direct lights than this make the direct pass slow enough to say so.
const MANY_DIRECT_LIGHTS: u32 = 64;

/// Checks the settings and finds the shapes for a job, with what `known` was measured to need.
pub(super) fn checked_shapes(
    technique: &dyn Technique,
    job: &Job<'_>,
    known: Option<&dyn TechniqueShape>,
) -> Result<Shapes> {
    check_with(technique, job.settings)?;
    let shapes = shapes(technique, job, known)?;
    let direct_lights = job.scene.light_count - technique.own_lights(job.scene, job.settings);
    if direct_lights > MANY_DIRECT_LIGHTS {
        log::warn!(
            "{direct_lights} lights are shaded one by one at every pixel; --lights both puts point lights into the hierarchy"
        );
    }
    Ok(shapes)
}

/// What of the motion of surfaces the frame needs to know, if anything.
fn surface_motion(technique: &dyn Technique, job: &Job<'_>, taa: bool) -> Option<SurfaceMotion> {
    let needed = taa || job.settings.render.view == View::MotionVectors || technique.reuse(job).is_some();
    let by = if job.scene.has_moving_vertices() { SurfaceMotion::Vertices } else { SurfaceMotion::Camera };
    needed.then_some(by)
}

/// The same without checks that need no device.
pub(super) fn shapes(technique: &dyn Technique, job: &Job<'_>, known: Option<&dyn TechniqueShape>) -> Result<Shapes> {
    let mut frame = FrameShape::new(job);
    for light in [&mut frame.environment, &mut frame.emitters].into_iter().flatten() {
        light.is_filtered &= technique.filters_area_light(job.settings);
        light.reuse = technique.reuse(job);
    }
    frame.surface_motion = surface_motion(technique, job, frame.taa);
    check_rays(job.gpu, frame.rays)?;
    if frame.rays == Rays::Query && !job.scene.has_structures {
        return Err(Error::Failure("the scene was uploaded without acceleration structures".to_owned()));
    }
    job.check_image_size([frame.width_px, frame.height_px])?;
    Ok(Shapes { technique: technique.shape(job, known)?, frame })
}
