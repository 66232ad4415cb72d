//! What clap has to say, as one sentence that helps.

use std::ffi::OsString;

use clap::CommandFactory;
use clap::error::{ContextKind, ContextValue, ErrorKind};

use super::Args;
use crate::error::short_word;

/// How alike a word is to the name of a command that was meant, at least.
const ALIKE: f64 = 0.8;

/// Names that other renderers have for options of this one.
const OTHER_NAMES: &[(&str, &str)] = &[
    ("--width", "--size WxH"),
    ("--height", "--size WxH"),
    ("--resolution", "--size WxH"),
    ("--spp", "--samples N"),
    ("--fov", "--camera X,Y,Z,AZIMUTH,HEIGHT,YFOV"),
    ("--hdri", "--environment FILE.hdr"),
    ("--env", "--environment FILE.hdr"),
    ("--device", "--gpu INDEX|NAME"),
    ("--scene", "the file alone, without an option"),
    ("--no-window", "--headless"),
];

/// clap's message about a command line as one sentence: without the usage line and the pointer to `--help`.
pub(super) fn sentence_about(error: &clap::Error, args: &[OsString]) -> String {
    let context = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => Some(text.as_str()),
        _ => None,
    };
    // clap takes whatever follows a scene for a command.
    if let (ErrorKind::ArgumentConflict, Some(extra)) = (error.kind(), context(ContextKind::InvalidSubcommand)) {
        let first = args.get(1).and_then(|word| word.to_str()).unwrap_or_default();
        return match command_like(first) {
            Some(command) => format!("there is no command '{first}'; a similar one exists: '{command}'"),
            None => {
                format!("unexpected argument '{extra}' found; there is one scene, and a command comes before all else")
            }
        };
    }
    if let (ErrorKind::UnknownArgument, Some(option)) = (error.kind(), context(ContextKind::InvalidArg))
        && let Some((_, ours)) = OTHER_NAMES.iter().find(|(other, _)| *other == option)
    {
        return format!("unexpected argument '{option}' found; here it is {ours}");
    }
    sentence(error)
}

/// The same where nothing but the message is known.
pub(super) fn sentence(error: &clap::Error) -> String {
    // Some sentences of clap quote a value twice and the option in between.
    let text = error.context().fold(error.to_string(), |text, (_, value)| match value {
        ContextValue::String(value) if !value.is_empty() => text.replace(value.as_str(), &short_word(value)),
        _ => text,
    });
    let text = text.split("Usage:").next().unwrap_or(&text);
    let text = text.split("For more information").next().unwrap_or(text);
    let words: Vec<_> = text.trim_start_matches("error:").split_whitespace().collect();
    // Nobody means a scene that is called like an option.
    let tips = words.join(" ");
    let mut tips = tips.split(" tip: ");
    let said = tips.next().unwrap_or_default().to_owned();
    tips.filter(|tip| !tip.starts_with("to pass ")).fold(said, |said, tip| said + "; " + tip)
}

/// The command that a word was meant for.
fn command_like(word: &str) -> Option<String> {
    let command = Args::command();
    let alike = |name: &str| strsim::jaro_winkler(word, name);
    let names = command.get_subcommands().map(|command| command.get_name().to_owned());
    names.filter(|name| alike(name) >= ALIKE).max_by(|a, b| alike(a).total_cmp(&alike(b)))
}

#[cfg(test)]
mod tests {
    fn complaint(line: &str) -> String {
        crate::cli::parse(["gridlight"].into_iter().chain(line.split_whitespace())).unwrap_err().to_string()
    }

    #[test]
    fn tips_make_sense() {
        for (line, sentence) in [
            ("comapre a b", "there is no command 'comapre'; a similar one exists: 'compare'"),
            ("diff-dump a b", "there is no command 'diff-dump'; a similar one exists: 'diff-dumps'"),
            ("--width 5", "unexpected argument '--width' found; here it is --size WxH"),
            ("--frobnicate", "unexpected argument '--frobnicate' found"),
            ("-q", "unexpected argument '-q' found"),
            ("--vews x", "unexpected argument '--vews' found; a similar argument exists: '--view'"),
            (
                "a.glb b.glb",
                "unexpected argument 'b.glb' found; there is one scene, and a command comes before all else",
            ),
        ] {
            assert_eq!(complaint(line), sentence, "{line}");
        }
    }
}
