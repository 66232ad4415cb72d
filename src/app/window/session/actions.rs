//! What each action does.

use std::path::{Path, PathBuf};
use std::time::Instant;

use winit::dpi::PhysicalSize;
use winit::window::Fullscreen;

use super::split::Inspector;
use super::{Due, Session, Shot};
use crate::Result;
use crate::app::setup::find_camera;
use crate::app::window::action::Action;
use crate::app::window::camera::FlyCamera;
use crate::app::window::loader::{Loading, Wanted};
use crate::app::window::panel::MESSAGE;
use crate::app::window::stage::Stage;
#[cfg(feature = "shader-compiler")]
use crate::app::window::stage::Wanted as FrameWanted;
use crate::app::window::{presets, screenshot};
use crate::settings::{EnvironmentSource, MotionSettings, Scope, Settings};
use crate::techniques;

/// What a camera that orbits does.
const ORBITS: &str = "drag the mouse: orbit; wheel: distance; O or W A S D Q E: fly";

impl Session {
    /// Does one thing; what the user got wrong is shown in the window.
    ///
    /// # Errors
    /// What the window does not survive.
    pub(super) fn act(&mut self, action: Action) -> Result<()> {
        self.dirty = true;
        match action {
            Action::Resize(size) => self.resize(size),
            Action::Press(key) => self.key(key, true, false),
            Action::Release(key) => self.key(key, false, false),
            Action::Look([dx, dy]) => self.camera.look(dx, dy),
            Action::Camera(index) => self.go_to_camera(index),
            Action::Panel => self.panel.toggle(),
            Action::Set(key, value) => {
                let changed = self.settings.with(&key, &value);
                self.change(changed)?;
            }
            Action::Reset(key) => {
                let changed = self.settings.with_default(&key);
                self.change(changed)?;
            }
            Action::Expose(stops) => {
                let stops = self.settings.picture.exposure_compensation + stops;
                let changed = self.settings.with("exposure-compensation", &stops.to_string());
                self.change(changed)?;
                self.panel.say(format!("exposure {stops:+} stops"));
            }
            Action::Preset(name) => self.change(Ok(presets::apply(name, &self.settings, &Settings::default())))?,
            Action::Sun(turn) => self.turn_sun(turn),
            Action::SunSpeed(speed) => self.sun_speed = speed,
            Action::Split => self.toggle_split(),
            Action::Swap => self.swap_sides(),
            Action::Divider(at) => self.move_divider(at),
            Action::Inspect => self.toggle_inspector(),
            Action::InspectAt(point) => self.inspector = Inspector::At(point),
            Action::Open(path) if EnvironmentSource::is_image(&path) => {
                let source = Some(EnvironmentSource::File(path));
                self.change(Ok(self.settings.clone().changed(|s| s.environment.source = source)))?;
            }
            Action::Open(path) => self.load(Some(path), None)?,
            Action::Screenshot(name) => {
                let due = if name.is_some() { Due::Settled } else { Due::Soon };
                self.screenshots.push(Shot { name, due });
            }
            Action::Render(name) => {
                self.screenshots.push(Shot { name, due: Due::Complete });
                if !self.refinement.is_full(&self.plan()) {
                    self.panel.say("the picture will be saved when it is complete".to_owned());
                }
            }
            Action::SaveSettings(path) => {
                let saved = screenshot::save_settings(&self.present_settings(), &path);
                if self.recover(saved)?.is_some() {
                    self.saved_settings = self.settings.clone();
                    self.panel.say(format!("saved {}", path.display()));
                }
            }
            Action::LoadSettings(path) => self.load_settings(&path)?,
            Action::Time(time_s) => self.moment_s = time_s,
            Action::Pause => self.clock.paused = !self.clock.paused,
            Action::Step => {
                self.clock.paused = true;
                self.clock.steps += 1;
            }
            Action::Reload => self.reload(),
            Action::Fullscreen => {
                let full = self.window.fullscreen().is_none().then_some(Fullscreen::Borderless(None));
                self.window.set_fullscreen(full);
            }
            Action::Minimise => {
                // Where there is no window manager nothing happens by itself.
                self.window.set_minimized(true);
                self.hidden = true;
            }
            Action::Restore => {
                self.window.set_minimized(false);
                self.hidden = false;
                self.presenter.resized();
            }
            Action::FrameScene => self.frame_scene(),
            Action::Orbit => self.toggle_orbit(),
            Action::ResetSpeed => {
                let speed = self.keys.reset_speed();
                self.say_speed(speed);
            }
            Action::Help => self.panel.toggle_help(),
            Action::Leave => self.leave(),
            Action::Quit => self.quit = true,
        }
        self.light_anew()
    }

    fn resize(&mut self, size: [u32; 2]) {
        self.no_area = size.contains(&0);
        self.asked_size_px = Some(size).filter(|_| !self.no_area);
        if self.no_area {
            self.presenter.resized();
        } else if let Some(size) = self.window.request_inner_size(PhysicalSize::new(size[0], size[1])) {
            // At once, without an event.
            self.resized([size.width, size.height]);
        }
    }

    fn frame_scene(&mut self) {
        let [width, height] = self.window_px();
        if let Some(stage) = &self.stage {
            self.camera.frame(&stage.scene().bounds, width as f32 / height.max(1) as f32);
            self.panel.say(ORBITS.to_owned());
        }
    }

    fn toggle_orbit(&mut self) {
        let bounds = self.stage.as_ref().map(|stage| stage.scene().bounds);
        let begins = !self.camera.orbits();
        self.camera.orbit(bounds.as_ref().filter(|_| begins));
        self.panel.say(if begins { ORBITS } else { "W A S D Q E and dragging the mouse: fly" }.to_owned());
    }

    /// Says how fast the camera flies.
    pub(super) fn say_speed(&mut self, speed: f32) {
        self.panel.say(format!("flying speed {speed:.3} m/s (wheel; R: reset)"));
        self.dirty = true;
    }

    /// Leaves, or says what would be lost.
    fn leave(&mut self) {
        let asks = self.asked_to_leave.is_some_and(|asked| asked.elapsed() < MESSAGE);
        let lost = if self.screenshots.is_empty() {
            (self.settings != self.saved_settings).then_some("the settings have unsaved changes")
        } else {
            Some("a picture has not been saved yet")
        };
        match lost.filter(|_| !asks) {
            None => self.quit = true,
            Some(lost) => {
                self.asked_to_leave = Some(Instant::now());
                self.panel.say(format!("{lost}: press Esc again to quit"));
            }
        }
    }

    fn go_to_camera(&mut self, index: usize) {
        let Some(scene) = self.stage.as_ref().map(Stage::scene) else { return };
        match scene.cameras.get(index) {
            Some(camera) => {
                self.camera = FlyCamera::for_scene(camera, &scene.bounds);
                self.settings.scene.camera = Some(camera.name.clone());
            }
            None => self.panel.say(format!("the scene has {} camera(s)", scene.cameras.len())),
        }
    }

    /// Takes over settings when they are in order.
    fn change(&mut self, settings: Result<Settings>) -> Result<()> {
        let checked = settings.and_then(|new| techniques::check(&new).map(|()| new));
        let Some(new) = self.recover(checked)? else { return Ok(()) };
        let before = std::mem::replace(&mut self.settings, new);
        self.panel.clear_error();
        self.scale.forget(self.window_px());
        if self.settings.window.present_mode != before.window.present_mode {
            self.presenter.resized();
        }
        if self.settings.scene.sun != before.scene.sun {
            self.suns.put(self.settings.scene.sun);
            self.sun_turned_deg = f32::INFINITY;
        }
        let place = |settings: &Settings| (settings.environment.scale, settings.environment.turn_deg);
        if place(&self.settings) != place(&before)
            && let Some(scene) = self.stage.as_ref().map(Stage::scene)
        {
            self.suns.follow(scene, &self.settings.environment);
            self.sun_turned_deg = f32::INFINITY;
        }
        if self.settings.scene.camera != before.scene.camera
            && let Some((scene, bounds)) = self.stage.as_ref().map(|stage| (stage.scene(), stage.scene().bounds))
        {
            let found = find_camera(scene, self.settings.scene.camera.as_deref());
            match self.recover(found)? {
                Some(camera) => self.camera = FlyCamera::for_scene(&camera, &bounds),
                None => self.settings.scene.camera = before.scene.camera,
            }
        }
        Ok(())
    }

    /// Starts to load a scene; the one that is shown stays until then.
    fn load(&mut self, path: Option<PathBuf>, scene_name: Option<String>) -> Result<()> {
        if self.loading.is_some() {
            self.panel.show_error("a scene is already being loaded".to_owned());
            return Ok(());
        }
        let environment = self.settings.environment.clone();
        let (sun, motion) = (None, MotionSettings::default());
        let wanted = Wanted { path, scene_name, sun, motion, environment, is_again: false };
        let started = Loading::start(wanted, self.presenter.gpu().report().limits);
        self.loading = self.recover(started)?;
        self.panel.clear_error();
        Ok(())
    }

    fn load_settings(&mut self, path: &Path) -> Result<()> {
        let read = Settings::read(path).and_then(|read| {
            let new = of_this_window(read, &self.settings);
            new.validate()?;
            techniques::check(&new)?;
            Ok(new)
        });
        let Some(new) = self.recover(read)? else { return Ok(()) };
        let scene = (new.scene.file.clone(), new.scene.scene_name.clone());
        let shown = (self.settings.scene.file.clone(), self.settings.scene.scene_name.clone());
        let other_scene = scene != shown;
        self.change(Ok(new.changed(|s| (s.scene.file, s.scene.scene_name) = shown)))?;
        self.saved_settings = self.settings.clone();
        self.panel.say(format!("loaded {}", path.display()));
        if other_scene { self.load(scene.0, scene.1) } else { Ok(()) }
    }

    /// Compiles shaders that have changed, on a thread of its own.
    #[cfg(feature = "shader-compiler")]
    fn reload(&mut self) {
        self.shaders.ask();
    }

    #[cfg(not(feature = "shader-compiler"))]
    fn reload(&mut self) {
        self.panel.show_error("this build cannot compile shaders: build with --features shader-compiler".to_owned());
    }

    /// Puts shaders in use that have been compiled; with an error the last good ones stay.
    #[cfg(feature = "shader-compiler")]
    pub(super) fn take_shaders(&mut self) -> Result<()> {
        let Some(compiled) = self.shaders.take() else { return Ok(()) };
        self.dirty = true;
        let Some(compiled) = self.recover(compiled)? else { return Ok(()) };
        let names = compiled.names();
        self.panel.clear_error();
        if names.is_empty() {
            self.panel.say("the shaders are up to date".to_owned());
            return Ok(());
        }
        let what = format!("{} shader(s) compiled: {}", names.len(), names.join(" "));
        log::info!("{what}");
        self.panel.say(what);
        let before = compiled.put_in_use();
        let adopted = self.compile_again();
        if self.recover(adopted)?.is_none() {
            // They compile, but the frame cannot have them: bindings that are not there, say.
            before.put_in_use();
        }
        self.begins_anew = true;
        Ok(())
    }

    /// Compiles the frames that come first with the shaders in use.
    #[cfg(feature = "shader-compiler")]
    fn compile_again(&mut self) -> Result<()> {
        let quality = self.first_quality();
        let (settings, held) = (self.settings_for(quality), self.held_settings_for(quality));
        let (camera, inspects) = (self.camera.camera(), self.inspector.is_on());
        let wanted = FrameWanted { settings: &settings, held: held.as_ref(), camera, inspects };
        self.stage.as_mut().map_or(Ok(()), |stage| stage.compile_again(quality, &wanted))
    }
}

/// Settings that were read, as far as a window can take them over while it is open with other settings.
fn of_this_window(read: Settings, in_use: &Settings) -> Settings {
    read.with_groups_of(in_use, Scope::is_session)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::testing::every_value_changed;

    #[test]
    fn a_window_keeps_its_session() {
        let (read, in_use) = (every_value_changed(), Settings::default());
        let differences = of_this_window(read, &in_use).differences(&in_use).unwrap();
        for key in Settings::keys() {
            let is_taken_over = differences.iter().any(|(different, _)| *different == key);
            assert_eq!(is_taken_over, !Settings::scope_of(&key).unwrap().is_session(), "{key}");
        }
    }
}
