//! What a device offers: the portability baseline, and the optional features with their fallbacks.

use std::ffi::CStr;

use ash::{amd, ext, khr, nv, vk};

use super::instance::Instance;
use super::stage_limits::StageLimits;
use crate::error::Result;
use crate::scene::Vertex;

/// Optional features. Each has a tested fallback; none is assumed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OptionalFeatures {
    /// 64-bit integers and 64-bit atomics on storage buffers: `--reservoir exact`. Fallback: `lock`.
    pub int64_atomics: bool,
    /// Additive blending on `R32G32B32A32_SFLOAT`. Fallback: `R16G16B16A16_SFLOAT`.
    pub blend_rgba32f: bool,
    /// Anisotropic filtering in the G-buffer. Fallback: trilinear.
    pub anisotropy: bool,
    /// Acceleration structures and ray queries: `--rays query`. Fallback: the BVH in shaders.
    pub ray_query: bool,
    /// Words written at any place of a command buffer, for crash markers. Fallback: `checkpoints`.
    pub buffer_marker: bool,
    /// Checkpoints that the driver keeps, for crash markers. Fallback: words filled between barriers.
    pub checkpoints: bool,
    /// What the driver knows of the fault of a lost device. Fallback: nothing of it is told.
    pub device_fault: bool,
}

/// One physical device, described for `--list-gpus` and the timings.
#[derive(Clone, Debug)]
pub struct DeviceReport {
    /// Device name.
    pub name: String,
    /// Driver name and version text.
    pub driver: String,
    /// API version, as `1.3.230`.
    pub api_version: String,
    /// Kind of device, as `cpu` or `discrete gpu`.
    pub kind: &'static str,
    /// PCI vendor.
    pub vendor_id: u32,
    /// PCI device.
    pub device_id: u32,
    /// The vendor's number of the driver version.
    pub driver_version: u32,
    /// Required features the device lacks; empty means gridlight runs on it.
    pub missing: Vec<&'static str>,
    /// Whether it is only a portability subset of Vulkan, as with MoltenVK. What such a device may lack is not used.
    pub is_portability_subset: bool,
    /// Optional features found.
    pub optional: OptionalFeatures,
    /// Limits.
    pub limits: Limits,
}

impl DeviceReport {
    /// Whether the driver renders on the CPU.
    #[must_use]
    pub fn is_cpu(&self) -> bool {
        self.kind == "cpu"
    }
}

/// The limits gridlight relies on.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Largest storage buffer range in bytes.
    pub storage_range_bytes: u64,
    /// Most memory that is given at once, in bytes.
    pub allocation_bytes: u64,
    /// Largest image edge in texels that also is a valid attachment.
    pub image_edge_px: u32,
    /// Most rows of a sampled image.
    pub image_rows: u32,
    /// Most layers of an image array.
    pub array_layers: u32,
    /// Most workgroups per dimension of a dispatch.
    pub dispatch_groups: u32,
    /// Most triangles in an acceleration structure; 0 without ray queries.
    pub structure_triangles: u64,
    /// Alignment of the memory that builds of acceleration structures work in.
    pub scratch_alignment: u32,
    /// Nanoseconds per timestamp tick.
    pub timestamp_period_ns: f32,
    /// Bits of a timestamp that count, of the queue in use; 0 without such a queue.
    pub timestamp_bits: u32,
    /// Most bindings of each kind that a stage of a pass may have.
    pub stage: StageLimits,
    /// Bits of a vertex position within a pixel.
    pub subpixel_bits: u32,
    /// Invocations in a subgroup.
    pub subgroup_size: u32,
}

impl OptionalFeatures {
    /// Each feature as (name, found, what is used without it).
    #[must_use]
    pub fn rows(&self) -> [(&'static str, bool, &'static str); 7] {
        [
            ("64-bit buffer atomics", self.int64_atomics, "--reservoir lock instead of exact"),
            ("rgba32f blending", self.blend_rgba32f, "rgba16f lighting target"),
            ("anisotropic filtering", self.anisotropy, "trilinear filtering"),
            ("ray queries", self.ray_query, "--rays bvh instead of query"),
            ("AMD buffer markers", self.buffer_marker, "checkpoints or fills as crash markers"),
            ("NVIDIA checkpoints", self.checkpoints, "fills as crash markers"),
            ("device fault reports", self.device_fault, "a lost device names its passes only"),
        ]
    }
}

/// What ray queries need beyond the baseline.
pub(super) const RAY_QUERY_EXTENSIONS: [&CStr; 3] =
    [khr::acceleration_structure::NAME, khr::ray_query::NAME, khr::deferred_host_operations::NAME];

/// Whether a device has all of some extensions.
fn has_extensions(instance: &Instance, device: vk::PhysicalDevice, names: &[&CStr]) -> bool {
    // SAFETY: `device` comes from this instance.
    let found = unsafe { instance.raw.enumerate_device_extension_properties(device) }.unwrap_or_default();
    names.iter().all(|name| found.iter().any(|e| e.extension_name_as_c_str() == Ok(*name)))
}

/// Queue family that can do everything the program needs, with timestamps.
pub(super) fn queue_family(instance: &ash::Instance, device: vk::PhysicalDevice) -> Option<u32> {
    let wanted = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
    let families = queue_families(instance, device);
    let index = families.iter().position(|f| f.queue_flags.contains(wanted) && f.timestamp_valid_bits > 0)?;
    u32::try_from(index).ok()
}

fn queue_families(instance: &ash::Instance, device: vk::PhysicalDevice) -> Vec<vk::QueueFamilyProperties> {
    // SAFETY: `device` comes from this instance.
    unsafe { instance.get_physical_device_queue_family_properties(device) }
}

fn timestamp_bits(instance: &ash::Instance, device: vk::PhysicalDevice) -> u32 {
    let family = queue_family(instance, device).map(|index| queue_families(instance, device)[index as usize]);
    family.map_or(0, |family| family.timestamp_valid_bits)
}

/// Every physical device with what it offers, in the order `--gpu INDEX` counts them.
///
/// # Errors
/// [`Error::NoDevice`](crate::Error::NoDevice) without a loader or driver.
pub fn list_gpus() -> Result<Vec<DeviceReport>> {
    let instance = Instance::new(false)?;
    Ok(instance.physical_devices()?.into_iter().map(|device| report(&instance, device)).collect())
}

/// Examines one physical device.
pub(super) fn report(instance: &Instance, device: vk::PhysicalDevice) -> DeviceReport {
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    let mut subgroup = vk::PhysicalDeviceSubgroupProperties::default();
    let mut structures = vk::PhysicalDeviceAccelerationStructurePropertiesKHR::default();
    let mut memory = vk::PhysicalDeviceMaintenance3Properties::default();
    let mut portability = vk::PhysicalDevicePortabilitySubsetPropertiesKHR::default();
    let is_portability_subset = has_extensions(instance, device, &[khr::portability_subset::NAME]);
    let properties = vk::PhysicalDeviceProperties2::default();
    let mut properties = properties.push_next(&mut driver).push_next(&mut subgroup).push_next(&mut memory);
    if has_extensions(instance, device, &RAY_QUERY_EXTENSIONS) {
        properties = properties.push_next(&mut structures);
    }
    if is_portability_subset {
        properties = properties.push_next(&mut portability);
    }
    // SAFETY: `device` comes from this instance; the chain lives on this stack frame.
    unsafe { instance.raw.get_physical_device_properties2(device, &mut properties) };
    let p = properties.properties;
    let text = |c: Option<std::borrow::Cow<'_, str>>| c.map(|s| s.trim().to_owned()).unwrap_or_default();
    let driver_text = format!(
        "{} {}",
        text(driver.driver_name_as_c_str().ok().map(std::ffi::CStr::to_string_lossy)),
        text(driver.driver_info_as_c_str().ok().map(std::ffi::CStr::to_string_lossy))
    );
    let (mut missing, optional) = features(instance, device, p.api_version);
    missing.extend(portability_obstacle(portability.min_vertex_input_binding_stride_alignment));
    DeviceReport {
        name: text(p.device_name_as_c_str().ok().map(std::ffi::CStr::to_string_lossy)),
        driver: driver_text.trim().to_owned(),
        api_version: version_text(p.api_version),
        kind: match p.device_type {
            vk::PhysicalDeviceType::DISCRETE_GPU => "discrete gpu",
            vk::PhysicalDeviceType::INTEGRATED_GPU => "integrated gpu",
            vk::PhysicalDeviceType::VIRTUAL_GPU => "virtual gpu",
            vk::PhysicalDeviceType::CPU => "cpu",
            _ => "other",
        },
        vendor_id: p.vendor_id,
        device_id: p.device_id,
        driver_version: p.driver_version,
        missing,
        is_portability_subset,
        optional,
        limits: Limits {
            timestamp_bits: timestamp_bits(&instance.raw, device),
            allocation_bytes: memory.max_memory_allocation_size,
            ..limits(&p.limits, subgroup.subgroup_size, &structures)
        },
    }
}

fn limits(
    l: &vk::PhysicalDeviceLimits,
    subgroup_size: u32,
    structures: &vk::PhysicalDeviceAccelerationStructurePropertiesKHR<'_>,
) -> Limits {
    Limits {
        storage_range_bytes: u64::from(l.max_storage_buffer_range),
        // Of other properties.
        allocation_bytes: 0,
        image_edge_px: l
            .max_image_dimension2_d
            .min(l.max_framebuffer_width)
            .min(l.max_framebuffer_height)
            .min(l.max_viewport_dimensions[0])
            .min(l.max_viewport_dimensions[1]),
        image_rows: l.max_image_dimension2_d,
        array_layers: l.max_image_array_layers,
        dispatch_groups: l.max_compute_work_group_count[0].min(l.max_compute_work_group_count[1]),
        structure_triangles: structures.max_primitive_count,
        scratch_alignment: structures.min_acceleration_structure_scratch_offset_alignment,
        timestamp_period_ns: l.timestamp_period,
        timestamp_bits: 0,
        stage: StageLimits::new(l),
        subpixel_bits: l.sub_pixel_precision_bits.min(16),
        subgroup_size,
    }
}

/// What keeps a device whose vertices must lie at multiples of `stride_alignment` bytes, 0 where any stride will do.
fn portability_obstacle(stride_alignment: u32) -> Option<&'static str> {
    let is_met = stride_alignment == 0 || (size_of::<Vertex>() as u32).is_multiple_of(stride_alignment);
    (!is_met).then_some("vertices of 32 bytes (minVertexInputBindingStrideAlignment)")
}

fn version_text(version: u32) -> String {
    let (major, minor, patch) =
        (vk::api_version_major(version), vk::api_version_minor(version), vk::api_version_patch(version));
    format!("{major}.{minor}.{patch}")
}

fn features(
    instance: &Instance,
    device: vk::PhysicalDevice,
    api_version: u32,
) -> (Vec<&'static str>, OptionalFeatures) {
    if api_version < vk::API_VERSION_1_3 {
        return (vec!["Vulkan 1.3"], OptionalFeatures::default());
    }
    let mut v12 = vk::PhysicalDeviceVulkan12Features::default();
    let mut v13 = vk::PhysicalDeviceVulkan13Features::default();
    let mut structure = vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default();
    let mut query = vk::PhysicalDeviceRayQueryFeaturesKHR::default();
    let mut chain = vk::PhysicalDeviceFeatures2::default().push_next(&mut v12).push_next(&mut v13);
    let mut fault = vk::PhysicalDeviceFaultFeaturesEXT::default();
    let has = |names: &[&CStr]| has_extensions(instance, device, names);
    if has(&RAY_QUERY_EXTENSIONS) {
        chain = chain.push_next(&mut structure).push_next(&mut query);
    }
    if has(&[ext::device_fault::NAME]) {
        chain = chain.push_next(&mut fault);
    }
    // SAFETY: `device` comes from this instance; the chain lives on this stack frame.
    unsafe { instance.raw.get_physical_device_features2(device, &mut chain) };
    let core = chain.features;
    let required = [
        ("dynamicRendering", v13.dynamic_rendering),
        ("synchronization2", v13.synchronization2),
        ("shaderDemoteToHelperInvocation", v13.shader_demote_to_helper_invocation),
        ("timelineSemaphore", v12.timeline_semaphore),
        ("fragmentStoresAndAtomics", core.fragment_stores_and_atomics),
    ];
    let mut missing: Vec<&'static str> =
        required.iter().filter(|(_, found)| *found == vk::FALSE).map(|(name, _)| *name).collect();
    if queue_family(&instance.raw, device).is_none() {
        missing.push("a graphics and compute queue with timestamps");
    }
    // SAFETY: `device` comes from this instance.
    let rgba32f =
        unsafe { instance.raw.get_physical_device_format_properties(device, vk::Format::R32G32B32A32_SFLOAT) };
    let optional = OptionalFeatures {
        int64_atomics: core.shader_int64 == vk::TRUE && v12.shader_buffer_int64_atomics == vk::TRUE,
        blend_rgba32f: rgba32f.optimal_tiling_features.contains(vk::FormatFeatureFlags::COLOR_ATTACHMENT_BLEND),
        anisotropy: core.sampler_anisotropy == vk::TRUE,
        ray_query: [structure.acceleration_structure, query.ray_query, v12.buffer_device_address] == [vk::TRUE; 3],
        buffer_marker: has(&[amd::buffer_marker::NAME]),
        checkpoints: has(&[nv::device_diagnostic_checkpoints::NAME]),
        device_fault: fault.device_fault == vk::TRUE,
    };
    (missing, optional)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_suit_the_strides_of_a_portability_subset() {
        for alignment in [0, 1, 4, 16, 32] {
            assert_eq!(portability_obstacle(alignment), None, "{alignment}");
        }
        for alignment in [12, 64, 256] {
            assert!(portability_obstacle(alignment).is_some(), "{alignment}");
        }
        assert_eq!(size_of::<Vertex>(), 32, "the obstacle names this size");
    }
}
