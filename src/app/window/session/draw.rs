//! From what the window holds to one frame of it.

use std::time::{Duration, Instant};

use super::split::Inspector;
use super::{Pace, Session};
use crate::Result;
use crate::app::window::action::Action;
use crate::app::window::app::IDLE;
use crate::app::window::loader::Loading;
use crate::app::window::panel::facts::{Facts, SideFacts};
use crate::app::window::presenter::{DoneFrame, Outcome, Request};
use crate::app::window::scale::{fixed_scale, picture_size};
use crate::gpu::PanelPicture;
use crate::renderer::{FrameFeedback, Renderer};
use crate::settings::Settings;

/// Time between two titles.
const TITLE_EVERY: Duration = Duration::from_millis(500);

impl Session {
    /// The settings with the camera where it is now.
    pub(super) fn present_settings(&self) -> Settings {
        let camera = self.camera.setting().or_else(|| self.settings.scene.camera.clone());
        let sun = self.suns.setting();
        self.settings.clone().changed(|s| {
            s.scene.camera = camera;
            s.scene.sun = sun;
        })
    }

    /// The settings with the picture's size in place of the window's.
    pub(super) fn picture_settings(&self) -> Settings {
        self.sized(self.present_settings())
    }

    /// Settings with the size that the picture has in the window.
    pub(super) fn sized(&self, settings: Settings) -> Settings {
        let scale = fixed_scale(settings.window.render_scale, self.presenter.gpu().report().is_cpu())
            .unwrap_or_else(|| self.scale.scale());
        let size = picture_size(self.window_px(), scale, settings.lgh.interleave);
        settings.changed(|s| s.picture.size = size)
    }

    /// Runs the panel, adapts the frame to what it says, and shows it.
    pub(super) fn draw(&mut self) -> Result<Pace> {
        let (picture, actions) = self.run_panel();
        self.dirty = false;
        for action in actions {
            self.act(action)?;
        }
        if let (Inspector::Cursor(_), Some(at)) = (self.inspector, self.panel.cursor()) {
            self.inspector = Inspector::Cursor(at);
        }
        if !self.adapt()? {
            return Ok(Pace::AtOnce);
        }
        let settings = self.picture_settings();
        let held = self.held_settings();
        if self.changes_picture() {
            self.accumulated = 0;
        }
        self.shown_settings = self.settings.clone();
        let lights = self.suns.changed_lights();
        let window_px = self.window_px();
        let request = Request {
            settings: &settings,
            held: held.as_ref().zip(self.split.as_ref().map(|split| split.divider)),
            camera: self.camera.camera(),
            lights,
            number: self.accumulated,
            inspected: self.inspector.point(),
            panel: &picture,
        };
        if let Some(capture) = &mut self.capture {
            capture.begin(self.shown_count);
        }
        let outcome = self.presenter.frame(window_px, &request);
        let was_shown = matches!(outcome, Ok(Outcome::Shown));
        let captured = self.capture.as_mut().map_or(Ok(None), |capture| capture.end(was_shown));
        let outcome = outcome?;
        if let Some(Some(path)) = self.recover(captured)? {
            self.panel.say(format!("RenderDoc captured {}", path.display()));
        }
        self.shown_camera = Some(self.camera.camera().clone());
        if outcome == Outcome::Skipped {
            self.dirty = true;
            return Ok(Pace::In(IDLE));
        }
        self.suns.mark_shown();
        self.shown_count += 1;
        self.accumulated = self.accumulated.saturating_add(1);
        self.take_screenshots()?;
        Ok(Pace::AtOnce)
    }

    /// Compiles what has another shape with the settings; false when that failed and settings went back.
    fn adapt(&mut self) -> Result<bool> {
        let start = Instant::now();
        let held_anew = self.adapt_held()?;
        let adapted = self.presenter.adapt(self.camera.camera(), &self.picture_settings(), self.inspector.is_on());
        match self.recover(adapted)? {
            Some(anew) => {
                if anew || held_anew {
                    log::debug!("compiled anew in {:.0} ms", start.elapsed().as_secs_f64() * 1e3);
                    self.history.forget();
                    self.accumulated = 0;
                }
                Ok(true)
            }
            None => {
                // The frame before stays, and so do its settings.
                self.settings = self.shown_settings.clone();
                Ok(false)
            }
        }
    }

    /// Whether a mean of frames must begin anew.
    fn changes_picture(&self) -> bool {
        self.settings != self.shown_settings
            || self.shown_camera.as_ref() != Some(self.camera.camera())
            || self.suns.are_changed()
    }

    /// Takes note of the frames that have completed.
    pub(super) fn take_done(&mut self) {
        for DoneFrame { main, held } in self.presenter.take_done() {
            let mut ms = main.result.gpu_ms();
            ms += self.split.as_mut().zip(held).map_or(0.0, |(split, held)| split.take(held));
            self.history.add(main.result);
            self.take_feedback(main.feedback);
            if self.chooses_scale() && self.goal() == 1 && self.scale.observe(ms) {
                let size = self.picture_settings().picture.size;
                log::warn!("frames take {ms:.0} ms: the picture now has {size} pixels");
            }
        }
    }

    /// Takes note of what a frame told; a window at rest shows it once more where it is of something else.
    fn take_feedback(&mut self, feedback: Option<FrameFeedback>) {
        let subject = |feedback: &Option<FrameFeedback>| {
            feedback.as_ref().map(|feedback| feedback.inspected.map(|pixel| pixel.pixel))
        };
        self.dirty |= subject(&feedback) != subject(&self.feedback);
        self.feedback = feedback;
    }

    fn run_panel(&mut self) -> (PanelPicture, Vec<Action>) {
        let (picture, window_px, scale_is_chosen) =
            (self.picture_settings().picture.size, self.window_px(), self.chooses_scale());
        let settings = self.present_settings();
        let renderer = self.presenter.renderer();
        let facts = Facts {
            settings: &settings,
            picture,
            window_px,
            history: &self.history,
            pass_names: renderer.map(Renderer::pass_names).unwrap_or_default(),
            memory: renderer.map(|r| r.executor().memory()).unwrap_or_default(),
            reserved_bytes: self.presenter.gpu().reserved_bytes(),
            device: &self.presenter.gpu().report().name,
            cameras: self.presenter.scene().map_or_else(Vec::new, |s| s.cameras.iter().map(|c| &*c.name).collect()),
            loading: self.loading.as_ref().map(Loading::progress),
            accumulated: self.accumulated,
            paused: self.clock.paused,
            sun_deg: self.suns.angles_deg(),
            sun_speed: self.sun_speed,
            scale_is_chosen,
            main: SideFacts { shapes: renderer.map(Renderer::shapes), feedback: self.feedback.as_ref() },
            held: self.split.as_ref().map(|split| split.facts(&self.presenter, &settings)),
            inspects: self.inspector.is_on(),
        };
        self.panel.run(&self.window, &facts)
    }

    /// Says in the title what is going on.
    pub(super) fn show_title(&mut self) {
        if self.titled.elapsed() < TITLE_EVERY {
            return;
        }
        self.titled = Instant::now();
        let mut title = String::from("gridlight");
        if let Some(scene) = self.presenter.scene() {
            let size = self.picture_settings().picture.size;
            title += &format!(" - {} - {size} pixels - {:.1} frames/s", scene.name, self.history.frames_per_second());
        }
        if self.goal() > 1 {
            title += &format!(" - {} of {} frames", self.accumulated, self.goal());
        }
        if self.clock.paused {
            title += " - paused";
        }
        if let Some(loading) = &self.loading {
            title += &format!(" - {}", loading.progress());
        }
        self.window.set_title(&title);
    }
}
