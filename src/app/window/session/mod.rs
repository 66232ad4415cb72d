//! One window while it is open: what is shown in it, and how it goes on from turn to turn.

mod actions;
mod draw;
mod frames;
mod input;
mod scenes;
mod split;

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use winit::window::Window;

use self::frames::Target;
use self::split::{Inspector, Split};
use super::app::IDLE;
use super::camera::FlyCamera;
use super::drag::Drag;
use super::keys::Keys;
use super::loader::{Loading, Wanted};
use super::panel::Panel;
use super::panel::history::History;
use super::presenter::Presenter;
use super::quality::{Quality, fixed_scale};
use super::recent::Recent;
use super::refinement::{Next, Refinement};
#[cfg(feature = "shader-compiler")]
use super::reload::ShaderReload;
use super::scale::ScaleControl;
use super::script::Script;
use super::stage::Stage;
use super::sun::Suns;
use crate::gpu::{FrameCapture, PanelPicture};
use crate::renderer::FrameFeedback;
use crate::settings::{EnvironmentSettings, Settings};
use crate::{Error, Result, interrupt};

/// Longest step of time, however long a frame took.
const LONGEST_STEP_S: f32 = 0.25;
/// A step of time with the `.` key.
const SINGLE_STEP_S: f32 = 1.0 / 30.0;
/// Pause between looks at a frame that is under way.
const BUSY: Duration = Duration::from_millis(1);
/// Pause between steps of what moves.
const MOVING: Duration = Duration::from_millis(5);
/// A script goes on when what it did has been shown, or after so long.
const SCRIPT_PATIENCE: Duration = Duration::from_millis(250);
/// The sun's turn after which the lights are measured anew.
const FAR_TURN_DEG: f32 = 10.0;

/// When the next turn should come.
pub enum Pace {
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

/// A screenshot that is asked for.
struct Shot {
    /// Its file, or the beginning of its files' names.
    name: Option<PathBuf>,
    due: Due,
}

/// When a screenshot is taken.
#[derive(Clone, Copy, PartialEq)]
enum Due {
    /// Once the frame under way is done.
    Soon,
    /// Once nothing is rendered any more, so that a script that counts frames has the same picture in every run.
    Settled,
    /// Once there is a picture of the window's size with the settings in use.
    Complete,
}

/// Everything of an open window.
pub struct Session {
    panel: Panel,
    recent: Recent,
    /// What is rendered, once there is a scene.
    stage: Option<Stage>,
    presenter: Presenter,
    loading: Option<Loading>,
    window: Arc<Window>,
    settings: Settings,
    /// The settings as they are in a file or on the command line.
    saved_settings: Settings,
    /// When it was last said what leaving would lose.
    asked_to_leave: Option<Instant>,
    /// The settings of the last frame that could be compiled.
    shown_settings: Settings,
    script: Script,
    /// Frames that the script has seen.
    frame: u64,
    /// When it saw the last one.
    frame_seen: Instant,
    /// When the first scene was there.
    opened: Option<Instant>,
    keys: Keys,
    /// The mouse over the picture.
    drag: Drag,
    camera: FlyCamera,
    suns: Suns,
    /// The environment of the scene that is shown.
    shown_environment: EnvironmentSettings,
    sun_speed: f32,
    /// Turn of the sun since the lights were last measured.
    sun_turned_deg: f32,
    clock: Clock,
    /// The moment of the scene's animation, in seconds.
    moment_s: f64,
    /// Frames, not the clock, move the scene.
    is_scripted: bool,
    scale: ScaleControl,
    history: History,
    /// What is to be seen, and how far its picture has come.
    target: Option<Target>,
    refinement: Refinement,
    /// What is to be seen has changed, whether or not that can be told from the target.
    begins_anew: bool,
    /// The next frame begins once something has been measured for it.
    waits_for_measures: bool,
    /// The frame under way shows what has changed since.
    is_late: bool,
    /// Rounds done and all of them, of a reference that shows what it has.
    part: Option<[u32; 2]>,
    /// Quality of the last frame that completed.
    shown_quality: Option<Quality>,
    /// Frames that have completed.
    frames_done: u64,
    /// What the last completed frame told.
    feedback: Option<FrameFeedback>,
    split: Option<Split>,
    inspector: Inspector,
    /// Screenshots to take.
    screenshots: Vec<Shot>,
    capture: Option<FrameCapture>,
    /// The next picture that is shown is that of a frame which may be captured.
    capture_ends: bool,
    #[cfg(feature = "shader-compiler")]
    shaders: ShaderReload,
    /// The panel as it was laid out last; its textures are those that have not been shown.
    panel_picture: PanelPicture,
    /// When the panel wants to be laid out again.
    repaint_at: Option<Instant>,
    /// Something may look different from what is shown.
    dirty: bool,
    /// A frame has completed that has not been shown.
    has_new_picture: bool,
    /// When the window was given a picture last.
    shown_at: Instant,
    /// Nobody can see the window.
    hidden: bool,
    /// Size of the window, as the window system said last.
    size_px: [u32; 2],
    /// Size that the window was asked to have last.
    asked_size_px: Option<[u32; 2]>,
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
    pub fn open(window: Arc<Window>, settings: Settings, script: Script) -> Result<Self> {
        let capture = FrameCapture::load(settings.output.renderdoc_frame)?;
        let presenter = Presenter::open(&settings, Arc::<Window>::clone(&window));
        let presenter = FrameCapture::opened(capture.as_ref(), presenter)?;
        let size = window.inner_size();
        let limits = presenter.gpu().report().limits;
        let wanted = Wanted {
            path: settings.scene.file.clone(),
            scene_name: settings.scene.scene_name.clone(),
            sun: settings.scene.sun,
            motion: settings.motion.clone(),
            environment: settings.environment.clone(),
            is_again: false,
        };
        let loading = Some(Loading::start(wanted, limits)?);
        let now = Instant::now();
        // A script finds the same window every time.
        let recent = if script.is_over() { Recent::of_user() } else { Recent::default() };
        Ok(Self {
            panel: Panel::new(&window, recent.is_first_start()),
            recent,
            stage: None,
            loading,
            window,
            saved_settings: settings.clone(),
            asked_to_leave: None,
            shown_settings: settings.clone(),
            is_scripted: !script.is_over(),
            script,
            frame: 0,
            frame_seen: now,
            opened: None,
            keys: Keys::new(),
            drag: Drag::default(),
            camera: FlyCamera::nowhere(),
            suns: Suns::default(),
            shown_environment: settings.environment.clone(),
            sun_speed: 0.0,
            sun_turned_deg: 0.0,
            clock: Clock { last: now, paused: false, steps: 0 },
            moment_s: settings.motion.time_s,
            scale: ScaleControl::new([size.width, size.height], presenter.gpu().report().is_cpu()),
            history: History::default(),
            target: None,
            refinement: Refinement::new(now),
            begins_anew: true,
            waits_for_measures: false,
            is_late: false,
            part: None,
            shown_quality: None,
            frames_done: 0,
            feedback: None,
            split: None,
            inspector: Inspector::Off,
            screenshots: Vec::new(),
            capture,
            capture_ends: false,
            #[cfg(feature = "shader-compiler")]
            shaders: ShaderReload::start(),
            panel_picture: PanelPicture::default(),
            repaint_at: None,
            dirty: true,
            has_new_picture: false,
            shown_at: now,
            hidden: false,
            size_px: [size.width, size.height],
            asked_size_px: None,
            no_area: false,
            quit: false,
            has_scene: false,
            titled: now,
            settings,
            presenter,
        })
    }

    /// Ends everything on the device.
    ///
    /// # Errors
    /// [`Error::Validation`] when the layers reported anything, the end included.
    pub fn close(mut self) -> Result<()> {
        self.panel_picture.textures.clear();
        let log = self.presenter.gpu().validation_log();
        // The surface goes before its window.
        let Self { presenter, stage, panel, window, .. } = self;
        drop(stage);
        drop(presenter);
        drop(panel);
        drop(window);
        log.check()
    }

    /// Looks at what goes on, and begins what can begin; never waits for a frame.
    ///
    /// # Errors
    /// What nothing can be done about: the device is lost, the first scene cannot be loaded.
    pub fn turn(&mut self) -> Result<Pace> {
        if self.quit || interrupt::requested() {
            return Ok(Pace::Quit);
        }
        self.take_scene()?;
        self.light_anew()?;
        #[cfg(feature = "shader-compiler")]
        self.take_shaders()?;
        // A frame that cannot begin yet is not left out.
        let between_frames = self.advance()? && !self.waits_for_measures;
        self.run_script(between_frames)?;
        self.pass_time()?;
        self.show_title();
        if self.hidden || self.window_px().contains(&0) {
            return self.stay_hidden();
        }
        if between_frames && self.plays() {
            // The next frame begins at once.
            self.take_screenshots(true)?;
        }
        self.watch()?;
        if between_frames {
            self.take_screenshots(false)?;
        }
        let renders = !between_frames && self.is_rendering() || self.begin_next()?;
        if !renders {
            self.take_screenshots(true)?;
        }
        self.show()?;
        Ok(Pace::In(self.pause()))
    }

    fn is_rendering(&self) -> bool {
        self.stage.as_ref().is_some_and(|stage| stage.running().is_some())
    }

    /// Nobody sees the window: nothing is rendered, and for screenshots the last picture must do.
    fn stay_hidden(&mut self) -> Result<Pace> {
        if let Some(stage) = &mut self.stage {
            stage.abandon()?;
        }
        (self.begins_anew, self.dirty, self.waits_for_measures) = (true, true, false);
        for shot in std::mem::take(&mut self.screenshots) {
            self.take_screenshot(shot.name.as_deref())?;
        }
        Ok(Pace::In(IDLE))
    }

    /// How long nothing has to be looked at.
    fn pause(&self) -> Duration {
        let idle = 10 * IDLE;
        if self.is_rendering() || self.dirty || !self.script.is_over() {
            BUSY
        } else if self.waits_for_measures
            || self.keys.are_moving()
            || self.plays()
            || self.sun_speed != 0.0 && !self.clock.paused
        {
            MOVING
        } else if self.loading.is_some() || !self.refinement.has_picture() || !self.refinement.is_full(&self.plan()) {
            IDLE
        } else {
            self.repaint_at.map_or(idle, |at| at.saturating_duration_since(Instant::now()).min(idle))
        }
    }

    /// Whether the window has the size that it was asked to have.
    fn has_asked_size(&self) -> bool {
        self.asked_size_px.is_none_or(|asked| asked == self.size_px)
    }

    /// Size of the window in pixels, 0 where it has no area.
    fn window_px(&self) -> [u32; 2] {
        if self.no_area { [0, 0] } else { self.size_px }
    }

    /// Does what the script has for this moment. It waits for scenes, for screenshots, and until what it did is shown.
    fn run_script(&mut self, between_frames: bool) -> Result<()> {
        let Some(opened) = self.opened else { return Ok(()) };
        while let Some(action) = self.script.next_timed(opened.elapsed()) {
            log::debug!("{:.1} s: {action:?}", opened.elapsed().as_secs_f64());
            let shots = self.screenshots.len();
            self.act(action)?;
            // It is a moment that was asked for.
            self.screenshots[shots..]
                .iter_mut()
                .filter(|shot| shot.due == Due::Settled)
                .for_each(|shot| shot.due = Due::Soon);
        }
        // What is not rendered because something may still move is not left out.
        let waits = !self.plays() && self.refinement.next(&self.plan(), Instant::now()) == Next::Wait;
        let is_shown = !self.dirty && self.has_asked_size() || self.hidden || self.window_px().contains(&0);
        let is_busy = !between_frames || waits || !is_shown && self.frame_seen.elapsed() < SCRIPT_PATIENCE;
        if is_busy || self.loading.is_some() || !self.screenshots.is_empty() {
            return Ok(());
        }
        while let Some(action) = self.script.next(self.frame) {
            log::debug!("frame {}: {action:?}", self.frame);
            self.act(action)?;
            if self.loading.is_some() || !self.screenshots.is_empty() {
                break;
            }
        }
        self.frame += 1;
        self.frame_seen = Instant::now();
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
        }
        let time = if self.clock.paused { SINGLE_STEP_S * self.clock.steps as f32 } else { seconds };
        self.clock.steps = 0;
        if self.plays() && !self.is_scripted || self.clock.paused && self.scene_moves() {
            self.moment_s += f64::from(time);
        }
        let [azimuth, elevation] = self.keys.sun_deg(seconds);
        self.turn_sun([azimuth + self.sun_speed * time, elevation]);
        let at_rest = azimuth == 0.0 && elevation == 0.0 && self.sun_speed == 0.0;
        // The device has the lights of the last frame.
        let is_shown = !self.suns.are_changed();
        if at_rest && is_shown && self.sun_turned_deg > FAR_TURN_DEG {
            self.sun_turned_deg = 0.0;
            self.stage.iter_mut().for_each(Stage::forget_measures);
            self.begins_anew = true;
        }
        Ok(())
    }

    fn scene_moves(&self) -> bool {
        self.stage.as_ref().is_some_and(Stage::moves)
    }

    /// Whether the scene moves by itself.
    fn plays(&self) -> bool {
        !self.clock.paused && self.scene_moves()
    }

    fn turn_sun(&mut self, [azimuth, elevation]: [f32; 2]) {
        if self.suns.turn_deg(azimuth, elevation) {
            self.sun_turned_deg += azimuth.abs() + elevation.abs();
        }
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
        fixed_scale(self.settings.window.render_scale).is_none()
    }
}
