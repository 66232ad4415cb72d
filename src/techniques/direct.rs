//! Direct light alone.

use super::{Added, Technique, TechniqueOutputs, TechniqueShape};
use crate::Result;
use crate::job::Job;
use crate::passes::Frame;
use crate::passes::gbuffer::GBuffer;

/// The technique, and its shape: it has no sizes.
#[derive(Clone, Debug, PartialEq)]
pub struct Direct;

impl Technique for Direct {
    fn name(&self) -> &'static str {
        "direct"
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
