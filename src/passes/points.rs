//! The points' tree as resources of the frame, which have their contents before the first one.

use ash::vk;

use super::Frame;
use crate::gpu::Work;
use crate::graph::{Access, BufferHandle, ImageHandle, ImageInfo, Pass};
use crate::points::PointCloud;
use crate::shared::WORD_ROW_TEXELS;

/// Bytes of a texel of four words.
const TEXEL_BYTES: usize = 16;

/// Levels of which all sides lie in the first word of a set of them; a tree has at least one more.
pub const FIRST_LEVELS: u32 = 4;

/// The tree, and which of its leaves are hit where.
#[derive(Clone, Copy, Debug)]
pub struct Points {
    /// Binary logarithm of the number of leaves.
    pub leaf_count_log2: u32,
    /// `PackedNode`s from 1 on, an image of words.
    pub nodes: ImageHandle,
    /// Albedo of each node, RGB9E5.
    pub albedos: BufferHandle,
    /// A bit for each node: whether its normal opposes its parent's.
    pub turned: BufferHandle,
    /// Leaves by cell.
    pub leaf_cells: BufferHandle,
    /// Cells of each triangle: the first one, and how many along an edge.
    pub triangle_cells: BufferHandle,
}

impl Points {
    /// Declares the tree.
    ///
    /// # Panics
    /// When the cloud has fewer than 2 to the power [`FIRST_LEVELS`] leaves.
    pub fn declare(frame: &mut Frame, cloud: &PointCloud) -> Self {
        assert!(cloud.leaf_count_log2 >= FIRST_LEVELS, "{} leaves are too few", cloud.leaf_count());
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
            turned: graph.filled_buffer("point_turned_bits", bytemuck::cast_slice(&cloud.turned_bits()).into()),
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

    /// Words of a set of sides, a bit for each key.
    #[must_use]
    pub fn side_words(&self) -> u32 {
        2 * self.node_count() / 32
    }

    /// A compute pass that finds the leaves that rays have hit.
    #[must_use]
    pub fn hit_by(&self, pass: Pass<Work>) -> Pass<Work> {
        pass.bind("triangle_cells", self.triangle_cells, Access::ComputeRead).bind(
            "leaf_cells",
            self.leaf_cells,
            Access::ComputeRead,
        )
    }

    /// Declares a set of sides.
    pub fn side_bits(&self, frame: &mut Frame, name: &str) -> BufferHandle {
        frame.graph.persistent_buffer(name, 4 * u64::from(self.side_words()))
    }

    /// The levels of the tree as parts of a set of sides, from the root down: first word and number of words. The first
    /// part is word 0, which has the four levels that are smaller than a word.
    pub fn levels(&self) -> impl DoubleEndedIterator<Item = [u32; 2]> + use<> {
        let below = (FIRST_LEVELS..=self.leaf_count_log2).map(|level| [1 << (level - FIRST_LEVELS); 2]);
        std::iter::once([0, 1]).chain(below)
    }
}
