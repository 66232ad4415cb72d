//! What the techniques of many lights share: the lights S0 and how many there are.

use std::sync::Arc;

use glam::Vec3;

use super::rules::is_of_every_frame;
use super::spacing::{disc_radius, median};
use super::{AddedView, Count, TechniqueOutputs, starts};
use crate::color::luminance;
use crate::dump::{
    Array, COUNT, DumpContext, Entry, Field, METRES_AND_BITS, Scalar, all_words, buffer, f, noted, ranks, u,
};
use crate::gpu::Executor;
use crate::job::Job;
use crate::passes::compaction::{self, Lights};
use crate::passes::direct_light::AreaLight;
use crate::passes::gbuffer::GBuffer;
use crate::passes::light_shape::{LightShape, SLOTS_AT_ONCE};
use crate::passes::{Frame, FrameShape, debug_view, direct_light, vpl_trace};
use crate::settings::{LightSet, Settings, View};
use crate::shared::{FrameData, StartCell};
use crate::uploaded_scene::UploadedScene;
use crate::{Error, Result};

/// Paths of the pilot run that measures how many VPLs a path leaves.
const PILOT_PATHS: u32 = 16_384;
/// From how many times the usual flux on a VPL stands for a larger disc. At 1 the glows around bright VPLs are fainter still, but
/// the upper gallery of Sponza loses another 0.6 % of its light.
const LARGE_VPL: f32 = 2.0;
/// Below this the scene is hardly hit, and the paths are what is limited.
const FEW_VPLS_PER_PATH: f64 = 1.0 / 16.0;
/// Room for other seeds than the one the capacities were measured with.
pub(super) const CAPACITY_MARGIN: f64 = 1.25;
/// The same for the largest lists of lights that fit the device: the paths of the pilot run tell to about 1 % how many VPLs
/// others leave.
const LEAST_MARGIN: f64 = 1.03;

/// Whether a view, or the finished picture, needs the lights S0.
pub(super) fn needs_lights(view: View) -> bool {
    view == View::Final || !is_of_every_frame(view)
}

/// Point lights of the scene that are among the lights S0.
pub(super) fn scene_lights(scene: &UploadedScene, settings: &Settings) -> u32 {
    match settings.many_lights.lights {
        LightSet::Vpl => 0,
        LightSet::Scene | LightSet::Both => scene.light_count - scene.first_point_light,
    }
}

/// Checks what does not depend on the scene.
pub(super) fn check_settings(settings: &Settings) -> Result<()> {
    let many_lights = &settings.many_lights;
    if many_lights.lights != LightSet::Scene && many_lights.bounces == 0 {
        return Err(Error::Usage(
            "--bounces 0 leaves no virtual point lights: give at least 1, or choose --lights scene".to_owned(),
        ));
    }
    Ok(())
}

/// Checks that the scene has the lights that are asked for.
pub(super) fn check_lights(job: &Job<'_>) -> Result<()> {
    if job.settings.many_lights.lights == LightSet::Scene && scene_lights(job.scene, job.settings) == 0 {
        return Err(Error::Usage(
            "--lights scene needs point lights, and the scene has none; use --lights vpl".to_owned(),
        ));
    }
    Ok(())
}

/// The shape before anything is measured: no paths.
pub(super) fn base_shape(job: &Job<'_>) -> LightShape {
    let settings = &job.settings.many_lights;
    LightShape {
        path_count: 0,
        starts: None,
        lacks_paths: false,
        bounces: settings.bounces,
        slots_at_once: SLOTS_AT_ONCE,
        vpl_capacity: 0,
        scene_light_count: scene_lights(job.scene, job.settings),
        shadow_samples: if settings.shadows.is_on() { settings.shadow_samples } else { 0 },
        vpl_radius: 0.0,
        vpl_flux_share: 0.0,
    }
}

/// Takes over what another shape of the same lights was measured to need.
pub(super) fn take_measures(shape: &mut LightShape, known: &LightShape) {
    shape.starts.clone_from(&known.starts);
    (shape.path_count, shape.lacks_paths) = (known.path_count, known.lacks_paths);
    shape.vpl_capacity = known.vpl_capacity;
    (shape.vpl_radius, shape.vpl_flux_share) = (known.vpl_radius, known.vpl_flux_share);
}

/// Whether two settings trace the same lights, where they trace any, and agree in what `also` tells.
pub(super) fn keeps_measures<T: PartialEq>(now: &Settings, before: &Settings, also: impl Fn(&Settings) -> T) -> bool {
    let needed = [now, before].map(|settings| needs_lights(settings.render.view));
    let same = now.many_lights.traced() == before.many_lights.traced() && also(now) == also(before);
    needed[0] == needed[1] && (same || !needed[0])
}

/// Writes the lights' part of the frame's constants.
pub(super) fn write_constants(shape: &LightShape, job: &Job<'_>, data: &mut FrameData) {
    data.shadow_samples = shape.shadow_samples;
    data.vpl_capacity = shape.vpl_capacity;
    data.path_count = shape.path_count;
    data.bounces = shape.bounces;
    data.direct_lights -= shape.scene_light_count;
    data.scene_lights = shape.scene_light_count;
    data.clamp_squared = (job.settings.many_lights.clamp * shape.vpl_radius).powi(2);
    let usual = shape.vpl_flux_share * job.emitted_luminance() as f32;
    data.large_vpl_luminance = if usual > 0.0 { LARGE_VPL * usual } else { f32::MAX };
}

/// Adds the passes that trace the light paths and pack what they leave, part by part.
pub(super) fn add_lights(frame: &mut Frame, shape: &LightShape) -> Lights {
    let parts = shape.path_parts();
    let slots = vpl_trace::declare(frame, shape, &parts);
    let start_cells = vpl_trace::declare_starts(frame, shape);
    let packing = compaction::begin_lights(frame, shape, &slots);
    for part in &parts {
        vpl_trace::add(frame, part, &slots, start_cells);
        compaction::pack_part(frame, shape, &slots, &packing, part);
    }
    packing.lights
}

/// Adds the passes of the view `vpls`: the lights as points.
pub(super) fn add_points(frame: &mut Frame, shape: &LightShape, gbuffer: &GBuffer) -> AddedView {
    let lights = add_lights(frame, shape);
    let direct = direct_light::add(frame, gbuffer, AreaLight::Here, AreaLight::Here);
    let values = debug_view::draw_points(frame, shape, gbuffer, &lights);
    let picture = debug_view::overlay_points(frame, gbuffer, values, direct.radiance);
    AddedView { values, picture, outputs: TechniqueOutputs::new(vec![lights.counts], lights) }
}

/// Finds the number of paths, the capacity, and how far apart VPLs will be, by tracing some paths.
pub(super) fn measure_paths(job: &Job<'_>, shape: &mut LightShape) -> Result<()> {
    let settings = &job.settings.many_lights;
    if settings.lights == LightSet::Scene {
        return Ok(());
    }
    let (vpls, bounces) = (f64::from(settings.vpls), f64::from(settings.bounces));
    shape.starts = starts::learn_starts(job)?.map(Arc::new);
    shape.path_count = PILOT_PATHS.min(settings.vpls);
    shape.vpl_capacity = shape.slot_count();
    let lights = trace(job, shape)?;
    let pilot = &lights.positions[..lights.vpl_luminances.len()];
    let vpls_per_path = f64::from(pilot.len().max(1) as u32) / f64::from(shape.path_count);
    let paths = (vpls / vpls_per_path).ceil();
    // Where few paths hit anything, as many must do as have slots in one buffer.
    let limit = job.gpu.report().limits.storage_range_bytes as f64;
    let most_paths = if vpls_per_path >= FEW_VPLS_PER_PATH {
        // Slots are numbered by words, and have a bit each. A light has 16 bytes.
        let slots = bounces * paths;
        let bytes = (slots / 8.0).max(slots / f64::from(u32::MAX) * limit);
        check_fit(job, bytes.max(16.0 * (vpls * LEAST_MARGIN + 1024.0)))?;
        f64::INFINITY
    } else {
        // A slot has 16 bytes.
        (limit / 16.0 / bounces).min(vpls * 64.0)
    };
    let pilot_paths = f64::from(shape.path_count);
    shape.lacks_paths = pilot.is_empty() || paths > most_paths;
    shape.path_count = if pilot.is_empty() { 1 } else { paths.min(most_paths) as u32 };
    let most_vpls = (limit / 16.0) as u32 - shape.scene_light_count.min((limit / 32.0) as u32);
    shape.vpl_capacity = shape.slot_count().min((vpls * CAPACITY_MARGIN) as u32 + 1024).min(most_vpls);
    // As many more lights share a surface as there are more paths.
    let fewer = (pilot_paths / f64::from(shape.path_count)) as f32;
    shape.vpl_radius = disc_radius(pilot) * fewer.sqrt();
    let emitted = job.emitted_luminance() as f32;
    shape.vpl_flux_share = if emitted > 0.0 { median(lights.vpl_luminances) * fewer / emitted } else { 0.0 };
    Ok(())
}

/// Fails where the largest buffer, which grows with the number of VPLs, does not fit the device.
pub(super) fn check_fit(job: &Job<'_>, largest_bytes: f64) -> Result<()> {
    let limit = job.gpu.report().limits.storage_range_bytes as f64;
    if largest_bytes <= limit {
        return Ok(());
    }
    let vpls = job.settings.many_lights.vpls;
    Err(Error::Usage(format!(
        "--vpls {vpls} does not fit this device, whose storage buffers end at {} MiB; about {:.0} would fit",
        limit as u64 >> 20,
        (f64::from(vpls) * limit / largest_bytes / 1000.0 * 0.97).floor() * 1000.0
    )))
}

/// What is known on the host of traced lights.
pub(super) struct TracedLights {
    /// Of the lights S0, the VPLs first.
    pub positions: Vec<[f32; 3]>,
    /// Luminances of the fluxes of the VPLs.
    pub vpl_luminances: Vec<f32>,
}

/// The lights S0 for a shape.
pub(super) fn trace(job: &Job<'_>, shape: &LightShape) -> Result<TracedLights> {
    let mut frame = Frame::new(FrameShape::new(job));
    let lights = add_lights(&mut frame, shape);
    let mut executor = Executor::new(job.gpu, frame.graph, Some(Arc::clone(&job.scene.set)))?;
    let mut data = job.frame_data();
    write_constants(shape, job, &mut data);
    let ticket = executor.submit(bytemuck::bytes_of(&data))?;
    executor.wait(ticket)?;
    let counts: Vec<u32> = bytemuck::pod_collect_to_vec(&executor.read_buffer(lights.counts)?);
    let positions: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&executor.read_buffer(lights.positions)?);
    let fluxes: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&executor.read_buffer(lights.fluxes)?);
    Ok(TracedLights {
        positions: positions.iter().take(counts[0] as usize).map(|p| [p[0], p[1], p[2]]).collect(),
        vpl_luminances: fluxes.iter().take(counts[1] as usize).map(|f| luminance(Vec3::from_slice(f))).collect(),
    })
}

/// What is counted of the lights S0; their counts are the first buffer.
pub(super) fn counts(shape: &LightShape, words: &[Vec<u32>]) -> Vec<Count> {
    let Some([_, vpls, ..]) = words.first().map(Vec::as_slice) else { return Vec::new() };
    vec![Count::new("vpls", "virtual point lights", *vpls), Count::new("paths", "light paths", shape.path_count)]
}

/// A sentence about what of the lights is missing: VPLs that too few paths left, VPLs and lights of grids that had no room.
/// `grid_lights` are those without and with room.
pub(super) fn complaint(shape: &LightShape, words: &[Vec<u32>], grid_lights: [u32; 2]) -> Option<String> {
    let [_, kept_vpls, lost_vpls, ..] = words.first()?[..] else { return None };
    let few_paths = shape.lacks_paths.then(|| {
        let vpls = u64::from(kept_vpls) + u64::from(lost_vpls);
        format!(
            "hardly any light path hits the scene: {} were traced and left {vpls} virtual point lights, fewer than --vpls \
             asks for",
            shape.path_count
        )
    });
    let parts: Vec<String> = few_paths.into_iter().chain(no_room([lost_vpls, kept_vpls], grid_lights)).collect();
    (!parts.is_empty()).then(|| parts.join("; "))
}

/// Where VPLs or lights of grids, each without and with room, had none.
fn no_room(vpls: [u32; 2], grid_lights: [u32; 2]) -> Option<String> {
    let part = |[lost, kept]: [u32; 2], what: &str| {
        (lost > 0).then(|| format!("{lost} of {} {what}", u64::from(lost) + u64::from(kept)))
    };
    let parts = [part(vpls, "virtual point lights"), part(grid_lights, "grid lights")];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    (!parts.is_empty()).then(|| {
        format!(
            "{} had no room and were left out: the picture lacks their light; room is made before the first frame, for \
             --vpls and --levels and the lights as they then are, with a quarter to spare",
            parts.join(" and ")
        )
    })
}

/// Resources of the passes that make the lights S0.
pub(super) const DUMP: &[Entry] = &[
    buffer(
        "start_cells",
        COUNT,
        start_cells,
        "Density of the starts of light paths: cells in the cube of the light's position in order and the light's two random numbers, each with its share of the paths.",
    ),
    buffer(
        "vpl_slot_positions",
        METRES_AND_BITS,
        slot_positions,
        "Positions and normals of the VPLs in the slots that the paths wrote: bounce b of path p is slot p * bounces + b. Beyond 8,388,608 slots, a part of the paths at a time, counted from its first.",
    ),
    buffer("vpl_slot_fluxes", "flux", slot_fluxes, "Fluxes of the VPLs in the same slots."),
    noted(buffer("vpl_slot_bits", "bits", all_words, "One bit for each slot, 1 where it holds a VPL.")),
    buffer("vpl_slot_ranks", COUNT, ranks, "For each word of the slot bits the number of VPLs before it."),
    buffer(
        "light_positions",
        METRES_AND_BITS,
        light_positions,
        "Positions and normals of the lights S0: the VPLs in slot order, then the scene's lights.",
    ),
    buffer(
        "light_fluxes",
        "flux",
        light_fluxes,
        "Fluxes of the lights S0; is_vpl is 1 for VPLs and 0 for lights that emit in all directions.",
    ),
    noted(buffer("light_counts", COUNT, light_counts, "Lights in S0, VPLs among them, and VPLs that did not fit.")),
];

/// Packed position and octahedral normal.
fn position_fields() -> Vec<Field> {
    vec![f("position_ws", &[3]), Field::new("normal_octahedral", Scalar::I16, &[2])]
}

fn flux_fields() -> Vec<Field> {
    vec![f("flux", &[3]), f("is_vpl", &[])]
}

/// Records of 16 bytes in path slots, those without a VPL zeroed; where parts of the paths share them, as they are.
fn slots(fields: Vec<Field>, bytes: &[u8], known: &DumpContext<'_>) -> Array {
    let count = bytes.len() / 16;
    let mut array = Array::records(fields, &[count as u64], bytes);
    let bits = known.words("vpl_slot_bits");
    let are_shared = bits.len() > count.div_ceil(32);
    for slot in (0..count).filter(|_| !are_shared) {
        if bits.get(slot / 32).is_none_or(|word| word >> (slot % 32) & 1 == 0) {
            array.bytes[16 * slot..16 * (slot + 1)].fill(0);
        }
    }
    array
}

fn slot_positions(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    slots(position_fields(), bytes, known)
}

fn slot_fluxes(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    slots(flux_fields(), bytes, known)
}

fn start_cells(bytes: &[u8], _: &DumpContext<'_>) -> Array {
    let fields = vec![f("low", &[3]), f("first", &[]), f("size", &[3]), f("share", &[])];
    Array::records(fields, &[(bytes.len() / size_of::<StartCell>()) as u64], bytes)
}

/// Lights in S0.
pub(super) fn light_count(known: &DumpContext<'_>) -> u32 {
    known.words("light_counts").first().copied().unwrap_or(0)
}

pub(super) fn light_positions(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    Array::records(position_fields(), &[light_count(known).into()], bytes)
}

pub(super) fn light_fluxes(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    Array::records(flux_fields(), &[light_count(known).into()], bytes)
}

fn light_counts(bytes: &[u8], _: &DumpContext<'_>) -> Array {
    Array::records(vec![u("lights", &[]), u("vpls", &[]), u("vpls_lost", &[])], &[1], bytes)
}
