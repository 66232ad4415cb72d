//! Frames that a window shows: camera, lights and settings change while they run, and only what has another shape is
//! compiled anew.

use std::ops::{ControlFlow, Range};
use std::sync::Arc;

use super::shape::{checked_shapes, shapes};
use super::{Renderer, frame_data};
use crate::error::Result;
use crate::frame::FrameOutputs;
use crate::gpu::{FrameResult, PacedFrame, SharedImage, SteppedFrame};
use crate::graph::BufferHandle;
use crate::job::Job;
use crate::passes::present::{SHOWN_FORMAT, SHOWN_PICTURE};
use crate::settings::Settings;
use crate::shared::{InspectedPixel, PunctualLight};
use crate::techniques::{self, Count, Technique, TechniqueShape};

/// What a frame has behind its picture for a window.
pub(super) struct Live {
    /// Where its picture is left.
    pub picture: Arc<SharedImage>,
    /// Where in its readback each buffer of [`feedback_buffers`] is.
    pub feedback: Vec<Range<usize>>,
}

/// What a completed frame of a window has told.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameFeedback {
    /// Exposure, or the upper end of a view's scale.
    pub exposure_or_scale: f32,
    /// Which of the two it is.
    pub is_exposed: bool,
    /// Rays of light paths and of shadow samples.
    pub rays: [u32; 2],
    /// What the technique counted.
    pub counts: Vec<Count>,
    /// What it had no room for, in a sentence.
    pub complaint: Option<String>,
    /// The pixel asked for.
    pub inspected: Option<InspectedPixel>,
}

impl FrameFeedback {
    /// The exposure; `None` for a view that has a scale instead.
    #[must_use]
    pub fn exposure(&self) -> Option<f32> {
        self.is_exposed.then_some(self.exposure_or_scale)
    }
}

impl Renderer {
    /// A frame for a window, which may tell everything about one pixel. What `before` measured of the same scene is used
    /// again where the settings leave it as it was; `measured_with` are the settings that it was measured with.
    ///
    /// # Errors
    /// Those of [`Renderer::new`].
    pub fn for_window(job: &Job<'_>, inspect: bool, before: Option<(&Self, &Settings)>) -> Result<Self> {
        let technique = techniques::of(job.settings)?;
        let known = before.filter(|(_, measured_with)| technique.keeps_measures(job.settings, measured_with));
        let known = known.map(|(before, _)| &*before.shapes.technique);
        let mut shapes = checked_shapes(technique, job, known.filter(|known| is_of(*known, technique)))?;
        shapes.frame.inspect = inspect;
        let size_px = [shapes.frame.width_px, shapes.frame.height_px];
        let picture = SharedImage::new(job.gpu, SHOWN_PICTURE, SHOWN_FORMAT, size_px)?;
        Self::compile(job, shapes, Some(picture))
    }

    /// Whether what it measured of the scene, with the settings `measured_with`, holds for others as well.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] when there is no such technique.
    pub fn knows(&self, settings: &Settings, measured_with: &Settings) -> Result<bool> {
        let technique = techniques::of(settings)?;
        Ok(is_of(&*self.shapes.technique, technique) && technique.keeps_measures(settings, measured_with))
    }

    /// Where a frame of a window leaves its picture.
    #[must_use]
    pub fn shown_picture(&self) -> Option<&Arc<SharedImage>> {
        self.live.as_ref().map(|live| &live.picture)
    }

    /// Whether frames of the job's settings are the ones compiled, but for their constants. `measured_with` are the
    /// settings that the renderer was made with.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] when the settings do not fit the device.
    pub fn fits(&self, job: &Job<'_>, measured_with: &Settings, inspect: bool) -> Result<bool> {
        if !self.knows(job.settings, measured_with)? {
            return Ok(false);
        }
        let mut shapes = shapes(techniques::of(job.settings)?, job, Some(&*self.shapes.technique))?;
        shapes.frame.inspect = inspect;
        Ok(shapes == self.shapes)
    }

    /// Takes over the camera and whatever of the settings are constants of the frame.
    pub fn update(&mut self, job: &Job<'_>) {
        self.camera = job.camera.clone();
        self.seed = job.settings.tracing.seed;
        self.data = frame_data(job, &self.shapes);
    }

    /// Replaces the scene's directional and spot lights with the next frame.
    ///
    /// # Errors
    /// [`crate::Error::Failure`] when there are more of them than the scene has room for.
    pub fn update_lights(&mut self, lights: &[PunctualLight]) -> Result<()> {
        self.expect_other_lights();
        self.executor.update_lights(bytemuck::cast_slice(lights).to_vec())
    }

    /// Tells the next frame that lights of the scene are others, whoever writes them.
    pub fn expect_other_lights(&mut self) {
        self.lights_changed = true;
    }

    /// Which pixel the next frames tell about, when they do.
    pub fn inspect_pixel(&mut self, pixel: [u32; 2]) {
        self.data.inspected_pixel = pixel;
    }

    /// Begins a frame that goes in pieces; see [`crate::gpu::Executor::begin_paced`].
    ///
    /// # Errors
    /// When the device is lost.
    pub fn begin_paced(&mut self, first_round: u32) -> Result<PacedFrame> {
        self.follow_last_frame();
        self.executor.begin_paced(bytemuck::bytes_of(&self.data), first_round)
    }

    /// Goes on with a frame; see [`crate::gpu::Executor::advance`].
    ///
    /// # Errors
    /// When the device is lost.
    pub fn advance(
        &mut self,
        frame: &mut PacedFrame,
        longest_ms: f64,
        flow: ControlFlow<()>,
    ) -> Result<Option<SteppedFrame>> {
        self.executor.advance(frame, longest_ms, flow)
    }

    /// Ends a frame before it is done; see [`crate::gpu::Executor::abandon`].
    ///
    /// # Errors
    /// When the device is lost.
    pub fn abandon(&mut self, frame: PacedFrame) -> Result<()> {
        self.executor.abandon(frame)
    }

    /// What a completed frame has told; `None` for frames without a window.
    #[must_use]
    pub fn feedback(&self, result: &FrameResult) -> Option<FrameFeedback> {
        let ranges = &self.live.as_ref()?.feedback;
        let parts: Vec<&[u8]> = ranges.iter().map(|range| result.readback.get(range.clone())).collect::<Option<_>>()?;
        let words: Vec<Vec<u32>> = parts.iter().map(|part| bytemuck::pod_collect_to_vec(part)).collect();
        let counters = 2..2 + self.outputs.technique.counters.len();
        let inspected = parts.get(counters.end).and_then(|bytes| bytes.get(..size_of::<InspectedPixel>()));
        let technique = &self.shapes.technique;
        Some(FrameFeedback {
            exposure_or_scale: f32::from_bits(*words[0].first()?),
            is_exposed: self.outputs.tone_mapped.is_exposed,
            rays: [*words[1].first()?, *words[1].get(1)?],
            counts: technique.counts(&words[counters.clone()]),
            complaint: technique.complaint(&words[counters]),
            inspected: inspected.map(bytemuck::pod_read_unaligned),
        })
    }
}

/// The buffers that tell the host of a frame: exposure, rays, the technique's counters, the inspected pixel.
pub(super) fn feedback_buffers(outputs: &FrameOutputs) -> Vec<BufferHandle> {
    let mut buffers = vec![outputs.tone_mapped.exposure, outputs.ray_count];
    buffers.extend(&outputs.technique.counters);
    buffers.extend(outputs.inspected);
    buffers
}

/// Whether a shape is of this technique.
fn is_of(shape: &dyn TechniqueShape, technique: &dyn Technique) -> bool {
    shape.technique().name() == technique.name()
}
