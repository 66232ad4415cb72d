//! Embeds the committed SPIR-V and the commit hash.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs};

fn main() {
    let root = PathBuf::from(env::var("CARGO_MANIFEST_DIR").expect("cargo sets it"));
    let out = PathBuf::from(env::var("OUT_DIR").expect("cargo sets it"));
    embed_spirv(&root.join("shaders/spirv"), &out.join("spirv_table.rs"));
}

/// Writes a table of (shader name, bytes), sorted by name, that `src/shader/spirv.rs` includes.
fn embed_spirv(dir: &Path, table: &Path) {
    println!("cargo:rerun-if-changed={}", dir.display());
    let mut files: Vec<PathBuf> = fs::read_dir(dir)
        .map(|entries| entries.flatten().map(|e| e.path()).collect())
        .unwrap_or_default();
    files.retain(|path| path.extension().is_some_and(|e| e == "spv"));
    let mut shaders: Vec<(String, PathBuf)> = files
        .into_iter()
        .map(|path| (path.file_stem().unwrap_or_default().to_string_lossy().replace("__", "/"), path))
        .collect();
    shaders.sort();
    let mut text = String::from("const SPIRV_TABLE: &[(&str, &[u8])] = &[\n");
    for (name, path) in shaders {
        let _ = writeln!(text, "    ({name:?}, include_bytes!({:?})),", path.display().to_string());
    }
    text.push_str("];\n");
    fs::write(table, text).expect("OUT_DIR is writable");
}
