//! Unidirectional path tracing, a reference for everything else.

use super::{Added, Technique, TechniqueOutputs, TechniqueShape, reference};
use crate::Result;
use crate::dump::Entry;
use crate::job::Job;
use crate::passes::compose::Indirect;
use crate::passes::direct_light::AreaLight;
use crate::passes::gbuffer::GBuffer;
use crate::passes::{Frame, path_trace};
use crate::random::hash;
use crate::settings::Settings;
use crate::shared::FrameData;

/// The technique.
pub struct PathTrace;

/// Its sizes.
#[derive(Clone, Debug, PartialEq)]
pub struct PathTraceShape {
    /// Paths per pixel.
    pub samples: u32,
}

impl Technique for PathTrace {
    fn name(&self) -> &'static str {
        "path-trace"
    }

    fn is_reference(&self) -> bool {
        true
    }

    /// Half of the samples with the seed, the rest with another.
    fn halves(&self, settings: &Settings) -> Option<[Settings; 2]> {
        let samples = settings.path_trace.samples;
        let second = settings.clone().changed(|s| {
            s.path_trace.samples = samples / 2;
            s.tracing.seed = hash(settings.tracing.seed);
        });
        let first = settings.clone().changed(|s| s.path_trace.samples = samples.div_ceil(2));
        (samples > 1).then_some([first, second])
    }

    fn shape(&self, job: &Job<'_>, _known: Option<&dyn TechniqueShape>) -> Result<Box<dyn TechniqueShape>> {
        Ok(Box::new(PathTraceShape { samples: job.settings.path_trace.samples }))
    }

    fn dump_entries(&self) -> &'static [&'static [Entry]] {
        &[reference::DUMP]
    }
}

impl TechniqueShape for PathTraceShape {
    fn technique(&self) -> &'static dyn Technique {
        &PathTrace
    }

    /// Its paths find it, as many as there are.
    fn environment_light(&self) -> AreaLight {
        AreaLight::InTechnique
    }

    fn emitter_light(&self) -> AreaLight {
        AreaLight::InTechnique
    }

    fn write_constants(&self, job: &Job<'_>, data: &mut FrameData) {
        data.bounces = job.settings.many_lights.bounces;
    }

    fn add_passes(&self, frame: &mut Frame, gbuffer: &GBuffer) -> Added {
        let lighting = path_trace::add(frame, gbuffer, self.samples);
        let indirect = Indirect { lighting, shadows: None, has_share: true };
        Added { indirect: Some(indirect), outputs: TechniqueOutputs::default(), inspect: None }
    }
}
