//! Functions of the extensions that tell more of a lost device, where there are any.

use std::ffi::{CStr, c_char, c_void};

use ash::{amd, ext, nv, vk};

use super::features::OptionalFeatures;
use super::instance::Instance;
use super::loss::DeviceFault;

/// The functions of those that are in use.
pub(super) struct Diagnostics {
    pub buffer_marker: Option<amd::buffer_marker::Device>,
    checkpoints: Option<nv::device_diagnostic_checkpoints::Device>,
    fault: Option<ext::device_fault::Device>,
}

/// Extensions to be enabled for the features.
pub(super) fn extensions(features: OptionalFeatures) -> impl Iterator<Item = &'static CStr> {
    let all = [
        (features.buffer_marker, amd::buffer_marker::NAME),
        (features.checkpoints, nv::device_diagnostic_checkpoints::NAME),
        (features.device_fault, ext::device_fault::NAME),
    ];
    all.into_iter().filter_map(|(found, name)| found.then_some(name))
}

impl Diagnostics {
    /// For a device on which the extensions of these features are enabled.
    pub fn new(instance: &Instance, device: &ash::Device, features: OptionalFeatures) -> Self {
        let raw = &instance.raw;
        Self {
            buffer_marker: features.buffer_marker.then(|| amd::buffer_marker::Device::new(raw, device)),
            checkpoints: features.checkpoints.then(|| nv::device_diagnostic_checkpoints::Device::new(raw, device)),
            fault: features.device_fault.then(|| ext::device_fault::Device::new(raw, device)),
        }
    }

    /// Records a checkpoint: a number that the driver keeps as a pointer and gives back.
    pub fn set_checkpoint(&self, commands: vk::CommandBuffer, number: usize) {
        let Some(checkpoints) = &self.checkpoints else { return };
        // SAFETY: the command buffer records; the driver does not follow the pointer.
        unsafe { checkpoints.cmd_set_checkpoint(commands, number as *const c_void) };
    }

    /// Stages of the queue of a lost device, each with the last checkpoint that it has reached.
    pub fn checkpoints(&self, queue: vk::Queue) -> Vec<(vk::PipelineStageFlags, usize)> {
        let Some(checkpoints) = &self.checkpoints else { return Vec::new() };
        // SAFETY: the queue belongs to the device, which is lost and used from this thread only.
        let count = unsafe { checkpoints.get_queue_checkpoint_data_len(queue) };
        let mut data = vec![vk::CheckpointDataNV::default(); count];
        // SAFETY: the same; there is room for as many as the driver says there are.
        unsafe { checkpoints.get_queue_checkpoint_data(queue, &mut data) };
        data.iter().map(|d| (d.stage, d.p_checkpoint_marker as usize)).collect()
    }

    /// What the driver of a lost device knows of the fault.
    pub fn fault(&self) -> Option<DeviceFault> {
        let fault = self.fault.as_ref()?;
        let mut counts = vk::DeviceFaultCountsEXT::default();
        let get = fault.fp().get_device_fault_info_ext;
        // SAFETY: the device is lost; without a place for them only counts are written.
        let counted = unsafe { get(fault.device(), &raw mut counts, std::ptr::null_mut()) };
        if counted != vk::Result::SUCCESS {
            return None;
        }
        // The vendor's binary is for the vendor's tools.
        counts.vendor_binary_size = 0;
        let mut addresses = vec![vk::DeviceFaultAddressInfoEXT::default(); counts.address_info_count as usize];
        let mut vendor = vec![vk::DeviceFaultVendorInfoEXT::default(); counts.vendor_info_count as usize];
        let mut info = vk::DeviceFaultInfoEXT {
            p_address_infos: addresses.as_mut_ptr(),
            p_vendor_infos: vendor.as_mut_ptr(),
            ..vk::DeviceFaultInfoEXT::default()
        };
        // SAFETY: the same; both arrays have as many elements as `counts` says, and outlive the call.
        let read = unsafe { get(fault.device(), &raw mut counts, &raw mut info) };
        if !matches!(read, vk::Result::SUCCESS | vk::Result::INCOMPLETE) {
            return None;
        }
        addresses.truncate(counts.address_info_count as usize);
        vendor.truncate(counts.vendor_info_count as usize);
        let vendor = vendor.iter().map(|v| (text(&v.description), v.vendor_fault_code, v.vendor_fault_data)).collect();
        Some(DeviceFault { description: text(&info.description), addresses, vendor })
    }
}

/// A driver's text up to its end, or all of it where it has none.
fn text(chars: &[c_char]) -> String {
    let bytes: Vec<u8> = chars.iter().map(|c| *c as u8).take_while(|byte| *byte != 0).collect();
    String::from_utf8_lossy(&bytes).trim().to_owned()
}
