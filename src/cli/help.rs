//! What the command line says of its options, for whoever else offers them.

use clap::CommandFactory;

use super::Args;

/// An option that is also a setting.
#[derive(Clone, Debug)]
pub struct OptionHelp {
    /// The setting's key: the long option.
    pub key: String,
    /// The group that the help has it in.
    pub group: String,
    /// What it is, with unit, range and default.
    pub help: String,
    /// The words that it takes with what each means; empty where it takes other values.
    pub values: Vec<(String, String)>,
}

/// Every long option of rendering, in the order of the help.
#[must_use]
pub fn option_help() -> Vec<OptionHelp> {
    let text = |styled: Option<&clap::builder::StyledStr>| styled.map(ToString::to_string).unwrap_or_default();
    Args::command()
        .get_arguments()
        .filter_map(|argument| {
            let flag = argument.get_action().takes_values();
            Some(OptionHelp {
                key: argument.get_long()?.to_owned(),
                group: argument.get_help_heading().unwrap_or_default().to_owned(),
                help: text(argument.get_help()),
                values: argument
                    .get_possible_values()
                    .iter()
                    .filter(|_| flag)
                    .map(|value| (value.get_name().to_owned(), text(value.get_help())))
                    .collect(),
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;

    #[test]
    fn every_option_of_a_setting_has_help_and_its_words() {
        let options = option_help();
        let find = |key: &str| options.iter().find(|o| o.key == key).unwrap_or_else(|| panic!("no {key}"));
        assert_eq!(find("technique").values.len(), 7);
        assert!(find("technique").values.iter().all(|(_, help)| !help.is_empty()));
        assert!(find("alpha").help.contains("above 0") && find("alpha").values.is_empty());
        assert_eq!(find("alpha").group, "Method");
        for key in Settings::default().table().unwrap().keys() {
            assert!(!find(key).help.is_empty(), "{key}");
        }
    }
}
