//! The part of a window that Vulkan draws to.

use std::ffi::CStr;
use std::sync::Arc;

use ash::{khr, vk};
use raw_window_handle::{HasDisplayHandle, HasWindowHandle};

use super::check;
use super::context::Gpu;
use super::device::GpuOptions;
use super::features::queue_family;
use super::instance::Instance;
use crate::error::{Error, Result};

/// Anything with a window handle, such as a window of winit.
pub trait WindowSource: HasDisplayHandle + HasWindowHandle {}

impl<T: HasDisplayHandle + HasWindowHandle> WindowSource for T {}

/// A surface of a window on an open device. Keeps both alive.
pub struct Surface {
    pub(super) raw: vk::SurfaceKHR,
    pub(super) functions: khr::surface::Instance,
    window: Arc<dyn WindowSource>,
    /// Frames until the surface counts as lost.
    frames_to_loss: Option<u32>,
    pub(super) gpu: Arc<Gpu>,
}

/// Set to a number, the surface counts as lost before that frame, once: how that is tested where no driver loses one.
const LOSE_SURFACE: &str = "GRIDLIGHT_LOSE_SURFACE";

impl Surface {
    /// Opens a device that can present to the window.
    ///
    /// # Errors
    /// Those of [`Gpu::new`]; [`Error::NoDevice`] when the driver or every device lacks surfaces or swapchains.
    pub fn open(options: &GpuOptions, window: Arc<dyn WindowSource>) -> Result<Self> {
        let display = window.display_handle().map_err(|error| no_handle(&error))?;
        let names = ash_window::enumerate_required_extensions(display.as_raw())
            .map_err(|result| Error::Vulkan { what: "the window's surface extensions".to_owned(), result })?;
        // SAFETY: the list consists of static NUL-terminated names.
        let names: Vec<&CStr> = names.iter().map(|name| unsafe { CStr::from_ptr(*name) }).collect();
        let instance = Instance::with_extensions(options.validation, &names)?;
        let functions = khr::surface::Instance::new(&instance.entry, &instance.raw);
        let raw = create(&instance, &*window)?;
        let raw_instance = instance.raw.clone();
        let obstacle = |device| obstacle(&raw_instance, &functions, raw, device);
        let gpu = Gpu::open(options, instance, &[khr::swapchain::NAME], &obstacle)?;
        let frames_to_loss = std::env::var(LOSE_SURFACE).ok().and_then(|number| number.parse().ok());
        Ok(Self { raw, functions, window, frames_to_loss, gpu })
    }

    /// The device that presents.
    #[must_use]
    pub fn gpu(&self) -> &Arc<Gpu> {
        &self.gpu
    }

    /// Whether the surface is to be taken for lost now; asked once before each frame.
    pub fn is_loss_planted(&mut self) -> bool {
        match &mut self.frames_to_loss {
            Some(0) => self.frames_to_loss.take().is_some(),
            Some(frames) => {
                *frames -= 1;
                false
            }
            None => false,
        }
    }

    /// Makes the surface anew after it was lost. No swapchain of it may be left.
    ///
    /// # Errors
    /// When the system gives no surface.
    pub fn renew(&mut self) -> Result<()> {
        self.gpu.wait_idle()?;
        // SAFETY: the GPU is idle and the caller has dropped the swapchain.
        unsafe { self.functions.destroy_surface(self.raw, None) };
        self.raw = vk::SurfaceKHR::null();
        self.raw = create(&self.gpu.instance, &*self.window)?;
        Ok(())
    }
}

impl Drop for Surface {
    fn drop(&mut self) {
        // SAFETY: swapchains are dropped before their surface; the instance lives as long as the device.
        unsafe { self.functions.destroy_surface(self.raw, None) };
    }
}

fn create(instance: &Instance, window: &dyn WindowSource) -> Result<vk::SurfaceKHR> {
    let display = window.display_handle().map_err(|error| no_handle(&error))?.as_raw();
    let handle = window.window_handle().map_err(|error| no_handle(&error))?.as_raw();
    // SAFETY: the handles belong to one live window, which the surface's owner keeps; the extensions are enabled.
    check("the window's surface", unsafe {
        ash_window::create_surface(&instance.entry, &instance.raw, display, handle, None)
    })
}

fn no_handle(error: &raw_window_handle::HandleError) -> Error {
    Error::Failure(format!("the window cannot be drawn to ({error}): add --headless to render without one"))
}

/// What keeps a device from presenting to a surface.
fn obstacle(
    instance: &ash::Instance,
    functions: &khr::surface::Instance,
    surface: vk::SurfaceKHR,
    device: vk::PhysicalDevice,
) -> Option<&'static str> {
    // SAFETY: the device is of this instance.
    let extensions = unsafe { instance.enumerate_device_extension_properties(device) }.unwrap_or_default();
    if !extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(khr::swapchain::NAME)) {
        return Some("VK_KHR_swapchain, which a window needs (add --headless to render without one)");
    }
    let family = queue_family(instance, device)?;
    // SAFETY: device and surface are of this instance, the family exists.
    let supported = unsafe { functions.get_physical_device_surface_support(device, family, surface) };
    if supported == Ok(true) {
        return None;
    }
    Some("a way to show pictures in this window (add --headless to render without one)")
}
