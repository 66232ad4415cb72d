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
}
