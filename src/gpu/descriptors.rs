//! Descriptor sets: one pool and layout per set, made once when a frame is compiled.

use std::sync::Arc;

use ash::vk;

use super::check;
use super::device::Device;
use crate::error::Result;
use crate::shader::interface::BindingKind;

/// What one binding points at.
#[derive(Clone, Copy, Debug)]
pub(super) enum Bound {
    Storage { buffer: vk::Buffer, size_bytes: u64 },
    Uniform { buffer: vk::Buffer, size_bytes: u64 },
    StorageImage { view: vk::ImageView },
    SampledImage { view: vk::ImageView, layout: vk::ImageLayout },
    Texture { view: vk::ImageView, sampler: vk::Sampler },
    Structure { raw: vk::AccelerationStructureKHR },
}

impl Bound {
    fn kind(self) -> vk::DescriptorType {
        match self {
            Self::Storage { .. } => vk::DescriptorType::STORAGE_BUFFER,
            Self::Uniform { .. } => vk::DescriptorType::UNIFORM_BUFFER,
            Self::StorageImage { .. } => vk::DescriptorType::STORAGE_IMAGE,
            Self::SampledImage { .. } => vk::DescriptorType::SAMPLED_IMAGE,
            Self::Structure { .. } => vk::DescriptorType::ACCELERATION_STRUCTURE_KHR,
            Self::Texture { .. } => vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
        }
    }
}

/// The kind of a descriptor that [`Bound`] makes.
pub(super) fn binding_kind(descriptor: vk::DescriptorType) -> BindingKind {
    match descriptor {
        vk::DescriptorType::UNIFORM_BUFFER => BindingKind::UniformBuffer,
        vk::DescriptorType::STORAGE_IMAGE => BindingKind::StorageImage,
        vk::DescriptorType::SAMPLED_IMAGE => BindingKind::SampledImage,
        vk::DescriptorType::COMBINED_IMAGE_SAMPLER => BindingKind::CombinedImageSampler,
        vk::DescriptorType::ACCELERATION_STRUCTURE_KHR => BindingKind::AccelerationStructure,
        _ => BindingKind::StorageBuffer,
    }
}

/// A binding with its type and stages: equal ones make compatible layouts.
pub(super) type Binding = (u32, vk::DescriptorType, vk::ShaderStageFlags);

/// Descriptor sets of one layout, with their pool.
pub(super) struct Sets {
    pub layout: vk::DescriptorSetLayout,
    pub bindings: Vec<Binding>,
    pub sets: Vec<vk::DescriptorSet>,
    pool: vk::DescriptorPool,
    gpu: Arc<Device>,
}

impl Sets {
    /// Makes one set per entry of `contents`; every entry lists the same bindings in the same order.
    pub fn new(
        gpu: &Arc<Device>,
        name: &str,
        stages: vk::ShaderStageFlags,
        contents: &[Vec<(u32, Bound)>],
    ) -> Result<Self> {
        let first = contents.first().map_or(&[][..], Vec::as_slice);
        let layout_bindings: Vec<_> = first
            .iter()
            .map(|(binding, bound)| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(*binding)
                    .descriptor_type(bound.kind())
                    .descriptor_count(1)
                    .stage_flags(stages)
            })
            .collect();
        let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&layout_bindings);
        // SAFETY: valid create info.
        let layout = check(name, unsafe { gpu.device.create_descriptor_set_layout(&info, None) })?;
        let bindings = first.iter().map(|(binding, bound)| (*binding, bound.kind(), stages)).collect();
        let mut sets =
            Self { layout, bindings, sets: Vec::new(), pool: vk::DescriptorPool::null(), gpu: Arc::clone(gpu) };
        if contents.is_empty() || first.is_empty() {
            return Ok(sets);
        }
        sets.allocate(name, first, contents.len())?;
        for (set, bindings) in sets.sets.iter().zip(contents) {
            bindings.iter().for_each(|(binding, bound)| write(gpu, *set, *binding, *bound));
        }
        Ok(sets)
    }

    fn allocate(&mut self, name: &str, bindings: &[(u32, Bound)], count: usize) -> Result<()> {
        let sizes: Vec<_> = bindings
            .iter()
            .map(|(_, bound)| vk::DescriptorPoolSize { ty: bound.kind(), descriptor_count: count as u32 })
            .collect();
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(count as u32).pool_sizes(&sizes);
        // SAFETY: valid create info.
        self.pool = check(name, unsafe { self.gpu.device.create_descriptor_pool(&info, None) })?;
        let layouts = vec![self.layout; count];
        let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(self.pool).set_layouts(&layouts);
        // SAFETY: the pool was sized for exactly these sets.
        self.sets = check(name, unsafe { self.gpu.device.allocate_descriptor_sets(&info) })?;
        self.sets.iter().for_each(|set| self.gpu.set_name(*set, name));
        Ok(())
    }
}

fn write(gpu: &Device, set: vk::DescriptorSet, binding: u32, bound: Bound) {
    let mut buffers = [vk::DescriptorBufferInfo::default()];
    let mut images = [vk::DescriptorImageInfo::default()];
    let raw_structures;
    let mut structures = vk::WriteDescriptorSetAccelerationStructureKHR::default();
    let target = vk::WriteDescriptorSet::default().dst_set(set).dst_binding(binding).descriptor_type(bound.kind());
    let target = match bound {
        Bound::Storage { buffer, size_bytes } | Bound::Uniform { buffer, size_bytes } => {
            buffers[0] = vk::DescriptorBufferInfo { buffer, offset: 0, range: size_bytes };
            target.buffer_info(&buffers)
        }
        Bound::Structure { raw } => {
            raw_structures = [raw];
            structures = structures.acceleration_structures(&raw_structures);
            target.descriptor_count(1).push_next(&mut structures)
        }
        Bound::StorageImage { view } => {
            images[0] = vk::DescriptorImageInfo::default().image_view(view).image_layout(vk::ImageLayout::GENERAL);
            target.image_info(&images)
        }
        Bound::SampledImage { view, layout } => {
            images[0] = vk::DescriptorImageInfo::default().image_view(view).image_layout(layout);
            target.image_info(&images)
        }
        Bound::Texture { view, sampler } => {
            images[0] = vk::DescriptorImageInfo {
                sampler,
                image_view: view,
                image_layout: vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
            };
            target.image_info(&images)
        }
    };
    // SAFETY: the set is not in use yet; what it points at outlives it.
    unsafe { gpu.device.update_descriptor_sets(&[target], &[]) };
}

impl Drop for Sets {
    fn drop(&mut self) {
        // SAFETY: owners wait for the GPU before they drop sets in use; a null pool is ignored.
        unsafe {
            self.gpu.device.destroy_descriptor_pool(self.pool, None);
            self.gpu.device.destroy_descriptor_set_layout(self.layout, None);
        }
    }
}
