//! What brings pictures into the window: device, surface, swapchain and the panel's painter.

use std::sync::Arc;

use super::stage::Stage;
use crate::Result;
use crate::app::setup::gpu_options;
use crate::gpu::{
    Acquired, FRAMES_IN_FLIGHT, Gpu, Overlay, PanelPainter, PanelPicture, Presented, Renewals, Surface, Swapchain,
    Target, WindowSource, WindowTarget, is_srgb,
};
use crate::passes::present::{Part, WindowFormat};
use crate::renderer::Show;
use crate::settings::{PresentMode, Settings};

/// What became of a frame of the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It is submitted, and will be shown.
    Shown,
    /// Nothing could be shown: no area, or no image now.
    Skipped,
}

/// What is shown.
pub struct View<'a> {
    /// Size of the window.
    pub window_px: [u32; 2],
    /// Where the left side of a split view ends, as a fraction of the window's width.
    pub divider: f32,
    /// What is drawn over the pictures.
    pub panel: &'a PanelPicture,
    /// Vulkan present mode of the window.
    pub present_mode: PresentMode,
}

/// Everything that shows. Fields are dropped in order.
pub struct Presenter {
    painter: Option<PanelPainter>,
    /// Shows the panel alone, as long as there is no picture.
    blank: Option<Show>,
    swapchain: Option<Swapchain>,
    renewals: Renewals,
    format: WindowFormat,
    surface: Surface,
    gpu: Arc<Gpu>,
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
        Ok(Self { painter: None, blank: None, swapchain: None, renewals: Renewals::default(), format, surface, gpu })
    }

    /// The device.
    pub fn gpu(&self) -> &Arc<Gpu> {
        &self.gpu
    }

    /// Format of the window's images.
    pub fn format(&self) -> WindowFormat {
        self.format
    }

    /// Drops the swapchain: the window has another size, or none.
    pub fn resized(&mut self) {
        self.swapchain = None;
    }

    /// Whether a frame of the window can begin at once: fewer are under way than there may be.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn is_ready(&mut self, stage: Option<&mut Stage>) -> Result<bool> {
        let blank = self.blank.as_mut().map_or(Ok(0), Show::count_under_way)?;
        let pictures = stage.map_or(Ok(0), Stage::shows_under_way)?;
        Ok(blank + pictures < FRAMES_IN_FLIGHT)
    }

    /// Shows the last picture with the panel over it; call it when [`Self::is_ready`].
    ///
    /// # Errors
    /// When the device is lost, or the surface is and cannot be had again.
    pub fn show(&mut self, view: &View<'_>, mut stage: Option<&mut Stage>) -> Result<Outcome> {
        if self.surface.is_loss_planted() {
            return self.renew_surface();
        }
        if !self.ensure_swapchain(view, stage.as_deref_mut())? {
            return Ok(Outcome::Skipped);
        }
        let Some(swapchain) = &mut self.swapchain else { return Ok(Outcome::Skipped) };
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
        painter.update_textures(&view.panel.textures)?;
        let mut overlay = |commands, extent| painter.draw(commands, extent, view.panel);
        match stage.and_then(Stage::shown_mut) {
            Some(set) => {
                let held = set.held.as_mut().map(|held| &mut held.show);
                submit(held, &mut set.main.show, (&target, view.divider), &mut overlay)?;
            }
            None => {
                let blank = match &mut self.blank {
                    Some(blank) => blank,
                    none => none.insert(Show::new(&self.gpu, None, self.format, Part::Whole)?),
                };
                submit(None, blank, (&target, 0.0), &mut overlay)?;
            }
        }
        match swapchain.present(target)? {
            Presented::Shown => {}
            Presented::Suboptimal if !self.renewals.wants(view.window_px) => {}
            Presented::Suboptimal | Presented::Stale => self.swapchain = None,
            Presented::SurfaceLost => return self.renew_surface(),
        }
        Ok(Outcome::Shown)
    }

    /// Makes the swapchain when there is none; false while the window has no area.
    fn ensure_swapchain(&mut self, view: &View<'_>, stage: Option<&mut Stage>) -> Result<bool> {
        if self.swapchain.is_some() {
            return Ok(true);
        }
        if view.window_px.contains(&0) {
            return Ok(false);
        }
        self.swapchain = Swapchain::new(&self.surface, view.window_px, view.present_mode)?;
        let Some(swapchain) = &self.swapchain else { return Ok(false) };
        let format = window_format(swapchain.format());
        if format != self.format {
            // Another monitor may want another format.
            self.format = format;
            (self.painter, self.blank) = (None, None);
            stage.map_or(Ok(()), |stage| stage.set_window(format))?;
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

/// Submits the sides of a frame of the window, the left one first.
fn submit(
    held: Option<&mut Show>,
    main: &mut Show,
    (target, divider): (&Target, f32),
    overlay: &mut Overlay<'_>,
) -> Result<()> {
    let [width, height] = target.size_px();
    let divider = held.as_ref().map_or(0, |_| ((divider * width as f32) as u32).min(width));
    if let Some(held) = held {
        held.submit(&mut WindowTarget { target, part_px: Some([0, 0, divider, height]), overlay: &mut *overlay })?;
    }
    main.submit(&mut WindowTarget { target, part_px: Some([divider, 0, width - divider, height]), overlay })
}

fn window_format(format: ash::vk::Format) -> WindowFormat {
    WindowFormat { format, driver_encodes: is_srgb(format) }
}
