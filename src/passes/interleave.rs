//! `interleave`: splitting the depth buffer for n x n interleaved sampling, and compositing the sub-images with
//! a blur that stops at discontinuities (section 4.1; Segovia et al. 2006).

use ash::vk;

use super::gbuffer::GBuffer;
use super::{Frame, shader};
use crate::gpu::{ComputeWork, DepthTarget, DrawCall, RasterDraw, RasterState, RasterWork, Viewport, Work};
use crate::graph::{Access, BufferHandle, ImageHandle, ImageInfo, Pass};

/// Adds the pass that deals the depth buffer to the sub-images; without interleaving it is the G-buffer's.
pub fn split_depth(frame: &mut Frame, gbuffer: &GBuffer) -> ImageHandle {
    if frame.shape.interleave == 1 {
        return gbuffer.depth;
    }
    let [width_px, height_px] = frame.shape.interleaved_px();
    let info = ImageInfo { format: vk::Format::D32_SFLOAT, width_px, height_px };
    let depth = frame.graph.transient_image("interleaved_depth", info);
    let draw = RasterDraw {
        vertex: "light_volumes/cover_screen.vert".to_owned(),
        fragment: "interleave/split_depth.frag".to_owned(),
        constants: Vec::new(),
        push: Vec::new(),
        state: RasterState {
            additive_blend: false,
            depth_compare: Some(vk::CompareOp::ALWAYS),
            depth_write: true,
            cull: vk::CullModeFlags::NONE,
            scene_vertices: false,
        },
        viewport: Viewport::whole(width_px, height_px),
        call: DrawCall::Direct { vertex_count: 3, instance_count: 1 },
    };
    let work = RasterWork {
        colors: Vec::new(),
        depth: Some(DepthTarget { image: depth, clear: Some(0.0), write: true }),
        extent_px: [width_px, height_px],
        draws: vec![draw],
        uses_scene: false,
    };
    frame.graph.add_pass(
        Pass::new("interleave/split_depth", Work::Raster(work))
            .bind(0, frame.data, Access::GraphicsUniform)
            .bind(1, gbuffer.depth, Access::FragmentSampled)
            .uses(depth, Access::DepthAttachmentWrite),
    );
    depth
}

/// Adds the compositing passes; gives the lighting in the picture's layout.
pub fn composite(frame: &mut Frame, gbuffer: &GBuffer, lighting: ImageHandle) -> ImageHandle {
    if frame.shape.interleave == 1 {
        return lighting;
    }
    let pixels = u64::from(frame.shape.width_px) * u64::from(frame.shape.height_px);
    let edges = frame.graph.transient_buffer("discontinuities", 4 * pixels);
    let pass = frame
        .compute("interleave/find_edges", shader("interleave/find_edges", frame.per_pixel()))
        .bind(1, gbuffer.depth, Access::ComputeSampled)
        .bind(2, gbuffer.normals, Access::ComputeSampled)
        .bind(3, edges, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    let along_x = blur(frame, gbuffer, 0, lighting, edges);
    blur(frame, gbuffer, 1, along_x, edges)
}

fn blur(frame: &mut Frame, gbuffer: &GBuffer, axis: u32, lighting: ImageHandle, edges: BufferHandle) -> ImageHandle {
    let name = ["x", "y"][axis as usize];
    let blurred = frame.image(&format!("lighting_blurred_{name}"), vk::Format::R16G16B16A16_SFLOAT);
    let work = ComputeWork { constants: vec![axis], ..shader("interleave/blur", frame.per_pixel()) };
    let pass = frame
        .compute(&format!("interleave/blur_{name}"), work)
        .bind(1, lighting, Access::ComputeSampled)
        .bind(2, edges, Access::ComputeRead)
        .bind(3, blurred, Access::ComputeWrite)
        .bind(4, gbuffer.depth, Access::ComputeSampled);
    frame.graph.add_pass(pass);
    blurred
}
