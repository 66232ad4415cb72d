//! `point_view`: points as discs, in the camera's picture or from above (`docs/views.md`).

use ash::vk;

use super::exclusive_scan::{self, ScanRange};
use super::gbuffer::GBuffer;
use super::point_selection::PointSelection;
use super::points::Points;
use super::tone_map::ToneMapped;
use super::{Frame, debug_view, shader, threads};
use crate::gpu::{
    ColorTarget, ComputeWork, DepthTarget, DrawCall, RasterDraw, RasterState, RasterWork, Viewport, Work,
};
use crate::graph::{Access, BufferHandle, ImageHandle, Pass};
use crate::shared::{MOST_SHOWN_POINTS, ShownPoint};
use crate::views::color_map;

/// The points that are shown.
#[derive(Clone, Copy, Debug)]
pub struct ShownSides {
    /// A bit for each side that is.
    pub bits: BufferHandle,
    /// Where their light comes from is told, rather than their level.
    pub selection: Option<PointSelection>,
}

/// Who looks at them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Viewer {
    /// The camera; what surfaces hide is hidden.
    Camera,
    /// Someone high above; the camera is drawn in.
    Above,
}

impl Viewer {
    /// As shaders have it.
    fn constant(self) -> (&'static str, u32) {
        ("FROM_ABOVE", (self == Self::Above).into())
    }
}

/// The points as discs, and the command that draws them.
struct Discs {
    points: BufferHandle,
    draw: BufferHandle,
    /// How far they reach.
    bounds: BufferHandle,
}

/// Adds the passes; gives the values, the number and the key of the point at each pixel, and their picture.
pub fn add(
    frame: &mut Frame,
    gbuffer: &GBuffer,
    points: &Points,
    shown: &ShownSides,
    viewer: Viewer,
) -> (ImageHandle, ToneMapped) {
    let discs = list(frame, points, shown);
    let values = draw(frame, gbuffer, &discs, viewer);
    (values, overlay(frame, gbuffer, values, &discs, viewer))
}

fn list(frame: &mut Frame, points: &Points, shown: &ShownSides) -> Discs {
    let word_count = points.side_words();
    let ranks = frame.graph.transient_buffer("shown_ranks", 4 * u64::from(word_count + 1));
    let capacity = (2 * points.node_count()).min(MOST_SHOWN_POINTS);
    let bytes = size_of::<ShownPoint>() as u64 * u64::from(capacity);
    let discs = Discs {
        points: frame.graph.transient_buffer("shown_points", bytes),
        draw: frame.graph.transient_buffer("shown_points_draw", 16),
        bounds: frame.graph.transient_buffer("shown_bounds", 16),
    };
    frame.clear(&[(discs.bounds, 0)]);
    let range = ScanRange { bits: shown.bits, ranks, first_word: 0, word_count, keep_ranks: false, values: false };
    exclusive_scan::add(frame, "shown", range);
    let work = ComputeWork {
        push: vec![word_count],
        constants: vec![("TELLS_LIGHT", shown.selection.is_some().into())],
        ..shader("point_view/list_points", threads(word_count))
    };
    // Bindings that are not read still need a buffer.
    let [needed, under, borrowed] =
        shown.selection.map_or([shown.bits; 3], |selection| [selection.needed, selection.under, selection.borrowed]);
    let pass = frame
        .compute("point_view/list_points", work)
        .bind("point_nodes", points.nodes, Access::ComputeSampled)
        .bind("shown_bits", shown.bits, Access::ComputeRead)
        .bind("ranks", ranks, Access::ComputeRead)
        .bind("needed_bits", needed, Access::ComputeRead)
        .bind("under_bits", under, Access::ComputeRead)
        .bind("borrowed_bits", borrowed, Access::ComputeRead)
        .bind("shown_points", discs.points, Access::ComputeWrite)
        .bind("draw", discs.draw, Access::ComputeWrite)
        .bind("shown_bounds", discs.bounds, Access::ComputeReadWrite);
    frame.graph.add_pass(pass);
    discs
}

fn draw(frame: &mut Frame, gbuffer: &GBuffer, discs: &Discs, viewer: Viewer) -> ImageHandle {
    let values = debug_view::values_image(frame);
    let [width, height] = [frame.shape.width_px, frame.shape.height_px];
    let from_above = viewer == Viewer::Above;
    let draw = RasterDraw {
        vertex: "point_view/draw_points.vert".to_owned(),
        fragment: "point_view/draw_points.frag".to_owned(),
        constants: vec![viewer.constant()],
        push: Vec::new(),
        state: RasterState {
            additive_blend: false,
            depth_compare: Some(vk::CompareOp::GREATER_OR_EQUAL),
            depth_write: from_above,
            cull: vk::CullModeFlags::NONE,
            scene_vertices: false,
        },
        viewport: Viewport::whole(width, height),
        call: DrawCall::Indirect { buffer: discs.draw, offset_bytes: 0 },
    };
    // From above the points hide each other; the surfaces that the camera sees say nothing there.
    let (depth, clear, access) = if from_above {
        (frame.image("shown_depth", vk::Format::D32_SFLOAT), Some(0.0), Access::DepthAttachmentWrite)
    } else {
        (gbuffer.depth, None, Access::DepthAttachmentRead)
    };
    let work = RasterWork {
        colors: vec![ColorTarget { target: values.into(), clear: Some([0; 4]) }],
        depth: Some(DepthTarget { target: depth.into(), clear, write: from_above }),
        extent_px: [width, height],
        draws: vec![draw],
        uses_scene: false,
    };
    frame.graph.add_pass(
        Pass::new("point_view/draw_points", Work::Raster(work))
            .bind("frame", frame.data, Access::GraphicsUniform)
            .bind("shown_points", discs.points, Access::VertexRead)
            .bind("shown_bounds", discs.bounds, Access::VertexRead)
            .uses(discs.draw, Access::IndirectRead)
            .uses(depth, access)
            .uses(values, Access::ColorAttachmentWrite),
    );
    values
}

fn overlay(frame: &mut Frame, gbuffer: &GBuffer, values: ImageHandle, discs: &Discs, viewer: Viewer) -> ToneMapped {
    let view = frame.shape.view;
    let end = color_map(view).and_then(|map| map.end).unwrap_or(0.0);
    let (picture, scale) = (debug_view::picture(frame), debug_view::scale(frame, end));
    let work = ComputeWork {
        push: debug_view::palette(view),
        constants: vec![viewer.constant()],
        ..shader("point_view/overlay_points", frame.per_pixel())
    };
    let pass = frame
        .compute("point_view/overlay_points", work)
        .bind("values_image", values, Access::ComputeSampled)
        .bind("albedo_image", gbuffer.albedo, Access::ComputeSampled)
        .bind("normals_image", gbuffer.normals, Access::ComputeSampled)
        .bind("depth_image", gbuffer.depth, Access::ComputeSampled)
        .bind("shown_bounds", discs.bounds, Access::ComputeRead)
        .bind("out_picture", picture, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    ToneMapped { picture, exposure: scale, is_exposed: false }
}
