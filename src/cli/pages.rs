//! What the shell and `man` are told of the command line, made from it.

use clap::CommandFactory;
use clap::builder::{PossibleValue, PossibleValuesParser};

use super::commands::{CompletionsArgs, ManArgs};
use super::{Args, every_view};
use crate::{Error, Result};

/// The whole command line, as it is told to people.
fn command() -> clap::Command {
    let mut command = super::error_report::state_defaults(Args::command());
    // Every command is known by its whole name: `gridlight compare`.
    command.build();
    command
}

/// The script that completes options, words and files in a shell.
pub(super) fn completions(args: &CompletionsArgs) -> String {
    let with_all = |view: clap::Arg| {
        let mut words = view.get_possible_values();
        words.push(PossibleValue::new(every_view::ALL).help("Each into a file named after --output"));
        view.value_parser(PossibleValuesParser::new(words))
    };
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut command().mut_arg("view", with_all), "gridlight", &mut text);
    String::from_utf8_lossy(&text).into_owned()
}

/// A manual page in roff.
///
/// # Errors
/// [`Error::Usage`] when there is no such command.
pub(super) fn man(args: &ManArgs) -> Result<String> {
    let command = command();
    let page = match &args.command {
        None => command,
        Some(name) => match command.find_subcommand(name) {
            Some(found) => found.clone(),
            None => return Err(Error::Usage(format!("man {name}: there is no command of this name"))),
        },
    };
    let mut text = Vec::new();
    let written = clap_mangen::Man::new(page).render(&mut text);
    written.map_err(|error| Error::Failure(format!("the manual page cannot be made: {error}")))?;
    Ok(String::from_utf8_lossy(&text).into_owned())
}

#[cfg(test)]
mod tests {
    use clap::ValueEnum;
    use clap_complete::Shell;

    use super::*;

    #[test]
    fn every_shell_is_told_of_options_and_words() {
        for shell in Shell::value_variants() {
            let script = completions(&CompletionsArgs { shell: *shell, help: None });
            for word in ["shadow-samples", "compare", "max-flip"] {
                assert!(script.contains(word), "{shell}: no {word}");
            }
        }
        let script = completions(&CompletionsArgs { shell: Shell::Bash, help: None });
        assert!(script.contains("brute-force") && script.contains(" cache-misses all"), "{script}");
    }

    #[test]
    fn the_manual_has_every_option_and_command() {
        let page = man(&ManArgs { command: None, help: None }).unwrap();
        for option in super::super::option_help() {
            let dashed = option.key.replace('-', "\\-");
            assert!(page.contains(&dashed), "no {dashed}");
        }
        let page = man(&ManArgs { command: Some("compare".to_owned()), help: None }).unwrap();
        assert!(page.contains("max\\-flip") && page.starts_with(".ie"), "{page}");
        let error = man(&ManArgs { command: Some("paint".to_owned()), help: None }).unwrap_err();
        assert_eq!(error.to_string(), "man paint: there is no command of this name");
    }
}
