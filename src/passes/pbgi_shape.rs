//! Sizes and modes of point-based global illumination.

use std::sync::Arc;

use crate::graph::BufferHandle;
use crate::passes::Frame;
use crate::points::PointCloud;
use crate::settings::{Coverage, Hemisphere, MicroFill, Selection};
use crate::shared::SECONDARY_EDGE;

/// What decides which passes there are and how large their resources.
#[derive(Clone, Debug, PartialEq)]
pub struct PbgiShape {
    /// The points of the scene.
    pub cloud: Arc<PointCloud>,
    /// Primary points that there is room for.
    pub primary_capacity: u32,
    /// References from tiles to caches that there is room for.
    pub reference_capacity: u32,
    /// Whether what stands still is kept from frame to frame.
    pub reuse: bool,
    /// What fills micro-buffers.
    pub micro: MicroFill,
    /// How points fill them.
    pub coverage: Coverage,
    /// How micro-buffers divide the hemisphere.
    pub hemisphere: Hemisphere,
    /// How points that need a micro-buffer of their own are found.
    pub selection: Selection,
    /// Bounces of light.
    pub bounces: u32,
    /// Means of the environment (`environment::blurred`), over the scale of the scene's environment.
    pub environment_means: Arc<[[f32; 4]]>,
}

/// Secondary points of which what they see can be kept, for each primary point that there is room for. Cameras find three or four.
const KEPT_PER_PRIMARY: u64 = 8;
/// Bytes that it may take: the least range of storage buffers that devices have.
const MOST_KEPT_BYTES: u64 = 128 << 20;

impl PbgiShape {
    /// Secondary points of which what they see is kept for more bounces.
    #[must_use]
    pub fn kept_secondaries(&self) -> u32 {
        let texel_bytes = 4 * u64::from(SECONDARY_EDGE * SECONDARY_EDGE);
        let all = 4 * u64::from(self.cloud.leaf_count());
        all.min(KEPT_PER_PRIMARY * u64::from(self.primary_capacity)).clamp(1, MOST_KEPT_BYTES / texel_bytes) as u32
    }

    /// The constant that tells shaders how much of a texel a point covers.
    #[must_use]
    pub fn binary_coverage(&self) -> (&'static str, u32) {
        ("BINARY_COVERAGE", (self.coverage == Coverage::Binary).into())
    }

    /// Declares the means of the environment.
    pub fn means_buffer(&self, frame: &mut Frame) -> BufferHandle {
        frame.graph.filled_buffer("environment_means", bytemuck::cast_slice(&self.environment_means).into())
    }
}
