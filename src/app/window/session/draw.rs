//! What the window shows: the last picture and the panel over it.

use std::time::{Duration, Instant};

use super::Session;
use super::split::Inspector;
use crate::Result;
use crate::app::window::action::Action;
use crate::app::window::loader::Loading;
use crate::app::window::panel::facts::{Facts, Progress, SideFacts};
use crate::app::window::presenter::{Outcome, View};
use crate::app::window::refinement::Next;
use crate::app::window::stage::{FrameSet, Stage};
use crate::gpu::PanelPicture;
use crate::renderer::Renderer;
use crate::settings::{Settings, Size};

/// Time between two pictures that differ in the panel alone, while frames are rendered: showing takes time from them, above all
/// where one processor does both.
const PANEL_EVERY: Duration = Duration::from_millis(15);
const PANEL_EVERY_ON_CPU: Duration = Duration::from_millis(100);
/// Time between two titles.
const TITLE_EVERY: Duration = Duration::from_millis(500);

impl Session {
    /// The settings with the camera, the sun and the time as they are now.
    pub(super) fn present_settings(&self) -> Settings {
        let camera = self.camera.setting().or_else(|| self.settings.scene.camera.clone());
        let sun = self.suns.setting();
        let time_s = if self.scene_moves() { self.moment_s } else { self.settings.motion.time_s };
        self.settings.clone().changed(|s| {
            s.scene.camera = camera;
            s.scene.sun = sun;
            s.motion.time_s = time_s;
        })
    }

    /// Shows the last picture with the panel over it, if anything looks different from what is shown.
    pub(super) fn show(&mut self) -> Result<()> {
        let now = Instant::now();
        self.dirty |= self.repaint_at.is_some_and(|at| at <= now);
        if !self.dirty || self.panel_can_wait() || !self.presenter.is_ready(self.stage.as_mut())? {
            return Ok(());
        }
        let (mut picture, actions) = self.run_panel();
        self.repaint_at = self.panel.repaint_in().map(|pause| now + pause);
        self.dirty = false;
        // Of a picture that could not be shown the textures are still wanted.
        let mut textures = std::mem::take(&mut self.panel_picture.textures);
        textures.append(picture.textures);
        picture.textures = textures;
        self.panel_picture = picture;
        for action in actions {
            self.act(action)?;
        }
        if let (Inspector::Cursor(_), Some(at)) = (self.inspector, self.panel.cursor()) {
            self.inspector = Inspector::Cursor(at);
        }
        let view = View {
            window_px: self.window_px(),
            divider: self.split.as_ref().map_or(0.0, |split| split.divider),
            panel: &self.panel_picture,
            present_mode: self.settings.window.present_mode,
        };
        if self.presenter.show(&view, self.stage.as_mut())? == Outcome::Skipped {
            self.dirty = true;
            return Ok(());
        }
        self.panel_picture.textures.clear();
        (self.has_new_picture, self.shown_at) = (false, Instant::now());
        self.end_capture()
    }

    /// Whether there is nothing new but in the panel, which has just been shown.
    fn panel_can_wait(&self) -> bool {
        let is_cpu = self.presenter.gpu().report().is_cpu();
        let pause = if is_cpu { PANEL_EVERY_ON_CPU } else { PANEL_EVERY };
        self.is_rendering() && !self.has_new_picture && self.shown_at.elapsed() < pause
    }

    /// A capture ends once the picture of its frame is shown.
    fn end_capture(&mut self) -> Result<()> {
        if !std::mem::take(&mut self.capture_ends) {
            return Ok(());
        }
        let captured = self.capture.as_mut().map_or(Ok(None), |capture| capture.end(true));
        if let Some(Some(path)) = self.recover(captured)? {
            self.panel.say(format!("RenderDoc captured {}", path.display()));
        }
        Ok(())
    }

    fn run_panel(&mut self) -> (PanelPicture, Vec<Action>) {
        let (window_px, scale_is_chosen) = (self.window_px(), self.chooses_scale());
        let (settings, progress) = (self.present_settings(), self.progress());
        let (stage, picture) = (self.stage.as_ref(), self.picture_size());
        let set = stage.and_then(Stage::shown);
        let renderer = set.map(|set| &set.main.renderer);
        let facts = Facts {
            settings: &settings,
            picture,
            window_px,
            history: &self.history,
            pass_names: renderer.map(Renderer::pass_names).unwrap_or_default(),
            memory: renderer.map(|r| r.executor().memory()).unwrap_or_default(),
            reserved_bytes: self.presenter.gpu().reserved_bytes(),
            device: &self.presenter.gpu().report().name,
            recent: self.recent.scenes(),
            cameras: stage.map_or_else(Vec::new, |stage| stage.scene().cameras.iter().map(|c| &*c.name).collect()),
            loading: self.loading.as_ref().map(Loading::progress),
            progress,
            paused: self.clock.paused,
            time_s: stage.and_then(|stage| Some([self.moment_s, stage.duration_s()?])),
            sun_deg: self.suns.angles_deg(),
            sun_speed: self.sun_speed,
            scale_is_chosen,
            main: SideFacts { shapes: renderer.map(Renderer::shapes), feedback: self.feedback.as_ref() },
            held: self.split.as_ref().map(|split| split.facts(set, &settings)),
            inspects: self.inspector.is_on(),
        };
        self.panel.run(&self.window, &facts)
    }

    /// Size of the picture that is shown.
    pub(super) fn picture_size(&self) -> Size {
        let shown = self.stage.as_ref().and_then(Stage::shown);
        let size = |set: &FrameSet| {
            let frame = &set.main.renderer.shapes().frame;
            Size { width: frame.width_px, height: frame.height_px }
        };
        shown.map_or(Size { width: 0, height: 0 }, size)
    }

    /// How far the picture has come.
    fn progress(&self) -> Progress {
        let plan = self.plan();
        Progress {
            quality: self.stage.as_ref().and_then(Stage::shown_quality),
            accumulated: self.refinement.accumulated(),
            goal: plan.goal(),
            is_done: self.refinement.next(&plan, Instant::now()) == Next::Nothing,
            part: self.part,
        }
    }

    /// Says in the title what is going on.
    pub(super) fn show_title(&mut self) {
        if self.titled.elapsed() < TITLE_EVERY {
            return;
        }
        self.titled = Instant::now();
        let mut title = String::from("gridlight");
        if let Some(scene) = self.scene() {
            let size = self.picture_size();
            title += &format!(" - {} - {size} pixels - {:.1} frames/s", scene.name, self.history.frames_per_second());
        }
        let Progress { accumulated, goal, .. } = self.progress();
        if goal > 1 && accumulated > 0 {
            title += &format!(" - {accumulated} of {goal} frames");
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
