//! Direct light alone.

use super::{Added, Technique, TechniqueOutputs, TechniqueShape};
use crate::Result;
use crate::job::Job;
use crate::passes::Frame;
use crate::passes::gbuffer::GBuffer;
use crate::settings::Settings;

/// The technique, and its shape: it has no sizes.
#[derive(Clone, Debug, PartialEq)]
pub struct Direct;

impl Technique for Direct {
    fn name(&self) -> &'static str {
        "direct"
    }

    /// A mean has many samples of its own, and keeps edges that the filter would blur.
    fn filters_area_light(&self, settings: &Settings) -> bool {
        settings.render.accumulate == 1
    }

    fn shape(&self, _job: &Job<'_>, _known: Option<&dyn TechniqueShape>) -> Result<Box<dyn TechniqueShape>> {
        Ok(Box::new(Self))
    }
}

impl TechniqueShape for Direct {
    fn technique(&self) -> &'static dyn Technique {
        &Self
    }

    fn add_passes(&self, _frame: &mut Frame, _gbuffer: &GBuffer) -> Added {
        Added { indirect: None, outputs: TechniqueOutputs::default(), inspect: None }
    }
}
