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

/// Adds the passes to a finished frame.
pub fn add(graph: &mut Graph<Work>, picture: ImageHandle, window: WindowFormat) {
    // The size is the window's in each frame; a graph outlives it.
    let info = ImageInfo { format: window.format, width_px: 1, height_px: 1 };
    let shown = graph.acquired_image("window", info);
    let draw = RasterDraw {
        vertex: "present/draw_picture.vert".to_owned(),
        fragment: "present/draw_picture.frag".to_owned(),
        constants: vec![u32::from(window.driver_encodes)],
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
        colors: vec![ColorTarget { image: shown, clear: Some([0; 4]) }],
        depth: None,
        extent_px: [1, 1],
        draws: vec![draw],
        uses_scene: false,
    };
    graph.add_pass(
        Pass::new("present/draw_picture", Work::Raster(work))
            .bind(0, picture, Access::FragmentSampled)
            .uses(shown, Access::ColorAttachmentWrite),
    );
    graph.add_pass(Pass::new("present/draw_panel", Work::Overlay).uses(shown, Access::ColorAttachmentBlend));
    graph.add_pass(Pass::new("present", Work::Transfer(Vec::new())).uses(shown, Access::Present));
}
