//! The committed SPIR-V, embedded in the binary by `build.rs` from `shaders/spirv/`, and what has been compiled anew since
//! the program runs.

use std::collections::BTreeMap;
use std::sync::{PoisonError, RwLock};

use super::interface::{self, Interface};
use crate::error::{Error, Result};

include!(concat!(env!("OUT_DIR"), "/spirv_table.rs"));

/// A compiled shader.
pub struct Spirv {
    /// Hash of its source.
    hash: String,
    words: Vec<u32>,
    interface: Interface,
}

impl Spirv {
    /// SPIR-V with the hash of its source, and what it asks for.
    #[must_use]
    pub fn new(hash: String, words: Vec<u32>, interface: Interface) -> Self {
        Self { hash, words, interface }
    }
}

static REPLACED: RwLock<BTreeMap<String, Spirv>> = RwLock::new(BTreeMap::new());

/// The SPIR-V words of the shader variant `name`, as in `gbuffer/draw_scene.frag`.
///
/// # Errors
/// When no such variant was compiled into `shaders/spirv/`.
pub fn words(name: &str) -> Result<Vec<u32>> {
    if let Some(replacement) = REPLACED.read().unwrap_or_else(PoisonError::into_inner).get(name) {
        return Ok(replacement.words.clone());
    }
    let bytes = SPIRV_TABLE
        .binary_search_by(|(key, _)| (*key).cmp(name))
        .map(|index| SPIRV_TABLE[index].1)
        .map_err(|_| Error::Failure(format!("shader `{name}` is not in shaders/spirv (run tools/compile-shaders)")))?;
    Ok(to_words(bytes))
}

/// What the shader variant `name` asks for.
///
/// # Errors
/// When no such variant was compiled into `shaders/spirv/`.
pub fn interface(name: &str) -> Result<Interface> {
    let replaced = REPLACED.read().unwrap_or_else(PoisonError::into_inner).get(name).map(|r| r.interface.clone());
    let missing =
        || Error::Failure(format!("shader `{name}` has no interface in shaders/spirv (run tools/compile-shaders)"));
    replaced.or_else(|| interface::embedded().get(name).cloned()).ok_or_else(missing)
}

/// The words of SPIR-V as bytes.
#[must_use]
pub fn to_words(bytes: &[u8]) -> Vec<u32> {
    bytes.chunks_exact(4).map(|c| u32::from_le_bytes([c[0], c[1], c[2], c[3]])).collect()
}

/// Puts other SPIR-V in use, or the embedded one for `None`; gives what was in use in its place.
pub fn replace(name: &str, spirv: Option<Spirv>) -> Option<Spirv> {
    let mut replaced = REPLACED.write().unwrap_or_else(PoisonError::into_inner);
    match spirv {
        Some(spirv) => replaced.insert(name.to_owned(), spirv),
        None => replaced.remove(name),
    }
}

/// Hash of the source of the SPIR-V in use that replaces the embedded one, if any does.
#[must_use]
pub fn replaced_hash(name: &str) -> Option<String> {
    REPLACED.read().unwrap_or_else(PoisonError::into_inner).get(name).map(|replacement| replacement.hash.clone())
}

/// Hash of the source of the SPIR-V in use.
#[must_use]
pub fn hash_in_use(name: &str) -> Option<String> {
    let embedded = || {
        let manifest = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/spirv/manifest.json"));
        serde_json::from_str::<BTreeMap<String, String>>(manifest).ok()?.remove(name)
    };
    replaced_hash(name).or_else(embedded)
}

/// Names of every embedded shader variant, sorted.
pub fn names() -> impl Iterator<Item = &'static str> {
    SPIRV_TABLE.iter().map(|(name, _)| *name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_in_use_can_be_put_back() {
        let name = "tone_map/tone_map.comp";
        let (embedded, hash) = (words(name).unwrap(), hash_in_use(name));
        let other = Spirv::new("a hash".to_owned(), vec![0x0723_0203, 1], interface(name).unwrap());
        let before = replace(name, Some(other));
        assert_eq!((words(name).unwrap(), hash_in_use(name)), (vec![0x0723_0203, 1], Some("a hash".to_owned())));
        assert!(replace(name, before).is_some());
        assert_eq!((words(name).unwrap(), hash_in_use(name)), (embedded, hash));
    }
}
