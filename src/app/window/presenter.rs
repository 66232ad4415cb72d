//! What is behind the window: device, swapchain, scene and the frames under way.

use std::collections::VecDeque;
use std::sync::Arc;

use super::loader::Loaded;
use crate::app::setup::gpu_options;
use crate::gpu::{
    Acquired, FRAMES_IN_FLIGHT, FrameResult, FrameTicket, Gpu, Overlay, PanelPainter, PanelPicture, Presented, Surface,
    Swapchain, Target, WindowSource, WindowTarget, is_srgb,
};
use crate::passes::present::{Part, WindowFormat};
use crate::renderer::{FrameFeedback, Fresh, Job, Renderer, UploadedScene, WindowOptions};
use crate::scene::{Camera, Scene};
use crate::settings::Settings;
use crate::shared::PunctualLight;
use crate::{Result, techniques};

/// What became of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It is submitted, and will be shown.
    Shown,
    /// Nothing could be shown: no area, no scene, or no image in time.
    Skipped,
}

/// What becomes of the numbers of lights and levels that were measured for the frame before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Measures {
    /// They are kept where the settings have the same lights.
    Kept,
    /// They are taken again.
    Anew,
}

/// One frame to be shown.
pub struct Request<'a> {
    /// Settings, with the size of the picture rather than that of the window.
    pub settings: &'a Settings,
    /// Settings of the left side of a split view, and where it ends, as a fraction of the window's width.
    pub held: Option<(&'a Settings, f32)>,
    /// Where it is seen from.
    pub camera: &'a Camera,
    /// Directional and spot lights, when they have changed.
    pub lights: Option<Vec<PunctualLight>>,
    /// Number among the accumulated frames.
    pub number: u32,
    /// Point of the window that is inspected, from the top left corner, 0 to 1.
    pub inspected: Option<[f32; 2]>,
    /// What is drawn over it.
    pub panel: &'a PanelPicture,
}

/// What a side of a frame that has completed took and told.
pub struct Done {
    /// Times.
    pub result: FrameResult,
    /// What the host learns of every frame.
    pub feedback: Option<FrameFeedback>,
}

/// A frame that has completed, and the left side of its split view.
pub struct DoneFrame {
    /// The frame, or its right side.
    pub main: Done,
    /// The left side.
    pub held: Option<Done>,
}

/// A compiled frame.
struct Side {
    renderer: Renderer,
    /// What the renderer was measured with.
    measured_with: Settings,
}

impl Side {
    fn finish(&mut self, ticket: FrameTicket) -> Result<Done> {
        let result = self.renderer.wait(ticket)?;
        Ok(Done { feedback: self.renderer.feedback(&result), result })
    }

    fn prepare(&mut self, job: &Job<'_>, request: &Request<'_>) {
        self.renderer.update(job);
        if self.renderer.shapes().frame.accumulate {
            self.renderer.set_accumulated_frame(request.number, Fresh::All);
        }
        if let Some([x, y]) = request.inspected {
            let pixel = |at: f32, edge: u32| ((at * edge as f32) as u32).min(edge.saturating_sub(1));
            let size = job.settings.picture.size;
            self.renderer.inspect_pixel([pixel(x, size.width), pixel(y, size.height)]);
        }
    }
}

/// A scene on the device, with its compiled frames.
struct SceneFrames {
    main: Side,
    /// The left side of a split view.
    held: Option<Side>,
    uploaded: UploadedScene,
}

/// A frame under way.
struct Tickets {
    main: FrameTicket,
    held: Option<FrameTicket>,
}

/// Everything on the device. Fields are dropped in order.
pub struct Presenter {
    tickets: VecDeque<Tickets>,
    frames: Option<SceneFrames>,
    /// Scene of the show.
    scene: Option<Scene>,
    painter: Option<PanelPainter>,
    swapchain: Option<Swapchain>,
    format: WindowFormat,
    surface: Surface,
    gpu: Arc<Gpu>,
    /// Frames that have completed and that nobody has taken.
    done: Vec<DoneFrame>,
    /// Frames compiled so far.
    pub builds: u32,
}

impl Presenter {
    /// Opens the device that can show pictures in the window.
    ///
    /// # Errors
    /// Those of [`Surface::open`] and [`Swapchain::new`].
    pub fn open(settings: &Settings, window: Arc<dyn WindowSource>) -> Result<Self> {
        let surface = Surface::open(&gpu_options(settings), window)?;
        let gpu = Arc::clone(surface.gpu());
        let format = window_format(surface.format()?);
        surface.check_mode(settings.window.present_mode)?;
        Ok(Self {
            tickets: VecDeque::new(),
            frames: None,
            scene: None,
            painter: None,
            swapchain: None,
            format,
            surface,
            gpu,
            done: Vec::new(),
            builds: 0,
        })
    }

    /// The device.
    pub fn gpu(&self) -> &Arc<Gpu> {
        &self.gpu
    }

    /// The scene that is shown.
    pub fn scene(&self) -> Option<&Scene> {
        self.scene.as_ref()
    }

    /// The scene as uploaded.
    pub fn uploaded(&self) -> Option<&UploadedScene> {
        self.frames.as_ref().map(|frames| &frames.uploaded)
    }

    /// The compiled frame.
    pub fn renderer(&self) -> Option<&Renderer> {
        self.frames.as_ref().map(|frames| &frames.main.renderer)
    }

    /// The compiled left side of a split view.
    pub fn held_renderer(&self) -> Option<&Renderer> {
        self.frames.as_ref()?.held.as_ref().map(|held| &held.renderer)
    }

    /// Puts another scene on the stage; the one before stays when that fails.
    ///
    /// # Errors
    /// When the scene does not fit the device or the settings.
    pub fn set_scene(&mut self, loaded: Loaded, camera: &Camera, settings: &Settings) -> Result<()> {
        let mut uploaded = UploadedScene::upload(&self.gpu, &loaded.scene, &loaded.ready, settings.tracing.rays)?;
        uploaded.spread_points(&loaded.scene, techniques::of(settings)?.point_count_log2(settings))?;
        let main = self.compile_side(&Job::new(&self.gpu, &uploaded, camera, settings), (Part::Whole, false), None)?;
        self.retire()?;
        self.frames = Some(SceneFrames { main, held: None, uploaded });
        self.scene = Some(loaded.scene);
        self.builds += 1;
        Ok(())
    }

    /// Compiles the frame anew when it has another shape with these settings; the one before stays when that fails.
    ///
    /// # Errors
    /// When the settings do not fit the device.
    pub fn adapt(&mut self, camera: &Camera, settings: &Settings, inspect: bool) -> Result<bool> {
        self.spread_points(settings)?;
        let Some(SceneFrames { main, held, uploaded }) = &self.frames else { return Ok(false) };
        let part = if held.is_some() { Part::Right } else { Part::Whole };
        let Side { renderer, measured_with } = main;
        let job = Job::new(&self.gpu, uploaded, camera, settings);
        if renderer.fits(&job, measured_with, self.window_options(part, inspect))? {
            return Ok(false);
        }
        let side = self.compile_side(&job, (part, inspect), Some(main))?;
        self.replace(|frames| frames.main = side)?;
        Ok(true)
    }

    /// The same for the left side of a split view; `None` ends it.
    ///
    /// # Errors
    /// When the settings do not fit the device.
    pub fn adapt_held(&mut self, camera: &Camera, settings: Option<&Settings>, inspect: bool) -> Result<bool> {
        settings.map_or(Ok(()), |settings| self.spread_points(settings))?;
        let Some(SceneFrames { main, held, uploaded }) = &self.frames else { return Ok(false) };
        let job = |settings| Job::new(&self.gpu, uploaded, camera, settings);
        let side = match (held, settings) {
            (None, None) => return Ok(false),
            (Some(_), None) => None,
            (Some(Side { renderer, measured_with }), Some(settings))
                if renderer.fits(&job(settings), measured_with, self.window_options(Part::Left, inspect))? =>
            {
                return Ok(false);
            }
            (held, Some(settings)) => {
                let before = held.as_ref().unwrap_or(main);
                Some(self.compile_side(&job(settings), (Part::Left, inspect), Some(before))?)
            }
        };
        self.replace(|frames| frames.held = side)?;
        Ok(true)
    }

    /// Spreads the points that settings need over the scene, if it does not have them.
    fn spread_points(&mut self, settings: &Settings) -> Result<()> {
        let wanted = techniques::of(settings)?.point_count_log2(settings);
        match (&mut self.frames, &self.scene) {
            (Some(frames), Some(scene)) => frames.uploaded.spread_points(scene, wanted),
            _ => Ok(()),
        }
    }

    /// Measures the lights anew, as after the sun has moved far.
    ///
    /// # Errors
    /// Those of [`Renderer::for_window`].
    pub fn measure_again(&mut self, camera: &Camera) -> Result<()> {
        self.compile_again(camera, Measures::Anew)
    }

    /// Compiles the frames anew with the shaders in use; the ones before stay when that fails.
    ///
    /// # Errors
    /// Those of [`Renderer::for_window`].
    pub fn compile(&mut self, camera: &Camera) -> Result<()> {
        self.compile_again(camera, Measures::Kept)
    }

    fn compile_again(&mut self, camera: &Camera, measures: Measures) -> Result<()> {
        let Some(SceneFrames { main, held, uploaded }) = &self.frames else { return Ok(()) };
        let again = |side: &Side, part| {
            let before = (measures == Measures::Kept).then_some(side);
            let inspect = side.renderer.shapes().frame.inspect;
            self.compile_side(&Job::new(&self.gpu, uploaded, camera, &side.measured_with), (part, inspect), before)
        };
        let new_held = held.as_ref().map(|side| again(side, Part::Left)).transpose()?;
        let new_main = again(main, if held.is_some() { Part::Right } else { Part::Whole })?;
        self.replace(|frames| (frames.main, frames.held) = (new_main, new_held))
    }

    fn window_options(&self, part: Part, inspect: bool) -> WindowOptions {
        WindowOptions { format: self.format, part, inspect }
    }

    fn compile_side(&self, job: &Job<'_>, (part, inspect): (Part, bool), before: Option<&Side>) -> Result<Side> {
        let before = before.map(|side| (&side.renderer, &side.measured_with));
        let window_options = self.window_options(part, inspect);
        let renderer = Renderer::for_window(job, window_options, before)?;
        Ok(Side { renderer, measured_with: job.settings.clone() })
    }

    /// Changes the show once the frames under way have completed.
    fn replace(&mut self, change: impl FnOnce(&mut SceneFrames)) -> Result<()> {
        self.retire()?;
        if let Some(frames) = &mut self.frames {
            change(frames);
        }
        self.builds += 1;
        Ok(())
    }

    /// Waits for the frames under way; what they took and told is of passes that go.
    fn retire(&mut self) -> Result<()> {
        while !self.tickets.is_empty() {
            self.finish_first()?;
        }
        self.done.clear();
        Ok(())
    }

    /// Waits for the frame that was begun first.
    fn finish_first(&mut self) -> Result<()> {
        let (Some(frames), Some(tickets)) = (&mut self.frames, self.tickets.pop_front()) else { return Ok(()) };
        let held = match (&mut frames.held, tickets.held) {
            (Some(side), Some(ticket)) => Some(side.finish(ticket)?),
            _ => None,
        };
        self.done.push(DoneFrame { main: frames.main.finish(tickets.main)?, held });
        Ok(())
    }

    /// Whether a frame can begin at once: fewer are under way than there may be.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn is_ready(&mut self) -> Result<bool> {
        while let (Some(frames), Some(tickets)) = (&self.frames, self.tickets.front()) {
            // The left side is submitted before the right one and completes before it.
            if !frames.main.renderer.executor().is_done(&tickets.main)? {
                break;
            }
            self.finish_first()?;
        }
        Ok(self.tickets.len() < FRAMES_IN_FLIGHT)
    }

    /// The frames that completed since the last call.
    pub fn take_done(&mut self) -> Vec<DoneFrame> {
        std::mem::take(&mut self.done)
    }

    /// Drops the swapchain: the window has another size, or none.
    pub fn resized(&mut self) {
        self.swapchain = None;
    }

    /// Draws and shows one frame; call it when [`Self::is_ready`].
    ///
    /// # Errors
    /// When the device is lost, or the surface is and cannot be had again.
    pub fn frame(&mut self, window_px: [u32; 2], request: &Request<'_>) -> Result<Outcome> {
        if self.surface.is_loss_planted() {
            return self.renew_surface();
        }
        if !self.ensure_swapchain(window_px, request)? {
            return Ok(Outcome::Skipped);
        }
        let (Some(frames), Some(swapchain)) = (&mut self.frames, &mut self.swapchain) else {
            return Ok(Outcome::Skipped);
        };
        let target = match swapchain.acquire()? {
            Acquired::Image(target) => target,
            Acquired::NotYet => return Ok(Outcome::Skipped),
            Acquired::Stale => {
                self.swapchain = None;
                return Ok(Outcome::Skipped);
            }
            Acquired::SurfaceLost => return self.renew_surface(),
        };
        let painter = match &mut self.painter {
            Some(painter) => painter,
            none => none.insert(PanelPainter::new(&self.gpu, self.format.format)?),
        };
        painter.update_textures(&request.panel.textures)?;
        let mut overlay = |commands, extent| painter.draw(commands, extent, request.panel);
        let tickets = submit(&self.gpu, frames, &target, request, &mut overlay)?;
        self.tickets.push_back(tickets);
        match swapchain.present(target)? {
            Presented::Shown => {}
            Presented::Stale => self.swapchain = None,
            Presented::SurfaceLost => return self.renew_surface(),
        }
        Ok(Outcome::Shown)
    }

    /// Makes the swapchain when there is none; false while the window has no area.
    fn ensure_swapchain(&mut self, window_px: [u32; 2], request: &Request<'_>) -> Result<bool> {
        if self.swapchain.is_some() {
            return Ok(true);
        }
        if window_px.contains(&0) {
            return Ok(false);
        }
        self.swapchain = Swapchain::new(&self.surface, window_px, request.settings.window.present_mode)?;
        let Some(swapchain) = &self.swapchain else { return Ok(false) };
        let format = window_format(swapchain.format());
        if format != self.format {
            // Another monitor may want another format.
            self.format = format;
            self.painter = None;
            self.compile(request.camera)?;
        }
        Ok(true)
    }

    fn renew_surface(&mut self) -> Result<Outcome> {
        log::warn!("the window's surface was lost; it is made anew");
        self.swapchain = None;
        self.surface.renew()?;
        Ok(Outcome::Skipped)
    }
}

/// Submits the sides of a frame, the left one first.
fn submit(
    gpu: &Arc<Gpu>,
    frames: &mut SceneFrames,
    target: &Target,
    request: &Request<'_>,
    overlay: &mut Overlay<'_>,
) -> Result<Tickets> {
    let SceneFrames { main, held, uploaded } = frames;
    let [width, height] = target.size_px();
    let split = held.as_mut().zip(request.held);
    let divider = split.as_ref().map_or(0, |(_, (_, at))| ((at * width as f32) as u32).min(width));
    // The lights are the scene's: written by the first frame they are there for both.
    let mut lights = request.lights.as_deref();
    let mut begin = |side: &mut Side, settings, part_px| {
        side.prepare(&Job::new(gpu, uploaded, request.camera, settings), request);
        if request.lights.is_some() {
            side.renderer.expect_other_lights();
        }
        if let Some(lights) = lights.take() {
            side.renderer.update_lights(lights)?;
        }
        side.renderer.submit_to(&mut WindowTarget { target, part_px: Some(part_px), overlay: &mut *overlay })
    };
    let held = match split {
        Some((side, (settings, _))) => Some(begin(side, settings, [0, 0, divider, height])?),
        None => None,
    };
    Ok(Tickets { main: begin(main, request.settings, [divider, 0, width - divider, height])?, held })
}

fn window_format(format: ash::vk::Format) -> WindowFormat {
    WindowFormat { format, driver_encodes: is_srgb(format) }
}
