//! The one settings tree: the command line, settings files and the window all fill this in.
//!
//! Settings stand in groups, by what they are about; each group is one struct with its defaults, its help and its
//! checks. A settings file knows no groups: its keys are the long options of the command line, without the dashes.

mod edit;
mod environment;
mod file;
mod group;
mod groups;
mod motion;
mod pbgi_values;
mod pixel;
mod scope;
mod sun;
mod techniques;
#[cfg(test)]
pub(crate) mod testing;
mod validate;
mod values;
mod window_values;

use serde::Serialize;
use serde::de::MapAccess;

pub use edit::plain;
pub use environment::{EnvironmentSettings, EnvironmentSource};
use group::{Group, Validate, is_key};
pub use groups::{
    DeviceSettings, OutputSettings, PictureSettings, RenderSettings, RunSettings, SceneSettings, TracingSettings,
    WindowSettings,
};
pub use motion::{Antilag, GridUpdate, MotionSettings, Temporal, VplSeeds};
pub use pbgi_values::{Coverage, Hemisphere, MicroFill, Selection};
pub use pixel::PixelPlace;
pub use scope::Scope;
pub use sun::SunPlace;
pub use techniques::{IndirectSize, LghSettings, ManyLightSettings, PathTraceSettings, PbgiSettings};
pub use values::{
    BackFaces, CenterWeight, Exposure, FirstLevelBuild, LevelBuild, Levels, LightSet, LightingMode, Lobe, Rays,
    Reservoir, ShadowEstimate, ShadowFilter, ShadowPoints, Size, Switch, Technique, TextureFilter, ToneMap, View,
    VplImportance, name,
};
pub use window_values::{PresentMode, RenderScale};

/// Makes the tree of the groups.
macro_rules! settings_tree {
    ($(
        $(#[doc = $doc:tt])+
        $field:ident: $group:ident,
    )+) => {
        /// Everything that decides what is rendered and where it goes.
        #[derive(Clone, Debug, Default, PartialEq, Serialize)]
        pub struct Settings {$(
            $(#[doc = $doc])+
            #[serde(flatten)]
            pub $field: $group,
        )+}

        /// What each group is about, and its keys.
        const GROUPS: &[(Scope, &[&str])] = &[$((<$group>::SCOPE, <$group>::KEYS),)+];

        impl Settings {
            /// The settings with the groups of `others` in place of the own, where `which` holds for what they are about.
            #[must_use]
            pub fn with_groups_of(mut self, others: &Self, which: impl Fn(Scope) -> bool) -> Self {
                $(
                    if which(<$group>::SCOPE) {
                        self.$field.clone_from(&others.$field);
                    }
                )+
                self
            }

            /// Takes over the value that follows `key` in a settings file, where a group has this key.
            fn read_value<'de, M: MapAccess<'de>>(&mut self, key: &str, map: &mut M) -> Result<(), M::Error> {
                let _ = $(self.$field.read(key, map)?)||+;
                Ok(())
            }

            /// The checks of each group by itself.
            fn validate_groups(&self) -> crate::Result<()> {
                $(self.$field.validate()?;)+
                Ok(())
            }
        }
    };
}

settings_tree! {
    /// What is looked at, from where, and under which sun.
    scene: SceneSettings,
    /// Which moments of a scene that moves are shown.
    motion: MotionSettings,
    /// Light from all around the scene.
    environment: EnvironmentSettings,
    /// How a run goes.
    run: RunSettings,
    /// What every picture has, whatever it shows.
    picture: PictureSettings,
    /// What the picture shows, and which technique renders it.
    render: RenderSettings,
    /// What light is traced with, whatever the technique.
    tracing: TracingSettings,
    /// Which lights there are, and how any of them lights a pixel.
    many_lights: ManyLightSettings,
    /// The lighting grid hierarchy.
    lgh: LghSettings,
    /// Point-based global illumination.
    pbgi: PbgiSettings,
    /// Path tracing.
    path_trace: PathTraceSettings,
    /// What renders, and how it is treated.
    device: DeviceSettings,
    /// How a window shows pictures.
    window: WindowSettings,
    /// The files that a run leaves.
    output: OutputSettings,
}

impl Settings {
    /// The settings after a change.
    #[must_use]
    pub fn changed(mut self, change: impl FnOnce(&mut Self)) -> Self {
        change(&mut self);
        self
    }

    /// Every key of a settings file.
    pub fn keys() -> impl Iterator<Item = String> {
        GROUPS.iter().flat_map(|(_, keys)| *keys).map(|key| key.replace('_', "-"))
    }

    /// What the group with this key is about; `None` when there is no such key.
    #[must_use]
    pub fn scope_of(key: &str) -> Option<Scope> {
        GROUPS.iter().find(|(_, keys)| keys.iter().any(|known| is_key(known, key))).map(|(scope, _)| *scope)
    }
}
