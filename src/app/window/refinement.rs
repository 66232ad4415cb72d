//! What to render next: a picture of what has just changed, then better ones as long as nothing changes.

use std::time::{Duration, Instant};

use super::quality::{Plan, Quality};

/// Nothing has changed for so long: it is at rest.
const SETTLE: Duration = Duration::from_millis(150);
/// A first picture that takes longer than this is given up when what it shows has changed.
const PATIENCE: Duration = Duration::from_secs(2);

/// The frame to render next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// One of this quality, with its number among the frames of a mean.
    Frame(Quality, u32),
    /// None yet: something may still move.
    Wait,
    /// None: the best picture is there.
    Nothing,
}

/// How far the picture of what is to be seen has come.
#[derive(Clone, Copy, Debug)]
pub struct Refinement {
    changed: Instant,
    /// Best quality that a picture of it has.
    reached: Option<Quality>,
    /// Whole frames in the mean.
    accumulated: u32,
    /// A better picture cannot be had.
    is_given_up: bool,
}

impl Refinement {
    /// There is no picture yet.
    pub fn new(now: Instant) -> Self {
        Self { changed: now, reached: None, accumulated: 0, is_given_up: false }
    }

    /// Something else is to be seen.
    pub fn restart(&mut self, now: Instant) {
        *self = Self::new(now);
    }

    /// Whether a frame that was begun before what is to be seen has changed is of no use any more. A first picture is
    /// shown although it is late; `is_other` says that it would show the wrong thing and not only the wrong place.
    pub fn gives_up(plan: &Plan, running: Quality, runs_for: Duration, is_other: bool) -> bool {
        is_other || plan.steps().first() != Some(&running) || runs_for > PATIENCE
    }

    /// What comes next.
    pub fn next(&self, plan: &Plan, now: Instant) -> Next {
        if self.is_given_up {
            return Next::Nothing;
        }
        let steps = plan.steps();
        let Some(reached) = self.reached else { return Next::Frame(steps[0], 0) };
        match steps.iter().find(|step| **step > reached) {
            Some(_) if now.duration_since(self.changed) < SETTLE => Next::Wait,
            Some(better) => Next::Frame(*better, 0),
            None if self.accumulated < plan.goal() => Next::Frame(reached, self.accumulated),
            None => Next::Nothing,
        }
    }

    /// Takes note of a frame that is done; a reference may be stopped before it is whole.
    pub fn took(&mut self, quality: Quality, is_whole: bool) {
        self.reached = self.reached.max(Some(quality));
        if quality == Quality::Full && is_whole {
            self.accumulated += 1;
        }
    }

    /// There will be no better picture until something changes.
    pub fn give_up(&mut self) {
        self.is_given_up = true;
    }

    /// Time since something has changed.
    pub fn since_change(&self) -> Duration {
        self.changed.elapsed()
    }

    /// Whole frames in the mean.
    pub fn accumulated(&self) -> u32 {
        self.accumulated
    }

    /// Whether there is a picture of what is to be seen.
    pub fn has_picture(&self) -> bool {
        self.reached.is_some()
    }

    /// Whether the picture has all its pixels and the samples that are asked for.
    pub fn is_full(&self, plan: &Plan) -> bool {
        self.accumulated >= plan.frames_of_settings()
    }
}

#[cfg(test)]
mod tests {
    use super::super::quality::{Rung, Way};
    use super::*;

    fn plan(way: Way) -> Plan {
        Plan { window_px: [1280, 720], way, accumulate: 1, samples: 4, is_picture: true, is_reference: false }
    }

    /// The frames that follow a change, with their times in ms.
    fn frames(plan: &Plan, count: usize) -> Vec<(Quality, u32)> {
        let start = Instant::now();
        let mut refinement = Refinement::new(start);
        let mut now = start;
        let mut frames = Vec::new();
        while frames.len() < count {
            match refinement.next(plan, now) {
                Next::Frame(quality, number) => {
                    frames.push((quality, number));
                    refinement.took(quality, true);
                }
                Next::Wait => now += Duration::from_millis(10),
                Next::Nothing => break,
            }
        }
        frames
    }

    #[test]
    fn a_picture_gets_better_and_then_accumulates_to_its_limit() {
        let slow = plan(Way::Adapts(Rung { scale: 0.2, is_cheap: true }));
        let all = frames(&slow, 999);
        assert_eq!(all[..4], [(Quality::Moving, 0), (Quality::Half, 0), (Quality::Full, 0), (Quality::Full, 1)]);
        assert_eq!(all.len() as u32, 2 + slow.goal(), "no more than the limit");
        assert_eq!(frames(&plan(Way::AsAsked(1.0)), 999), [(Quality::Full, 0)]);
    }

    #[test]
    fn the_settings_are_there_with_their_samples() {
        let plan = plan(Way::Adapts(Rung { scale: 0.2, is_cheap: true }));
        let mut refinement = Refinement::new(Instant::now());
        (0..3).for_each(|_| refinement.took(Quality::Full, true));
        assert!(!refinement.is_full(&plan), "three samples of four");
        refinement.took(Quality::Full, true);
        assert!(refinement.is_full(&plan));
    }

    #[test]
    fn nothing_better_is_begun_while_something_moves() {
        let start = Instant::now();
        let slow = plan(Way::Adapts(Rung { scale: 0.2, is_cheap: true }));
        let mut refinement = Refinement::new(start);
        refinement.took(Quality::Moving, true);
        assert_eq!(refinement.next(&slow, start + SETTLE / 2), Next::Wait);
        assert_eq!(refinement.next(&slow, start + SETTLE), Next::Frame(Quality::Half, 0));
        refinement.restart(start + SETTLE);
        assert_eq!(refinement.next(&slow, start + SETTLE), Next::Frame(Quality::Moving, 0));
    }

    #[test]
    fn a_part_of_a_reference_is_shown_but_not_counted() {
        let start = Instant::now();
        let slow = Plan { is_reference: true, ..plan(Way::Adapts(Rung { scale: 0.2, is_cheap: true })) };
        let mut refinement = Refinement::new(start);
        refinement.took(Quality::Full, false);
        assert_eq!((refinement.accumulated(), refinement.is_full(&slow)), (0, false));
        assert_eq!(refinement.next(&slow, start + SETTLE), Next::Frame(Quality::Full, 0));
    }

    #[test]
    fn a_late_first_picture_is_shown_and_others_are_given_up() {
        let slow = plan(Way::Adapts(Rung { scale: 0.2, is_cheap: true }));
        let soon = Duration::from_millis(100);
        assert!(!Refinement::gives_up(&slow, Quality::Moving, soon, false));
        assert!(Refinement::gives_up(&slow, Quality::Moving, soon, true));
        assert!(Refinement::gives_up(&slow, Quality::Moving, 2 * PATIENCE, false));
        assert!(Refinement::gives_up(&slow, Quality::Full, soon, false));
        assert!(!Refinement::gives_up(&plan(Way::AsAsked(0.5)), Quality::Full, soon, false));
    }
}
