//! How many bindings of each kind a stage of a pass has, against what the device allows: counted before anything of a
//! frame is created.

use ash::vk;

use super::interfaces::{binding_numbers, kind_of};
use super::work::Work;
use crate::error::{Error, Result};
use crate::graph::{Graph, Pass};
use crate::shader::interface::BindingKind;

/// Bindings by kind: those that one stage has, or the most that it may have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StageLimits {
    /// Uniform buffers.
    pub uniform_buffers: u32,
    /// Storage buffers.
    pub storage_buffers: u32,
    /// Images that are sampled, with or without a sampler of their own.
    pub sampled_images: u32,
    /// Images that are read and written as storage.
    pub storage_images: u32,
    /// Samplers.
    pub samplers: u32,
    /// All of them, with a fragment stage's colour attachments.
    pub resources: u32,
}

impl StageLimits {
    /// The limits of a device. A pass has one pipeline layout for all stages, so the limits of layouts hold as well.
    pub(super) fn new(l: &vk::PhysicalDeviceLimits) -> Self {
        Self {
            uniform_buffers: l.max_per_stage_descriptor_uniform_buffers.min(l.max_descriptor_set_uniform_buffers),
            storage_buffers: l.max_per_stage_descriptor_storage_buffers.min(l.max_descriptor_set_storage_buffers),
            sampled_images: l.max_per_stage_descriptor_sampled_images.min(l.max_descriptor_set_sampled_images),
            storage_images: l.max_per_stage_descriptor_storage_images.min(l.max_descriptor_set_storage_images),
            samplers: l.max_per_stage_descriptor_samplers.min(l.max_descriptor_set_samplers),
            resources: l.max_per_stage_resources,
        }
    }

    /// What bindings of these kinds add up to.
    #[must_use]
    pub fn of(kinds: impl IntoIterator<Item = BindingKind>) -> Self {
        let mut counts = Self::default();
        for kind in kinds {
            counts.resources += 1;
            match kind {
                BindingKind::UniformBuffer => counts.uniform_buffers += 1,
                BindingKind::StorageBuffer => counts.storage_buffers += 1,
                BindingKind::SampledImage => counts.sampled_images += 1,
                BindingKind::StorageImage => counts.storage_images += 1,
                BindingKind::CombinedImageSampler => {
                    counts.sampled_images += 1;
                    counts.samplers += 1;
                }
                // Ray queries have a limit of their own, of at least 16; the scene has one structure.
                BindingKind::AccelerationStructure => {}
            }
        }
        counts
    }

    /// Each kind with Vulkan's name of its limit.
    #[must_use]
    pub fn rows(&self) -> [(&'static str, &'static str, u32); 6] {
        [
            ("uniform buffers", "maxPerStageDescriptorUniformBuffers", self.uniform_buffers),
            ("storage buffers", "maxPerStageDescriptorStorageBuffers", self.storage_buffers),
            ("sampled images", "maxPerStageDescriptorSampledImages", self.sampled_images),
            ("storage images", "maxPerStageDescriptorStorageImages", self.storage_images),
            ("samplers", "maxPerStageDescriptorSamplers", self.samplers),
            ("resources", "maxPerStageResources", self.resources),
        ]
    }
}

/// Checks the passes of a frame, whose scene has bindings of the given kinds, against the limits of a device.
///
/// # Errors
/// [`Error::NoDevice`] with the first pass that has too many bindings, their kind and the limit; a frame that does not fit
/// its shaders is [`Error::Failure`].
pub fn check_stage_limits(graph: &Graph<Work>, scene: &[BindingKind], limits: &StageLimits) -> Result<()> {
    for pass in graph.passes() {
        let counts = stage_bindings(graph, pass, scene)?.rows();
        let beyond = counts.iter().zip(limits.rows()).find(|((_, _, count), (_, _, limit))| count > limit);
        if let Some(((kind, name, count), (_, _, limit))) = beyond {
            return Err(Error::NoDevice(format!(
                "pass `{}` binds {count} {kind} in one stage, this device allows {limit} ({name})",
                pass.name
            )));
        }
    }
    Ok(())
}

/// Bindings of the stage of a pass that has most: compute, or fragment. They are made for all stages of a pass.
fn stage_bindings(graph: &Graph<Work>, pass: &Pass<Work>, scene: &[BindingKind]) -> Result<StageLimits> {
    let own = binding_numbers(pass)?;
    let own = own.iter().map(|(_, used)| kind_of(used.access, graph.resources()[used.resource.index()].info.kind()));
    let (uses_scene, attachments) = match &pass.payload {
        Work::Compute(work) => (work.uses_scene, None),
        Work::Raster(work) => (work.uses_scene, Some(work.colors.len() as u32)),
        Work::Transfer(_) | Work::BuildStructure { .. } | Work::Overlay => (false, None),
    };
    let scene = scene.iter().copied().filter(|_| uses_scene);
    // Base colour and normals of a material.
    let material = [BindingKind::CombinedImageSampler; 2].into_iter().filter(|_| uses_scene && attachments.is_some());
    let mut counts = StageLimits::of(own.chain(scene).chain(material));
    counts.resources += attachments.unwrap_or(0);
    Ok(counts)
}
