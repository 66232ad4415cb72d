//! A headless run of a scene that moves, and the frames that it writes one by one.

use std::collections::VecDeque;
use std::sync::Arc;

use super::frames::AroundFrames;
use super::headless::note;
use super::lighting;
use super::setup::find_camera;
use crate::files::OutputFile;
use crate::gpu::Gpu;
use crate::renderer::{Fresh, Job, Renderer, UploadedScene};
use crate::scene::Scene;
use crate::scene_mover::SceneMover;
use crate::settings::{Settings, VplSeeds};
use crate::{Result, techniques};

/// What a run does around its frames: it moves the scene, and writes the frames of a sequence.
pub struct Sequence<'a> {
    /// The device.
    pub gpu: &'a Arc<Gpu>,
    /// How it is rendered.
    pub settings: &'a Settings,
    /// The scene at the moment that is shown.
    pub scene: &'a mut Scene,
    /// The scene on the device.
    pub uploaded: &'a mut UploadedScene,
    /// What moves it there.
    pub mover: SceneMover,
    /// The moment that is shown, in seconds.
    pub shown_s: f64,
    /// The files of the frames that are not rendered yet.
    pub files: VecDeque<OutputFile>,
}

impl Sequence<'_> {
    /// Compiles a frame for where the scene is now, with everything measured anew.
    fn renderer(&mut self) -> Result<Renderer> {
        let settings = self.settings;
        let point_count_log2 = techniques::of(settings)?.point_count_log2(settings);
        if point_count_log2.is_some() {
            self.scene.pose_vertices();
        }
        self.uploaded.spread_points(self.scene, point_count_log2)?;
        let camera = find_camera(self.scene, settings.scene.camera.as_deref())?;
        Renderer::new(&Job::new(self.gpu, self.uploaded, &camera, settings))
    }

    /// Shows the scene at a moment.
    fn show(&mut self, renderer: &mut Renderer, moment_s: f64) -> Result<()> {
        let (settings, moves) = (self.settings, self.scene.motion.moves());
        if !moves.any() || moment_s == self.shown_s {
            return Ok(());
        }
        self.shown_s = moment_s;
        self.scene.pose_without_vertices(moment_s);
        let has_other_sky = lighting::follow(self.scene, settings.scene.sun, &settings.environment);
        self.mover.follow(self.uploaded, self.scene)?;
        let has_points = techniques::of(settings)?.point_count_log2(settings).is_some();
        if has_points && (moves.geometry || has_other_sky) {
            // The points and the means of the sky are part of what is compiled.
            *renderer = self.renderer()?;
            return Ok(());
        }
        let camera = find_camera(self.scene, settings.scene.camera.as_deref())?;
        renderer.update(&Job::new(self.gpu, self.uploaded, &camera, settings));
        if moves.geometry || moves.lights {
            renderer.expect_another_scene();
        }
        Ok(())
    }

    /// What frames have of their own; `None` where all are the same.
    fn fresh(&self) -> Option<Fresh> {
        let held = self.scene.motion.moves().any().then_some(VplSeeds::Held);
        Some(match self.settings.many_lights.vpl_seeds.or(held)? {
            VplSeeds::Held => Fresh::Shadows,
            VplSeeds::Rolling => Fresh::SomePaths,
            VplSeeds::Fresh => Fresh::All,
        })
    }

    /// Gives a frame its random numbers. Those of a mean have theirs already.
    fn seed(&self, renderer: &mut Renderer, frame: u32) {
        if let Some(fresh) = self.fresh().filter(|_| self.settings.render.accumulate == 1) {
            renderer.set_accumulated_frame(frame, fresh);
        }
    }
}

impl AroundFrames for Sequence<'_> {
    fn before(&mut self, renderer: &mut Renderer, frame: u32) -> Result<()> {
        // A mean is of one moment.
        let of_moment = if self.settings.render.accumulate > 1 { 0 } else { frame };
        self.show(renderer, self.settings.motion.moment_s(of_moment))?;
        self.seed(renderer, frame);
        Ok(())
    }

    fn passes_before(&mut self) -> Vec<(String, f64)> {
        self.mover.pass_names().into_iter().zip(self.mover.take_pass_ms()).collect()
    }

    fn render_again(&mut self, renderer: &mut Renderer, frame: u32) -> Result<bool> {
        let stands = !self.scene.motion.moves().any() || self.settings.render.accumulate > 1;
        if stands || renderer.complaint()?.is_none() {
            return Ok(false);
        }
        *renderer = self.renderer()?;
        self.seed(renderer, frame);
        Ok(true)
    }

    fn after(&mut self, renderer: &Renderer, frame: u32) -> Result<()> {
        let Some(file) = self.files.pop_front() else { return Ok(()) };
        self.gpu.check_validation()?;
        let picture = renderer.read_picture(format!("{}, frame {frame}", note(self.settings, 1, None)))?;
        file.commit_picture(&picture)
    }
}
