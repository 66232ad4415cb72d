//! `present`: the finished picture in the window, and the panel over it. Only frames that a window shows have it.

use ash::vk;

use crate::gpu::{ColorTarget, DrawCall, RasterDraw, RasterState, RasterWork, Viewport, Work};
use crate::graph::{Access, Graph, ImageHandle, ImageInfo, Pass};

/// What the window wants of its pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WindowFormat {
    /// Format of the window's images.
    pub format: vk::Format,
    /// Whether writing to them encodes sRGB.
    pub driver_encodes: bool,
}

/// Which part of the window a frame fills. Where two share it, the left one comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// All of it.
    Whole,
    /// The left of a split view; the frame on the right goes on with the window's image.
    Left,
    /// The right of a split view, with the panel over both.
    Right,
}

/// Adds the passes to a finished frame.
pub fn add(graph: &mut Graph<Work>, picture: ImageHandle, window: WindowFormat, part: Part) {
    // The size is the window's in each frame; a graph outlives it.
    let info = ImageInfo::new(window.format, 1, 1);
    let (shown, access, clear) = match part {
        Part::Whole | Part::Left => (graph.acquired_image("window", info), Access::ColorAttachmentWrite, Some([0; 4])),
        Part::Right => (graph.continued_image("window", info), Access::ColorAttachmentBlend, None),
    };
    let draw = RasterDraw {
        vertex: "present/draw_picture.vert".to_owned(),
        fragment: "present/draw_picture.frag".to_owned(),
        constants: vec![("DRIVER_ENCODES", u32::from(window.driver_encodes))],
        push: Vec::new(),
        state: RasterState {
            additive_blend: false,
            depth_compare: None,
            depth_write: false,
            cull: vk::CullModeFlags::NONE,
            scene_vertices: false,
        },
        viewport: Viewport::whole(1, 1),
        call: DrawCall::Direct { vertex_count: 3, instance_count: 1 },
    };
    let work = RasterWork {
        colors: vec![ColorTarget { target: shown.into(), clear }],
        depth: None,
        extent_px: [1, 1],
        draws: vec![draw],
        uses_scene: false,
    };
    graph.add_pass(
        Pass::new("present/draw_picture", Work::Raster(work))
            .bind("picture", picture, Access::FragmentSampled)
            .uses(shown, access),
    );
    if part == Part::Left {
        return;
    }
    graph.add_pass(Pass::new("present/draw_panel", Work::Overlay).uses(shown, Access::ColorAttachmentBlend));
    graph.add_pass(Pass::new("present", Work::Transfer(Vec::new())).uses(shown, Access::Present));
}
