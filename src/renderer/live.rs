//! Frames that a window shows: camera, lights and settings change while they run, and only what has another shape is
//! compiled anew.

use std::ops::{ControlFlow, Range};
use std::sync::Arc;

use super::shape::{checked_shapes, shapes};
use super::{Renderer, constants_of_lights, frame_data};
use crate::error::Result;
use crate::frame::FrameOutputs;
use crate::gpu::{FrameResult, PacedFrame, SharedImage, SteppedFrame};
use crate::graph::BufferHandle;
use crate::job::Job;
use crate::passes::present::{SHOWN_FORMAT, SHOWN_PICTURE};
use crate::settings::Settings;
use crate::shared::{InspectedPixel, PunctualLight};
use crate::techniques::{self, Count, TechniqueShape};

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
    /// What it had no room for, or was found wrong, in a sentence.
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
    /// A frame for a window, which may tell everything about one pixel. `known` was measured for its settings, or for others
    /// that [`holds_for`] them.
    ///
    /// # Errors
    /// Those of [`Renderer::new`].
    pub fn for_window(job: &Job<'_>, inspect: bool, known: Option<&dyn TechniqueShape>) -> Result<Self> {
        let technique = techniques::of(job.settings)?;
        let mut shapes = checked_shapes(technique, job, known)?;
        (shapes.frame.inspect, shapes.frame.keeps_lights) = (inspect, true);
        let size_px = [shapes.frame.width_px, shapes.frame.height_px];
        let picture = SharedImage::new(job.gpu, SHOWN_PICTURE, SHOWN_FORMAT, size_px)?;
        Self::compile(job, shapes, Some(picture))
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
        if !holds_for(&*self.shapes.technique, job.settings, measured_with)? {
            return Ok(false);
        }
        let mut shapes = shapes(techniques::of(job.settings)?, job, Some(&*self.shapes.technique))?;
        (shapes.frame.inspect, shapes.frame.keeps_lights) = (inspect, true);
        Ok(shapes == self.shapes)
    }

    /// Takes over the camera and whatever of the settings are constants of the frame.
    pub fn update(&mut self, job: &Job<'_>) {
        self.camera = job.camera.clone();
        self.seed = job.settings.tracing.seed;
        self.data = frame_data(job, &self.shapes);
        self.vertex_moves[0] = job.scene.vertex_moves();
    }

    /// Replaces the scene's directional and spot lights with the next frame.
    ///
    /// # Errors
    /// [`crate::Error::Failure`] when there are more of them than the scene has room for.
    pub fn update_lights(&mut self, lights: &[PunctualLight]) -> Result<()> {
        self.expect_another_scene();
        self.executor.update_lights(bytemuck::cast_slice(lights).to_vec())
    }

    /// Tells the next frame that lights or geometry of the scene are others, whoever writes them.
    pub fn expect_another_scene(&mut self) {
        self.scene_changed = true;
    }

    /// Which pixel the next frames tell about, when they do.
    pub fn inspect_pixel(&mut self, pixel: [u32; 2]) {
        self.data.inspected_pixel = pixel;
    }

    /// The next frame makes its lights anew, whether or not it could use those of the frame before.
    pub fn forget_lights(&mut self) {
        self.lights_of = None;
    }

    /// Begins a frame that goes in pieces, with the lights of the one before where nothing that they follow from has changed; see [`crate::gpu::Executor::begin_paced`].
    ///
    /// # Errors
    /// When the device is lost.
    pub fn begin_paced(&mut self, first_round: u32) -> Result<PacedFrame> {
        let lights_of = Some(constants_of_lights(&self.data));
        self.executor.set_reuses_kept(!self.scene_changed && self.lights_of == lights_of);
        self.lights_of = lights_of;
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
            complaint: technique.fault(&words[counters.clone()]).or_else(|| technique.complaint(&words[counters])),
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

/// What a technique measures of a scene before it can render the job's settings; takes a while.
///
/// # Errors
/// Those of [`Renderer::new`].
pub fn measure(job: &Job<'_>) -> Result<Box<dyn TechniqueShape>> {
    Ok(checked_shapes(techniques::of(job.settings)?, job, None)?.technique)
}

/// Whether what was measured with the settings `measured_with` holds for others as well.
///
/// # Errors
/// [`crate::Error::Usage`] when there is no such technique.
pub fn holds_for(measured: &dyn TechniqueShape, settings: &Settings, measured_with: &Settings) -> Result<bool> {
    let technique = techniques::of(settings)?;
    Ok(measured.technique().name() == technique.name() && technique.keeps_measures(settings, measured_with))
}
