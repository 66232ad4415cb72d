//! Point-based global illumination (Harada 2014, after Ritschel et al. 2009): light of the environment, of suns and of lamps
//! is computed at the points of the scene's surfaces that matter for the picture, and gathered from there.

mod counts;
mod dump;
mod measure;
mod passes;
mod reference;

use serde_json::{Map, Value, json};

use super::{Added, Count, Technique, TechniqueShape};
use crate::Result;
use crate::dump::Entry;
use crate::job::Job;
use crate::passes::Frame;
use crate::passes::direct_light::EnvironmentLight;
use crate::passes::gbuffer::GBuffer;
use crate::passes::pbgi_shape::PbgiShape;
use crate::settings::Settings;
use crate::shared::FrameData;

pub use reference::PbgiReference;

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

    fn shape(&self, job: &Job<'_>, _known: Option<&dyn TechniqueShape>) -> Result<Box<dyn TechniqueShape>> {
        Ok(Box::new(measure::shape(job)?))
    }

    fn dump_entries(&self) -> &'static [&'static [Entry]] {
        &[dump::ENTRIES, dump::POINTS]
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
        passes::add(frame, self, gbuffer)
    }

    /// The caches hold it.
    fn environment_light(&self) -> EnvironmentLight {
        EnvironmentLight::InTechnique
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
