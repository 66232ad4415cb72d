//! `--render-scale`: the size of the picture within the window, adapted to a slow device.

use crate::settings::{RenderScale, Size};

/// Scales that `auto` takes.
const LADDER: [f32; 10] = [1.0, 0.75, 0.5, 0.375, 0.25, 0.1875, 0.125, 0.09, 0.065, 0.05];
/// A frame of 10 per second.
const AIM_MS: f64 = 100.0;
/// Slower or faster than this, in `AIM_MS`, the scale changes.
const SLOW: f64 = 1.3;
const FAST: f64 = 0.4;
/// Frames in a row that must be slow or fast.
const SLOW_FRAMES: u32 = 3;
const FAST_FRAMES: u32 = 10;
/// Frames after a change that are not looked at: at least those under way.
const WARM_UP: u32 = 3;
/// A smaller picture that takes more than this of the time before does not help.
const NO_HELP: f64 = 0.85;
/// Pixels of the first picture.
const FIRST_PIXELS: f32 = 320.0 * 180.0;

/// Chooses the scale of the next frames.
pub struct ScaleControl {
    rung: usize,
    slow: u32,
    fast: u32,
    /// Frames that do not count: drivers compile shaders at their first use.
    warming: u32,
    /// Time before the last step down.
    before_ms: Option<f64>,
    /// Rungs below this do not help.
    lowest: usize,
    /// Rungs above this were too slow.
    highest: usize,
}

impl ScaleControl {
    /// Starts with a picture of moderate size.
    pub fn new(window_px: [u32; 2]) -> Self {
        let wanted = (FIRST_PIXELS / (window_px[0] as f32 * window_px[1] as f32).max(1.0)).sqrt();
        let rung = LADDER.iter().position(|scale| *scale <= wanted).unwrap_or(LADDER.len() - 1);
        Self { rung, slow: 0, fast: 0, warming: WARM_UP, before_ms: None, lowest: LADDER.len() - 1, highest: 0 }
    }

    /// Other settings, another scene: what was learnt counts no longer.
    pub fn forget(&mut self) {
        (self.slow, self.fast, self.warming, self.before_ms) = (0, 0, WARM_UP, None);
        (self.lowest, self.highest) = (LADDER.len() - 1, 0);
    }

    /// The scale in use.
    pub fn scale(&self) -> f32 {
        LADDER[self.rung]
    }

    /// Takes note of a frame; true when the scale has changed.
    pub fn observe(&mut self, frame_ms: f64) -> bool {
        if self.warming > 0 {
            self.warming -= 1;
            return false;
        }
        self.slow = if frame_ms > SLOW * AIM_MS { self.slow + 1 } else { 0 };
        self.fast = if frame_ms < FAST * AIM_MS { self.fast + 1 } else { 0 };
        if let Some(before) = self.before_ms.filter(|_| self.slow >= SLOW_FRAMES) {
            self.before_ms = None;
            if frame_ms > NO_HELP * before {
                // What takes the time is not the picture: as well be it a larger one.
                self.lowest = self.rung.saturating_sub(1);
                return self.step(self.lowest);
            }
        }
        if self.slow >= SLOW_FRAMES && self.rung < self.lowest {
            self.before_ms = Some(frame_ms);
            self.highest = self.rung + 1;
            return self.step(self.rung + 1);
        }
        if self.fast >= FAST_FRAMES && self.rung > self.highest {
            return self.step(self.rung - 1);
        }
        false
    }

    fn step(&mut self, rung: usize) -> bool {
        (self.slow, self.fast, self.warming) = (0, 0, WARM_UP);
        std::mem::replace(&mut self.rung, rung) != rung
    }
}

/// Size of the picture in a window: whole pixels, and at least as many as an interleaving pattern has.
pub fn picture_size(window_px: [u32; 2], scale: f32, interleave: u32) -> Size {
    let edge = |px: u32| ((px as f32 * scale).round() as u32).max(interleave.max(1));
    Size { width: edge(window_px[0]), height: edge(window_px[1]) }
}

/// The scale that the settings ask for, when it is not chosen by the frame's time.
pub fn fixed_scale(setting: RenderScale, is_cpu: bool) -> Option<f32> {
    match setting {
        RenderScale::Fixed(scale) => Some(scale),
        RenderScale::Auto if is_cpu => None,
        RenderScale::Auto => Some(1.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_frames_make_the_picture_smaller_and_fast_ones_larger() {
        let mut control = ScaleControl::new([1280, 720]);
        assert_eq!(control.scale(), 0.25);
        assert!(!(0..WARM_UP + 2).any(|_| control.observe(900.0)) && control.observe(900.0));
        assert_eq!(control.scale(), 0.1875);
        for _ in 0..99 {
            assert!(!control.observe(90.0));
        }
        let mut control = ScaleControl::new([1280, 720]);
        assert!((0..WARM_UP + FAST_FRAMES).any(|_| control.observe(10.0)));
        assert_eq!(control.scale(), 0.375);
    }

    #[test]
    fn it_stops_where_a_smaller_picture_does_not_help() {
        let mut control = ScaleControl::new([1280, 720]);
        let changes = (0..100).filter(|_| control.observe(500.0)).count();
        assert_eq!((changes, control.scale()), (2, 0.25), "once down, and back");
    }

    #[test]
    fn it_does_not_swing() {
        let mut control = ScaleControl::new([1280, 720]);
        let time = |scale: f32| 2000.0 * f64::from(scale);
        let changes = (0..500)
            .filter(|_| {
                let ms = time(control.scale());
                control.observe(ms)
            })
            .count();
        assert!(changes < 10, "{changes}");
    }

    #[test]
    fn tiny_windows_have_pixels() {
        assert_eq!(picture_size([1, 1], 0.05, 4), Size { width: 4, height: 4 });
        assert_eq!(picture_size([1280, 720], 0.25, 1), Size { width: 320, height: 180 });
        assert_eq!(fixed_scale(RenderScale::Auto, true), None);
    }
}
