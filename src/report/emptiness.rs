//! What to say of a picture that shows nothing.

use glam::Vec2;

use crate::camera::{Camera, View};
use crate::scene::{Light, Scene};
use crate::settings::Size;

/// Why the final picture of a scene, as it stands now, is empty or black; nothing where something shows.
#[must_use]
pub fn sentence(scene: &Scene, camera: &Camera, size: Size, radiance: &[f32]) -> Option<String> {
    let is_black = !radiance.iter().any(|value| *value > 0.0);
    let name = &camera.name;
    match (sees_a_triangle(scene, camera, size), is_black) {
        (false, false) => Some(format!("the camera `{name}` sees none of the scene's triangles")),
        (false, true) => Some(format!("the picture is black: the camera `{name}` sees none of the scene's triangles")),
        (true, true) if scene.environment.is_none() && scene.lights.iter().all(Light::is_dark) => {
            Some("the picture is black: no light of the scene shines".to_owned())
        }
        (true, true) => Some(format!(
            "the picture is black: no light reaches what the camera `{name}` sees; it may be inside a solid"
        )),
        (true, false) => None,
    }
}

/// Whether a triangle may be within the camera's view: whether not all of its corners are beyond one side of it.
fn sees_a_triangle(scene: &Scene, camera: &Camera, size: Size) -> bool {
    let clip_from_world = View::new(camera, size.width, size.height, Vec2::ZERO).clip_from_world;
    let beyond = |vertex: u32| {
        let [x, y, z] = scene.vertices[vertex as usize].position_ws;
        let at = clip_from_world * glam::vec4(x, y, z, 1.0);
        // The near plane is where z is w; there is no far plane.
        [at.x > at.w, at.x < -at.w, at.y > at.w, at.y < -at.w, at.z > at.w]
    };
    scene.indices.as_chunks().0.iter().any(|triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(beyond);
        (0..5).all(|side| !(a[side] && b[side] && c[side]))
    })
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::scene::testing::plane;

    const SIZE: Size = Size { width: 16, height: 9 };

    fn said(scene: &Scene, camera: &Camera, radiance: f32) -> String {
        sentence(scene, camera, SIZE, &[0.0, radiance]).unwrap_or_default()
    }

    #[test]
    fn what_is_empty_is_said() {
        let mut scene = plane(2.0);
        let camera = scene.cameras[0].clone();
        let away = Camera { forward_ws: -camera.forward_ws, right_ws: -camera.right_ws, ..camera.clone() };
        assert_eq!(said(&scene, &camera, 1.0), "");
        assert!(said(&scene, &away, 1.0).ends_with("sees none of the scene's triangles"));
        assert!(said(&scene, &away, 0.0).starts_with("the picture is black: the camera"));
        assert!(said(&scene, &camera, 0.0).contains("no light reaches"));
        assert!(said(&scene, &camera, f32::NAN).contains("no light reaches"));
        scene.lights = vec![Light::DARK];
        assert!(said(&scene, &camera, 0.0).contains("no light of the scene shines"));
    }

    #[test]
    fn a_triangle_around_the_eye_is_seen() {
        let scene = plane(100.0);
        let above = Camera { position_ws: Vec3::Y, ..scene.cameras[0].clone() };
        let down = crate::camera::turned(&above, 0.0, -1.5);
        assert!(sees_a_triangle(&scene, &down, SIZE));
        let up = crate::camera::turned(&above, 0.0, std::f32::consts::FRAC_PI_2);
        assert!(!sees_a_triangle(&scene, &up, SIZE));
    }
}
