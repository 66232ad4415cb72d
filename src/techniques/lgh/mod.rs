//! The lighting grid hierarchy.

mod counts;
mod dump;
mod grid_update;
mod inspector;
mod measure;
mod passes;
mod views;

use serde_json::{Map, Value, json};

use super::rules::{is_of_every_frame, require};
use super::{Added, AddedView, Count, InspectorTable, Technique, TechniqueShape, many_lights};
use crate::Result;
use crate::dump::{Derived, DumpContext, Entry};
use crate::job::Job;
use crate::passes::Frame;
use crate::passes::gbuffer::GBuffer;
use crate::passes::lgh_shape::LghShape;
use crate::passes::temporal::{Estimated, Reuse};
use crate::settings::{
    GridUpdate, IndirectSize, LghSettings, LightingMode, Reservoir, Settings, ShadowEstimate, ShadowFilter,
    ShadowPoints, Temporal, View, name,
};
use crate::shared::{FrameData, InspectedPixel};
use crate::uploaded_scene::UploadedScene;

pub(super) use dump::ENTRIES as DUMP;
pub(super) use grid_update::DUMP as UPDATE_DUMP;
pub use measure::reservoir_mode;
pub(super) use passes::add_hierarchy;
pub use passes::{HierarchyOutputs, build_hierarchy, construct};

/// The technique.
pub struct Lgh;

impl Technique for Lgh {
    fn name(&self) -> &'static str {
        "lgh"
    }

    fn has_view(&self, view: View) -> bool {
        match view {
            View::Vpls
            | View::Indirect
            | View::ShadowRatio
            | View::ShadowRatioFiltered
            | View::SelectedLevel
            | View::LightsTested
            | View::LightCount
            | View::LevelWeights => true,
            // Of every frame, or of another technique.
            _ => false,
        }
    }

    fn check(&self, settings: &Settings) -> Result<()> {
        many_lights::check_settings(settings)?;
        let view = settings.render.view;
        if needs_shadows(view) {
            settings.require_shadow_samples(&format!("--view {}", name(&view)))?;
        }
        if let Some(temporal) = settings.lgh.temporal.filter(|temporal| *temporal != Temporal::Off) {
            check_temporal(settings, &name(&temporal))?;
        }
        if settings.lgh.temporal_rounds_or_default() > 1 {
            check_rounds(&settings.lgh)?;
        }
        if settings.lgh.indirect_size == IndirectSize::Half {
            check_half(settings)?;
        }
        let (estimate, points) = (settings.lgh.shadow_estimate_or_default(), settings.lgh.shadow_points);
        require(estimate == ShadowEstimate::Ratio || points == ShadowPoints::Descent, || {
            let estimate = name(&estimate);
            format!("--shadow-estimate {estimate} needs rays that end on lights: choose --shadow-points descent")
        })?;
        require(view != View::ShadowRatioFiltered || settings.lgh.filter != ShadowFilter::None, || {
            let view = name(&view);
            format!(
                "--view {view} needs a filter, and --filter none is none: choose --view shadow-ratio, or --filter atrous"
            )
        })
    }

    fn check_unused(&self, settings: &Settings, chosen: &str) -> Result<()> {
        require(settings.lgh.reservoir.is_none(), || {
            format!("--technique {chosen} has no reservoirs: leave --reservoir out, or choose --technique lgh")
        })?;
        require(settings.lgh.lighting.is_none(), || {
            format!(
                "--technique {chosen} has no lights of a hierarchy: leave --lighting out, or choose --technique lgh"
            )
        })
    }

    fn own_lights(&self, scene: &UploadedScene, settings: &Settings) -> u32 {
        many_lights::scene_lights(scene, settings)
    }

    fn shape(&self, job: &Job<'_>, known: Option<&dyn TechniqueShape>) -> Result<Box<dyn TechniqueShape>> {
        Ok(Box::new(measured_shape(job, known.and_then(|known| known.as_any().downcast_ref()))?))
    }

    fn reuse(&self, job: &Job<'_>) -> Option<Reuse> {
        let shows = matches!(job.settings.render.view, View::Final | View::Direct | View::ShadowRatioFiltered);
        reuse(job).filter(|_| shows)
    }

    fn keeps_measures(&self, now: &Settings, before: &Settings) -> bool {
        // Fresh paths have a grid that stands still.
        many_lights::keeps_measures(now, before, |settings| (settings.lgh.measured(), settings.many_lights.vpl_seeds))
    }

    fn dump_entries(&self) -> &'static [&'static [Entry]] {
        &[many_lights::DUMP, dump::ENTRIES, grid_update::DUMP]
    }
}

/// The hierarchy's shape for a job; `known` was measured before for settings of which `Lgh::keeps_measures` holds.
pub(super) fn measured_shape(job: &Job<'_>, known: Option<&LghShape>) -> Result<LghShape> {
    many_lights::check_lights(job)?;
    let mut shape = measure::base_shape(job)?;
    let needs_lights = many_lights::needs_lights(job.settings.render.view);
    if let Some(known) = known {
        measure::take_measures(&mut shape, known);
    } else if needs_lights {
        measure::measure(job, &mut shape)?;
    }
    grid_update::check(&shape)?;
    if needs_lights {
        measure::check_shadow_levels(job, &shape)?;
    }
    Ok(shape)
}

/// Checks that only the finished picture is asked for, and that lights are found in the one way that goes by the frame's
/// constants alone.
fn check_half(settings: &Settings) -> Result<()> {
    let view = settings.render.view;
    let is_of_frame = view == View::Final || is_of_every_frame(view) || view == View::Vpls;
    require(is_of_frame, || format!("--view {} is of every pixel: leave --indirect-size half out", name(&view)))?;
    let lgh = &settings.lgh;
    let draws_volumes =
        lgh.lighting == Some(LightingMode::Volumes) || matches!(lgh.reservoir, Some(Reservoir::Race | Reservoir::Lock));
    require(!draws_volumes, || {
        "--indirect-size half gathers lights: leave it out, or choose --lighting gather and --reservoir exact"
            .to_owned()
    })?;
    require(settings.output.inspect.is_none(), || {
        "--inspect tells of the light at one pixel, and --indirect-size half leaves most pixels out: leave one of them out"
            .to_owned()
    })
}

/// Checks that there is something that frames can take over from those before.
fn check_temporal(settings: &Settings, temporal: &str) -> Result<()> {
    let what = format!("--temporal {temporal}");
    settings.require_shadow_samples(&what)?;
    settings.require_successive_frames(&what)
}

/// Checks that samples can be taken again in the same frame.
fn check_rounds(settings: &LghSettings) -> Result<()> {
    let [reason, instead] = settings.one_round_only().unwrap_or_default();
    require(reason.is_empty(), || {
        let rounds = settings.temporal_rounds_or_default();
        format!("--temporal-rounds {rounds} does not go with {reason}: leave it out, or choose {instead}")
    })
}

/// What is taken over from the frames before. Frames of a mean are to be independent.
fn reuse(job: &Job<'_>) -> Option<Reuse> {
    let settings = job.settings;
    let has_samples = settings.many_lights.shadows.is_on() && settings.many_lights.shadow_samples > 0;
    let LghSettings { temporal, antilag, interleave, .. } = settings.lgh;
    let least_weight = settings.lgh.temporal_weight_or_default();
    let of = match temporal? {
        Temporal::Off => return None,
        Temporal::Shadows => Estimated::Shadows,
        Temporal::Indirect => Estimated::Light,
    };
    let rounds = settings.lgh.temporal_rounds_or_default();
    let reuse = Reuse { of, least_weight, antilag, step_px: interleave, rounds };
    (has_samples && settings.render.accumulate == 1).then_some(reuse)
}

/// Whether a view shows what becomes of shadow samples.
fn needs_shadows(view: View) -> bool {
    matches!(view, View::ShadowRatio | View::ShadowRatioFiltered | View::SelectedLevel)
}

impl TechniqueShape for LghShape {
    fn technique(&self) -> &'static dyn Technique {
        &Lgh
    }

    fn write_constants(&self, job: &Job<'_>, data: &mut FrameData) {
        many_lights::write_constants(&self.lights, job, data);
        let settings = &job.settings.lgh;
        data.sub_image_px = self.sub_image_px();
        data.interleave = self.interleave;
        data.shadow_from = settings.shadow_from.min(self.levels.top);
        data.first_level = self.first_level;
        data.top_level = self.levels.top;
        data.alpha = settings.alpha;
        data.levels = self.levels.table();
    }

    fn add_passes(&self, frame: &mut Frame, gbuffer: &GBuffer) -> Added {
        passes::add(frame, self, gbuffer)
    }

    fn add_view(&self, frame: &mut Frame, gbuffer: &GBuffer, view: View) -> Option<AddedView> {
        views::add(frame, self, gbuffer, view)
    }

    fn counts(&self, words: &[Vec<u32>]) -> Vec<Count> {
        counts::counts(self, words)
    }

    fn complaint(&self, words: &[Vec<u32>]) -> Option<String> {
        let (lost, levels) = words.get(1).and_then(|table| table.split_last()).unwrap_or((&0, &[]));
        many_lights::complaint(&self.lights, words, [*lost, levels.iter().skip(1).step_by(2).sum()])
    }

    fn fault(&self, words: &[Vec<u32>]) -> Option<String> {
        grid_update::fault(self, words)
    }

    fn checks_itself(&self) -> bool {
        self.grid_update == GridUpdate::Check
    }

    fn counting(&self) -> Option<Box<dyn TechniqueShape>> {
        Some(Box::new(Self { count_lights_tested: true, ..self.clone() }))
    }

    fn note_choices(&self, settings: &mut Settings) {
        settings.lgh.reservoir = Some(self.reservoir);
        settings.lgh.shadow_estimate = Some(self.shadow_estimate);
        settings.lgh.temporal_weight = Some(settings.lgh.temporal_weight_or_default());
        settings.lgh.temporal_rounds = Some(self.reuse.map_or(1, |reuse| reuse.rounds));
        settings.lgh.temporal = Some(match self.reuse.map(|reuse| reuse.of) {
            None => Temporal::Off,
            Some(Estimated::Light) => Temporal::Indirect,
            Some(Estimated::Shadows | Estimated::Radiance) => Temporal::Shadows,
        });
    }

    fn level_range(&self) -> [u32; 2] {
        [self.first_level, self.levels.top]
    }

    fn inspector_tables(&self, pixel: &InspectedPixel) -> Vec<InspectorTable> {
        // Most pixels have no lights and samples of their own there, and `passes::add` lets none be inspected.
        if self.indirect_size == IndirectSize::Half { Vec::new() } else { inspector::tables(self, pixel) }
    }

    fn is_interleaved(&self) -> bool {
        self.interleave > 1
    }

    fn manifest(&self) -> Map<String, Value> {
        let sizes = json!({
            "sub_image_px": self.sub_image_px(),
            "interleaved_px": self.interleaved_px(),
            "interleave": self.interleave,
            "top_level": self.levels.top,
            "first_level": self.first_level,
            "slots": self.lights.slot_count(),
            "light_capacity": self.lights.light_capacity(),
            "grid_capacity": self.grid_capacity,
            "upper_capacity": self.upper_capacity,
            "grid_anchor": self.anchor.map(|anchor| json!({ "low_ws": anchor.low_ws, "edge": anchor.edge })),
            "shadow_samples": self.lights.shadow_samples,
        });
        sizes.as_object().cloned().unwrap_or_default()
    }

    fn derived(&self, resource: &str, bytes: &[u8], known: &DumpContext<'_>, data: &FrameData) -> Option<Derived> {
        (resource == "merged_lights").then(|| dump::blending_radii(bytes, known, data))?
    }
}
