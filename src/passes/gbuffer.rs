//! `gbuffer`: rasterises the scene into albedo, normals and reversed-Z depth. Section 3.2's deferred renderer.

use ash::vk;

use super::Frame;
use crate::gpu::{ColorTarget, DepthTarget, DrawCall, RasterDraw, RasterState, RasterWork, Viewport, Work};
use crate::graph::{Access, ImageHandle, Pass};

/// What the pass makes.
#[derive(Clone, Copy, Debug)]
pub struct GBuffer {
    /// Linear base colour; alpha 1 where there is a surface.
    pub albedo: ImageHandle,
    /// Shading and geometric normal, octahedral, turned towards the viewer.
    pub normals: ImageHandle,
    /// near / view z; 0 where there is no surface.
    pub depth: ImageHandle,
}

/// Adds the pass.
pub fn add(frame: &mut Frame) -> GBuffer {
    let albedo = frame.image("gbuffer_albedo", vk::Format::R16G16B16A16_SFLOAT);
    let normals = frame.image("gbuffer_normals", vk::Format::R32G32_UINT);
    let depth = frame.image("gbuffer_depth", vk::Format::D32_SFLOAT);
    let [width, height] = [frame.shape.width_px, frame.shape.height_px];
    let draw = RasterDraw {
        vertex: "gbuffer/draw_scene.vert".to_owned(),
        fragment: "gbuffer/draw_scene.frag".to_owned(),
        constants: Vec::new(),
        // The material index, pushed per draw of the scene.
        push: vec![0],
        state: RasterState {
            additive_blend: false,
            depth_compare: Some(vk::CompareOp::GREATER),
            depth_write: true,
            cull: vk::CullModeFlags::NONE,
            scene_vertices: true,
        },
        viewport: Viewport::whole(width, height),
        call: DrawCall::Scene,
    };
    let work = RasterWork {
        colors: vec![
            ColorTarget { target: albedo.into(), clear: Some([0; 4]) },
            ColorTarget { target: normals.into(), clear: Some([0; 4]) },
        ],
        depth: Some(DepthTarget { target: depth.into(), clear: Some(0.0), write: true }),
        extent_px: [width, height],
        draws: vec![draw],
        uses_scene: true,
    };
    let pass = Pass::new("gbuffer", Work::Raster(work))
        .bind("frame", frame.data, Access::GraphicsUniform)
        .uses(albedo, Access::ColorAttachmentWrite)
        .uses(normals, Access::ColorAttachmentWrite)
        .uses(depth, Access::DepthAttachmentWrite);
    frame.graph.add_pass(frame.scene.iter().fold(pass, |pass, scene| scene.drawn_by(pass)));
    GBuffer { albedo, normals, depth }
}
