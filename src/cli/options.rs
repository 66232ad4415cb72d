//! The options of the command line in their groups, and how each group overrides the settings.

use std::path::PathBuf;

use clap::ArgAction;

use super::Verbosity;
use crate::settings::{
    Build, Center, Exposure, Filter, Levels, LightSet, LightingMode, Lobe, PresentMode, Rays, RenderScale, Reservoir,
    Scatter, Settings, ShadowPoints, Size, SunPlace, Switch, Technique, View,
};

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Run")]
pub(super) struct RunArgs {
    /// glTF or GLB file to render [default: the built-in scene]
    pub scene: Option<PathBuf>,
    /// Read settings from a TOML or .json file; its keys are the long options, which override it
    #[arg(long, value_name = "FILE")]
    pub settings: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Run")]
pub(super) struct FrameArgs {
    /// Render without a window; needs no display
    #[arg(long)]
    pub headless: bool,
    /// Measured frames, 1 or more [default: 1]
    #[arg(long, value_name = "N")]
    pub frames: Option<u32>,
    /// Frames rendered before the measured ones [default: 0]
    #[arg(long, value_name = "N")]
    pub warmup: Option<u32>,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Picture")]
pub(super) struct PictureArgs {
    /// Size in pixels [default: 1280x720]
    #[arg(long, value_name = "WxH")]
    pub size: Option<Size>,
    /// Camera of the scene, by name or by index from 0, or a place and a view as the window saves them: X,Y,Z,AZIMUTH,HEIGHT,YFOV
    /// in metres and degrees [default: the first, or one inside a room and outside anything else]
    #[arg(long, value_name = "NAME|INDEX|PLACE")]
    pub camera: Option<String>,
    /// Where the scene's first directional light stands, in degrees: 0 is along -z and 90 along x; height above the horizon
    /// [default: as in the scene]
    #[arg(long, value_name = "AZIMUTH,HEIGHT", allow_hyphen_values = true)]
    pub sun: Option<SunPlace>,
    /// Factor on the radiance in PNG pictures, above 0, or `auto` [default: auto]
    #[arg(long, value_name = "auto|FACTOR", allow_negative_numbers = true)]
    pub exposure: Option<Exposure>,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Picture")]
pub(super) struct ViewArgs {
    /// What the picture shows: final, albedo, normal, depth, direct, indirect, shadow-ratio, shadow-ratio-filtered,
    /// selected-level, overdraw, light-count, level-weights or vpls [default: final]
    #[arg(long, value_enum, hide_possible_values = true, value_name = "NAME")]
    pub view: Option<View>,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Method")]
pub(super) struct TechniqueArgs {
    /// The lighting grid hierarchy, direct light alone, or a reference: every light at every pixel, or path tracing
    /// [default: lgh]
    #[arg(long, value_enum, hide_possible_values = true, value_name = "lgh|direct|brute-force|path-trace")]
    pub technique: Option<Technique>,
    /// Paths per pixel of a path-traced frame, 1 or more [default: 16]
    #[arg(long, value_name = "N")]
    pub samples: Option<u32>,
    /// Mean of this many frames with fresh seeds and sub-pixel jitter, 1 or more [default: 1]
    #[arg(long, value_name = "N")]
    pub accumulate: Option<u32>,
    /// Direct light [default: on]
    #[arg(long, value_enum, hide_possible_values = true, value_name = "on|off")]
    pub direct: Option<Switch>,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Method")]
pub(super) struct MethodArgs {
    /// Lights of the hierarchy: traced virtual point lights, the scene's point lights, or both [default: vpl]
    #[arg(long, value_enum, hide_possible_values = true, value_name = "vpl|scene|both")]
    pub lights: Option<LightSet>,
    /// Virtual point lights, about this many, 1 or more [default: 100000]
    #[arg(long, value_name = "N")]
    pub vpls: Option<u32>,
    /// Diffuse bounces of a light path, at most this many, 1 to 64 [default: 3]
    #[arg(long, value_name = "N")]
    pub bounces: Option<u32>,
    /// Top level of the hierarchy, 2 to 10, or `auto` [default: auto]
    #[arg(long, value_name = "auto|N")]
    pub levels: Option<Levels>,
    /// Blending radius of a level, in cells of that level, above 0 [default: 1]
    #[arg(long, value_name = "CELLS", allow_negative_numbers = true)]
    pub alpha: Option<f32>,
    /// How a grid light sends out its flux [default: mixture]
    #[arg(long, value_enum, hide_possible_values = true, value_name = "mixture|clamped-normal|sh1|sh1-nonlinear")]
    pub lobe: Option<Lobe>,
    /// Where a grid light is: the mean of its lights by luminance, or each counting the same [default: intensity]
    #[arg(long, value_enum, hide_possible_values = true, value_name = "intensity|uniform")]
    pub center: Option<Center>,
    /// First level that lights: 0 the lights themselves, 1 the finest grid [default: 1]
    #[arg(long, value_name = "0|1")]
    pub first_level: Option<u32>,
    /// Side of the interleaving pattern, in pixels, 1, 2 or 4 [default: 1]
    #[arg(long, value_name = "1|2|4")]
    pub interleave: Option<u32>,
    /// How the coarse levels are built: from the level below, from the finest level, or from all lights
    /// [default: cascade]
    #[arg(long, value_enum, hide_possible_values = true, value_name = "cascade|gather|scatter")]
    pub build: Option<Build>,
    /// How lights are summed into the finest grid: listed by cell, or by atomic additions [default: sorted, but
    /// atomic where very many lights share a cell]
    #[arg(long, value_enum, hide_possible_values = true, value_name = "sorted|atomic")]
    pub scatter: Option<Scatter>,
    /// Singularity clamp, a fraction of the scene radius, 0 or above; 0 is the reference [default: 0.01]
    #[arg(long, value_name = "FRACTION", allow_negative_numbers = true)]
    pub clamp: Option<f32>,
    /// About the longest time of one submission to the device, above 0: frames are split between passes, reference
    /// techniques between parts of the picture [default: 200]
    #[arg(long, value_name = "MS", allow_negative_numbers = true)]
    pub max_submit_ms: Option<f32>,
    /// Seed of every random number, 0 to 4294967295 [default: 1]
    #[arg(long, value_name = "N")]
    pub seed: Option<u32>,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Shadows")]
pub(super) struct ShadowArgs {
    /// Shadow rays per pixel, 0 to 16; 0 is no indirect shadows [default: 4]
    #[arg(long, value_name = "K")]
    pub shadow_samples: Option<u32>,
    /// Shadows of the indirect light [default: on]
    #[arg(long, value_enum, hide_possible_values = true, value_name = "on|off")]
    pub shadows: Option<Switch>,
    /// First level whose lights get shadow rays, 0 to 10 [default: 1]
    #[arg(long, value_name = "L")]
    pub shadow_from: Option<u32>,

    /// Where a shadow ray ends: on a finer light that the chosen one is made of, or jittered about the chosen
    /// one by its deviation as in the paper [default: descent]
    #[arg(long, value_enum, hide_possible_values = true, value_name = "descent|deviation")]
    pub shadow_points: Option<ShadowPoints>,
    /// How lights reach the pixels: gathered by tiles of pixels, or drawn as volumes [default: gather, volumes with
    /// --reservoir race or lock]
    #[arg(long, value_enum, hide_possible_values = true, value_name = "volumes|gather")]
    pub lighting: Option<LightingMode>,
    /// Reservoir update; gathering knows `exact` only [default: exact; for volumes on a device without 64-bit
    /// atomics lock]
    #[arg(long, value_enum, hide_possible_values = true, value_name = "race|lock|exact")]
    pub reservoir: Option<Reservoir>,
    /// What traces rays of any kind: the BVH in shaders, or the device's acceleration structures by ray queries
    /// [default: bvh]
    #[arg(long, value_enum, hide_possible_values = true, value_name = "bvh|query")]
    pub rays: Option<Rays>,
    /// Filter of the shadow estimates [default: atrous]
    #[arg(long, value_enum, hide_possible_values = true, value_name = "atrous|none")]
    pub filter: Option<Filter>,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Device")]
pub(super) struct DeviceArgs {
    /// Device, by its index in --list-gpus or by a part of its name [default: the most capable]
    #[arg(long, value_name = "INDEX|NAME")]
    pub gpu: Option<String>,
    /// Run under the Vulkan validation layers; any message is a failure (exit 4)
    #[arg(long)]
    pub validation: bool,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Device")]
pub(super) struct ListArgs {
    /// List the devices, with each optional feature found or missing, and stop
    #[arg(long)]
    pub list_gpus: bool,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Window")]
pub(super) struct WindowArgs {
    /// How the window's pictures take turns: each waits for the display, the newest is taken, at once, or waiting
    /// unless late [default: fifo]
    #[arg(long, value_enum, hide_possible_values = true, value_name = "fifo|mailbox|immediate|fifo-relaxed")]
    pub present_mode: Option<PresentMode>,
    /// Edge of the rendered picture as a fraction of the window's, 0.05 to 1, or `auto`: 1, but on a CPU driver what
    /// holds about 10 frames per second [default: auto]
    #[arg(long, value_name = "auto|F", allow_negative_numbers = true)]
    pub render_scale: Option<RenderScale>,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Window")]
pub(super) struct ScriptArgs {
    /// Do what the file says, frame by frame (docs/window.md)
    #[arg(long, value_name = "FILE")]
    pub script: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Output")]
pub(super) struct OutputArgs {
    /// Write the last frame: .exr (linear radiance) or .png (exposed, tone-mapped)
    #[arg(long, value_name = "PATH")]
    pub output: Option<PathBuf>,
    /// Write the timings: .json (statistics, settings, counts) or .csv (every frame and pass)
    #[arg(long, value_name = "PATH")]
    pub timings: Option<PathBuf>,
    /// Write every intermediate of the last frame into this new or empty folder (docs/dumps.md)
    #[arg(long, value_name = "DIR")]
    pub dump: Option<PathBuf>,
    /// Let RenderDoc capture this frame, counted from 0, into gridlight_*.rdc in the working directory
    #[arg(long, value_name = "N")]
    pub renderdoc_frame: Option<u32>,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Diagnostics")]
pub(super) struct GraphArgs {
    /// Print the frame graph (Graphviz) on stdout and stop
    #[arg(long)]
    pub print_graph: bool,
    /// Print the version
    #[arg(short = 'V', long, action = ArgAction::Version)]
    pub version: Option<bool>,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Diagnostics")]
pub(super) struct DiagnosticsArgs {
    /// Say more on stderr; repeat for still more
    #[arg(short, long, action = ArgAction::Count, conflicts_with = "quiet")]
    pub verbose: u8,
    /// Print no table and no progress, errors only
    #[arg(long)]
    pub quiet: bool,
    /// Print this help
    #[arg(short, long, action = ArgAction::Help)]
    pub help: Option<bool>,
}

impl RunArgs {
    pub fn apply(self, settings: &mut Settings) {
        settings.scene = self.scene.or(settings.scene.take());
    }
}

impl FrameArgs {
    pub fn apply(self, settings: &mut Settings) {
        settings.headless |= self.headless;
        set(&mut settings.frames, self.frames);
        set(&mut settings.warmup, self.warmup);
    }
}

impl PictureArgs {
    pub fn apply(self, settings: &mut Settings) {
        set(&mut settings.size, self.size);
        settings.camera = self.camera.or(settings.camera.take());
        settings.sun = self.sun.or(settings.sun);
        set(&mut settings.exposure, self.exposure);
    }
}

impl ViewArgs {
    pub fn apply(self, settings: &mut Settings) {
        set(&mut settings.view, self.view);
    }
}

impl TechniqueArgs {
    pub fn apply(self, settings: &mut Settings) {
        set(&mut settings.technique, self.technique);
        set(&mut settings.samples, self.samples);
        set(&mut settings.accumulate, self.accumulate);
        set(&mut settings.direct, self.direct);
    }
}

impl MethodArgs {
    pub fn apply(self, settings: &mut Settings) {
        set(&mut settings.lights, self.lights);
        set(&mut settings.vpls, self.vpls);
        set(&mut settings.bounces, self.bounces);
        set(&mut settings.levels, self.levels);
        set(&mut settings.alpha, self.alpha);
        set(&mut settings.lobe, self.lobe);
        set(&mut settings.center, self.center);
        set(&mut settings.first_level, self.first_level);
        set(&mut settings.interleave, self.interleave);
        set(&mut settings.build, self.build);
        settings.scatter = self.scatter.or(settings.scatter);
        set(&mut settings.clamp, self.clamp);
        set(&mut settings.max_submit_ms, self.max_submit_ms);
        set(&mut settings.seed, self.seed);
    }
}

impl ShadowArgs {
    pub fn apply(self, settings: &mut Settings) {
        set(&mut settings.shadow_samples, self.shadow_samples);
        set(&mut settings.shadows, self.shadows);
        set(&mut settings.shadow_from, self.shadow_from);
        set(&mut settings.shadow_points, self.shadow_points);
        settings.lighting = self.lighting.or(settings.lighting);
        settings.reservoir = self.reservoir.or(settings.reservoir);
        set(&mut settings.rays, self.rays);
        set(&mut settings.filter, self.filter);
    }
}

impl DeviceArgs {
    pub fn apply(self, settings: &mut Settings) {
        settings.gpu = self.gpu.or(settings.gpu.take());
        settings.validation |= self.validation;
    }
}

impl WindowArgs {
    pub fn apply(self, settings: &mut Settings) {
        set(&mut settings.present_mode, self.present_mode);
        set(&mut settings.render_scale, self.render_scale);
    }
}

impl DiagnosticsArgs {
    pub fn verbosity(&self) -> Verbosity {
        Verbosity { verbose: self.verbose, quiet: self.quiet }
    }
}

impl OutputArgs {
    pub fn apply(self, settings: &mut Settings) {
        settings.output = self.output.or(settings.output.take());
        settings.timings = self.timings.or(settings.timings.take());
        settings.dump = self.dump.or(settings.dump.take());
        settings.renderdoc_frame = self.renderdoc_frame.or(settings.renderdoc_frame);
    }
}

fn set<T>(slot: &mut T, given: Option<T>) {
    if let Some(value) = given {
        *slot = value;
    }
}
