//! Which frame is rendered when: the one under way is looked at and never waited for, and given up once it is of no use.

use std::ops::ControlFlow;
use std::path::Path;
use std::time::{Duration, Instant};

use super::{Due, Session, Shot};
use crate::Result;
use crate::app::window::quality::{Plan, Quality, Way, fixed_scale};
use crate::app::window::refinement::{Next, Refinement};
use crate::app::window::screenshot;
use crate::app::window::stage::{Adapted, DoneFrame, Patience, Request, Stage, Wanted};
use crate::scene::Camera;
use crate::settings::{Settings, View};
use crate::techniques::{self, Technique};

/// About the longest piece of a frame: what the window shows comes after it.
const PIECE_MS: f64 = 20.0;
/// The same of a frame that is itself what the window shows next: between pieces the device waits.
const MOVING_PIECE_MS: f64 = 50.0;
/// Time until a reference shows what it has; later on more often than not it shows twice as much.
const FIRST_PART: Duration = Duration::from_secs(1);
/// Longest time between two parts.
const LONGEST_PART: Duration = Duration::from_secs(10);

/// What is to be seen: a picture of something else is of no use.
#[derive(Clone, PartialEq)]
pub(super) struct Target {
    settings: Settings,
    held: Option<Settings>,
    window_px: [u32; 2],
    /// Where it is seen from; of the settings this is not a part.
    camera: Camera,
    /// How often the sun and the other lights have changed.
    light_changes: u64,
    /// The moment of the scene's animation.
    moment_s: f64,
    inspected: Option<[f32; 2]>,
    inspects: bool,
}

impl Target {
    /// Whether more than place and point differ.
    fn is_other_than(&self, before: &Self) -> bool {
        (&self.settings, &self.held, self.window_px, self.inspects)
            != (&before.settings, &before.held, before.window_px, before.inspects)
    }
}

impl Session {
    /// What the window is to show, and how.
    pub(super) fn plan(&self) -> Plan {
        let window_px = self.window_px();
        let held = self.held_settings();
        let sides = || held.iter().chain([&self.settings]);
        let way = match fixed_scale(self.settings.window.render_scale) {
            Some(scale) => Way::AsAsked(scale),
            None => Way::Adapts(self.scale.rung(window_px)),
        };
        Plan {
            window_px,
            way,
            accumulate: sides().map(|side| side.render.accumulate).max().unwrap_or(1),
            samples: sides().map(|side| side.many_lights.shadow_samples).max().unwrap_or(1),
            is_picture: sides().any(|side| side.render.view == View::Final),
            is_reference: sides().any(|side| techniques::of(side).is_ok_and(Technique::is_reference)),
        }
    }

    /// Settings of the frame, or of the right side of a split view, for pictures of a quality.
    pub(super) fn settings_for(&self, quality: Quality) -> Settings {
        self.plan().settings(quality, &self.present_settings())
    }

    /// The same for the left side.
    pub(super) fn held_settings_for(&self, quality: Quality) -> Option<Settings> {
        self.held_settings().map(|held| self.plan().settings(quality, &held))
    }

    /// The quality of the first picture after a change.
    pub(super) fn first_quality(&self) -> Quality {
        self.plan().steps()[0]
    }

    /// Notes what is to be seen; a frame that has become of no use is given up.
    pub(super) fn watch(&mut self) -> Result<()> {
        let target = Target {
            // Where camera and sun stand is told by them.
            settings: self.settings.clone().changed(|s| (s.scene.camera, s.scene.sun) = (None, None)),
            held: self.held_settings().map(|held| held.changed(|s| (s.scene.camera, s.scene.sun) = (None, None))),
            window_px: self.window_px(),
            camera: self.camera.camera().clone(),
            light_changes: self.suns.changes(),
            moment_s: self.moment_s,
            inspected: self.inspector.point(),
            inspects: self.inspector.is_on(),
        };
        let is_other = self.target.as_ref().is_none_or(|before| target.is_other_than(before));
        if self.target.as_ref() == Some(&target) && !self.begins_anew {
            return Ok(());
        }
        let now = Instant::now();
        self.refinement.restart(now);
        let plan = self.plan();
        if let Some(stage) = &mut self.stage
            && let Some((quality, runs_for)) = stage.running()
            && (self.begins_anew || Refinement::gives_up(&plan, quality, runs_for, is_other))
        {
            log::debug!("a frame is given up after {:.0} ms", runs_for.as_secs_f64() * 1e3);
            stage.abandon()?;
            let captured = self.capture.as_mut().map_or(Ok(None), |capture| capture.end(false));
            self.recover(captured)?;
        }
        self.is_late = self.stage.as_ref().is_some_and(|stage| stage.running().is_some());
        // A frame that shows it is next; until it is there, only the panel may have to tell.
        (self.target, self.begins_anew, self.part) = (Some(target), false, None);
        self.dirty |= is_other;
        Ok(())
    }

    /// Looks at the frame under way; true when none is, be it that it has just completed.
    pub(super) fn advance(&mut self) -> Result<bool> {
        let flow = if self.shows_part_now() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        let Some(stage) = &mut self.stage else { return Ok(true) };
        let is_moving = stage.running().is_some_and(|(quality, _)| quality == Quality::Moving);
        let piece_ms = if is_moving { MOVING_PIECE_MS } else { PIECE_MS };
        let piece_ms = piece_ms.min(f64::from(self.settings.device.max_submit_ms));
        if let Some(done) = stage.advance(piece_ms, flow)? {
            self.take_done(done);
        }
        Ok(self.stage.as_ref().is_none_or(|stage| stage.running().is_none()))
    }

    /// Whether a reference has rendered for long enough to show what it has. Parts are of the first frame of a mean alone:
    /// after that there is a picture already.
    fn shows_part_now(&self) -> bool {
        let Some((_, runs_for)) = self.stage.as_ref().and_then(|stage| stage.running()) else { return false };
        let spent = self.refinement.since_change();
        self.refinement.accumulated() == 0 && runs_for > (spent / 2).clamp(FIRST_PART, LONGEST_PART)
    }

    /// Takes note of a frame that has completed.
    fn take_done(&mut self, done: DoneFrame) {
        let DoneFrame { quality, main, held, part } = done;
        if self.shown_quality != Some(quality) {
            self.history.forget();
            self.shown_quality = Some(quality);
        }
        if let (Some(split), Some(held)) = (&mut self.split, held) {
            split.take(held);
        }
        if let Some(main) = main {
            let ms = main.result.cpu_ms;
            self.history.add(main.result);
            self.feedback = main.feedback;
            if quality == Quality::Moving && self.scale.observe(ms) {
                let size = self.settings_for(quality).picture.size;
                log::info!("frames take {ms:.0} ms: while anything moves the picture now has {size} pixels");
            }
        }
        self.frames_done += 1;
        if self.is_scripted && self.plays() {
            self.moment_s += 1.0 / self.settings.motion.fps;
        }
        self.capture_ends = true;
        self.part = part;
        (self.dirty, self.has_new_picture) = (true, true);
        if self.is_late {
            // Something has changed since it was begun.
            (self.is_late, self.part) = (false, None);
        } else {
            self.refinement.took(quality, part.is_none());
        }
        log::debug!("frame {}: {quality:?}, {} accumulated", self.frames_done, self.refinement.accumulated());
    }

    /// Begins the frame that comes next, if there is one; true when a frame is under way then.
    pub(super) fn begin_next(&mut self) -> Result<bool> {
        self.waits_for_measures = false;
        let next = self.refinement.next(&self.plan(), Instant::now());
        let Next::Frame(quality, number) = next else { return Ok(false) };
        let settings = self.settings_for(quality);
        let held = self.held_settings_for(quality);
        let camera = self.camera.camera().clone();
        let wanted =
            Wanted { settings: &settings, held: held.as_ref(), camera: &camera, inspects: self.inspector.is_on() };
        let Some(stage) = &mut self.stage else { return Ok(false) };
        if stage.pose(self.moment_s, self.suns.setting(), &self.settings.environment)? {
            self.suns.carry(stage.scene(), stage.uploaded().other_lights());
        }
        let start = Instant::now();
        let adapted = stage.adapt(quality, &wanted, Patience::Returns);
        match self.recover(adapted)? {
            Some(Adapted::Later) => {
                self.waits_for_measures = true;
                return Ok(false);
            }
            Some(Adapted::Yes) => {
                log::debug!("{quality:?} compiled anew in {:.0} ms", start.elapsed().as_secs_f64() * 1e3);
                self.history.forget();
            }
            Some(Adapted::No) => {}
            None => {
                // The frames before stay, and so do their settings; a split view ends when they are the same.
                if self.settings == self.shown_settings {
                    self.split = None;
                }
                self.settings = self.shown_settings.clone();
                self.refinement.give_up();
                return Ok(false);
            }
        }
        self.shown_settings = self.settings.clone();
        let request = Request {
            wanted,
            lights: self.suns.changed_lights(),
            number,
            inspected: self.inspector.point(),
            goes_on: self.part.is_some() && quality == Quality::Full && number == 0,
        };
        if let Some(capture) = &mut self.capture {
            capture.begin(self.frames_done);
        }
        if let Some(stage) = &mut self.stage {
            stage.begin(quality, &request)?;
        }
        self.is_late = false;
        // Its first pass has the lights.
        self.advance()?;
        self.suns.mark_shown();
        Ok(true)
    }

    /// Takes the screenshots whose time has come; no frame is under way, and if it is settled none will begin.
    pub(super) fn take_screenshots(&mut self, is_settled: bool) -> Result<()> {
        let (has_picture, is_full) = (self.refinement.has_picture(), self.refinement.is_full(&self.plan()));
        // What moves never comes to rest, and is another scene once it is rendered.
        let plays = self.plays() && self.stage.as_ref().and_then(Stage::shown).is_some();
        let is_due = |shot: &Shot| match shot.due {
            _ if plays => is_settled,
            Due::Soon => has_picture,
            Due::Settled => is_settled && has_picture,
            Due::Complete => is_full,
        };
        let (due, later) = std::mem::take(&mut self.screenshots).into_iter().partition(is_due);
        self.screenshots = later;
        due.into_iter().try_for_each(|Shot { name, .. }| self.take_screenshot(name.as_deref()))
    }

    pub(super) fn take_screenshot(&mut self, name: Option<&Path>) -> Result<()> {
        let Some(quality) = self.stage.as_ref().and_then(Stage::shown_quality) else { return Ok(()) };
        let frames = self.refinement.accumulated().max(1);
        let noted = |settings: Settings| {
            settings.changed(|s| s.render.accumulate = if quality == Quality::Full { frames } else { 1 })
        };
        let settings = noted(self.settings_for(quality));
        let held = self.held_settings_for(quality).map(noted);
        let Some(set) = self.stage.as_ref().and_then(Stage::shown) else { return Ok(()) };
        let held = set.held.as_ref().map(|side| &side.renderer).zip(held);
        let saved = screenshot::save(&set.main.renderer, &settings, held, name);
        if let Some(what) = self.recover(saved)? {
            log::info!("saved {what}");
            self.panel.say(format!("saved {what}"));
            self.dirty = true;
        }
        Ok(())
    }
}
