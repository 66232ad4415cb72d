//! The frame in order: its table of contents.

pub mod readback;
mod views;

use crate::gpu::Work;
use crate::graph::{BufferHandle, Graph, ImageHandle};
use crate::passes::compaction::{GridLights, Lights};
use crate::passes::compose::Indirect;
use crate::passes::descent::Descent;
use crate::passes::gbuffer::GBuffer;
use crate::passes::interleave::Composite;
use crate::passes::light_volumes::Lighting;
use crate::passes::merge::MergedLights;
use crate::passes::shadow_rays::{Samples, ShadowEstimates};
use crate::passes::tone_map::ToneMapped;
use crate::passes::{
    Frame, FrameShape, accumulate, atrous, bounds, brute_force, compaction, compose, descent, direct_light, gbuffer,
    grid_gather, grid_scatter, inspect, interleave, light_buckets, light_gather, light_volumes, merge, path_trace,
    shadow_rays, tone_map, vpl_trace,
};
use crate::settings::{Build, Filter, LightingMode, Scatter, ShadowPoints, Technique};

pub use views::needs_lights;

/// What can be read after a frame.
#[derive(Clone, Copy, Debug)]
pub struct FrameOutputs {
    /// Linear radiance.
    pub radiance: ImageHandle,
    /// Tone-mapped picture and its exposure.
    pub tone_mapped: ToneMapped,
    /// Rays traced.
    pub ray_count: BufferHandle,
    /// The hierarchy, when the technique has one.
    pub hierarchy: Option<HierarchyOutputs>,
    /// An [`InspectedPixel`](crate::shared::InspectedPixel), when the shape asks for it.
    pub inspected: Option<BufferHandle>,
}

/// Buffers of the hierarchy that outlive the frame.
#[derive(Clone, Copy, Debug)]
pub struct HierarchyOutputs {
    /// S0.
    pub lights: Lights,
    /// Grid placement.
    pub placement: BufferHandle,
    /// Levels 1..=Lmax.
    pub grid: GridLights,
    /// The merged list.
    pub merged: MergedLights,
    /// The way from coarse lights to the lights they are made of, when shadow rays take it.
    pub descent: Option<Descent>,
    /// Fragments per pixel of the light volumes; without them the ray counts.
    pub overdraw: BufferHandle,
}

/// The whole frame of a technique, or the part of it that the shape's view shows.
#[must_use]
pub fn build(technique: Technique, shape: FrameShape) -> (Graph<Work>, FrameOutputs) {
    views::build(&shape).unwrap_or_else(|| build_picture(technique, shape))
}

fn build_picture(technique: Technique, shape: FrameShape) -> (Graph<Work>, FrameOutputs) {
    let mut frame = Frame::new(shape);
    let gbuffer = gbuffer::add(&mut frame);
    let mut lights = None;
    let (indirect, hierarchy) = match technique {
        Technique::Direct => (None, None),
        Technique::Lgh => {
            let (indirect, hierarchy, lit) = lighting_grid_hierarchy(&mut frame, &gbuffer);
            lights = Some(samples(&hierarchy, &lit));
            (Some(indirect), Some(hierarchy))
        }
        Technique::BruteForce => {
            let originals = trace_lights(&mut frame);
            let lighting = brute_force::add(&mut frame, &gbuffer, &originals);
            (Some(Indirect { lighting, shadows: None, has_share: true }), None)
        }
        Technique::PathTrace => {
            let lighting = path_trace::add(&mut frame, &gbuffer);
            (Some(Indirect { lighting, shadows: None, has_share: true }), None)
        }
    };
    let direct = frame.shape.direct.then(|| direct_light::add(&mut frame, &gbuffer));
    let mut radiance = compose::add(&mut frame, &gbuffer, direct, indirect);
    let seen = inspect::Seen { radiance, direct, indirect, lights };
    let inspected = frame.shape.inspect.then(|| inspect::add(&mut frame, &gbuffer, &seen));
    if frame.shape.accumulate {
        radiance = accumulate::add(&mut frame, radiance);
    }
    let tone_mapped = tone_map::add(&mut frame, radiance);
    let outputs = FrameOutputs { radiance, tone_mapped, ray_count: frame.ray_count, hierarchy, inspected };
    (frame.graph, outputs)
}

/// Only the lights S0: what the levels and capacities are chosen from before the first frame.
#[must_use]
pub fn build_lights(shape: FrameShape) -> (Graph<Work>, Lights) {
    let mut frame = Frame::new(shape);
    let lights = trace_lights(&mut frame);
    (frame.graph, lights)
}

fn trace_lights(frame: &mut Frame) -> Lights {
    let slots = vpl_trace::add(frame);
    compaction::pack_lights(frame, &slots)
}

/// The hierarchy alone, over lights that the caller writes to the S0 buffers: how the stages are tested.
#[must_use]
pub fn build_hierarchy(shape: FrameShape) -> (Graph<Work>, HierarchyOutputs) {
    let mut frame = Frame::new(shape);
    let lights = compaction::declare_lights(&mut frame);
    let placement = bounds::add(&mut frame, &lights);
    let grid = construct(&mut frame, &lights, placement);
    let merged = merge::add(&mut frame, &lights, placement, &grid);
    let descent = add_descent(&mut frame, &lights, placement, &grid);
    let overdraw = frame.ray_count;
    (frame.graph, HierarchyOutputs { lights, placement, grid, merged, descent, overdraw })
}

fn lighting_grid_hierarchy(frame: &mut Frame, gbuffer: &GBuffer) -> (Indirect, HierarchyOutputs, Lit) {
    let mut hierarchy = add_hierarchy(frame);
    let lit = add_lighting(frame, gbuffer, &mut hierarchy);
    let shadows = lit.lighting.reservoirs.map(|_| {
        let estimates = trace_shadows(frame, gbuffer, &mut hierarchy, &lit);
        filter_shadows(frame, gbuffer, &lit, estimates)
    });
    (Indirect { lighting: lit.composite.lighting, shadows, has_share: false }, hierarchy, lit)
}

/// Traces the light paths and builds the hierarchy over their lights.
fn add_hierarchy(frame: &mut Frame) -> HierarchyOutputs {
    let lights = trace_lights(frame);
    let placement = bounds::add(frame, &lights);
    let grid = construct(frame, &lights, placement);
    let merged = merge::add(frame, &lights, placement, &grid);
    HierarchyOutputs { lights, placement, grid, merged, descent: None, overdraw: frame.ray_count }
}

/// The unshadowed lighting, as the light volumes leave it and put together.
struct Lit {
    lighting: Lighting,
    composite: Composite,
}

fn add_lighting(frame: &mut Frame, gbuffer: &GBuffer, hierarchy: &mut HierarchyOutputs) -> Lit {
    let lighting = match frame.shape.lighting {
        LightingMode::Volumes => {
            let depth = interleave::split_depth(frame, gbuffer);
            light_volumes::add(frame, gbuffer, depth, hierarchy.placement, &hierarchy.merged)
        }
        LightingMode::Gather => {
            let inputs = light_gather::Inputs {
                lights: hierarchy.lights,
                placement: hierarchy.placement,
                grid: hierarchy.grid,
                merged: hierarchy.merged,
            };
            light_gather::add(frame, gbuffer, &inputs)
        }
    };
    hierarchy.overdraw = lighting.overdraw;
    let composite = interleave::composite(frame, gbuffer, lighting.image);
    Lit { lighting, composite }
}

/// One ray for each light that a reservoir holds.
fn trace_shadows(frame: &mut Frame, gbuffer: &GBuffer, hierarchy: &mut HierarchyOutputs, lit: &Lit) -> ShadowEstimates {
    let HierarchyOutputs { lights, placement, grid, .. } = *hierarchy;
    hierarchy.descent = add_descent(frame, &lights, placement, &grid);
    shadow_rays::add(frame, gbuffer, &samples(hierarchy, lit))
}

/// The lights and what was picked of them.
fn samples(hierarchy: &HierarchyOutputs, lit: &Lit) -> Samples {
    let HierarchyOutputs { lights, placement, grid, merged, descent, .. } = *hierarchy;
    let Lighting { image, reservoirs, .. } = lit.lighting;
    Samples { merged, lighting: image, reservoirs, lights, placement, grid, descent }
}

/// Takes the interleaving pattern and the noise out of the estimates.
fn filter_shadows(frame: &mut Frame, gbuffer: &GBuffer, lit: &Lit, estimates: ShadowEstimates) -> ShadowEstimates {
    let estimates = interleave::smooth_estimates(frame, gbuffer, &lit.composite, lit.lighting.image, estimates);
    match frame.shape.filter {
        Filter::Atrous => atrous::add(frame, gbuffer, lit.composite.lighting, estimates),
        Filter::None => estimates,
    }
}

/// Adds the descent passes when shadow rays need them.
fn add_descent(frame: &mut Frame, lights: &Lights, placement: BufferHandle, grid: &GridLights) -> Option<Descent> {
    match frame.shape.shadow_points {
        ShadowPoints::Descent => Some(descent::add(frame, lights, placement, grid)),
        ShadowPoints::Deviation => None,
    }
}

/// The grids: S1 from the lights, the rest by gather, or everything by scatter.
pub(crate) fn construct(frame: &mut Frame, lights: &Lights, placement: BufferHandle) -> GridLights {
    let top = frame.shape.levels.top;
    let mut grid = compaction::begin_grid(frame);
    match frame.shape.build {
        Build::Cascade | Build::Gather => {
            compaction::mark_lights(frame, lights, placement, &grid, 1, 1);
            compaction::compact_levels(frame, "S1", &grid, 1, 1);
            match frame.shape.scatter {
                Scatter::Sorted => {
                    let buckets = light_buckets::add(frame, lights, placement);
                    grid_scatter::add_sorted(frame, lights, placement, &grid, &buckets);
                    grid.buckets = Some(buckets);
                }
                Scatter::Atomic => grid_scatter::add(frame, lights, placement, &grid, 1),
            }
            compaction::mark_grid_lights(frame, &grid);
            compaction::compact_levels(frame, "upper", &grid, 2, top);
            grid_gather::add(frame, placement, &grid);
        }
        Build::Scatter => {
            compaction::mark_lights(frame, lights, placement, &grid, 1, top);
            compaction::compact_levels(frame, "all", &grid, 1, top);
            grid_scatter::add(frame, lights, placement, &grid, top);
        }
    }
    grid
}
