//! The scene's acceleration structures for ray queries (`--rays query`): all triangles in one bottom structure, one
//! instance of it in the top structure.

use std::sync::Arc;

use ash::vk;

use super::buffer::Buffer;
use super::check;
use super::descriptors::Bound;
use super::device::Device;
use super::transfer::{full_barrier, submit_once, upload_buffer};
use crate::error::{Error, Result};
use crate::scene::Vertex;
use crate::scene::query_geometry::QueryGeometry;

/// Usage of what a build reads.
pub(super) const BUILD_INPUT: vk::BufferUsageFlags = vk::BufferUsageFlags::from_raw(
    vk::BufferUsageFlags::ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_KHR.as_raw()
        | vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS.as_raw(),
);

/// Both structures, built.
pub(super) struct Acceleration {
    top: Structure,
    /// The top structure refers to it.
    bottom: Structure,
}

/// One structure with its memory.
struct Structure {
    raw: vk::AccelerationStructureKHR,
    gpu: Arc<Device>,
    buffer: Buffer,
}

impl Drop for Structure {
    fn drop(&mut self) {
        if let Some(functions) = &self.gpu.acceleration {
            // SAFETY: owners wait for the GPU before they drop the scene; the buffer goes after the structure.
            unsafe { functions.destroy_acceleration_structure(self.raw, None) };
        }
    }
}

impl Acceleration {
    /// Builds the structures over `vertices`, a buffer of [`Vertex`] with usage [`BUILD_INPUT`]; waits.
    ///
    /// # Errors
    /// [`Error::Failure`] when the device has no ray queries or cannot take so many triangles; [`Error::Memory`].
    pub fn new(gpu: &Arc<Device>, vertices: &Buffer, geometry: &QueryGeometry) -> Result<Self> {
        let triangles = u64::from(geometry.opaque_count()) + u64::from(geometry.masked_count());
        let most = gpu.report().limits.structure_triangles;
        if triangles > most {
            return Err(Error::Failure(format!(
                "the scene is too large for --rays query on this device: {triangles} triangles, it takes {most}"
            )));
        }
        let usage = BUILD_INPUT | vk::BufferUsageFlags::TRANSFER_DST;
        let bytes: &[u8] = bytemuck::cast_slice(&geometry.indices);
        let indices = Buffer::new(gpu, "structure indices", bytes.len() as u64, usage)?;
        upload_buffer(gpu, &indices, bytes)?;
        let (geometries, counts) = triangle_geometries(gpu, vertices, &indices, geometry);
        let kind = vk::AccelerationStructureTypeKHR::BOTTOM_LEVEL;
        let bottom = Structure::build(gpu, "bottom structure", kind, &geometries, &counts)?;
        let instance = instance_words(bottom.address()?);
        let instances = Buffer::new(gpu, "structure instance", 64, usage)?;
        upload_buffer(gpu, &instances, bytemuck::cast_slice(&instance))?;
        let data = vk::AccelerationStructureGeometryInstancesDataKHR::default()
            .data(vk::DeviceOrHostAddressConstKHR { device_address: address(gpu, &instances) });
        let instances = [vk::AccelerationStructureGeometryKHR::default()
            .geometry_type(vk::GeometryTypeKHR::INSTANCES)
            .geometry(vk::AccelerationStructureGeometryDataKHR { instances: data })];
        let kind = vk::AccelerationStructureTypeKHR::TOP_LEVEL;
        let top = Structure::build(gpu, "top structure", kind, &instances, &[1])?;
        Ok(Self { top, bottom })
    }

    /// The buffers that hold the top and the bottom structure.
    pub fn buffers(&self) -> [&Buffer; 2] {
        [&self.top.buffer, &self.bottom.buffer]
    }

    pub fn bound(&self) -> Bound {
        Bound::Structure { raw: self.top.raw }
    }
}

/// The groups of triangles that are not empty, and how many triangles each has.
fn triangle_geometries<'a>(
    gpu: &Device,
    vertices: &Buffer,
    indices: &Buffer,
    geometry: &QueryGeometry,
) -> (Vec<vk::AccelerationStructureGeometryKHR<'a>>, Vec<u32>) {
    let vertex_count = (vertices.size_bytes / size_of::<Vertex>() as u64) as u32;
    let masked_from = 12 * u64::from(geometry.opaque_count());
    let groups = [
        (geometry.opaque_count(), 0, vk::GeometryFlagsKHR::OPAQUE),
        (geometry.masked_count(), masked_from, vk::GeometryFlagsKHR::empty()),
    ];
    let one = |(_, offset, flags): &(u32, u64, vk::GeometryFlagsKHR)| {
        let data = vk::AccelerationStructureGeometryTrianglesDataKHR::default()
            .vertex_format(vk::Format::R32G32B32_SFLOAT)
            .vertex_data(vk::DeviceOrHostAddressConstKHR { device_address: address(gpu, vertices) })
            .vertex_stride(size_of::<Vertex>() as u64)
            .max_vertex(vertex_count.saturating_sub(1))
            .index_type(vk::IndexType::UINT32)
            .index_data(vk::DeviceOrHostAddressConstKHR { device_address: address(gpu, indices) + offset });
        vk::AccelerationStructureGeometryKHR::default()
            .geometry_type(vk::GeometryTypeKHR::TRIANGLES)
            .flags(*flags)
            .geometry(vk::AccelerationStructureGeometryDataKHR { triangles: data })
    };
    groups.iter().filter(|(count, ..)| *count > 0).map(|group| (one(group), group.0)).unzip()
}

/// `VkAccelerationStructureInstanceKHR`: no transform, visible to every ray, both sides of triangles count.
fn instance_words(bottom: vk::DeviceAddress) -> [u32; 16] {
    let mut words = [0; 16];
    // The diagonal of a matrix of three rows of four.
    [0, 5, 10].iter().for_each(|i| words[*i] = 1.0_f32.to_bits());
    words[12] = 0xff << 24;
    words[13] = vk::GeometryInstanceFlagsKHR::TRIANGLE_FACING_CULL_DISABLE.as_raw() << 24;
    (words[14], words[15]) = (bottom as u32, (bottom >> 32) as u32);
    words
}

/// Where a buffer with the usage `SHADER_DEVICE_ADDRESS` lies.
fn address(gpu: &Device, buffer: &Buffer) -> vk::DeviceAddress {
    let info = vk::BufferDeviceAddressInfo::default().buffer(buffer.raw);
    // SAFETY: the buffer is alive, has the usage, and the feature is enabled where structures are built.
    unsafe { gpu.device.get_buffer_device_address(&info) }
}

impl Structure {
    /// Builds one structure over geometries with so many primitives each; waits.
    fn build(
        gpu: &Arc<Device>,
        name: &str,
        kind: vk::AccelerationStructureTypeKHR,
        geometries: &[vk::AccelerationStructureGeometryKHR<'_>],
        counts: &[u32],
    ) -> Result<Self> {
        let functions = functions(gpu)?;
        let mut info = vk::AccelerationStructureBuildGeometryInfoKHR::default()
            .ty(kind)
            .flags(vk::BuildAccelerationStructureFlagsKHR::PREFER_FAST_TRACE)
            .mode(vk::BuildAccelerationStructureModeKHR::BUILD)
            .geometries(geometries);
        let mut sizes = vk::AccelerationStructureBuildSizesInfoKHR::default();
        // SAFETY: a count for each geometry.
        unsafe {
            let device = vk::AccelerationStructureBuildTypeKHR::DEVICE;
            functions.get_acceleration_structure_build_sizes(device, &info, counts, &mut sizes);
        }
        let structure = Self::empty(gpu, name, kind, sizes.acceleration_structure_size)?;
        let alignment = u64::from(gpu.report().limits.scratch_alignment.max(1));
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS;
        let scratch = Buffer::new(gpu, "structure scratch", sizes.build_scratch_size + alignment, usage)?;
        info.dst_acceleration_structure = structure.raw;
        info.scratch_data.device_address = address(gpu, &scratch).next_multiple_of(alignment);
        let range = |count: &u32| vk::AccelerationStructureBuildRangeInfoKHR::default().primitive_count(*count);
        let ranges: Vec<_> = counts.iter().map(range).collect();
        submit_once(gpu, |commands| {
            full_barrier(gpu, commands);
            // SAFETY: the structure and the scratch memory have the sizes asked for, and all inputs are alive; the
            // submission is waited for.
            unsafe { functions.cmd_build_acceleration_structures(commands, &[info], &[&ranges]) };
            full_barrier(gpu, commands);
        })?;
        Ok(structure)
    }

    fn empty(gpu: &Arc<Device>, name: &str, kind: vk::AccelerationStructureTypeKHR, size_bytes: u64) -> Result<Self> {
        let usage =
            vk::BufferUsageFlags::ACCELERATION_STRUCTURE_STORAGE_KHR | vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS;
        let buffer = Buffer::new(gpu, name, size_bytes, usage)?;
        let info = vk::AccelerationStructureCreateInfoKHR::default().buffer(buffer.raw).size(size_bytes).ty(kind);
        // SAFETY: the buffer has the size and the usage; the structure is destroyed before it.
        let raw = check(name, unsafe { functions(gpu)?.create_acceleration_structure(&info, None) })?;
        gpu.set_name(raw, name);
        Ok(Self { raw, gpu: Arc::clone(gpu), buffer })
    }

    fn address(&self) -> Result<vk::DeviceAddress> {
        let info = vk::AccelerationStructureDeviceAddressInfoKHR::default().acceleration_structure(self.raw);
        // SAFETY: the structure is alive.
        Ok(unsafe { functions(&self.gpu)?.get_acceleration_structure_device_address(&info) })
    }
}

fn functions(gpu: &Device) -> Result<&ash::khr::acceleration_structure::Device> {
    gpu.acceleration.as_ref().ok_or_else(|| Error::Failure("this device has no acceleration structures".to_owned()))
}
