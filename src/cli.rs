//! The command line: what it accepts, and how it overrides a settings file.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::error::ErrorKind;
use clap::{ArgAction, Parser};

use crate::settings::{Build, Exposure, Filter, Levels, LightSet, Reservoir, Settings, ShadowPoints, Size, Technique};
use crate::{Error, Result};

const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), " (", env!("GRIDLIGHT_COMMIT"), ")");

/// How much is said on stderr and stdout.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Verbosity {
    /// How often `-v` was given.
    pub verbose: u8,
    /// `--quiet`: no table, no progress bars, errors only.
    pub quiet: bool,
}

/// What the command line asks for.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Render with these (valid) settings.
    Render {
        /// The settings: command line over file over defaults.
        settings: Box<Settings>,
        /// Print the frame graph of these settings instead of rendering.
        print_graph: bool,
        /// How much to say.
        verbosity: Verbosity,
    },
    /// List the Vulkan devices.
    ListGpus {
        /// How much to say.
        verbosity: Verbosity,
    },
    /// Print this text (help or version) on stdout.
    Show(String),
}

/// Render scenes lit by very many lights with the Lighting Grid Hierarchy on Vulkan.
#[derive(Debug, Parser)]
#[command(name = "gridlight", version = VERSION, args_override_self = true, max_term_width = 110)]
#[command(disable_help_flag = true, disable_version_flag = true)]
pub struct Args {
    #[command(flatten)]
    run: RunArgs,
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    method: MethodArgs,
    #[command(flatten)]
    shadows: ShadowArgs,
    #[command(flatten)]
    device: DeviceArgs,
    #[command(flatten)]
    output: OutputArgs,
    #[command(flatten)]
    diagnostics: DiagnosticsArgs,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Run")]
struct RunArgs {
    /// glTF or GLB file to render [default: the built-in scene]
    scene: Option<PathBuf>,
    /// Render without a window; needs no display
    #[arg(long)]
    headless: bool,
    /// Measured frames, 1 or more [default: 1]
    #[arg(long, value_name = "N")]
    frames: Option<u32>,
    /// Frames rendered before the measured ones [default: 0]
    #[arg(long, value_name = "N")]
    warmup: Option<u32>,
    /// Read settings from a TOML or .json file; its keys are the long options, which override it
    #[arg(long, value_name = "FILE")]
    settings: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Picture")]
struct PictureArgs {
    /// Size in pixels [default: 1280x720]
    #[arg(long, value_name = "WxH")]
    size: Option<Size>,
    /// Camera of the scene, by name or by index from 0 [default: the first, or one that frames the scene]
    #[arg(long, value_name = "NAME|INDEX")]
    camera: Option<String>,
    /// Factor on the radiance in PNG pictures, above 0, or `auto` [default: auto]
    #[arg(long, value_name = "auto|FACTOR", allow_negative_numbers = true)]
    exposure: Option<Exposure>,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Method")]
struct MethodArgs {
    /// Pipeline: the lighting grid hierarchy, or direct light alone [default: lgh]
    #[arg(long, value_enum, hide_possible_values = true, value_name = "lgh|direct")]
    technique: Option<Technique>,
    /// Lights of the hierarchy: traced virtual point lights, the scene's point lights, or both [default: vpl]
    #[arg(long, value_enum, hide_possible_values = true, value_name = "vpl|scene|both")]
    lights: Option<LightSet>,
    /// Virtual point lights, about this many, 1 or more [default: 100000]
    #[arg(long, value_name = "N")]
    vpls: Option<u32>,
    /// Diffuse bounces of a light path, at most this many, 1 to 64 [default: 3]
    #[arg(long, value_name = "N")]
    bounces: Option<u32>,
    /// Top level of the hierarchy, 2 to 10, or `auto` [default: auto]
    #[arg(long, value_name = "auto|N")]
    levels: Option<Levels>,
    /// Blending radius of a level, in cells of that level, above 0 [default: 1]
    #[arg(long, value_name = "CELLS", allow_negative_numbers = true)]
    alpha: Option<f32>,
    /// First level that lights: 0 the lights themselves, 1 the finest grid [default: 1]
    #[arg(long, value_name = "0|1")]
    first_level: Option<u32>,
    /// Side of the interleaving pattern, in pixels, 1, 2 or 4 [default: 1]
    #[arg(long, value_name = "1|2|4")]
    interleave: Option<u32>,
    /// How the coarse levels are built: from the finest level, or from all lights [default: gather]
    #[arg(long, value_enum, hide_possible_values = true, value_name = "gather|scatter")]
    build: Option<Build>,
    /// Singularity clamp, a fraction of the scene radius, 0 or above; 0 is the reference [default: 0.01]
    #[arg(long, value_name = "FRACTION", allow_negative_numbers = true)]
    clamp: Option<f32>,
    /// Seed of every random number, 0 to 4294967295 [default: 1]
    #[arg(long, value_name = "N")]
    seed: Option<u32>,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Shadows")]
struct ShadowArgs {
    /// Shadow rays per pixel, 0 to 16; 0 is no indirect shadows [default: 4]
    #[arg(long, value_name = "K")]
    shadow_samples: Option<u32>,
    /// First level whose lights get shadow rays, 0 to 10 [default: 2]
    #[arg(long, value_name = "L")]
    shadow_from: Option<u32>,

    /// Where a shadow ray ends: on a finer light that the chosen one is made of, or jittered about the chosen
    /// one by its deviation as in the paper [default: descent]
    #[arg(long, value_enum, hide_possible_values = true, value_name = "descent|deviation")]
    shadow_points: Option<ShadowPoints>,
    /// Reservoir update [default: exact where the device has 64-bit atomics, else lock]
    #[arg(long, value_enum, hide_possible_values = true, value_name = "race|lock|exact")]
    reservoir: Option<Reservoir>,
    /// Filter of the shadow estimates [default: atrous]
    #[arg(long, value_enum, hide_possible_values = true, value_name = "atrous|none")]
    filter: Option<Filter>,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Device")]
struct DeviceArgs {
    /// Device, by its index in --list-gpus or by a part of its name [default: the most capable]
    #[arg(long, value_name = "INDEX|NAME")]
    gpu: Option<String>,
    /// List the devices, with each optional feature found or missing, and stop
    #[arg(long)]
    list_gpus: bool,
    /// Run under the Vulkan validation layers; any message is a failure (exit 4)
    #[arg(long)]
    validation: bool,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Output")]
struct OutputArgs {
    /// Write the last frame: .exr (linear radiance) or .png (exposed, tone-mapped)
    #[arg(long, value_name = "PATH")]
    output: Option<PathBuf>,
    /// Write the timings: .json (statistics, settings, counts) or .csv (every frame and pass)
    #[arg(long, value_name = "PATH")]
    timings: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Diagnostics")]
struct DiagnosticsArgs {
    /// Print the frame graph (Graphviz) on stdout and stop
    #[arg(long)]
    print_graph: bool,
    /// Say more on stderr; repeat for still more
    #[arg(short, long, action = ArgAction::Count, conflicts_with = "quiet")]
    verbose: u8,
    /// Print no table and no progress, errors only
    #[arg(long)]
    quiet: bool,
    /// Print this help
    #[arg(short, long, action = ArgAction::Help)]
    help: Option<bool>,
    /// Print the version
    #[arg(short = 'V', long, action = ArgAction::Version)]
    version: Option<bool>,
}

/// Reads a command line, program name first, and the settings file it names.
///
/// # Errors
/// [`Error::Usage`] when it asks for something impossible, [`Error::File`] when the settings file
/// cannot be read. Help and version are no errors but [`Command::Show`].
pub fn parse<I>(args: I) -> Result<Command>
where
    I: IntoIterator,
    I::Item: Into<OsString> + Clone,
{
    match Args::try_parse_from(args) {
        Ok(args) => args.into_command(),
        Err(error) if matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) => {
            Ok(Command::Show(error.to_string()))
        }
        Err(error) => Err(Error::Usage(sentence(&error))),
    }
}

impl Args {
    fn into_command(self) -> Result<Command> {
        let verbosity = Verbosity { verbose: self.diagnostics.verbose, quiet: self.diagnostics.quiet };
        if self.device.list_gpus {
            return Ok(Command::ListGpus { verbosity });
        }
        let print_graph = self.diagnostics.print_graph;
        let settings = Box::new(self.into_settings()?);
        if !settings.headless && !print_graph {
            return Err(Error::Usage("there is no window yet: add --headless to render without one".to_owned()));
        }
        Ok(Command::Render { settings, print_graph, verbosity })
    }

    /// Command line over settings file over defaults, validated.
    fn into_settings(self) -> Result<Settings> {
        let file = self.run.settings.clone();
        let mut settings = file.as_deref().map_or_else(|| Ok(Settings::default()), Settings::read)?;
        self.run.apply(&mut settings);
        self.picture.apply(&mut settings);
        self.method.apply(&mut settings);
        self.shadows.apply(&mut settings);
        settings.gpu = self.device.gpu.or(settings.gpu);
        settings.validation |= self.device.validation;
        settings.output = self.output.output.or(settings.output);
        settings.timings = self.output.timings.or(settings.timings);
        if file.is_some() && file == settings.timings {
            return Err(Error::Usage("timings would overwrite the settings file: give another name".to_owned()));
        }
        settings.validate()?;
        Ok(settings)
    }
}

impl RunArgs {
    fn apply(self, settings: &mut Settings) {
        settings.scene = self.scene.or(settings.scene.take());
        settings.headless |= self.headless;
        set(&mut settings.frames, self.frames);
        set(&mut settings.warmup, self.warmup);
    }
}

impl PictureArgs {
    fn apply(self, settings: &mut Settings) {
        set(&mut settings.size, self.size);
        settings.camera = self.camera.or(settings.camera.take());
        set(&mut settings.exposure, self.exposure);
    }
}

impl MethodArgs {
    fn apply(self, settings: &mut Settings) {
        set(&mut settings.technique, self.technique);
        set(&mut settings.lights, self.lights);
        set(&mut settings.vpls, self.vpls);
        set(&mut settings.bounces, self.bounces);
        set(&mut settings.levels, self.levels);
        set(&mut settings.alpha, self.alpha);
        set(&mut settings.first_level, self.first_level);
        set(&mut settings.interleave, self.interleave);
        set(&mut settings.build, self.build);
        set(&mut settings.clamp, self.clamp);
        set(&mut settings.seed, self.seed);
    }
}

impl ShadowArgs {
    fn apply(self, settings: &mut Settings) {
        set(&mut settings.shadow_samples, self.shadow_samples);
        set(&mut settings.shadow_from, self.shadow_from);
        set(&mut settings.shadow_points, self.shadow_points);
        settings.reservoir = self.reservoir.or(settings.reservoir);
        set(&mut settings.filter, self.filter);
    }
}

fn set<T>(slot: &mut T, given: Option<T>) {
    if let Some(value) = given {
        *slot = value;
    }
}

/// clap's message as one sentence: without the usage line and the pointer to `--help`.
fn sentence(error: &clap::Error) -> String {
    let text = error.to_string();
    let text = text.split("Usage:").next().unwrap_or(&text);
    let text = text.split("For more information").next().unwrap_or(text);
    let words: Vec<_> = text.trim_start_matches("error:").split_whitespace().collect();
    words.join(" ").replace(" tip: ", "; ")
}

#[cfg(test)]
#[path = "cli_tests.rs"]
mod tests;
