//! `half_picture`: indirect light for every second pixel of every second row. Passes between [`shrink`] and [`enlarge`] see a
//! picture of half the width and height; the pixels left out take the light of those around them that show the same surface
//! (joint bilateral upsampling, Kopf et al. 2007).

use ash::vk;

use super::compose::Indirect;
use super::gbuffer::{GBuffer, MotionImages};
use super::{Frame, shader};
use crate::gpu::ComputeWork;
use crate::graph::{Access, BufferHandle, ImageHandle};

/// The whole picture, while the frame is that of the half one.
#[derive(Clone, Copy, Debug)]
pub struct WholePicture {
    size_px: [u32; 2],
    data: BufferHandle,
}

/// Pixels of a picture that has every second one.
#[must_use]
pub fn halved(size_px: [u32; 2]) -> [u32; 2] {
    size_px.map(|edge| edge.div_ceil(2))
}

/// Adds the pass that picks the pixels, and makes the frame that of the half picture until [`enlarge`].
pub fn shrink(frame: &mut Frame, gbuffer: &GBuffer) -> (WholePicture, GBuffer) {
    let whole = WholePicture { size_px: [frame.shape.width_px, frame.shape.height_px], data: frame.data };
    let half_data = frame.copy_of_constants("half_frame_data");
    let [width, height] = halved(whole.size_px);
    (frame.shape.width_px, frame.shape.height_px) = (width, height);
    let half = declare(frame, gbuffer);
    let motion = gbuffer.motion.zip(half.motion);
    let variant = if motion.is_some() { "_motion" } else { "" };
    let work = shader(&format!("half_picture/pick_pixels{variant}"), frame.per_pixel());
    let mut pass = frame
        .compute("half_picture/pick_pixels", work)
        .bind("half_frame", half_data, Access::ComputeReadWrite)
        .bind("depth_image", gbuffer.depth, Access::ComputeSampled)
        .bind("normals_image", gbuffer.normals, Access::ComputeSampled)
        .bind("out_depth", half.depth, Access::ComputeWrite)
        .bind("out_normals", half.normals, Access::ComputeWrite);
    if let Some((whole, half)) = motion {
        pass = pass.bind("motion_image", whole.motion, Access::ComputeSampled).bind(
            "out_motion",
            half.motion,
            Access::ComputeWrite,
        );
    }
    frame.graph.add_pass(pass);
    frame.data = half_data;
    (whole, half)
}

/// Images like the G-buffer's, in formats that every device can store to. Albedo and emission are only of the whole picture.
fn declare(frame: &mut Frame, gbuffer: &GBuffer) -> GBuffer {
    let (normals_format, depth_format) = (vk::Format::R32G32B32A32_UINT, vk::Format::R32_SFLOAT);
    if gbuffer.motion.is_none() {
        let normals = frame.image("half_normals", normals_format);
        let depth = frame.image("half_depth", depth_format);
        return GBuffer { normals, depth, ..*gbuffer };
    }
    let normals = frame.history_image("half_normals", normals_format);
    let depth = frame.history_image("half_depth", depth_format);
    let motion = frame.image("half_motion", vk::Format::R32G32B32A32_SFLOAT);
    let motion = MotionImages { motion, previous_normals: normals.previous, previous_depth: depth.previous };
    GBuffer { normals: normals.current, depth: depth.current, motion: Some(motion), ..*gbuffer }
}

/// Adds the passes that bring the half picture's indirect light to all pixels, and makes the frame that of the whole picture
/// again. Gives the light with its shadows, per unit albedo.
pub fn enlarge(
    frame: &mut Frame,
    whole: WholePicture,
    gbuffer: &GBuffer,
    half: &GBuffer,
    indirect: &Indirect,
) -> ImageHandle {
    let shadowed = apply_shadows(frame, indirect);
    [frame.shape.width_px, frame.shape.height_px] = whole.size_px;
    frame.data = whole.data;
    let enlarged = frame.image("indirect_enlarged", vk::Format::R32G32B32A32_SFLOAT);
    let pass = frame
        .compute("half_picture/enlarge", shader("half_picture/enlarge", frame.per_pixel()))
        .bind("depth_image", gbuffer.depth, Access::ComputeSampled)
        .bind("normals_image", gbuffer.normals, Access::ComputeSampled)
        .bind("half_depth", half.depth, Access::ComputeSampled)
        .bind("half_normals", half.normals, Access::ComputeSampled)
        .bind("half_indirect", shadowed, Access::ComputeSampled)
        .bind("out_indirect", enlarged, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    enlarged
}

/// The light of the half picture with its shadows.
fn apply_shadows(frame: &mut Frame, indirect: &Indirect) -> ImageHandle {
    let Some(shadows) = indirect.shadows else { return indirect.lighting };
    let shadowed = frame.image("half_indirect", vk::Format::R32G32B32A32_SFLOAT);
    let work = ComputeWork {
        constants: vec![("ESTIMATE", shadows.estimate.code())],
        ..shader("half_picture/apply_shadows", frame.per_pixel())
    };
    let pass = frame
        .compute("half_picture/apply_shadows", work)
        .bind("indirect_image", indirect.lighting, Access::ComputeSampled)
        .bind("shadowed_image", shadows.shadowed, Access::ComputeSampled)
        .bind("unshadowed_image", shadows.unshadowed, Access::ComputeSampled)
        .bind("out_indirect", shadowed, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    shadowed
}
