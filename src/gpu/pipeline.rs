//! A pipeline, compute or graphics, with its layout.

use std::sync::Arc;

use ash::vk;

use super::check;
use super::device::Device;
use super::work::{Constants, RasterDraw, RasterState};
use crate::error::Result;
use crate::scene::Vertex;
use crate::shader::spirv;

/// A pipeline with its layout.
pub(super) struct Pipeline {
    pub raw: vk::Pipeline,
    pub layout: vk::PipelineLayout,
    pub push_stages: vk::ShaderStageFlags,
    gpu: Arc<Device>,
}

impl Drop for Pipeline {
    fn drop(&mut self) {
        // SAFETY: the executor waits for the GPU before it drops pipelines.
        unsafe {
            self.gpu.device.destroy_pipeline(self.raw, None);
            self.gpu.device.destroy_pipeline_layout(self.layout, None);
        }
    }
}

/// A shader module for the duration of a pipeline's creation.
struct Module<'a> {
    raw: vk::ShaderModule,
    gpu: &'a Device,
}

impl<'a> Module<'a> {
    fn new(gpu: &'a Device, name: &str) -> Result<Self> {
        let words = spirv::words(name)?;
        let info = vk::ShaderModuleCreateInfo::default().code(&words);
        // SAFETY: the words are SPIR-V produced by the project's own compiler run.
        let raw = check(name, unsafe { gpu.device.create_shader_module(&info, None) })?;
        gpu.set_name(raw, name);
        Ok(Self { raw, gpu })
    }
}

impl Drop for Module<'_> {
    fn drop(&mut self) {
        // SAFETY: modules may be destroyed once the pipeline exists.
        unsafe { self.gpu.device.destroy_shader_module(self.raw, None) };
    }
}

fn layout(
    gpu: &Device,
    name: &str,
    sets: &[vk::DescriptorSetLayout],
    push_words: usize,
    stages: vk::ShaderStageFlags,
) -> Result<vk::PipelineLayout> {
    let ranges = [vk::PushConstantRange::default().stage_flags(stages).size(4 * push_words as u32)];
    let mut info = vk::PipelineLayoutCreateInfo::default().set_layouts(sets);
    if push_words > 0 {
        info = info.push_constant_ranges(&ranges);
    }
    // SAFETY: set layouts belong to this device.
    check(name, unsafe { gpu.device.create_pipeline_layout(&info, None) })
}

/// The specialization constants of one module.
struct Specialization {
    entries: Vec<vk::SpecializationMapEntry>,
    values: Vec<u32>,
}

impl Specialization {
    /// Those of `constants` that the shader has.
    fn new(shader: &str, constants: &Constants) -> Result<Self> {
        let interface = spirv::interface(shader)?;
        let given = constants.iter().filter_map(|(name, value)| Some((*interface.constants.get(*name)?, *value)));
        let (ids, values): (Vec<u32>, Vec<u32>) = given.unzip();
        let entry = |(index, id)| vk::SpecializationMapEntry { constant_id: id, offset: 4 * index as u32, size: 4 };
        Ok(Self { entries: ids.into_iter().enumerate().map(entry).collect(), values })
    }

    fn info(&self) -> vk::SpecializationInfo<'_> {
        vk::SpecializationInfo::default().map_entries(&self.entries).data(bytemuck::cast_slice(&self.values))
    }
}

pub(super) fn create_compute(
    gpu: &Arc<Device>,
    cache: vk::PipelineCache,
    shader: &str,
    constants: &Constants,
    push_words: usize,
    sets: &[vk::DescriptorSetLayout],
) -> Result<Pipeline> {
    let module = Module::new(gpu, shader)?;
    let specialization = Specialization::new(shader, constants)?;
    let specialization = specialization.info();
    let stage = vk::PipelineShaderStageCreateInfo::default()
        .stage(vk::ShaderStageFlags::COMPUTE)
        .module(module.raw)
        .name(c"main")
        .specialization_info(&specialization);
    let push_stages = vk::ShaderStageFlags::COMPUTE;
    let layout = layout(gpu, shader, sets, push_words, push_stages)?;
    // Long dispatches go in several parts.
    let flags = vk::PipelineCreateFlags::DISPATCH_BASE;
    let info = [vk::ComputePipelineCreateInfo::default().flags(flags).stage(stage).layout(layout)];
    // SAFETY: all referenced objects are alive.
    let created = unsafe { gpu.device.create_compute_pipelines(cache, &info, None) };
    let mut pipeline = Pipeline { raw: vk::Pipeline::null(), layout, push_stages, gpu: Arc::clone(gpu) };
    pipeline.raw = check(shader, created.map_err(|(_, result)| result))?[0];
    gpu.set_name(pipeline.raw, shader);
    Ok(pipeline)
}

pub(super) fn compile_graphics(
    gpu: &Arc<Device>,
    cache: vk::PipelineCache,
    draw: &RasterDraw,
    color_formats: &[vk::Format],
    depth_format: vk::Format,
    sets: &[vk::DescriptorSetLayout],
) -> Result<Pipeline> {
    let vertex = Module::new(gpu, &draw.vertex)?;
    let fragment = Module::new(gpu, &draw.fragment)?;
    let [of_vertex, of_fragment] =
        [Specialization::new(&draw.vertex, &draw.constants)?, Specialization::new(&draw.fragment, &draw.constants)?];
    let [of_vertex, of_fragment] = [of_vertex.info(), of_fragment.info()];
    let stage = |flags, module: &Module<'_>| {
        vk::PipelineShaderStageCreateInfo::default().stage(flags).module(module.raw).name(c"main")
    };
    let stages = [
        stage(vk::ShaderStageFlags::VERTEX, &vertex).specialization_info(&of_vertex),
        stage(vk::ShaderStageFlags::FRAGMENT, &fragment).specialization_info(&of_fragment),
    ];
    let push_stages = vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT;
    let layout = layout(gpu, &draw.fragment, sets, draw.push.len(), push_stages)?;
    let mut pipeline = Pipeline { raw: vk::Pipeline::null(), layout, push_stages, gpu: Arc::clone(gpu) };
    pipeline.raw = create_graphics(gpu, cache, draw, &stages, layout, color_formats, depth_format)?;
    gpu.set_name(pipeline.raw, &draw.fragment);
    Ok(pipeline)
}

fn create_graphics(
    gpu: &Device,
    cache: vk::PipelineCache,
    draw: &RasterDraw,
    stages: &[vk::PipelineShaderStageCreateInfo<'_>],
    layout: vk::PipelineLayout,
    color_formats: &[vk::Format],
    depth_format: vk::Format,
) -> Result<vk::Pipeline> {
    let state = &draw.state;
    let (bindings, attributes) = vertex_input(state);
    let vertex_input = vk::PipelineVertexInputStateCreateInfo::default()
        .vertex_binding_descriptions(&bindings)
        .vertex_attribute_descriptions(&attributes);
    let assembly = vk::PipelineInputAssemblyStateCreateInfo::default().topology(vk::PrimitiveTopology::TRIANGLE_LIST);
    let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
    let raster = vk::PipelineRasterizationStateCreateInfo::default()
        .polygon_mode(vk::PolygonMode::FILL)
        .cull_mode(state.cull)
        .front_face(vk::FrontFace::COUNTER_CLOCKWISE)
        .line_width(1.0);
    let multisample =
        vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(vk::SampleCountFlags::TYPE_1);
    let depth = vk::PipelineDepthStencilStateCreateInfo::default()
        .depth_test_enable(state.depth_compare.is_some())
        .depth_write_enable(state.depth_write)
        .depth_compare_op(state.depth_compare.unwrap_or(vk::CompareOp::ALWAYS));
    let blends = vec![blend(state); color_formats.len()];
    let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blends);
    let dynamic = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
    let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic);
    let mut rendering = vk::PipelineRenderingCreateInfo::default()
        .color_attachment_formats(color_formats)
        .depth_attachment_format(depth_format);
    let info = [vk::GraphicsPipelineCreateInfo::default()
        .stages(stages)
        .vertex_input_state(&vertex_input)
        .input_assembly_state(&assembly)
        .viewport_state(&viewport)
        .rasterization_state(&raster)
        .multisample_state(&multisample)
        .depth_stencil_state(&depth)
        .color_blend_state(&blend)
        .dynamic_state(&dynamic)
        .layout(layout)
        .push_next(&mut rendering)];
    // SAFETY: all referenced objects and arrays are alive during the call.
    let created = unsafe { gpu.device.create_graphics_pipelines(cache, &info, None) };
    Ok(check(&draw.fragment, created.map_err(|(_, result)| result))?[0])
}

fn blend(state: &RasterState) -> vk::PipelineColorBlendAttachmentState {
    vk::PipelineColorBlendAttachmentState::default()
        .color_write_mask(vk::ColorComponentFlags::RGBA)
        .blend_enable(state.additive_blend)
        .src_color_blend_factor(vk::BlendFactor::ONE)
        .dst_color_blend_factor(vk::BlendFactor::ONE)
        .color_blend_op(vk::BlendOp::ADD)
        .src_alpha_blend_factor(vk::BlendFactor::ONE)
        .dst_alpha_blend_factor(vk::BlendFactor::ONE)
        .alpha_blend_op(vk::BlendOp::ADD)
}

fn vertex_input(
    state: &RasterState,
) -> (Vec<vk::VertexInputBindingDescription>, Vec<vk::VertexInputAttributeDescription>) {
    if !state.scene_vertices {
        return (Vec::new(), Vec::new());
    }
    let binding = vk::VertexInputBindingDescription {
        binding: 0,
        stride: size_of::<Vertex>() as u32,
        input_rate: vk::VertexInputRate::VERTEX,
    };
    let attribute = |location, format, offset: usize| vk::VertexInputAttributeDescription {
        location,
        binding: 0,
        format,
        offset: offset as u32,
    };
    let attributes = vec![
        attribute(0, vk::Format::R32G32B32_SFLOAT, std::mem::offset_of!(Vertex, position_ws)),
        attribute(1, vk::Format::R32_UINT, std::mem::offset_of!(Vertex, normal_oct)),
        attribute(2, vk::Format::R32G32_SFLOAT, std::mem::offset_of!(Vertex, uv)),
        attribute(3, vk::Format::R16G16B16A16_UNORM, std::mem::offset_of!(Vertex, color)),
    ];
    (vec![binding], attributes)
}
