//! The one settings tree: the command line, settings files and the window all fill this in.
//!
//! Settings stand in groups, by what they are about; each group is one struct with its defaults, its help and its
//! checks. A settings file knows no groups: its keys are the long options of the command line, without the dashes.

mod edit;
mod file;
mod group;
mod groups;
mod sun;
mod techniques;
mod validate;
mod values;
mod view_rules;
mod window_values;

use serde::Serialize;
use serde::de::MapAccess;

pub use edit::plain;
use group::Group;
pub use groups::{
    DeviceSettings, OutputSettings, PictureSettings, RenderSettings, RunSettings, SceneSettings, WindowSettings,
};
pub use sun::SunPlace;
pub use techniques::{LghSettings, ManyLightSettings, PathTraceSettings};
pub use values::{
    Build, Center, Exposure, Filter, Levels, LightSet, LightingMode, Lobe, Rays, Reservoir, Scatter, ShadowPoints,
    Size, Switch, Technique, View, name,
};
pub use window_values::{PresentMode, RenderScale};

/// Everything that decides what is rendered and where it goes.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Settings {
    /// What is looked at, from where, and under which sun.
    #[serde(flatten)]
    pub scene: SceneSettings,
    /// How a run goes.
    #[serde(flatten)]
    pub run: RunSettings,
    /// What every picture has, whatever it shows.
    #[serde(flatten)]
    pub picture: PictureSettings,
    /// What the picture shows, and which technique renders it.
    #[serde(flatten)]
    pub render: RenderSettings,
    /// Which lights there are, and how any of them lights a pixel.
    #[serde(flatten)]
    pub many_lights: ManyLightSettings,
    /// The lighting grid hierarchy.
    #[serde(flatten)]
    pub lgh: LghSettings,
    /// Path tracing.
    #[serde(flatten)]
    pub path_trace: PathTraceSettings,
    /// What renders, and how it is treated.
    #[serde(flatten)]
    pub device: DeviceSettings,
    /// How a window shows pictures.
    #[serde(flatten)]
    pub window: WindowSettings,
    /// The files that a run leaves.
    #[serde(flatten)]
    pub output: OutputSettings,
}

impl Settings {
    /// The settings after a change.
    #[must_use]
    pub fn changed(mut self, change: impl FnOnce(&mut Self)) -> Self {
        change(&mut self);
        self
    }

    /// Takes over the value that follows `key` in a settings file, where a group has this key.
    fn read_value<'de, M: MapAccess<'de>>(&mut self, key: &str, map: &mut M) -> Result<(), M::Error> {
        let _ = self.scene.read(key, map)?
            || self.run.read(key, map)?
            || self.picture.read(key, map)?
            || self.render.read(key, map)?
            || self.many_lights.read(key, map)?
            || self.lgh.read(key, map)?
            || self.path_trace.read(key, map)?
            || self.device.read(key, map)?
            || self.window.read(key, map)?
            || self.output.read(key, map)?;
        Ok(())
    }

    /// Every key of a settings file.
    pub fn keys() -> impl Iterator<Item = String> {
        KEYS.into_iter().flatten().map(|key| key.replace('_', "-"))
    }
}

/// The keys of every group.
const KEYS: [&[&str]; 10] = [
    SceneSettings::KEYS,
    RunSettings::KEYS,
    PictureSettings::KEYS,
    RenderSettings::KEYS,
    ManyLightSettings::KEYS,
    LghSettings::KEYS,
    PathTraceSettings::KEYS,
    DeviceSettings::KEYS,
    WindowSettings::KEYS,
    OutputSettings::KEYS,
];
