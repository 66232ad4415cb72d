//! Keys: which are held, and what pressing one does.

use std::collections::HashSet;

use glam::Vec3;
use winit::keyboard::KeyCode;

use super::action::Action;

/// Change of the flying speed for a notch of the wheel.
const SPEED_STEP: f32 = 1.2;
/// Factor of Shift, and of Ctrl the other way.
const FAST: f32 = 4.0;
/// Slowest and fastest flight, of the speed that suits the scene.
const SPEED_BOUNDS: [f32; 2] = [1e-3, 1e2];
const SHIFT: [KeyCode; 2] = [KeyCode::ShiftLeft, KeyCode::ShiftRight];
const CTRL: [KeyCode; 2] = [KeyCode::ControlLeft, KeyCode::ControlRight];
/// Degrees that the sun turns in a second.
const SUN_DEG_PER_S: f32 = 30.0;

/// Stops of exposure that a key gives or takes.
const EXPOSURE_STEP_STOPS: f32 = 0.25;

/// What the keys do, for whoever asks.
pub const HELP: [(&str, &str); 20] = [
    ("W A S D, Q E", "fly forward, left, back, right; down, up"),
    ("mouse drag", "look around; in orbit mode, rotate around the scene"),
    ("Shift, Ctrl", "fly four times as fast, a quarter as fast"),
    ("wheel, R", "flying speed, reset it; in orbit mode, distance"),
    ("O", "switch between orbiting and flying"),
    ("F", "fit the whole scene into view"),
    ("1 to 9", "cameras of the scene"),
    ("arrow keys", "move the sun"),
    ("Page Up, Page Down", "exposure up, down by a quarter stop"),
    ("Space", "pause, resume"),
    (".", "advance by 1/30 second"),
    ("Tab", "panel"),
    ("C, X", "split view; swap its sides"),
    ("I", "inspect the pixel under the cursor"),
    ("F5", "recompile changed shaders"),
    ("F6", "save the picture at full quality, as EXR and PNG, with the settings"),
    ("Shift+F6", "save what is shown"),
    ("F11", "full screen"),
    ("H, ?", "this help"),
    ("Esc, Ctrl+Q", "quit; Esc asks first if something would be lost"),
];

/// Keys by the names that scripts have for them.
pub const NAMES: [(&str, KeyCode); 37] = [
    ("w", KeyCode::KeyW),
    ("a", KeyCode::KeyA),
    ("s", KeyCode::KeyS),
    ("d", KeyCode::KeyD),
    ("q", KeyCode::KeyQ),
    ("e", KeyCode::KeyE),
    ("c", KeyCode::KeyC),
    ("x", KeyCode::KeyX),
    ("i", KeyCode::KeyI),
    ("f", KeyCode::KeyF),
    ("h", KeyCode::KeyH),
    ("o", KeyCode::KeyO),
    ("r", KeyCode::KeyR),
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

/// What a key does at once when it is pressed alone; keys that act while they are held do nothing here.
fn action_of(key: KeyCode) -> Option<Action> {
    let camera = NAMES.iter().find(|(_, code)| *code == key).and_then(|(name, _)| name.parse::<usize>().ok());
    match key {
        KeyCode::Space => Some(Action::Pause),
        KeyCode::Period => Some(Action::Step),
        KeyCode::Tab => Some(Action::Panel),
        KeyCode::KeyC => Some(Action::Split),
        KeyCode::KeyX => Some(Action::Swap),
        KeyCode::KeyI => Some(Action::Inspect),
        KeyCode::KeyF => Some(Action::FrameScene),
        KeyCode::KeyO => Some(Action::Orbit),
        KeyCode::KeyR => Some(Action::ResetSpeed),
        KeyCode::KeyH | KeyCode::Slash => Some(Action::Help),
        KeyCode::PageUp => Some(Action::Expose(EXPOSURE_STEP_STOPS)),
        KeyCode::PageDown => Some(Action::Expose(-EXPOSURE_STEP_STOPS)),
        KeyCode::F5 => Some(Action::Reload),
        KeyCode::F6 => Some(Action::Render(None)),
        KeyCode::F11 => Some(Action::Fullscreen),
        KeyCode::Escape => Some(Action::Leave),
        _ => camera.map(|number| Action::Camera(number - 1)),
    }
}

/// The keys that are held, and how fast they move the camera.
pub struct Keys {
    held: HashSet<KeyCode>,
    /// Metres in a second.
    speed: f32,
    /// The speed that suits the scene.
    usual_speed: f32,
}

impl Keys {
    /// No key held.
    pub fn new() -> Self {
        Self { held: HashSet::new(), speed: 1.0, usual_speed: 1.0 }
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

    /// Another scene, which this speed suits.
    pub fn set_usual_speed(&mut self, speed: f32) {
        (self.speed, self.usual_speed) = (speed, speed);
    }

    /// The speed of flight is again the one that suits the scene; gives it.
    pub fn reset_speed(&mut self) -> f32 {
        self.speed = self.usual_speed;
        self.speed
    }

    /// The wheel turns, away from the user is up; gives the speed of flight.
    pub fn wheel(&mut self, notches: f32) -> f32 {
        let bounds = SPEED_BOUNDS.map(|bound| bound * self.usual_speed);
        self.speed = (self.speed * SPEED_STEP.powf(notches)).clamp(bounds[0], bounds[1]);
        self.speed
    }

    /// What a key does at once when it is pressed now, with those that are held.
    pub fn action(&self, key: KeyCode) -> Option<Action> {
        let (shift, ctrl) = (self.any(&SHIFT), self.any(&CTRL));
        match key {
            KeyCode::KeyQ if ctrl => Some(Action::Quit),
            KeyCode::F6 if shift => Some(Action::Screenshot(None)),
            _ => action_of(key),
        }
    }

    /// Flight in these seconds: right, up, ahead, in metres.
    pub fn flight(&self, seconds: f32) -> Vec3 {
        let fast = if self.any(&SHIFT) { FAST } else { 1.0 };
        let slow = if self.any(&CTRL) { FAST } else { 1.0 };
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

    /// Whether anything moves by a key.
    pub fn are_moving(&self) -> bool {
        self.flight(1.0) != Vec3::ZERO || self.sun_deg(1.0) != [0.0; 2]
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
    fn the_speed_has_bounds_and_a_reset() {
        let mut keys = Keys::new();
        keys.set_usual_speed(2.0);
        assert!(keys.wheel(1.0) > 2.0);
        assert_eq!((keys.wheel(1e3), keys.wheel(-1e3), keys.reset_speed()), (200.0, 2e-3, 2.0));
    }

    #[test]
    fn held_keys_change_what_others_do() {
        let mut keys = Keys::new();
        assert_eq!(keys.action(KeyCode::F6), Some(Action::Render(None)));
        assert_eq!(keys.action(KeyCode::KeyQ), None);
        keys.set(KeyCode::ShiftRight, true);
        keys.set(KeyCode::ControlLeft, true);
        assert_eq!(keys.action(KeyCode::F6), Some(Action::Screenshot(None)));
        assert_eq!(keys.action(KeyCode::KeyQ), Some(Action::Quit));
    }

    #[test]
    fn page_keys_expose() {
        assert_eq!(action_of(KeyCode::PageUp), Some(Action::Expose(0.25)));
        assert_eq!(action_of(KeyCode::PageDown), Some(Action::Expose(-0.25)));
    }
}
