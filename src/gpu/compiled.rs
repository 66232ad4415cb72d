//! A planned frame graph with everything that recording it takes: resources, pipelines and descriptor sets.

use std::sync::Arc;

use ash::vk;
use rayon::prelude::*;

use super::context::Gpu;
use super::descriptors::{Bound, Sets};
use super::device::Device;
use super::interfaces::{binding_numbers, check_interfaces, kind_of};
use super::physical::{Physical, image_levels};
use super::pipeline::Pipeline;
use super::pipelines::Pipelines;
use super::resources::{Imports, Resources};
use super::scene_set::SceneSet;
use super::stage_limits::check_stage_limits;
use super::transfer::{self, Subresource};
use super::work::{RasterWork, TransferOp, Work};
use crate::error::{Error, Result};
use crate::graph::{Graph, Handle, ImageHandle, ImageInfo, ImageLevel, Lifetime, Pass, Plan, Use, plan};
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
    pub imports: Imports,
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
    pub fn new(gpu: &Gpu, graph: Graph<Work>, imports: Imports) -> Result<Self> {
        let mut plan = plan(&graph).map_err(|e| Error::Failure(format!("frame graph: {e}")))?;
        check_interfaces(&graph)?;
        let scene = imports.scene.as_ref().map_or_else(Vec::new, |scene| scene.binding_kinds());
        check_stage_limits(&graph, &scene, &gpu.report().limits.stage)?;
        let resources = Resources::new(gpu, &graph, &mut plan, &imports)?;
        let (passes, gpu_kept) = (Vec::new(), Arc::clone(gpu));
        let mut frame = Self {
            graph,
            plan,
            resources,
            passes,
            imports,
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

    /// The scene that its passes read, if they read one.
    pub fn scene(&self) -> Option<&SceneSet> {
        self.imports.scene.as_deref()
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
        let read = self.plan.initial.iter().filter(|(level, _)| self.begun && self.is_previous(level.image));
        let layouts: Vec<_> = read.map(|&(level, layout)| (level, self.final_layout(level), layout)).collect();
        if layouts.iter().all(|(_, left, layout)| left == layout) {
            return Ok(());
        }
        transfer::submit_once(&self.gpu, |commands| {
            for (level, left, layout) in layouts {
                self.change_layout(commands, level, left, layout);
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

    /// Layout in which the frame leaves a level of an image: that of its last use.
    pub fn final_layout(&self, ImageLevel { image, level }: ImageLevel) -> vk::ImageLayout {
        let info = self.graph.resources()[Handle::from(image).index()].info;
        let is_of_level = |used: &&Use| used.resource == image.into() && info.levels(used.level).contains(&level);
        let mut uses = self.graph.passes().iter().rev().flat_map(|p| &p.uses).filter(is_of_level);
        uses.next().map_or(vk::ImageLayout::UNDEFINED, |used| used.access.sync(info.kind()).layout)
    }

    /// Persistent images get their contents, if there are any, and the layout that the first frame expects, once.
    fn initial_layouts(&self) -> Result<()> {
        let filled = |level: &ImageLevel| self.graph.resources()[Handle::from(level.image).index()].contents.as_ref();
        for (level, layout) in &self.plan.initial {
            if let Some(texels) = filled(level) {
                let (raw, _, ImageInfo { width_px, height_px, .. }) = self.resources.image(level.image);
                let whole = Subresource { mip: 0, layer: 0, width_px, height_px, texels };
                transfer::upload_raw_image(&self.gpu, raw, &[whole], *layout)?;
            }
        }
        transfer::submit_once(&self.gpu, |commands| {
            for &(level, layout) in self.plan.initial.iter().filter(|(level, _)| filled(level).is_none()) {
                self.change_layout(commands, level, vk::ImageLayout::UNDEFINED, layout);
            }
        })
    }

    fn change_layout(
        &self,
        commands: vk::CommandBuffer,
        ImageLevel { image, level }: ImageLevel,
        old: vk::ImageLayout,
        new: vk::ImageLayout,
    ) {
        let (raw, _, info) = self.resources.image(image);
        transfer::image_layout(&self.gpu, commands, raw, image_levels(&info, level..level + 1), old, new);
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
            Work::Transfer(_) | Work::BuildStructure { .. } | Work::Overlay => Vec::new(),
        };
        Ok(CompiledPass { pipelines, sets })
    }

    fn raster_pipelines(&self, pipelines: &Pipelines, work: &RasterWork, sets: &Sets) -> Result<Vec<Arc<Pipeline>>> {
        let formats: Vec<_> = work.colors.iter().map(|c| self.resources.image(c.target.image).2.format).collect();
        let depth = work.depth.map_or(vk::Format::UNDEFINED, |d| self.resources.image(d.target.image).2.format);
        let layouts = self.set_layouts(sets, work.uses_scene, true)?;
        let draws = work.draws.iter();
        draws.map(|draw| pipelines.graphics(draw, &formats, depth, &layouts)).collect()
    }

    fn set_layouts<'a>(&'a self, sets: &'a Sets, uses_scene: bool, raster: bool) -> Result<Vec<&'a Sets>> {
        let mut layouts = vec![sets];
        if uses_scene {
            let scene = self.scene().ok_or_else(|| Error::Failure("a pass needs a scene".to_owned()))?;
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
            let view = || self.resources.view(place(used), used.level);
            match (self.resources.list[place(used).index()], kind_of(used.access, kind)) {
                (Physical::Buffer { raw, size_bytes }, BindingKind::UniformBuffer) => {
                    Bound::Uniform { buffer: raw, size_bytes }
                }
                (Physical::Buffer { raw, size_bytes }, _) => Bound::Storage { buffer: raw, size_bytes },
                (Physical::Image { .. }, BindingKind::SampledImage) => {
                    Bound::SampledImage { view: view(), layout: used.access.sync(kind).layout }
                }
                (Physical::Image { .. }, _) => Bound::StorageImage { view: view() },
            }
        };
        Ok(binding_numbers(pass)?.iter().map(|(number, used)| (*number, bound(used))).collect())
    }
}
