//! What shapes a frame: the settings, the device, and how many lights the light paths leave.

use std::sync::Arc;

use ash::vk;

use super::capacity::{check_hierarchy, check_reservoirs, check_slots, scatter_mode};
use super::frame_data;
use crate::error::{Error, Result};
use crate::frame;
use crate::gpu::{Executor, Gpu};
use crate::job::Job;
use crate::light_grid::Levels;
use crate::light_grid::choose_levels::{LevelChoice, choose_levels};
use crate::passes::FrameShape;
use crate::settings::{self, LightSet, LightingMode, Rays, Reservoir, Scatter, Settings, Technique};
use crate::uploaded_scene::check_rays;

/// Paths of the pilot run that measures how many VPLs a path leaves.
const PILOT_PATHS: u32 = 16_384;
/// Below this the scene is hardly hit, and the paths are what is limited.
const FEW_VPLS_PER_PATH: f64 = 1.0 / 16.0;
/// Room for other seeds than the one the capacities were measured with.
const CAPACITY_MARGIN: f64 = 1.25;

/// Checks the settings and finds the frame's shape.
pub(super) fn measured_shape(job: &Job<'_>) -> Result<FrameShape> {
    job.settings.validate_view()?;
    check_lights(job)?;
    let mut shape = base_shape(job)?;
    if is_measured(job.settings) {
        calibrate(job, &mut shape)?;
    }
    Ok(shape)
}

/// Whether light paths decide the shape.
pub(super) fn is_measured(settings: &Settings) -> bool {
    let many_lights = matches!(settings.render.technique, Technique::Lgh | Technique::BruteForce);
    many_lights && frame::needs_lights(settings.render.view)
}

/// More direct lights than this make the direct pass slow enough to say so.
const MANY_DIRECT_LIGHTS: u32 = 64;

pub(super) fn check_lights(job: &Job<'_>) -> Result<()> {
    let Job { scene, settings, .. } = job;
    let point_lights = scene.light_count - scene.first_point_light;
    let many_lights = matches!(settings.render.technique, Technique::Lgh | Technique::BruteForce);
    if many_lights && settings.many_lights.lights == LightSet::Scene && point_lights == 0 {
        return Err(Error::Usage(
            "--lights scene needs point lights, and the scene has none; use --lights vpl".to_owned(),
        ));
    }
    if scene.direct_lights(settings) > MANY_DIRECT_LIGHTS {
        log::warn!(
            "{} lights are shaded one by one at every pixel; --lights both puts point lights into the hierarchy",
            scene.direct_lights(settings)
        );
    }
    Ok(())
}

/// How lights reach the pixels with these settings.
#[must_use]
pub fn lighting_mode(settings: &Settings) -> LightingMode {
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

/// The shape before calibration: sizes and modes; no paths, the fewest levels.
pub(super) fn base_shape(job: &Job<'_>) -> Result<FrameShape> {
    let Job { gpu, scene, settings, .. } = job;
    let features = gpu.features();
    let reservoir = reservoir_mode(gpu, settings)?;
    check_rays(gpu, settings.tracing.rays)?;
    if settings.tracing.rays == Rays::Query && !scene.has_structures {
        return Err(Error::Failure("the scene was uploaded without acceleration structures".to_owned()));
    }
    let lighting_format =
        if features.blend_rgba32f { vk::Format::R32G32B32A32_SFLOAT } else { vk::Format::R16G16B16A16_SFLOAT };
    let shape = FrameShape {
        width_px: settings.picture.size.width,
        height_px: settings.picture.size.height,
        direct: settings.render.direct.is_on(),
        accumulate: settings.render.accumulate > 1,
        samples: settings.path_trace.samples,
        interleave: settings.lgh.interleave,
        levels: Levels::new(2),
        lobe: settings.lgh.lobe,
        center: settings.lgh.center,
        first_level: settings.lgh.first_level,
        path_count: 0,
        bounces: settings.many_lights.bounces,
        vpl_capacity: 0,
        scene_light_count: scene.hierarchy_lights(settings),
        grid_capacity: 1,
        upper_capacity: 1,
        shadow_points: settings.lgh.shadow_points,
        shadow_samples: if settings.many_lights.shadows.is_on() { settings.many_lights.shadow_samples } else { 0 },
        lighting: lighting_mode(settings),
        reservoir,
        rays: settings.tracing.rays,
        build: settings.lgh.build,
        scatter: Scatter::Sorted,
        filter: settings.lgh.filter,
        lighting_format,
        // A dump shows the fragments of every pixel.
        count_overdraw: settings.output.dump.is_some(),
        view: settings.render.view,
        inspect: false,
    };
    let limit = gpu.report().limits.image_edge_px;
    let [width, height] = shape.interleaved_px();
    if width > limit || height > limit {
        return Err(Error::Usage(format!("--size {width}x{height} is beyond this device's limit of {limit}x{limit}")));
    }
    if settings.render.technique == Technique::Lgh {
        check_reservoirs(gpu, &shape)?;
    }
    Ok(shape)
}

/// Finds path count, VPL count, levels and capacities by tracing the paths once before the first frame.
fn calibrate(job: &Job<'_>, shape: &mut FrameShape) -> Result<()> {
    let Job { gpu, settings, .. } = job;
    if settings.many_lights.lights != LightSet::Scene {
        shape.path_count = PILOT_PATHS.min(settings.many_lights.vpls);
        shape.vpl_capacity = shape.slot_count();
        let pilot = trace_lights(job, shape)?.len() as u32 - shape.scene_light_count;
        let vpls_per_path = f64::from(pilot.max(1)) / f64::from(shape.path_count);
        let paths = (f64::from(settings.many_lights.vpls) / vpls_per_path).ceil();
        // Where few paths hit anything, as many paths as fit must do.
        if vpls_per_path >= FEW_VPLS_PER_PATH {
            check_slots(gpu, settings, f64::from(settings.many_lights.bounces) / vpls_per_path)?;
        }
        let slots_that_fit = gpu.report().limits.storage_range_bytes as f64 / 16.0;
        let most_paths =
            (slots_that_fit / f64::from(settings.many_lights.bounces)).min(f64::from(settings.many_lights.vpls) * 64.0);
        shape.path_count = if pilot == 0 { 1 } else { paths.min(most_paths) as u32 };
        shape.vpl_capacity =
            shape.slot_count().min((f64::from(settings.many_lights.vpls) * CAPACITY_MARGIN) as u32 + 1024);
    }
    let positions = trace_lights(job, shape)?;
    if positions.is_empty() {
        log::warn!("no light reaches the scene: there is no indirect light");
    }
    let fixed = match settings.lgh.levels {
        settings::Levels::Auto => None,
        settings::Levels::Fixed(top) => Some(top),
    };
    let LevelChoice { levels, s1_count, most_in_cell } = choose_levels(&positions, fixed);
    let top = levels.top;
    let upper: u32 = (2..=top).map(|l| choose_levels(&positions, Some(top - l + 1)).s1_count).sum();
    shape.levels = levels;
    shape.scatter = scatter_mode(settings, most_in_cell);
    shape.grid_capacity = (f64::from(s1_count + upper) * CAPACITY_MARGIN) as u32 + 1024;
    shape.upper_capacity = (f64::from(upper) * CAPACITY_MARGIN) as u32 + 1024;
    check_hierarchy(gpu, settings, shape)?;
    log::info!("{} lights, {} levels, {s1_count} lights in S1", positions.len(), top);
    Ok(())
}

/// Positions of the lights S0 for a shape.
fn trace_lights(job: &Job<'_>, shape: &FrameShape) -> Result<Vec<[f32; 3]>> {
    let (graph, lights) = frame::build_lights(shape.clone());
    let mut executor = Executor::new(job.gpu, graph, Some(Arc::clone(&job.scene.set)))?;
    let data = frame_data(job, shape);
    let ticket = executor.submit(bytemuck::bytes_of(&data))?;
    executor.wait(ticket)?;
    let counts: Vec<u32> = bytemuck::pod_collect_to_vec(&executor.read_buffer(lights.counts)?);
    let positions: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&executor.read_buffer(lights.positions)?);
    Ok(positions.iter().take(counts[0] as usize).map(|p| [p[0], p[1], p[2]]).collect())
}
