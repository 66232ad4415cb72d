//! The logical device with its queue and memory allocator.

use std::ffi::CStr;
use std::mem::ManuallyDrop;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard};

use ash::{ext, khr, vk};
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};

use super::check;
use super::diagnostics::{self, Diagnostics};
use super::features::{self, DeviceReport, OptionalFeatures};
use super::instance::{Instance, Messages};
use crate::error::{Error, Result};

/// Which device to open, and how.
#[derive(Clone, Debug, Default)]
pub struct GpuOptions {
    /// Index in `--list-gpus`, or a case-insensitive part of the name; `None` picks the fastest kind.
    pub select: Option<String>,
    /// Enable core and synchronization validation.
    pub validation: bool,
    /// Treat every optional feature as missing: how the fallbacks are tested.
    pub baseline_only: bool,
    /// Folder where the driver's compiled pipelines are kept from run to run; `None` keeps none.
    pub pipeline_folder: Option<PathBuf>,
}

/// The messages of the validation layers; outlives the device, whose end may be reported too.
pub struct ValidationLog(Messages);

impl ValidationLog {
    /// Fails when there is any message.
    ///
    /// # Errors
    /// [`Error::Validation`] with the first message.
    pub fn check(&self) -> Result<()> {
        let messages = self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        match messages.first() {
            Some(first) => Err(Error::Validation { count: messages.len(), first: first.clone() }),
            None => Ok(()),
        }
    }
}

/// An open device, its queue and its memory: all that buffers, images and pipelines are made with. Each of them keeps it
/// alive.
pub struct Device {
    pub(super) device: ash::Device,
    pub(super) queue: vk::Queue,
    pub(super) queue_family: u32,
    /// Held by whoever uses the queue: threads that measure and the one that renders share it.
    queue_use: Mutex<()>,
    pub(super) debug: Option<ext::debug_utils::Device>,
    /// Functions of acceleration structures, where there are ray queries.
    pub(super) acceleration: Option<khr::acceleration_structure::Device>,
    pub(super) diagnostics: Diagnostics,
    /// Shared with the painter of the window's panel.
    pub(super) allocator: ManuallyDrop<Arc<Mutex<Allocator>>>,
    report: DeviceReport,
    pub(super) physical: vk::PhysicalDevice,
    pub(super) instance: Instance,
}

impl Device {
    /// Opens a device of an instance with extensions enabled. `obstacle` names what a device lacks beyond the baseline.
    pub(super) fn open(
        options: &GpuOptions,
        instance: Instance,
        extensions: &[&CStr],
        obstacle: &dyn Fn(vk::PhysicalDevice) -> Option<&'static str>,
    ) -> Result<Arc<Self>> {
        let (physical, mut report) = select(&instance, options.select.as_deref(), obstacle)?;
        if options.baseline_only {
            report.optional = OptionalFeatures::default();
        }
        let queue_family = features::queue_family(&instance.raw, physical)
            .ok_or_else(|| Error::NoDevice(format!("{} has no queue for graphics and compute", report.name)))?;
        let device = create_device(&instance, physical, queue_family, &report, extensions)?;
        // SAFETY: family and index were requested at device creation.
        let queue = unsafe { device.get_device_queue(queue_family, 0) };
        let debug = instance.has_debug_utils.then(|| ext::debug_utils::Device::new(&instance.raw, &device));
        let ray_query = report.optional.ray_query;
        let acceleration = ray_query.then(|| khr::acceleration_structure::Device::new(&instance.raw, &device));
        let diagnostics = Diagnostics::new(&instance, &device, report.optional);
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.raw.clone(),
            device: device.clone(),
            physical_device: physical,
            debug_settings: gpu_allocator::AllocatorDebugSettings::default(),
            buffer_device_address: ray_query,
            allocation_sizes: gpu_allocator::AllocationSizes::default(),
        })
        .map_err(|e| Error::Memory { name: "the allocator".to_owned(), reason: e.to_string() })?;
        log::info!("device: {} ({})", report.name, report.driver);
        let allocator = ManuallyDrop::new(Arc::new(Mutex::new(allocator)));
        Ok(Arc::new(Self {
            device,
            queue,
            queue_family,
            queue_use: Mutex::new(()),
            debug,
            acceleration,
            diagnostics,
            allocator,
            report,
            physical,
            instance,
        }))
    }

    /// What the device is and offers.
    #[must_use]
    pub fn report(&self) -> &DeviceReport {
        &self.report
    }

    /// Optional features in use.
    #[must_use]
    pub fn features(&self) -> OptionalFeatures {
        self.report.optional
    }

    /// Validation messages so far, warnings and errors.
    #[must_use]
    pub fn validation_messages(&self) -> Vec<String> {
        self.instance.messages()
    }

    /// The messages of the validation layers, for when the device is gone.
    #[must_use]
    pub fn validation_log(&self) -> ValidationLog {
        ValidationLog(self.instance.message_log())
    }

    /// Fails when validation reported anything.
    ///
    /// # Errors
    /// [`Error::Validation`] with the first message.
    pub fn check_validation(&self) -> Result<()> {
        self.validation_log().check()
    }

    /// Bytes of device memory now reserved from the driver.
    #[must_use]
    pub fn reserved_bytes(&self) -> u64 {
        self.allocator().capacity()
    }

    /// Checks that the device has images of this kind and size.
    ///
    /// # Errors
    /// [`Error::Failure`] that says what it was asked for.
    pub(super) fn check_image(&self, name: &str, create: &vk::ImageCreateInfo<'_>) -> Result<()> {
        let info = vk::PhysicalDeviceImageFormatInfo2::default()
            .format(create.format)
            .ty(create.image_type)
            .tiling(create.tiling)
            .usage(create.usage)
            .flags(create.flags);
        let mut properties = vk::ImageFormatProperties2::default();
        let raw = &self.instance.raw;
        // SAFETY: valid query of this instance's physical device.
        let found = unsafe { raw.get_physical_device_image_format_properties2(self.physical, &info, &mut properties) };
        let most = properties.image_format_properties;
        let vk::Extent3D { width, height, depth } = create.extent;
        let fits = found.is_ok()
            && width <= most.max_extent.width
            && height <= most.max_extent.height
            && depth <= most.max_extent.depth
            && create.mip_levels <= most.max_mip_levels
            && create.array_layers <= most.max_array_layers;
        if fits {
            return Ok(());
        }
        Err(Error::Failure(format!(
            "this device has no image `{name}`: {width}x{height}x{depth} texels, {} layers, {} levels of {:?} for {:?}",
            create.array_layers, create.mip_levels, create.format, create.usage
        )))
    }

    /// Blocks until the device is idle. Never called inside a frame.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn wait_idle(&self) -> Result<()> {
        let _queue = self.lock_queue();
        // SAFETY: the device is alive, and nobody else uses its queue meanwhile.
        check("vkDeviceWaitIdle", unsafe { self.device.device_wait_idle() })
    }

    /// Keeps others from the queue as long as the guard lives.
    pub(super) fn lock_queue(&self) -> MutexGuard<'_, ()> {
        self.queue_use.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    pub(super) fn allocator(&self) -> MutexGuard<'_, Allocator> {
        self.allocator.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    /// Gives an object its debug name.
    pub(super) fn set_name<T: vk::Handle>(&self, object: T, name: &str) {
        let (Some(debug), Ok(name)) = (&self.debug, std::ffi::CString::new(name)) else { return };
        let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(object).object_name(&name);
        // SAFETY: the object belongs to this device; failure to name it is harmless.
        let _ = unsafe { debug.set_debug_utils_object_name(&info) };
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: every object created from the device holds an `Arc<Device>`, so all are gone by now; the
        // allocator is dropped exactly once, before its device.
        unsafe {
            let _ = self.device.device_wait_idle();
            let leaked = self.allocator().generate_report().allocations.len();
            let level = if leaked == 0 { log::Level::Info } else { log::Level::Error };
            log::log!(level, "device memory: {leaked} allocations leaked");
            ManuallyDrop::drop(&mut self.allocator);
            self.device.destroy_device(None);
        }
    }
}

fn rank(kind: &str) -> u8 {
    match kind {
        "discrete gpu" => 0,
        "integrated gpu" => 1,
        "virtual gpu" => 2,
        "cpu" => 3,
        _ => 4,
    }
}

fn select(
    instance: &Instance,
    wanted: Option<&str>,
    obstacle: &dyn Fn(vk::PhysicalDevice) -> Option<&'static str>,
) -> Result<(vk::PhysicalDevice, DeviceReport)> {
    let examine = |device| {
        let mut report = features::report(instance, device);
        if report.missing.is_empty() {
            report.missing.extend(obstacle(device));
        }
        (device, report)
    };
    let mut found: Vec<_> = instance.physical_devices()?.into_iter().map(examine).collect();
    let names = found.iter().enumerate().map(|(i, (_, r))| format!("{i}: {}", r.name)).collect::<Vec<_>>().join(", ");
    if let Some(wanted) = wanted {
        let index = wanted
            .parse::<usize>()
            .ok()
            .filter(|i| *i < found.len())
            .or_else(|| found.iter().position(|(_, r)| r.name.to_lowercase().contains(&wanted.to_lowercase())));
        let index = index.ok_or_else(|| Error::Usage(format!("--gpu {wanted} names no device; there are {names}")))?;
        let (device, report) = found.swap_remove(index);
        return match report.missing.as_slice() {
            [] => Ok((device, report)),
            missing => Err(Error::NoDevice(format!("{} lacks {}", report.name, missing.join(", ")))),
        };
    }
    let lacking: Vec<String> =
        found.iter().map(|(_, r)| format!("{} lacks {}", r.name, r.missing.join(", "))).collect();
    found.retain(|(_, r)| r.missing.is_empty());
    found.sort_by_key(|(_, r)| rank(r.kind));
    if found.is_empty() {
        return Err(Error::NoDevice(format!("no Vulkan device fits: {}", lacking.join("; "))));
    }
    Ok(found.swap_remove(0))
}

fn create_device(
    instance: &Instance,
    physical: vk::PhysicalDevice,
    queue_family: u32,
    report: &DeviceReport,
    extensions: &[&CStr],
) -> Result<ash::Device> {
    let optional = report.optional;
    let mut extensions: Vec<_> = extensions.iter().map(|name| name.as_ptr()).collect();
    if report.is_portability_subset {
        // Must be enabled where it is offered. Of its features none is: nothing here uses one.
        extensions.push(khr::portability_subset::NAME.as_ptr());
    }
    let priorities = [1.0];
    let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(queue_family).queue_priorities(&priorities)];
    let core = vk::PhysicalDeviceFeatures::default()
        .fragment_stores_and_atomics(true)
        .sampler_anisotropy(optional.anisotropy)
        .shader_int64(optional.int64_atomics);
    let mut v12 = vk::PhysicalDeviceVulkan12Features::default()
        .timeline_semaphore(true)
        .shader_buffer_int64_atomics(optional.int64_atomics)
        .buffer_device_address(optional.ray_query);
    let mut v13 = vk::PhysicalDeviceVulkan13Features::default()
        .dynamic_rendering(true)
        .synchronization2(true)
        .shader_demote_to_helper_invocation(true);
    let mut features = vk::PhysicalDeviceFeatures2::default().features(core).push_next(&mut v12).push_next(&mut v13);
    let mut structure = vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default().acceleration_structure(true);
    let mut query = vk::PhysicalDeviceRayQueryFeaturesKHR::default().ray_query(true);
    if optional.ray_query {
        extensions.extend(features::RAY_QUERY_EXTENSIONS.map(std::ffi::CStr::as_ptr));
        features = features.push_next(&mut structure).push_next(&mut query);
    }
    extensions.extend(diagnostics::extensions(optional).map(CStr::as_ptr));
    let mut fault = vk::PhysicalDeviceFaultFeaturesEXT::default().device_fault(true);
    if optional.device_fault {
        features = features.push_next(&mut fault);
    }
    let info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_extension_names(&extensions)
        .push_next(&mut features);
    // SAFETY: only features reported by the device are enabled; pointers outlive the call.
    check("vkCreateDevice", unsafe { instance.raw.create_device(physical, &info, None) })
}
