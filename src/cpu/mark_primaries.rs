//! Twin of `point_cut/mark_primaries`.

use glam::{Vec2, Vec3};

use super::mark_passing::Decision;
use super::point_sides::has_bit;
use crate::points::{Node, PointCloud};
use crate::shared::FrameData;

/// Whether a node is in the cut: it passes or is a leaf, and no node above it passes.
#[must_use]
pub fn is_in_cut(node: u32, leaf_count: u32, passing_bits: &[u32]) -> bool {
    let above = std::iter::successors(Some(node / 2), |above| Some(above / 2)).take_while(|above| *above > 0);
    (node >= leaf_count || has_bit(passing_bits, node)) && !above.into_iter().any(|above| has_bit(passing_bits, above))
}

/// A picture's depth, near / view z, and the view that it was taken in, without jitter.
pub struct DepthView<'a> {
    /// The view.
    pub data: &'a FrameData,
    /// Depth by pixel.
    pub depth: &'a [f32],
}

impl DepthView<'_> {
    fn meets_view(&self, offset: Vec3, radius: f32) -> Decision {
        let [forward, right, up] = [self.data.forward_ws, self.data.right_ws, self.data.up_ws].map(Vec3::from);
        let ahead = offset.dot(forward);
        let outside = |axis: Vec3| {
            let half = axis.length();
            (offset.dot(axis).abs() / half - ahead * half) / (1.0 + half * half).sqrt()
        };
        let inside = |axis: Vec3| Decision::at_most(radius, outside(axis)).contrary();
        Decision::at_most(ahead + radius, self.data.near).contrary().and(inside(right)).and(inside(up))
    }

    /// The pixel of an offset from the eye, and whether it is far from being another one.
    fn pixel(&self, offset: Vec3, ahead: f32) -> ([u32; 2], bool) {
        let [right, up] = [self.data.right_ws, self.data.up_ws].map(Vec3::from);
        let size = Vec2::from(self.data.size_px.map(|edge| edge as f32));
        let along = Vec2::new(offset.dot(right) / right.length_squared(), -offset.dot(up) / up.length_squared());
        let place = (along / ahead * 0.5 + 0.5) * size;
        let is_sure = (place - place.round()).abs().min_element() > 1e-5 * size.max_element();
        let clamped = place.clamp(Vec2::ZERO, size - 1.0);
        ([clamped.x as u32, clamped.y as u32], is_sure)
    }

    fn is_open(&self, offset: Vec3, least: f32) -> Decision {
        let [forward, right, up] = [self.data.forward_ws, self.data.right_ws, self.data.up_ws].map(Vec3::from);
        let ahead = offset.dot(forward);
        let is_behind = Decision::at_most(ahead, self.data.near);
        if is_behind.holds {
            return is_behind;
        }
        let ([x, y], is_sure) = self.pixel(offset, ahead);
        let [width, height] = self.data.size_px.map(|edge| edge as f32);
        let ndc = Vec2::new((x as f32 + 0.5) / width, (y as f32 + 0.5) / height) * 2.0 - 1.0;
        let ray = forward + right * ndc.x - up * ndc.y;
        let depth = self.depth[(y * self.data.size_px[0] + x) as usize];
        let open = Decision::at_most(least * depth, ray.length() * self.data.near);
        Decision { margin: if is_sure { open.margin } else { 0.0 }, ..open }
    }

    /// Whether a node is seen.
    #[must_use]
    pub fn is_visible(&self, node: &Node) -> Decision {
        let offset = node.centroid_ws - Vec3::from(self.data.eye_ws);
        let least = offset.length() - node.radius - self.data.point_leaf_radius;
        let [right, up] = [self.data.right_ws, self.data.up_ws]
            .map(|axis| Vec3::from(axis).normalize() * node.radius * std::f32::consts::FRAC_1_SQRT_2);
        let places = [offset, offset - right, offset + right, offset - up, offset + up];
        let closed = places.map(|place| self.is_open(place, least).contrary());
        let open = closed.into_iter().reduce(Decision::and).map(Decision::contrary);
        open.map_or(self.meets_view(offset, node.radius), |open| open.and(self.meets_view(offset, node.radius)))
    }

    /// The side of a node that is seen; whether it is 1.
    #[must_use]
    pub fn is_other_side(&self, node: &Node) -> Decision {
        let towards_eye = Vec3::from(self.data.eye_ws) - node.centroid_ws;
        let cone_sin = (1.0 - node.cone_cos * node.cone_cos).max(0.0).sqrt();
        let least = if node.is_solid && node.cone_cos > 0.0 { -cone_sin } else { 0.0 };
        let facing = node.normal.dot(towards_eye) / towards_eye.length();
        Decision { holds: facing < least, margin: (facing - least).abs() }
    }
}

/// For each node of the cut, its key if it is seen, and whether that is close.
#[must_use]
pub fn mark_primaries(cloud: &PointCloud, passing_bits: &[u32], view: &DepthView<'_>) -> Vec<(u32, Decision)> {
    let nodes = (1..2 * cloud.leaf_count()).filter(|node| is_in_cut(*node, cloud.leaf_count(), passing_bits));
    let key = |index: u32| {
        let node = cloud.node(index);
        let (visible, side) = (view.is_visible(&node), view.is_other_side(&node));
        let margin = if visible.holds { visible.margin.min(side.margin) } else { visible.margin };
        (2 * index + u32::from(side.holds), Decision { margin, ..visible })
    };
    nodes.map(key).collect()
}

#[cfg(test)]
mod tests {
    use super::super::point_sides::testing::random_bits;
    use super::*;

    #[test]
    fn every_leaf_has_one_node_of_the_cut_above_it_whatever_passes() {
        for (seed, share) in [(1, 0.0), (2, 0.05), (3, 0.3), (4, 1.0)] {
            let count = 256;
            let passing = random_bits(2 * count, share, seed);
            for leaf in count..2 * count {
                let path = std::iter::successors(Some(leaf), |node| Some(node / 2)).take_while(|node| *node > 0);
                assert_eq!(path.filter(|node| is_in_cut(*node, count, &passing)).count(), 1, "leaf {leaf}");
            }
        }
    }

    #[test]
    fn of_two_decisions_the_one_that_decides_is_as_close() {
        let [near, far] = [1.0, 2.0].map(|b| Decision::at_most(0.999, b));
        assert!(near.and(far).margin < 0.01 && near.contrary().and(far).margin < 0.01);
        assert!(near.and(far.contrary()).margin > 0.4 && near.contrary().and(far.contrary()).margin > 0.4);
    }
}
