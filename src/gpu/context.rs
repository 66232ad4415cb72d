//! An open GPU as the program holds it: the device, and the pipelines that all frames on it share.

use std::ffi::CStr;
use std::ops::Deref;
use std::sync::Arc;

use ash::vk;

use super::device::{Device, GpuOptions};
use super::instance::Instance;
use super::pipelines::Pipelines;
use crate::error::Result;

/// A device with the pipelines of its frames. Whatever takes a [`Device`] takes a `Gpu`.
pub struct Gpu {
    pub(super) pipelines: Pipelines,
    device: Arc<Device>,
}

impl Gpu {
    /// Opens a device.
    ///
    /// # Errors
    /// [`Error::NoDevice`](crate::Error::NoDevice) when no driver fits the baseline,
    /// [`Error::Usage`](crate::Error::Usage) when `select` names none.
    pub fn new(options: &GpuOptions) -> Result<Arc<Self>> {
        Self::open(options, Instance::new(options.validation)?, &[], &|_| None)
    }

    /// Opens a device of an instance with extensions enabled. `obstacle` names what a device lacks beyond the baseline.
    pub(super) fn open(
        options: &GpuOptions,
        instance: Instance,
        extensions: &[&CStr],
        obstacle: &dyn Fn(vk::PhysicalDevice) -> Option<&'static str>,
    ) -> Result<Arc<Self>> {
        let device = Device::open(options, instance, extensions, obstacle)?;
        let pipelines = Pipelines::new(&device, options.pipeline_folder.as_deref())?;
        Ok(Arc::new(Self { pipelines, device }))
    }
}

impl Deref for Gpu {
    type Target = Arc<Device>;

    fn deref(&self) -> &Self::Target {
        &self.device
    }
}
