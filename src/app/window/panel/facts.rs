//! What the panel shows of everything else.

use std::path::PathBuf;

use super::history::History;
use crate::app::window::quality::Quality;
use crate::gpu::MemoryUse;
use crate::renderer::FrameFeedback;
use crate::settings::{Settings, Size};
use crate::techniques::Shapes;

/// What is known when a frame begins.
pub struct Facts<'a> {
    /// Settings in use.
    pub settings: &'a Settings,
    /// Size of the picture.
    pub picture: Size,
    /// Size of the window.
    pub window_px: [u32; 2],
    /// Times.
    pub history: &'a History,
    /// Names that the times belong to.
    pub pass_names: Vec<String>,
    /// Memory of the frame.
    pub memory: MemoryUse,
    /// Memory reserved from the driver.
    pub reserved_bytes: u64,
    /// Name of the device.
    pub device: &'a str,
    /// Scenes that were opened before, the last one first.
    pub recent: &'a [PathBuf],
    /// Names of the scene's cameras.
    pub cameras: Vec<&'a str>,
    /// How far a scene is loaded.
    pub loading: Option<String>,
    /// How far the picture has come.
    pub progress: Progress,
    /// Time stands still.
    pub paused: bool,
    /// Where in its animation the scene is, and how long that lasts, in seconds; `None` where nothing moves.
    pub time_s: Option<[f64; 2]>,
    /// Azimuth and elevation of the sun.
    pub sun_deg: Option<[f32; 2]>,
    /// Degrees in a second.
    pub sun_speed: f32,
    /// The picture's size follows the time that frames take.
    pub scale_is_chosen: bool,
    /// The frame, or the right side of a split view.
    pub main: SideFacts<'a>,
    /// The left side of a split view.
    pub held: Option<HeldFacts<'a>>,
    /// A pixel is inspected.
    pub inspects: bool,
}

/// How far the picture has come.
#[derive(Clone, Copy)]
pub struct Progress {
    /// How good the picture is that is shown; `None` where it is of something else.
    pub quality: Option<Quality>,
    /// Frames in the mean.
    pub accumulated: u32,
    /// Frames that it will be of.
    pub goal: u32,
    /// There will be no better picture.
    pub is_done: bool,
    /// Rounds done and all of them, of a reference that shows what it has.
    pub part: Option<[u32; 2]>,
}

/// What is known of one side of the window.
pub struct SideFacts<'a> {
    /// Shapes of its frame, when one is compiled.
    pub shapes: Option<&'a Shapes>,
    /// What its last completed frame told.
    pub feedback: Option<&'a FrameFeedback>,
}

/// What is known of the left side of a split view.
pub struct HeldFacts<'a> {
    /// Its frame.
    pub side: SideFacts<'a>,
    /// Where it ends, from the left of the window, 0 to 1.
    pub divider: f32,
    /// Settings that differ, with the values on the left and on the right.
    pub differences: Vec<(String, [String; 2])>,
    /// Sum of its passes in the last frame.
    pub ms: f64,
}
