//! The options of the command line that are no settings, and how those that are override the settings.

use std::marker::PhantomData;
use std::path::PathBuf;

use clap::parser::ValueSource;
use clap::{ArgAction, ArgMatches, Command};

use super::Verbosity;

/// The options of a group of settings: what the command line gives of them.
#[derive(Clone, Debug)]
pub(super) struct Overrides<G> {
    given: ArgMatches,
    group: PhantomData<G>,
}

impl<G: clap::Args> clap::Args for Overrides<G> {
    fn augment_args(command: Command) -> Command {
        // None of them must be given.
        G::augment_args_for_update(command)
    }

    fn augment_args_for_update(command: Command) -> Command {
        G::augment_args_for_update(command)
    }
}

impl<G: clap::Args> clap::FromArgMatches for Overrides<G> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut given = matches.clone();
        let ids: Vec<String> = matches.ids().map(ToString::to_string).collect();
        for id in ids {
            // A flag that is not given is no `false`: the settings file may have it.
            if given.value_source(&id) == Some(ValueSource::DefaultValue) {
                let _ = given.try_clear_id(&id);
            }
        }
        Ok(Self { given, group: PhantomData })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl<G: clap::Args> Overrides<G> {
    /// Puts what was given in the place of what the group has.
    pub fn apply(mut self, group: &mut G) -> crate::Result<()> {
        let updated = group.update_from_arg_matches_mut(&mut self.given);
        updated.map_err(|error| crate::Error::Usage(super::complaints::sentence(&error)))
    }
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Run")]
pub(super) struct FileArgs {
    /// Read settings from a TOML or .json file, whose keys are the long options; the command line overrides it
    #[arg(long, value_name = "FILE")]
    pub settings: Option<PathBuf>,
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
pub(super) struct ScriptArgs {
    /// Run a script of actions at given frames (docs/window.md)
    #[arg(long, value_name = "FILE")]
    pub script: Option<PathBuf>,
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
    /// Print a table of all passes, and more on stderr; repeat for more
    #[arg(short, long, action = ArgAction::Count, conflicts_with = "quiet")]
    pub verbose: u8,
    /// Print errors only: no summary, no progress
    #[arg(long)]
    pub quiet: bool,
    /// Print this help
    #[arg(short, long, action = ArgAction::Help)]
    pub help: Option<bool>,
}

impl DiagnosticsArgs {
    pub fn verbosity(&self) -> Verbosity {
        Verbosity { verbose: self.verbose, quiet: self.quiet }
    }
}
