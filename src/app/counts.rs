//! What a frame counted: rays, and what its technique counts. Read after the measured frames; what is
//! slow to count comes from one extra frame.

use crate::Result;
use crate::job::Job;
use crate::passes::FrameShape;
use crate::renderer::Renderer;
use crate::report::timings::{Counts, RayCounts};
use crate::settings::View;
use crate::techniques::Shapes;

/// Rays that the last frame traced.
///
/// # Errors
/// When the device is lost.
pub fn rays(renderer: &Renderer) -> Result<RayCounts> {
    let words: Vec<u32> = bytemuck::pod_collect_to_vec(&renderer.executor().read_buffer(renderer.outputs().ray_count)?);
    Ok(RayCounts { vpl: words[0].into(), shadow: words[1].into(), environment: words[2].into() })
}

/// Counts of the last frame of `renderer`; renders one more frame where a technique has more to count.
///
/// # Errors
/// When the device is lost.
pub fn count(job: &Job<'_>, renderer: &Renderer) -> Result<Counts> {
    let RayCounts { vpl, shadow, environment } = rays(renderer)?;
    let rays = [("vpl_rays", vpl), ("shadow_rays", shadow), ("environment_rays", environment)];
    let mut counts: Counts = rays.into_iter().map(|(name, count)| (name.to_owned(), count.into())).collect();
    let mut note = |renderer: &Renderer| -> Result<()> {
        let counted = renderer.shapes().technique.counts(&renderer.read_counters()?);
        counts.extend(counted.into_iter().map(|count| (count.key.to_owned(), count.value)));
        Ok(())
    };
    let Shapes { frame, technique } = renderer.shapes();
    let has_counters = !renderer.outputs().technique.counters.is_empty();
    if let Some(technique) = technique.counting().filter(|_| has_counters) {
        let frame = FrameShape { view: View::Final, ..frame.clone() };
        let mut counting = Renderer::with_shapes(job, Shapes { frame, technique })?;
        let ticket = counting.submit()?;
        counting.wait(ticket)?;
        note(&counting)?;
    }
    note(renderer)?;
    Ok(counts)
}
