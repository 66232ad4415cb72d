//! Single settings by their keys, as a settings file has them.

use std::borrow::Cow;
use std::collections::BTreeSet;

use serde::Deserialize;

use super::Settings;
use crate::{Error, Result};

impl Settings {
    /// The settings with another value for one key, written as in a settings file or on the command line.
    ///
    /// # Errors
    /// [`Error::Usage`] when there is no such key or the value is not one of its kind, or contradicts others.
    pub fn with(&self, key: &str, value: &str) -> Result<Self> {
        let mut table = self.table()?;
        let typed = value
            .parse::<i64>()
            .map(toml::Value::from)
            .or_else(|_| value.parse::<f64>().map(toml::Value::from))
            .or_else(|_| value.parse::<bool>().map(toml::Value::from))
            .unwrap_or_else(|_| toml::Value::from(value));
        table.insert(key.to_owned(), typed);
        let settings = from_table(table).map_err(|what| Error::Usage(format!("{key} {value}: {what}")))?;
        settings.validate()?;
        Ok(settings)
    }

    /// The settings with the default of one key.
    ///
    /// # Errors
    /// Those of [`Self::with`].
    pub fn with_default(&self, key: &str) -> Result<Self> {
        let mut table = self.table()?;
        match Self::default().table()?.remove(key) {
            Some(value) => table.insert(key.to_owned(), value),
            None => table.remove(key),
        };
        let settings = from_table(table).map_err(|what| Error::Usage(format!("{key}: {what}")))?;
        settings.validate()?;
        Ok(settings)
    }

    /// Keys and values as in a settings file; keys without a value are left out.
    ///
    /// # Errors
    /// [`Error::Failure`] when TOML cannot express a value.
    pub fn table(&self) -> Result<toml::Table> {
        toml::Table::try_from(self).map_err(|error| Error::Failure(format!("the settings are no TOML: {error}")))
    }

    /// Keys whose values differ, with the value here and the one there; none is an empty word.
    ///
    /// # Errors
    /// Those of [`Self::table`].
    pub fn differences(&self, other: &Self) -> Result<Vec<(String, [String; 2])>> {
        let tables = [self.table()?, other.table()?];
        let keys: BTreeSet<&String> = tables.iter().flat_map(toml::Table::keys).collect();
        let different = keys.into_iter().filter(|key| tables[0].get(*key) != tables[1].get(*key));
        let value = |table: &toml::Table, key: &str| table.get(key).map(plain).unwrap_or_default();
        Ok(different.map(|key| (key.clone(), [value(&tables[0], key), value(&tables[1], key)])).collect())
    }

    /// The settings that are not the defaults, as a command line.
    ///
    /// # Errors
    /// Those of [`Self::table`].
    pub fn command_line(&self) -> Result<String> {
        let (table, defaults) = (self.table()?, Self::default().table()?);
        let mut line = String::from("gridlight");
        if let Some(scene) = table.get("scene") {
            line += &format!(" {}", quoted(&plain(scene)));
        }
        for (key, value) in table.iter().filter(|(key, value)| *key != "scene" && defaults.get(*key) != Some(*value)) {
            let each = value.as_array().map_or(std::slice::from_ref(value), Vec::as_slice);
            for value in each {
                if let toml::Value::Boolean(true) = value {
                    line += &format!(" --{key}");
                } else {
                    let value = plain(value);
                    // What begins with a dash would be taken for an option.
                    let separator = if value.starts_with('-') { '=' } else { ' ' };
                    line += &format!(" --{key}{separator}{}", quoted(&value));
                }
            }
        }
        Ok(line)
    }
}

fn from_table(table: toml::Table) -> std::result::Result<Settings, String> {
    Settings::deserialize(toml::Value::Table(table)).map_err(|error| super::file::one_line(error.message()))
}

/// A value as it is written on the command line.
#[must_use]
pub fn plain(value: &toml::Value) -> String {
    match value {
        toml::Value::String(text) => text.clone(),
        // What was a 32-bit number is written as one.
        toml::Value::Float(number) => (*number as f32).to_string(),
        other => other.to_string(),
    }
}

/// As a shell takes it for one word.
fn quoted(text: &str) -> Cow<'_, str> {
    // Only a NUL cannot be quoted, and no argument holds one.
    shlex::try_quote(text).unwrap_or(Cow::Borrowed(text))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{Exposure, Reservoir, Technique};

    #[test]
    fn values_are_those_of_files() {
        let settings = Settings::default();
        assert_eq!(settings.with("alpha", "2").unwrap().lgh.alpha.to_bits(), 2.0_f32.to_bits());
        assert_eq!(settings.with("technique", "direct").unwrap().render.technique, Technique::Direct);
        assert_eq!(settings.with("exposure", "0.5").unwrap().picture.exposure, Exposure::Fixed(0.5));
        assert_eq!(settings.with("camera", "2").unwrap().scene.camera.as_deref(), Some("2"));
        let race = settings.with("reservoir", "race").unwrap();
        assert_eq!(race.lgh.reservoir, Some(Reservoir::Race));
        assert_eq!(race.with_default("reservoir").unwrap(), settings);
    }

    #[test]
    fn mistakes_are_usage_errors() {
        for (key, value, part) in [
            ("alhpa", "2", "alhpa"),
            ("alpha", "-1", "--alpha must be a finite number above 0, not -1"),
            ("technique", "magic", "magic"),
            ("vpls", "many", "vpls many"),
        ] {
            let error = Settings::default().with(key, value).unwrap_err();
            assert!(error.exit_code() == 2 && error.to_string().contains(part), "{error}");
        }
    }

    #[test]
    fn a_command_line_says_what_is_not_default() {
        assert_eq!(Settings::default().command_line().unwrap(), "gridlight");
        let settings = Settings::default().changed(|s| {
            s.scene.file = Some("a b.gltf".into());
            s.lgh.alpha = 1.7;
            s.render.technique = Technique::BruteForce;
            s.device.validation = true;
            s.scene.camera = Some("-1,2,3,4,5".to_owned());
        });
        let line = settings.command_line().unwrap();
        assert_eq!(line, "gridlight 'a b.gltf' --alpha 1.7 --camera='-1,2,3,4,5' --technique brute-force --validation");
    }
}
