//! Tests of trees that follow triangles, against brute force over the moved triangles.

use super::*;
use crate::scene::bvh::{Hit, Ray};
use crate::scene::testing::{Random, plane, scene_from_quads, soup};

/// The scene with every quad carried along its own way.
fn carried(scene: &Scene, ways: &[Vec3], time: f32) -> Scene {
    let mut moved = scene_from_quads("moved", &[[Vec3::ZERO; 4]], plane(1.0).materials.remove(0));
    moved.indices.clone_from(&scene.indices);
    moved.triangle_materials.clone_from(&scene.triangle_materials);
    moved.vertices.clone_from(&scene.vertices);
    for (index, vertex) in moved.vertices.iter_mut().enumerate() {
        vertex.position_ws = (Vec3::from_array(vertex.position_ws) + ways[index / 4] * time).to_array();
    }
    moved
}

/// The nearest hit by the planes of the nodes, as shaders see them.
fn trace(bvh: &SceneBvh, ray: &Ray) -> Option<Hit> {
    let mut closest: Option<Hit> = None;
    let mut stack = vec![0];
    let inverse = ray.direction.recip();
    while let Some(index) = stack.pop() {
        let node = &bvh.nodes[index];
        for slot in 0..SLOTS {
            let t_max = closest.map_or(ray.t_max, |hit| hit.t);
            let meets = meets(&planes(node, slot), ray.origin, inverse, t_max);
            match child(node, slot) {
                Child::Inner(child) if meets => stack.push(child),
                Child::Leaf(range) if meets => {
                    for triangle in &bvh.triangles[range] {
                        let t_max = closest.map_or(ray.t_max, |hit| hit.t);
                        closest = triangle.intersect(&Ray { t_max, ..*ray }).or(closest);
                    }
                }
                _ => {}
            }
        }
    }
    closest
}

/// The box of a child.
fn planes(node: &BvhNode, slot: usize) -> Aabb {
    let byte = |words: &[u32], i: usize| words[i / 4] >> (8 * (i % 4)) & 0xff;
    let plane = |axis: usize, planes: &[u32; 4], end: usize| {
        let unit = f32::from_bits(byte(&[node.exponents_and_inner], axis) << 23);
        node.origin[axis] + unit * byte(planes, slot + 8 * end) as f32
    };
    let corner = |end| Vec3::new(plane(0, &node.x, end), plane(1, &node.y, end), plane(2, &node.z, end));
    Aabb { min: corner(0), max: corner(1) }
}

fn meets(bounds: &Aabb, origin: Vec3, inverse: Vec3, t_max: f32) -> bool {
    let (t0, t1) = ((bounds.min - origin) * inverse, (bounds.max - origin) * inverse);
    t0.min(t1).max_element().max(0.0) <= t0.max(t1).min_element().min(t_max) * 1.000_001
}

fn brute(bvh: &SceneBvh, ray: &Ray) -> Option<Hit> {
    bvh.triangles.iter().filter_map(|triangle| triangle.intersect(ray)).min_by(|a, b| a.t.total_cmp(&b.t))
}

/// Every box of a node encloses what is in it.
fn nests(bvh: &SceneBvh) -> bool {
    fn around(bvh: &SceneBvh, index: usize) -> Option<Aabb> {
        (0..SLOTS).try_fold(Aabb::EMPTY, |all, slot| {
            let node = &bvh.nodes[index];
            let inside = match child(node, slot) {
                Child::Nothing => return Some(all),
                Child::Inner(child) => around(bvh, child)?,
                Child::Leaf(range) => {
                    bvh.triangles[range].iter().flat_map(corners).fold(Aabb::EMPTY, |all, p| all.with(p))
                }
            };
            let own = planes(node, slot);
            let holds = own.min.cmple(inside.min).all() && own.max.cmpge(inside.max).all();
            holds.then(|| all.union(&inside))
        })
    }
    around(bvh, 0).is_some()
}

/// Poses of a soup with trees that follow it, and rays.
fn poses() -> (Scene, Vec<Vec3>, MovingBvh, Random) {
    let mut random = Random(11);
    let scene = soup(300, &mut random);
    let ways: Vec<Vec3> = (0..300).map(|_| random.vector()).collect();
    let moving = MovingBvh::new(&build(&scene));
    (scene, ways, moving, random)
}

#[test]
fn rays_find_moved_triangles() {
    let (scene, ways, moving, mut random) = poses();
    let mut hits = 0;
    for pose in 0..20 {
        let bvh = moving.at(&carried(&scene, &ways, 0.1 * pose as f32));
        assert!(nests(&bvh), "pose {pose}");
        for _ in 0..2000 {
            let (origin, direction) = (random.vector() * 6.0, random.vector());
            let ray = Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY };
            let (found, expected) = (trace(&bvh, &ray), brute(&bvh, &ray));
            let of = |hit: Option<Hit>| hit.map(|hit| hit.triangle_index);
            assert_eq!(of(found), of(expected), "pose {pose}");
            if let (Some(found), Some(expected)) = (found, expected) {
                assert!((found.t - expected.t).abs() <= 1e-5 * expected.t, "{found:?}, not {expected:?}");
                hits += 1;
            }
        }
    }
    assert!(hits > 1000, "{hits} hits test too little");
}

#[test]
fn a_node_left_out_of_the_refit_is_found() {
    let (scene, ways, moving, _) = poses();
    let mut bvh = moving.at(&carried(&scene, &ways, 0.5));
    let inner = bvh.nodes.len() / 2;
    bvh.nodes[inner] = moving.built.nodes[inner];
    assert!(!nests(&bvh));
}

#[test]
fn a_tree_that_has_become_bad_is_built_anew() {
    let (scene, ways, moving, _) = poses();
    let near = moving.at(&carried(&scene, &ways, 0.01));
    assert_eq!(near.nodes.len(), moving.built.nodes.len());
    assert!(near.nodes.iter().zip(&moving.built.nodes).all(|(a, b)| a.meta == b.meta), "its nodes stay");
    let far = carried(&scene, &ways, 20.0);
    let (bvh, anew) = (moving.at(&far), build(&far));
    let children = |bvh: &SceneBvh| bvh.nodes.iter().map(|node| (node.first_child, node.meta)).collect::<Vec<_>>();
    assert!(children(&bvh) == children(&anew) && bvh.triangles == anew.triangles && nests(&bvh));
}

#[test]
fn a_heap_in_one_point_and_a_flat_scene_have_boxes() {
    let (scene, ways, moving, _) = poses();
    let mut heap = carried(&scene, &ways, 0.0);
    heap.vertices.iter_mut().for_each(|vertex| vertex.position_ws = [1.0, 2.0, 3.0]);
    assert!(nests(&moving.at(&heap)));
    heap.vertices.iter_mut().enumerate().for_each(|(i, vertex)| vertex.position_ws = [i as f32, 2.0, 1e-30]);
    assert!(nests(&moving.at(&heap)));
}
