//! Point-based global illumination (Harada 2014, after Ritschel et al. 2009): light of the environment, of suns and of lamps
//! is computed at the points of the scene's surfaces that matter for the picture, and gathered from there.

mod counts;
mod dump;
mod final_gather;
mod inspector;
mod measure;
mod passes;
mod reference;
mod views;

use serde_json::{Map, Value, json};

use super::{Added, AddedView, Count, InspectorImage, InspectorTable, Technique, TechniqueShape};
use crate::Result;
use crate::dump::Entry;
use crate::job::Job;
use crate::passes::Frame;
use crate::passes::direct_light::AreaLight;
use crate::passes::gbuffer::GBuffer;
use crate::passes::pbgi_shape::PbgiShape;
use crate::settings::{Settings, View};
use crate::shared::{FrameData, InspectedPixel, MAX_LEVEL};

pub use final_gather::{FinalGather, FinalGatherShape};
pub use reference::{PbgiReference, PbgiReferenceShape};

/// Largest radius of a primary point in the picture.
const PRIMARY_RADIUS_PX: f32 = 8.0;
/// Widest angle of its normals with their mean.
const PRIMARY_CONE_DEG: f32 = 30.0;
/// The same for a node that is seen.
const HIT_CONE_DEG: f32 = 60.0;
/// Reach of a cache, in radii of its node.
const CACHE_REACH: f32 = 2.5;
/// Widest angle between the normals of a cache and of a surface that it lights.
const CACHE_CONE_DEG: f32 = 60.0;

/// The technique.
pub struct Pbgi;

impl Technique for Pbgi {
    fn name(&self) -> &'static str {
        "pbgi"
    }

    fn point_count_log2(&self, settings: &Settings) -> Option<u32> {
        Some(settings.pbgi.points.ilog2())
    }

    fn has_view(&self, view: View) -> bool {
        views::has(view)
    }

    fn shape(&self, job: &Job<'_>, known: Option<&dyn TechniqueShape>) -> Result<Box<dyn TechniqueShape>> {
        let known = known.and_then(|known| known.as_any().downcast_ref());
        Ok(Box::new(measure::shape(job, known)?))
    }

    fn keeps_measures(&self, now: &Settings, before: &Settings) -> bool {
        measure::keeps_measures(now, before)
    }

    fn dump_entries(&self) -> &'static [&'static [Entry]] {
        &[dump::ENTRIES, dump::TABLES, dump::POINTS]
    }
}

impl TechniqueShape for PbgiShape {
    fn technique(&self) -> &'static dyn Technique {
        &Pbgi
    }

    fn write_constants(&self, job: &Job<'_>, data: &mut FrameData) {
        data.point_leaf_count = self.cloud.leaf_count();
        data.point_leaf_radius = self.cloud.leaf_radius;
        data.primary_radius_px = PRIMARY_RADIUS_PX;
        data.primary_cone_cos = PRIMARY_CONE_DEG.to_radians().cos();
        data.hit_texels = 1.0;
        data.hit_cone_cos = HIT_CONE_DEG.to_radians().cos();
        data.sun_leaves = job.settings.pbgi.sun_leaves;
        data.cache_reach = CACHE_REACH;
        data.cache_cone_cos = CACHE_CONE_DEG.to_radians().cos();
    }

    fn add_passes(&self, frame: &mut Frame, gbuffer: &GBuffer) -> Added {
        passes::add(frame, self, gbuffer, None)
    }

    fn add_view(&self, frame: &mut Frame, gbuffer: &GBuffer, view: View) -> Option<AddedView> {
        views::add(frame, self, gbuffer, view, None)
    }

    fn inspector_tables(&self, pixel: &InspectedPixel) -> Vec<InspectorTable> {
        inspector::tables(self, pixel)
    }

    fn inspector_images(&self, pixel: &InspectedPixel) -> Vec<InspectorImage> {
        inspector::images(pixel)
    }

    /// Of the tree, counted from the leaves.
    fn level_range(&self) -> [u32; 2] {
        [0, self.cloud.leaf_count_log2.min(MAX_LEVEL)]
    }

    /// The caches hold it.
    fn environment_light(&self) -> AreaLight {
        AreaLight::InTechnique
    }

    fn counts(&self, words: &[Vec<u32>]) -> Vec<Count> {
        counts::counts(words)
    }

    fn complaint(&self, words: &[Vec<u32>]) -> Option<String> {
        counts::complaint(self, words)
    }

    fn manifest(&self) -> Map<String, Value> {
        let sizes = json!({
            "points": self.cloud.leaf_count(),
            "primary_capacity": self.primary_capacity,
            "reference_capacity": self.reference_capacity,
        });
        sizes.as_object().cloned().unwrap_or_default()
    }
}
