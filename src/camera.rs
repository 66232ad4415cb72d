//! Cameras, and the way from one to the frame's constants. Reversed Z, infinite far plane, y down in the picture.

use glam::{Mat4, Vec2, Vec3, Vec4};

/// A pinhole camera with an orthonormal world-space frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// The node's name (or the camera's), unique within the scene.
    pub name: String,
    /// Eye position.
    pub position_ws: Vec3,
    /// Unit vector to the right of the picture.
    pub right_ws: Vec3,
    /// Unit vector to the top of the picture.
    pub up_ws: Vec3,
    /// Unit viewing direction.
    pub forward_ws: Vec3,
    /// Vertical field of view in radians.
    pub yfov_rad: f32,
    /// Near plane distance.
    pub near: f32,
    /// How far behind the place of its node the eye is, in metres: above 0 for cameras that stand for parallel views.
    pub set_back: f32,
}

/// A parallel view's camera stands so many half heights of its picture, at least, from the middle of what it looks at,
const PARALLEL_HALF_HEIGHTS: f32 = 64.0;
/// and so many radii of the scene. Farther away, depth would have fewer digits than rays off a surface need.
const PARALLEL_RADII: f32 = 16.0;

/// A camera that sees from far away nearly what a parallel view of a half height of `half_height` metres sees, in the middle
/// of a scene just that. Nothing in front of the parallel view's own near plane comes into sight.
#[must_use]
pub fn nearly_parallel(camera: &Camera, half_height: f32, scene_center_ws: Vec3, scene_radius: f32) -> Camera {
    let distance = (PARALLEL_HALF_HEIGHTS * half_height).max(PARALLEL_RADII * scene_radius);
    let set_back = distance - (scene_center_ws - camera.position_ws).dot(camera.forward_ws);
    Camera {
        position_ws: camera.position_ws - camera.forward_ws * set_back,
        yfov_rad: 2.0 * (half_height / distance).atan(),
        near: (camera.near + set_back).max(1e-3 * distance),
        set_back,
        ..camera.clone()
    }
}

/// A camera that stands upright and looks in a [`direction`].
#[must_use]
pub fn turned(camera: &Camera, azimuth_rad: f32, height_rad: f32) -> Camera {
    let forward_ws = direction(azimuth_rad, height_rad);
    let right_ws = Vec3::new(azimuth_rad.cos(), 0.0, azimuth_rad.sin());
    Camera { forward_ws, right_ws, up_ws: right_ws.cross(forward_ws), ..camera.clone() }
}

/// Azimuth and height of a camera's view, in radians.
#[must_use]
pub fn angles_rad(camera: &Camera) -> [f32; 2] {
    compass_rad(camera.forward_ws)
}

/// The unit direction of a compass: azimuth 0 along -z and 90 degrees along x, height upwards.
#[must_use]
pub fn direction(azimuth_rad: f32, height_rad: f32) -> Vec3 {
    let (sin_azimuth, cos_azimuth) = azimuth_rad.sin_cos();
    let (sin_height, cos_height) = height_rad.sin_cos();
    Vec3::new(sin_azimuth * cos_height, sin_height, -cos_azimuth * cos_height)
}

/// Azimuth and height of a unit direction, in radians: the inverse of [`direction`].
#[must_use]
pub fn compass_rad(direction: Vec3) -> [f32; 2] {
    [direction.x.atan2(-direction.z), direction.y.clamp(-1.0, 1.0).asin()]
}

/// A camera as a setting has it when it is none of the scene's: position; azimuth, height and vertical field of view in
/// degrees.
#[must_use]
pub fn as_setting(camera: &Camera) -> String {
    let Vec3 { x, y, z } = camera.position_ws;
    let [azimuth, height] = angles_rad(camera).map(f32::to_degrees);
    format!("{x:.5},{y:.5},{z:.5},{azimuth:.4},{height:.4},{:.4}", camera.yfov_rad.to_degrees())
}

/// The camera that [`as_setting`] describes; its near plane, and where it is not given its field of view, are those of
/// `like`.
#[must_use]
pub fn from_setting(text: &str, like: &Camera) -> Option<Camera> {
    let numbers: Vec<f32> = text.split(',').map(|n| n.trim().parse().ok()).collect::<Option<_>>()?;
    let (place, field) = numbers.split_at_checked(5)?;
    let [x, y, z, azimuth, height] = *<&[f32; 5]>::try_from(place).ok()?;
    let yfov = match field {
        [] => like.yfov_rad.to_degrees(),
        [yfov] => *yfov,
        _ => return None,
    };
    let fits = numbers.iter().all(|n| n.is_finite()) && height.abs() < 90.0 && yfov > 0.0 && yfov < 180.0;
    let camera = turned(like, azimuth.to_radians(), height.to_radians());
    let (name, position_ws) = (text.to_owned(), Vec3::new(x, y, z));
    fits.then(|| Camera { name, position_ws, yfov_rad: yfov.to_radians(), ..camera })
}

/// A camera at a picture size, as the shaders use it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Clip space from world space.
    pub clip_from_world: Mat4,
    /// Eye position.
    pub eye_ws: Vec3,
    /// Unit viewing direction.
    pub forward_ws: Vec3,
    /// Right vector times tan(half horizontal field of view).
    pub right_ws: Vec3,
    /// Up vector times tan(half vertical field of view).
    pub up_ws: Vec3,
    /// Near plane distance.
    pub near: f32,
}

impl View {
    /// The camera's view onto a picture; the vertical field of view is the camera's, the horizontal one follows.
    /// `jitter_px` leads from the pixel centres to where pixels are sampled, y down.
    #[must_use]
    pub fn new(camera: &Camera, width_px: u32, height_px: u32, jitter_px: Vec2) -> Self {
        let half_height = (camera.yfov_rad * 0.5).tan();
        let half_width = half_height * width_px as f32 / height_px as f32;
        let row = |axis: Vec3, scale: f32| (axis * scale).extend(-axis.dot(camera.position_ws) * scale);
        // The picture moves against the sampling points; clip w is the distance along the viewing direction.
        let ahead = row(camera.forward_ws, 1.0);
        let rows = [
            row(camera.right_ws, 1.0 / half_width) - ahead * (2.0 * jitter_px.x / width_px as f32),
            row(camera.up_ws, -1.0 / half_height) - ahead * (2.0 * jitter_px.y / height_px as f32),
            Vec4::new(0.0, 0.0, 0.0, camera.near),
            ahead,
        ];
        Self {
            clip_from_world: Mat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose(),
            eye_ws: camera.position_ws,
            forward_ws: camera.forward_ws,
            right_ws: camera.right_ws * half_width,
            up_ws: camera.up_ws * half_height,
            near: camera.near,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_survives_as_a_setting() {
        let camera = Camera {
            name: "a".to_owned(),
            position_ws: Vec3::new(1.5, -2.0, 0.25),
            right_ws: Vec3::X,
            up_ws: Vec3::Y,
            forward_ws: Vec3::NEG_Z,
            yfov_rad: 1.0,
            near: 0.1,
            set_back: 0.0,
        };
        let camera = turned(&camera, 0.7, -0.3);
        let text = as_setting(&camera);
        let again = from_setting(&text, &Camera { yfov_rad: 0.5, ..camera.clone() }).unwrap();
        assert!((again.yfov_rad - 1.0).abs() < 1e-4, "{text}");
        assert!(again.position_ws.distance(camera.position_ws) < 1e-3, "{text}");
        assert!(again.forward_ws.distance(camera.forward_ws) < 1e-3 && again.up_ws.y > 0.9, "{text}");
        for wrong in ["", "court", "1,2,3", "1,2,3,4,x", "1,2,3,4,95", "1,2,3,4,nan", "1,2,3,4,5,180", "1,2,3,4,5,6,7"]
        {
            assert_eq!(from_setting(wrong, &camera), None, "{wrong}");
        }
    }

    #[test]
    fn a_parallel_view_is_seen_from_far_away() {
        let camera = Camera {
            name: String::new(),
            position_ws: Vec3::new(0.0, 5.0, 0.0),
            right_ws: Vec3::X,
            up_ws: Vec3::NEG_Z,
            forward_ws: Vec3::NEG_Y,
            yfov_rad: 1.0,
            near: 0.5,
            set_back: 0.0,
        };
        let far = nearly_parallel(&camera, 2.0, Vec3::ZERO, 3.0);
        let ndc = |point: Vec3| {
            let clip = View::new(&far, 100, 100, Vec2::ZERO).clip_from_world * point.extend(1.0);
            clip / clip.w
        };
        let edge = ndc(Vec3::new(2.0, 0.0, 0.0));
        assert!((edge.x - 1.0).abs() < 1e-4, "exact in the middle: {edge}");
        let above = ndc(Vec3::new(2.0, 3.0, 0.0));
        assert!((above.x - 1.0).abs() < 0.03, "nearly so elsewhere: {above}");
        // The near plane is where it was: 0.5 in front of the place in the file.
        assert!(ndc(Vec3::new(0.0, 4.4, 0.0)).z < 1.0 && ndc(Vec3::new(0.0, 4.6, 0.0)).z > 1.0);
        assert!((far.position_ws.y - far.set_back - 5.0).abs() < 1e-3 && far.forward_ws == Vec3::NEG_Y);
    }

    #[test]
    fn a_point_up_and_right_lands_up_and_right_with_reversed_depth() {
        let camera = Camera {
            name: String::new(),
            position_ws: Vec3::new(1.0, 2.0, 3.0),
            right_ws: Vec3::X,
            up_ws: Vec3::Y,
            forward_ws: Vec3::NEG_Z,
            yfov_rad: std::f32::consts::FRAC_PI_2,
            near: 0.1,
            set_back: 0.0,
        };
        let view = View::new(&camera, 200, 100, Vec2::ZERO);
        let clip = view.clip_from_world * Vec4::new(1.0 + 4.0, 2.0 + 1.0, 3.0 - 2.0, 1.0);
        let ndc = clip / clip.w;
        // At distance 2 the picture is 4 high and 8 wide: x = 4 of 4, y = 1 of 2 (up is negative).
        assert!((ndc.x - 1.0).abs() < 1e-6 && (ndc.y + 0.5).abs() < 1e-6, "{ndc}");
        assert!((ndc.z - 0.05).abs() < 1e-6, "{ndc}");
        // Sampling 1/4 pixel to the right and 1/2 below moves the picture by 1/400 and 1/100 of its half sizes.
        let clip = View::new(&camera, 200, 100, Vec2::new(0.25, 0.5)).clip_from_world * Vec4::new(5.0, 3.0, 1.0, 1.0);
        let moved = clip / clip.w - ndc;
        assert!((moved.x + 0.0025).abs() < 1e-6 && (moved.y + 0.01).abs() < 1e-6, "{moved}");
    }
}
