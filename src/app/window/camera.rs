//! A camera that flies.

use glam::Vec3;

use crate::camera::{angles_rad, as_setting, turned};
use crate::scene::Camera;

/// Steepest view up or down.
const STEEPEST_RAD: f32 = 1.55;
/// Turn for a pixel of mouse movement.
const RAD_PER_PX: f32 = 0.003;

/// A camera with the angles that mouse and keys change.
pub struct FlyCamera {
    camera: Camera,
    yaw_rad: f32,
    pitch_rad: f32,
    /// It is no longer where it started.
    flown: bool,
}

impl FlyCamera {
    /// Starts at a camera of the scene; it is held upright from the first turn on.
    pub fn new(camera: &Camera) -> Self {
        let [yaw_rad, pitch_rad] = angles_rad(camera);
        Self { camera: camera.clone(), yaw_rad, pitch_rad, flown: false }
    }

    /// Stands in until there is a scene.
    pub fn nowhere() -> Self {
        Self::new(&Camera {
            name: String::new(),
            position_ws: Vec3::ZERO,
            right_ws: Vec3::X,
            up_ws: Vec3::Y,
            forward_ws: Vec3::NEG_Z,
            yfov_rad: 1.0,
            near: 0.1,
        })
    }

    /// The camera as it is now.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Its place as a setting, when it is no longer that of the scene's camera.
    pub fn setting(&self) -> Option<String> {
        self.flown.then(|| as_setting(&self.camera))
    }

    /// Turns by a movement of the mouse, right and down.
    pub fn look(&mut self, dx_px: f32, dy_px: f32) {
        self.yaw_rad += dx_px * RAD_PER_PX;
        self.pitch_rad = (self.pitch_rad - dy_px * RAD_PER_PX).clamp(-STEEPEST_RAD, STEEPEST_RAD);
        self.camera = turned(&self.camera, self.yaw_rad, self.pitch_rad);
        self.flown = true;
    }

    /// Moves by metres to the right, up and ahead, as the camera is turned.
    pub fn fly(&mut self, right_up_ahead: Vec3) {
        let Camera { right_ws, up_ws, forward_ws, .. } = &self.camera;
        self.flown = true;
        self.camera.position_ws +=
            *right_ws * right_up_ahead.x + *up_ws * right_up_ahead.y + *forward_ws * right_up_ahead.z;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> FlyCamera {
        FlyCamera::new(&Camera {
            name: "c".to_owned(),
            position_ws: Vec3::ZERO,
            right_ws: Vec3::X,
            up_ws: Vec3::Y,
            forward_ws: Vec3::NEG_Z,
            yfov_rad: 1.0,
            near: 0.1,
        })
    }

    #[test]
    fn looking_nowhere_changes_nothing() {
        let mut fly = camera();
        let before = fly.camera().clone();
        fly.look(0.0, 0.0);
        assert!(fly.camera().forward_ws.distance(before.forward_ws) < 1e-6);
        assert!(fly.camera().up_ws.distance(before.up_ws) < 1e-6);
    }

    #[test]
    fn the_mouse_turns_right_and_up_and_not_over_the_top() {
        let mut fly = camera();
        fly.look(100.0, -100.0);
        let Camera { forward_ws, right_ws, up_ws, .. } = fly.camera();
        assert!(forward_ws.x > 0.2 && forward_ws.y > 0.2, "{forward_ws}");
        assert!(right_ws.cross(*forward_ws).distance(*up_ws) < 1e-5 && up_ws.y > 0.0);
        fly.look(0.0, -1e6);
        assert!(fly.camera().up_ws.y > 0.0);
    }

    #[test]
    fn it_flies_where_it_looks() {
        let mut fly = camera();
        fly.fly(Vec3::new(1.0, 2.0, 3.0));
        assert!(fly.camera().position_ws.distance(Vec3::new(1.0, 2.0, -3.0)) < 1e-5);
    }
}
