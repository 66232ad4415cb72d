//! The renderer: a scene on a device, and frames of it. Headless and windowed runs share it.

mod live;
mod shape;
mod show;

use std::sync::Arc;

use glam::Vec2;

use self::live::Live;
pub use self::live::{FrameFeedback, holds_for, measure};
use self::shape::checked_shapes;
pub use self::show::Show;
use crate::camera::View;
use crate::error::{Error, Result};
use crate::files::pictures::Picture;
use crate::frame::readback;
use crate::frame::{self, FrameOutputs};
use crate::gpu::{Executor, FrameResult, FrameTicket, OnStep, SharedImage, SteppedFrame, Written};
use crate::graph::BufferHandle;
pub use crate::job::Job;
use crate::passes::{present, taa};
use crate::random::{hash, r2_sequence};
use crate::scene::Camera;
use crate::shared::{FrameData, InspectedPixel};
use crate::techniques::{self, Shapes, Technique};
pub use crate::uploaded_scene::{ReadyScene, UploadedScene};
use crate::views;
use crate::views::legend::{self, Canvas};

/// What a frame of a mean does not share with the frames before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fresh {
    /// Light paths, shadow samples, and where in the pixels it samples.
    All,
    /// Shadow samples alone: the light paths are those of the first frame, and pixels are sampled at their centres.
    Shadows,
    /// As `Shadows`, and one in [`FRAMES_OF_PATHS`] of the light paths: those of a frame are successive ones of a sequence.
    SomePaths,
}

/// Frames after which all light paths are others, where some are renewed in every frame.
pub const FRAMES_OF_PATHS: u32 = 16;

/// A compiled frame of one scene, camera and settings.
pub struct Renderer {
    executor: Executor,
    outputs: FrameOutputs,
    camera: Camera,
    seed: u32,
    data: FrameData,
    /// The constants of the last frame submitted.
    last_data: FrameData,
    /// Whether the next frame has other lights or geometry of the scene.
    scene_changed: bool,
    /// How often the scene's vertices have moved until the next frame, and until the last one.
    vertex_moves: [u64; 2],
    /// Frames between the last cut and the last frame.
    frames_since_cut: u32,
    /// The constants that the lights of the last frame follow from, where they may be used again.
    lights_of: Option<Vec<u8>>,
    shapes: Shapes,
    /// What the frame has behind the picture for a window.
    live: Option<Live>,
}

impl Renderer {
    /// Measures the light paths, chooses the levels and compiles the frame.
    ///
    /// # Errors
    /// [`Error::Usage`] when the settings do not fit the device; device errors.
    pub fn new(job: &Job<'_>) -> Result<Self> {
        Self::with_technique(techniques::of(job.settings)?, job)
    }

    /// The same with a technique that need not be one of [`techniques::TECHNIQUES`].
    ///
    /// # Errors
    /// Those of [`Self::new`].
    pub fn with_technique(technique: &dyn Technique, job: &Job<'_>) -> Result<Self> {
        Self::with_shapes(job, checked_shapes(technique, job, None)?)
    }

    /// Compiles a frame of known shapes, such as those of another renderer with more counted.
    ///
    /// # Errors
    /// Device errors.
    pub fn with_shapes(job: &Job<'_>, shapes: Shapes) -> Result<Self> {
        Self::compile(job, shapes, None)
    }

    /// With a picture it is a frame for a window, which leaves its own there.
    fn compile(job: &Job<'_>, shapes: Shapes, picture: Option<Arc<SharedImage>>) -> Result<Self> {
        let (mut graph, outputs) = frame::build(&shapes);
        let live = picture.map(|picture| {
            let feedback = readback::add(&mut graph, &live::feedback_buffers(&outputs));
            present::publish(&mut graph, outputs.tone_mapped.picture);
            Live { picture, feedback }
        });
        let images = live.iter().map(|live| Arc::clone(&live.picture)).collect();
        let mut executor = Executor::with_images(job.gpu, graph, Some(Arc::clone(&job.scene.set)), images)?;
        executor.set_max_submit_ms(f64::from(job.settings.device.max_submit_ms));
        let data = frame_data(job, &shapes);
        let (camera, seed) = (job.camera.clone(), job.settings.tracing.seed);
        Ok(Self {
            executor,
            outputs,
            camera,
            seed,
            data,
            last_data: data,
            scene_changed: false,
            vertex_moves: [job.scene.vertex_moves(); 2],
            frames_since_cut: 0,
            lights_of: None,
            shapes,
            live,
        })
    }

    /// Prepares frame `number` of a picture that is the mean of several: the seeds and sampling points that it does
    /// not share with the others. Frame 0 starts a new mean; where nothing accumulates, each frame stands alone.
    pub fn set_accumulated_frame(&mut self, number: u32, fresh: Fresh) {
        let everything = fresh == Fresh::All;
        let jittered = self.shapes.frame.accumulate && everything;
        let jitter_px = if jittered { sampling_point(self.seed, number) } else { Vec2::ZERO };
        let frame_seed = if number == 0 { self.seed } else { hash(self.seed ^ hash(number)) };
        self.sample_at(jitter_px);
        self.data.seed = if everything { frame_seed } else { self.seed };
        let paths = self.data.path_count;
        let renewed = paths.wrapping_add(number.wrapping_mul(paths.div_ceil(FRAMES_OF_PATHS)));
        self.data.renewed_paths = if fresh == Fresh::SomePaths { renewed } else { 0 };
        (self.data.accumulated_frame, self.data.sampling_seed) = (number, frame_seed);
    }

    /// Samples the pixels of the next frame so far from their centres, y down.
    fn sample_at(&mut self, jitter_px: Vec2) {
        let view = View::new(&self.camera, self.shapes.frame.width_px, self.shapes.frame.height_px, jitter_px);
        self.data.clip_from_world = view.clip_from_world.to_cols_array_2d();
        [self.data.jitter_x_px, self.data.jitter_y_px] = jitter_px.to_array();
    }

    /// Runs one frame and waits for it, repeated passes in submissions of about `max_submit_ms`.
    ///
    /// # Errors
    /// When the device is lost, and when the frame's own checks found it wrong.
    pub fn run_in_steps(&mut self, max_submit_ms: f64, on_step: &mut OnStep) -> Result<SteppedFrame> {
        self.follow_last_frame();
        let frame = self.executor.run_in_steps(bytemuck::bytes_of(&self.data), max_submit_ms, on_step)?;
        self.verify()?;
        Ok(frame)
    }

    /// Submits one frame.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn submit(&mut self) -> Result<FrameTicket> {
        self.follow_last_frame();
        self.executor.submit(bytemuck::bytes_of(&self.data))
    }

    /// The next frame has nothing to do with the one before: its history is not valid, and its previous camera is its own.
    pub fn cut(&mut self) {
        self.executor.invalidate_history();
    }

    /// Tells the frame that is about to be submitted what it follows.
    fn follow_last_frame(&mut self) {
        let [moves, moves_before] = self.vertex_moves;
        // The device has where vertices were before they last moved, but not where they were still earlier.
        if moves > moves_before + 1 {
            self.cut();
        }
        self.vertex_moves[1] = moves;
        let valid = self.executor.history_is_valid();
        self.frames_since_cut = if valid { self.frames_since_cut.wrapping_add(1) } else { 0 };
        if self.shapes.frame.taa {
            self.sample_at(taa::jitter_px(self.frames_since_cut));
        }
        let last = if valid { self.last_data } else { self.data };
        self.data.previous_jitter_px = [last.jitter_x_px, last.jitter_y_px];
        self.data.previous_eye_ws = last.eye_ws;
        (self.data.previous_forward_ws, self.data.previous_near) = (last.forward_ws, last.near);
        (self.data.previous_right_ws, self.data.previous_up_ws) = (last.right_ws, last.up_ws);
        self.data.vertices_moved = (valid && moves > moves_before).into();
        self.data.history_is_valid = valid.into();
        let stands = valid && !self.scene_changed && without_view(&self.data) == without_view(&last);
        self.data.scene_stands = stands.into();
        // Other light paths find the same light.
        let lighting = |data| constants_of_lights(&FrameData { seed: 0, renewed_paths: 0, ..data });
        let lights_stand = valid && !self.scene_changed && lighting(self.data) == lighting(last);
        self.data.lighting_stands = lights_stand.into();
        self.scene_changed = false;
        self.last_data = self.data;
    }

    /// Waits for a frame.
    ///
    /// # Errors
    /// When the device is lost, and when the frame's own checks found it wrong.
    pub fn wait(&mut self, ticket: FrameTicket) -> Result<FrameResult> {
        let result = self.executor.wait(ticket)?;
        self.verify()?;
        Ok(result)
    }

    /// Fails where the last frame checks itself and found something wrong.
    fn verify(&self) -> Result<()> {
        let technique = &self.shapes.technique;
        let fault = if technique.checks_itself() { technique.fault(&self.read_counters()?) } else { None };
        fault.map_or(Ok(()), |sentence| Err(Error::Failure(sentence)))
    }

    /// What the last frame has read of the one before it; nothing where its history was not valid. Call it before
    /// [`Self::run_and_read`].
    ///
    /// # Errors
    /// When the device is lost or has no memory.
    pub fn read_history(&self) -> Result<Vec<Written>> {
        if self.data.history_is_valid == 0 { Ok(Vec::new()) } else { self.executor.read_history() }
    }

    /// Runs one more frame, pass by pass, and gives `visit` every pass's index with what it wrote.
    ///
    /// # Errors
    /// When the device is lost or has no memory, and those of `visit`.
    pub fn run_and_read(&self, visit: impl FnMut(usize, Vec<Written>) -> Result<()>) -> Result<()> {
        self.executor.run_and_read(bytemuck::bytes_of(&self.data), visit)
    }

    /// The constants of the last frame.
    #[must_use]
    pub fn frame_data(&self) -> &FrameData {
        &self.data
    }

    /// Names of the passes in order.
    #[must_use]
    pub fn pass_names(&self) -> Vec<String> {
        self.executor.graph().passes().iter().map(|p| p.name.clone()).collect()
    }

    /// The compiled frame.
    #[must_use]
    pub fn executor(&self) -> &Executor {
        &self.executor
    }

    /// What can be read after a frame.
    #[must_use]
    pub fn outputs(&self) -> &FrameOutputs {
        &self.outputs
    }

    /// Sizes, capacities and modes in use.
    #[must_use]
    pub fn shapes(&self) -> &Shapes {
        &self.shapes
    }

    /// One sentence when the last frame lacks something that was asked for ([`TechniqueShape::complaint`]); waits.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn complaint(&self) -> Result<Option<String>> {
        Ok(self.shapes().technique.complaint(&self.read_counters()?))
    }

    /// What the last frame told about the inspected pixel; `None` when it does not tell.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn read_inspected(&self) -> Result<Option<InspectedPixel>> {
        let read = |buffer| Ok(bytemuck::pod_read_unaligned(&self.executor.read_buffer(buffer)?));
        self.outputs.inspected.map(read).transpose()
    }

    /// Words of the technique's counters after the last frame.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn read_counters(&self) -> Result<Vec<Vec<u32>>> {
        let read = |buffer: &BufferHandle| Ok(bytemuck::pod_collect_to_vec(&self.executor.read_buffer(*buffer)?));
        self.outputs.technique.counters.iter().map(read).collect()
    }

    /// The picture of the last frame in both forms, with a note that goes into its file.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn read_picture(&self, note: String) -> Result<Picture> {
        Ok(Picture {
            width_px: self.shapes.frame.width_px,
            height_px: self.shapes.frame.height_px,
            radiance: self.read_radiance()?,
            srgb: self.read_srgb()?,
            note,
        })
    }

    /// Linear radiance of the last frame, RGB, row 0 at the top.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn read_radiance(&self) -> Result<Vec<f32>> {
        let bytes = self.executor.read_image(self.outputs.radiance)?;
        let texels: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&bytes);
        Ok(texels.iter().flat_map(|t| [t[0], t[1], t[2]]).collect())
    }

    /// Exposure of the last frame's picture; `None` for a view that has a scale instead.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn read_exposure(&self) -> Result<Option<f32>> {
        let factor = self.read_exposure_or_scale()?;
        Ok(self.outputs.tone_mapped.is_exposed.then_some(factor))
    }

    fn read_exposure_or_scale(&self) -> Result<f32> {
        let numbers: Vec<f32> =
            bytemuck::pod_collect_to_vec(&self.executor.read_buffer(self.outputs.tone_mapped.exposure)?);
        Ok(numbers[0])
    }

    /// Tone-mapped picture of the last frame, sRGB, RGB; a view with a scale has its legend drawn in.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn read_srgb(&self) -> Result<Vec<u8>> {
        let bytes = self.executor.read_image(self.outputs.tone_mapped.picture)?;
        let mut rgb: Vec<u8> = bytes.chunks_exact(4).flat_map(|t| [t[0], t[1], t[2]]).collect();
        let end = self.read_exposure_or_scale()?;
        let shape = &self.shapes.frame;
        if let Some((title, scale)) = views::legend_of(shape.view, self.shapes.technique.level_range(), end) {
            let mut canvas = Canvas { rgb: &mut rgb, width_px: shape.width_px, height_px: shape.height_px };
            legend::draw(&mut canvas, title, &scale);
        }
        Ok(rgb)
    }
}

/// The constants of a frame without those that say from where it is seen, what came before, and how it is shown.
fn without_view(data: &FrameData) -> Vec<u8> {
    let rest = FrameData {
        clip_from_world: [[0.0; 4]; 4],
        eye_ws: [0.0; 3],
        previous_eye_ws: [0.0; 3],
        forward_ws: [0.0; 3],
        right_ws: [0.0; 3],
        up_ws: [0.0; 3],
        near: 0.0,
        previous_forward_ws: [0.0; 3],
        previous_near: 0.0,
        previous_right_ws: [0.0; 3],
        previous_up_ws: [0.0; 3],
        vertices_moved: 0,
        jitter_x_px: 0.0,
        jitter_y_px: 0.0,
        previous_jitter_px: [0.0; 2],
        rasteriser_step: 0.0,
        history_is_valid: 0,
        scene_stands: 0,
        lighting_stands: 0,
        inspected_pixel: [0; 2],
        exposure: 0.0,
        exposure_compensation: 0.0,
        tone_map: 0,
        ..*data
    };
    bytemuck::bytes_of(&rest).to_vec()
}

/// The constants that lights, and what is built over them, may follow from.
fn constants_of_lights(data: &FrameData) -> Vec<u8> {
    without_view(&FrameData { sampling_seed: 0, accumulated_frame: 0, ..*data })
}

/// Where frame `number` of a mean samples its pixels: offset from the centre, within half a pixel.
fn sampling_point(seed: u32, number: u32) -> Vec2 {
    Vec2::from_array(r2_sequence(number, seed)) - 0.5
}

/// The frame's constants.
fn frame_data(job: &Job<'_>, shapes: &Shapes) -> FrameData {
    let mut data = job.frame_data();
    shapes.technique.write_constants(job, &mut data);
    data
}
