use std::collections::HashSet;

use glam::Vec4;

use super::*;
use crate::scene::Texture;
use crate::scene::octahedral::unpack_octahedral;
use crate::scene::testing::{box_room, diffuse, plane, scene_from_quads};

/// A box and, above it, a plane of another colour that stands on edge.
fn box_and_wall() -> Scene {
    let mut scene = box_room(2.0, Vec3::new(0.8, 0.4, 0.2));
    let corners =
        [Vec3::new(-1.0, 2.0, 5.0), Vec3::new(1.0, 2.0, 5.0), Vec3::new(1.0, 7.0, 5.0), Vec3::new(-1.0, 7.0, 5.0)];
    let wall = scene_from_quads("wall", &[corners], diffuse("wall", Vec3::splat(0.1)));
    let first = scene.vertices.len() as u32;
    scene.vertices.extend(&wall.vertices);
    scene.indices.extend(wall.indices.iter().map(|i| first + i));
    scene.triangle_materials.extend([1, 1]);
    scene.materials.extend(wall.materials);
    scene
}

fn courtyard() -> Scene {
    let glb = include_bytes!("../../assets/courtyard.glb");
    crate::scene::gltf::load_bytes("courtyard", glb, &|_, _, _| {}).unwrap()
}

/// A plane whose texture has holes in a checkered half, in squares of a quarter.
fn sieve() -> Scene {
    let mut scene = plane(3.0);
    let texel = |i: u32| [200, 100, 50, if (i % 64 / 16 + i / 64 / 16).is_multiple_of(2) { 255 } else { 0 }];
    scene.textures =
        vec![Texture { name: "sieve".into(), width: 64, height: 64, rgba: (0..64 * 64).flat_map(texel).collect() }];
    scene.materials[0].base_color_texture = Some(0);
    scene.materials[0].alpha_cutoff = Some(0.5);
    scene
}

fn points(scene: &Scene, leaf_count_log2: u32) -> PointCloud {
    PointCloud::of_scene(scene, leaf_count_log2).unwrap()
}

fn leaf_area(cloud: &PointCloud) -> f64 {
    (cloud.leaf_count()..2 * cloud.leaf_count()).map(|node| f64::from(cloud.node(node).area)).sum()
}

#[test]
fn the_leaves_cover_the_surface_and_each_triangle_has_its_share() {
    let scene = box_and_wall();
    let cloud = points(&scene, 12);
    assert!((leaf_area(&cloud) / 34.0 - 1.0).abs() < 1e-5, "{}", leaf_area(&cloud));
    assert!((f64::from(cloud.node(1).area) / 34.0 - 1.0).abs() < 1e-5);
    let disc = std::f32::consts::PI * cloud.leaf_radius * cloud.leaf_radius;
    assert!((disc * 4096.0 / 34.0 - 1.0).abs() < 1e-5, "{disc}");
    let leaves = sampling::sample(&scene, 4096).unwrap().leaves;
    for triangle in 0..14 {
        let own = leaves.iter().filter(|leaf| leaf.triangle == triangle).count() as f64;
        let share = if triangle < 12 { 2.0 } else { 5.0 } / 34.0 * 4096.0;
        assert!((own - share).abs() <= 1.0, "triangle {triangle} has {own} of {share}");
    }
}

#[test]
fn holes_have_no_points() {
    let scene = sieve();
    let sample = sampling::sample(&scene, 1 << 12).unwrap();
    let area = f64::from(sample.leaf_area) * 4096.0;
    assert!((area / 4.5 - 1.0).abs() < 0.02, "{area}");
    assert_eq!(sample.leaves.len(), 4096);
    let middle = |leaf: &Leaf| (leaf.position_ws / 3.0 + 0.5) * 4.0;
    for leaf in &sample.leaves {
        let at = middle(leaf);
        // Between texels that are half a hole each, the cutoff lies in the middle.
        let is_hole = (at.x as i32 + at.z as i32) % 2 != 0;
        let rim = (at - at.round()).abs();
        assert!(!is_hole || rim.x.min(rim.z) < 0.05, "a point at {at}");
    }
    let colour = sample.leaves[0].albedo;
    assert!(colour.distance(Vec3::new(0.578, 0.127, 0.032)) < 0.01, "{colour}");
}

#[test]
fn where_almost_nothing_is_left_points_stand_for_several() {
    let mut scene = sieve();
    // One texel in a corner.
    for texel in scene.textures[0].rgba.chunks_exact_mut(4).skip(1) {
        texel[3] = 0;
    }
    let cloud = points(&scene, 10);
    assert!((leaf_area(&cloud) - 9.0 / 4096.0).abs() < 9.0 / 4096.0, "{}", leaf_area(&cloud));
    scene.textures[0].rgba[3] = 0;
    let error = PointCloud::of_scene(&scene, 10).unwrap_err().to_string();
    assert_eq!(error, "scene plane has no visible surface for points to lie on");
}

/// What of a cloud does not enclose its leaves.
fn not_enclosed(cloud: &PointCloud) -> Vec<String> {
    let (mut found, count) = (Vec::new(), cloud.leaf_count());
    for leaf in count..2 * count {
        let disc = cloud.node(leaf);
        let (u, v) = disc.normal.any_orthonormal_pair();
        let mut above = leaf;
        while above >= 1 {
            let node = cloud.node(above);
            let slack = 1e-5 * node.radius;
            for i in 0..8 {
                let (sin, cos) = (i as f32 * std::f32::consts::FRAC_PI_4).sin_cos();
                let rim = disc.centroid_ws + (u * cos + v * sin) * disc.radius - node.centroid_ws;
                let in_sphere = rim.length() <= node.radius + slack;
                let in_slab = rim.dot(node.normal).abs() <= node.half_thickness + slack;
                if !(in_sphere && in_slab) {
                    found.push(format!("leaf {leaf} reaches out of node {above}: sphere {in_sphere}, slab {in_slab}"));
                }
            }
            let in_cone = disc.normal.dot(node.normal) >= node.cone_cos - 1e-5;
            if !in_cone {
                found.push(format!("leaf {leaf} is outside the cone of node {above}"));
            }
            above /= 2;
        }
    }
    found
}

#[test]
fn nodes_enclose_the_discs_of_their_leaves() {
    for scene in [box_and_wall(), sieve(), plane(1e-3), courtyard()] {
        assert_eq!(not_enclosed(&points(&scene, 9)), [""; 0], "{}", scene.name);
    }
}

#[test]
fn planted_faults_in_nodes_are_noticed() {
    let cloud = points(&box_and_wall(), 6);
    for fault in [
        |node: &mut PackedNode| node.radius *= 0.9,
        |node: &mut PackedNode| node.spread &= 0x3fff_ffff,
        |node: &mut PackedNode| node.spread |= 0xff00,
        |node: &mut PackedNode| node.radius = f32::NAN,
    ] {
        let mut wrong = cloud.clone();
        fault(&mut wrong.nodes[1]);
        assert!(!not_enclosed(&wrong).is_empty());
    }
}

#[test]
fn nodes_sum_up_their_children() {
    let cloud = points(&box_and_wall(), 10);
    for i in 1..cloud.leaf_count() {
        let [node, left, right] = [i, 2 * i, 2 * i + 1].map(|i| cloud.node(i));
        assert!((left.area + right.area - node.area).abs() <= 1e-5 * node.area);
        assert!(
            ((left.centroid_ws + right.centroid_ws) * 0.5).distance(node.centroid_ws) <= 1e-5 * (1.0 + node.radius)
        );
        assert!(leaves_of(i, cloud.leaf_count()).contains(&node.leaf));
        let leaf = cloud.node(cloud.leaf_count() + node.leaf);
        assert!(leaf.normal.dot(node.normal) > 0.5, "node {i} is represented by a leaf that faces another way");
        assert_eq!(left.is_turned, left.normal.dot(node.normal) < 0.0);
        assert_eq!(node.is_solid, left.is_solid && right.is_solid);
        let mean = |i: u32| unpack_rgb9e5(cloud.albedos[i as usize]);
        assert!(((mean(2 * i) + mean(2 * i + 1)) * 0.5).distance(mean(i)) < 0.01);
    }
}

#[test]
fn a_box_is_solid_a_wall_is_not() {
    let scene = box_and_wall();
    let leaves = sampling::sample(&scene, 512).unwrap().leaves;
    assert!(leaves.iter().all(|leaf| leaf.is_solid == (leaf.triangle < 12)));
    let cloud = points(&scene, 9);
    let flat = cloud.node(cloud.leaf_count() + 7);
    assert_eq!((flat.normal_length, flat.cone_cos, flat.leaf), (1.0, 1.0, 7));
    assert!(flat.half_thickness < 1e-3 * flat.radius);
}

#[test]
fn both_sides_of_a_thin_wall_are_represented_by_one_of_them() {
    let [a, b, c, d] = [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y];
    let scene = scene_from_quads("thin", &[[a, b, c, d], [d, c, b, a]], diffuse("thin", Vec3::ONE));
    let root = points(&scene, 8).node(1);
    assert!(root.normal_length < 0.01 && root.cone_cos < -0.99, "{root:?}");
    assert!(root.normal.z.abs() > 0.999, "{}", root.normal);
}

#[test]
fn each_half_lies_on_one_side() {
    let cloud = points(&box_and_wall(), 8);
    let count = cloud.leaf_count();
    for node in 1..count {
        let positions = |node: u32| leaves_of(node, count).map(|leaf| cloud.node(count + leaf).centroid_ws);
        let bounds = |node: u32| positions(node).fold((Vec3::MAX, Vec3::MIN), |(a, b), p| (a.min(p), b.max(p)));
        let (min, max) = bounds(node);
        let axis = (max - min).max_position();
        assert!(bounds(2 * node).1[axis] <= bounds(2 * node + 1).0[axis], "node {node}");
    }
}

#[test]
fn walking_the_subtrees_finds_every_node_once() {
    let count = 64;
    let (mut node, mut seen) = (1, HashSet::new());
    loop {
        assert!(seen.insert(node));
        node = if node < count { 2 * node } else { after_subtree(node) };
        if node == 1 {
            break;
        }
    }
    assert_eq!(seen.len(), 127);
    assert_eq!([after_subtree(1), after_subtree(2), after_subtree(3), after_subtree(5)], [1, 3, 1, 3]);
}

#[test]
fn a_hit_finds_a_leaf_of_its_triangle_nearby() {
    let scene = box_and_wall();
    let (cloud, surface) = (points(&scene, 12), surface::Surface::new(&scene));
    let leaves = cloud.leaf_count()..2 * cloud.leaf_count();
    for triangle in 0..14 {
        let corners = surface.triangle(triangle as usize);
        for i in 0..100u32 {
            let [x, y] = crate::random::r2_sequence(i, triangle);
            let at = if x + y > 1.0 { Vec2::new(1.0 - x, 1.0 - y) } else { Vec2::new(x, y) };
            let found = cloud.node(cloud.leaf_count() + cloud.leaf_of_hit(triangle, at));
            let place = corners.position(at);
            assert!(found.normal.dot(corners.normal()) > 0.99);
            let nearest = leaves.clone().map(|leaf| cloud.node(leaf).centroid_ws.distance(place));
            let nearest = nearest.fold(f32::MAX, f32::min);
            let distance = found.centroid_ws.distance(place);
            assert!(distance <= nearest + 3.0 * cloud.leaf_radius, "{distance} instead of {nearest}");
        }
    }
}

#[test]
fn few_and_many_leaves_of_a_triangle_find_the_nearest() {
    // More leaves than are tried one by one, and then fewer.
    for (count_log2, expected_edge) in [(8, 12), (4, 3)] {
        let (scene, count) = (plane(2.0), 1 << count_log2);
        let cloud = points(&scene, count_log2);
        assert_eq!(cloud.triangle_cells[0].edge, expected_edge);
        let own: HashSet<u32> = cloud.leaf_cells.iter().copied().collect();
        assert!(own.len() as u32 > count / 2, "{} of {count} leaves are named", own.len());
        let middle = Vec2::splat(1.0 / 3.0 / expected_edge as f32);
        let place = surface::Surface::new(&scene).triangle(0).position(middle);
        let distance = |leaf: u32| cloud.node(count + leaf).centroid_ws.distance(place);
        let nearest = (0..count).map(distance).fold(f32::MAX, f32::min);
        assert!(distance(cloud.leaf_of_hit(0, middle)) <= nearest + 1.0 * cloud.leaf_radius);
    }
}

#[test]
fn triangles_without_leaves_name_one_that_faces_their_way() {
    // A thousand slivers on the box's lid, which have no leaves of their own, and one triangle that is a line.
    let mut scene = box_room(2.0, Vec3::ONE);
    let first = scene.triangle_materials.len() as u32;
    for i in 0..1000 {
        let x = i as f32 * 1e-3 - 0.5;
        let corners = [[x, 1.0, 0.0], [x + 1e-5, 1.0, 0.0], [x, 1.0, if i == 999 { 0.0 } else { 1e-5 }]];
        let normal_oct = 0;
        let vertex = scene.vertices.len() as u32;
        scene.vertices.extend(corners.map(|position_ws| crate::scene::Vertex {
            position_ws,
            normal_oct,
            uv: [0.0; 2],
            color: crate::scene::Vertex::WHITE,
        }));
        scene.indices.extend([vertex, vertex + 1, vertex + 2]);
        scene.triangle_materials.push(0);
    }
    let cloud = points(&scene, 8);
    for triangle in first..first + 1000 {
        let leaf = cloud.node(cloud.leaf_count() + cloud.leaf_of_hit(triangle, Vec2::splat(0.2)));
        assert!(leaf.normal.y < -0.99 || triangle == first + 999, "{}", leaf.normal);
    }
}

#[test]
fn awkward_sizes() {
    let one = |scale: f32| {
        let mut scene = plane(scale);
        scene.indices.truncate(3);
        scene.triangle_materials.truncate(1);
        scene
    };
    for cloud in [points(&one(1.0), 0), points(&one(1.0), 12), points(&one(1e-7), 8), points(&one(1e6), 5)] {
        assert_eq!(cloud.nodes.len(), 2 * cloud.leaf_count() as usize);
        for node in 1..2 * cloud.leaf_count() {
            let node = cloud.node(node);
            let numbers = [node.radius, node.area, node.half_thickness, node.cone_cos, node.centroid_ws.length()];
            assert!(numbers.iter().all(|n| n.is_finite()) && node.radius > 0.0 && node.area > 0.0, "{node:?}");
        }
        assert!(cloud.leaf_of_hit(0, Vec2::splat(0.3)) < cloud.leaf_count());
    }
    // All at one place: far from the origin the corners of a small triangle are hardly told apart.
    let mut far = one(1e-3);
    far.vertices.iter_mut().for_each(|vertex| vertex.position_ws[0] += 8192.0);
    let cloud = points(&far, 10);
    assert!(cloud.node(1).radius.is_finite() && cloud.node(1).normal.is_finite());
    assert!(PointCloud::of_scene(&plane(1.0), 22).is_err());
    assert!(PointCloud::of_scene(&plane(0.0), 4).is_err());
}

#[test]
fn a_scene_has_the_same_points_every_time() {
    let scene = box_and_wall();
    assert!(points(&scene, 10) == points(&scene, 10));
}

#[test]
fn albedo_is_blurred_over_the_disc() {
    let mut scene = plane(1.0);
    // Black and white texels; a disc covers many.
    let rgba = (0..256 * 256u32).flat_map(|i| if (i + i / 256).is_multiple_of(2) { [255; 4] } else { [0, 0, 0, 255] });
    scene.textures = vec![Texture { name: "fine".into(), width: 256, height: 256, rgba: rgba.collect() }];
    scene.materials[0].base_color_texture = Some(0);
    scene.materials[0].base_color = Vec4::new(1.0, 0.5, 0.0, 1.0).to_array();
    for leaf in sampling::sample(&scene, 64).unwrap().leaves {
        assert!(leaf.albedo.distance(Vec3::new(0.5, 0.25, 0.0)) < 0.01, "{}", leaf.albedo);
        assert!((leaf.normal - unpack_octahedral(scene.vertices[0].normal_oct)).length() < 1e-3);
    }
}
