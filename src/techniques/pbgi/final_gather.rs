//! Final gathering over the lighting grid hierarchy: the points of point-based global illumination look light of all bounces up
//! in it, and pixels see only them. What the hierarchy is wrong by lies behind one more bounce then.

use serde_json::{Map, Value};

use super::super::rules::require;
use super::super::{
    Added, AddedView, Count, InspectorImage, InspectorTable, Technique, TechniqueShape, lgh, many_lights,
};
use super::{Pbgi, dump, measure, passes, views};
use crate::Result;
use crate::dump::{Derived, DumpContext, Entry};
use crate::job::Job;
use crate::passes::Frame;
use crate::passes::direct_light::AreaLight;
use crate::passes::gbuffer::GBuffer;
use crate::passes::lgh_shape::LghShape;
use crate::passes::pbgi_shape::PbgiShape;
use crate::settings::{LightSet, Settings, ShadowPoints, View};
use crate::shared::{FrameData, InspectedPixel};

/// Counters of points and caches; those of the hierarchy follow them.
const POINT_COUNTERS: usize = 2;

/// The technique.
pub struct FinalGather;

/// Its sizes.
#[derive(Clone, Debug, PartialEq)]
pub struct FinalGatherShape {
    /// Of what pixels see.
    pub points: PbgiShape,
    /// Of what points see.
    pub lights: LghShape,
}

/// The settings as the hierarchy is to have them: no pixel looks at it, points cast as many rays as they have lanes, and its
/// light bounces once more on the way to a pixel.
fn of_hierarchy(settings: &Settings) -> Settings {
    settings.clone().changed(|s| {
        s.lgh.interleave = 1;
        s.lgh.shadow_points = ShadowPoints::Descent;
        s.many_lights.bounces = s.many_lights.bounces.saturating_sub(1);
        s.many_lights.shadow_samples = s.many_lights.shadow_samples.min(1);
    })
}

impl Technique for FinalGather {
    fn name(&self) -> &'static str {
        "final-gather"
    }

    fn point_count_log2(&self, settings: &Settings) -> Option<u32> {
        Pbgi.point_count_log2(settings)
    }

    fn has_view(&self, view: View) -> bool {
        views::has(view)
    }

    fn check(&self, settings: &Settings) -> Result<()> {
        many_lights::check_settings(settings)?;
        let many_lights = &settings.many_lights;
        require(many_lights.lights == LightSet::Scene || many_lights.bounces >= 2, || {
            "--technique final-gather has bounces after the first from the hierarchy, and --bounces 1 leaves none: give at least 2, \
             or choose --technique pbgi"
                .to_owned()
        })?;
        require(settings.pbgi.point_bounces == 1, || {
            format!(
                "--technique final-gather has the bounces of --bounces: leave --point-bounces {} out, or choose --technique pbgi",
                settings.pbgi.point_bounces
            )
        })?;
        require(settings.lgh.first_level == 1, || {
            "--technique final-gather looks grid lights up: leave --first-level at 1".to_owned()
        })
    }

    fn shape(&self, job: &Job<'_>, known: Option<&dyn TechniqueShape>) -> Result<Box<dyn TechniqueShape>> {
        let known: Option<&FinalGatherShape> = known.and_then(|known| known.as_any().downcast_ref());
        let points = measure::shape(job, known.map(|known| &known.points))?;
        let settings = of_hierarchy(job.settings);
        let job = Job::new(job.gpu, job.scene, job.camera, &settings);
        let lights = lgh::measured_shape(&job, known.map(|known| &known.lights))?;
        Ok(Box::new(FinalGatherShape { points, lights }))
    }

    fn keeps_measures(&self, now: &Settings, before: &Settings) -> bool {
        Pbgi.keeps_measures(now, before) && lgh::Lgh.keeps_measures(now, before)
    }

    fn dump_entries(&self) -> &'static [&'static [Entry]] {
        &[many_lights::DUMP, lgh::DUMP, lgh::UPDATE_DUMP, dump::ENTRIES, dump::TABLES, dump::POINTS]
    }
}

impl TechniqueShape for FinalGatherShape {
    fn technique(&self) -> &'static dyn Technique {
        &FinalGather
    }

    fn write_constants(&self, job: &Job<'_>, data: &mut FrameData) {
        self.points.write_constants(job, data);
        self.lights.write_constants(job, data);
        // Points look those up that are among the lights of the hierarchy, pixels are lit by all.
        data.direct_lights += self.lights.lights.scene_light_count;
    }

    fn add_passes(&self, frame: &mut Frame, gbuffer: &GBuffer) -> Added {
        passes::add(frame, &self.points, gbuffer, Some(&self.lights))
    }

    fn add_view(&self, frame: &mut Frame, gbuffer: &GBuffer, view: View) -> Option<AddedView> {
        views::add(frame, &self.points, gbuffer, view, Some(&self.lights))
    }

    fn inspector_tables(&self, pixel: &InspectedPixel) -> Vec<InspectorTable> {
        self.points.inspector_tables(pixel)
    }

    fn inspector_images(&self, pixel: &InspectedPixel) -> Vec<InspectorImage> {
        self.points.inspector_images(pixel)
    }

    fn level_range(&self) -> [u32; 2] {
        self.points.level_range()
    }

    fn environment_light(&self) -> AreaLight {
        AreaLight::InTechnique
    }

    fn counts(&self, words: &[Vec<u32>]) -> Vec<Count> {
        let (points, lights) = words.split_at(POINT_COUNTERS.min(words.len()));
        [self.points.counts(points), self.lights.counts(lights)].concat()
    }

    fn complaint(&self, words: &[Vec<u32>]) -> Option<String> {
        let (points, lights) = words.split_at(POINT_COUNTERS.min(words.len()));
        let complaints: Vec<_> =
            [self.points.complaint(points), self.lights.complaint(lights)].into_iter().flatten().collect();
        (!complaints.is_empty()).then(|| complaints.join("; "))
    }

    fn fault(&self, words: &[Vec<u32>]) -> Option<String> {
        self.lights.fault(words.get(POINT_COUNTERS..)?)
    }

    fn checks_itself(&self) -> bool {
        self.lights.checks_itself()
    }

    fn manifest(&self) -> Map<String, Value> {
        self.points.manifest().into_iter().chain(self.lights.manifest()).collect()
    }

    fn derived(&self, resource: &str, bytes: &[u8], known: &DumpContext<'_>, data: &FrameData) -> Option<Derived> {
        self.lights.derived(resource, bytes, known, data)
    }
}
