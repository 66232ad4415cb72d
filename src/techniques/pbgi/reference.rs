//! Point-based global illumination without its savings, a reference for them.

use super::super::rules::require;
use super::super::{Added, Technique, TechniqueOutputs, TechniqueShape, reference};
use super::measure;
use crate::Result;
use crate::dump::Entry;
use crate::job::Job;
use crate::passes::compose::Indirect;
use crate::passes::direct_light::AreaLight;
use crate::passes::gbuffer::GBuffer;
use crate::passes::micro_buffers::GatherTables;
use crate::passes::pbgi_shape::PbgiShape;
use crate::passes::points::Points;
use crate::passes::{Frame, pbgi_reference};
use crate::settings::Settings;
use crate::shared::FrameData;

/// The technique.
pub struct PbgiReference;

/// Its sizes.
#[derive(Clone, Debug, PartialEq)]
pub struct PbgiReferenceShape(pub PbgiShape);

impl Technique for PbgiReference {
    fn name(&self) -> &'static str {
        "pbgi-reference"
    }

    fn is_reference(&self) -> bool {
        true
    }

    fn check(&self, settings: &Settings) -> Result<()> {
        require(settings.pbgi.point_bounces == 1, || {
            format!(
                "--technique pbgi-reference has one bounce, not {}: leave --point-bounces out, or choose --technique pbgi",
                settings.pbgi.point_bounces
            )
        })
    }

    fn point_count_log2(&self, settings: &Settings) -> Option<u32> {
        super::Pbgi.point_count_log2(settings)
    }

    fn shape(&self, job: &Job<'_>, _known: Option<&dyn TechniqueShape>) -> Result<Box<dyn TechniqueShape>> {
        Ok(Box::new(PbgiReferenceShape(measure::base_shape(job)?)))
    }

    fn dump_entries(&self) -> &'static [&'static [Entry]] {
        &[reference::DUMP, super::dump::TABLES, super::dump::POINTS]
    }
}

impl TechniqueShape for PbgiReferenceShape {
    fn technique(&self) -> &'static dyn Technique {
        &PbgiReference
    }

    fn environment_light(&self) -> AreaLight {
        AreaLight::InTechnique
    }

    fn write_constants(&self, job: &Job<'_>, data: &mut FrameData) {
        self.0.write_constants(job, data);
    }

    fn add_passes(&self, frame: &mut Frame, gbuffer: &GBuffer) -> Added {
        let tables = GatherTables::declare(frame, &self.0);
        let points = Points::declare(frame, &self.0.cloud);
        let lighting = pbgi_reference::add(frame, gbuffer, &points, &tables);
        let indirect = Indirect { lighting, shadows: None, has_share: true };
        Added { indirect: Some(indirect), outputs: TechniqueOutputs::default(), inspect: None }
    }
}
