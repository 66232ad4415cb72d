//! The program: reads the command line, does what it asks, answers with an exit code.

pub mod compare;
pub mod compare_sequence;
pub mod counts;
pub mod diff_dumps;
pub mod error_report;
pub mod every_view;
mod frames;
pub mod headless;
mod lighting;
pub mod list_gpus;
mod outputs;
pub mod selftest;
mod sequence;
mod setup;
#[cfg(feature = "window")]
pub mod window;

use std::ffi::OsString;
use std::io::{ErrorKind, Write};
use std::path::Path;
use std::process::ExitCode;

use log::{Level, LevelFilter};

use crate::cli::{self, Command, Verbosity};
use crate::error::shortened;
use crate::files::guard::hide_guarded_panics;
use crate::settings::Settings;
use crate::{Error, Result, interrupt};

/// Runs the program on a command line, program name first.
pub fn run<I>(args: I) -> ExitCode
where
    I: IntoIterator,
    I::Item: Into<OsString> + Clone,
{
    hide_guarded_panics();
    #[cfg(unix)]
    if let Err(error) = interrupt::outlive_file_limits() {
        log::debug!("{error}");
    }
    match cli::parse(args).and_then(execute) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // A run that was stopped and kept what it had is no failure.
            let kind = if matches!(error, Error::Interrupted(_)) { "" } else { "error: " };
            let _ = writeln!(std::io::stderr(), "{kind}{}", one_line(&error.to_string()));
            ExitCode::from(error.exit_code())
        }
    }
}

fn execute(command: Command) -> Result<()> {
    match command {
        Command::Show(text) => say(&text),
        Command::Compare(args) => compare::compare(&args),
        Command::CompareSequence(args) => compare_sequence::compare(&args),
        Command::DiffDumps(args) => diff_dumps::diff(&args),
        Command::Selftest(args) => {
            start_log(Verbosity { verbose: 0, quiet: args.quiet });
            selftest::selftest(&args)
        }
        Command::ErrorReport { settings, options, verbosity } => {
            start_log(verbosity);
            error_report::report(&settings, &options, verbosity.quiet)
        }
        Command::Window { settings, script, verbosity } => {
            start_log(verbosity);
            open_window(*settings, script.as_deref())
        }
        Command::ListGpus { verbosity } => {
            start_log(verbosity);
            list_gpus::list()
        }
        Command::RenderViews { each, verbosity } => {
            start_log(verbosity);
            every_view::render(&each, verbosity)
        }
        Command::Render { settings, print_graph: true, verbosity } => {
            start_log(verbosity);
            headless::print_graph(&settings)
        }
        Command::Render { settings, print_graph: false, verbosity } => {
            start_log(verbosity);
            headless::render(&settings, verbosity)
        }
    }
}

#[cfg(feature = "window")]
fn open_window(settings: Settings, script: Option<&Path>) -> Result<()> {
    // What cannot be a scene is told whether or not there is a display.
    settings.scene.file.as_deref().map_or(Ok(()), crate::scene::gltf::check_file)?;
    window::run(settings, script)
}

#[cfg(not(feature = "window"))]
fn open_window(_: Settings, _: Option<&Path>) -> Result<()> {
    Err(Error::Usage(
        "this build has no window: `cargo build --release` makes one that has; --headless renders without".to_owned(),
    ))
}

/// Prints on stdout. A reader that has gone away is no failure.
///
/// # Errors
/// [`Error::Failure`] for anything else, such as a full disk.
pub fn say(text: &str) -> Result<()> {
    let mut stdout = std::io::stdout().lock();
    let written = writeln!(stdout, "{}", text.trim_end()).and_then(|()| stdout.flush());
    match written {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Error::Failure(format!("stdout cannot be written: {error}")))
        }
        _ => Ok(()),
    }
}

/// Names from files and messages from drivers may hold line breaks; an error is one line whatever they hold.
fn one_line(text: &str) -> String {
    text.split(char::is_control).map(str::trim).filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" ")
}

/// Logs to stderr: warnings, with `-v` what this program does, with `-vv` in detail. `RUST_LOG` overrides.
fn start_log(verbosity: Verbosity) {
    let (own, others) = levels(verbosity);
    let started = env_logger::Builder::new()
        .filter_level(others)
        .filter_module("gridlight", own)
        // At every start it warns of displays that say little of themselves, as virtual ones do.
        .filter_module("winit", if others == LevelFilter::Warn { LevelFilter::Error } else { others })
        .parse_default_env()
        .format(|line, record| {
            let level = record.level().as_str().to_lowercase();
            match record.target() {
                // Warnings quote files; errors are short by themselves, and what the validation layers say stays whole.
                own if own.starts_with("gridlight") && record.level() == Level::Warn => {
                    writeln!(line, "{level}: {}", one_line(&shortened(&record.args().to_string())))
                }
                own if own.starts_with("gridlight") => writeln!(line, "{level}: {}", record.args()),
                library => writeln!(line, "{level} ({library}): {}", record.args()),
            }
        })
        .target(env_logger::Target::Stderr)
        .try_init();
    if started.is_err() {
        log::debug!("another logger is in place");
    }
}

/// The levels of this crate's messages and of the libraries'.
fn levels(verbosity: Verbosity) -> (LevelFilter, LevelFilter) {
    match verbosity {
        Verbosity { quiet: true, .. } => (LevelFilter::Error, LevelFilter::Error),
        Verbosity { verbose: 0, .. } => (LevelFilter::Warn, LevelFilter::Warn),
        Verbosity { verbose: 1, .. } => (LevelFilter::Info, LevelFilter::Warn),
        Verbosity { verbose: 2, .. } => (LevelFilter::Debug, LevelFilter::Info),
        Verbosity { .. } => (LevelFilter::Trace, LevelFilter::Debug),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_one_line() {
        assert_eq!(one_line("camera a\nb\r\n  c\x1b"), "camera a b c");
        assert_eq!(one_line("two  spaces stay"), "two  spaces stay");
    }

    #[test]
    fn levels_follow_the_options() {
        let own = |verbose, quiet| levels(Verbosity { verbose, quiet }).0;
        assert_eq!(own(0, false), LevelFilter::Warn);
        assert_eq!(own(1, false), LevelFilter::Info);
        assert_eq!(own(2, false), LevelFilter::Debug);
        assert_eq!(own(9, false), LevelFilter::Trace);
        assert_eq!(own(0, true), LevelFilter::Error);
    }
}
