//! The scene's acceleration structures for ray queries (`--rays query`): all triangles in one bottom structure, one
//! instance of it in the top structure.

use std::sync::Arc;

use ash::{khr, vk};

use super::buffer::Buffer;
use super::check;
use super::descriptors::Bound;
use super::device::Device;
use super::transfer::{full_barrier, submit_once, upload_buffer};
use super::work::StructureLevel;
use crate::error::{Error, Result};
use crate::graph::Access;
use crate::scene::Vertex;
use crate::scene::query_geometry::QueryGeometry;

/// Usage of what a build reads.
pub(super) const BUILD_INPUT: vk::BufferUsageFlags = vk::BufferUsageFlags::from_raw(
    vk::BufferUsageFlags::ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_KHR.as_raw()
        | vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS.as_raw(),
);

/// Both structures, built, with what they are built from.
pub(super) struct Acceleration {
    top: Structure,
    /// The top structure refers to it.
    bottom: Structure,
    triangles: Triangles,
    /// The only instance.
    instances: Buffer,
}

/// What the bottom structure is built from.
struct Triangles {
    vertices: vk::DeviceAddress,
    vertex_count: u32,
    /// Opaque triangles before masked ones.
    indices: Buffer,
    opaque_count: u32,
    masked_count: u32,
}

/// One structure with its memory.
struct Structure {
    raw: vk::AccelerationStructureKHR,
    gpu: Arc<Device>,
    functions: khr::acceleration_structure::Device,
    buffer: Buffer,
    /// Memory that a build needs meanwhile, with room to align it.
    scratch_bytes: u64,
}

/// Geometries of a structure, and how many primitives each has.
type Geometries = (Vec<vk::AccelerationStructureGeometryKHR<'static>>, Vec<u32>);

impl Drop for Structure {
    fn drop(&mut self) {
        // SAFETY: owners wait for the GPU before they drop the scene; the buffer goes after the structure.
        unsafe { self.functions.destroy_acceleration_structure(self.raw, None) };
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
        let triangles = Triangles {
            vertices: address(gpu, vertices.raw),
            vertex_count: (vertices.size_bytes / size_of::<Vertex>() as u64) as u32,
            indices,
            opaque_count: geometry.opaque_count(),
            masked_count: geometry.masked_count(),
        };
        let bottom = Structure::built(gpu, StructureLevel::Bottom, &triangles.geometries(gpu))?;
        let instance = instance_words(bottom.address());
        let instances = Buffer::new(gpu, "structure instance", 64, usage)?;
        upload_buffer(gpu, &instances, bytemuck::cast_slice(&instance))?;
        let top = Structure::built(gpu, StructureLevel::Top, &instance_geometry(gpu, &instances))?;
        Ok(Self { top, bottom, triangles, instances })
    }

    /// Builds both anew, in their places, over the vertices that are in their buffer now; waits. `geometry` has as many
    /// triangles of each kind as before, in any order.
    ///
    /// # Errors
    /// [`Error::Failure`] when it has not; when the device is lost.
    pub fn rebuild(&self, gpu: &Arc<Device>, geometry: &QueryGeometry) -> Result<()> {
        let counts = (self.triangles.opaque_count, self.triangles.masked_count);
        if counts != (geometry.opaque_count(), geometry.masked_count()) {
            return Err(Error::Failure("triangles of acceleration structures can move, but not come or go".to_owned()));
        }
        upload_buffer(gpu, &self.triangles.indices, bytemuck::cast_slice(&geometry.indices))?;
        for level in [StructureLevel::Bottom, StructureLevel::Top] {
            self.structure(level).build(gpu, level, &self.geometries(level))?;
        }
        Ok(())
    }

    /// Records a new build of one structure, in its place, from what is in the scene's buffers then. `scratch` has at least
    /// [`Self::scratch_bytes`].
    pub fn record_build(&self, commands: vk::CommandBuffer, level: StructureLevel, scratch: vk::Buffer) {
        self.structure(level).record_build(commands, level, &self.geometries(level), scratch);
    }

    fn geometries(&self, level: StructureLevel) -> Geometries {
        let gpu = &self.structure(level).gpu;
        match level {
            StructureLevel::Bottom => self.triangles.geometries(gpu),
            StructureLevel::Top => instance_geometry(gpu, &self.instances),
        }
    }

    /// Bytes of scratch memory that a build of one structure takes.
    pub fn scratch_bytes(&self, level: StructureLevel) -> u64 {
        self.structure(level).scratch_bytes
    }

    fn structure(&self, level: StructureLevel) -> &Structure {
        match level {
            StructureLevel::Bottom => &self.bottom,
            StructureLevel::Top => &self.top,
        }
    }

    /// The buffers that hold the top and the bottom structure.
    pub fn buffers(&self) -> [&Buffer; 2] {
        [&self.top.buffer, &self.bottom.buffer]
    }

    pub fn bound(&self) -> Bound {
        Bound::Structure { raw: self.top.raw }
    }
}

impl Triangles {
    /// The groups of triangles that are not empty.
    fn geometries(&self, gpu: &Device) -> Geometries {
        let masked_from = 12 * u64::from(self.opaque_count);
        let groups = [
            (self.opaque_count, 0, vk::GeometryFlagsKHR::OPAQUE),
            (self.masked_count, masked_from, vk::GeometryFlagsKHR::empty()),
        ];
        let indices = address(gpu, self.indices.raw);
        let one = |(_, offset, flags): &(u32, u64, vk::GeometryFlagsKHR)| {
            let data = vk::AccelerationStructureGeometryTrianglesDataKHR::default()
                .vertex_format(vk::Format::R32G32B32_SFLOAT)
                .vertex_data(vk::DeviceOrHostAddressConstKHR { device_address: self.vertices })
                .vertex_stride(size_of::<Vertex>() as u64)
                .max_vertex(self.vertex_count.saturating_sub(1))
                .index_type(vk::IndexType::UINT32)
                .index_data(vk::DeviceOrHostAddressConstKHR { device_address: indices + offset });
            vk::AccelerationStructureGeometryKHR::default()
                .geometry_type(vk::GeometryTypeKHR::TRIANGLES)
                .flags(*flags)
                .geometry(vk::AccelerationStructureGeometryDataKHR { triangles: data })
        };
        groups.iter().filter(|(count, ..)| *count > 0).map(|group| (one(group), group.0)).unzip()
    }
}

fn instance_geometry(gpu: &Device, instances: &Buffer) -> Geometries {
    let data = vk::AccelerationStructureGeometryInstancesDataKHR::default()
        .data(vk::DeviceOrHostAddressConstKHR { device_address: address(gpu, instances.raw) });
    let geometry = vk::AccelerationStructureGeometryKHR::default()
        .geometry_type(vk::GeometryTypeKHR::INSTANCES)
        .geometry(vk::AccelerationStructureGeometryDataKHR { instances: data });
    (vec![geometry], vec![1])
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
fn address(gpu: &Device, buffer: vk::Buffer) -> vk::DeviceAddress {
    let info = vk::BufferDeviceAddressInfo::default().buffer(buffer);
    // SAFETY: the buffer is alive, has the usage, and the feature is enabled where structures are built.
    unsafe { gpu.device.get_buffer_device_address(&info) }
}

/// How a structure of this level is built from geometries.
fn build_info<'a>(
    level: StructureLevel,
    geometries: &'a [vk::AccelerationStructureGeometryKHR<'a>],
) -> vk::AccelerationStructureBuildGeometryInfoKHR<'a> {
    vk::AccelerationStructureBuildGeometryInfoKHR::default()
        .ty(level.kind())
        .flags(vk::BuildAccelerationStructureFlagsKHR::PREFER_FAST_TRACE)
        .mode(vk::BuildAccelerationStructureModeKHR::BUILD)
        .geometries(geometries)
}

impl StructureLevel {
    fn kind(self) -> vk::AccelerationStructureTypeKHR {
        match self {
            Self::Bottom => vk::AccelerationStructureTypeKHR::BOTTOM_LEVEL,
            Self::Top => vk::AccelerationStructureTypeKHR::TOP_LEVEL,
        }
    }
}

impl Structure {
    /// Makes one structure and builds it; waits.
    fn built(gpu: &Arc<Device>, level: StructureLevel, geometries: &Geometries) -> Result<Self> {
        let functions = functions(gpu)?;
        let mut sizes = vk::AccelerationStructureBuildSizesInfoKHR::default();
        // SAFETY: a count for each geometry.
        unsafe {
            let device = vk::AccelerationStructureBuildTypeKHR::DEVICE;
            let info = build_info(level, &geometries.0);
            functions.get_acceleration_structure_build_sizes(device, &info, &geometries.1, &mut sizes);
        }
        let structure = Self::empty(gpu, level, &sizes)?;
        structure.build(gpu, level, geometries)?;
        Ok(structure)
    }

    /// Builds it in its place; waits.
    fn build(&self, gpu: &Arc<Device>, level: StructureLevel, geometries: &Geometries) -> Result<()> {
        let usage = Access::StructureScratch.buffer_usage();
        let scratch = Buffer::new(gpu, "structure scratch", self.scratch_bytes, usage)?;
        submit_once(gpu, |commands| {
            full_barrier(gpu, commands);
            self.record_build(commands, level, geometries, scratch.raw);
            full_barrier(gpu, commands);
        })
    }

    fn record_build(
        &self,
        commands: vk::CommandBuffer,
        level: StructureLevel,
        (geometries, counts): &Geometries,
        scratch: vk::Buffer,
    ) {
        let mut info = build_info(level, geometries);
        info.dst_acceleration_structure = self.raw;
        info.scratch_data.device_address = address(&self.gpu, scratch).next_multiple_of(scratch_alignment(&self.gpu));
        let range = |count: &u32| vk::AccelerationStructureBuildRangeInfoKHR::default().primitive_count(*count);
        let ranges: Vec<_> = counts.iter().map(range).collect();
        // SAFETY: the structure and the scratch memory have the sizes asked for, and all inputs are alive until the
        // commands have been waited for.
        unsafe { self.functions.cmd_build_acceleration_structures(commands, &[info], &[&ranges]) };
    }

    fn empty(
        gpu: &Arc<Device>,
        level: StructureLevel,
        sizes: &vk::AccelerationStructureBuildSizesInfoKHR<'_>,
    ) -> Result<Self> {
        let (name, size_bytes) = (level.name(), sizes.acceleration_structure_size);
        let usage =
            vk::BufferUsageFlags::ACCELERATION_STRUCTURE_STORAGE_KHR | vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS;
        let buffer = Buffer::new(gpu, name, size_bytes, usage)?;
        let info =
            vk::AccelerationStructureCreateInfoKHR::default().buffer(buffer.raw).size(size_bytes).ty(level.kind());
        let functions = functions(gpu)?.clone();
        // SAFETY: the buffer has the size and the usage; the structure is destroyed before it.
        let raw = check(name, unsafe { functions.create_acceleration_structure(&info, None) })?;
        gpu.set_name(raw, name);
        let scratch_bytes = sizes.build_scratch_size + scratch_alignment(gpu);
        Ok(Self { raw, gpu: Arc::clone(gpu), functions, buffer, scratch_bytes })
    }

    fn address(&self) -> vk::DeviceAddress {
        let info = vk::AccelerationStructureDeviceAddressInfoKHR::default().acceleration_structure(self.raw);
        // SAFETY: the structure is alive.
        unsafe { self.functions.get_acceleration_structure_device_address(&info) }
    }
}

fn scratch_alignment(gpu: &Device) -> u64 {
    u64::from(gpu.report().limits.scratch_alignment.max(1))
}

fn functions(gpu: &Device) -> Result<&khr::acceleration_structure::Device> {
    gpu.acceleration.as_ref().ok_or_else(|| Error::Failure("this device has no acceleration structures".to_owned()))
}
