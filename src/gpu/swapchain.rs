//! The images that a window shows, and their acquisition and presentation.

use std::sync::Arc;

use ash::{khr, vk};
use clap::ValueEnum;

use super::check;
use super::device::Device;
use super::surface::Surface;
use super::target::{FRAMES_IN_FLIGHT, Target};
use crate::error::{Error, Result};
use crate::settings::PresentMode;

/// Nanoseconds to wait for an image before a frame is given up: a hidden window may never give one.
const ACQUIRE_TIMEOUT_NS: u64 = 250_000_000;

/// Set to `srgb`, a surface format whose values the driver encodes is taken where there is one: how both kinds are
/// tested where a driver offers both.
const SURFACE_FORMAT: &str = "GRIDLIGHT_SURFACE_FORMAT";

/// Set to 1, every image that is shown counts as suboptimal: how that is tested where no driver says so.
const SUBOPTIMAL: &str = "GRIDLIGHT_SUBOPTIMAL";

/// What asking for an image gave.
pub enum Acquired {
    /// An image to draw to; give it to [`Swapchain::present`] once a frame into it is submitted.
    Image(Target),
    /// None in time: the window is hidden, or the display slow.
    NotYet,
    /// The swapchain no longer fits the window.
    Stale,
    /// The surface is gone: renew it.
    SurfaceLost,
}

/// How presenting an image went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presented {
    /// It is shown.
    Shown,
    /// It is shown, but a swapchain made anew might suit the window better: see [`Renewals`].
    Suboptimal,
    /// It may be shown, but the swapchain must be made anew.
    Stale,
    /// The surface is gone: renew it.
    SurfaceLost,
}

/// Images of a surface's present size and format.
pub struct Swapchain {
    raw: vk::SwapchainKHR,
    functions: khr::swapchain::Device,
    images: Vec<ShownImage>,
    /// One for each frame in flight: what an image's acquisition signals.
    acquired: Vec<vk::Semaphore>,
    /// Acquisitions whose frames were submitted.
    frames: usize,
    format: vk::Format,
    extent: vk::Extent2D,
    plants_suboptimal: bool,
    gpu: Arc<Device>,
}

/// Which suboptimal swapchains are made anew: one for each size of the window. Some drivers call every swapchain of a size
/// suboptimal, as on a turned display, and would have a new one in every frame.
#[derive(Debug, Default)]
pub struct Renewals {
    /// Size of the window for which a suboptimal swapchain has been made anew.
    tried_px: Option<[u32; 2]>,
}

impl Renewals {
    /// Whether the suboptimal swapchain of a window of this size is to be made anew; says so once.
    pub fn wants(&mut self, window_px: [u32; 2]) -> bool {
        self.tried_px.replace(window_px) != Some(window_px)
    }
}

#[derive(Clone, Copy)]
struct ShownImage {
    raw: vk::Image,
    view: vk::ImageView,
    /// Signalled by the frame, waited for by presentation. One for each image: it is free again when the image is
    /// acquired again, and not when the frame has completed.
    drawn: vk::Semaphore,
}

impl Surface {
    /// Format that a swapchain would have now.
    ///
    /// # Errors
    /// [`Error::NoDevice`] when no format is of use.
    pub fn format(&self) -> Result<vk::Format> {
        Ok(find_format(self)?.format)
    }

    /// Checks that the window has a present mode.
    ///
    /// # Errors
    /// [`Error::Usage`] with those that there are.
    pub fn check_mode(&self, mode: PresentMode) -> Result<()> {
        find_mode(self, mode).map(|_| ())
    }
}

impl Swapchain {
    /// Makes the images for a window of `size_px`, `None` while the window has no area.
    ///
    /// # Errors
    /// [`Error::Usage`] when the surface lacks the present mode, [`Error::NoDevice`] when it has no usable format;
    /// device errors.
    pub fn new(surface: &Surface, size_px: [u32; 2], mode: PresentMode) -> Result<Option<Self>> {
        let gpu = &surface.gpu;
        let mode = find_mode(surface, mode)?;
        let format = find_format(surface)?;
        // SAFETY: device and surface are of one instance.
        let limits = check("the surface's limits", unsafe {
            surface.functions.get_physical_device_surface_capabilities(gpu.physical, surface.raw)
        })?;
        let extent = extent(&limits, size_px);
        if extent.width == 0 || extent.height == 0 {
            return Ok(None);
        }
        // One more than the least, so that acquiring seldom waits for the display.
        let most = if limits.max_image_count == 0 { u32::MAX } else { limits.max_image_count };
        let info = vk::SwapchainCreateInfoKHR::default()
            .surface(surface.raw)
            .min_image_count((limits.min_image_count + 1).min(most))
            .image_format(format.format)
            .image_color_space(format.color_space)
            .image_extent(extent)
            .image_array_layers(1)
            .image_usage(vk::ImageUsageFlags::COLOR_ATTACHMENT)
            .pre_transform(limits.current_transform)
            .composite_alpha(find_alpha(limits.supported_composite_alpha))
            .present_mode(mode)
            .clipped(true);
        let functions = khr::swapchain::Device::new(&gpu.instance.raw, &gpu.device);
        // SAFETY: everything is as the surface says; no other swapchain of it is left.
        let raw = check("the swapchain", unsafe { functions.create_swapchain(&info, None) })?;
        let mut swapchain = Self {
            raw,
            functions,
            images: Vec::new(),
            acquired: Vec::new(),
            frames: 0,
            format: format.format,
            extent,
            plants_suboptimal: std::env::var_os(SUBOPTIMAL).is_some_and(|value| value == "1"),
            gpu: Arc::clone(gpu),
        };
        swapchain.create_images()?;
        log::info!("swapchain: {} images of {}x{}, {format:?}", swapchain.images.len(), extent.width, extent.height);
        Ok(Some(swapchain))
    }

    /// Format of the images.
    #[must_use]
    pub fn format(&self) -> vk::Format {
        self.format
    }

    /// Size of the images.
    #[must_use]
    pub fn size_px(&self) -> [u32; 2] {
        [self.extent.width, self.extent.height]
    }

    /// Asks for the next image. At most [`FRAMES_IN_FLIGHT`] - 1 frames may be under way.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn acquire(&self) -> Result<Acquired> {
        let acquired = self.acquired[self.frames % self.acquired.len()];
        // SAFETY: the frame that last waited for the semaphore has completed.
        let result =
            unsafe { self.functions.acquire_next_image(self.raw, ACQUIRE_TIMEOUT_NS, acquired, vk::Fence::null()) };
        match result {
            // Suboptimal images can be shown; presentation says so again.
            Ok((index, _)) => {
                let ShownImage { raw, view, drawn } = self.images[index as usize];
                Ok(Acquired::Image(Target { index, image: raw, view, extent: self.extent, acquired, drawn }))
            }
            Err(vk::Result::TIMEOUT | vk::Result::NOT_READY) => Ok(Acquired::NotYet),
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => Ok(Acquired::Stale),
            Err(vk::Result::ERROR_SURFACE_LOST_KHR) => Ok(Acquired::SurfaceLost),
            Err(result) => check("vkAcquireNextImageKHR", Err(result)),
        }
    }

    /// Shows an image that a submitted frame draws to.
    ///
    /// # Errors
    /// When the device is lost.
    #[expect(clippy::needless_pass_by_value, reason = "an acquired image is presented once")]
    pub fn present(&mut self, target: Target) -> Result<Presented> {
        self.frames += 1;
        let (waits, swapchains, indices) = ([target.drawn], [self.raw], [target.index]);
        let info =
            vk::PresentInfoKHR::default().wait_semaphores(&waits).swapchains(&swapchains).image_indices(&indices);
        let _queue = self.gpu.lock_queue();
        // SAFETY: nobody else uses the queue meanwhile; the frame that signals the semaphore is submitted and leaves the image in the layout to present.
        match unsafe { self.functions.queue_present(self.gpu.queue, &info) } {
            Ok(false) if self.plants_suboptimal => Ok(Presented::Suboptimal),
            Ok(false) => Ok(Presented::Shown),
            Ok(true) => Ok(Presented::Suboptimal),
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => Ok(Presented::Stale),
            Err(vk::Result::ERROR_SURFACE_LOST_KHR) => Ok(Presented::SurfaceLost),
            Err(result) => check("vkQueuePresentKHR", Err(result)),
        }
    }

    fn create_images(&mut self) -> Result<()> {
        // SAFETY: the swapchain is alive.
        let images = check("the swapchain's images", unsafe { self.functions.get_swapchain_images(self.raw) })?;
        for (index, raw) in images.into_iter().enumerate() {
            self.gpu.set_name(raw, &format!("window image {index}"));
            let view = self.create_view(raw)?;
            self.images.push(ShownImage { raw, view, drawn: vk::Semaphore::null() });
            let drawn = self.create_semaphore(&format!("window image {index} drawn"))?;
            if let Some(last) = self.images.last_mut() {
                last.drawn = drawn;
            }
        }
        for index in 0..FRAMES_IN_FLIGHT {
            let semaphore = self.create_semaphore(&format!("image acquired {index}"))?;
            self.acquired.push(semaphore);
        }
        Ok(())
    }

    fn create_view(&self, image: vk::Image) -> Result<vk::ImageView> {
        let info = vk::ImageViewCreateInfo::default()
            .image(image)
            .view_type(vk::ImageViewType::TYPE_2D)
            .format(self.format)
            .subresource_range(vk::ImageSubresourceRange {
                aspect_mask: vk::ImageAspectFlags::COLOR,
                base_mip_level: 0,
                level_count: 1,
                base_array_layer: 0,
                layer_count: 1,
            });
        // SAFETY: the image is the swapchain's.
        check("a view of the window", unsafe { self.gpu.device.create_image_view(&info, None) })
    }

    fn create_semaphore(&self, name: &str) -> Result<vk::Semaphore> {
        // SAFETY: valid create info; destroyed in `drop`.
        let semaphore =
            check(name, unsafe { self.gpu.device.create_semaphore(&vk::SemaphoreCreateInfo::default(), None) })?;
        self.gpu.set_name(semaphore, name);
        Ok(semaphore)
    }
}

impl Drop for Swapchain {
    fn drop(&mut self) {
        // Presentation has no fence of its own; an idle queue has taken up its semaphores.
        if let Err(error) = self.gpu.wait_idle() {
            log::error!("waiting for the GPU: {error}");
        }
        // SAFETY: the GPU is idle; null handles are ignored.
        unsafe {
            for image in &self.images {
                self.gpu.device.destroy_image_view(image.view, None);
                self.gpu.device.destroy_semaphore(image.drawn, None);
            }
            for semaphore in &self.acquired {
                self.gpu.device.destroy_semaphore(*semaphore, None);
            }
            self.functions.destroy_swapchain(self.raw, None);
        }
    }
}

/// Whether the driver encodes what is written to such images, so that linear values must be written.
#[must_use]
pub fn is_srgb(format: vk::Format) -> bool {
    matches!(format, vk::Format::B8G8R8A8_SRGB | vk::Format::R8G8B8A8_SRGB | vk::Format::A8B8G8R8_SRGB_PACK32)
}

/// The window's size, as far as the surface does not set its own.
fn extent(limits: &vk::SurfaceCapabilitiesKHR, size_px: [u32; 2]) -> vk::Extent2D {
    if limits.current_extent.width != u32::MAX {
        return limits.current_extent;
    }
    let (least, most) = (limits.min_image_extent, limits.max_image_extent);
    if size_px.contains(&0) {
        return vk::Extent2D::default();
    }
    vk::Extent2D {
        width: size_px[0].clamp(least.width, most.width),
        height: size_px[1].clamp(least.height, most.height),
    }
}

fn find_mode(surface: &Surface, wanted: PresentMode) -> Result<vk::PresentModeKHR> {
    // SAFETY: device and surface are of one instance.
    let offered = check("the surface's present modes", unsafe {
        surface.functions.get_physical_device_surface_present_modes(surface.gpu.physical, surface.raw)
    })?;
    let raw = |mode| match mode {
        PresentMode::Fifo => vk::PresentModeKHR::FIFO,
        PresentMode::FifoRelaxed => vk::PresentModeKHR::FIFO_RELAXED,
        PresentMode::Mailbox => vk::PresentModeKHR::MAILBOX,
        PresentMode::Immediate => vk::PresentModeKHR::IMMEDIATE,
    };
    if offered.contains(&raw(wanted)) {
        return Ok(raw(wanted));
    }
    let names: Vec<String> = PresentMode::value_variants()
        .iter()
        .filter(|mode| offered.contains(&raw(**mode)))
        .map(crate::settings::name)
        .collect();
    Err(Error::Usage(format!(
        "--present-mode {} is not offered for this window; there are {}",
        crate::settings::name(&wanted),
        names.join(", ")
    )))
}

/// Values that are shown as they are come first: the panel blends its edges in them.
fn find_format(surface: &Surface) -> Result<vk::SurfaceFormatKHR> {
    // SAFETY: device and surface are of one instance.
    let offered = check("the surface's formats", unsafe {
        surface.functions.get_physical_device_surface_formats(surface.gpu.physical, surface.raw)
    })?;
    let mut known = [
        vk::Format::B8G8R8A8_UNORM,
        vk::Format::R8G8B8A8_UNORM,
        vk::Format::A8B8G8R8_UNORM_PACK32,
        vk::Format::B8G8R8A8_SRGB,
        vk::Format::R8G8B8A8_SRGB,
        vk::Format::A8B8G8R8_SRGB_PACK32,
    ];
    if std::env::var_os(SURFACE_FORMAT).is_some_and(|wanted| wanted == "srgb") {
        known.rotate_left(3);
    }
    let fits = |wanted| {
        offered.iter().find(|f| f.format == wanted && f.color_space == vk::ColorSpaceKHR::SRGB_NONLINEAR).copied()
    };
    known.into_iter().find_map(fits).ok_or_else(|| {
        Error::NoDevice(
            "the window's surface has no 8-bit sRGB format: add --headless to render without a window".to_owned(),
        )
    })
}

/// Opaque where there is a choice.
fn find_alpha(offered: vk::CompositeAlphaFlagsKHR) -> vk::CompositeAlphaFlagsKHR {
    let known = [
        vk::CompositeAlphaFlagsKHR::OPAQUE,
        vk::CompositeAlphaFlagsKHR::INHERIT,
        vk::CompositeAlphaFlagsKHR::PRE_MULTIPLIED,
        vk::CompositeAlphaFlagsKHR::POST_MULTIPLIED,
    ];
    known.into_iter().find(|alpha| offered.contains(*alpha)).unwrap_or(vk::CompositeAlphaFlagsKHR::OPAQUE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_suboptimal_swapchain_is_made_anew_once_for_each_size() {
        let mut renewals = Renewals::default();
        let sizes = [[800, 600], [800, 600], [800, 600], [600, 800], [600, 800], [800, 600], [800, 600]];
        let made: Vec<bool> = sizes.into_iter().map(|size| renewals.wants(size)).collect();
        assert_eq!(made, [true, false, false, true, false, true, false]);
    }
}
