//! `present`: the finished picture in the window, and the panel over it. They are a small frame of their own, which a window
//! shows again and again while the frame of the next picture, of which the last pass here is a part, goes on.

use ash::vk;

use crate::gpu::{ColorTarget, DrawCall, RasterDraw, RasterState, RasterWork, TransferOp, Viewport, Work};
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

/// Name of the image in which a finished picture is handed over.
pub const SHOWN_PICTURE: &str = "shown_picture";
/// Its format: that of `tone_map`.
pub const SHOWN_FORMAT: vk::Format = vk::Format::R8G8B8A8_UNORM;

/// Adds the last pass of a frame whose picture is shown: a copy of it, so that it stays as it is until the next one is done.
pub fn publish(graph: &mut Graph<Work>, picture: ImageHandle) {
    let shown = graph.imported_image(SHOWN_PICTURE, SHOWN_FORMAT);
    let copy = Work::Transfer(vec![TransferOp::CopyImage { from: picture, to: shown }]);
    let pass = Pass::new("publish", copy).uses(picture, Access::TransferRead).uses(shown, Access::TransferWrite);
    graph.add_pass(pass);
}

/// The frame that shows what has been published, or nothing, and the panel over it.
#[must_use]
pub fn show(window: WindowFormat, part: Part, has_picture: bool) -> Graph<Work> {
    let mut graph = Graph::default();
    let picture = has_picture.then(|| graph.imported_image(SHOWN_PICTURE, SHOWN_FORMAT));
    add(&mut graph, picture, window, part);
    graph
}

fn add(graph: &mut Graph<Work>, picture: Option<ImageHandle>, window: WindowFormat, part: Part) {
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
        draws: picture.map(|_| draw).into_iter().collect(),
        uses_scene: false,
    };
    let pass = Pass::new("present/draw_picture", Work::Raster(work)).uses(shown, access);
    graph.add_pass(match picture {
        Some(picture) => pass.bind("picture", picture, Access::FragmentSampled),
        None => pass,
    });
    if part == Part::Left {
        return;
    }
    graph.add_pass(Pass::new("present/draw_panel", Work::Overlay).uses(shown, Access::ColorAttachmentBlend));
    graph.add_pass(Pass::new("present", Work::Transfer(Vec::new())).uses(shown, Access::Present));
}
