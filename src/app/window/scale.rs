//! `--render-scale`: the size of the picture within the window, adapted to a slow device.

use crate::settings::{RenderScale, Size};

/// Scales that `auto` takes.
const LADDER: [f32; 10] = [1.0, 0.75, 0.5, 0.375, 0.25, 0.1875, 0.125, 0.09, 0.065, 0.05];
/// A frame of 10 per second.
const AIM_MS: f64 = 100.0;
/// Slower or faster than this, in `AIM_MS`, the scale changes.
const SLOW: f64 = 1.3;
const FAST: f64 = 0.5;
/// Frames whose median decides.
const OBSERVED: usize = 5;
/// Frames after a change that are not looked at: those under way, and one in which drivers compile shaders.
const WARM_UP: u32 = 4;
/// Rungs that the scale changes by at once, at most.
const LONGEST_STEP: usize = 2;
/// A smaller picture that takes more than this of the time before does not help.
const NO_HELP: f64 = 0.85;
/// Pixels of the first picture.
const FIRST_PIXELS: f32 = 320.0 * 180.0;

/// Chooses the scale of the next frames.
pub struct ScaleControl {
    rung: usize,
    /// Frames observed since the last decision.
    observed: Vec<f64>,
    /// Frames that do not count.
    warming: u32,
    /// Rung and time before the last step down.
    before: Option<(usize, f64)>,
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
        Self { rung, observed: Vec::new(), warming: WARM_UP, before: None, lowest: LADDER.len() - 1, highest: 0 }
    }

    /// Other settings, another scene: what was learnt counts no longer.
    pub fn forget(&mut self) {
        *self = Self { rung: self.rung, ..Self::new([1, 1]) };
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
        self.observed.push(frame_ms);
        if self.observed.len() < OBSERVED {
            return false;
        }
        self.observed.sort_by(f64::total_cmp);
        let median_ms = self.observed[OBSERVED / 2];
        self.observed.clear();
        let slow = median_ms > SLOW * AIM_MS;
        if let Some((rung, before_ms)) = self.before.take()
            && slow
            && median_ms > NO_HELP * before_ms
        {
            // What takes the time is not the picture: as well be it the larger one.
            self.lowest = rung;
            return self.step(rung);
        }
        if slow && self.rung < self.lowest {
            self.before = Some((self.rung, median_ms));
            self.highest = self.rung + 1;
            return self.step(self.rung_for(median_ms).clamp(self.rung + 1, self.lowest));
        }
        if median_ms < FAST * AIM_MS && self.rung > self.highest {
            return self.step(self.rung - 1);
        }
        false
    }

    /// The largest picture that would be fast enough if time went with pixels; not too far from the one in use.
    fn rung_for(&self, ms: f64) -> usize {
        let wanted = f64::from(self.scale()) * (AIM_MS / ms).sqrt();
        let rung = LADDER.iter().position(|scale| f64::from(*scale) <= wanted).unwrap_or(LADDER.len() - 1);
        rung.min(self.rung + LONGEST_STEP)
    }

    fn step(&mut self, rung: usize) -> bool {
        self.observed.clear();
        self.warming = WARM_UP;
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

    /// Frames until the scale changes, at most `most`.
    fn frames_to_change(control: &mut ScaleControl, ms: f64, most: u32) -> Option<u32> {
        (1..=most).find(|_| control.observe(ms))
    }

    #[test]
    fn slow_frames_make_the_picture_smaller_and_fast_ones_larger() {
        let mut control = ScaleControl::new([1280, 720]);
        assert_eq!(control.scale(), 0.25);
        assert_eq!(frames_to_change(&mut control, 170.0, 99), Some(WARM_UP + OBSERVED as u32));
        assert_eq!(control.scale(), 0.1875);
        assert_eq!(frames_to_change(&mut control, 90.0, 99), None);
        let mut control = ScaleControl::new([1280, 720]);
        assert!(frames_to_change(&mut control, 10.0, 20).is_some());
        assert_eq!(control.scale(), 0.375);
    }

    #[test]
    fn much_too_slow_frames_take_two_rungs() {
        let mut control = ScaleControl::new([1280, 720]);
        assert!(frames_to_change(&mut control, 900.0, 20).is_some());
        assert_eq!(control.scale(), 0.125);
    }

    #[test]
    fn one_slow_frame_changes_nothing() {
        let mut control = ScaleControl::new([1280, 720]);
        let changes = (0..100).filter(|i| control.observe(if i % 5 == 0 { 900.0 } else { 90.0 })).count();
        assert_eq!(changes, 0);
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
        let time = |scale: f32| 4000.0 * f64::from(scale * scale);
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
