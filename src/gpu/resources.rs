//! The frame's buffers and images: created from the graph's declarations, transients sharing memory.

use std::ops::Range;
use std::sync::Arc;

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};

use super::buffer::Buffer;
use super::check;
use super::device::Device;
use super::physical::{Physical, image_create_info, view_create_info};
use super::scene_set::SceneSet;
use super::shared_image::SharedImage;
use super::target::{FRAMES_IN_FLIGHT, WindowTarget};
use super::work::Work;
use crate::error::{Error, Result};
use crate::graph::{
    AliasPlan, BufferInfo, Graph, Handle, ImageInfo, Lifetime, Plan, Requirement, Resource, ResourceInfo,
    add_alias_barriers, assign, hoist,
};

/// Memory figures of a compiled frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct MemoryUse {
    /// Bytes of transient memory after aliasing.
    pub transient_bytes: u64,
    /// Bytes the transients would take without aliasing.
    pub unaliased_bytes: u64,
    /// Bytes of persistent buffers and images.
    pub persistent_bytes: u64,
}

/// All resources of one graph.
pub(super) struct Resources {
    pub list: Vec<Physical>,
    pub memory: MemoryUse,
    /// Part of the acquired image that pictures are drawn to: x, y, width, height; `None` is all of it.
    pub shown_part_px: Option<[u32; 4]>,
    /// By resource, a view of each level of an image that has several.
    level_views: Vec<Vec<vk::ImageView>>,
    /// Buffers of the frames in flight that the host reads, by resource.
    readback: Vec<(usize, Vec<Buffer>)>,
    /// Whether each resource is the graph's own.
    owned: Vec<bool>,
    /// Pairs that change places between frames.
    history: Vec<(usize, usize)>,
    /// Whether they have done so an odd number of times.
    odd_frame: bool,
    allocations: Vec<Allocation>,
    gpu: Arc<Device>,
}

/// One memory class: resources that may share memory must agree on it.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Class {
    is_image: bool,
    memory_type_bits: u32,
}

impl Resources {
    /// Creates everything and completes the plan: what waits where memory is shared, and where barriers are recorded.
    /// Imported resources are parts of the scene, or shared images.
    pub fn new(gpu: &Arc<Device>, graph: &Graph<Work>, plan: &mut Plan, imports: &Imports) -> Result<Self> {
        let mut resources = Self {
            list: Vec::new(),
            memory: MemoryUse::default(),
            shown_part_px: None,
            level_views: vec![Vec::new(); graph.resources().len()],
            readback: Vec::new(),
            owned: Vec::new(),
            history: Vec::new(),
            odd_frame: false,
            allocations: Vec::new(),
            gpu: Arc::clone(gpu),
        };
        for (index, resource) in graph.resources().iter().enumerate() {
            let physical = match (resource.lifetime, resource.info) {
                (Lifetime::Imported, _) => imports.find(resource)?,
                // Another one in every frame: see `Executor::submit_to`.
                (lifetime, ResourceInfo::Image(info)) if lifetime.is_acquired() => Physical::unacquired(info),
                (Lifetime::Readback, ResourceInfo::Buffer(info)) => {
                    resources.create_readback(index, &resource.name, info)?
                }
                _ => resources.create(graph, index, &resource.name, resource.info)?,
            };
            resources.list.push(physical);
            resources.owned.push(is_owned(resource.lifetime));
            if let Lifetime::Previous { current } = resource.lifetime {
                resources.history.push((index, current.index()));
            }
        }
        let mut classes = Vec::new();
        let requirements: Vec<_> = (0..resources.list.len())
            .map(|index| {
                let shared =
                    graph.resources()[index].lifetime == Lifetime::Transient && plan.lifetimes[index].is_some();
                shared.then(|| resources.requirement(index, &mut classes))
            })
            .collect();
        let aliases = assign(&plan.lifetimes, &requirements);
        add_alias_barriers(plan, graph, &requirements, &aliases);
        hoist(plan, graph);
        resources.bind_shared(&aliases, &requirements, &classes)?;
        resources.bind_single(graph, &aliases)?;
        resources.create_views(graph)?;
        Ok(resources)
    }

    pub fn buffer(&self, handle: impl Into<Handle>) -> (vk::Buffer, u64) {
        self.buffer_at(handle.into().index())
    }

    /// The buffer at a position in the graph's list of resources.
    pub fn buffer_at(&self, index: usize) -> (vk::Buffer, u64) {
        match self.list[index] {
            Physical::Buffer { raw, size_bytes } => (raw, size_bytes),
            Physical::Image { .. } => unreachable!("typed handles name buffers"),
        }
    }

    pub fn image(&self, handle: impl Into<Handle>) -> (vk::Image, vk::ImageView, ImageInfo) {
        match self.list[handle.into().index()] {
            Physical::Image { raw, view, info } => (raw, view, info),
            Physical::Buffer { .. } => unreachable!("typed handles name images"),
        }
    }

    /// The view of one level of an image, or of all.
    pub fn view(&self, handle: impl Into<Handle>, level: Option<u32>) -> vk::ImageView {
        let handle = handle.into();
        let views = &self.level_views[handle.index()];
        level.and_then(|level| views.get(level as usize)).copied().unwrap_or_else(|| self.image(handle).1)
    }

    fn create(&self, graph: &Graph<Work>, index: usize, name: &str, info: ResourceInfo) -> Result<Physical> {
        match info {
            ResourceInfo::Buffer(buffer) => {
                // Any buffer may be written or read back for tests and dumps.
                let usage =
                    graph.usage_of(index).0 | vk::BufferUsageFlags::TRANSFER_SRC | vk::BufferUsageFlags::TRANSFER_DST;
                let create = vk::BufferCreateInfo::default().size(buffer.size_bytes).usage(usage);
                self.check_range(name, buffer.size_bytes)?;
                // SAFETY: valid create info; destroyed in `drop`.
                let raw = check(name, unsafe { self.gpu.device.create_buffer(&create, None) })?;
                self.gpu.set_name(raw, name);
                Ok(Physical::Buffer { raw, size_bytes: buffer.size_bytes })
            }
            ResourceInfo::Image(info) => {
                let mut usage = graph.usage_of(index).1 | vk::ImageUsageFlags::TRANSFER_SRC;
                if graph.resources()[index].contents.is_some() {
                    usage |= vk::ImageUsageFlags::TRANSFER_DST;
                }
                let create = image_create_info(&info, usage);
                self.gpu.check_image(name, &create)?;
                // SAFETY: valid create info within the device's limits; destroyed in `drop`.
                let raw = check(name, unsafe { self.gpu.device.create_image(&create, None) })?;
                self.gpu.set_name(raw, name);
                Ok(Physical::Image { raw, view: vk::ImageView::null(), info })
            }
        }
    }

    fn create_readback(&mut self, index: usize, name: &str, info: BufferInfo) -> Result<Physical> {
        let create = |_| Buffer::host(&self.gpu, name, info.size_bytes, vk::BufferUsageFlags::TRANSFER_DST);
        let buffers = (0..FRAMES_IN_FLIGHT).map(create).collect::<Result<Vec<_>>>()?;
        let raw = buffers[0].raw;
        self.readback.push((index, buffers));
        Ok(Physical::Buffer { raw, size_bytes: info.size_bytes })
    }

    /// What the last frame wrote for the next one becomes what that one reads.
    pub fn change_places(&mut self) {
        for (previous, current) in &self.history {
            self.list.swap(*previous, *current);
            self.level_views.swap(*previous, *current);
        }
        self.odd_frame ^= true;
    }

    /// Which of a pass's descriptor sets are those of this frame, when it has one for each place of its pairs.
    pub fn parity(&self) -> usize {
        usize::from(self.odd_frame)
    }

    /// Whether there is anything that changes places from frame to frame.
    pub fn keeps_history(&self) -> bool {
        !self.history.is_empty()
    }

    /// The next frame is recorded for this one of the frames in flight.
    pub fn use_slot(&mut self, slot: usize) {
        for (index, buffers) in &self.readback {
            self.list[*index] = Physical::Buffer { raw: buffers[slot].raw, size_bytes: buffers[slot].size_bytes };
        }
    }

    /// What the graph's readback buffers hold after a frame that has been waited for, one after the other.
    pub fn read_back(&self, slot: usize) -> Vec<u8> {
        self.readback.iter().flat_map(|(_, buffers)| buffers[slot].mapped()).copied().collect()
    }

    /// Puts the image of this frame in the place of the graph's acquired one, or takes it out again.
    pub(super) fn acquired(&mut self, graph: &Graph<Work>, shown: Option<&WindowTarget<'_>>) {
        self.shown_part_px = shown.and_then(|shown| shown.part_px);
        for (physical, resource) in self.list.iter_mut().zip(graph.resources()) {
            if let (true, ResourceInfo::Image(info)) = (resource.lifetime.is_acquired(), resource.info) {
                *physical = shown.map_or_else(
                    || Physical::unacquired(info),
                    |WindowTarget { target, .. }| Physical::Image {
                        raw: target.image,
                        view: target.view,
                        info: ImageInfo { width_px: target.extent.width, height_px: target.extent.height, ..info },
                    },
                );
            }
        }
    }

    fn check_range(&self, name: &str, size_bytes: u64) -> Result<()> {
        let limit = self.gpu.report().limits.storage_range_bytes;
        if size_bytes <= limit {
            return Ok(());
        }
        Err(Error::Failure(format!(
            "{name} needs {} MiB, but a storage buffer of this device holds {} MiB",
            size_bytes >> 20,
            limit >> 20
        )))
    }

    fn memory_requirements(&self, index: usize) -> (vk::MemoryRequirements, bool) {
        // SAFETY: the objects belong to this device.
        unsafe {
            match self.list[index] {
                Physical::Buffer { raw, .. } => (self.gpu.device.get_buffer_memory_requirements(raw), false),
                Physical::Image { raw, .. } => (self.gpu.device.get_image_memory_requirements(raw), true),
            }
        }
    }

    fn requirement(&self, index: usize, classes: &mut Vec<Class>) -> Requirement {
        let (needs, is_image) = self.memory_requirements(index);
        let class = Class { is_image, memory_type_bits: needs.memory_type_bits };
        let position = classes.iter().position(|c| *c == class).unwrap_or_else(|| {
            classes.push(class);
            classes.len() - 1
        });
        Requirement { size_bytes: needs.size, alignment: needs.alignment, class: position as u32 }
    }

    fn bind_shared(
        &mut self,
        aliases: &AliasPlan,
        requirements: &[Option<Requirement>],
        classes: &[Class],
    ) -> Result<()> {
        for (class, size) in &aliases.class_sizes {
            let alignment = requirements.iter().flatten().filter(|r| r.class == *class).map(|r| r.alignment).max();
            let Class { is_image, memory_type_bits } = classes[*class as usize];
            let needs = vk::MemoryRequirements { size: *size, alignment: alignment.unwrap_or(256), memory_type_bits };
            check_allocation(*size, self.gpu.report().limits.allocation_bytes, self.largest_image_px())?;
            let slot = self.allocate("a frame's images and buffers, which grow with --size", needs, !is_image)?;
            for (index, placement) in aliases.placements.iter().enumerate() {
                if let Some(placement) = placement.as_ref().filter(|p| p.class == *class) {
                    self.bind(index, slot, placement.offset_bytes)?;
                }
            }
            self.memory.transient_bytes += size;
        }
        self.memory.unaliased_bytes = aliases.unaliased_bytes;
        Ok(())
    }

    fn bind_single(&mut self, graph: &Graph<Work>, aliases: &AliasPlan) -> Result<()> {
        for index in 0..self.list.len() {
            let lifetime = graph.resources()[index].lifetime;
            if is_owned(lifetime) && aliases.placements[index].is_none() {
                let (needs, is_image) = self.memory_requirements(index);
                let slot = self.allocate(&graph.resources()[index].name, needs, !is_image)?;
                self.bind(index, slot, 0)?;
                self.memory.persistent_bytes += needs.size;
            }
        }
        Ok(())
    }

    /// Width and height of the frame's largest image.
    fn largest_image_px(&self) -> [u32; 2] {
        let sizes = self.list.iter().filter_map(|physical| match physical {
            Physical::Image { info, .. } => Some([info.width_px, info.height_px]),
            Physical::Buffer { .. } => None,
        });
        sizes.max_by_key(|[width, height]| u64::from(*width) * u64::from(*height)).unwrap_or_default()
    }

    fn allocate(&mut self, name: &str, requirements: vk::MemoryRequirements, linear: bool) -> Result<usize> {
        let desc = AllocationCreateDesc {
            name,
            requirements,
            location: MemoryLocation::GpuOnly,
            linear,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        };
        let allocation = self.gpu.allocator().allocate(&desc).map_err(|e| Error::Memory {
            name: format!("{name} ({} MiB)", requirements.size >> 20),
            reason: e.to_string(),
        })?;
        self.allocations.push(allocation);
        Ok(self.allocations.len() - 1)
    }

    fn bind(&self, index: usize, slot: usize, offset_bytes: u64) -> Result<()> {
        let allocation = &self.allocations[slot];
        let offset = allocation.offset() + offset_bytes;
        // SAFETY: offset and size lie within the allocation and meet the alignment; each object is bound once.
        let bound = unsafe {
            match self.list[index] {
                Physical::Buffer { raw, .. } => self.gpu.device.bind_buffer_memory(raw, allocation.memory(), offset),
                Physical::Image { raw, .. } => self.gpu.device.bind_image_memory(raw, allocation.memory(), offset),
            }
        };
        check("binding memory", bound)
    }

    fn create_views(&mut self, graph: &Graph<Work>) -> Result<()> {
        for (index, resource) in graph.resources().iter().enumerate() {
            if let Physical::Image { raw, info, .. } = self.list[index]
                && is_owned(resource.lifetime)
            {
                let view = self.create_view(&resource.name, raw, &info, 0..info.level_count)?;
                self.list[index] = Physical::Image { raw, view, info };
                for level in (0..info.level_count).filter(|_| info.level_count > 1) {
                    let view = self.create_view(&resource.name, raw, &info, level..level + 1)?;
                    self.level_views[index].push(view);
                }
            }
        }
        Ok(())
    }

    fn create_view(&self, name: &str, raw: vk::Image, info: &ImageInfo, levels: Range<u32>) -> Result<vk::ImageView> {
        let create = view_create_info(raw, info, levels);
        // SAFETY: the image is alive and bound; destroyed in `drop`.
        check(name, unsafe { self.gpu.device.create_image_view(&create, None) })
    }
}

/// Refuses a frame that needs more memory at once than the device gives, which would otherwise be out of memory without
/// a word of what would do.
fn check_allocation(size_bytes: u64, limit_bytes: u64, [width, height]: [u32; 2]) -> Result<()> {
    if size_bytes <= limit_bytes {
        return Ok(());
    }
    // A hundredth less, as images are padded to whole tiles.
    let part = 0.99 * (limit_bytes as f64 / size_bytes as f64).sqrt();
    let [fit_width, fit_height] = [width, height].map(|edge| (f64::from(edge) * part) as u32);
    let [size, limit] = [size_bytes, limit_bytes].map(|bytes| bytes >> 20);
    Err(Error::Usage(format!(
        "a frame of {width}x{height} pixels needs {size} MiB of memory at once, and {limit} MiB are the most that this \
         device gives; --size {fit_width}x{fit_height} would fit"
    )))
}

/// Whether a graph's resources of this lifetime are its own: created, bound and destroyed here.
fn is_owned(lifetime: Lifetime) -> bool {
    !lifetime.is_acquired() && !matches!(lifetime, Lifetime::Readback | Lifetime::Imported)
}

/// What a graph's imported resources are.
#[derive(Clone, Default)]
pub(super) struct Imports {
    pub scene: Option<Arc<SceneSet>>,
    /// Images of their own names.
    pub images: Vec<Arc<SharedImage>>,
}

impl Imports {
    fn find(&self, resource: &Resource) -> Result<Physical> {
        let image = self.images.iter().find(|image| image.name == resource.name).map(|image| image.physical());
        let part = || self.scene.as_ref().and_then(|scene| scene.part(&resource.name));
        image
            .or_else(part)
            .ok_or_else(|| Error::Failure(format!("a pass needs `{}`, which the scene does not have", resource.name)))
    }
}

impl Drop for Resources {
    fn drop(&mut self) {
        for view in self.level_views.drain(..).flatten() {
            // SAFETY: the executor waits for the GPU before it drops its resources.
            unsafe { self.gpu.device.destroy_image_view(view, None) };
        }
        for (physical, _) in self.list.iter().zip(&self.owned).filter(|(_, owned)| **owned) {
            // SAFETY: the executor waits for the GPU before it drops its resources; null views are ignored.
            unsafe {
                match *physical {
                    Physical::Buffer { raw, .. } => self.gpu.device.destroy_buffer(raw, None),
                    Physical::Image { raw, view, .. } => {
                        self.gpu.device.destroy_image_view(view, None);
                        self.gpu.device.destroy_image(raw, None);
                    }
                }
            }
        }
        for allocation in self.allocations.drain(..) {
            if let Err(error) = self.gpu.allocator().free(allocation) {
                log::error!("freeing frame memory: {error}");
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_beyond_the_memory_is_refused_with_the_size_that_fits() {
        let gib = 1 << 30;
        assert!(check_allocation(2 * gib, 2 * gib, [8192, 4096]).is_ok());
        let error = check_allocation(8 * gib, 2 * gib, [8192, 4096]).unwrap_err();
        assert_eq!(error.exit_code(), 2);
        let wanted = "a frame of 8192x4096 pixels needs 8192 MiB of memory at once, and 2048 MiB are the most that this \
                      device gives; --size 4055x2027 would fit";
        assert_eq!(error.to_string(), wanted);
        assert!(check_allocation(2 * gib + 1, 2 * gib, [8192, 4096]).is_err());
    }
}
