//! What is rendered for the window: the scene on the device, its compiled frames for each quality, and the frame that is
//! under way.

mod adapt;

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

pub use self::adapt::{Adapted, Patience};
use super::loader::Loaded;
use super::measuring::{Measured, Measuring};
use super::quality::Quality;
use crate::Result;
use crate::app::lighting;
use crate::gpu::{FrameResult, Gpu, PacedFrame};
use crate::passes::present::WindowFormat;
use crate::renderer::{FrameFeedback, Fresh, Job, Renderer, Show, UploadedScene};
use crate::scene::{Camera, Scene};
use crate::scene_mover::SceneMover;
use crate::settings::{EnvironmentSettings, Settings, SunPlace};
use crate::shared::PunctualLight;

/// What a frame must have been compiled for.
pub struct Wanted<'a> {
    /// Settings of the frame, or of the right side of a split view.
    pub settings: &'a Settings,
    /// Settings of the left side of a split view.
    pub held: Option<&'a Settings>,
    /// Where it is seen from.
    pub camera: &'a Camera,
    /// Whether a pixel is inspected.
    pub inspects: bool,
}

/// What says how a scene that moves is posed.
#[derive(Clone, Copy, PartialEq)]
struct Posed {
    /// Of its animation.
    moment_s: f64,
    /// Where its sun is held.
    held: Option<SunPlace>,
    /// How far its sky is turned.
    turn_deg: f32,
}

/// One frame to be rendered.
pub struct Request<'a> {
    /// What it is compiled for.
    pub wanted: Wanted<'a>,
    /// Directional and spot lights, when they have changed.
    pub lights: Option<Vec<PunctualLight>>,
    /// Number among the accumulated frames.
    pub number: u32,
    /// Point of the window that is inspected, from the top left corner, 0 to 1.
    pub inspected: Option<[f32; 2]>,
    /// Goes on with the rounds of the frame before, if that was stopped.
    pub goes_on: bool,
}

/// What a side of a frame that has completed took and told.
pub struct Done {
    /// Times.
    pub result: FrameResult,
    /// What the host learns of every frame.
    pub feedback: Option<FrameFeedback>,
}

/// A frame that has completed, and the left side of its split view.
pub struct DoneFrame {
    /// How good it is.
    pub quality: Quality,
    /// The frame, or its right side.
    pub main: Option<Done>,
    /// The left side.
    pub held: Option<Done>,
    /// Rounds done and all of them, of a reference that was stopped on either side.
    pub part: Option<[u32; 2]>,
}

/// A compiled frame, and what shows its picture.
pub struct Side {
    /// The frame.
    pub renderer: Renderer,
    /// What brings its picture into the window.
    pub show: Show,
    /// What the renderer was measured with; `None` once that counts no longer.
    measured_with: Option<Settings>,
    /// The round that a frame which was stopped goes on with.
    next_round: Option<u32>,
    /// Frames with samples of their own so far.
    frames: u32,
}

/// The compiled frames of one quality.
pub struct FrameSet {
    /// The frame, or the right side of a split view.
    pub main: Side,
    /// The left side.
    pub held: Option<Side>,
}

/// A side of a split view; without one there is only the right side, which is then the whole window.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Which {
    Held,
    Main,
}

/// A frame under way.
struct Running {
    quality: Quality,
    since: Instant,
    which: Which,
    frame: PacedFrame,
    /// Sides that come after the one that is rendered.
    later: Vec<Which>,
    done: DoneFrame,
}

/// Everything that renders. Fields are dropped in order.
pub struct Stage {
    running: Option<Running>,
    sets: [Option<FrameSet>; Quality::COUNT],
    /// Frames that are still shown, of which others have taken the place.
    outgoing: Option<FrameSet>,
    /// Whose picture is shown; `None` is that of the outgoing ones, if there are any.
    shown: Option<Quality>,
    /// A measurement under way, and the last ones.
    measuring: Option<Measuring>,
    measured: Vec<Measured>,
    uploaded: UploadedScene,
    mover: SceneMover,
    /// Shared with a measurement under way only.
    scene: Arc<Scene>,
    /// As what it was last put on the device; `None` before the first time.
    posed: Option<Posed>,
    window: WindowFormat,
    gpu: Arc<Gpu>,
}

impl Stage {
    /// Puts a scene on the device and compiles a first frame of it. What `before` shows stays in sight until that is done;
    /// when this fails nothing has changed.
    ///
    /// # Errors
    /// When the scene does not fit the device or the settings.
    pub fn new(
        gpu: &Arc<Gpu>,
        loaded: Loaded,
        (quality, wanted): (Quality, &Wanted<'_>),
        window: WindowFormat,
        before: &mut Option<Self>,
    ) -> Result<Self> {
        let uploaded = UploadedScene::upload(gpu, &loaded.scene, &loaded.ready, wanted.settings.tracing.rays)?;
        let mut stage = Self {
            running: None,
            sets: [const { None }; Quality::COUNT],
            outgoing: None,
            shown: None,
            measuring: None,
            measured: Vec::new(),
            mover: SceneMover::new(gpu, &loaded.scene, &uploaded)?,
            uploaded,
            scene: Arc::new(loaded.scene),
            posed: None,
            window,
            gpu: Arc::clone(gpu),
        };
        stage.adapt(quality, wanted, Patience::Waits)?;
        stage.outgoing = before.take().and_then(Self::into_shown);
        Ok(stage)
    }

    /// The frames whose picture is shown.
    fn into_shown(mut self) -> Option<FrameSet> {
        match self.shown {
            Some(quality) => self.sets[quality.index()].take(),
            None => self.outgoing.take(),
        }
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Whether anything of the scene moves by itself.
    pub fn moves(&self) -> bool {
        self.scene.motion.moves().any()
    }

    /// How long the animation lasts, in seconds; `None` where nothing moves.
    pub fn duration_s(&self) -> Option<f64> {
        self.moves().then(|| self.scene.motion.duration_s()).filter(|duration_s| *duration_s > 0.0)
    }

    /// Puts the scene where it is at a moment, under the sky of its sun then, or of one that is `held` in a place; no frame is
    /// under way. Waits for the device, where anything has moved. Whether lights have.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn pose(&mut self, moment_s: f64, held: Option<SunPlace>, around: &EnvironmentSettings) -> Result<bool> {
        let posed = Posed { moment_s, held, turn_deg: around.turn_deg };
        // What is being measured is the scene as it was.
        if !self.moves() || self.posed == Some(posed) || self.measuring.is_some() {
            return Ok(false);
        }
        let Some(scene) = Arc::get_mut(&mut self.scene) else { return Ok(false) };
        self.posed = Some(posed);
        scene.pose_without_vertices(moment_s);
        let has_other_sky = lighting::follow(scene, held, around);
        self.mover.follow(&mut self.uploaded, scene)?;
        let moves = self.scene.motion.moves();
        if moves.geometry || moves.lights || has_other_sky {
            let sides = self.all_sets_mut().flat_map(|set| set.held.iter_mut().chain([&mut set.main]));
            sides.for_each(|side| side.renderer.expect_another_scene());
        }
        Ok(moves.lights)
    }

    /// The scene as uploaded.
    pub fn uploaded(&self) -> &UploadedScene {
        &self.uploaded
    }

    /// The frames whose picture is shown, once there is one.
    pub fn shown(&self) -> Option<&FrameSet> {
        self.shown.map_or(self.outgoing.as_ref(), |quality| self.sets[quality.index()].as_ref())
    }

    /// The same, to show them.
    pub fn shown_mut(&mut self) -> Option<&mut FrameSet> {
        self.shown.map_or(self.outgoing.as_mut(), |quality| self.sets[quality.index()].as_mut())
    }

    /// How good the picture is that is shown; `None` where it is of something else.
    pub fn shown_quality(&self) -> Option<Quality> {
        self.shown
    }

    /// The frame that is under way, and for how long it has been.
    pub fn running(&self) -> Option<(Quality, Duration)> {
        self.running.as_ref().map(|running| (running.quality, running.since.elapsed()))
    }

    /// How many frames of the window are not done.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn shows_under_way(&mut self) -> Result<usize> {
        self.all_sets_mut().try_fold(0, |sum, set| Ok(sum + set.main.show.count_under_way()?))
    }

    fn all_sets_mut(&mut self) -> impl Iterator<Item = &mut FrameSet> {
        self.sets.iter_mut().flatten().chain(&mut self.outgoing)
    }

    /// The window's images have another format.
    ///
    /// # Errors
    /// Device errors.
    pub fn set_window(&mut self, window: WindowFormat) -> Result<()> {
        self.window = window;
        let gpu = Arc::clone(&self.gpu);
        for set in self.all_sets_mut() {
            for side in set.held.iter_mut().chain([&mut set.main]) {
                side.show = Show::new(&gpu, side.renderer.shown_picture(), window, side.show.part())?;
            }
        }
        Ok(())
    }

    /// Begins a frame, which must have been adapted to what is wanted; no other is under way.
    ///
    /// # Errors
    /// When the device is lost, and those of [`Renderer::update_lights`].
    pub fn begin(&mut self, quality: Quality, request: &Request<'_>) -> Result<()> {
        if request.lights.is_some() {
            let sides = self.all_sets_mut().flat_map(|set| set.held.iter_mut().chain([&mut set.main]));
            sides.for_each(|side| side.renderer.expect_another_scene());
        }
        let Some(set) = &mut self.sets[quality.index()] else { return Ok(()) };
        let settings = [request.wanted.held, Some(request.wanted.settings)];
        let goes_on = request.goes_on && [Which::Held, Which::Main].into_iter().any(|which| set.is_stopped(which));
        let mut sides = Vec::new();
        for (which, settings) in [Which::Held, Which::Main].into_iter().zip(settings) {
            let (Some(side), Some(settings)) = (set.side(which), settings) else { continue };
            side.next_round = side.next_round.filter(|_| goes_on);
            if goes_on && side.next_round.is_none() {
                continue;
            }
            side.prepare(&Job::new(&self.gpu, &self.uploaded, request.wanted.camera, settings), request);
            // The lights are the scene's: written by the first frame they are there for both.
            if let Some(lights) = request.lights.as_deref().filter(|_| sides.is_empty()) {
                side.renderer.update_lights(lights)?;
            }
            sides.push(which);
        }
        sides.reverse();
        let Some((which, side)) = sides.pop().and_then(|which| Some((which, set.side(which)?))) else { return Ok(()) };
        let frame = side.begin()?;
        let done = DoneFrame { quality, main: None, held: None, part: None };
        self.running = Some(Running { quality, since: Instant::now(), which, frame, later: sides, done });
        Ok(())
    }

    /// Goes on with the frame under way, if there is one, in pieces of about `longest_ms`; gives it once it has completed and
    /// is the one to be shown. With `Break` a reference stops at the end of its round.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn advance(&mut self, longest_ms: f64, flow: ControlFlow<()>) -> Result<Option<DoneFrame>> {
        let Some(running) = &mut self.running else { return Ok(None) };
        let Some(set) = &mut self.sets[running.quality.index()] else { return Ok(None) };
        let Some(side) = set.side(running.which) else { return Ok(None) };
        let Some(stepped) = side.renderer.advance(&mut running.frame, longest_ms, flow)? else { return Ok(None) };
        side.next_round = (stepped.rounds_done < stepped.rounds).then_some(stepped.rounds_done);
        if side.next_round.is_some() {
            running.done.part = Some([stepped.rounds_done, stepped.rounds]);
        }
        let done = Done { feedback: side.renderer.feedback(&stepped.times), result: stepped.times };
        match running.which {
            Which::Held => running.done.held = Some(done),
            Which::Main => running.done.main = Some(done),
        }
        if let Some((which, side)) = running.later.pop().and_then(|which| Some((which, set.side(which)?))) {
            (running.which, running.frame) = (which, side.begin()?);
            return Ok(None);
        }
        self.shown = Some(running.quality);
        self.outgoing = None;
        Ok(self.running.take().map(|running| running.done))
    }

    /// Ends the frame under way, if there is one; what is shown stays.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn abandon(&mut self) -> Result<()> {
        let Some(Running { quality, which, frame, .. }) = self.running.take() else { return Ok(()) };
        let Some(set) = &mut self.sets[quality.index()] else { return Ok(()) };
        for which in [Which::Held, Which::Main] {
            set.side(which).into_iter().for_each(|side| side.next_round = None);
        }
        set.side(which).map_or(Ok(()), |side| side.renderer.abandon(frame))
    }
}

impl FrameSet {
    /// Whether a side was stopped before its reference was whole.
    fn is_stopped(&mut self, which: Which) -> bool {
        self.side(which).is_some_and(|side| side.next_round.is_some())
    }

    fn side(&mut self, which: Which) -> Option<&mut Side> {
        match which {
            Which::Held => self.held.as_mut(),
            Which::Main => Some(&mut self.main),
        }
    }
}

impl Side {
    fn prepare(&mut self, job: &Job<'_>, request: &Request<'_>) {
        self.renderer.update(job);
        let frame = &self.renderer.shapes().frame;
        if frame.accumulate {
            self.renderer.set_accumulated_frame(request.number, Fresh::All);
        } else if frame.surface_motion.is_some() {
            // What is taken over from earlier frames calms only samples that are others in every frame.
            self.frames = self.frames.wrapping_add(1);
            self.renderer.set_accumulated_frame(self.frames, Fresh::Shadows);
        }
        if let Some([x, y]) = request.inspected {
            let pixel = |at: f32, edge: u32| ((at * edge as f32) as u32).min(edge.saturating_sub(1));
            let size = job.settings.picture.size;
            self.renderer.inspect_pixel([pixel(x, size.width), pixel(y, size.height)]);
        }
    }

    fn begin(&mut self) -> Result<PacedFrame> {
        self.renderer.begin_paced(self.next_round.take().unwrap_or(0))
    }
}
