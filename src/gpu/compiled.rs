//! A planned frame graph with everything that recording it takes: resources, pipelines and descriptor sets.

use std::sync::Arc;

use ash::vk;
use rayon::prelude::*;

use super::context::Gpu;
use super::descriptors::{Bound, Sets};
use super::device::Device;
use super::interfaces::{binding_numbers, check_interfaces, kind_of};
use super::physical::Physical;
use super::pipeline::Pipeline;
use super::pipelines::Pipelines;
use super::resources::{Resources, aspect};
use super::scene_set::SceneSet;
use super::transfer;
use super::work::{RasterWork, TransferOp, Work};
use crate::error::{Error, Result};
use crate::graph::{Graph, Handle, ImageHandle, Lifetime, Pass, Plan, Use, plan};
use crate::shader::interface::BindingKind;

/// A pass ready to record.
pub(super) struct CompiledPass {
    pub pipelines: Vec<Arc<Pipeline>>,
    /// One, or one for each place of the pairs that it uses.
    pub sets: Sets,
}

/// A compiled frame: made once, recorded in every frame.
pub(super) struct CompiledFrame {
    pub graph: Graph<Work>,
    pub plan: Plan,
    pub resources: Resources,
    pub passes: Vec<CompiledPass>,
    pub scene: Option<Arc<SceneSet>>,
    /// New contents of the scene's lights, for the next frame.
    pub light_update: Option<Vec<u8>>,
    /// Whether a frame has begun.
    begun: bool,
    /// Whether the next frame finds something in what its history has of the frame before.
    pub history_is_valid: bool,
    pub gpu: Arc<Device>,
}

impl CompiledFrame {
    /// Plans the graph and creates everything it needs.
    ///
    /// # Errors
    /// When the graph is wrong (a bug of ours), or the device runs out of memory.
    pub fn new(gpu: &Gpu, graph: Graph<Work>, scene: Option<Arc<SceneSet>>) -> Result<Self> {
        let mut plan = plan(&graph).map_err(|e| Error::Failure(format!("frame graph: {e}")))?;
        check_interfaces(&graph)?;
        let resources = Resources::new(gpu, &graph, &mut plan, scene.as_deref())?;
        let (passes, gpu_kept) = (Vec::new(), Arc::clone(gpu));
        let mut frame = Self {
            graph,
            plan,
            resources,
            passes,
            scene,
            light_update: None,
            begun: false,
            history_is_valid: false,
            gpu: gpu_kept,
        };
        let compile = |pass| frame.compile_pass(&gpu.pipelines, pass);
        frame.passes = frame.graph.passes().par_iter().map(compile).collect::<Result<_>>()?;
        frame.initial_layouts()?;
        Ok(frame)
    }

    /// Begins a frame: from the second on, what the one before wrote is what this one has of it.
    pub fn begin(&mut self) {
        if self.begun {
            self.resources.change_places();
        }
        (self.begun, self.history_is_valid) = (true, true);
    }

    /// Brings what the last frame has read of the one before into the layouts in which that frame began; waits. The
    /// last frame can then be recorded once more.
    pub fn rewind_history(&self) -> Result<()> {
        let read = self.plan.initial.iter().filter(|(image, _)| self.begun && self.is_previous(*image));
        let layouts: Vec<_> = read.map(|&(image, layout)| (image, self.final_layout(image), layout)).collect();
        if layouts.iter().all(|(_, left, layout)| left == layout) {
            return Ok(());
        }
        transfer::submit_once(&self.gpu, |commands| {
            for (image, left, layout) in layouts {
                let (raw, _, info) = self.resources.image(image);
                transfer::image_layout(&self.gpu, commands, raw, aspect(&info), left, layout);
            }
        })
    }

    fn is_previous(&self, image: ImageHandle) -> bool {
        matches!(self.graph.resources()[Handle::from(image).index()].lifetime, Lifetime::Previous { .. })
    }

    /// The buffer, and its size in bytes, that new lights of the scene are written to.
    pub fn lights_target(&self) -> Option<(vk::Buffer, u64)> {
        let lights = |op: &TransferOp| match op {
            TransferOp::SceneLights { buffer } => Some(self.resources.buffer(*buffer)),
            _ => None,
        };
        self.graph.passes().iter().find_map(|pass| match &pass.payload {
            Work::Transfer(ops) => ops.iter().find_map(lights),
            _ => None,
        })
    }

    /// Layout in which the frame leaves an image: that of its last use.
    pub fn final_layout(&self, image: ImageHandle) -> vk::ImageLayout {
        let mut uses = self.graph.passes().iter().rev().flat_map(|p| &p.uses).filter(|u| u.resource == image.into());
        let kind = self.graph.resources()[Handle::from(image).index()].info.kind();
        uses.next().map_or(vk::ImageLayout::UNDEFINED, |u| u.access.sync(kind).layout)
    }

    /// Persistent images get the layout that the first frame expects, once.
    fn initial_layouts(&self) -> Result<()> {
        transfer::submit_once(&self.gpu, |commands| {
            for (image, layout) in &self.plan.initial {
                let (raw, _, info) = self.resources.image(*image);
                let undefined = vk::ImageLayout::UNDEFINED;
                transfer::image_layout(&self.gpu, commands, raw, aspect(&info), undefined, *layout);
            }
        })
    }

    fn compile_pass(&self, pipelines: &Pipelines, pass: &Pass<Work>) -> Result<CompiledPass> {
        let stages = match pass.payload {
            Work::Compute(_) => vk::ShaderStageFlags::COMPUTE,
            _ => vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT,
        };
        let partner = |used: &Use| self.graph.resources()[used.resource.index()].lifetime.partner();
        let mut contents = vec![self.bindings(pass, |used| used.resource)?];
        if pass.uses.iter().any(|used| partner(used).is_some()) {
            contents.push(self.bindings(pass, |used| partner(used).unwrap_or(used.resource))?);
        }
        let sets = Sets::new(&self.gpu, &pass.name, stages, &contents)?;
        let pipelines = match &pass.payload {
            Work::Compute(work) => {
                let layouts = self.set_layouts(&sets, work.uses_scene, false)?;
                vec![pipelines.compute(&work.shader, &work.constants, work.push_words(), &layouts)?]
            }
            Work::Raster(work) => self.raster_pipelines(pipelines, work, &sets)?,
            Work::Transfer(_) | Work::Overlay => Vec::new(),
        };
        Ok(CompiledPass { pipelines, sets })
    }

    fn raster_pipelines(&self, pipelines: &Pipelines, work: &RasterWork, sets: &Sets) -> Result<Vec<Arc<Pipeline>>> {
        let formats: Vec<_> = work.colors.iter().map(|c| self.resources.image(c.image).2.format).collect();
        let depth = work.depth.map_or(vk::Format::UNDEFINED, |d| self.resources.image(d.image).2.format);
        let layouts = self.set_layouts(sets, work.uses_scene, true)?;
        let draws = work.draws.iter();
        draws.map(|draw| pipelines.graphics(draw, &formats, depth, &layouts)).collect()
    }

    fn set_layouts<'a>(&'a self, sets: &'a Sets, uses_scene: bool, raster: bool) -> Result<Vec<&'a Sets>> {
        let mut layouts = vec![sets];
        if uses_scene {
            let scene = self.scene.as_ref().ok_or_else(|| Error::Failure("a pass needs a scene".to_owned()))?;
            layouts.push(&scene.scene);
            if raster {
                layouts.push(&scene.materials);
            }
        }
        Ok(layouts)
    }

    /// What a pass's bindings point at, with what is in the place of each resource.
    fn bindings(&self, pass: &Pass<Work>, place: impl Fn(&Use) -> Handle) -> Result<Vec<(u32, Bound)>> {
        let bound = |used: &Use| {
            let kind = self.graph.resources()[used.resource.index()].info.kind();
            match (self.resources.list[place(used).index()], kind_of(used.access, kind)) {
                (Physical::Buffer { raw, size_bytes }, BindingKind::UniformBuffer) => {
                    Bound::Uniform { buffer: raw, size_bytes }
                }
                (Physical::Buffer { raw, size_bytes }, _) => Bound::Storage { buffer: raw, size_bytes },
                (Physical::Image { view, .. }, BindingKind::SampledImage) => {
                    Bound::SampledImage { view, layout: used.access.sync(kind).layout }
                }
                (Physical::Image { view, .. }, _) => Bound::StorageImage { view },
            }
        };
        Ok(binding_numbers(pass)?.iter().map(|(number, used)| (*number, bound(used))).collect())
    }
}

/// Bytes per texel of the formats the frame uses.
pub(super) fn texel_bytes(format: vk::Format) -> u64 {
    match format {
        vk::Format::R32G32B32A32_SFLOAT | vk::Format::R32G32B32A32_UINT => 16,
        vk::Format::R16G16B16A16_SFLOAT | vk::Format::R32G32_UINT => 8,
        _ => 4,
    }
}
