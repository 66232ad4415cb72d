//! One window while it is open: what is shown in it, and how it goes on from turn to turn.

mod actions;
mod draw;
mod split;

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use winit::event::{MouseScrollDelta, WindowEvent};
use winit::keyboard::KeyCode;
use winit::window::{CursorGrabMode, Window};

use self::split::{Inspector, Split};
use super::action::Action;
use super::app::IDLE;
use super::camera::FlyCamera;
use super::keys::{self, Keys};
use super::loader::{Loading, Wanted};
use super::panel::Panel;
use super::panel::history::History;
use super::presenter::Presenter;
#[cfg(feature = "shader-compiler")]
use super::reload::ShaderReload;
use super::scale::{ScaleControl, fixed_scale};
use super::script::Script;
use super::sun::Suns;
use crate::app::setup::find_camera;
use crate::gpu::FrameCapture;
use crate::renderer::FrameFeedback;
use crate::scene::Camera;
use crate::settings::{EnvironmentSettings, RenderScale, Settings};
use crate::{Error, Result, interrupt};

/// On a CPU driver the window begins with no more lights than this: they take most of such a device's time.
const CPU_VPLS: u32 = 5_000;
/// Longest step of time, however long a frame took.
const LONGEST_STEP_S: f32 = 0.25;
/// A step of time with the `.` key.
const SINGLE_STEP_S: f32 = 1.0 / 30.0;
/// Pause between looks at a frame that is under way.
const BUSY: Duration = Duration::from_millis(1);
/// The sun's turn after which the lights are measured anew.
const FAR_TURN_DEG: f32 = 10.0;

/// When the next turn should come.
pub enum Pace {
    /// As soon as events are dealt with.
    AtOnce,
    /// After a while, or with the next event.
    In(Duration),
    /// Never: leave.
    Quit,
}

/// Where time stands.
struct Clock {
    last: Instant,
    paused: bool,
    /// Single steps asked for.
    steps: u32,
}

/// Everything of an open window.
pub struct Session {
    panel: Panel,
    presenter: Presenter,
    loading: Option<Loading>,
    window: Arc<Window>,
    settings: Settings,
    /// What presets go back to: the defaults, as far as the device can bear them.
    defaults: Settings,
    /// The settings of the last frame that could be compiled.
    shown_settings: Settings,
    script: Script,
    /// Turns since the scene is there.
    frame: u64,
    keys: Keys,
    looking: bool,
    camera: FlyCamera,
    suns: Suns,
    /// The environment of the scene that is shown.
    shown_environment: EnvironmentSettings,
    sun_speed: f32,
    /// Turn of the sun since the lights were last measured.
    sun_turned_deg: f32,
    clock: Clock,
    scale: ScaleControl,
    history: History,
    /// Frames accumulated since anything changed.
    accumulated: u32,
    /// What the last completed frame told.
    feedback: Option<FrameFeedback>,
    split: Option<Split>,
    inspector: Inspector,
    /// Screenshots to take of the next frame.
    screenshots: Vec<Option<PathBuf>>,
    capture: Option<FrameCapture>,
    /// Frames shown.
    shown_count: u64,
    #[cfg(feature = "shader-compiler")]
    shaders: ShaderReload,
    /// Where the last frame was seen from.
    shown_camera: Option<Camera>,
    /// Something may look different from the last frame.
    dirty: bool,
    /// Nobody can see the window.
    hidden: bool,
    /// Size of the window, as the window system said last.
    size_px: [u32; 2],
    /// The window was given no area, whatever the window system says.
    no_area: bool,
    quit: bool,
    /// The first scene: without it there is nothing to go on with.
    has_scene: bool,
    titled: Instant,
}

impl Session {
    /// Opens the device and starts to load the scene.
    ///
    /// # Errors
    /// Those of [`Presenter::open`] and [`FrameCapture::load`].
    pub fn open(window: Arc<Window>, mut settings: Settings, script: Script) -> Result<Self> {
        let capture = FrameCapture::load(settings.output.renderdoc_frame)?;
        let presenter = Presenter::open(&settings, Arc::<Window>::clone(&window));
        let presenter = FrameCapture::opened(capture.as_ref(), presenter)?;
        let mut defaults = Settings::default();
        if presenter.gpu().report().is_cpu() && settings.window.render_scale == RenderScale::Auto {
            adapt_to_cpu(&mut settings, &mut defaults);
        }
        let size = window.inner_size();
        let layers = presenter.gpu().report().limits.array_layers;
        let wanted = Wanted {
            path: settings.scene.file.clone(),
            sun: settings.scene.sun,
            environment: settings.environment.clone(),
            is_again: false,
        };
        let loading = Some(Loading::start(wanted, layers)?);
        let now = Instant::now();
        Ok(Self {
            panel: Panel::new(&window),
            loading,
            window,
            shown_settings: settings.clone(),
            script,
            frame: 0,
            keys: Keys::new(),
            looking: false,
            camera: FlyCamera::nowhere(),
            suns: Suns::default(),
            shown_environment: settings.environment.clone(),
            sun_speed: 0.0,
            sun_turned_deg: 0.0,
            clock: Clock { last: now, paused: false, steps: 0 },
            scale: ScaleControl::new([size.width, size.height]),
            history: History::default(),
            accumulated: 0,
            feedback: None,
            split: None,
            inspector: Inspector::Off,
            screenshots: Vec::new(),
            capture,
            shown_count: 0,
            #[cfg(feature = "shader-compiler")]
            shaders: ShaderReload::start(),
            shown_camera: None,
            dirty: true,
            hidden: false,
            size_px: [size.width, size.height],
            no_area: false,
            quit: false,
            has_scene: false,
            titled: now,
            settings,
            defaults,
            presenter,
        })
    }

    /// Ends everything on the device.
    ///
    /// # Errors
    /// [`Error::Validation`] when the layers reported anything, the end included.
    pub fn close(self) -> Result<()> {
        let log = self.presenter.gpu().validation_log();
        // The surface goes before its window.
        let Self { presenter, panel, window, .. } = self;
        drop(presenter);
        drop(panel);
        drop(window);
        log.check()
    }

    /// Goes on by one frame where that is possible.
    ///
    /// # Errors
    /// What nothing can be done about: the device is lost, the first scene cannot be loaded.
    pub fn turn(&mut self) -> Result<Pace> {
        if self.quit || interrupt::requested() {
            return Ok(Pace::Quit);
        }
        self.take_scene()?;
        self.light_anew()?;
        if !self.has_scene {
            self.show_title();
            return Ok(Pace::In(IDLE));
        }
        if !self.presenter.is_ready()? {
            return Ok(Pace::In(BUSY));
        }
        self.take_done();
        #[cfg(feature = "shader-compiler")]
        self.take_shaders()?;
        // A script waits for scenes and for screenshots.
        if self.loading.is_none() && self.screenshots.is_empty() {
            self.run_script()?;
            self.frame += 1;
        }
        self.pass_time()?;
        self.show_title();
        if self.hidden || self.window_px().contains(&0) {
            // There is no next frame: the last one must do.
            self.take_screenshots()?;
            return Ok(Pace::In(IDLE));
        }
        if self.is_at_rest() {
            return Ok(Pace::In(10 * IDLE));
        }
        self.draw()
    }

    /// Whether the next frame would look like the last.
    fn is_at_rest(&self) -> bool {
        let goal = self.goal();
        let finished = goal > 1 && self.accumulated >= goal;
        !self.dirty && self.script.is_over() && (self.clock.paused || finished) && !self.panel.wants_repaint()
    }

    /// Size of the window in pixels, 0 where it has no area.
    fn window_px(&self) -> [u32; 2] {
        if self.no_area { [0, 0] } else { self.size_px }
    }

    fn run_script(&mut self) -> Result<()> {
        while let Some(action) = self.script.next(self.frame) {
            log::debug!("frame {}: {action:?}", self.frame);
            self.act(action)?;
            if self.loading.is_some() || !self.screenshots.is_empty() {
                break;
            }
        }
        Ok(())
    }

    /// Moves whatever moves.
    fn pass_time(&mut self) -> Result<()> {
        let now = Instant::now();
        let seconds = now.duration_since(self.clock.last).as_secs_f32().min(LONGEST_STEP_S);
        self.clock.last = now;
        let flight = self.keys.flight(seconds);
        if flight != glam::Vec3::ZERO {
            self.camera.fly(flight);
            self.dirty = true;
        }
        let time = if self.clock.paused { SINGLE_STEP_S * self.clock.steps as f32 } else { seconds };
        self.clock.steps = 0;
        let [azimuth, elevation] = self.keys.sun_deg(seconds);
        self.turn_sun([azimuth + self.sun_speed * time, elevation]);
        let at_rest = azimuth == 0.0 && elevation == 0.0 && self.sun_speed == 0.0;
        // The device has the lights of the last frame.
        let is_shown = !self.suns.are_changed();
        if at_rest && is_shown && self.sun_turned_deg > FAR_TURN_DEG {
            self.sun_turned_deg = 0.0;
            let measured = self.presenter.measure_again(self.camera.camera());
            self.recover(measured)?;
        }
        Ok(())
    }

    fn turn_sun(&mut self, [azimuth, elevation]: [f32; 2]) {
        if self.suns.turn_deg(azimuth, elevation) {
            self.sun_turned_deg += azimuth.abs() + elevation.abs();
            self.dirty = true;
        }
    }

    /// Puts a scene that has been loaded on the stage.
    fn take_scene(&mut self) -> Result<()> {
        let Some(loading) = self.loading.take_if(|loading| loading.is_finished()) else { return Ok(()) };
        let (wanted, loaded) = loading.finish();
        let camera = wanted.is_again.then(|| self.camera.camera().clone());
        let shown = loaded.and_then(|loaded| {
            let named = self.settings.scene.camera.as_deref().filter(|_| !self.has_scene);
            let camera = camera.map_or_else(|| find_camera(&loaded.scene, named), Ok)?;
            let settings = self.picture_settings().changed(|s| s.scene.file.clone_from(&wanted.path));
            self.presenter.set_scene(loaded, &camera, &settings)?;
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
        let Some((scene, uploaded)) = self.presenter.scene().zip(self.presenter.uploaded()) else { return };
        let mut suns = Suns::new(scene, uploaded.other_lights(), wanted.sun);
        if wanted.is_again {
            suns.steered_as(&self.suns);
        } else {
            self.camera = FlyCamera::new(camera);
            if self.has_scene {
                (self.settings.scene.camera, self.settings.scene.sun) = (None, None);
            }
            self.keys.speed = 0.2 * scene.bounds.radius();
        }
        if wanted.environment != self.settings.environment {
            suns.follow(scene, &self.settings.environment);
        }
        self.suns = suns;
        (self.settings.scene.file, self.shown_environment) = (wanted.path, wanted.environment);
        self.shown_settings = self.settings.clone();
        self.scale.forget();
        (self.has_scene, self.dirty, self.accumulated) = (true, true, 0);
    }

    /// Loads the scene that is shown once more where its environment is not the one that is asked for: there is another
    /// one, or the sun has come to rest in another place than its sky was made for.
    pub(super) fn light_anew(&mut self) -> Result<()> {
        let Some(scene) = self.presenter.scene().filter(|_| self.loading.is_none()) else { return Ok(()) };
        let asked = &self.settings.environment;
        let is_other = asked.source != self.shown_environment.source;
        if !is_other && !self.suns.have_left_their_sky(scene, asked.turn_deg) {
            return Ok(());
        }
        let wanted = Wanted {
            path: self.settings.scene.file.clone(),
            sun: self.suns.setting(),
            environment: asked.clone(),
            is_again: true,
        };
        let started = Loading::start(wanted, self.presenter.gpu().report().limits.array_layers);
        self.loading = self.recover(started)?;
        Ok(())
    }

    /// Shows an error that the window survives; gives others back.
    fn recover<T>(&mut self, result: Result<T>) -> Result<Option<T>> {
        match result {
            Ok(value) => Ok(Some(value)),
            Err(error @ (Error::Usage(_) | Error::File { .. } | Error::Failure(_) | Error::Memory { .. })) => {
                log::error!("{error}");
                self.panel.show_error(error.to_string());
                self.dirty = true;
                Ok(None)
            }
            Err(error) => Err(error),
        }
    }

    /// Whether the picture's size follows the time that frames take.
    fn chooses_scale(&self) -> bool {
        fixed_scale(self.settings.window.render_scale, self.presenter.gpu().report().is_cpu()).is_none()
    }

    /// Lets the panel see an event; true when it is the panel's alone.
    pub fn panel_takes(&mut self, event: &WindowEvent) -> bool {
        if !matches!(event, WindowEvent::RedrawRequested) {
            self.dirty = true;
        }
        self.panel.on_event(&self.window, event)
    }

    /// A key goes down or up.
    pub fn key(&mut self, key: KeyCode, down: bool, repeat: bool) {
        self.keys.set(key, down);
        if let Some(action) = keys::action_of(key).filter(|_| down && !repeat)
            && let Err(error) = self.act(action)
        {
            log::error!("{error}");
            self.panel.show_error(error.to_string());
        }
    }

    /// The window lost the keyboard.
    pub fn lose_focus(&mut self) {
        self.keys.release_all();
        self.mouse(false);
    }

    /// A button goes down over the picture, or up.
    pub fn mouse(&mut self, down: bool) {
        if self.looking == down {
            return;
        }
        self.looking = down;
        let modes: &[_] =
            if down { &[CursorGrabMode::Locked, CursorGrabMode::Confined] } else { &[CursorGrabMode::None] };
        if !modes.iter().any(|mode| self.window.set_cursor_grab(*mode).is_ok()) {
            log::debug!("the cursor cannot be held");
        }
        self.window.set_cursor_visible(!down);
    }

    /// The mouse moves, right and down.
    pub fn mouse_moved(&mut self, [dx, dy]: [f32; 2]) {
        if self.looking {
            self.camera.look(dx, dy);
            self.dirty = true;
        }
    }

    /// The wheel turns over the picture.
    pub fn wheel(&mut self, delta: MouseScrollDelta) {
        self.keys.wheel(match delta {
            MouseScrollDelta::LineDelta(_, lines) => lines,
            MouseScrollDelta::PixelDelta(pixels) => pixels.y as f32 / 40.0,
        });
    }

    /// The window has another size.
    pub fn resized(&mut self, size_px: [u32; 2]) {
        self.size_px = size_px;
        self.presenter.resized();
        self.dirty = true;
    }

    /// The window is out of sight, or back.
    pub fn hidden(&mut self, hidden: bool) {
        self.hidden = hidden;
        self.dirty = true;
    }

    /// A file was dropped on the window.
    pub fn drop_file(&mut self, path: PathBuf) {
        if let Err(error) = self.act(Action::Open(path)) {
            self.panel.show_error(error.to_string());
        }
    }
}

/// What a CPU can do ten times a second, unless other settings were asked for.
fn adapt_to_cpu(settings: &mut Settings, defaults: &mut Settings) {
    if settings.many_lights.vpls == defaults.many_lights.vpls {
        settings.many_lights.vpls = CPU_VPLS;
    }
    defaults.many_lights.vpls = CPU_VPLS;
    log::warn!(
        "a CPU driver: the picture's size adapts to about 10 frames per second, with {} lights; --render-scale sets \
         a size and leaves the number of lights alone",
        settings.many_lights.vpls
    );
}
