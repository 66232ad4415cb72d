//! Scenes that come onto the stage: loaded on a thread, and again where their light is to be another.

use std::sync::Arc;
use std::time::Instant;

use super::Session;
use crate::Result;
use crate::app::setup::find_camera;
use crate::app::window::camera::FlyCamera;
use crate::app::window::loader::{Loading, Wanted};
use crate::app::window::stage::{Stage, Wanted as WantedFrame};
use crate::app::window::sun::Suns;
use crate::scene::{Camera, Scene};

impl Session {
    /// Puts a scene that has been loaded on the stage.
    pub(super) fn take_scene(&mut self) -> Result<()> {
        let Some(loading) = self.loading.take_if(|loading| loading.is_finished()) else { return Ok(()) };
        self.dirty = true;
        let (wanted, loaded) = loading.finish();
        let camera = wanted.is_again.then(|| self.camera.camera().clone());
        let shown = loaded.and_then(|loaded| {
            let named = self.settings.scene.camera.as_deref().filter(|_| !self.has_scene);
            let camera = camera.map_or_else(|| find_camera(&loaded.scene, named), Ok)?;
            let quality = self.first_quality();
            let settings = self.settings_for(quality).changed(|s| {
                s.scene.file.clone_from(&wanted.path);
                s.scene.scene_name.clone_from(&wanted.scene_name);
            });
            let held = self.held_settings_for(quality);
            let inspects = self.inspector.is_on();
            let wanted = WantedFrame { settings: &settings, held: held.as_ref(), camera: &camera, inspects };
            let (gpu, format) = (Arc::clone(self.presenter.gpu()), self.presenter.format());
            self.stage = Some(Stage::new(&gpu, loaded, (quality, &wanted), format, &mut self.stage)?);
            Ok(camera)
        });
        let shown = match shown {
            // Without any scene the error ends the program.
            Err(error) if !self.has_scene => return Err(error),
            shown => self.recover(shown)?,
        };
        match shown {
            Some(camera) => self.show_scene(wanted, &camera),
            // The environment before stays.
            None => self.settings.environment.source.clone_from(&self.shown_environment.source),
        }
        Ok(())
    }

    /// Begins with a scene that is on the device.
    fn show_scene(&mut self, wanted: Wanted, camera: &Camera) {
        let Some((scene, uploaded)) = self.stage.as_ref().map(|stage| (stage.scene(), stage.uploaded())) else {
            return;
        };
        let mut suns = Suns::new(scene, uploaded.other_lights(), wanted.sun);
        if wanted.is_again {
            suns.steered_as(&self.suns);
        } else {
            self.moment_s = wanted.motion.time_s;
            self.camera = FlyCamera::for_scene(camera, &scene.bounds);
            if self.has_scene {
                (self.settings.scene.camera, self.settings.scene.sun) = (None, None);
            }
            self.keys.set_usual_speed(0.2 * scene.bounds.radius());
        }
        if wanted.environment != self.settings.environment {
            suns.follow(scene, &self.settings.environment);
        }
        self.suns = suns;
        self.recent.note(wanted.path.as_deref());
        (self.settings.scene.file, self.settings.scene.scene_name) = (wanted.path, wanted.scene_name);
        self.shown_environment = wanted.environment;
        self.shown_settings = self.settings.clone();
        self.scale.forget(self.window_px());
        (self.has_scene, self.begins_anew) = (true, true);
        let now = Instant::now();
        self.opened.get_or_insert(now);
    }

    /// Loads the scene that is shown once more where its environment is not the one that is asked for: there is another
    /// one, or the sun has come to rest in another place than its sky was made for.
    pub(super) fn light_anew(&mut self) -> Result<()> {
        let Some(scene) = self.scene().filter(|_| self.loading.is_none()) else { return Ok(()) };
        let asked = &self.settings.environment;
        let is_other = asked.source != self.shown_environment.source;
        if !is_other && !self.suns.have_left_their_sky(scene, asked.turn_deg) {
            return Ok(());
        }
        let wanted = Wanted {
            path: self.settings.scene.file.clone(),
            scene_name: self.settings.scene.scene_name.clone(),
            sun: self.suns.setting(),
            motion: self.settings.motion.clone(),
            environment: asked.clone(),
            is_again: true,
        };
        let started = Loading::start(wanted, self.presenter.gpu().report().limits);
        self.loading = self.recover(started)?;
        Ok(())
    }

    /// The scene that is shown.
    pub(super) fn scene(&self) -> Option<&Scene> {
        self.stage.as_ref().map(Stage::scene)
    }
}
