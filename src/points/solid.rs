//! Which surfaces are closed, so that only their outside can be seen.

use std::collections::HashMap;

use crate::scene::Scene;

/// Sets of vertices that hang together.
struct Components(Vec<u32>);

impl Components {
    fn root(&mut self, mut vertex: u32) -> u32 {
        while self.0[vertex as usize] != vertex {
            let above = self.0[self.0[vertex as usize] as usize];
            self.0[vertex as usize] = above;
            vertex = above;
        }
        vertex
    }

    fn join(&mut self, a: u32, b: u32) {
        let [a, b] = [a, b].map(|vertex| self.root(vertex));
        // Towards the smaller number, so that the outcome does not depend on the order.
        self.0[a.max(b) as usize] = a.min(b);
    }
}

/// Per triangle, whether the component that it belongs to is closed: welded by position, each of its edges has exactly
/// two triangles, which pass it in opposite directions, and none of them has holes.
pub(super) fn solid_triangles(scene: &Scene) -> Vec<bool> {
    let welded = weld(scene);
    let corners = |triangle: usize| [0, 1, 2].map(|c| welded[scene.indices[3 * triangle + c] as usize]);
    let triangles = 0..scene.triangle_materials.len();
    let mut components = Components((0..scene.vertices.len() as u32).collect());
    let mut edges: HashMap<[u32; 2], u32> = HashMap::with_capacity(scene.indices.len());
    for [a, b, c] in triangles.clone().map(corners) {
        components.join(a, b);
        components.join(b, c);
        // One that is a line encloses nothing.
        if a != b && b != c && c != a {
            for edge in [[a, b], [b, c], [c, a]] {
                *edges.entry(edge).or_default() += 1;
            }
        }
    }
    let mut is_open = vec![false; scene.vertices.len()];
    for ([a, b], count) in &edges {
        if *count != 1 || edges.get(&[*b, *a]) != Some(&1) {
            is_open[components.root(*a) as usize] = true;
        }
    }
    for triangle in triangles.clone() {
        if scene.materials[scene.triangle_materials[triangle] as usize].alpha_cutoff.is_some() {
            is_open[components.root(corners(triangle)[0]) as usize] = true;
        }
    }
    triangles.map(|triangle| !is_open[components.root(corners(triangle)[0]) as usize]).collect()
}

/// Per vertex the first one at the same position.
fn weld(scene: &Scene) -> Vec<u32> {
    let mut first: HashMap<[u32; 3], u32> = HashMap::with_capacity(scene.vertices.len());
    // Adding zero makes the negative zero a positive one.
    let key = |position: [f32; 3]| position.map(|c| (c + 0.0).to_bits());
    let places = scene.vertices.iter().zip(0..);
    places.map(|(vertex, index)| *first.entry(key(vertex.position_ws)).or_insert(index)).collect()
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::scene::testing::{box_room, plane};

    fn all_solid(scene: &Scene) -> bool {
        let solid = solid_triangles(scene);
        assert!(solid.iter().all(|s| *s == solid[0]), "{solid:?}");
        solid[0]
    }

    #[test]
    fn a_box_is_closed_and_a_plane_is_not() {
        assert!(all_solid(&box_room(2.0, Vec3::ONE)));
        assert!(!all_solid(&plane(2.0)));
    }

    #[test]
    fn one_missing_turned_or_masked_triangle_opens_a_box() {
        let mut missing = box_room(2.0, Vec3::ONE);
        missing.indices.truncate(33);
        missing.triangle_materials.truncate(11);
        assert!(!all_solid(&missing));
        let mut turned = box_room(2.0, Vec3::ONE);
        turned.indices.swap(0, 1);
        assert!(!all_solid(&turned));
        let mut masked = box_room(2.0, Vec3::ONE);
        masked.materials[0].alpha_cutoff = Some(0.5);
        assert!(!all_solid(&masked));
    }

    #[test]
    fn a_box_beside_a_plane_stays_closed() {
        let mut scene = box_room(2.0, Vec3::ONE);
        let beside = plane(9.0);
        let first = scene.vertices.len() as u32;
        scene.vertices.extend(&beside.vertices);
        scene.indices.extend(beside.indices.iter().map(|i| first + i));
        scene.triangle_materials.extend([0, 0]);
        let solid = solid_triangles(&scene);
        assert_eq!((solid[..12].iter().all(|s| *s), &solid[12..]), (true, [false; 2].as_slice()));
    }
}
