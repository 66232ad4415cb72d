//! `gbuffer`: rasterises the scene into albedo, normals and reversed-Z depth, and on demand where its surfaces were in the
//! frame before. Section 3.2's deferred renderer.

use ash::vk;

use super::{Frame, SurfaceMotion};
use crate::gpu::{ColorTarget, DepthTarget, DrawCall, RasterDraw, RasterState, RasterWork, Viewport, Work};
use crate::graph::{Access, ImageHandle, Pass};
use crate::scene::chunks::Surfaces;

/// What the pass makes.
#[derive(Clone, Copy, Debug)]
pub struct GBuffer {
    /// Linear base colour; alpha 1 where there is a surface.
    pub albedo: ImageHandle,
    /// Shading and geometric normal, octahedral, turned towards the viewer.
    pub normals: ImageHandle,
    /// near / view z; 0 where there is no surface.
    pub depth: ImageHandle,
    /// Where the surfaces were in the frame before, if the frame's shape asks for it.
    pub motion: Option<MotionImages>,
    /// Radiance of the surface itself; `None` where nothing shines or is unlit.
    pub emission: Option<ImageHandle>,
}

/// What tells where a surface was in the frame before, and whether the surface there was the same.
#[derive(Clone, Copy, Debug)]
pub struct MotionImages {
    /// Offset to the surface's place in the frame before in pixels, y down; its near / view z there, 0 where it was behind the
    /// camera. Both are 0 where there is no surface.
    pub motion: ImageHandle,
    /// `normals` of the frame before.
    pub previous_normals: ImageHandle,
    /// `depth` of the frame before.
    pub previous_depth: ImageHandle,
}

/// Adds the pass.
pub fn add(frame: &mut Frame) -> GBuffer {
    let gbuffer = declare(frame);
    let targets: Vec<_> = [gbuffer.albedo, gbuffer.normals]
        .into_iter()
        .chain(gbuffer.motion.map(|m| m.motion))
        .chain(gbuffer.emission)
        .collect();
    let [width, height] = [frame.shape.width_px, frame.shape.height_px];
    let work = RasterWork {
        colors: targets.iter().map(|image| ColorTarget { target: (*image).into(), clear: Some([0; 4]) }).collect(),
        depth: Some(DepthTarget { target: gbuffer.depth.into(), clear: Some(0.0), write: true }),
        extent_px: [width, height],
        draws: [Surfaces::Plain, Surfaces::Detailed].map(|surfaces| draw(frame, surfaces)).to_vec(),
        uses_scene: true,
    };
    let pass = Pass::new("gbuffer", Work::Raster(work))
        .bind("frame", frame.data, Access::GraphicsUniform)
        .uses(gbuffer.depth, Access::DepthAttachmentWrite);
    let pass = targets.into_iter().fold(pass, |pass, image| pass.uses(image, Access::ColorAttachmentWrite));
    let moves = frame.shape.surface_motion == Some(SurfaceMotion::Vertices);
    let previous = frame.scene.as_mut().filter(|_| moves).map(|scene| scene.declare_previous(&mut frame.graph));
    let pass =
        previous.into_iter().fold(pass, |pass, vertices| pass.bind("previous_vertices", vertices, Access::VertexRead));
    frame.graph.add_pass(frame.scene.iter().fold(pass, |pass, scene| scene.drawn_by(pass)));
    gbuffer
}

/// Normals and depth are handed on to the next frame where it asks for the motion of surfaces.
fn declare(frame: &mut Frame) -> GBuffer {
    let albedo = frame.image("gbuffer_albedo", vk::Format::R16G16B16A16_SFLOAT);
    let emission = frame.shape.has_emission.then(|| frame.image("gbuffer_emission", vk::Format::R32G32B32A32_SFLOAT));
    let (normals_format, depth_format) = (vk::Format::R32G32_UINT, vk::Format::D32_SFLOAT);
    if frame.shape.surface_motion.is_none() {
        let normals = frame.image("gbuffer_normals", normals_format);
        let depth = frame.image("gbuffer_depth", depth_format);
        return GBuffer { albedo, normals, depth, motion: None, emission };
    }
    let normals = frame.history_image("gbuffer_normals", normals_format);
    let depth = frame.history_image("gbuffer_depth", depth_format);
    let motion = frame.image("gbuffer_motion", vk::Format::R32G32B32A32_SFLOAT);
    let motion = MotionImages { motion, previous_normals: normals.previous, previous_depth: depth.previous };
    GBuffer { albedo, normals: normals.current, depth: depth.current, motion: Some(motion), emission }
}

/// Most materials are plain. Their pipeline reads one texture, interpolates less, and discards nothing, so that hardware may
/// test the depth first.
fn draw(frame: &Frame, surfaces: Surfaces) -> RasterDraw {
    let (vertex, fragment) = match frame.shape.surface_motion {
        None => ("", ""),
        Some(SurfaceMotion::Camera) => ("_motion", "_motion"),
        Some(SurfaceMotion::Vertices) => ("_motion_vertices", "_motion"),
    };
    let emission = if frame.shape.has_emission { "_emission" } else { "" };
    RasterDraw {
        vertex: format!("gbuffer/draw_scene{vertex}.vert"),
        fragment: format!("gbuffer/draw_scene{fragment}{emission}.frag"),
        constants: vec![
            ("CULLS_BACK_FACES", frame.shape.culls_back_faces.into()),
            ("IS_PLAIN", (surfaces == Surfaces::Plain).into()),
        ],
        // The material index, pushed per draw of the scene.
        push: vec![0],
        state: RasterState {
            additive_blend: false,
            depth_compare: Some(vk::CompareOp::GREATER),
            depth_write: true,
            cull: vk::CullModeFlags::NONE,
            scene_vertices: true,
        },
        viewport: Viewport::whole(frame.shape.width_px, frame.shape.height_px),
        call: DrawCall::Scene { textures: frame.shape.texture_filter, surfaces },
    }
}
