//! Twin of `point_cut/mark_passing`.

use glam::Vec3;

use crate::points::{Node, PointCloud};
use crate::shared::FrameData;

/// What a comparison with a threshold says, and by how much of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// The outcome.
    pub holds: bool,
    /// Relative distance of what was compared; rounding may turn a decision that was close.
    pub margin: f32,
}

impl Decision {
    /// Whether `a` is at most `b`.
    #[must_use]
    pub fn at_most(a: f32, b: f32) -> Self {
        Self { holds: a <= b, margin: (a - b).abs() / a.abs().max(b.abs()).max(f32::MIN_POSITIVE) }
    }

    /// Both of two: as close as the one that decides.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        let margin = match (self.holds, other.holds) {
            (true, true) => self.margin.min(other.margin),
            (false, false) => self.margin.max(other.margin),
            (true, false) => other.margin,
            (false, true) => self.margin,
        };
        Self { holds: self.holds && other.holds, margin }
    }

    /// The contrary.
    #[must_use]
    pub fn contrary(self) -> Self {
        Self { holds: !self.holds, ..self }
    }
}

/// Whether a node is small enough in the picture, and flat enough, to be a primary point.
#[must_use]
pub fn passes(node: &Node, data: &FrameData) -> Decision {
    let distance = node.centroid_ws.distance(data.eye_ws.into());
    let pixels_at_1 = data.size_px[1] as f32 / (2.0 * Vec3::from(data.up_ws).length());
    let is_outside = Decision::at_most(distance, node.radius).contrary();
    let is_small = Decision::at_most(node.radius * pixels_at_1, data.primary_radius_px * distance);
    let is_flat = Decision::at_most(data.primary_cone_cos, node.cone_cos);
    is_outside.and(is_small).and(is_flat)
}

/// [`passes`] for every node from 1 on; nothing for 0.
#[must_use]
pub fn mark_passing(cloud: &PointCloud, data: &FrameData) -> Vec<Decision> {
    let never = Decision { holds: false, margin: f32::INFINITY };
    let nodes = (1..2 * cloud.leaf_count()).map(|node| passes(&cloud.node(node), data));
    std::iter::once(never).chain(nodes).collect()
}
