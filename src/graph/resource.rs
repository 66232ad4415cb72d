//! What a graph is made of: buffers and images, by handle.

use ash::vk;

/// Names a buffer of one graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct BufferHandle(pub(super) usize);

/// Names an image of one graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ImageHandle(pub(super) usize);

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

/// Shape of a two-dimensional image (one mip level, one layer: all the frame needs).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageInfo {
    /// Texel format.
    pub format: vk::Format,
    /// Width in texels.
    pub width_px: u32,
    /// Height in texels.
    pub height_px: u32,
}

impl ImageInfo {
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
}

/// How long the contents must last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lifetime {
    /// Written before it is read in every frame; its memory may be shared with other transients.
    Transient,
    /// Keeps its contents and layout from frame to frame; created and owned by the graph's executor.
    Persistent,
    /// Owned outside the graph (scene data); buffers only, never written by a pass.
    Imported,
    /// An image that is another one in every frame (of a swapchain) and comes without contents, once a semaphore
    /// has been waited for at the colour attachment output stage.
    Acquired,
    /// An acquired image that another graph has drawn to in the same frame, on the same queue: it comes with
    /// contents, as a colour attachment.
    Continued,
    /// A buffer that the host reads once the frame has completed; each frame in flight has its own.
    Readback,
}

impl Lifetime {
    /// Whether the resource is handed over anew for every frame.
    #[must_use]
    pub fn is_acquired(self) -> bool {
        matches!(self, Self::Acquired | Self::Continued)
    }
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
}
