//! Micro-buffers: small pictures of the hemisphere above a point (Ritschel et al. 2009), their texels and their lobes. No
//! Vulkan here.
//!
//! Directions are in the frame of the point: z is its normal.

mod hemisphere;
mod lobes;

pub use hemisphere::{direction_at, disc_point, table};
pub use lobes::{LOBES, lobe_directions, lobe_place};

use crate::shared::{PRIMARY_EDGE, SECONDARY_EDGE};

/// Edges in texels of the micro-buffers there are.
pub const EDGES: [u32; 2] = [PRIMARY_EDGE, SECONDARY_EDGE];
