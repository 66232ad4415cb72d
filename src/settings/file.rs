//! Settings files: TOML or JSON, one flat table.

use std::collections::BTreeSet;
use std::fmt;
use std::path::Path;

use serde::de::{DeserializeSeed, Error as _, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::Settings;
use crate::files::read_text;
use crate::{Error, Result};

impl Settings {
    /// Reads a settings file: JSON where the extension is `.json`, TOML otherwise. Absent keys keep
    /// their defaults; the values are not validated yet. Paths inside are relative to the working
    /// directory, as on the command line.
    ///
    /// # Errors
    /// [`Error::File`] when the file cannot be read or is not TOML (or JSON) at all, [`Error::Usage`]
    /// when it has an unknown key or a value of the wrong kind.
    pub fn read(path: &Path) -> Result<Self> {
        Self::default().read_over(path)
    }

    /// [`Self::read`], but absent keys keep the values that they have here.
    ///
    /// # Errors
    /// Those of [`Self::read`].
    pub fn read_over(self, path: &Path) -> Result<Self> {
        let text =
            read_text(path).map_err(|error| Error::file(path, format!("cannot read the settings file: {error}")))?;
        // Some editors begin a file with a byte order mark.
        let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
        let is_json = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"));
        if is_json { from_json(self, path, text) } else { from_toml(self, path, text) }
    }

    /// The settings as a TOML settings file.
    ///
    /// # Errors
    /// [`Error::Failure`] when TOML cannot express a value.
    pub fn to_toml(&self) -> Result<String> {
        toml::to_string(self).map_err(|error| Error::Failure(format!("cannot write the settings as TOML: {error}")))
    }
}

fn from_toml(base: Settings, path: &Path, text: &str) -> Result<Settings> {
    let read = toml::Deserializer::parse(text).and_then(|deserializer| Over(base).deserialize(deserializer));
    read.map_err(|error| {
        let line = error.span().map(|span| 1 + text[..span.start.min(text.len())].matches('\n').count());
        let message = error.message();
        if toml::from_str::<toml::Table>(text).is_err() {
            let place = line.map_or(String::new(), |line| format!(" (line {line})"));
            Error::file(path, format!("not a TOML file: {}{place}", one_line(message)))
        } else {
            bad_setting(path, line, message)
        }
    })
}

fn from_json(base: Settings, path: &Path, text: &str) -> Result<Settings> {
    let mut deserializer = serde_json::Deserializer::from_str(text);
    let read = Over(base).deserialize(&mut deserializer).and_then(|settings| deserializer.end().map(|()| settings));
    read.map_err(|error| {
        if error.is_data() {
            let message = error.to_string();
            let message = message.split(" at line ").next().unwrap_or(&message);
            bad_setting(path, Some(error.line()), message)
        } else {
            Error::file(path, format!("not a JSON file: {error}"))
        }
    })
}

fn bad_setting(path: &Path, line: Option<usize>, message: &str) -> Error {
    let place = line.map_or(String::new(), |line| format!(", line {line}"));
    Error::Usage(format!("settings file {}{place}: {}", path.display(), one_line(message)))
}

pub(super) fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}

impl<'de> Deserialize<'de> for Settings {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        Over(Self::default()).deserialize(deserializer)
    }
}

/// Settings that a flat table overrides. (serde's `flatten` would lose the lines of errors, and accept unknown keys.)
pub(super) struct Over(pub(super) Settings);

impl<'de> DeserializeSeed<'de> for Over {
    type Value = Settings;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> std::result::Result<Settings, D::Error> {
        deserializer.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for Over {
    type Value = Settings;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a table of settings")
    }

    fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> std::result::Result<Settings, M::Error> {
        let Self(mut settings) = self;
        let mut seen = BTreeSet::new();
        while let Some(Key(key)) = map.next_key()? {
            if !seen.insert(key.clone()) {
                return Err(M::Error::custom(format!("`{key}` is given twice")));
            }
            settings.read_value(&key, &mut map)?;
        }
        Ok(settings)
    }
}

/// A key that there is.
struct Key(String);

impl<'de> Deserialize<'de> for Key {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        let key = String::deserialize(deserializer)?;
        if Settings::scope_of(&key).is_some() {
            return Ok(Self(key));
        }
        Err(D::Error::custom(format!("unknown key `{key}`: keys are the long options of the command line")))
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;
    use crate::settings::testing::every_value_changed;
    use crate::settings::{Exposure, GROUPS, Levels, View};

    fn file(name: &str, text: &str) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        (folder, path)
    }

    #[test]
    fn every_key_is_of_one_group_and_can_change() {
        let keys: BTreeSet<String> = Settings::keys().collect();
        assert_eq!(keys.len(), GROUPS.iter().map(|(_, keys)| keys.len()).sum::<usize>());
        let changed = every_value_changed().differences(&Settings::default()).unwrap();
        let changed: BTreeSet<String> = changed.into_iter().map(|(key, _)| key).collect();
        assert_eq!(changed, keys);
    }

    #[test]
    fn toml_and_json_round_trip() {
        for settings in [Settings::default(), every_value_changed()] {
            let (_folder, path) = file("s.toml", &settings.to_toml().unwrap());
            assert_eq!(Settings::read(&path).unwrap(), settings);
            let (_folder, path) = file("s.JSON", &serde_json::to_string(&settings).unwrap());
            assert_eq!(Settings::read(&path).unwrap(), settings);
        }
    }

    #[test]
    fn toml_is_readable() {
        let text = every_value_changed().to_toml().unwrap();
        for line in ["size = \"320x180\"", "levels = 7", "alpha = 1.7", "shadow-from = 3", "reservoir = \"lock\""] {
            assert!(text.lines().any(|found| found == line), "no `{line}` in\n{text}");
        }
    }

    #[test]
    fn words_may_be_numbers() {
        let (_folder, path) = file("s.toml", "camera = 1\ngpu = 0\nlevels = \"5\"\nexposure = 2\nalpha = 2\n");
        let settings = Settings::read(&path).unwrap();
        assert_eq!(settings.scene.camera.as_deref(), Some("1"));
        assert_eq!(settings.device.gpu.as_deref(), Some("0"));
        assert_eq!(settings.lgh.levels, Levels::Fixed(5));
        assert_eq!(settings.picture.exposure, Exposure::Fixed(2.0));
        assert_eq!(settings.lgh.alpha.to_bits(), 2.0_f32.to_bits());
    }

    #[test]
    fn old_names_of_values_are_read() {
        let (_folder, path) = file("s.toml", "view = \"overdraw\"\n");
        assert_eq!(Settings::read(&path).unwrap().render.view, View::LightsTested);
    }

    fn complaint(name: &str, text: &str) -> (u8, String) {
        let (_folder, path) = file(name, text);
        let error = Settings::read(&path).unwrap_err();
        (error.exit_code(), error.to_string())
    }

    #[test]
    fn unknown_keys_name_key_and_file() {
        for (name, text) in [("s.toml", "frames = 2\nframse = 3\n"), ("s.json", "{\"frames\": 2,\n\"framse\": 3}")] {
            let (code, sentence) = complaint(name, text);
            assert_eq!(code, 2);
            assert!(sentence.contains("`framse`") && sentence.contains(name), "{sentence}");
            assert!(sentence.contains("line 2") && !sentence.contains('\n'), "{sentence}");
        }
    }

    #[test]
    fn wrong_values_name_their_line() {
        for (name, text) in
            [("s.toml", "frames = 2\n\nalpha = \"wide\"\n"), ("s.json", "{\"frames\": 2,\n\n\"alpha\": \"wide\"}")]
        {
            let (code, sentence) = complaint(name, text);
            assert!(code == 2 && sentence.contains("line 3") && sentence.contains("wide"), "{sentence}");
        }
    }

    #[test]
    fn a_key_stands_there_once() {
        let (code, sentence) = complaint("s.json", "{\"frames\": 2,\n\"frames\": 3}");
        assert!(code == 2 && sentence.contains("line 2") && sentence.contains("`frames`"), "{sentence}");
    }

    #[test]
    fn a_byte_order_mark_is_no_part_of_the_text() {
        for (name, text) in [("s.toml", "\u{feff}frames = 3\r\n"), ("s.json", "\u{feff}{\"frames\": 3}\r\n")] {
            let (_folder, path) = file(name, text);
            assert_eq!(Settings::read(&path).unwrap().run.frames, 3, "{name}");
        }
    }

    #[test]
    fn null_is_a_setting_without_a_value() {
        let (_folder, path) = file("s.json", "{\"scene\": null, \"reservoir\": null, \"camera\": null}");
        assert_eq!(Settings::read(&path).unwrap(), Settings::default());
    }

    #[test]
    fn wrong_values_are_usage_errors() {
        let cases = [
            ("vpls = -1", "-1"),
            ("size = \"12\"", "WIDTHxHEIGHT"),
            ("size = \"axb\"", "WIDTHxHEIGHT"),
            ("levels = \"many\"", "`auto` or a whole number"),
            ("levels = 2.5", "`auto` or a whole number"),
            ("exposure = \"bright\"", "`auto` or a number"),
            ("technique = \"magic\"", "magic"),
            ("camera = true", "a name or an index"),
        ];
        for (text, part) in cases {
            let (code, sentence) = complaint("s.toml", text);
            assert_eq!(code, 2, "{sentence}");
            assert!(sentence.contains(part) && !sentence.contains('\n'), "{text}: {sentence}");
        }
    }

    #[test]
    fn broken_and_missing_files() {
        for (name, text, part) in
            [("s.toml", "frames = = 2", "not a TOML file"), ("s.json", "{\"frames\": ", "not a JSON file")]
        {
            let (code, sentence) = complaint(name, text);
            assert_eq!(code, 1);
            assert!(sentence.contains(part) && !sentence.contains('\n'), "{sentence}");
        }
        let error = Settings::read(Path::new("/no/such/file.toml")).unwrap_err();
        assert_eq!(error.exit_code(), 1);
        assert!(error.to_string().starts_with("/no/such/file.toml: cannot read the settings file"));
    }
}
