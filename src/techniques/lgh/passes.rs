//! The passes of the hierarchy in order.

use super::super::{Added, InspectPass, TechniqueOutputs, many_lights};
use crate::gpu::Work;
use crate::graph::{BufferHandle, Graph};
use crate::passes::atrous::Filtered;
use crate::passes::compaction::{GridLights, LightSlots, Lights};
use crate::passes::compose::Indirect;
use crate::passes::descent::Descent;
use crate::passes::first_level::Inputs;
use crate::passes::gbuffer::GBuffer;
use crate::passes::interleave::Composite;
use crate::passes::lgh_shape::LghShape;
use crate::passes::light_volumes::Lighting;
use crate::passes::merge::MergedLights;
use crate::passes::shadow_rays::{Samples, ShadowEstimates};
use crate::passes::temporal::{Blended, Light, Reuse};
use crate::passes::{
    Frame, FrameShape, atrous, bounds, compaction, descent, first_level, grid_gather, grid_update, half_picture,
    inspect, interleave, light_buckets, light_gather, light_volumes, merge, rounds, shadow_rays, temporal,
};
use crate::settings::{
    FirstLevelBuild, GridUpdate, IndirectSize, LevelBuild, LightingMode, ShadowFilter, ShadowPoints,
};

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
    /// Lights that each pixel tests, where pixels are lit.
    pub lights_tested: Option<BufferHandle>,
}

impl HierarchyOutputs {
    /// What the host can read of them.
    pub(in crate::techniques) fn outputs(&self, shape: &LghShape) -> TechniqueOutputs {
        let mut counters = vec![self.lights.counts, self.grid.level_table];
        counters.extend(self.grid.update_counts);
        counters.extend(self.lights_tested.filter(|_| shape.count_lights_tested));
        TechniqueOutputs::new(counters, *self)
    }
}

/// All passes of a finished picture.
pub(super) fn add(frame: &mut Frame, shape: &LghShape, gbuffer: &GBuffer) -> Added {
    let mut hierarchy = add_hierarchy(frame, shape, shape.lights.shadow_samples > 0);
    if shape.indirect_size == IndirectSize::Half {
        // Only what frames take over there needs the motion there.
        let motion = gbuffer.motion.filter(|_| shape.reuse.is_some());
        let (whole, half) = half_picture::shrink(frame, &GBuffer { motion, ..*gbuffer });
        let (indirect, _) = add_indirect(frame, shape, &half, &mut hierarchy);
        let lighting = half_picture::enlarge(frame, whole, gbuffer, &half, &indirect);
        let indirect = Indirect { lighting, shadows: None, has_share: false };
        return Added { indirect: Some(indirect), outputs: hierarchy.outputs(shape), inspect: None };
    }
    let (indirect, samples) = add_indirect(frame, shape, gbuffer, &mut hierarchy);
    let shape_seen = shape.clone();
    let inspect: InspectPass =
        Box::new(move |frame, gbuffer, seen| inspect::add_with_lights(frame, &shape_seen, gbuffer, seen, &samples));
    Added { indirect: Some(indirect), outputs: hierarchy.outputs(shape), inspect: Some(inspect) }
}

/// The lighting with its shadows, and the samples that these are of.
fn add_indirect(
    frame: &mut Frame,
    shape: &LghShape,
    gbuffer: &GBuffer,
    hierarchy: &mut HierarchyOutputs,
) -> (Indirect, Samples) {
    let lit = add_lighting(frame, shape, gbuffer, hierarchy);
    let filtered = lit.lighting.reservoirs.map(|_| {
        let estimates = trace_shadows(frame, shape, gbuffer, hierarchy, &lit);
        filter_shadows(frame, shape, gbuffer, hierarchy, &lit, estimates, Filtered::ForPicture)
    });
    let lighting = filtered.map_or(lit.composite.lighting, |light| light.lighting);
    let shadows = filtered.map(|light| light.estimates);
    (Indirect { lighting, shadows, has_share: false }, samples(hierarchy, &lit))
}

/// The hierarchy alone, over lights that the caller writes to the S0 buffers: how the stages are tested.
#[must_use]
pub fn build_hierarchy(frame: FrameShape, shape: &LghShape) -> (Graph<Work>, HierarchyOutputs) {
    let mut frame = Frame::without_scene(frame);
    let mut lights = compaction::declare_lights(&mut frame, &shape.lights);
    if shape.grid_update != GridUpdate::Full {
        lights.slots = Some(LightSlots::given(&mut frame, shape.lights.light_capacity()));
    }
    let hierarchy = add_grids(&mut frame, shape, lights, true);
    (frame.graph, hierarchy)
}

/// Traces the light paths and builds the hierarchy over their lights, with what shadow rays need of it if they are traced.
pub(in crate::techniques) fn add_hierarchy(frame: &mut Frame, shape: &LghShape, for_shadows: bool) -> HierarchyOutputs {
    frame.kept(|frame| {
        let lights = many_lights::add_lights(frame, &shape.lights);
        add_grids(frame, shape, lights, for_shadows)
    })
}

fn add_grids(frame: &mut Frame, shape: &LghShape, lights: Lights, for_shadows: bool) -> HierarchyOutputs {
    let placement = bounds::add(frame, &lights, &shape.lights, shape.anchor);
    let grid = construct(frame, shape, &lights, placement);
    let descend = for_shadows && shape.shadow_points == ShadowPoints::Descent;
    let descent = descend.then(|| descent::add(frame, shape, &lights, placement, &grid));
    let merged = merge::add(frame, shape, &lights, placement, &grid);
    HierarchyOutputs { lights, placement, grid, merged, descent, lights_tested: None }
}

/// The unshadowed lighting, as it was summed and put together.
pub(super) struct Lit {
    pub(super) lighting: Lighting,
    pub(super) composite: Composite,
}

pub(super) fn add_lighting(
    frame: &mut Frame,
    shape: &LghShape,
    gbuffer: &GBuffer,
    hierarchy: &mut HierarchyOutputs,
) -> Lit {
    let lighting = match shape.lighting {
        LightingMode::Volumes => {
            let depth = interleave::split_depth(frame, shape, gbuffer);
            light_volumes::add(frame, shape, gbuffer, depth, hierarchy.placement, &hierarchy.merged)
        }
        LightingMode::Gather => {
            let mut inputs = gather_inputs(hierarchy);
            let lighting = light_gather::add(frame, shape, gbuffer, &mut inputs);
            hierarchy.grid = inputs.grid;
            lighting
        }
    };
    hierarchy.lights_tested = Some(lighting.lights_tested);
    let composite = interleave::composite(frame, shape, gbuffer, lighting.image);
    Lit { lighting, composite }
}

fn gather_inputs(hierarchy: &HierarchyOutputs) -> light_gather::Inputs {
    let HierarchyOutputs { lights, placement, grid, merged, .. } = *hierarchy;
    light_gather::Inputs { lights, placement, grid, merged }
}

/// One ray for each light that a reservoir holds.
pub(super) fn trace_shadows(
    frame: &mut Frame,
    shape: &LghShape,
    gbuffer: &GBuffer,
    hierarchy: &HierarchyOutputs,
    lit: &Lit,
) -> ShadowEstimates {
    shadow_rays::add(frame, shape, gbuffer, &samples(hierarchy, lit))
}

/// The lights and what was picked of them.
fn samples(hierarchy: &HierarchyOutputs, lit: &Lit) -> Samples {
    let HierarchyOutputs { lights, placement, grid, merged, descent, .. } = *hierarchy;
    let Lighting { image, reservoirs, .. } = lit.lighting;
    Samples { merged, lighting: image, reservoirs, lights, placement, grid, descent }
}

/// Takes the interleaving pattern and the noise out of the estimates, by way of the frames before where there is motion to
/// find them with.
pub(super) fn filter_shadows(
    frame: &mut Frame,
    shape: &LghShape,
    gbuffer: &GBuffer,
    hierarchy: &HierarchyOutputs,
    lit: &Lit,
    estimates: ShadowEstimates,
    filtered: Filtered,
) -> Light {
    let estimates = interleave::smooth_estimates(frame, gbuffer, &lit.composite, estimates);
    let mut light = Light { estimates, lighting: lit.composite.lighting };
    if let Some((motion, reuse)) = gbuffer.motion.zip(shape.reuse) {
        let blended = temporal::add(frame, gbuffer, motion, reuse, light);
        add_rounds(frame, shape, gbuffer, hierarchy, &samples(hierarchy, lit), (reuse, estimates, &blended));
        light = blended.light;
    }
    if shape.filter == ShadowFilter::Atrous {
        light.estimates = atrous::add(frame, gbuffer, shape.interleave, light.estimates, filtered);
    }
    light
}

/// Further rounds of samples where histories are short.
fn add_rounds(
    frame: &mut Frame,
    shape: &LghShape,
    gbuffer: &GBuffer,
    hierarchy: &HierarchyOutputs,
    samples: &Samples,
    (reuse, estimates, blended): (Reuse, ShadowEstimates, &Blended),
) {
    if reuse.last_round() == 1 {
        return;
    }
    let of_first = samples.reservoirs.filter(|_| !frame.shape.inspect);
    let reservoirs = of_first.unwrap_or_else(|| light_gather::add_round_reservoirs(frame, shape));
    let samples = Samples { reservoirs: Some(reservoirs), ..*samples };
    let descent = samples.descent.map(|descent| (descent, descent::declare_round_representatives(frame, shape)));
    for round in rounds::all(reuse, blended) {
        if let Some((descent, representatives)) = &descent {
            descent::add_round(frame, shape, &samples, descent, *representatives, round);
        }
        light_gather::add_round(frame, shape, gbuffer, &gather_inputs(hierarchy), reservoirs, round);
        let representatives = descent.map(|(_, representatives)| representatives);
        shadow_rays::add_round(frame, shape, gbuffer, (&samples, representatives), estimates, round);
        temporal::add_round(frame, gbuffer, reuse, estimates, blended, round);
    }
}

/// The grids: S1 from the lights, the rest by gather, or everything by scatter.
pub fn construct(frame: &mut Frame, shape: &LghShape, lights: &Lights, placement: BufferHandle) -> GridLights {
    let top = shape.levels.top;
    let mut grid = compaction::begin_grid(frame, shape);
    if shape.build == LevelBuild::Scatter {
        compaction::mark_lights(frame, shape, lights, placement, &grid, 1, top);
        compaction::compact_levels(frame, shape, "all", &grid, 1, top);
        first_level::add(frame, Inputs { shape, lights, placement, grid: &grid }, top);
        return grid;
    }
    let compact_s1 = |frame: &mut Frame| {
        compaction::mark_lights(frame, shape, lights, placement, &grid, 1, 1);
        compaction::compact_levels(frame, shape, "S1", &grid, 1, 1);
    };
    let compact_upper = |frame: &mut Frame| {
        compaction::mark_grid_lights(frame, &grid);
        compaction::compact_levels(frame, shape, "upper", &grid, 2, top);
    };
    let inputs = Inputs { shape, lights, placement, grid: &grid };
    let compact = |frame: &mut Frame| {
        compact_s1(frame);
        compact_upper(frame);
    };
    match (shape.scatter, shape.grid_update) {
        (FirstLevelBuild::Atomic, _) => {
            compact(frame);
            first_level::add(frame, inputs, 1);
        }
        (FirstLevelBuild::Sorted, GridUpdate::Full) => {
            let list = |frame: &mut Frame| light_buckets::add(frame, shape, lights, placement);
            let ((), buckets) = frame.side_by_side(compact, list);
            first_level::add_sorted(frame, inputs, &buckets);
            grid.buckets = Some(buckets);
        }
        (FirstLevelBuild::Sorted, GridUpdate::Auto | GridUpdate::Check) => {
            let find = |frame: &mut Frame| grid_update::find_changes(frame, shape, lights);
            let ((), changes) = frame.side_by_side(compact_s1, find);
            let build = grid_update::choose_build(frame, inputs, changes);
            let list = |frame: &mut Frame| light_buckets::add_where(frame, shape, lights, placement, build.lists());
            let ((), buckets) = frame.side_by_side(compact_upper, list);
            grid_update::build(frame, inputs, &buckets, &build);
            (grid.buckets, grid.update_counts) = (Some(buckets), Some(build.counts));
        }
    }
    grid_gather::add(frame, shape, placement, &grid);
    grid
}
