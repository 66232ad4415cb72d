//! Records one pass: its debug label, the barriers of the plan, its work.

use std::ffi::CString;
use std::ops::Range;

use ash::vk;
use glam::Mat4;

use super::compiled::{CompiledFrame, CompiledPass};
use super::physical::{Physical, image_levels};
use super::pipeline::Pipeline;
use super::target::WindowTarget;
use super::work::{ComputeWork, Dispatch, DrawCall, RasterDraw, RasterWork, TransferOp, Viewport, Work};
use crate::error::Result;
use crate::graph::{Barrier, Handle, ImageHandle, ImageLevel, MemoryBarrier, PlannedPass};
use crate::scene::chunks::{Surfaces, in_sight};
use crate::settings::TextureFilter;
use crate::shared::FrameData;

/// Bytes that one command may write to a buffer.
const UPDATE_BYTES: usize = 65_536;

/// Records pass `index` of the frame's graph, with all its repetitions.
pub(super) fn record_pass(frame: &CompiledFrame, commands: vk::CommandBuffer, index: usize, frame_data: &[u8]) {
    let pass = &frame.graph.passes()[index];
    if let Work::Compute(ComputeWork { repeat: Some(repeat), .. }) = &pass.payload {
        record_repetitions(frame, commands, index, 0..repeat.count(), Begins::Yes);
        return;
    }
    begin_label(frame, commands, &pass.name);
    batch(frame, commands, &frame.plan.passes[index]);
    let compiled = &frame.passes[index];
    match &pass.payload {
        Work::Compute(work) => compute(frame, commands, compiled, work, (&work.push, None)),
        Work::Raster(work) => raster(frame, commands, compiled, work, frame_data),
        Work::Transfer(ops) => ops.iter().for_each(|op| transfer(frame, commands, op, frame_data)),
        Work::BuildStructure { level, scratch } => {
            let scratch = frame.resources.buffer(*scratch).0;
            frame.scene().iter().for_each(|scene| scene.record_build(commands, *level, scratch));
        }
        Work::Overlay => {}
    }
    end_label(frame, commands);
    release_after(frame, commands, index);
}

/// Records what follows pass `index` when that is the frame's last one.
fn release_after(frame: &CompiledFrame, commands: vk::CommandBuffer, index: usize) {
    if index + 1 == frame.passes.len() {
        barriers(frame, commands, None, &frame.plan.release);
    }
}

/// Records the pass that draws over the finished frame.
pub(super) fn record_overlay(
    frame: &CompiledFrame,
    commands: vk::CommandBuffer,
    index: usize,
    shown: &mut WindowTarget<'_>,
) -> Result<()> {
    let target = shown.target;
    begin_label(frame, commands, &frame.graph.passes()[index].name);
    batch(frame, commands, &frame.plan.passes[index]);
    let color = [vk::RenderingAttachmentInfo::default()
        .image_view(target.view)
        .image_layout(vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)
        .load_op(vk::AttachmentLoadOp::LOAD)
        .store_op(vk::AttachmentStoreOp::STORE)];
    let area = vk::Rect2D { offset: vk::Offset2D::default(), extent: target.extent };
    let info = vk::RenderingInfo::default().render_area(area).layer_count(1).color_attachments(&color);
    // SAFETY: the plan has brought the image to this layout; the scope is ended below.
    unsafe { frame.gpu.device.cmd_begin_rendering(commands, &info) };
    let drawn = (shown.overlay)(commands, target.extent);
    // SAFETY: ends the scope begun above.
    unsafe { frame.gpu.device.cmd_end_rendering(commands) };
    end_label(frame, commands);
    release_after(frame, commands, index);
    drawn
}

/// Records some rows of a dispatch ([`ComputeWork::rows`]); those before them must have been recorded earlier.
pub(super) fn record_rows(frame: &CompiledFrame, commands: vk::CommandBuffer, index: usize, rows: Range<u32>) {
    let pass = &frame.graph.passes()[index];
    let Work::Compute(work) = &pass.payload else { return };
    begin_label(frame, commands, &pass.name);
    if rows.start == 0 {
        batch(frame, commands, &frame.plan.passes[index]);
    }
    let is_last = Some(rows.end) == work.rows();
    compute(frame, commands, &frame.passes[index], work, (&work.push, Some(rows)));
    end_label(frame, commands);
    if is_last {
        release_after(frame, commands, index);
    }
}

/// Records what is around the work of a pass whose results are there already.
pub(super) fn record_kept(frame: &CompiledFrame, commands: vk::CommandBuffer, index: usize) {
    batch(frame, commands, &frame.plan.passes[index]);
    release_after(frame, commands, index);
}

/// Records what is around the work of passes from `first` on, and not the work: what they leave behind has then all the
/// layouts in which the next frame expects it, whatever it holds.
pub(super) fn record_without_work(frame: &CompiledFrame, commands: vk::CommandBuffer, first: usize) {
    frame.plan.passes.iter().skip(first).for_each(|planned| batch(frame, commands, planned));
    barriers(frame, commands, None, &frame.plan.release);
}

/// Whether a pass has not begun yet in this frame.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Begins {
    Yes,
    No,
}

/// Records some of the repetitions of a repeated pass; those before them must have been recorded earlier.
pub(super) fn record_repetitions(
    frame: &CompiledFrame,
    commands: vk::CommandBuffer,
    index: usize,
    repetitions: Range<u32>,
    begins: Begins,
) {
    let pass = &frame.graph.passes()[index];
    let Work::Compute(work @ ComputeWork { repeat: Some(repeat), .. }) = &pass.payload else { return };
    let planned = &frame.plan.passes[index];
    begin_label(frame, commands, &pass.name);
    let last = repetitions.end == repeat.count();
    let first = repetitions.start;
    for i in repetitions {
        if i == first && begins == Begins::Yes {
            batch(frame, commands, planned);
        } else {
            barriers(frame, commands, None, &planned.between);
        }
        let words = [work.push.as_slice(), &[i / repeat.parts, i % repeat.parts]].concat();
        compute(frame, commands, &frame.passes[index], work, (&words, None));
    }
    end_label(frame, commands);
    if last {
        release_after(frame, commands, index);
    }
}

fn begin_label(frame: &CompiledFrame, commands: vk::CommandBuffer, name: &str) {
    if let (Some(debug), Ok(name)) = (&frame.gpu.debug, CString::new(name)) {
        let label = vk::DebugUtilsLabelEXT::default().label_name(&name);
        // SAFETY: recording; every label is ended in `end_label`.
        unsafe { debug.cmd_begin_debug_utils_label(commands, &label) };
    }
}

fn end_label(frame: &CompiledFrame, commands: vk::CommandBuffer) {
    if let Some(debug) = &frame.gpu.debug {
        // SAFETY: ends the label begun in `begin_label`.
        unsafe { debug.cmd_end_debug_utils_label(commands) };
    }
}

/// What the plan asks for before this pass.
fn batch(frame: &CompiledFrame, commands: vk::CommandBuffer, planned: &PlannedPass) {
    barriers(frame, commands, planned.takeover, &planned.barriers);
}

/// One `vkCmdPipelineBarrier2` with exactly these barriers; none where there are none.
fn barriers(frame: &CompiledFrame, commands: vk::CommandBuffer, takeover: Option<MemoryBarrier>, planned: &[Barrier]) {
    if planned.is_empty() && takeover.is_none() {
        return;
    }
    let global = takeover.map(|memory| {
        vk::MemoryBarrier2::default()
            .src_stage_mask(memory.src_stage)
            .src_access_mask(memory.src_access)
            .dst_stage_mask(memory.dst_stage)
            .dst_access_mask(memory.dst_access)
    });
    let mut buffers = Vec::new();
    let mut images = Vec::new();
    for barrier in planned {
        match frame.resources.list[barrier.resource.index()] {
            Physical::Buffer { raw, .. } => buffers.push(
                vk::BufferMemoryBarrier2::default()
                    .src_stage_mask(barrier.src_stage)
                    .src_access_mask(barrier.src_access)
                    .dst_stage_mask(barrier.dst_stage)
                    .dst_access_mask(barrier.dst_access)
                    .buffer(raw)
                    .size(vk::WHOLE_SIZE),
            ),
            Physical::Image { raw, info, .. } => images.push(
                vk::ImageMemoryBarrier2::default()
                    .src_stage_mask(barrier.src_stage)
                    .src_access_mask(barrier.src_access)
                    .dst_stage_mask(barrier.dst_stage)
                    .dst_access_mask(barrier.dst_access)
                    .old_layout(barrier.old_layout)
                    .new_layout(barrier.new_layout)
                    .image(raw)
                    .subresource_range(image_levels(&info, barrier.levels())),
            ),
        }
    }
    let info = vk::DependencyInfo::default()
        .memory_barriers(global.as_slice())
        .buffer_memory_barriers(&buffers)
        .image_memory_barriers(&images);
    // SAFETY: recording outside a rendering scope; all objects belong to the frame.
    unsafe { frame.gpu.device.cmd_pipeline_barrier2(commands, &info) };
}

fn compute(
    frame: &CompiledFrame,
    commands: vk::CommandBuffer,
    compiled: &CompiledPass,
    work: &ComputeWork,
    (words, rows): (&[u32], Option<Range<u32>>),
) {
    let device = &frame.gpu.device;
    let pipeline = &compiled.pipelines[0];
    let bind_point = vk::PipelineBindPoint::COMPUTE;
    bind(frame, commands, compiled, pipeline, bind_point, work.uses_scene);
    push(frame, commands, pipeline, words);
    // SAFETY: pipeline and sets are bound; indirect buffers are declared in the graph.
    unsafe {
        match work.dispatch {
            Dispatch::Groups([x, y, z]) => {
                let rows = rows.unwrap_or(0..y);
                device.cmd_dispatch_base(commands, 0, rows.start, 0, x, rows.end - rows.start, z);
            }
            Dispatch::Indirect { buffer, offset_bytes } => {
                device.cmd_dispatch_indirect(commands, frame.resources.buffer(buffer).0, offset_bytes);
            }
        }
    }
}

fn bind(
    frame: &CompiledFrame,
    commands: vk::CommandBuffer,
    compiled: &CompiledPass,
    pipeline: &Pipeline,
    bind_point: vk::PipelineBindPoint,
    uses_scene: bool,
) {
    let device = &frame.gpu.device;
    // SAFETY: pipeline, layout and sets were made for each other in `compile_pass`.
    unsafe {
        device.cmd_bind_pipeline(commands, bind_point, pipeline.raw);
        if let Some(set) = compiled.sets.sets.iter().cycle().nth(frame.resources.parity()) {
            device.cmd_bind_descriptor_sets(commands, bind_point, pipeline.layout, 0, &[*set], &[]);
        }
        if let Some(scene) = frame.scene().filter(|_| uses_scene) {
            device.cmd_bind_descriptor_sets(commands, bind_point, pipeline.layout, 1, &scene.scene.sets, &[]);
        }
    }
}

fn push(frame: &CompiledFrame, commands: vk::CommandBuffer, pipeline: &Pipeline, words: &[u32]) {
    if !words.is_empty() {
        let bytes = bytemuck::cast_slice(words);
        // SAFETY: the layout has a range of exactly this size.
        unsafe {
            frame.gpu.device.cmd_push_constants(commands, pipeline.layout, pipeline.push_stages, 0, bytes);
        }
    }
}

fn raster(
    frame: &CompiledFrame,
    commands: vk::CommandBuffer,
    compiled: &CompiledPass,
    work: &RasterWork,
    frame_data: &[u8],
) {
    let attachment = |target: ImageLevel, layout, clear: Option<vk::ClearValue>, store| {
        vk::RenderingAttachmentInfo::default()
            .image_view(frame.resources.view(target.image, Some(target.level)))
            .image_layout(layout)
            .load_op(clear.map_or(vk::AttachmentLoadOp::LOAD, |_| vk::AttachmentLoadOp::CLEAR))
            .store_op(store)
            .clear_value(clear.unwrap_or_default())
    };
    let colors: Vec<_> = work
        .colors
        .iter()
        .map(|c| {
            let clear = c.clear.map(|uint32| vk::ClearValue { color: vk::ClearColorValue { uint32 } });
            attachment(c.target, vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL, clear, vk::AttachmentStoreOp::STORE)
        })
        .collect();
    let depth = work.depth.map(|d| {
        let clear =
            d.clear.map(|depth| vk::ClearValue { depth_stencil: vk::ClearDepthStencilValue { depth, stencil: 0 } });
        let (layout, store) = if d.write {
            (vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL, vk::AttachmentStoreOp::STORE)
        } else {
            (vk::ImageLayout::DEPTH_STENCIL_READ_ONLY_OPTIMAL, vk::AttachmentStoreOp::NONE)
        };
        attachment(d.target, layout, clear, store)
    });
    // An acquired image has the size of the window, which the graph does not know.
    let in_window = window_viewport(frame, work);
    let [width, height] = in_window.map_or(work.extent_px, |v| [v.width_px as u32, v.height_px as u32]);
    let area = vk::Rect2D { offset: vk::Offset2D::default(), extent: vk::Extent2D { width, height } };
    let mut info = vk::RenderingInfo::default().render_area(area).layer_count(1).color_attachments(&colors);
    if let Some(depth) = &depth {
        info = info.depth_attachment(depth);
    }
    // SAFETY: attachments are in the layouts the plan gave them; the scope is ended below.
    unsafe { frame.gpu.device.cmd_begin_rendering(commands, &info) };
    for (draw, pipeline) in work.draws.iter().zip(&compiled.pipelines) {
        bind(frame, commands, compiled, pipeline, vk::PipelineBindPoint::GRAPHICS, work.uses_scene);
        push(frame, commands, pipeline, &draw.push);
        set_viewport(frame, commands, in_window.unwrap_or(draw.viewport));
        record_draw(frame, commands, pipeline, draw, frame_data);
    }
    // SAFETY: ends the scope begun above.
    unsafe { frame.gpu.device.cmd_end_rendering(commands) };
}

/// Where in the window this frame draws, when that is what the pass draws to.
fn window_viewport(frame: &CompiledFrame, work: &RasterWork) -> Option<Viewport> {
    let target = work.colors.first()?.target.image;
    let resource = &frame.graph.resources()[Handle::from(target).index()];
    let info = frame.resources.image(target).2;
    let whole = Viewport::whole(info.width_px, info.height_px);
    let part = frame.resources.shown_part_px.unwrap_or(whole.scissor_px);
    resource.lifetime.is_acquired().then_some(Viewport { scissor_px: part, ..whole })
}

fn set_viewport(frame: &CompiledFrame, commands: vk::CommandBuffer, v: Viewport) {
    let viewport =
        vk::Viewport { x: v.x_px, y: v.y_px, width: v.width_px, height: v.height_px, min_depth: 0.0, max_depth: 1.0 };
    let [x, y, width, height] = v.scissor_px;
    let scissor =
        vk::Rect2D { offset: vk::Offset2D { x: x as i32, y: y as i32 }, extent: vk::Extent2D { width, height } };
    // SAFETY: the pipeline has dynamic viewport and scissor.
    unsafe {
        frame.gpu.device.cmd_set_viewport(commands, 0, &[viewport]);
        frame.gpu.device.cmd_set_scissor(commands, 0, &[scissor]);
    }
}

fn record_draw(
    frame: &CompiledFrame,
    commands: vk::CommandBuffer,
    pipeline: &Pipeline,
    draw: &RasterDraw,
    frame_data: &[u8],
) {
    let device = &frame.gpu.device;
    // SAFETY: pipeline, sets and dynamic state are bound; indirect buffers are declared in the graph.
    unsafe {
        match draw.call {
            DrawCall::Direct { vertex_count, instance_count } => {
                device.cmd_draw(commands, vertex_count, instance_count, 0, 0);
            }
            DrawCall::Indirect { buffer, offset_bytes } => {
                device.cmd_draw_indirect(commands, frame.resources.buffer(buffer).0, offset_bytes, 1, 16);
            }
            DrawCall::Scene { textures, surfaces } => {
                draw_scene(frame, commands, pipeline, (textures, surfaces), frame_data);
            }
        }
    }
}

/// Draws what of the triangles of all `surfaces` may be in sight of the frame's camera, with the textures of each material bound.
///
/// # Safety
/// Pipeline, sets 0 and 1 and dynamic state must be bound, inside a rendering scope.
unsafe fn draw_scene(
    frame: &CompiledFrame,
    commands: vk::CommandBuffer,
    pipeline: &Pipeline,
    (textures, surfaces): (TextureFilter, Surfaces),
    frame_data: &[u8],
) {
    let Some(scene) = frame.scene() else { return };
    let Ok(data) = bytemuck::try_pod_read_unaligned::<FrameData>(frame_data) else { return };
    let device = &frame.gpu.device;
    let mut bound = None;
    // SAFETY: buffers are alive; the vertex layout is the pipeline's; sets fit its layout.
    unsafe {
        device.cmd_bind_vertex_buffers(commands, 0, &[scene.vertices.raw], &[0]);
        device.cmd_bind_index_buffer(commands, scene.indices.raw, 0, vk::IndexType::UINT32);
        for draw in in_sight(&scene.chunks, surfaces, &Mat4::from_cols_array_2d(&data.clip_from_world)) {
            if bound != Some(draw.material) {
                let set = [scene.material_set(draw.material, textures)];
                let point = vk::PipelineBindPoint::GRAPHICS;
                device.cmd_bind_descriptor_sets(commands, point, pipeline.layout, 2, &set, &[]);
                push(frame, commands, pipeline, &[draw.material]);
                bound = Some(draw.material);
            }
            device.cmd_draw_indexed(commands, draw.index_count, 1, draw.first_index, 0, 0);
        }
    }
}

fn transfer(frame: &CompiledFrame, commands: vk::CommandBuffer, op: &TransferOp, frame_data: &[u8]) {
    let device = &frame.gpu.device;
    // SAFETY: the buffers are alive, large enough and declared as sources or destinations of transfers in the graph.
    unsafe {
        match *op {
            TransferOp::FrameData { buffer } => {
                device.cmd_update_buffer(commands, frame.resources.buffer(buffer).0, 0, frame_data);
            }
            TransferOp::SceneLights { buffer } => {
                let raw = frame.resources.buffer(buffer).0;
                let chunks = frame.light_update.iter().flat_map(|bytes| bytes.chunks(UPDATE_BYTES));
                for (index, chunk) in chunks.enumerate() {
                    device.cmd_update_buffer(commands, raw, (index * UPDATE_BYTES) as u64, chunk);
                }
            }
            TransferOp::Fill { buffer, value } => {
                let raw = frame.resources.buffer(buffer).0;
                device.cmd_fill_buffer(commands, raw, 0, vk::WHOLE_SIZE, value);
            }
            TransferOp::Copy { from, to, offset_bytes } => {
                let (source, size) = frame.resources.buffer(from);
                let region = [vk::BufferCopy { src_offset: 0, dst_offset: offset_bytes, size }];
                device.cmd_copy_buffer(commands, source, frame.resources.buffer(to).0, &region);
            }
            TransferOp::CopyImage { from, to } => copy_image(frame, commands, from, to),
        }
    }
}

/// # Safety
/// The images are alive, of one size and format, and in the layouts of a source and a destination.
unsafe fn copy_image(frame: &CompiledFrame, commands: vk::CommandBuffer, from: ImageHandle, to: ImageHandle) {
    let (source, _, info) = frame.resources.image(from);
    let layers =
        vk::ImageSubresourceLayers::default().aspect_mask(vk::ImageAspectFlags::COLOR).layer_count(info.layer_count());
    let [width, height, depth] = info.level_size_px(0);
    let region = [vk::ImageCopy::default().src_subresource(layers).dst_subresource(layers).extent(vk::Extent3D {
        width,
        height,
        depth,
    })];
    let (read, write) = (vk::ImageLayout::TRANSFER_SRC_OPTIMAL, vk::ImageLayout::TRANSFER_DST_OPTIMAL);
    // SAFETY: as the caller has promised.
    unsafe {
        frame.gpu.device.cmd_copy_image(commands, source, read, frame.resources.image(to).0, write, &region);
    }
}
