//! The command line: what it accepts, and how it overrides a settings file.

mod commands;
mod compare_sequence;
mod complaints;
mod error_report;
mod every_view;
mod help;
mod options;
mod pages;

use std::ffi::OsString;
use std::path::PathBuf;

use clap::error::ErrorKind;
use clap::{CommandFactory, FromArgMatches, Parser};

use crate::settings::{
    DeviceSettings, EnvironmentSettings, LghSettings, ManyLightSettings, MotionSettings, OutputSettings,
    PathTraceSettings, PbgiSettings, PictureSettings, RenderSettings, RunSettings, SceneSettings, Settings,
    TracingSettings, WindowSettings,
};
use crate::{Error, Result, techniques};
use commands::Subcommand;
pub use commands::{CompareArgs, CompareKind, DiffDumpsArgs, SelftestArgs};
pub use compare_sequence::CompareSequenceArgs;
pub use error_report::{ErrorReportOptions, REPORT_FILES};
pub use help::{OptionHelp, option_help};
use options::{DiagnosticsArgs, FileArgs, GraphArgs, ListArgs, Overrides, ScriptArgs};

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
    /// Render one frame with each of these (valid) settings, which differ in their view and its file.
    RenderViews {
        /// The settings of each view.
        each: Vec<Settings>,
        /// How much to say.
        verbosity: Verbosity,
    },
    /// Open a window with these (valid) settings.
    Window {
        /// The settings: command line over file over defaults.
        settings: Box<Settings>,
        /// A file with actions to be done at certain frames.
        script: Option<PathBuf>,
        /// How much to say.
        verbosity: Verbosity,
    },
    /// List the Vulkan devices.
    ListGpus {
        /// How much to say.
        verbosity: Verbosity,
    },
    /// Compare two files.
    Compare(Box<CompareArgs>),
    /// Compare two sequences of pictures.
    CompareSequence(Box<CompareSequenceArgs>),
    /// Compare two dumps.
    DiffDumps(DiffDumpsArgs),
    /// Test a device.
    Selftest(SelftestArgs),
    /// Render in stages and split the error by cause.
    ErrorReport {
        /// The (valid) settings that the stages vary.
        settings: Box<Settings>,
        /// How much is rendered, and where the report goes.
        options: ErrorReportOptions,
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
#[command(args_conflicts_with_subcommands = true)]
pub struct Args {
    #[command(subcommand)]
    subcommand: Option<Subcommand>,
    #[command(flatten)]
    scene: Overrides<SceneSettings>,
    #[command(flatten)]
    motion: Overrides<MotionSettings>,
    #[command(flatten)]
    environment: Overrides<EnvironmentSettings>,
    #[command(flatten)]
    file: FileArgs,
    #[command(flatten)]
    run: Overrides<RunSettings>,
    #[command(flatten)]
    picture: Overrides<PictureSettings>,
    #[command(flatten)]
    render: Overrides<RenderSettings>,
    #[command(flatten)]
    pbgi: Overrides<PbgiSettings>,
    #[command(flatten)]
    path_trace: Overrides<PathTraceSettings>,
    #[command(flatten)]
    tracing: Overrides<TracingSettings>,
    #[command(flatten)]
    many_lights: Overrides<ManyLightSettings>,
    #[command(flatten)]
    lgh: Overrides<LghSettings>,
    #[command(flatten)]
    device: Overrides<DeviceSettings>,
    #[command(flatten)]
    list: ListArgs,
    #[command(flatten)]
    window: Overrides<WindowSettings>,
    #[command(flatten)]
    script: ScriptArgs,
    #[command(flatten)]
    output: Overrides<OutputSettings>,
    #[command(flatten)]
    graph: GraphArgs,
    #[command(flatten)]
    diagnostics: DiagnosticsArgs,
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
    let (args, every_view) = every_view::take(args.into_iter().map(Into::into).collect());
    let command = error_report::state_defaults(Args::command());
    match command.try_get_matches_from(&args).and_then(|matches| Args::from_arg_matches(&matches)) {
        Ok(parsed) => parsed.into_command(every_view),
        Err(error) if matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) => {
            Ok(Command::Show(error.to_string()))
        }
        Err(error) => Err(Error::Usage(complaints::sentence_about(&error, &args))),
    }
}

impl Args {
    fn into_command(self, every_view: bool) -> Result<Command> {
        if every_view && self.subcommand.is_some() {
            return Err(Error::Usage("--view all is for rendering: a command has no views".to_owned()));
        }
        match self.subcommand {
            Some(Subcommand::Compare(compare)) => {
                compare.check()?;
                return Ok(Command::Compare(Box::new(compare)));
            }
            Some(Subcommand::CompareSequence(compare)) => {
                compare.check()?;
                return Ok(Command::CompareSequence(Box::new(compare)));
            }
            Some(Subcommand::DiffDumps(dumps)) => {
                dumps.check()?;
                return Ok(Command::DiffDumps(dumps));
            }
            Some(Subcommand::Selftest(args)) => {
                args.check()?;
                return Ok(Command::Selftest(args));
            }
            Some(Subcommand::ErrorReport(args)) => return args.into_command(),
            Some(Subcommand::Completions(args)) => return Ok(Command::Show(pages::completions(&args))),
            Some(Subcommand::Man(args)) => return pages::man(&args).map(Command::Show),
            None => {}
        }
        let verbosity = self.diagnostics.verbosity();
        if self.list.list_gpus {
            return Ok(Command::ListGpus { verbosity });
        }
        let print_graph = self.graph.print_graph;
        let script = self.script.script.clone();
        let mut settings = Box::new(self.into_settings()?);
        if every_view {
            return Ok(Command::RenderViews { each: every_view::settings_of_each(&settings)?, verbosity });
        }
        // Only runs that end by themselves leave files.
        settings.run.headless |= settings.output.files().next().is_some();
        if script.is_some() {
            check_that_a_script_has_a_window(&settings, print_graph)?;
        }
        if !settings.run.headless && !print_graph {
            return Ok(Command::Window { settings, script, verbosity });
        }
        Ok(Command::Render { settings, print_graph, verbosity })
    }

    /// Command line over settings file over defaults, validated.
    fn into_settings(self) -> Result<Settings> {
        let file = self.file.settings;
        let mut settings = file.as_deref().map_or_else(|| Ok(Settings::default()), Settings::read)?;
        self.scene.apply(&mut settings.scene)?;
        self.motion.apply(&mut settings.motion)?;
        self.environment.apply(&mut settings.environment)?;
        self.run.apply(&mut settings.run)?;
        self.picture.apply(&mut settings.picture)?;
        self.render.apply(&mut settings.render)?;
        self.pbgi.apply(&mut settings.pbgi)?;
        self.path_trace.apply(&mut settings.path_trace)?;
        self.tracing.apply(&mut settings.tracing)?;
        self.many_lights.apply(&mut settings.many_lights)?;
        self.lgh.apply(&mut settings.lgh)?;
        self.device.apply(&mut settings.device)?;
        self.window.apply(&mut settings.window)?;
        self.output.apply(&mut settings.output)?;
        settings.output.keep_last_timings();
        if settings.output.timings.iter().any(|timings| Some(timings) == file.as_ref()) {
            return Err(Error::Usage("--timings would overwrite the settings file: give another name".to_owned()));
        }
        settings.validate()?;
        techniques::check(&settings)?;
        Ok(settings)
    }
}

/// A script is for the window, and a window writes no files by itself.
fn check_that_a_script_has_a_window(settings: &Settings, print_graph: bool) -> Result<()> {
    if let Some((name, path)) = settings.output.files().next() {
        let path = path.display();
        return Err(Error::Usage(format!("--script is for the window, which does not write --{name} {path}")));
    }
    if settings.run.headless || print_graph {
        return Err(Error::Usage("--script is for the window: leave out --headless and --print-graph".to_owned()));
    }
    Ok(())
}

#[cfg(test)]
mod tests;
