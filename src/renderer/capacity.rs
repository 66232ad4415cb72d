//! What fits a device: buffers and images whose size follows from the settings, checked before they are made.

use crate::gpu::Gpu;
use crate::passes::light_volumes::reservoir_bytes;
use crate::passes::{FrameShape, descent, merge};
use crate::settings::{Build, Scatter, Settings};
use crate::shared::{GridLight, MOMENT_WORDS};
use crate::{Error, Result};

/// One thread sums the lights of a cell: beyond so many, threads that add atomically are faster.
const MOST_SORTED_IN_CELL: u32 = 16_384;

/// The reservoirs, the largest buffer of the picture's size, must fit the device.
pub(super) fn check_reservoirs(gpu: &Gpu, shape: &FrameShape) -> Result<()> {
    let limit = gpu.report().limits.storage_range_bytes;
    let [width, height] = shape.interleaved_px();
    let pixels = u64::from(width) * u64::from(height);
    // Without reservoirs a word for each pixel remains: counts and discontinuities.
    let bytes = |samples: u32| match samples {
        0 => 4 * pixels,
        _ => reservoir_bytes(shape.reservoir, samples) * pixels,
    };
    if bytes(shape.shadow_samples) <= limit {
        return Ok(());
    }
    let most = (0..shape.shadow_samples).rev().find(|samples| bytes(*samples) <= limit);
    let advice = most.map_or_else(
        || format!("{} pixels would fit", limit / 4),
        |samples| format!("--shadow-samples {samples} would fit"),
    );
    Err(Error::Usage(format!(
        "--size {width}x{height} with --shadow-samples {} needs a buffer of {} MiB, but this device's storage \
         buffers end at {} MiB; {advice}",
        shape.shadow_samples,
        bytes(shape.shadow_samples).div_ceil(1 << 20),
        limit >> 20
    )))
}

/// The slots of the light paths, 16 bytes each, must fit the device.
pub(super) fn check_slots(gpu: &Gpu, settings: &Settings, slots_per_vpl: f64) -> Result<()> {
    check_vpls(gpu, settings, 16.0 * slots_per_vpl * f64::from(settings.many_lights.vpls))
}

/// The largest buffer of the hierarchy must fit the device.
pub(super) fn check_hierarchy(gpu: &Gpu, settings: &Settings, shape: &FrameShape) -> Result<()> {
    let (lights, upper) = (u64::from(shape.grid_capacity), u64::from(shape.upper_capacity));
    let originals = if shape.first_level == 0 { u64::from(shape.light_capacity()) } else { 0 };
    let moments = 4 * u64::from(MOMENT_WORDS) * lights;
    let merged = size_of::<GridLight>() as u64 * (lights + originals);
    check_vpls(gpu, settings, moments.max(merged).max(descent::TABLE_BYTES * upper) as f64)?;
    check_light_rows(gpu, shape)
}

/// The largest buffer, which grows with the number of VPLs, must fit.
fn check_vpls(gpu: &Gpu, settings: &Settings, largest_bytes: f64) -> Result<()> {
    let limit = gpu.report().limits.storage_range_bytes as f64;
    if largest_bytes <= limit {
        return Ok(());
    }
    Err(Error::Usage(format!(
        "--vpls {} does not fit this device, whose storage buffers end at {} MiB; about {:.0} would fit",
        settings.many_lights.vpls,
        limit as u64 >> 20,
        (f64::from(settings.many_lights.vpls) * limit / largest_bytes / 1000.0 * 0.97).floor() * 1000.0
    )))
}

/// How lights are summed into S1 when `most_in_cell` of them share a cell.
pub(super) fn scatter_mode(settings: &Settings, most_in_cell: u32) -> Scatter {
    let crowded = settings.lgh.build == Build::Scatter || most_in_cell > MOST_SORTED_IN_CELL;
    settings.lgh.scatter.unwrap_or(if crowded { Scatter::Atomic } else { Scatter::Sorted })
}

/// The image that holds the merged lights must fit the device.
fn check_light_rows(gpu: &Gpu, shape: &FrameShape) -> Result<()> {
    let (rows, limit) = (merge::light_rows(shape), gpu.report().limits.image_edge_px);
    if rows <= limit {
        return Ok(());
    }
    Err(Error::Usage(format!(
        "--vpls leads to an image of {rows} rows for the lights of the hierarchy, beyond this device's limit of {limit}; \
         ask for fewer"
    )))
}
