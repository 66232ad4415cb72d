//! What a frame counted: lights, rays, overdraw. Read after the measured frames, the overdraw from one extra frame.

use crate::Result;
use crate::job::Job;
use crate::passes::FrameShape;
use crate::renderer::Renderer;
use crate::report::timings::Counts;
use crate::settings::View;

/// Rays that the last frame traced for virtual point lights and for shadows.
///
/// # Errors
/// When the device is lost.
pub fn rays(renderer: &Renderer) -> Result<[u64; 2]> {
    let words: Vec<u32> = bytemuck::pod_collect_to_vec(&renderer.executor().read_buffer(renderer.outputs().ray_count)?);
    Ok([words[0].into(), words[1].into()])
}

/// Counts of the last frame of `renderer`; renders one more frame with fragments counted.
///
/// # Errors
/// When the device is lost.
pub fn count(job: &Job<'_>, renderer: &Renderer) -> Result<Counts> {
    let words =
        |buffer| -> Result<Vec<u32>> { Ok(bytemuck::pod_collect_to_vec(&renderer.executor().read_buffer(buffer)?)) };
    let [vpl_rays, shadow_rays] = rays(renderer)?;
    let mut counts = Counts { vpl_rays, shadow_rays, ..Counts::default() };
    let Some(hierarchy) = &renderer.outputs().hierarchy else { return Ok(counts) };
    let lights = words(hierarchy.lights.counts)?;
    let levels = words(hierarchy.grid.level_table)?;
    let top = renderer.shape().levels.top;
    counts.vpls = lights[1].into();
    counts.paths = renderer.shape().path_count.into();
    counts.level_count = top;
    counts.grid_lights_per_level = (1..=top as usize).map(|l| levels[2 * l + 1]).collect();
    warn_of_overflow(lights[2], levels.last().copied().unwrap_or(0));
    let shape = FrameShape { count_overdraw: true, view: View::Final, ..renderer.shape().clone() };
    let (mean, most) = overdraw(Renderer::with_shape(job, shape)?)?;
    (counts.overdraw_mean, counts.overdraw_max) = (mean, most);
    Ok(counts)
}

fn warn_of_overflow(vpls: u32, grid_lights: u32) {
    if vpls > 0 || grid_lights > 0 {
        log::warn!("{vpls} VPLs and {grid_lights} grid lights did not fit and were left out");
    }
}

/// Mean and largest number of light-volume fragments per pixel.
fn overdraw(mut renderer: Renderer) -> Result<(f64, u32)> {
    let ticket = renderer.submit()?;
    renderer.wait(ticket)?;
    let Some(hierarchy) = renderer.outputs().hierarchy else { return Ok((0.0, 0)) };
    let bytes = renderer.executor().read_buffer(hierarchy.overdraw)?;
    let fragments: Vec<u32> = bytemuck::pod_collect_to_vec(&bytes);
    let pixels = f64::from(renderer.shape().width_px) * f64::from(renderer.shape().height_px);
    let sum: f64 = fragments.iter().map(|f| f64::from(*f)).sum();
    Ok((sum / pixels, fragments.iter().copied().max().unwrap_or(0)))
}
