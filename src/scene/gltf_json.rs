//! The JSON of a glTF: what it says of itself first, then the whole of it.

use std::borrow::Cow;
use std::path::Path;

use ::gltf::json::Root;
use serde::{Deserialize, Deserializer};
use serde_json::Value;

use super::gltf_extensions::check_required;
use super::gltf_lenient::Lenient;
use super::gltf_parts::{self, WrongPart};
use super::gltf_pointers::Pointers;
use crate::{Error, Result};

/// What decides whether the rest is looked at. Of any type, so that a file of another version gets the sentence about that.
#[derive(Deserialize)]
struct Head {
    asset: Option<Value>,
    #[serde(rename = "extensionsRequired")]
    extensions_required: Option<Value>,
    animations: Option<Value>,
}

/// What the JSON of a file holds.
pub(super) struct Parsed {
    /// As the `gltf` crate has it.
    pub root: Root,
    /// Pointers of animations, which the crate's types lack.
    pub pointers: Pointers,
    /// What was wrong with parts that the scene can do without, and is not in `root`.
    pub wrong_parts: Vec<WrongPart>,
}

/// Parses the JSON text, without byte order mark and padding. A key whose value is `null` counts as left out. A wrong
/// version and a required extension that is not read are found before anything else.
///
/// # Errors
/// [`Error::File`] in one sentence.
pub(super) fn parse(path: &Path, text: &[u8]) -> Result<Parsed> {
    let text = &without_nulls(text);
    let broken = |reason: &dyn std::fmt::Display| Error::file(path, format_args!("the glTF JSON is broken: {reason}"));
    let head: Head = serde_json::from_slice(text).map_err(|e| broken(&e))?;
    check_version(head.asset.as_ref()).map_err(|reason| Error::file(path, reason))?;
    check_required(&strings(head.extensions_required.as_ref())).map_err(|reason| Error::file(path, reason))?;
    let pointers = Pointers::of(head.animations.as_ref());
    let reason = match root(&mut serde_json::Deserializer::from_slice(text)) {
        Ok(root) => return Ok(Parsed { root, pointers, wrong_parts: Vec::new() }),
        Err(reason) => reason,
    };
    let mut file: Value = serde_json::from_slice(text).map_err(|e| broken(&e))?;
    let wrong_parts = gltf_parts::take_out_wrong(&mut file);
    if wrong_parts.is_empty() {
        return Err(broken(&reason));
    }
    let root = root(&file).map_err(|reason| broken(&reason))?;
    Ok(Parsed { root, pointers, wrong_parts })
}

/// All that the file holds, or what is wrong and where.
fn root<'de, D: Deserializer<'de>>(json: D) -> std::result::Result<Root, String> {
    let mut track = serde_path_to_error::Track::new();
    let tracked = serde_path_to_error::Deserializer::new(Lenient::new(json), &mut track);
    Root::deserialize(tracked).map_err(|e| format!("{}: {e}", track.path()))
}

/// The text with members of objects that are `null` blank, so that what follows keeps its line and column.
fn without_nulls(text: &[u8]) -> Cow<'_, [u8]> {
    let mut changed = Cow::Borrowed(text);
    // Where the last string began.
    let (mut string, mut at) = (0, 0);
    while at < text.len() {
        match text[at] {
            b'"' => {
                string = at;
                at = end_of_string(text, at);
            }
            b'n' if text[at..].starts_with(b"null") => {
                let is_member =
                    matches!(before(text, at), Some((i, b':')) if matches!(before(text, i), Some((_, b'"'))));
                if is_member {
                    blank(changed.to_mut(), string, at + 4);
                }
                at += 4;
            }
            _ => at += 1,
        }
    }
    changed
}

/// The place behind the string that begins here.
fn end_of_string(text: &[u8], begin: usize) -> usize {
    let mut at = begin + 1;
    while at < text.len() && text[at] != b'"' {
        at += if text[at] == b'\\' { 2 } else { 1 };
    }
    at + 1
}

/// The last byte before a place that is not space, and where it is.
fn before(text: &[u8], at: usize) -> Option<(usize, u8)> {
    let at = text[..at].iter().rposition(|byte| !byte.is_ascii_whitespace())?;
    Some((at, text[at]))
}

/// Makes a member of an object blank, and the comma that separates it from the next, or else from the last.
fn blank(text: &mut [u8], begin: usize, end: usize) {
    let next = text[end..].iter().position(|byte| !byte.is_ascii_whitespace()).map(|offset| end + offset);
    match (next, before(text, begin)) {
        (Some(comma), _) if text[comma] == b',' => text[comma] = b' ',
        (Some(brace), Some((comma, b','))) if text[brace] == b'}' => text[comma] = b' ',
        (Some(brace), _) if text[brace] == b'}' => {}
        // Whatever stands there is no JSON.
        _ => return,
    }
    text[begin..end].fill(b' ');
}

/// The strings of a list that may be anything.
fn strings(list: Option<&Value>) -> Vec<&str> {
    list.and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_str).collect()
}

/// Whether a file of this `asset` may be read: of version 2, and not in need of a later 2.x.
fn check_version(asset: Option<&Value>) -> std::result::Result<(), String> {
    // Some write it as a number.
    let text = |key: &str| match asset?.get(key)? {
        Value::String(text) => Some(text.trim().to_owned()),
        Value::Number(number) => Some(number.to_string()),
        _ => None,
    };
    let parts = |version: &str| -> Option<(u32, u32)> {
        let (major, minor) = version.split_once('.').unwrap_or((version, "0"));
        Some((major.parse().ok()?, minor.parse().ok()?))
    };
    let Some(version) = text("version") else {
        return Err("it has no asset.version, which every glTF has".into());
    };
    if parts(&version).is_none_or(|(major, _)| major != 2) {
        return Err(format!("it is of glTF version {version}; only version 2 can be read"));
    }
    match text("minVersion") {
        Some(needed) if parts(&needed).is_none_or(|needed| needed > (2, 0)) => {
            Err(format!("it needs a reader of glTF version {needed}; version 2.0 is what can be read"))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
#[path = "gltf_json_tests.rs"]
mod tests;
