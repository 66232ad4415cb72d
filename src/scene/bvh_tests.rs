//! Tests of the hierarchy against brute force.

use super::*;
use crate::scene::testing::{Random, box_room, plane, scene_from_quads, soup};

fn ray(origin: Vec3, direction: Vec3) -> Ray {
    Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
}

#[test]
fn agrees_with_brute_force() {
    let mut random = Random(7);
    let bvh = build_binary(&soup(1500, &mut random));
    let (mut hits, mut shortened) = (0, 0);
    for _ in 0..2000 {
        let mut ray = ray(random.vector() * 6.0, random.vector());
        let brute = |ray: &Ray| {
            let all = bvh.triangles.iter().filter_map(|t| t.intersect(ray));
            all.min_by(|a, b| a.t.total_cmp(&b.t))
        };
        let expected = brute(&ray);
        assert_eq!(bvh.trace_closest(&ray).map(|h| h.t), expected.map(|h| h.t));
        assert_eq!(bvh.trace_any(&ray), expected.is_some());
        hits += u32::from(expected.is_some());
        ray.t_max = random.next_unit() * 4.0;
        let expected = brute(&ray).is_some();
        assert_eq!(bvh.trace_any(&ray), expected);
        shortened += u32::from(expected);
    }
    assert!(hits > 400 && shortened > 50, "{hits} and {shortened} hits test too little");
}

#[test]
fn every_triangle_is_in_one_leaf_and_inside_its_box() {
    let scene = soup(700, &mut Random(3));
    let bvh = build_binary(&scene);
    let mut seen = vec![0; bvh.triangles.len()];
    for node in bvh.nodes.iter().filter(|n| n.prim_count > 0) {
        for t in node.first_index..node.first_index + node.prim_count {
            let triangle = &bvh.triangles[t as usize];
            seen[triangle.triangle_index as usize] += 1;
            for corner in [Vec3::ZERO, triangle.edge1.into(), triangle.edge2.into()] {
                let p = Vec3::from_array(triangle.v0) + corner;
                assert!(p.cmpge(Vec3::from(node.min) - 1e-5).all() && p.cmple(Vec3::from(node.max) + 1e-5).all());
            }
        }
    }
    assert!(seen.iter().all(|n| *n == 1) && seen.len() == 1400);
    assert!(bvh.depth > 5 && bvh.depth <= MAX_DEPTH);
}

#[test]
fn known_hits_in_a_room_and_on_a_plane() {
    let bvh = build_binary(&box_room(2.0, Vec3::ONE));
    for direction in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z] {
        let hit = bvh.trace_closest(&ray(Vec3::new(0.1, 0.2, -0.3), direction)).unwrap();
        let expected = 1.0 - Vec3::new(0.1, 0.2, -0.3).dot(direction);
        assert!((hit.t - expected).abs() < 1e-6, "{direction}");
    }
    let flat = build_binary(&plane(2.0));
    let hit = flat.trace_closest(&ray(Vec3::new(0.5, 3.0, 0.25), Vec3::NEG_Y)).unwrap();
    assert_eq!(hit.t, 3.0);
    assert!(!flat.trace_any(&ray(Vec3::new(0.5, 3.0, 0.25), Vec3::Y)));
    assert!(!flat.trace_any(&Ray { t_max: 2.9, ..ray(Vec3::new(0.5, 3.0, 0.25), Vec3::NEG_Y) }));
    assert!(!flat.trace_any(&Ray { t_min: 3.1, ..ray(Vec3::new(0.5, 3.0, 0.25), Vec3::NEG_Y) }));
}

#[test]
fn one_triangle_and_many_equal_ones_build() {
    let mut scene = plane(1.0);
    scene.indices.truncate(3);
    scene.triangle_materials.truncate(1);
    let bvh = build_binary(&scene);
    assert_eq!((bvh.triangles.len(), bvh.depth), (1, 1));
    assert!(!build(&scene).nodes.is_empty());
    let quad = [Vec3::ZERO, Vec3::X, Vec3::ONE, Vec3::Y];
    let same = build_binary(&scene_from_quads("same", &[quad; 500], scene.materials.remove(0)));
    assert_eq!(same.triangles.len(), 1000);
    assert!(same.depth <= MAX_DEPTH);
    let down = ray(Vec3::new(0.3, 0.2, 5.0), Vec3::NEG_Z);
    assert_eq!(
        same.trace_closest(&down).map(|h| h.t),
        same.triangles[0].intersect(&down).or(same.triangles[1].intersect(&down)).map(|h| h.t)
    );
}

#[test]
fn the_balanced_fallback_is_a_proper_tree() {
    let mut random = Random(5);
    let mut bvh = build_binary(&soup(600, &mut random));
    let rays: Vec<Ray> = (0..500).map(|_| ray(random.vector() * 6.0, random.vector())).collect();
    let expected: Vec<_> = rays.iter().map(|r| bvh.trace_closest(r).map(|h| h.t)).collect();
    bvh.nodes = balanced(&bvh.triangles, LEAF_TRIANGLES);
    assert_eq!(depth(&bvh.nodes), 10);
    assert_eq!(rays.iter().map(|r| bvh.trace_closest(r).map(|h| h.t)).collect::<Vec<_>>(), expected);
}

#[test]
fn heaps_of_equal_triangles_build_at_once() {
    let quad = [Vec3::ZERO, Vec3::X, Vec3::ONE, Vec3::Y];
    let heap = build_binary(&scene_from_quads("heap", &vec![quad; 20_000], plane(1.0).materials.remove(0)));
    assert!(heap.build_ms < 5e3 && heap.depth <= MAX_DEPTH && heap.triangles.len() == 40_000);
}

#[test]
fn masked_materials_are_flagged() {
    let mut scene = plane(1.0);
    assert_eq!(build_binary(&scene).triangles[0].flags, 0);
    scene.materials[0].alpha_cutoff = Some(0.5);
    assert_eq!(build_binary(&scene).triangles[1].flags, TRIANGLE_ALPHA_MASKED);
}

/// Checks an eight-wide tree: every triangle in one leaf, and inside the boxes of all that contain it.
fn check_wide(bvh: &SceneBvh) {
    let mut seen = vec![0; bvh.triangles.len()];
    let mut stack = vec![(0u32, Vec3::MIN, Vec3::MAX)];
    while let Some((i, min, max)) = stack.pop() {
        let node = &bvh.nodes[i as usize];
        let byte = |words: &[u32], i: usize| words[i / 4] >> (8 * (i % 4)) & 0xff;
        let inner = node.exponents_and_inner >> 24;
        for slot in 0..8 {
            let meta = byte(&node.meta, slot);
            if meta == 0 {
                continue;
            }
            let plane = |k: usize, planes: &[u32; 4], end: usize| {
                let unit = f32::from_bits(byte(&[node.exponents_and_inner], k) << 23);
                node.origin[k] + unit * byte(planes, slot + 8 * end) as f32
            };
            let corner = |end| Vec3::new(plane(0, &node.x, end), plane(1, &node.y, end), plane(2, &node.z, end));
            let (min, max) = (corner(0).max(min), corner(1).min(max));
            if inner >> slot & 1 == 1 {
                assert_eq!(meta, 0x20 | (24 + slot as u32));
                stack.push((node.first_child + (inner & ((1 << slot) - 1)).count_ones(), min, max));
                continue;
            }
            let first = node.first_triangle + (meta & 31);
            for t in first..first + (meta >> 5).count_ones() {
                let triangle = &bvh.triangles[t as usize];
                seen[triangle.triangle_index as usize] += 1;
                for corner in [Vec3::ZERO, triangle.edge1.into(), triangle.edge2.into()] {
                    let p = Vec3::from_array(triangle.v0) + corner;
                    assert!(p.cmpge(min - 1e-5).all() && p.cmple(max + 1e-5).all(), "{p} in {min} to {max}");
                }
            }
        }
    }
    assert!(seen.iter().all(|n| *n == 1) && bvh.depth <= MAX_WIDE_DEPTH);
}

#[test]
fn a_tree_too_deep_for_rays_is_an_error() {
    let mut bvh = build(&soup(20, &mut Random(9)));
    for (depth, fits) in [(1, true), (MAX_WIDE_DEPTH, true), (MAX_WIDE_DEPTH + 1, false)] {
        bvh.depth = depth;
        assert_eq!(bvh.check_depth().is_ok(), fits, "{depth} levels");
    }
    assert!(bvh.check_depth().unwrap_err().to_string().contains("33 levels"));
}

#[test]
fn the_wide_tree_holds_every_triangle() {
    for count in [1, 2, 3, 300] {
        check_wide(&build(&soup(count, &mut Random(9))));
    }
    let quad = [Vec3::ZERO, Vec3::X, Vec3::ONE, Vec3::Y];
    for count in [500, 10_000] {
        let heap = build(&scene_from_quads("heap", &vec![quad; count], plane(1.0).materials.remove(0)));
        check_wide(&heap);
        assert!(heap.build_ms < 5e3);
    }
}
