//! Keys: which are held, and what pressing one does.

use std::collections::HashSet;

use glam::Vec3;
use winit::keyboard::KeyCode;

use super::action::Action;

/// Change of the flying speed for a notch of the wheel.
const SPEED_STEP: f32 = 1.2;
/// Factor of Shift, and of Ctrl the other way.
const FAST: f32 = 4.0;
/// Degrees that the sun turns in a second.
const SUN_DEG_PER_S: f32 = 30.0;

/// Stops of exposure that a key gives or takes.
const EXPOSURE_STEP_STOPS: f32 = 0.25;

/// Keys by the names that scripts have for them.
pub const NAMES: [(&str, KeyCode); 33] = [
    ("w", KeyCode::KeyW),
    ("a", KeyCode::KeyA),
    ("s", KeyCode::KeyS),
    ("d", KeyCode::KeyD),
    ("q", KeyCode::KeyQ),
    ("e", KeyCode::KeyE),
    ("c", KeyCode::KeyC),
    ("x", KeyCode::KeyX),
    ("i", KeyCode::KeyI),
    ("shift", KeyCode::ShiftLeft),
    ("ctrl", KeyCode::ControlLeft),
    ("left", KeyCode::ArrowLeft),
    ("right", KeyCode::ArrowRight),
    ("up", KeyCode::ArrowUp),
    ("down", KeyCode::ArrowDown),
    ("pageup", KeyCode::PageUp),
    ("pagedown", KeyCode::PageDown),
    ("space", KeyCode::Space),
    (".", KeyCode::Period),
    ("tab", KeyCode::Tab),
    ("escape", KeyCode::Escape),
    ("f5", KeyCode::F5),
    ("f6", KeyCode::F6),
    ("f11", KeyCode::F11),
    ("1", KeyCode::Digit1),
    ("2", KeyCode::Digit2),
    ("3", KeyCode::Digit3),
    ("4", KeyCode::Digit4),
    ("5", KeyCode::Digit5),
    ("6", KeyCode::Digit6),
    ("7", KeyCode::Digit7),
    ("8", KeyCode::Digit8),
    ("9", KeyCode::Digit9),
];

/// What a key does at once when it is pressed; keys that act while they are held do nothing here.
pub fn action_of(key: KeyCode) -> Option<Action> {
    let camera = NAMES.iter().find(|(_, code)| *code == key).and_then(|(name, _)| name.parse::<usize>().ok());
    match key {
        KeyCode::Space => Some(Action::Pause),
        KeyCode::Period => Some(Action::Step),
        KeyCode::Tab => Some(Action::Panel),
        KeyCode::KeyC => Some(Action::Split),
        KeyCode::KeyX => Some(Action::Swap),
        KeyCode::KeyI => Some(Action::Inspect),
        KeyCode::PageUp => Some(Action::Expose(EXPOSURE_STEP_STOPS)),
        KeyCode::PageDown => Some(Action::Expose(-EXPOSURE_STEP_STOPS)),
        KeyCode::F5 => Some(Action::Reload),
        KeyCode::F6 => Some(Action::Screenshot(None)),
        KeyCode::F11 => Some(Action::Fullscreen),
        KeyCode::Escape => Some(Action::Quit),
        _ => camera.map(|number| Action::Camera(number - 1)),
    }
}

/// The keys that are held, and how fast they move the camera.
pub struct Keys {
    held: HashSet<KeyCode>,
    /// Metres in a second.
    pub speed: f32,
}

impl Keys {
    /// No key held.
    pub fn new() -> Self {
        Self { held: HashSet::new(), speed: 1.0 }
    }

    /// A key goes down or up.
    pub fn set(&mut self, key: KeyCode, down: bool) {
        if down {
            self.held.insert(key);
        } else {
            self.held.remove(&key);
        }
    }

    /// All keys go up, as when the window loses the keyboard.
    pub fn release_all(&mut self) {
        self.held.clear();
    }

    /// The wheel turns, away from the user is up.
    pub fn wheel(&mut self, notches: f32) {
        self.speed = (self.speed * SPEED_STEP.powf(notches)).clamp(1e-4, 1e5);
    }

    /// Flight in these seconds: right, up, ahead, in metres.
    pub fn flight(&self, seconds: f32) -> Vec3 {
        let fast = if self.any(&[KeyCode::ShiftLeft, KeyCode::ShiftRight]) { FAST } else { 1.0 };
        let slow = if self.any(&[KeyCode::ControlLeft, KeyCode::ControlRight]) { FAST } else { 1.0 };
        let axes = Vec3::new(
            self.axis(KeyCode::KeyD, KeyCode::KeyA),
            self.axis(KeyCode::KeyE, KeyCode::KeyQ),
            self.axis(KeyCode::KeyW, KeyCode::KeyS),
        );
        axes.normalize_or_zero() * (self.speed * fast / slow * seconds)
    }

    /// Turn of the sun in these seconds: azimuth and elevation, in degrees.
    pub fn sun_deg(&self, seconds: f32) -> [f32; 2] {
        let turn = SUN_DEG_PER_S * seconds;
        [
            turn * self.axis(KeyCode::ArrowRight, KeyCode::ArrowLeft),
            turn * self.axis(KeyCode::ArrowUp, KeyCode::ArrowDown),
        ]
    }

    fn any(&self, keys: &[KeyCode]) -> bool {
        keys.iter().any(|key| self.held.contains(key))
    }

    fn axis(&self, plus: KeyCode, minus: KeyCode) -> f32 {
        f32::from(u8::from(self.held.contains(&plus))) - f32::from(u8::from(self.held.contains(&minus)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_fly_as_long_as_they_are_held() {
        let mut keys = Keys::new();
        keys.set(KeyCode::KeyW, true);
        assert_eq!(keys.flight(0.5), Vec3::new(0.0, 0.0, 0.5));
        keys.set(KeyCode::ShiftLeft, true);
        assert_eq!(keys.flight(0.5).z, 2.0);
        keys.release_all();
        assert_eq!(keys.flight(0.5), Vec3::ZERO);
    }

    #[test]
    fn digits_are_cameras() {
        assert_eq!(action_of(KeyCode::Digit1), Some(Action::Camera(0)));
        assert_eq!(action_of(KeyCode::Digit9), Some(Action::Camera(8)));
        assert_eq!(action_of(KeyCode::KeyW), None);
    }

    #[test]
    fn page_keys_expose() {
        assert_eq!(action_of(KeyCode::PageUp), Some(Action::Expose(0.25)));
        assert_eq!(action_of(KeyCode::PageDown), Some(Action::Expose(-0.25)));
    }
}
