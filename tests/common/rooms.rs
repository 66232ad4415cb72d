//! Rooms to render in.

use std::f32::consts::PI;
use std::path::Path;

use glam::Vec3;
use gridlight::scene::bvh::{BinaryBvh, Ray};
use gridlight::scene::testing::{box_room, diffuse, scene_from_quads};
use gridlight::scene::{Camera, Draw, Light, Material, Scene, gltf};
use gridlight::settings::Size;

/// A camera that looks from a place in a direction, upright, or with z upwards where it looks straight up or down.
pub fn camera(position_ws: Vec3, forward_ws: Vec3, yfov_rad: f32) -> Camera {
    let right_ws = forward_ws.cross(if forward_ws.y.abs() > 0.9 { Vec3::Z } else { Vec3::Y }).normalize();
    let up_ws = right_ws.cross(forward_ws);
    Camera { name: "test".into(), position_ws, right_ws, up_ws, forward_ws, yfov_rad, near: 0.01, set_back: 0.0 }
}

/// The built-in scene.
pub fn courtyard() -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/courtyard.glb");
    gltf::load(&path, &|_: &str, _, _| ()).unwrap()
}

/// A closed room with one lamp, seen from inside.
pub fn lamp_room(albedo: Vec3) -> Scene {
    let mut scene = box_room(4.0, albedo);
    scene.lights = vec![Light::Point { position_ws: Vec3::new(0.3, 0.9, 0.2), intensity: Vec3::new(9.0, 6.0, 3.0) }];
    scene.cameras = vec![camera(Vec3::new(-1.5, 0.3, 1.4), Vec3::new(0.7, -0.2, -0.9).normalize(), 1.2)];
    scene
}

/// The inside of a ball of radius 1 about a lamp that gives it an irradiance of pi, from near its centre: all of it has the same
/// light, and sends the same to all of it.
pub fn inside_of_ball(albedo: f32) -> Scene {
    let (columns, rows) = (48, 24);
    let at = |x: u32, y: u32| {
        let x = if y == 0 || y == rows { 0 } else { x % columns };
        let (around, down) = (x as f32 / columns as f32 * 2.0 * PI, y as f32 / rows as f32 * PI);
        Vec3::new(down.sin() * around.cos(), down.cos(), down.sin() * around.sin())
    };
    let quads: Vec<_> = (0..columns * rows)
        .map(|i| (i % columns, i / columns))
        .map(|(x, y)| [at(x + 1, y + 1), at(x + 1, y), at(x, y), at(x, y + 1)])
        .collect();
    let mut scene = scene_from_quads("ball", &quads, diffuse("grey", Vec3::splat(albedo)));
    scene.lights = vec![Light::Point { position_ws: Vec3::ZERO, intensity: Vec3::splat(PI) }];
    scene.cameras = vec![camera(Vec3::new(0.1, 0.05, 0.3), Vec3::new(0.3, -0.1, -1.0).normalize(), 0.9)];
    scene
}

/// The room with a table and a shelf in it, so that depth and normal break.
pub fn furnished_room() -> Scene {
    let mut scene = lamp_room(Vec3::new(0.7, 0.5, 0.3));
    let top = |y: f32, h: f32| [Vec3::new(-h, y, h), Vec3::new(h, y, h), Vec3::new(h, y, -h), Vec3::new(-h, y, -h)];
    add_quad(&mut scene, top(-0.4, 0.5));
    add_quad(&mut scene, top(-0.9, 0.2).map(|p| p + Vec3::new(-1.0, 0.3, 0.6)));
    scene
}

/// Adds a quad to a scene of one material.
pub fn add_quad(scene: &mut Scene, quad: [Vec3; 4]) {
    let part = scene_from_quads("quad", &[quad], scene.materials[0].clone());
    let first = scene.vertices.len() as u32;
    scene.vertices.extend(part.vertices);
    scene.indices.extend(part.indices.iter().map(|i| first + i));
    scene.triangle_materials.extend(part.triangle_materials);
    scene.draws[0].index_count = scene.indices.len() as u32;
}

/// Adds a quad of another material.
pub fn add_quad_of(scene: &mut Scene, quad: [Vec3; 4], material: Material) {
    let part = scene_from_quads("quad", &[quad], material);
    let first = scene.vertices.len() as u32;
    let material = scene.materials.len() as u32;
    let draw = Draw { first_index: scene.indices.len() as u32, index_count: 6, material };
    scene.vertices.extend(part.vertices);
    scene.indices.extend(part.indices.iter().map(|i| first + i));
    scene.triangle_materials.extend([material; 2]);
    scene.draws.push(draw);
    scene.materials.extend(part.materials);
}

/// Where the ray through a pixel's centre meets [`lamp_room`]: the point, the wall's normal, the depth.
pub fn surface(bvh: &BinaryBvh, camera: &Camera, size: Size, index: usize) -> (Vec3, Vec3, f32) {
    let [x, y] = [index as u32 % size.width, index as u32 / size.width];
    let half = (camera.yfov_rad * 0.5).tan();
    let ndc_x = (x as f32 + 0.5) / size.width as f32 * 2.0 - 1.0;
    let ndc_y = 1.0 - (y as f32 + 0.5) / size.height as f32 * 2.0;
    let aspect = size.width as f32 / size.height as f32;
    let direction = camera.forward_ws + camera.right_ws * (ndc_x * half * aspect) + camera.up_ws * (ndc_y * half);
    let ray = Ray { origin: camera.position_ws, direction, t_min: 0.0, t_max: f32::MAX };
    let depth = bvh.trace_closest(&ray).expect("the room is closed").t;
    let position = ray.origin + direction * depth;
    let axis = position.abs().max_position();
    let mut normal = Vec3::ZERO;
    normal[axis] = -position[axis].signum();
    (position, normal, depth)
}

/// A floor and a wall lit by the sun, a roof between them that shadows, and sky around.
pub fn roofed_floor() -> Scene {
    let quad = |origin: Vec3, u: Vec3, v: Vec3| [origin, origin + u, origin + u + v, origin + v];
    let quads = [
        quad(Vec3::new(-3.0, 0.0, 3.0), Vec3::X * 6.0, Vec3::NEG_Z * 6.0),
        quad(Vec3::new(-3.0, 0.0, -3.0), Vec3::X * 6.0, Vec3::Y * 4.0),
        quad(Vec3::new(-1.0, 1.0, 1.0), Vec3::X * 2.0, Vec3::NEG_Z * 2.0),
    ];
    let mut scene = scene_from_quads("roof", &quads, diffuse("wall", Vec3::splat(0.7)));
    let direction_ws = Vec3::new(0.3, -1.0, -0.6).normalize();
    scene.lights = vec![Light::Directional { direction_ws, irradiance: Vec3::splat(3.0) }];
    scene
}

/// Before the roofed floor's wall a screen that turns by 8 to 46 degrees from panel to panel, and before that a fence of
/// slats narrower than the pixels of a small picture. Seen from so far that most edges are turns.
pub fn folding_screen() -> Scene {
    let mut scene = roofed_floor();
    let mut at = Vec3::new(-1.7, 0.0, -2.0);
    for turn_deg in [0.0_f32, 8.0, -6.0, 14.0, -16.0, 30.0] {
        let (sin, cos) = turn_deg.to_radians().sin_cos();
        let (along, up) = (0.6 * Vec3::new(cos, 0.0, sin), 2.6 * Vec3::Y);
        add_quad(&mut scene, [at, at + along, at + along + up, at + up]);
        at += along;
    }
    for slat in -5..=5_i8 {
        let left = Vec3::new(0.45 * f32::from(slat), 0.0, 2.5);
        let (right, up) = (0.06 * Vec3::X, 1.6 * Vec3::Y);
        add_quad(&mut scene, [left, left + right, left + right + up, left + up]);
    }
    let (from, to) = (Vec3::new(4.0, 3.5, 9.0), Vec3::new(0.0, 1.8, -0.5));
    scene.cameras = vec![camera(from, (to - from).normalize(), 0.45)];
    scene
}
