//! The committed SPIR-V, embedded in the binary by `build.rs` from `shaders/spirv/`.

use crate::error::{Error, Result};

include!(concat!(env!("OUT_DIR"), "/spirv_table.rs"));

/// The SPIR-V words of the shader variant `name`, as in `gbuffer/draw_scene.frag`.
///
/// # Errors
/// When no such variant was compiled into `shaders/spirv/`.
pub fn words(name: &str) -> Result<Vec<u32>> {
    let bytes = SPIRV_TABLE
        .binary_search_by(|(key, _)| (*key).cmp(name))
        .map(|index| SPIRV_TABLE[index].1)
        .map_err(|_| Error::Failure(format!("shader `{name}` is not in shaders/spirv (run tools/compile-shaders)")))?;
    Ok(bytes.chunks_exact(4).map(|c| u32::from_le_bytes([c[0], c[1], c[2], c[3]])).collect())
}

/// Names of every embedded shader variant, sorted.
pub fn names() -> impl Iterator<Item = &'static str> {
    SPIRV_TABLE.iter().map(|(name, _)| *name)
}
