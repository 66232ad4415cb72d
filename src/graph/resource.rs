//! What a graph is made of: buffers and images, by handle.

use std::ops::Range;
use std::sync::Arc;

use ash::vk;

/// Names a buffer of one graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct BufferHandle(pub(super) usize);

/// Names an image of one graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ImageHandle(pub(super) usize);

impl ImageHandle {
    /// One of its mip levels; 0 is the image in full size.
    #[must_use]
    pub fn level(self, level: u32) -> ImageLevel {
        ImageLevel { image: self, level }
    }
}

/// One mip level of an image, with all its layers or its whole depth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ImageLevel {
    /// The image.
    pub image: ImageHandle,
    /// Which level; 0 is the image in full size.
    pub level: u32,
}

impl From<ImageHandle> for ImageLevel {
    fn from(image: ImageHandle) -> Self {
        image.level(0)
    }
}

/// What a pass uses: a whole resource, or one level of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Part {
    /// The resource.
    pub resource: Handle,
    /// The only level of it, or `None` for all of it.
    pub level: Option<u32>,
}

impl<H: Into<Handle>> From<H> for Part {
    fn from(resource: H) -> Self {
        Self { resource: resource.into(), level: None }
    }
}

impl From<ImageLevel> for Part {
    fn from(ImageLevel { image, level }: ImageLevel) -> Self {
        Self { resource: image.into(), level: Some(level) }
    }
}

/// Either kind of resource; the number indexes the graph's resource list.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Handle(pub(super) usize);

impl Handle {
    /// Position in the graph's resource list.
    #[must_use]
    pub fn index(self) -> usize {
        self.0
    }
}

impl From<BufferHandle> for Handle {
    fn from(handle: BufferHandle) -> Self {
        Self(handle.0)
    }
}

impl From<ImageHandle> for Handle {
    fn from(handle: ImageHandle) -> Self {
        Self(handle.0)
    }
}

/// Size of a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BufferInfo {
    /// Size in bytes, never 0.
    pub size_bytes: u64,
}

/// How far an image goes beyond width and height.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageDepth {
    /// Two dimensions.
    Flat,
    /// An array of so many flat images, one level of which is used as a whole.
    Layers(u32),
    /// Three dimensions, so many texels deep.
    Texels(u32),
}

/// Shape of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageInfo {
    /// Texel format.
    pub format: vk::Format,
    /// Width in texels.
    pub width_px: u32,
    /// Height in texels.
    pub height_px: u32,
    /// Layers, or depth in texels.
    pub depth: ImageDepth,
    /// Mip levels. Passes use each for itself ([`ImageHandle::level`]), or sample them all.
    pub level_count: u32,
}

impl ImageInfo {
    /// A flat image of one level.
    #[must_use]
    pub fn new(format: vk::Format, width_px: u32, height_px: u32) -> Self {
        Self { format, width_px, height_px, depth: ImageDepth::Flat, level_count: 1 }
    }

    /// The same as an array.
    #[must_use]
    pub fn with_layers(self, layer_count: u32) -> Self {
        Self { depth: ImageDepth::Layers(layer_count), ..self }
    }

    /// The same in three dimensions.
    #[must_use]
    pub fn with_depth(self, depth_px: u32) -> Self {
        Self { depth: ImageDepth::Texels(depth_px), ..self }
    }

    /// The same with so many mip levels.
    #[must_use]
    pub fn with_levels(self, level_count: u32) -> Self {
        Self { level_count, ..self }
    }

    /// Levels down to a single texel.
    #[must_use]
    pub fn most_levels(&self) -> u32 {
        let longest = self.size_px().into_iter().max().unwrap_or_default();
        u32::BITS - longest.leading_zeros()
    }

    /// Width, height and depth of a level in texels; the depth of flat images and of arrays is 1.
    #[must_use]
    pub fn level_size_px(&self, level: u32) -> [u32; 3] {
        self.size_px().map(|size| size.checked_shr(level).unwrap_or(0).max(1))
    }

    fn size_px(&self) -> [u32; 3] {
        let depth_px = if let ImageDepth::Texels(depth_px) = self.depth { depth_px } else { 1 };
        [self.width_px, self.height_px, depth_px]
    }

    /// Array layers; 1 for images that are no array.
    #[must_use]
    pub fn layer_count(&self) -> u32 {
        if let ImageDepth::Layers(count) = self.depth { count } else { 1 }
    }

    /// Whether there is not a single texel.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.size_px().contains(&0) || [self.layer_count(), self.level_count].contains(&0)
    }

    /// Whether the format has a depth aspect (`D32_SFLOAT` is the only one used).
    #[must_use]
    pub fn is_depth(&self) -> bool {
        self.format == vk::Format::D32_SFLOAT
    }
}

/// Buffer or image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResourceInfo {
    /// A buffer.
    Buffer(BufferInfo),
    /// An image.
    Image(ImageInfo),
}

/// What decides which accesses fit a resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// A buffer.
    Buffer,
    /// An image with a colour aspect.
    Color,
    /// An image with a depth aspect.
    Depth,
}

impl ResourceInfo {
    /// Buffer, colour image or depth image.
    #[must_use]
    pub fn kind(&self) -> Kind {
        match self {
            Self::Buffer(_) => Kind::Buffer,
            Self::Image(info) if info.is_depth() => Kind::Depth,
            Self::Image(_) => Kind::Color,
        }
    }

    /// Mip levels; a buffer counts as one.
    #[must_use]
    pub fn level_count(&self) -> u32 {
        match self {
            Self::Buffer(_) => 1,
            Self::Image(info) => info.level_count,
        }
    }

    /// The levels that a use of one, or of all, touches.
    #[must_use]
    pub fn levels(&self, level: Option<u32>) -> Range<u32> {
        level.map_or(0..self.level_count(), |level| level..level + 1)
    }
}

/// How long the contents must last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lifetime {
    /// Written before it is read in every frame; its memory may be shared with other transients.
    Transient,
    /// Keeps its contents and layout from frame to frame; created and owned by the graph's executor.
    Persistent,
    /// Owned outside the graph (scene data) and shared with every graph on the queue; its owner knows the size. A
    /// frame finds and leaves its contents visible to everything, and an image in [`IMPORTED_LAYOUT`].
    Imported,
    /// An image that is another one in every frame (of a swapchain) and comes without contents, once a semaphore
    /// has been waited for at the colour attachment output stage.
    Acquired,
    /// An acquired image that another graph has drawn to in the same frame, on the same queue: it comes with
    /// contents, as a colour attachment.
    Continued,
    /// A buffer that the host reads once the frame has completed; each frame in flight has its own.
    Readback,
    /// What the frame before wrote to `current`; only read. The two change places between frames.
    Previous {
        /// The resource that this frame writes and the next one has as its previous.
        current: Handle,
    },
    /// Written before it is read in every frame, and kept for the next frame, which has it as `previous`.
    Current {
        /// The resource that holds what the frame before wrote.
        previous: Handle,
    },
}

/// Layout of an imported image between frames.
pub const IMPORTED_LAYOUT: vk::ImageLayout = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;

impl Lifetime {
    /// Whether the resource is handed over anew for every frame.
    #[must_use]
    pub fn is_acquired(self) -> bool {
        matches!(self, Self::Acquired | Self::Continued)
    }

    /// Whether a frame starts with nothing in the resource that it may read.
    #[must_use]
    pub fn starts_empty(self) -> bool {
        matches!(self, Self::Transient | Self::Acquired | Self::Readback | Self::Current { .. })
    }

    /// The other one of a pair that changes places between frames.
    #[must_use]
    pub fn partner(self) -> Option<Handle> {
        match self {
            Self::Previous { current } => Some(current),
            Self::Current { previous } => Some(previous),
            _ => None,
        }
    }
}

/// A pair of buffers or of images that change places between frames: what is `current` now is `previous` in the
/// next frame. What `previous` holds means nothing in the first frame and after a cut; the executor says so.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct History<H> {
    /// What the frame before left; read only.
    pub previous: H,
    /// What this frame leaves to the next; to be written in every frame, before it is read.
    pub current: H,
}

/// One resource of the graph.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Resource {
    /// Name, also its Vulkan debug name; unique in the graph.
    pub name: String,
    /// Kind and size.
    pub info: ResourceInfo,
    /// How long the contents must last.
    pub lifetime: Lifetime,
    /// What a persistent buffer, or an image of one level and one layer, holds before the first frame.
    pub contents: Option<Arc<[u8]>>,
}
