//! From what the window holds to one frame of it.

use std::time::{Duration, Instant};

use super::{Pace, Session};
use crate::Result;
use crate::app::window::action::Action;
use crate::app::window::app::IDLE;
use crate::app::window::loader::Loading;
use crate::app::window::panel::facts::{Counts, Facts};
use crate::app::window::scale::{fixed_scale, picture_size};
use crate::app::window::stage::{Outcome, Request};
use crate::app::window::sun::Sun;
use crate::gpu::PanelPicture;
use crate::renderer::Renderer;
use crate::settings::Settings;

/// Time between two titles.
const TITLE_EVERY: Duration = Duration::from_millis(500);

impl Session {
    /// The settings with the camera where it is now.
    pub(super) fn present_settings(&self) -> Settings {
        let camera = self.camera.setting().or_else(|| self.settings.camera.clone());
        Settings { camera, ..self.settings.clone() }
    }

    /// The settings with the picture's size in place of the window's.
    pub(super) fn picture_settings(&self) -> Settings {
        let scale = fixed_scale(self.settings.render_scale, self.stage.gpu().report().is_cpu())
            .unwrap_or_else(|| self.scale.scale());
        let size = picture_size(self.window_px(), scale, self.settings.interleave);
        Settings { size, ..self.present_settings() }
    }

    /// Runs the panel, adapts the frame to what it says, and shows it.
    pub(super) fn draw(&mut self) -> Result<Pace> {
        let (picture, actions) = self.run_panel();
        self.dirty = false;
        for action in actions {
            self.act(action)?;
        }
        let settings = self.picture_settings();
        let adapted = self.stage.adapt(self.camera.camera(), &settings);
        match self.soften(adapted)? {
            Some(true) => {
                self.history.forget();
                self.accumulated = 0;
            }
            Some(false) => {}
            None => {
                // The frame before stays, and so do its settings.
                self.settings = self.shown_settings.clone();
                return Ok(Pace::AtOnce);
            }
        }
        if self.changes_picture() {
            self.accumulated = 0;
        }
        self.shown_settings = self.settings.clone();
        let lights = self.sun.as_ref().and_then(Sun::changed_lights);
        let window_px = self.window_px();
        let request = Request {
            settings: &settings,
            camera: self.camera.camera(),
            lights,
            number: self.accumulated,
            panel: &picture,
        };
        let outcome = self.stage.frame(window_px, &request)?;
        self.shown_camera = Some(self.camera.camera().clone());
        if outcome == Outcome::Skipped {
            self.dirty = true;
            return Ok(Pace::In(IDLE));
        }
        if let Some(sun) = &mut self.sun {
            sun.mark_shown();
        }
        self.accumulated = self.accumulated.saturating_add(1);
        Ok(Pace::AtOnce)
    }

    /// Whether a mean of frames must begin anew.
    fn changes_picture(&self) -> bool {
        self.settings != self.shown_settings
            || self.shown_camera.as_ref() != Some(self.camera.camera())
            || self.sun.as_ref().is_some_and(Sun::is_changed)
    }

    /// Takes note of the frames that have completed.
    pub(super) fn take_times(&mut self) {
        for times in self.stage.take_times() {
            let ms: f64 = times.pass_ms.iter().sum();
            self.history.add(times);
            if self.chooses_scale() && self.settings.accumulate == 1 && self.scale.observe(ms) {
                let size = self.picture_settings().size;
                log::warn!("frames take {ms:.0} ms: the picture now has {size} pixels");
            }
        }
    }

    /// Reads what the last frame counted; waits for it.
    pub(super) fn count(&mut self) -> Result<()> {
        let Some(renderer) = self.stage.renderer() else { return Ok(()) };
        let counted = Counts::read(renderer);
        if let Some(counts) = self.soften(counted)? {
            self.panel.set_counts(counts);
        }
        Ok(())
    }

    fn run_panel(&mut self) -> (PanelPicture, Vec<Action>) {
        let (picture, window_px, scale_is_chosen) =
            (self.picture_settings().size, self.window_px(), self.chooses_scale());
        let settings = self.present_settings();
        let renderer = self.stage.renderer();
        let facts = Facts {
            settings: &settings,
            picture,
            window_px,
            history: &self.history,
            pass_names: renderer.map(Renderer::pass_names).unwrap_or_default(),
            memory: renderer.map(|r| r.executor().memory()).unwrap_or_default(),
            reserved_bytes: self.stage.gpu().reserved_bytes(),
            device: &self.stage.gpu().report().name,
            cameras: self.stage.scene().map_or_else(Vec::new, |s| s.cameras.iter().map(|c| &*c.name).collect()),
            loading: self.loading.as_ref().map(Loading::progress),
            accumulated: self.accumulated,
            paused: self.clock.paused,
            sun_deg: self.sun.as_ref().map(Sun::angles_deg),
            sun_speed: self.sun_speed,
            scale_is_chosen,
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
        if let Some(scene) = self.stage.scene() {
            let size = self.picture_settings().size;
            title += &format!(" - {} - {size} pixels - {:.1} frames/s", scene.name, self.history.frames_per_second());
        }
        if self.settings.accumulate > 1 {
            title += &format!(" - {} of {} frames", self.accumulated, self.settings.accumulate);
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
