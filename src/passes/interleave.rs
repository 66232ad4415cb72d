//! `interleave`: splitting the depth buffer for n x n interleaved sampling, and compositing the sub-images with
//! a blur that stops at discontinuities (section 4.1; Segovia et al. 2006).

use ash::vk;

use super::gbuffer::GBuffer;
use super::lgh_shape::LghShape;
use super::shadow_rays::ShadowEstimates;
use super::{Frame, shader};
use crate::gpu::{ComputeWork, DepthTarget, DrawCall, RasterDraw, RasterState, RasterWork, Viewport, Work};
use crate::graph::{Access, BufferHandle, ImageHandle, ImageInfo, Pass};

/// Adds the pass that deals the depth buffer to the sub-images; without interleaving it is the G-buffer's.
pub fn split_depth(frame: &mut Frame, shape: &LghShape, gbuffer: &GBuffer) -> ImageHandle {
    if shape.interleave == 1 {
        return gbuffer.depth;
    }
    let [width_px, height_px] = shape.interleaved_px();
    let info = ImageInfo::new(vk::Format::D32_SFLOAT, width_px, height_px);
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
        depth: Some(DepthTarget { target: depth.into(), clear: Some(0.0), write: true }),
        extent_px: [width_px, height_px],
        draws: vec![draw],
        uses_scene: false,
    };
    frame.graph.add_pass(
        Pass::new("interleave/split_depth", Work::Raster(work))
            .bind("frame", frame.data, Access::GraphicsUniform)
            .bind("depth_image", gbuffer.depth, Access::FragmentSampled)
            .uses(depth, Access::DepthAttachmentWrite),
    );
    depth
}

/// The lighting put together.
#[derive(Clone, Copy, Debug)]
pub struct Composite {
    /// Lighting in the picture's layout.
    pub lighting: ImageHandle,
    /// The discontinuity buffer; `None` without interleaving.
    pub edges: Option<BufferHandle>,
}

/// Adds the compositing passes.
pub fn composite(frame: &mut Frame, shape: &LghShape, gbuffer: &GBuffer, lighting: ImageHandle) -> Composite {
    if shape.interleave == 1 {
        return Composite { lighting, edges: None };
    }
    let pixels = u64::from(frame.shape.width_px) * u64::from(frame.shape.height_px);
    let edges = frame.graph.transient_buffer("discontinuities", 4 * pixels);
    let pass = frame
        .compute("interleave/find_edges", shader("interleave/find_edges", frame.per_pixel()))
        .bind("depth_image", gbuffer.depth, Access::ComputeSampled)
        .bind("normals_image", gbuffer.normals, Access::ComputeSampled)
        .bind("edges", edges, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    let input = Input { what: "lighting", image: lighting, is_lighting: true };
    let blurred = blur(frame, gbuffer, edges, input);
    Composite { lighting: blurred, edges: Some(edges) }
}

/// Adds the passes that take the n x n pattern out of the shadow estimates: each pixel's are of its sub-image.
pub fn smooth_estimates(
    frame: &mut Frame,
    gbuffer: &GBuffer,
    composite: &Composite,
    estimates: ShadowEstimates,
) -> ShadowEstimates {
    let Some(edges) = composite.edges else { return estimates };
    let mut smooth = |what, image| blur(frame, gbuffer, edges, Input { what, image, is_lighting: false });
    let shadowed = smooth("shadowed", estimates.shadowed);
    let unshadowed = smooth("unshadowed", estimates.unshadowed);
    ShadowEstimates { shadowed, unshadowed, ..estimates }
}

/// An image to blur.
#[derive(Clone, Copy)]
struct Input {
    what: &'static str,
    image: ImageHandle,
    /// The lighting, in the interleaved layout, rather than an estimate in the picture's, which counts as much as its alpha.
    is_lighting: bool,
}

/// Blurs along x, then along y.
fn blur(frame: &mut Frame, gbuffer: &GBuffer, edges: BufferHandle, input: Input) -> ImageHandle {
    let mut image = input.image;
    for (axis, name) in ["x", "y"].into_iter().enumerate() {
        let blurred = frame.image(&format!("{}_blurred_{name}", input.what), vk::Format::R32G32B32A32_SFLOAT);
        let constants = vec![
            ("AXIS", axis as u32),
            ("READS_INTERLEAVED", u32::from(input.is_lighting && axis == 0)),
            ("WEIGHTED", u32::from(!input.is_lighting)),
        ];
        let work = ComputeWork { constants, ..shader("interleave/blur", frame.per_pixel()) };
        let pass = frame
            .compute(&format!("interleave/blur_{}_{name}", input.what), work)
            .bind("input_image", image, Access::ComputeSampled)
            .bind("edges", edges, Access::ComputeRead)
            .bind("out_image", blurred, Access::ComputeWrite)
            .bind("depth_image", gbuffer.depth, Access::ComputeSampled);
        frame.graph.add_pass(pass);
        image = blurred;
    }
    image
}
