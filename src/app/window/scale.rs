//! How cheap pictures must be while something moves: first fewer lights and samples, then a smaller picture.

use super::quality::{Rung, smallest_scale};

/// Cheaper and cheaper ways.
const LADDER: [Rung; 8] = [
    Rung { scale: 1.0, is_cheap: false },
    Rung { scale: 1.0, is_cheap: true },
    Rung { scale: 0.75, is_cheap: true },
    Rung { scale: 0.5, is_cheap: true },
    Rung { scale: 0.375, is_cheap: true },
    Rung { scale: 0.25, is_cheap: true },
    Rung { scale: 0.1875, is_cheap: true },
    Rung { scale: 0.125, is_cheap: true },
];
/// A frame of 10 per second.
const AIM_MS: f64 = 100.0;
/// Slower or faster than this, in `AIM_MS`, the rung changes.
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

/// Chooses the rung of the next frames.
pub struct ScaleControl {
    rung: usize,
    /// The cheapest one: with others the picture would be too small.
    cheapest: usize,
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
    /// Starts with the best pictures, or with the cheapest ones on a device that is known to be slow.
    pub fn new(window_px: [u32; 2], is_slow: bool) -> Self {
        let cheapest = cheapest(window_px);
        let rung = if is_slow { cheapest } else { 0 };
        Self { rung, cheapest, observed: Vec::new(), warming: WARM_UP, before: None, lowest: cheapest, highest: 0 }
    }

    /// Other settings, another scene, another size of the window: what was learnt counts no longer.
    pub fn forget(&mut self, window_px: [u32; 2]) {
        let cheapest = cheapest(window_px);
        // Where the cheapest was in use it stays so, although it is another one.
        let rung = if self.rung == self.cheapest { cheapest } else { self.rung.min(cheapest) };
        *self = Self { rung, ..Self::new(window_px, false) };
    }

    /// The rung in use.
    pub fn rung(&self, window_px: [u32; 2]) -> Rung {
        let rung = LADDER[self.rung];
        Rung { scale: rung.scale.max(smallest_scale(window_px)), ..rung }
    }

    /// Takes note of a frame; true when the rung has changed.
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
        if !LADDER[self.rung].is_cheap {
            return self.rung + 1;
        }
        let wanted = f64::from(LADDER[self.rung].scale) * (AIM_MS / ms).sqrt();
        let rung = LADDER.iter().position(|rung| f64::from(rung.scale) <= wanted).unwrap_or(LADDER.len() - 1);
        rung.min(self.rung + LONGEST_STEP)
    }

    fn step(&mut self, rung: usize) -> bool {
        self.observed.clear();
        self.warming = WARM_UP;
        std::mem::replace(&mut self.rung, rung) != rung
    }
}

/// The last rung with which the picture in a window is not too small.
fn cheapest(window_px: [u32; 2]) -> usize {
    let smallest = smallest_scale(window_px);
    LADDER.iter().position(|rung| rung.scale <= smallest).unwrap_or(LADDER.len() - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WINDOW: [u32; 2] = [1280, 720];
    /// The rung of half the window's size.
    const HALF: usize = 3;

    fn control(rung: usize) -> ScaleControl {
        ScaleControl { rung, ..ScaleControl::new(WINDOW, false) }
    }

    /// Frames until the rung changes, at most `most`.
    fn frames_to_change(control: &mut ScaleControl, ms: f64, most: u32) -> Option<u32> {
        (1..=most).find(|_| control.observe(ms))
    }

    #[test]
    fn slow_frames_become_cheaper_and_fast_ones_better() {
        let mut slow = control(HALF);
        assert_eq!(frames_to_change(&mut slow, 170.0, 99), Some(WARM_UP + OBSERVED as u32));
        assert_eq!(slow.rung(WINDOW).scale, 0.375);
        assert_eq!(frames_to_change(&mut slow, 90.0, 99), None);
        let mut fast = control(HALF);
        assert!(frames_to_change(&mut fast, 10.0, 20).is_some());
        assert_eq!(fast.rung(WINDOW).scale, 0.75);
    }

    #[test]
    fn lights_and_samples_go_first() {
        let mut control = ScaleControl::new(WINDOW, false);
        assert_eq!(control.rung(WINDOW), Rung { scale: 1.0, is_cheap: false });
        assert!(frames_to_change(&mut control, 900.0, 20).is_some());
        assert_eq!(control.rung(WINDOW), Rung { scale: 1.0, is_cheap: true });
    }

    #[test]
    fn much_too_slow_frames_take_two_rungs_and_pictures_are_never_too_small() {
        let mut much_too_slow = control(HALF);
        assert!(frames_to_change(&mut much_too_slow, 900.0, 20).is_some());
        assert_eq!(much_too_slow.rung(WINDOW).scale, 0.25);
        let mut control = control(HALF);
        // Always too slow, although fewer pixels help.
        (0..200).for_each(|_| {
            let ms = 40_000.0 * f64::from(control.rung(WINDOW).scale.powi(2));
            control.observe(ms);
        });
        assert_eq!(control.rung(WINDOW).scale, 0.1875);
        assert_eq!(ScaleControl::new(WINDOW, true).rung(WINDOW).scale, 0.1875);
        assert_eq!(ScaleControl::new([300, 100], true).rung([300, 100]).scale, 1.0);
        assert_eq!(ScaleControl::new([1920, 1080], true).rung([1920, 1080]).scale, 0.125);
    }

    #[test]
    fn one_slow_frame_changes_nothing() {
        let mut control = control(HALF);
        let changes = (0..100).filter(|i| control.observe(if i % 5 == 0 { 900.0 } else { 90.0 })).count();
        assert_eq!(changes, 0);
    }

    #[test]
    fn it_stops_where_a_smaller_picture_does_not_help() {
        let mut control = control(HALF);
        let changes = (0..100).filter(|_| control.observe(500.0)).count();
        assert_eq!((changes, control.rung), (2, HALF), "once down, and back");
    }

    #[test]
    fn it_does_not_swing() {
        let mut control = control(HALF);
        let time = |scale: f32| 4000.0 * f64::from(scale * scale);
        let changes = (0..500)
            .filter(|_| {
                let ms = time(control.rung(WINDOW).scale);
                control.observe(ms)
            })
            .count();
        assert!(changes < 10, "{changes}");
    }
}
