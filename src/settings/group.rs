//! A group of settings: a struct whose fields are keys of settings files and long options of the command line.

use serde::de::MapAccess;

use super::Scope;
use crate::Result;

/// A check of a group by itself.
pub(crate) trait Validate {
    /// Fails with one sentence about the first thing wrong.
    fn validate(&self) -> Result<()>;
}

/// What all groups of settings can do.
pub(crate) trait Group: Validate + Clone {
    /// What the group is about.
    const SCOPE: Scope;
    /// The keys in a settings file; `_` may stand for `-`.
    const KEYS: &'static [&'static str];

    /// Takes over the value that follows `key` in a settings file; whether the group has this key.
    fn read<'de, M: MapAccess<'de>>(&mut self, key: &str, map: &mut M) -> std::result::Result<bool, M::Error>;
}

/// Whether a key of [`Group::KEYS`] is written like this in a file.
pub(crate) fn is_key(of_group: &str, in_file: &str) -> bool {
    of_group.len() == in_file.len()
        && of_group.bytes().zip(in_file.bytes()).all(|(a, b)| if a == b'_' { b == b'-' } else { a == b })
}

/// Declares a group and its [`Scope`]: for each setting its help, the attributes that clap and serde need, name, type and default.
/// `as "key"` names the key where it is not the field's name. Keys are written with `-` for `_`.
macro_rules! settings_group {
    (
        $(#[$attribute:meta])*
        pub struct $group:ident: $scope:ident {$(
            $(#[doc = $doc:tt])+
            $(#[arg($($arg:tt)*)])?
            $(#[serde($($serde:tt)*)])?
            pub $field:ident $(as $key:literal)?: $kind:ty = $default:expr,
        )+}
    ) => {
        #[derive(Clone, Debug, PartialEq, serde::Serialize, clap::Args)]
        #[serde(rename_all = "kebab-case")]
        $(#[$attribute])*
        pub struct $group {$(
            $(#[doc = $doc])+
            $(#[arg($($arg)*)])?
            $(#[serde($($serde)*)])?
            $(#[serde(rename = $key)])?
            pub $field: $kind,
        )+}

        impl Default for $group {
            fn default() -> Self {
                Self { $($field: $default,)+ }
            }
        }

        impl $crate::settings::group::Group for $group {
            const SCOPE: $crate::settings::Scope = $crate::settings::Scope::$scope;
            const KEYS: &'static [&'static str] = &[$($crate::settings::group::key!($field $($key)?),)+];

            fn read<'de, M: serde::de::MapAccess<'de>>(&mut self, key: &str, map: &mut M) -> std::result::Result<bool, M::Error> {
                $(
                    if $crate::settings::group::is_key($crate::settings::group::key!($field $($key)?), key) {
                        #[derive(serde::Deserialize)]
                        #[serde(transparent)]
                        struct Value($(#[serde($($serde)*)])? $kind);
                        self.$field = map.next_value::<Value>()?.0;
                        return Ok(true);
                    }
                )+
                Ok(false)
            }
        }
    };
}

/// The key of a field.
macro_rules! key {
    ($field:ident) => {
        stringify!($field)
    };
    ($field:ident $key:literal) => {
        $key
    };
}

pub(crate) use {key, settings_group};
