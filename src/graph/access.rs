//! The ways a pass can touch a resource, and what each means to Vulkan.

use ash::vk;

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
    /// Depth attachment, tested only (read-only layout).
    DepthAttachmentRead,
    /// Depth attachment, tested only, and sampled in the fragment shader of the same pass.
    DepthAttachmentReadSampled,
    /// Arguments of an indirect dispatch or draw.
    IndirectRead,
    /// Vertex buffer bound to the input assembler.
    VertexBuffer,
    /// Index buffer bound to the input assembler.
    IndexBuffer,
    /// Source of a copy.
    TransferRead,
    /// Destination of a copy, fill or update that overwrites all the contents later passes use.
    TransferWrite,
    /// Read by the host after the frame's completion has been waited for.
    HostRead,
}
