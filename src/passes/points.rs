//! The points' tree as resources of the frame, which have their contents before the first one.

use ash::vk;

use super::Frame;
use crate::graph::{BufferHandle, ImageHandle, ImageInfo};
use crate::points::PointCloud;
use crate::shared::WORD_ROW_TEXELS;

/// Bytes of a texel of four words.
const TEXEL_BYTES: usize = 16;

/// The tree, and which of its leaves are hit where.
#[derive(Clone, Copy, Debug)]
pub struct Points {
    /// Binary logarithm of the number of leaves.
    pub leaf_count_log2: u32,
    /// `PackedNode`s from 1 on, an image of words.
    pub nodes: ImageHandle,
    /// Albedo of each node, RGB9E5.
    pub albedos: BufferHandle,
    /// Leaves by cell.
    pub leaf_cells: BufferHandle,
    /// Cells of each triangle: the first one, and how many along an edge.
    pub triangle_cells: BufferHandle,
}

impl Points {
    /// Declares the tree.
    pub fn declare(frame: &mut Frame, cloud: &PointCloud) -> Self {
        let mut texels = bytemuck::cast_slice(&cloud.nodes).to_vec();
        let row_bytes = WORD_ROW_TEXELS as usize * TEXEL_BYTES;
        let rows = texels.len().div_ceil(row_bytes);
        texels.resize(rows * row_bytes, 0_u8);
        let info = ImageInfo::new(vk::Format::R32G32B32A32_UINT, WORD_ROW_TEXELS, rows as u32);
        let graph = &mut frame.graph;
        Self {
            leaf_count_log2: cloud.leaf_count_log2,
            nodes: graph.filled_image("point_nodes", info, texels.into()),
            albedos: graph.filled_buffer("point_albedos", bytemuck::cast_slice(&cloud.albedos).into()),
            leaf_cells: graph.filled_buffer("leaf_cells", bytemuck::cast_slice(&cloud.leaf_cells).into()),
            triangle_cells: graph.filled_buffer("triangle_cells", bytemuck::cast_slice(&cloud.triangle_cells).into()),
        }
    }

    /// Number of leaves.
    #[must_use]
    pub fn leaf_count(&self) -> u32 {
        1 << self.leaf_count_log2
    }

    /// Number of nodes, the unused one at 0 with them.
    #[must_use]
    pub fn node_count(&self) -> u32 {
        2 * self.leaf_count()
    }

    /// Bytes of a set of sides: a bit for each key.
    #[must_use]
    pub fn side_bits_bytes(&self) -> u64 {
        u64::from(self.side_bit_words()) * 4
    }

    /// Words of a set of sides.
    #[must_use]
    pub fn side_bit_words(&self) -> u32 {
        (2 * self.node_count()).div_ceil(32)
    }
}
