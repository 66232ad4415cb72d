//! The one settings tree: the command line, settings files and (later) the window all fill this in.
//!
//! The keys of a settings file are the long options of the command line, without the dashes.

mod edit;
mod sun;
mod validate;
mod values;
mod view_rules;
mod window_values;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize, Serializer};

use crate::{Error, Result};
pub use edit::plain;
pub use sun::SunPlace;
pub use values::{
    Build, Center, Exposure, Filter, Levels, LightSet, LightingMode, Lobe, Rays, Reservoir, Scatter, ShadowPoints,
    Size, Switch, Technique, View, name,
};
pub use window_values::{PresentMode, RenderScale};

/// Everything that decides what is rendered and where it goes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
pub struct Settings {
    /// The glTF or GLB file; `None` is the built-in scene.
    #[serde(serialize_with = "path_as_text")]
    pub scene: Option<PathBuf>,
    /// Render without a window, surface or display.
    pub headless: bool,
    /// Number of measured frames.
    pub frames: u32,
    /// Number of frames rendered before the measured ones.
    pub warmup: u32,
    /// Size of the picture in pixels.
    pub size: Size,
    /// Camera name or index; `None` is the scene's first camera.
    #[serde(deserialize_with = "values::name_or_index")]
    pub camera: Option<String>,
    /// Where the scene's first directional light stands; `None` is where the scene has it.
    pub sun: Option<SunPlace>,
    /// Which pipeline renders.
    pub technique: Technique,
    /// Paths per pixel of a path-traced frame.
    pub samples: u32,
    /// Frames with fresh seeds and sub-pixel jitter that a picture is the mean of.
    pub accumulate: u32,
    /// Direct light.
    pub direct: Switch,
    /// Which lights enter the hierarchy.
    pub lights: LightSet,
    /// Approximate number of virtual point lights.
    pub vpls: u32,
    /// Most diffuse bounces of a light path.
    pub bounces: u32,
    /// Number of the top level of the hierarchy.
    pub levels: Levels,
    /// Blending radius of a level in cells of that level.
    pub alpha: f32,
    /// How a grid light sends out its flux.
    pub lobe: Lobe,
    /// Where a grid light is.
    pub center: Center,
    /// First level that lights: 0 the lights themselves, 1 the finest grid.
    pub first_level: u32,
    /// Side of the interleaving pattern in pixels.
    pub interleave: u32,
    /// Shadow rays (and reservoirs) per pixel; 0 is no shadows.
    pub shadow_samples: u32,
    /// Shadows of the indirect light.
    pub shadows: Switch,
    /// First level whose lights may be chosen for shadow rays.
    pub shadow_from: u32,
    /// Where on a chosen light the shadow ray ends.
    pub shadow_points: ShadowPoints,
    /// How lights reach the pixels; `None` is `gather`, and `volumes` for reservoirs that only those have.
    pub lighting: Option<LightingMode>,
    /// How reservoirs are updated; `None` is `exact`, but for light volumes on a device without 64-bit atomics `lock`.
    pub reservoir: Option<Reservoir>,
    /// What traces rays.
    pub rays: Rays,
    /// How the levels above the first are built.
    pub build: Build,
    /// How lights are summed into the first; `None` is `sorted`, but `atomic` where very many lights share a cell.
    pub scatter: Option<Scatter>,
    /// The filter of the shadow estimates.
    pub filter: Filter,
    /// Singularity clamp, a fraction of the scene radius; 0 is the unclamped reference.
    pub clamp: f32,
    /// About the longest time that one submission takes; passes, and parts of reference techniques, stay whole.
    pub max_submit_ms: f32,
    /// Seed of every random number.
    pub seed: u32,
    /// Exposure of PNG pictures.
    pub exposure: Exposure,
    /// What the picture shows.
    pub view: View,
    /// Where the picture goes, `.exr` or `.png`.
    #[serde(serialize_with = "path_as_text")]
    pub output: Option<PathBuf>,
    /// Where the timings go, `.json` or `.csv`.
    #[serde(serialize_with = "path_as_text")]
    pub timings: Option<PathBuf>,
    /// Folder for every intermediate of the last frame.
    #[serde(serialize_with = "path_as_text")]
    pub dump: Option<PathBuf>,
    /// Frame that RenderDoc captures, counted from 0.
    pub renderdoc_frame: Option<u32>,
    /// Device index or a part of its name; `None` is the most capable.
    #[serde(deserialize_with = "values::name_or_index")]
    pub gpu: Option<String>,
    /// Run under the validation layers, and fail on any message.
    pub validation: bool,
    /// How the window's pictures take turns.
    pub present_mode: PresentMode,
    /// Edge of the rendered picture as a fraction of the window's.
    pub render_scale: RenderScale,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            scene: None,
            headless: false,
            frames: 1,
            warmup: 0,
            size: Size { width: 1280, height: 720 },
            camera: None,
            sun: None,
            technique: Technique::Lgh,
            samples: 16,
            accumulate: 1,
            direct: Switch::On,
            lights: LightSet::Vpl,
            vpls: 100_000,
            bounces: 3,
            levels: Levels::Auto,
            alpha: 1.0,
            lobe: Lobe::Mixture,
            center: Center::Intensity,
            first_level: 1,
            interleave: 1,
            shadow_samples: 4,
            shadows: Switch::On,
            shadow_from: 1,
            shadow_points: ShadowPoints::Descent,
            lighting: None,
            reservoir: None,
            rays: Rays::Bvh,
            build: Build::Cascade,
            scatter: None,
            filter: Filter::Atrous,
            clamp: 0.01,
            max_submit_ms: 200.0,
            seed: 1,
            exposure: Exposure::Auto,
            view: View::Final,
            output: None,
            timings: None,
            dump: None,
            renderdoc_frame: None,
            gpu: None,
            validation: false,
            present_mode: PresentMode::Fifo,
            render_scale: RenderScale::Auto,
        }
    }
}

impl Settings {
    /// Reads a settings file: JSON where the extension is `.json`, TOML otherwise. Absent keys keep
    /// their defaults; the values are not validated yet. Paths inside are relative to the working
    /// directory, as on the command line.
    ///
    /// # Errors
    /// [`Error::File`] when the file cannot be read or is not TOML (or JSON) at all, [`Error::Usage`]
    /// when it has an unknown key or a value of the wrong kind.
    pub fn read(path: &Path) -> Result<Self> {
        Ok(Self::read_with_keys(path)?.0)
    }

    /// [`Self::read`] together with the keys that the file has.
    ///
    /// # Errors
    /// Those of [`Self::read`].
    pub fn read_with_keys(path: &Path) -> Result<(Self, Vec<String>)> {
        let text = std::fs::read_to_string(path)
            .map_err(|error| Error::file(path, format!("cannot read the settings file: {error}")))?;
        let is_json = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"));
        if is_json { from_json(path, &text) } else { from_toml(path, &text) }
    }

    /// The settings as a TOML settings file.
    ///
    /// # Errors
    /// [`Error::Failure`] when TOML cannot express a value.
    pub fn to_toml(&self) -> Result<String> {
        toml::to_string(self).map_err(|error| Error::Failure(format!("cannot write the settings as TOML: {error}")))
    }
}

fn from_toml(path: &Path, text: &str) -> Result<(Settings, Vec<String>)> {
    let settings = toml::from_str(text).map_err(|error| {
        let line = error.span().map(|span| 1 + text[..span.start.min(text.len())].matches('\n').count());
        let message = error.message();
        if toml::from_str::<toml::Table>(text).is_err() {
            let place = line.map_or(String::new(), |line| format!(" (line {line})"));
            Error::file(path, format!("not a TOML file: {}{place}", one_line(message)))
        } else {
            bad_setting(path, line, message)
        }
    })?;
    let table: toml::Table = toml::from_str(text).map_err(|error| bad_setting(path, None, error.message()))?;
    Ok((settings, table.keys().cloned().collect()))
}

fn from_json(path: &Path, text: &str) -> Result<(Settings, Vec<String>)> {
    let settings = serde_json::from_str(text).map_err(|error| {
        if error.is_data() {
            let message = error.to_string();
            let message = message.split(" at line ").next().unwrap_or(&message);
            bad_setting(path, Some(error.line()), message)
        } else {
            Error::file(path, format!("not a JSON file: {error}"))
        }
    })?;
    let keys: std::collections::BTreeMap<String, serde::de::IgnoredAny> =
        serde_json::from_str(text).map_err(|error| bad_setting(path, None, &error.to_string()))?;
    Ok((settings, keys.into_keys().collect()))
}

fn bad_setting(path: &Path, line: Option<usize>, message: &str) -> Error {
    let place = line.map_or(String::new(), |line| format!(", line {line}"));
    Error::Usage(format!("settings file {}{place}: {}", path.display(), one_line(message)))
}

fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A path that is not Unicode must not stop the timings from being written.
fn path_as_text<S: Serializer>(path: &Option<PathBuf>, serializer: S) -> std::result::Result<S::Ok, S::Error> {
    path.as_ref().map(|path| path.to_string_lossy()).serialize(serializer)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(name: &str, text: &str) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        (folder, path)
    }

    fn every_value_changed() -> Settings {
        Settings {
            scene: Some("a/b c.gltf".into()),
            headless: true,
            frames: 8,
            warmup: 2,
            size: Size { width: 320, height: 180 },
            camera: Some("atrium".into()),
            sun: Some(SunPlace { azimuth_deg: 10.0, height_deg: 20.5 }),
            technique: Technique::PathTrace,
            samples: 3,
            accumulate: 4,
            direct: Switch::Off,
            lights: LightSet::Both,
            vpls: 1_000_000,
            bounces: 5,
            levels: Levels::Fixed(7),
            alpha: 1.7,
            lobe: Lobe::ClampedNormal,
            center: Center::Uniform,
            first_level: 0,
            interleave: 4,
            shadow_samples: 16,
            shadows: Switch::Off,
            shadow_from: 3,
            shadow_points: ShadowPoints::Deviation,
            lighting: Some(LightingMode::Volumes),
            reservoir: Some(Reservoir::Lock),
            rays: Rays::Query,
            build: Build::Scatter,
            scatter: Some(Scatter::Atomic),
            filter: Filter::None,
            clamp: 0.0,
            max_submit_ms: 50.5,
            seed: u32::MAX,
            exposure: Exposure::Fixed(0.3),
            view: View::ShadowRatio,
            output: Some("o.exr".into()),
            timings: Some("t.csv".into()),
            dump: Some("d".into()),
            renderdoc_frame: Some(3),
            gpu: Some("llvmpipe".into()),
            validation: true,
            present_mode: PresentMode::Mailbox,
            render_scale: RenderScale::Fixed(0.5),
        }
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
        assert_eq!(settings.camera.as_deref(), Some("1"));
        assert_eq!(settings.gpu.as_deref(), Some("0"));
        assert_eq!(settings.levels, Levels::Fixed(5));
        assert_eq!(settings.exposure, Exposure::Fixed(2.0));
        assert_eq!(settings.alpha.to_bits(), 2.0_f32.to_bits());
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
