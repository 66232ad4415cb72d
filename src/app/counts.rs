//! What a frame counted: rays, and what its technique counts. Read after the measured frames; what is
//! slow to count comes from one extra frame.

use crate::Result;
use crate::job::Job;
use crate::passes::FrameShape;
use crate::renderer::Renderer;
use crate::report::timings::Counts;
use crate::settings::View;
use crate::techniques::Shapes;

/// Rays that the last frame traced for virtual point lights and for shadows.
///
/// # Errors
/// When the device is lost.
pub fn rays(renderer: &Renderer) -> Result<[u64; 2]> {
    let words: Vec<u32> = bytemuck::pod_collect_to_vec(&renderer.executor().read_buffer(renderer.outputs().ray_count)?);
    Ok([words[0].into(), words[1].into()])
}

/// Counts of the last frame of `renderer`; renders one more frame where a technique has more to count.
///
/// # Errors
/// When the device is lost.
pub fn count(job: &Job<'_>, renderer: &Renderer) -> Result<Counts> {
    let [vpl_rays, shadow_rays] = rays(renderer)?;
    let mut counts =
        Counts::from_iter([("vpl_rays".to_owned(), vpl_rays.into()), ("shadow_rays".to_owned(), shadow_rays.into())]);
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
