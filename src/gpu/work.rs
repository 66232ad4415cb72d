//! What a pass does, as data: the payload of the frame graph's passes. The executor turns it into commands.

use ash::vk;

use crate::graph::{BufferHandle, ImageHandle, ImageLevel};
use crate::scene::chunks::Surfaces;
use crate::settings::TextureFilter;
use crate::shared::DISPATCH_WIDTH;

/// The work of one pass.
#[derive(Clone, Debug)]
pub enum Work {
    /// One compute dispatch.
    Compute(ComputeWork),
    /// One dynamic-rendering scope with its draws.
    Raster(RasterWork),
    /// Fills, updates and copies.
    Transfer(Vec<TransferOp>),
    /// A new build of one of the scene's acceleration structures, in its place.
    BuildStructure {
        /// Which one; the top one comes after the bottom one.
        level: StructureLevel,
        /// Memory for the build meanwhile: [`SceneSet::scratch_bytes`](super::SceneSet::scratch_bytes).
        scratch: BufferHandle,
    },
    /// What is drawn over the frame from outside, such as a panel, into the acquired image.
    Overlay,
}

/// One of the scene's acceleration structures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StructureLevel {
    /// Of the triangles.
    Bottom,
    /// Of the one instance of the bottom one.
    Top,
}

impl StructureLevel {
    /// What it is called.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Bottom => "bottom structure",
            Self::Top => "top structure",
        }
    }
}

/// Specialization constants: names as in the shader, and the bits of the values.
pub type Constants = Vec<(&'static str, u32)>;

/// One compute dispatch.
#[derive(Clone, Debug)]
pub struct ComputeWork {
    /// Shader variant, as in `bounds/reduce_bounds.comp`.
    pub shader: String,
    /// Specialization constants.
    pub constants: Constants,
    /// Push constants, at most 32 words.
    pub push: Vec<u32>,
    /// How many workgroups.
    pub dispatch: Dispatch,
    /// Whether the shader reads the scene (descriptor set 1).
    pub uses_scene: bool,
    /// Dispatched again and again; the pass must be declared as repeated.
    pub repeat: Option<Repeat>,
}

impl ComputeWork {
    /// Rows of workgroups that may be dispatched one after the other, where there are several. A row is whole, so that
    /// shaders may ask for the number of workgroups in it; how many rows there are they must not ask for.
    #[must_use]
    pub fn rows(&self) -> Option<u32> {
        match self.dispatch {
            Dispatch::Groups([_, rows, 1]) if rows > 1 && self.repeat.is_none() => Some(rows),
            _ => None,
        }
    }

    /// Workgroups of a row, where that is known.
    #[must_use]
    pub fn row_groups(&self) -> u32 {
        match self.dispatch {
            Dispatch::Groups([columns, ..]) => columns,
            Dispatch::Indirect { .. } => 0,
        }
    }

    /// Words that are pushed in all: those of the work, then the round and the part of one that repeats.
    #[must_use]
    pub fn push_words(&self) -> usize {
        self.push.len() + if self.repeat.is_some() { 2 } else { 0 }
    }
}

/// A dispatch repeated `rounds * parts` times. The last two push constants are the round and the part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Repeat {
    /// Rounds; after each of them the result is worth keeping.
    pub rounds: u32,
    /// Parts of a round, so small that each is short.
    pub parts: u32,
}

impl Repeat {
    /// All repetitions.
    #[must_use]
    pub fn count(self) -> u32 {
        self.rounds * self.parts
    }
}

/// How many workgroups a dispatch has.
#[derive(Clone, Copy, Debug)]
pub enum Dispatch {
    /// Known when the graph is built.
    Groups([u32; 3]),
    /// Read from a buffer on the GPU (`VkDispatchIndirectCommand`).
    Indirect {
        /// Buffer with the command; the pass must declare `Access::IndirectRead` of it.
        buffer: BufferHandle,
        /// Where in the buffer.
        offset_bytes: u64,
    },
}

impl Dispatch {
    /// At least `count` workgroups, spread over two dimensions when there are more than one may hold
    /// (`common/dispatch.glsl` numbers them).
    #[must_use]
    pub fn groups(count: u32) -> Self {
        let x = count.clamp(1, DISPATCH_WIDTH);
        Self::Groups([x, count.div_ceil(x).max(1), 1])
    }
}

/// A colour attachment.
#[derive(Clone, Copy, Debug)]
pub struct ColorTarget {
    /// The image, or one level of it; the pass must declare a colour attachment access of it.
    pub target: ImageLevel,
    /// Clear value as raw 32-bit words (floats by `to_bits`), or `None` to load.
    pub clear: Option<[u32; 4]>,
}

/// The depth attachment.
#[derive(Clone, Copy, Debug)]
pub struct DepthTarget {
    /// The image, or one level of it; the pass must declare a depth attachment access of it.
    pub target: ImageLevel,
    /// Clear value, or `None` to load.
    pub clear: Option<f32>,
    /// Whether draws write depth.
    pub write: bool,
}

/// One rendering scope.
#[derive(Clone, Debug)]
pub struct RasterWork {
    /// Colour attachments by location.
    pub colors: Vec<ColorTarget>,
    /// Depth attachment.
    pub depth: Option<DepthTarget>,
    /// Render area, from the origin.
    pub extent_px: [u32; 2],
    /// Draws in order.
    pub draws: Vec<RasterDraw>,
    /// Whether shaders read the scene (descriptor set 1).
    pub uses_scene: bool,
}

/// Fixed-function state of a draw.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct RasterState {
    /// Add the fragment's output to every colour attachment instead of replacing it.
    pub additive_blend: bool,
    /// Depth comparison; `None` is no test.
    pub depth_compare: Option<vk::CompareOp>,
    /// Write depth.
    pub depth_write: bool,
    /// Which faces to drop. Front faces are counter-clockwise as seen in the picture.
    pub cull: vk::CullModeFlags,
    /// Whether the scene's vertex and index buffers are bound.
    pub scene_vertices: bool,
}

/// Viewport in pixels; may start outside the render area.
#[derive(Clone, Copy, Debug)]
pub struct Viewport {
    /// Left edge.
    pub x_px: f32,
    /// Top edge.
    pub y_px: f32,
    /// Width.
    pub width_px: f32,
    /// Height.
    pub height_px: f32,
    /// Scissor rectangle: x, y, width, height.
    pub scissor_px: [u32; 4],
}

impl Viewport {
    /// All of an image.
    #[must_use]
    pub fn whole(width: u32, height: u32) -> Self {
        Self {
            x_px: 0.0,
            y_px: 0.0,
            width_px: width as f32,
            height_px: height as f32,
            scissor_px: [0, 0, width, height],
        }
    }
}

/// One draw with its pipeline.
#[derive(Clone, Debug)]
pub struct RasterDraw {
    /// Vertex shader variant.
    pub vertex: String,
    /// Fragment shader variant.
    pub fragment: String,
    /// Specialization constants of both shaders.
    pub constants: Constants,
    /// Push constants of both shaders, at most 32 words.
    pub push: Vec<u32>,
    /// Fixed-function state.
    pub state: RasterState,
    /// Viewport and scissor.
    pub viewport: Viewport,
    /// What to draw.
    pub call: DrawCall,
}

/// What a draw draws.
#[derive(Clone, Copy, Debug)]
pub enum DrawCall {
    /// Vertices and instances known when the graph is built.
    Direct {
        /// Vertex count.
        vertex_count: u32,
        /// Instance count.
        instance_count: u32,
    },
    /// `VkDrawIndirectCommand` in a buffer on the GPU.
    Indirect {
        /// Buffer with the command; the pass must declare `Access::IndirectRead` of it.
        buffer: BufferHandle,
        /// Where in the buffer.
        offset_bytes: u64,
    },
    /// What of the scene may be in sight of the [`FrameData`](crate::shared::FrameData) that the frame is given, with each
    /// material's textures in descriptor set 2.
    Scene {
        /// How these are read.
        textures: TextureFilter,
        /// Which of its materials are drawn.
        surfaces: Surfaces,
    },
}

/// One transfer command.
#[derive(Clone, Copy, Debug)]
pub enum TransferOp {
    /// Writes the frame's constants (given with each frame) to the start of the buffer.
    FrameData {
        /// Destination.
        buffer: BufferHandle,
    },
    /// Writes the start of the scene's lights, in frames for which `Executor::update_lights` has been given some.
    SceneLights {
        /// The scene's lights.
        buffer: BufferHandle,
    },
    /// Fills the whole buffer with one word.
    Fill {
        /// Destination.
        buffer: BufferHandle,
        /// The word.
        value: u32,
    },
    /// Copies a whole buffer.
    Copy {
        /// Source.
        from: BufferHandle,
        /// Destination.
        to: BufferHandle,
        /// Where in the destination.
        offset_bytes: u64,
    },
    /// Copies the first level of an image to one of the same size and format.
    CopyImage {
        /// Source.
        from: ImageHandle,
        /// Destination.
        to: ImageHandle,
    },
}
