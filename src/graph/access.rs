//! The ways a pass can touch a resource, and what each means to Vulkan.

use ash::vk::{AccessFlags2 as Mask, BufferUsageFlags, ImageLayout, ImageUsageFlags, PipelineStageFlags2 as Stage};

use super::resource::Kind;

/// How one pass uses one resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Access {
    /// Storage buffer or storage image, read in a compute shader.
    ComputeRead,
    /// Storage buffer or storage image, written in a compute shader; every texel or all the contents
    /// that later passes use are overwritten.
    ComputeWrite,
    /// Storage buffer or storage image, read and written (or updated by atomics) in a compute shader.
    ComputeReadWrite,
    /// Sampled image (`texelFetch`), read in a compute shader.
    ComputeSampled,
    /// Uniform buffer, read in a compute shader.
    ComputeUniform,
    /// Storage buffer, read in a vertex shader.
    VertexRead,
    /// Uniform buffer, read in vertex and fragment shaders.
    GraphicsUniform,
    /// Storage buffer, read in both the vertex and the fragment shader.
    GraphicsRead,
    /// Storage buffer, read in a fragment shader.
    FragmentRead,
    /// Storage buffer, read and written (atomics) in a fragment shader.
    FragmentReadWrite,
    /// Sampled image (`texelFetch`), read in a fragment shader.
    FragmentSampled,
    /// Colour attachment, cleared or wholly overwritten.
    ColorAttachmentWrite,
    /// Colour attachment, loaded and blended into.
    ColorAttachmentBlend,
    /// Depth attachment, cleared and written with depth test.
    DepthAttachmentWrite,
    /// Depth attachment, tested only (read-only layout; the attachment's store operation must be `NONE`,
    /// because storing counts as a write).
    DepthAttachmentRead,
    /// Depth attachment, tested only, and sampled in the fragment shader of the same pass.
    DepthAttachmentReadSampled,
    /// Arguments of an indirect dispatch or draw.
    IndirectRead,
    /// Vertex buffer bound to the input assembler.
    VertexBuffer,
    /// Index buffer bound to the input assembler.
    IndexBuffer,
    /// Acceleration structure (the buffer that holds it), walked through by ray queries in a compute shader.
    ComputeTrace,
    /// Vertices, indices or instances that an acceleration structure is built from.
    StructureInput,
    /// Acceleration structure (the buffer that holds it) that another one is built from.
    StructureReference,
    /// Acceleration structure (the buffer that holds it), built anew.
    StructureBuild,
    /// Memory that the build of an acceleration structure uses meanwhile.
    StructureScratch,
    /// Source of a copy.
    TransferRead,
    /// Destination of a copy, fill or update that overwrites all the contents later passes use.
    TransferWrite,
    /// Read by the host after the frame's completion has been waited for.
    HostRead,
    /// Shown by the presentation engine after the frame; only for the image that comes from outside.
    Present,
}

/// What one access means to Vulkan: which stages touch the memory, how, and in which image layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SyncScope {
    /// Pipeline stages that perform the access.
    pub stages: Stage,
    /// Kinds of memory access performed.
    pub access: Mask,
    /// Layout the image must be in; `UNDEFINED` for buffers.
    pub layout: ImageLayout,
}

impl Access {
    /// Stages, memory accesses and layout of this access to a resource of the given kind.
    #[must_use]
    pub fn sync(self, kind: Kind) -> SyncScope {
        let (stages, access, layout) = match self {
            Self::ComputeRead => (Stage::COMPUTE_SHADER, Mask::SHADER_STORAGE_READ, ImageLayout::GENERAL),
            Self::ComputeWrite => (Stage::COMPUTE_SHADER, Mask::SHADER_STORAGE_WRITE, ImageLayout::GENERAL),
            Self::ComputeReadWrite => {
                (Stage::COMPUTE_SHADER, Mask::SHADER_STORAGE_READ | Mask::SHADER_STORAGE_WRITE, ImageLayout::GENERAL)
            }
            Self::ComputeSampled => {
                (Stage::COMPUTE_SHADER, Mask::SHADER_SAMPLED_READ, ImageLayout::SHADER_READ_ONLY_OPTIMAL)
            }
            Self::ComputeUniform => (Stage::COMPUTE_SHADER, Mask::UNIFORM_READ, ImageLayout::UNDEFINED),
            Self::VertexRead => (Stage::VERTEX_SHADER, Mask::SHADER_STORAGE_READ, ImageLayout::UNDEFINED),
            Self::GraphicsUniform => {
                (Stage::VERTEX_SHADER | Stage::FRAGMENT_SHADER, Mask::UNIFORM_READ, ImageLayout::UNDEFINED)
            }
            Self::GraphicsRead => {
                (Stage::VERTEX_SHADER | Stage::FRAGMENT_SHADER, Mask::SHADER_STORAGE_READ, ImageLayout::UNDEFINED)
            }
            Self::FragmentRead => (Stage::FRAGMENT_SHADER, Mask::SHADER_STORAGE_READ, ImageLayout::UNDEFINED),
            Self::FragmentReadWrite => {
                (Stage::FRAGMENT_SHADER, Mask::SHADER_STORAGE_READ | Mask::SHADER_STORAGE_WRITE, ImageLayout::UNDEFINED)
            }
            Self::FragmentSampled => {
                (Stage::FRAGMENT_SHADER, Mask::SHADER_SAMPLED_READ, ImageLayout::SHADER_READ_ONLY_OPTIMAL)
            }
            Self::ColorAttachmentWrite => {
                (Stage::COLOR_ATTACHMENT_OUTPUT, Mask::COLOR_ATTACHMENT_WRITE, ImageLayout::COLOR_ATTACHMENT_OPTIMAL)
            }
            Self::ColorAttachmentBlend => (
                Stage::COLOR_ATTACHMENT_OUTPUT,
                Mask::COLOR_ATTACHMENT_READ | Mask::COLOR_ATTACHMENT_WRITE,
                ImageLayout::COLOR_ATTACHMENT_OPTIMAL,
            ),
            Self::DepthAttachmentWrite => (
                Stage::EARLY_FRAGMENT_TESTS | Stage::LATE_FRAGMENT_TESTS,
                Mask::DEPTH_STENCIL_ATTACHMENT_READ | Mask::DEPTH_STENCIL_ATTACHMENT_WRITE,
                ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
            ),
            Self::DepthAttachmentRead => (
                Stage::EARLY_FRAGMENT_TESTS | Stage::LATE_FRAGMENT_TESTS,
                Mask::DEPTH_STENCIL_ATTACHMENT_READ,
                ImageLayout::DEPTH_STENCIL_READ_ONLY_OPTIMAL,
            ),
            Self::DepthAttachmentReadSampled => (
                Stage::EARLY_FRAGMENT_TESTS | Stage::LATE_FRAGMENT_TESTS | Stage::FRAGMENT_SHADER,
                Mask::DEPTH_STENCIL_ATTACHMENT_READ | Mask::SHADER_SAMPLED_READ,
                ImageLayout::DEPTH_STENCIL_READ_ONLY_OPTIMAL,
            ),
            Self::IndirectRead => (Stage::DRAW_INDIRECT, Mask::INDIRECT_COMMAND_READ, ImageLayout::UNDEFINED),
            Self::VertexBuffer => (Stage::VERTEX_ATTRIBUTE_INPUT, Mask::VERTEX_ATTRIBUTE_READ, ImageLayout::UNDEFINED),
            Self::IndexBuffer => (Stage::INDEX_INPUT, Mask::INDEX_READ, ImageLayout::UNDEFINED),
            Self::ComputeTrace => {
                (Stage::COMPUTE_SHADER, Mask::ACCELERATION_STRUCTURE_READ_KHR, ImageLayout::UNDEFINED)
            }
            Self::StructureInput => {
                (Stage::ACCELERATION_STRUCTURE_BUILD_KHR, Mask::SHADER_READ, ImageLayout::UNDEFINED)
            }
            Self::StructureReference => {
                (Stage::ACCELERATION_STRUCTURE_BUILD_KHR, Mask::ACCELERATION_STRUCTURE_READ_KHR, ImageLayout::UNDEFINED)
            }
            Self::StructureScratch => (
                Stage::ACCELERATION_STRUCTURE_BUILD_KHR,
                Mask::ACCELERATION_STRUCTURE_READ_KHR | Mask::ACCELERATION_STRUCTURE_WRITE_KHR,
                ImageLayout::UNDEFINED,
            ),
            Self::StructureBuild => (
                Stage::ACCELERATION_STRUCTURE_BUILD_KHR,
                Mask::ACCELERATION_STRUCTURE_WRITE_KHR,
                ImageLayout::UNDEFINED,
            ),
            Self::TransferRead => (Stage::ALL_TRANSFER, Mask::TRANSFER_READ, ImageLayout::TRANSFER_SRC_OPTIMAL),
            Self::TransferWrite => (Stage::ALL_TRANSFER, Mask::TRANSFER_WRITE, ImageLayout::TRANSFER_DST_OPTIMAL),
            Self::HostRead => (Stage::HOST, Mask::HOST_READ, ImageLayout::UNDEFINED),
            // The semaphore that presentation waits for makes the contents visible.
            Self::Present => (Stage::ALL_COMMANDS, Mask::NONE, ImageLayout::PRESENT_SRC_KHR),
        };
        let layout = if kind == Kind::Buffer { ImageLayout::UNDEFINED } else { layout };
        SyncScope { stages, access, layout }
    }

    /// Whether the resource's contents change.
    #[must_use]
    pub fn is_write(self) -> bool {
        matches!(
            self,
            Self::ComputeWrite
                | Self::ComputeReadWrite
                | Self::FragmentReadWrite
                | Self::ColorAttachmentWrite
                | Self::ColorAttachmentBlend
                | Self::DepthAttachmentWrite
                | Self::StructureBuild
                | Self::StructureScratch
                | Self::TransferWrite
        )
    }

    /// Whether the contents that the resource had before the pass matter. True for read-write and blending;
    /// false for a depth attachment that is cleared first.
    #[must_use]
    pub fn is_read(self) -> bool {
        !self.is_write()
            || matches!(self, Self::ComputeReadWrite | Self::FragmentReadWrite | Self::ColorAttachmentBlend)
    }

    /// Whether a resource of this kind can be used this way at all.
    #[must_use]
    pub fn fits(self, kind: Kind) -> bool {
        match kind {
            Kind::Buffer => !self.buffer_usage().is_empty() || self == Self::HostRead,
            Kind::Color if self == Self::Present => true,
            Kind::Color => {
                !self.image_usage().is_empty()
                    && !self.image_usage().contains(ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT)
            }
            Kind::Depth => {
                !self.image_usage().is_empty()
                    && !self.image_usage().intersects(ImageUsageFlags::COLOR_ATTACHMENT | ImageUsageFlags::STORAGE)
            }
        }
    }

    /// Whether the image is an attachment of the pass.
    #[must_use]
    pub fn is_attachment(self) -> bool {
        let attachments = ImageUsageFlags::COLOR_ATTACHMENT | ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT;
        self.image_usage().intersects(attachments)
    }

    /// Whether one use takes all mip levels of an image, as sampling does; storage images and attachments have one.
    #[must_use]
    pub fn takes_levels(self) -> bool {
        !self.is_attachment() && !self.image_usage().contains(ImageUsageFlags::STORAGE)
    }

    /// Usage flags a buffer needs for this access; empty where the access needs none or is not for buffers.
    #[must_use]
    pub fn buffer_usage(self) -> BufferUsageFlags {
        match self {
            Self::ComputeRead
            | Self::ComputeWrite
            | Self::ComputeReadWrite
            | Self::VertexRead
            | Self::GraphicsRead
            | Self::FragmentRead
            | Self::FragmentReadWrite => BufferUsageFlags::STORAGE_BUFFER,
            Self::ComputeUniform | Self::GraphicsUniform => BufferUsageFlags::UNIFORM_BUFFER,
            Self::IndirectRead => BufferUsageFlags::INDIRECT_BUFFER,
            Self::VertexBuffer => BufferUsageFlags::VERTEX_BUFFER,
            Self::IndexBuffer => BufferUsageFlags::INDEX_BUFFER,
            Self::ComputeTrace | Self::StructureReference | Self::StructureBuild => {
                BufferUsageFlags::ACCELERATION_STRUCTURE_STORAGE_KHR
            }
            Self::StructureScratch => BufferUsageFlags::STORAGE_BUFFER | BufferUsageFlags::SHADER_DEVICE_ADDRESS,
            Self::StructureInput => BufferUsageFlags::ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_KHR,
            Self::TransferRead => BufferUsageFlags::TRANSFER_SRC,
            Self::TransferWrite => BufferUsageFlags::TRANSFER_DST,
            _ => BufferUsageFlags::empty(),
        }
    }

    /// Usage flags an image needs for this access; empty where the access is not for images.
    #[must_use]
    pub fn image_usage(self) -> ImageUsageFlags {
        match self {
            Self::ComputeRead | Self::ComputeWrite | Self::ComputeReadWrite => ImageUsageFlags::STORAGE,
            Self::ComputeSampled | Self::FragmentSampled => ImageUsageFlags::SAMPLED,
            Self::ColorAttachmentWrite | Self::ColorAttachmentBlend => ImageUsageFlags::COLOR_ATTACHMENT,
            Self::DepthAttachmentWrite | Self::DepthAttachmentRead => ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT,
            Self::DepthAttachmentReadSampled => ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT | ImageUsageFlags::SAMPLED,
            Self::TransferRead => ImageUsageFlags::TRANSFER_SRC,
            Self::TransferWrite => ImageUsageFlags::TRANSFER_DST,
            _ => ImageUsageFlags::empty(),
        }
    }
}
