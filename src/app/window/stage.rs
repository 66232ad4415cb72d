//! What is behind the window: device, swapchain, scene and the frames under way.

use std::collections::VecDeque;
use std::sync::Arc;

use super::loader::Loaded;
use crate::Result;
use crate::gpu::{
    Acquired, FRAMES_IN_FLIGHT, FrameTicket, FrameTimes, Gpu, GpuOptions, PanelPainter, PanelPicture, Presented,
    Surface, Swapchain, WindowSource, is_srgb,
};
use crate::passes::present::WindowFormat;
use crate::renderer::{Fresh, Renderer, UploadedScene};
use crate::scene::{Camera, Scene};
use crate::settings::Settings;
use crate::shared::PunctualLight;

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
    /// Where it is seen from.
    pub camera: &'a Camera,
    /// Directional and spot lights, when they have changed.
    pub lights: Option<Vec<PunctualLight>>,
    /// Number among the accumulated frames.
    pub number: u32,
    /// What is drawn over it.
    pub panel: &'a PanelPicture,
}

/// A scene on the device, with its compiled frame.
struct Show {
    renderer: Renderer,
    /// What the renderer was measured with.
    made_with: Settings,
    uploaded: UploadedScene,
}

/// Everything on the device. Fields are dropped in order.
pub struct Stage {
    tickets: VecDeque<FrameTicket>,
    show: Option<Show>,
    /// Scene of the show.
    scene: Option<Scene>,
    painter: Option<PanelPainter>,
    swapchain: Option<Swapchain>,
    format: WindowFormat,
    surface: Surface,
    gpu: Arc<Gpu>,
    /// Times of frames that have completed and that nobody has taken.
    times: Vec<FrameTimes>,
    /// Frames compiled so far.
    pub builds: u32,
}

impl Stage {
    /// Opens the device that can show pictures in the window.
    ///
    /// # Errors
    /// Those of [`Surface::open`] and [`Swapchain::new`].
    pub fn open(settings: &Settings, window: Arc<dyn WindowSource>) -> Result<Self> {
        let options =
            GpuOptions { select: settings.gpu.clone(), validation: settings.validation, baseline_only: false };
        let surface = Surface::open(&options, window)?;
        let gpu = Arc::clone(surface.gpu());
        let format = window_format(surface.format()?);
        surface.check_mode(settings.present_mode)?;
        Ok(Self {
            tickets: VecDeque::new(),
            show: None,
            scene: None,
            painter: None,
            swapchain: None,
            format,
            surface,
            gpu,
            times: Vec::new(),
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
        self.show.as_ref().map(|show| &show.uploaded)
    }

    /// The compiled frame.
    pub fn renderer(&self) -> Option<&Renderer> {
        self.show.as_ref().map(|show| &show.renderer)
    }

    /// Puts another scene on the stage; the one before stays when that fails.
    ///
    /// # Errors
    /// When the scene does not fit the device or the settings.
    pub fn set_scene(&mut self, loaded: Loaded, camera: &Camera, settings: &Settings) -> Result<()> {
        let uploaded = UploadedScene::upload(&self.gpu, &loaded.scene, &loaded.ready, settings.rays)?;
        let renderer = Renderer::for_window(&self.gpu, &uploaded, camera, settings, self.format, None)?;
        self.retire()?;
        self.show = Some(Show { renderer, made_with: settings.clone(), uploaded });
        self.scene = Some(loaded.scene);
        self.builds += 1;
        Ok(())
    }

    /// Compiles the frame anew when it has another shape with these settings; the one before stays when that fails.
    ///
    /// # Errors
    /// When the settings do not fit the device.
    pub fn adapt(&mut self, camera: &Camera, settings: &Settings) -> Result<bool> {
        let Some(show) = &self.show else { return Ok(false) };
        let Show { renderer, made_with, uploaded } = show;
        if renderer.fits(&self.gpu, uploaded, settings, made_with)? {
            return Ok(false);
        }
        self.compile(camera, settings)?;
        Ok(true)
    }

    /// Measures the lights anew, as after the sun has moved far.
    ///
    /// # Errors
    /// Those of [`Renderer::for_window`].
    pub fn measure_again(&mut self, camera: &Camera, settings: &Settings) -> Result<()> {
        self.compile_with(camera, settings, Measures::Anew)
    }

    /// Compiles the frame anew with the shaders in use; the one before stays when that fails.
    ///
    /// # Errors
    /// Those of [`Renderer::for_window`].
    pub fn compile(&mut self, camera: &Camera, settings: &Settings) -> Result<()> {
        self.compile_with(camera, settings, Measures::Kept)
    }

    fn compile_with(&mut self, camera: &Camera, settings: &Settings, measures: Measures) -> Result<()> {
        let Some(Show { renderer, made_with, uploaded }) = &self.show else { return Ok(()) };
        let before = (measures == Measures::Kept).then_some((renderer, made_with));
        let renderer = Renderer::for_window(&self.gpu, uploaded, camera, settings, self.format, before)?;
        self.retire()?;
        if let Some(show) = &mut self.show {
            (show.renderer, show.made_with) = (renderer, settings.clone());
        }
        self.builds += 1;
        Ok(())
    }

    /// Waits for the frames under way.
    fn retire(&mut self) -> Result<()> {
        while let (Some(ticket), Some(show)) = (self.tickets.pop_front(), &mut self.show) {
            self.times.push(show.renderer.wait(ticket)?);
        }
        Ok(())
    }

    /// Whether a frame can begin at once: fewer are under way than there may be.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn is_ready(&mut self) -> Result<bool> {
        let Some(show) = &mut self.show else { return Ok(true) };
        while let Some(ticket) = self.tickets.front() {
            if !show.renderer.executor().is_done(ticket)? {
                break;
            }
            if let Some(ticket) = self.tickets.pop_front() {
                self.times.push(show.renderer.wait(ticket)?);
            }
        }
        Ok(self.tickets.len() < FRAMES_IN_FLIGHT)
    }

    /// Times of the frames that completed since the last call.
    pub fn take_times(&mut self) -> Vec<FrameTimes> {
        std::mem::take(&mut self.times)
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
        if !self.ensure_swapchain(window_px, request.settings, request.camera)? {
            return Ok(Outcome::Skipped);
        }
        let (Some(show), Some(swapchain)) = (&mut self.show, &mut self.swapchain) else { return Ok(Outcome::Skipped) };
        let target = match swapchain.acquire()? {
            Acquired::Image(target) => target,
            Acquired::NotYet => return Ok(Outcome::Skipped),
            Acquired::Stale => {
                self.swapchain = None;
                return Ok(Outcome::Skipped);
            }
            Acquired::SurfaceLost => return self.renew_surface(),
        };
        let Show { renderer, uploaded, .. } = show;
        renderer.update(&self.gpu, uploaded, request.camera, request.settings);
        if renderer.shape().accumulate {
            renderer.set_accumulated_frame(request.number, Fresh::All);
        }
        if let Some(lights) = &request.lights {
            renderer.update_lights(lights);
        }
        let painter = match &mut self.painter {
            Some(painter) => painter,
            none => none.insert(PanelPainter::new(&self.gpu, self.format.format)?),
        };
        painter.update_textures(&request.panel.textures)?;
        let mut overlay = |commands, extent| painter.draw(commands, extent, request.panel);
        self.tickets.push_back(renderer.submit_to(&target, &mut overlay)?);
        match swapchain.present(target)? {
            Presented::Shown => {}
            Presented::Stale => self.swapchain = None,
            Presented::SurfaceLost => return self.renew_surface(),
        }
        Ok(Outcome::Shown)
    }

    /// Makes the swapchain when there is none; false while the window has no area.
    fn ensure_swapchain(&mut self, window_px: [u32; 2], settings: &Settings, camera: &Camera) -> Result<bool> {
        if self.swapchain.is_some() {
            return Ok(true);
        }
        if window_px.contains(&0) {
            return Ok(false);
        }
        self.swapchain = Swapchain::new(&self.surface, window_px, settings.present_mode)?;
        let Some(swapchain) = &self.swapchain else { return Ok(false) };
        let format = window_format(swapchain.format());
        if format != self.format {
            // Another monitor may want another format.
            self.format = format;
            self.painter = None;
            self.compile(camera, settings)?;
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

fn window_format(format: ash::vk::Format) -> WindowFormat {
    WindowFormat { format, driver_encodes: is_srgb(format) }
}
