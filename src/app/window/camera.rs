//! A camera that flies, or turns about a point.

use glam::Vec3;

use crate::camera::{angles_rad, as_setting, turned};
use crate::scene::{Aabb, Camera};

/// Steepest view up or down.
const STEEPEST_RAD: f32 = 1.55;
/// Turn for a pixel of mouse movement.
const RAD_PER_PX: f32 = 0.003;
/// Change of the distance for a notch of the wheel.
const ZOOM_STEP: f32 = 1.15;

/// A camera with the angles that mouse and keys change.
pub struct FlyCamera {
    camera: Camera,
    yaw_rad: f32,
    pitch_rad: f32,
    /// It is no longer where it started.
    flown: bool,
    /// What it turns about, when it does not fly.
    pivot_ws: Option<Vec3>,
}

impl FlyCamera {
    /// Starts at a camera of the scene; it is held upright from the first turn on.
    pub fn new(camera: &Camera) -> Self {
        let [yaw_rad, pitch_rad] = angles_rad(camera);
        Self { camera: camera.clone(), yaw_rad, pitch_rad, flown: false, pivot_ws: None }
    }

    /// The same; a camera outside the scene turns about it.
    pub fn for_scene(camera: &Camera, bounds: &Aabb) -> Self {
        let mut new = Self::new(camera);
        let at = camera.position_ws;
        if at.cmplt(bounds.min).any() || at.cmpgt(bounds.max).any() {
            new.orbit(Some(bounds));
        }
        new
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
            set_back: 0.0,
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
        let distance = self.distance();
        self.camera = turned(&self.camera, self.yaw_rad, self.pitch_rad);
        if let Some(pivot_ws) = self.pivot_ws {
            self.camera.position_ws = pivot_ws - distance * self.camera.forward_ws;
        }
        self.flown = true;
    }

    /// Turns about the middle of a scene from now on, as far as that is straight ahead, or flies.
    pub fn orbit(&mut self, bounds: Option<&Aabb>) {
        let Camera { position_ws, forward_ws, .. } = self.camera;
        self.pivot_ws = bounds.map(|bounds| {
            let ahead = (bounds.center() - position_ws).dot(forward_ws);
            position_ws + ahead.max(0.1 * bounds.radius()) * forward_ws
        });
    }

    /// Whether it turns about something.
    pub fn orbits(&self) -> bool {
        self.pivot_ws.is_some()
    }

    fn distance(&self) -> f32 {
        self.pivot_ws.map_or(0.0, |pivot_ws| pivot_ws.distance(self.camera.position_ws))
    }

    /// Comes nearer to what it turns about, by notches of the wheel.
    pub fn zoom(&mut self, notches: f32) {
        if let Some(pivot_ws) = self.pivot_ws {
            let distance = (self.distance() * ZOOM_STEP.powf(-notches)).max(2.0 * self.camera.near);
            self.camera.position_ws = pivot_ws - distance * self.camera.forward_ws;
            self.flown = true;
        }
    }

    /// Moves back or ahead until a scene fills the picture, of this width over height, and turns about it.
    pub fn frame(&mut self, bounds: &Aabb, aspect: f32) {
        let half_y = (0.5 * self.camera.yfov_rad).tan();
        let narrowest_rad = half_y.min(half_y * aspect).atan();
        let distance = bounds.radius() / narrowest_rad.sin();
        self.pivot_ws = Some(bounds.center());
        self.camera = turned(&self.camera, self.yaw_rad, self.pitch_rad);
        self.camera.position_ws = bounds.center() - distance * self.camera.forward_ws;
        self.flown = true;
    }

    /// Moves by metres to the right, up and ahead, as the camera is turned.
    pub fn fly(&mut self, right_up_ahead: Vec3) {
        let Camera { right_ws, up_ws, forward_ws, .. } = &self.camera;
        (self.flown, self.pivot_ws) = (true, None);
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
            set_back: 0.0,
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

    fn room() -> Aabb {
        Aabb { min: Vec3::new(-1.0, -1.0, -12.0), max: Vec3::new(1.0, 1.0, -8.0) }
    }

    #[test]
    fn a_camera_outside_turns_about_the_scene() {
        let mut fly = FlyCamera::for_scene(camera().camera(), &room());
        assert!(fly.orbits());
        fly.look(500.0, 100.0);
        let Camera { position_ws, forward_ws, .. } = *fly.camera();
        assert!((position_ws + 10.0 * forward_ws).distance(room().center()) < 1e-4, "it looks at the middle");
        fly.zoom(1.0);
        assert!(fly.camera().position_ws.distance(room().center()) < 9.0);
        fly.fly(Vec3::X);
        assert!(!fly.orbits());
        let inside = Camera { position_ws: room().center(), ..camera().camera().clone() };
        assert!(!FlyCamera::for_scene(&inside, &room()).orbits());
    }

    #[test]
    fn a_scene_that_is_framed_fills_the_picture() {
        let mut fly = camera();
        fly.look(400.0, 50.0);
        for aspect in [16.0 / 9.0, 0.5] {
            fly.frame(&room(), aspect);
            let Camera { position_ws, forward_ws, yfov_rad, .. } = *fly.camera();
            let distance = room().center().distance(position_ws);
            assert!((position_ws + distance * forward_ws).distance(room().center()) < 1e-4);
            let half = (room().radius() / distance).asin().tan() / (0.5 * yfov_rad).tan();
            assert!((half - aspect.min(1.0)).abs() < 1e-3, "{half} of the picture's half height");
        }
    }

    #[test]
    fn it_flies_where_it_looks() {
        let mut fly = camera();
        fly.fly(Vec3::new(1.0, 2.0, 3.0));
        assert!(fly.camera().position_ws.distance(Vec3::new(1.0, 2.0, -3.0)) < 1e-5);
    }
}
