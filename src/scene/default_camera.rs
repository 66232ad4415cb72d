//! Where a scene that brings no camera is seen from: inside when it stands around its middle, else from outside.

use std::f32::consts::TAU;

use glam::Vec3;

use super::bvh::{BvhTriangle, Ray};
use super::gltf_nodes::framing_camera;
use super::{Aabb, Camera, Vertex};
use crate::camera::{direction, turned};

/// Height of the eye between the floor below the middle of the scene and that middle.
const EYE_HEIGHT: f32 = 0.3;
/// How far the camera stands back from above that floor, as a fraction of the way to the wall behind it.
const STEP_BACK: f32 = 0.8;
/// Horizontal directions that are looked at.
const DIRECTIONS: u32 = 8;
/// A scene is around a point that sees front faces in all directions but for so many: a door, a gap in a mesh. From within
/// a closed object there are back faces to see.
const GAPS: usize = 1;

/// The camera; rays are traced by trying every triangle, of which there are `indices.len() / 3`.
pub(super) fn default_camera(vertices: &[Vertex], indices: &[u32], bounds: &Aabb) -> Camera {
    inside_camera(vertices, indices, bounds).unwrap_or_else(|| framing_camera(bounds))
}

fn inside_camera(vertices: &[Vertex], indices: &[u32], bounds: &Aabb) -> Option<Camera> {
    let free = |origin, direction| free_distance(vertices, indices, origin, direction);
    let center = bounds.center();
    let below = free(center, Vec3::NEG_Y)?;
    let eye = center - Vec3::Y * (below * (1.0 - EYE_HEIGHT));
    let azimuth_rad = |i: u32| i as f32 * TAU / DIRECTIONS as f32;
    let around: Vec<Option<f32>> = (0..DIRECTIONS).map(|i| free(eye, direction(azimuth_rad(i), 0.0))).collect();
    if around.iter().filter(|distance| distance.is_none()).count() > GAPS {
        return None;
    }
    // The longest way across, looked along from its nearer end.
    let far = |i: u32| around[i as usize].unwrap_or(bounds.radius());
    let opposite = |i: u32| (i + DIRECTIONS / 2) % DIRECTIONS;
    let across = |i: &u32| far(*i) + far(opposite(*i));
    let longest = (0..DIRECTIONS / 2).max_by(|a, b| across(a).total_cmp(&across(b)))?;
    let ahead = if far(longest) >= far(opposite(longest)) { longest } else { opposite(longest) };
    let camera = turned(&framing_camera(bounds), azimuth_rad(ahead), 0.0);
    let position_ws = eye - camera.forward_ws * (STEP_BACK * far(opposite(ahead)));
    Some(Camera { position_ws, yfov_rad: 60_f32.to_radians(), ..camera })
}

/// How far a ray of unit direction goes before it meets a triangle, when that is from its front.
fn free_distance(vertices: &[Vertex], indices: &[u32], origin: Vec3, direction: Vec3) -> Option<f32> {
    let ray = Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY };
    let corner = |index: u32| Vec3::from_array(vertices[index as usize].position_ws);
    let triangles = indices.chunks_exact(3).map(|t| BvhTriangle::new([corner(t[0]), corner(t[1]), corner(t[2])]));
    let hits = triangles.filter_map(|triangle| Some((triangle.intersect(&ray)?.t, triangle)));
    let (distance, triangle) = hits.min_by(|a, b| a.0.total_cmp(&b.0))?;
    triangle.is_met_in_front(direction).then_some(distance)
}

#[cfg(test)]
mod tests {
    use super::super::testing::{box_room, diffuse, scene_from_quads};
    use super::super::{Scene, gltf};
    use super::*;

    fn camera_of(scene: &Scene) -> Camera {
        default_camera(&scene.vertices, &scene.indices, &scene.bounds)
    }

    /// The box room, stretched along x and shifted.
    fn hall() -> Scene {
        let mut scene = box_room(2.0, Vec3::splat(0.5));
        for vertex in &mut scene.vertices {
            vertex.position_ws[0] = 4.0 * vertex.position_ws[0] + 3.0;
        }
        scene.bounds = gltf::bounds(&scene.vertices, &scene.indices);
        scene
    }

    #[test]
    fn a_hall_is_seen_from_one_of_its_ends() {
        let scene = hall();
        let camera = camera_of(&scene);
        let Aabb { min, max } = scene.bounds;
        assert!(camera.position_ws.cmpgt(min).all() && camera.position_ws.cmplt(max).all(), "{camera:?}");
        assert!(camera.forward_ws.x.abs() > 0.99, "along its length: {}", camera.forward_ws);
        let behind = (camera.position_ws - camera.forward_ws * max.x.max(-min.x)).x;
        assert!(behind < min.x || behind > max.x, "an end is behind it");
        let walked = (camera.position_ws - scene.bounds.center()).dot(camera.forward_ws);
        assert!(walked < -0.3 * (max.x - min.x), "it stands well back: {walked}");
        assert!(camera.right_ws.cross(camera.up_ws).distance(-camera.forward_ws) < 1e-5);
    }

    #[test]
    fn without_a_roof_it_still_is_a_hall() {
        let mut scene = hall();
        let top = scene.bounds.max.y;
        let (vertices, below) = (scene.vertices.clone(), |i: &u32| scene.vertices[*i as usize].position_ws[1] < top);
        scene.indices = scene.indices.chunks_exact(3).filter(|t| t.iter().any(below)).flatten().copied().collect();
        let camera = default_camera(&vertices, &scene.indices, &scene.bounds);
        assert!(camera.position_ws.x > scene.bounds.min.x && camera.position_ws.x < scene.bounds.max.x);
    }

    #[test]
    fn what_stands_in_the_open_is_seen_from_outside() {
        let floor = [[-1, 1], [1, 1], [1, -1], [-1, -1]].map(|[x, z]| Vec3::new(x as f32, 0.0, z as f32));
        let wall = floor.map(|p| Vec3::new(p.x, 1.0 + p.z, 0.5));
        for quads in [vec![floor], vec![floor, wall]] {
            let scene = scene_from_quads("open", &quads, diffuse("grey", Vec3::splat(0.5)));
            assert_eq!(camera_of(&scene), framing_camera(&scene.bounds));
        }
    }

    #[test]
    fn a_closed_object_is_seen_from_outside() {
        let mut scene = hall();
        scene.indices.reverse();
        assert_eq!(camera_of(&scene), framing_camera(&scene.bounds));
    }

    #[test]
    fn triangles_without_area_are_no_walls() {
        let point = [Vec3::ZERO; 4];
        let scene = scene_from_quads("point", &[point], diffuse("grey", Vec3::splat(0.5)));
        assert_eq!(camera_of(&scene), framing_camera(&scene.bounds));
    }
}
