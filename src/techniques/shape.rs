//! What a technique is once its sizes are known: its passes, and what is made of what they leave.

use std::any::Any;
use std::fmt::Debug;
use std::sync::Arc;

use serde_json::{Map, Value};

use super::{Count, InspectorImage, InspectorTable, Technique};
use crate::dump::{Derived, DumpContext};
use crate::graph::{BufferHandle, ImageHandle};
use crate::job::Job;
use crate::passes::compose::Indirect;
use crate::passes::direct_light::AreaLight;
use crate::passes::gbuffer::GBuffer;
use crate::passes::inspect::InspectorInputs;
use crate::passes::tone_map::ToneMapped;
use crate::passes::{Frame, FrameShape};
use crate::settings::{Settings, View};
use crate::shared::{FrameData, InspectedPixel};

/// Sizes and modes of a technique. Frames of equal shapes are the same but for their constants.
pub trait TechniqueShape: AnyShape + Debug + Send + Sync {
    /// The technique that it is of.
    fn technique(&self) -> &'static dyn Technique;

    /// Writes what it has in the frame's constants.
    fn write_constants(&self, _job: &Job<'_>, _data: &mut FrameData) {}

    /// Adds its passes, in order.
    fn add_passes(&self, frame: &mut Frame, gbuffer: &GBuffer) -> Added;

    /// Adds the passes that lead to one of its views; `None` for the finished picture.
    fn add_view(&self, _frame: &mut Frame, _gbuffer: &GBuffer, _view: View) -> Option<AddedView> {
        None
    }

    /// Who computes the light that the environment sends to the surfaces that are seen.
    fn environment_light(&self) -> AreaLight {
        AreaLight::Here
    }

    /// Who computes the light that surfaces which shine send to the surfaces that are seen.
    fn emitter_light(&self) -> AreaLight {
        AreaLight::Here
    }

    /// What a frame counted, from the words of the buffers in [`TechniqueOutputs::counters`].
    fn counts(&self, _words: &[Vec<u32>]) -> Vec<Count> {
        Vec::new()
    }

    /// One sentence when a frame lacks something: lights that its buffers have no room for, or that could not be made.
    fn complaint(&self, _words: &[Vec<u32>]) -> Option<String> {
        None
    }

    /// Whether its frames are checked, so that there may be a [`Self::fault`].
    fn checks_itself(&self) -> bool {
        false
    }

    /// One sentence when a frame's own check has found it wrong, from the words of the buffers in [`TechniqueOutputs::counters`].
    fn fault(&self, _words: &[Vec<u32>]) -> Option<String> {
        None
    }

    /// The shape of a frame that counts more, too slow for every frame; `None` where there is nothing more to count.
    fn counting(&self) -> Option<Box<dyn TechniqueShape>> {
        None
    }

    /// Puts the choices that were made for the user into the settings.
    fn note_choices(&self, _settings: &mut Settings) {}

    /// First and last level of lights, for legends.
    fn level_range(&self) -> [u32; 2] {
        [0, 0]
    }

    /// What it tells about an inspected pixel, besides surface and light.
    fn inspector_tables(&self, _pixel: &InspectedPixel) -> Vec<InspectorTable> {
        Vec::new()
    }

    /// Pictures that it has of an inspected pixel.
    fn inspector_images(&self, _pixel: &InspectedPixel) -> Vec<InspectorImage> {
        Vec::new()
    }

    /// Whether images and buffers in the interleaved layout differ from the picture's layout.
    fn is_interleaved(&self) -> bool {
        false
    }

    /// What a dump's manifest says of its sizes.
    fn manifest(&self) -> Map<String, Value> {
        Map::new()
    }

    /// What a dump holds besides a resource that a pass has written.
    fn derived(&self, _resource: &str, _bytes: &[u8], _known: &DumpContext<'_>, _data: &FrameData) -> Option<Derived> {
        None
    }
}

/// What every shape can do by being of some type.
pub trait AnyShape: Any {
    /// Itself, to be told apart by type.
    fn as_any(&self) -> &dyn Any;
    /// Itself, to be changed.
    fn as_any_mut(&mut self) -> &mut dyn Any;
    /// Whether another shape is of the same type and equal.
    fn equals(&self, other: &dyn TechniqueShape) -> bool;
    /// A copy.
    fn boxed(&self) -> Box<dyn TechniqueShape>;
}

impl<T: TechniqueShape + Clone + PartialEq> AnyShape for T {
    fn as_any(&self) -> &dyn Any {
        self
    }

    fn as_any_mut(&mut self) -> &mut dyn Any {
        self
    }

    fn equals(&self, other: &dyn TechniqueShape) -> bool {
        other.as_any().downcast_ref() == Some(self)
    }

    fn boxed(&self) -> Box<dyn TechniqueShape> {
        Box::new(self.clone())
    }
}

/// The shape of a whole frame.
#[derive(Debug)]
pub struct Shapes {
    /// What every frame has.
    pub frame: FrameShape,
    /// What its technique adds.
    pub technique: Box<dyn TechniqueShape>,
}

impl Shapes {
    /// The technique's part, where it is of this type.
    #[must_use]
    pub fn of<T: 'static>(&self) -> Option<&T> {
        (*self.technique).as_any().downcast_ref()
    }

    /// The technique's part to be changed, where it is of this type.
    pub fn of_mut<T: 'static>(&mut self) -> Option<&mut T> {
        (*self.technique).as_any_mut().downcast_mut()
    }
}

impl Clone for Shapes {
    fn clone(&self) -> Self {
        Self { frame: self.frame.clone(), technique: (*self.technique).boxed() }
    }
}

impl PartialEq for Shapes {
    fn eq(&self, other: &Self) -> bool {
        self.frame == other.frame && self.technique.equals(&*other.technique)
    }
}

/// What a technique adds to a frame.
pub struct Added {
    /// The indirect light; `None` leaves direct light alone.
    pub indirect: Option<Indirect>,
    /// What can be read after the frame.
    pub outputs: TechniqueOutputs,
    /// The pass of the inspector when it sees more than surface and light.
    pub inspect: Option<InspectPass>,
}

/// Adds an inspector's pass; gives the buffer with the [`InspectedPixel`].
pub type InspectPass = Box<dyn FnOnce(&mut Frame, &GBuffer, &InspectorInputs) -> BufferHandle>;

/// What a view of a technique adds to a frame.
pub struct AddedView {
    /// The numbers that are shown.
    pub values: ImageHandle,
    /// The picture of them.
    pub picture: ToneMapped,
    /// What can be read after the frame.
    pub outputs: TechniqueOutputs,
}

/// What can be read of a technique after a frame.
#[derive(Clone, Debug, Default)]
pub struct TechniqueOutputs {
    /// Small buffers of counts that the host reads; [`TechniqueShape::counts`] knows what they are.
    pub counters: Vec<BufferHandle>,
    handles: Option<Arc<dyn Any + Send + Sync>>,
}

impl TechniqueOutputs {
    /// Counters, and a struct of handles of which the technique and its tests know the type.
    #[must_use]
    pub fn new(counters: Vec<BufferHandle>, handles: impl Any + Send + Sync) -> Self {
        Self { counters, handles: Some(Arc::new(handles)) }
    }

    /// The handles, where they are of this type.
    #[must_use]
    pub fn of<T: 'static>(&self) -> Option<&T> {
        self.handles.as_deref()?.downcast_ref()
    }
}
