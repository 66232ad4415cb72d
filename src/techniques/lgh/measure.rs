//! What sizes the hierarchy: the settings, the device, and the lights that the light paths leave.

use ash::vk;

use super::super::many_lights::{self, CAPACITY_MARGIN, check_fit};
use super::grid_update;
use crate::gpu::Gpu;
use crate::job::Job;
use crate::light_grid::Levels;
use crate::light_grid::anchor::GridAnchor;
use crate::light_grid::choose_levels::{LevelChoice, choose_levels, light_bounds};
use crate::passes::lgh_shape::LghShape;
use crate::passes::light_volumes::reservoir_bytes;
use crate::passes::{descent, half_picture, merge};
use crate::scene::Aabb;
use crate::settings::{self, FirstLevelBuild, IndirectSize, LevelBuild, LightingMode, Reservoir, Settings, VplSeeds};
use crate::shared::{GridLight, MOMENT_WORDS};
use crate::{Error, Result};

/// One thread sums the lights of eight cells: beyond so many in one, each light adds itself atomically. The sums are the
/// same. Eight times as many passes of a loop are what lavapipe allows (docs/porting.md), and more than others are good for.
const MOST_SORTED_IN_CELL: u32 = 8_000;

/// How lights reach the pixels with these settings.
fn lighting_mode(settings: &Settings) -> LightingMode {
    let only_in_volumes = matches!(settings.lgh.reservoir, Some(Reservoir::Race | Reservoir::Lock));
    let otherwise = if only_in_volumes { LightingMode::Volumes } else { LightingMode::Gather };
    settings.lgh.lighting.unwrap_or(otherwise)
}

/// How a device updates reservoirs when these settings are asked for.
///
/// # Errors
/// [`Error::Usage`] when it cannot do so in the way that they name.
pub fn reservoir_mode(gpu: &Gpu, settings: &Settings) -> Result<Reservoir> {
    if lighting_mode(settings) == LightingMode::Gather {
        return Ok(Reservoir::Exact);
    }
    match settings.lgh.reservoir {
        Some(Reservoir::Exact) if !gpu.features().int64_atomics => Err(Error::Usage(
            "--lighting volumes --reservoir exact needs 64-bit buffer atomics, which this device lacks; use lock or \
             --lighting gather"
                .to_owned(),
        )),
        Some(mode) => Ok(mode),
        None if gpu.features().int64_atomics => Ok(Reservoir::Exact),
        None => Ok(Reservoir::Lock),
    }
}

/// The shape before anything is measured: sizes and modes; no paths, the fewest levels.
pub(super) fn base_shape(job: &Job<'_>) -> Result<LghShape> {
    let (gpu, settings) = (job.gpu, job.settings);
    let size = settings.picture.size;
    let size_px = [size.width, size.height];
    let indirect_size = settings.lgh.indirect_size;
    let rgba32f = gpu.features().blend_rgba32f;
    let shape = LghShape {
        lights: many_lights::base_shape(job),
        picture_px: if indirect_size == IndirectSize::Half { half_picture::halved(size_px) } else { size_px },
        indirect_size,
        interleave: settings.lgh.interleave,
        levels: Levels::new(2),
        anchor: None,
        lobe: settings.lgh.lobe,
        center: settings.lgh.center,
        first_level: settings.lgh.first_level,
        grid_capacity: 1,
        upper_capacity: 1,
        shadow_points: settings.lgh.shadow_points,
        shadow_estimate: settings.lgh.shadow_estimate_or_default(),
        lighting: lighting_mode(settings),
        reservoir: reservoir_mode(gpu, settings)?,
        build: settings.lgh.build,
        scatter: FirstLevelBuild::Sorted,
        grid_update: grid_update::mode(job),
        filter: settings.lgh.filter,
        reuse: super::reuse(job),
        lighting_format: if rgba32f { vk::Format::R32G32B32A32_SFLOAT } else { vk::Format::R16G16B16A16_SFLOAT },
        // A dump shows the lights that every pixel tests.
        count_lights_tested: settings.output.dump.is_some(),
    };
    let [width, height] = shape.interleaved_px();
    job.check_image_size([width, height])?;
    check_reservoirs(gpu, &shape)?;
    Ok(shape)
}

/// Takes over what another shape of the same lights was measured to need.
pub(super) fn take_measures(shape: &mut LghShape, known: &LghShape) {
    many_lights::take_measures(&mut shape.lights, &known.lights);
    (shape.levels, shape.anchor, shape.scatter) = (known.levels, known.anchor, known.scatter);
    (shape.grid_capacity, shape.upper_capacity) = (known.grid_capacity, known.upper_capacity);
}

/// Finds path count, levels and capacities by tracing the paths once.
pub(super) fn measure(job: &Job<'_>, shape: &mut LghShape) -> Result<()> {
    many_lights::measure_paths(job, &mut shape.lights)?;
    let positions = many_lights::trace(job, &shape.lights)?.positions;
    let (low_ws, high_ws) = light_bounds(&positions);
    shape.anchor = anchor(job).map(|anchor| anchor.grown(low_ws, high_ws));
    let fixed = match job.settings.lgh.levels {
        settings::Levels::Auto => None,
        settings::Levels::Fixed(top) => Some(top),
    };
    let fits = |choice: &LevelChoice| {
        let mut sized = shape.clone();
        take_levels(&mut sized, choice);
        largest_buffer_bytes(&sized) <= job.gpu.report().limits.storage_range_bytes
            && merge::light_rows(&sized) <= job.gpu.report().limits.image_edge_px
    };
    let choice = choose_levels(&positions, shape.anchor, fixed, fits);
    take_levels(shape, &choice);
    shape.scatter = scatter_mode(job.settings, choice.most_in_cell);
    check_hierarchy(job, shape)?;
    log::info!("{} lights, {} levels, {} lights in S1", positions.len(), choice.levels.top, choice.s1_count);
    Ok(())
}

/// Where the grids stand when frames have different lights: a grid around the lights of each would move all its vertices with
/// the outermost light, and the light of a whole picture with them.
fn anchor(job: &Job<'_>) -> Option<GridAnchor> {
    let has_lamps = many_lights::scene_lights(job.scene, job.settings) > 0;
    let lamps = if has_lamps { job.scene.lamp_bounds() } else { Aabb::EMPTY };
    let bounds = job.scene.bounds.union(&lamps);
    let differ = job.scene.has_moving_lighting()
        || job.settings.many_lights.vpl_seeds.is_some_and(|seeds| seeds != VplSeeds::Held);
    differ.then(|| GridAnchor::around(bounds.min.to_array(), bounds.max.to_array())).flatten()
}

/// Takes over levels, with room for their lights.
fn take_levels(shape: &mut LghShape, choice: &LevelChoice) {
    let capacity = |count: f64| (count * CAPACITY_MARGIN) as u32 + 1024;
    shape.levels = choice.levels;
    shape.grid_capacity = capacity(f64::from(choice.s1_count) + f64::from(choice.upper_count));
    shape.upper_capacity = capacity(f64::from(choice.upper_count));
}

/// The first level with shadow rays must be there; where the number of levels is chosen, only now it is known.
pub(super) fn check_shadow_levels(job: &Job<'_>, shape: &LghShape) -> Result<()> {
    let (from, top) = (job.settings.lgh.shadow_from, shape.levels.top);
    if shape.lights.shadow_samples == 0 || from <= top {
        return Ok(());
    }
    Err(Error::Usage(format!(
        "--shadow-from {from} lies above the top level, which is {top} for these lights: give at most {top}"
    )))
}

/// How lights are summed into S1 when `most_in_cell` of them share a cell.
fn scatter_mode(settings: &Settings, most_in_cell: u32) -> FirstLevelBuild {
    let crowded = settings.lgh.build == LevelBuild::Scatter || most_in_cell > MOST_SORTED_IN_CELL;
    settings.lgh.scatter.unwrap_or(if crowded { FirstLevelBuild::Atomic } else { FirstLevelBuild::Sorted })
}

/// The reservoirs, the largest buffer of the picture's size, must fit the device.
fn check_reservoirs(gpu: &Gpu, shape: &LghShape) -> Result<()> {
    let limit = gpu.report().limits.storage_range_bytes;
    let shadow_samples = shape.lights.shadow_samples;
    let [width, height] = shape.interleaved_px();
    let pixels = u64::from(width) * u64::from(height);
    // Without reservoirs a word for each pixel remains: counts and discontinuities.
    let bytes = |samples: u32| match samples {
        0 => 4 * pixels,
        _ => reservoir_bytes(shape.reservoir, samples) * pixels,
    };
    if bytes(shadow_samples) <= limit {
        return Ok(());
    }
    let most = (0..shadow_samples).rev().find(|samples| bytes(*samples) <= limit);
    let advice = most.map_or_else(
        || format!("{} pixels would fit", limit / 4),
        |samples| format!("--shadow-samples {samples} would fit"),
    );
    Err(Error::Usage(format!(
        "--size {width}x{height} with --shadow-samples {shadow_samples} needs a buffer of {} MiB, but this device's \
         storage buffers end at {} MiB; {advice}",
        bytes(shadow_samples).div_ceil(1 << 20),
        limit >> 20
    )))
}

/// Bytes of the largest buffer of the hierarchy.
fn largest_buffer_bytes(shape: &LghShape) -> u64 {
    let (lights, upper) = (u64::from(shape.grid_capacity), u64::from(shape.upper_capacity));
    let originals = if shape.first_level == 0 { u64::from(shape.lights.light_capacity()) } else { 0 };
    let moments = 4 * u64::from(MOMENT_WORDS) * lights;
    let merged = size_of::<GridLight>() as u64 * (lights + originals);
    moments.max(merged).max(descent::TABLE_BYTES * upper)
}

/// The largest buffer of the hierarchy, and the image that holds the merged lights, must fit the device.
fn check_hierarchy(job: &Job<'_>, shape: &LghShape) -> Result<()> {
    check_fit(job, largest_buffer_bytes(shape) as f64)?;
    let (rows, limit) = (merge::light_rows(shape), job.gpu.report().limits.image_edge_px);
    if rows <= limit {
        return Ok(());
    }
    Err(Error::Usage(format!(
        "--vpls leads to an image of {rows} rows for the lights of the hierarchy, beyond this device's limit of {limit}; \
         ask for fewer"
    )))
}
