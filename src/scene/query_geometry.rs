//! The triangles of a scene as an acceleration structure takes them: those that let nothing through first.

use super::Scene;
use crate::shared::{BvhTriangle, TRIANGLE_ALPHA_MASKED};

/// Triangles in two groups, opaque and alpha-masked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct QueryGeometry {
    /// Three indices into the scene's vertices for each triangle.
    pub indices: Vec<u32>,
    /// The number of opaque triangles, then for each triangle its place among the BVH's.
    pub bvh_triangles: Vec<u32>,
}

impl QueryGeometry {
    /// Groups the BVH's triangles.
    #[must_use]
    pub fn new(scene: &Scene, triangles: &[BvhTriangle]) -> Self {
        let is_masked = |i: &u32| triangles[*i as usize].flags & TRIANGLE_ALPHA_MASKED != 0;
        let all = 0..triangles.len() as u32;
        let opaque = all.clone().filter(|i| !is_masked(i));
        let masked = all.filter(is_masked);
        let mut bvh_triangles = vec![0];
        bvh_triangles.extend(opaque);
        bvh_triangles[0] = bvh_triangles.len() as u32 - 1;
        bvh_triangles.extend(masked);
        let corners = |bvh_triangle: &u32| {
            let first = 3 * triangles[*bvh_triangle as usize].triangle_index as usize;
            [0, 1, 2].map(|corner| scene.indices[first + corner])
        };
        let indices = bvh_triangles[1..].iter().flat_map(corners).collect();
        Self { indices, bvh_triangles }
    }

    /// Number of opaque triangles, which come first.
    #[must_use]
    pub fn opaque_count(&self) -> u32 {
        self.bvh_triangles[0]
    }

    /// Number of alpha-masked triangles.
    #[must_use]
    pub fn masked_count(&self) -> u32 {
        self.bvh_triangles.len() as u32 - 1 - self.bvh_triangles[0]
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::scene::bvh;
    use crate::scene::testing::box_room;

    #[test]
    fn opaque_triangles_come_first_and_keep_their_corners() {
        let scene = box_room(1.0, Vec3::ONE);
        let mut triangles = bvh::build(&scene).triangles;
        triangles[1].flags = TRIANGLE_ALPHA_MASKED;
        let geometry = QueryGeometry::new(&scene, &triangles);
        let count = triangles.len() as u32;
        assert_eq!((geometry.opaque_count(), geometry.masked_count()), (count - 1, 1));
        assert_eq!((geometry.bvh_triangles[2], geometry.bvh_triangles.last()), (2, Some(&1)));
        for (bvh_triangle, corners) in geometry.bvh_triangles[1..].iter().zip(geometry.indices.chunks_exact(3)) {
            let triangle = &triangles[*bvh_triangle as usize];
            assert_eq!(scene.vertices[corners[0] as usize].position_ws, triangle.v0);
        }
    }
}
