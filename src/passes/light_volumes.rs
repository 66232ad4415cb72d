//! `light_volumes`: lights as instanced polyhedra, the top level as a full-screen pass; additive lighting and the
//! pixels' shadow reservoirs (sections 3.2, 3.3).

use ash::vk;

use super::Frame;
use super::gbuffer::GBuffer;
use super::lgh_shape::LghShape;
use super::merge::MergedLights;
use crate::gpu::{ColorTarget, DepthTarget, DrawCall, RasterDraw, RasterState, RasterWork, Viewport, Work};
use crate::graph::{Access, BufferHandle, ImageHandle, ImageInfo, Pass};
use crate::settings::Reservoir;

/// What the pass makes, all in the interleaved layout.
#[derive(Clone, Copy, Debug)]
pub struct Lighting {
    /// Radiance per unit albedo; in alpha the sum of shadow sample weights f.
    pub image: ImageHandle,
    /// The reservoirs; `None` without shadow samples.
    pub reservoirs: Option<BufferHandle>,
    /// Lights that each pixel tests; counted in statistics frames only.
    pub lights_tested: BufferHandle,
}

/// Declares what lighting makes, whichever pass makes it.
pub(super) fn declare(frame: &mut Frame, shape: &LghShape, format: vk::Format) -> Lighting {
    let [width_px, height_px] = shape.interleaved_px();
    let pixels = u64::from(width_px) * u64::from(height_px);
    let image = frame.graph.transient_image("lighting", ImageInfo::new(format, width_px, height_px));
    let lights_tested_bytes = if shape.count_lights_tested { 4 * pixels } else { 16 };
    let lights_tested = frame.graph.persistent_buffer("lights_tested", lights_tested_bytes);
    let reservoirs = (shape.lights.shadow_samples > 0).then(|| declare_reservoirs(frame, shape, "reservoirs"));
    Lighting { image, reservoirs, lights_tested }
}

/// Declares the reservoirs of all pixels.
pub(super) fn declare_reservoirs(frame: &mut Frame, shape: &LghShape, name: &str) -> BufferHandle {
    let [width_px, height_px] = shape.interleaved_px();
    let bytes = reservoir_bytes(shape.reservoir, shape.lights.shadow_samples);
    frame.graph.transient_buffer(name, bytes * u64::from(width_px) * u64::from(height_px))
}

/// Adds the passes. `depth` is the depth buffer in the interleaved layout.
pub fn add(
    frame: &mut Frame,
    shape: &LghShape,
    gbuffer: &GBuffer,
    depth: ImageHandle,
    placement: BufferHandle,
    merged: &MergedLights,
) -> Lighting {
    let [width_px, height_px] = shape.interleaved_px();
    let Lighting { image, reservoirs, lights_tested } = declare(frame, shape, shape.lighting_format);
    let mut cleared = vec![(lights_tested, 0)];
    cleared.extend(reservoirs.map(|r| (r, empty_word(shape.reservoir))));
    frame.clear_here("light_volumes/clear", &cleared);
    let work = RasterWork {
        colors: vec![ColorTarget { target: image.into(), clear: Some([0; 4]) }],
        depth: Some(DepthTarget { target: depth.into(), clear: None, write: false }),
        extent_px: [width_px, height_px],
        draws: draws(shape, merged),
        uses_scene: false,
    };
    // Without interleaving the tested depth buffer is also the one that is sampled.
    let depth_access =
        if depth == gbuffer.depth { Access::DepthAttachmentReadSampled } else { Access::DepthAttachmentRead };
    let mut pass = Pass::new("light_volumes", Work::Raster(work))
        .bind("frame", frame.data, Access::GraphicsUniform)
        .bind("merged_lights", merged.lights, Access::GraphicsRead)
        .bind("sub_images", merged.sub_images, Access::GraphicsRead)
        .bind("grid", placement, Access::GraphicsRead)
        .bind("normals_image", gbuffer.normals, Access::FragmentSampled)
        .bind("lights_tested", lights_tested, Access::FragmentReadWrite)
        .uses(merged.draws, Access::IndirectRead)
        .uses(image, Access::ColorAttachmentWrite);
    pass = if depth == gbuffer.depth {
        pass.bind("depth_image", depth, depth_access)
    } else {
        pass.bind("depth_image", gbuffer.depth, Access::FragmentSampled).uses(depth, depth_access)
    };
    if let Some(reservoirs) = reservoirs {
        pass = pass.bind("reservoirs", reservoirs, Access::FragmentReadWrite);
    }
    frame.graph.add_pass(pass);
    Lighting { image, reservoirs, lights_tested }
}

/// Bytes of a pixel's reservoirs.
#[must_use]
pub fn reservoir_bytes(mode: Reservoir, shadow_samples: u32) -> u64 {
    match mode {
        Reservoir::Exact => 8 * u64::from(shadow_samples),
        Reservoir::Race | Reservoir::Lock => 4 * u64::from(shadow_samples + 2),
    }
}

/// The word that means "empty".
fn empty_word(mode: Reservoir) -> u32 {
    match mode {
        Reservoir::Exact => u32::MAX,
        Reservoir::Race | Reservoir::Lock => 0,
    }
}

/// Per sub-image the volumes, then the full-screen triangle of the top level.
fn draws(shape: &LghShape, merged: &MergedLights) -> Vec<RasterDraw> {
    let mode = match (shape.lights.shadow_samples, shape.reservoir) {
        (0, _) => "none",
        (_, Reservoir::Race) => "race",
        (_, Reservoir::Lock) => "lock",
        (_, Reservoir::Exact) => "exact",
    };
    let n = shape.interleave;
    let mut draws = Vec::new();
    for sub_image in 0..n * n {
        let draw = |vertex: &str, fragment: &str, depth_compare, cull, viewport, call| RasterDraw {
            vertex: format!("light_volumes/{vertex}.vert"),
            fragment: format!("light_volumes/{fragment}_{mode}.frag"),
            constants: vec![("COUNT_LIGHTS_TESTED", u32::from(shape.count_lights_tested)), ("LOBE", shape.lobe.code())],
            push: vec![sub_image],
            state: RasterState { additive_blend: true, depth_compare, depth_write: false, cull, scene_vertices: false },
            viewport,
            call,
        };
        let [sub_image_viewport, plain] = sub_image_viewports(shape, sub_image);
        // Back faces at or behind the surface: the surface lies inside the volume. Depth is reversed.
        draws.push(draw(
            "draw_volumes",
            "shade_light_volume",
            Some(vk::CompareOp::LESS_OR_EQUAL),
            vk::CullModeFlags::FRONT,
            sub_image_viewport,
            DrawCall::Indirect { buffer: merged.draws, offset_bytes: 16 * u64::from(sub_image) },
        ));
        draws.push(draw(
            "cover_screen",
            "shade_top_level",
            None,
            vk::CullModeFlags::NONE,
            plain,
            DrawCall::Direct { vertex_count: 3, instance_count: 1 },
        ));
    }
    draws
}

/// The viewport that shows the picture's pixels x % n == i, y % n == j in sub-image (i, j), and the plain
/// rectangle of that sub-image.
fn sub_image_viewports(shape: &LghShape, sub_image: u32) -> [Viewport; 2] {
    let n = shape.interleave;
    let [sub_image_width, sub_image_height] = shape.sub_image_px();
    let (i, j) = (sub_image % n, sub_image / n);
    let (x, y) = (i * sub_image_width, j * sub_image_height);
    // Sub-image pixel p is picture pixel n p + i, so its centre p + 1/2 shows the picture's n p + i + 1/2.
    let shift = |k: u32| 0.5 - (k as f32 + 0.5) / n as f32;
    let scissor_px = [x, y, sub_image_width, sub_image_height];
    let interleaved = Viewport {
        x_px: x as f32 + shift(i),
        y_px: y as f32 + shift(j),
        width_px: shape.picture_px[0] as f32 / n as f32,
        height_px: shape.picture_px[1] as f32 / n as f32,
        scissor_px,
    };
    let plain = Viewport {
        x_px: x as f32,
        y_px: y as f32,
        width_px: sub_image_width as f32,
        height_px: sub_image_height as f32,
        scissor_px,
    };
    [interleaved, plain]
}
