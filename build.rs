//! Embeds the committed SPIR-V and the commit hash.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

fn main() {
    let root = PathBuf::from(env::var("CARGO_MANIFEST_DIR").expect("cargo sets it"));
    let out = PathBuf::from(env::var("OUT_DIR").expect("cargo sets it"));
    println!("cargo::rerun-if-changed=build.rs");
    embed_spirv(&root.join("shaders/spirv"), &out.join("spirv_table.rs"));
    let commit = commit();
    if commit.is_some() {
        watch_head();
    }
    println!("cargo::rustc-env=GRIDLIGHT_COMMIT={}", commit.as_deref().unwrap_or("unknown"));
}

/// Writes a table of (shader name, bytes), sorted by name, that `src/shader/spirv.rs` includes.
fn embed_spirv(dir: &Path, table: &Path) {
    println!("cargo::rerun-if-changed={}", dir.display());
    let mut files: Vec<PathBuf> =
        fs::read_dir(dir).map(|entries| entries.flatten().map(|e| e.path()).collect()).unwrap_or_default();
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

/// The commit of this checkout. A repository that merely contains this folder does not count.
fn commit() -> Option<String> {
    let at_top = git(&["rev-parse", "--show-prefix"])?.is_empty();
    if at_top { git(&["rev-parse", "--short", "HEAD"]) } else { None }
}

/// Runs again when HEAD moves. Files that do not exist are left out: cargo would run every time.
fn watch_head() {
    let reference = git(&["symbolic-ref", "--quiet", "HEAD"]);
    let names = ["HEAD", "logs/HEAD", "packed-refs"].into_iter().chain(reference.as_deref());
    for path in names.filter_map(|name| git(&["rev-parse", "--git-path", name])) {
        if Path::new(&path).exists() {
            println!("cargo::rerun-if-changed={path}");
        }
    }
}

/// What git prints, or `None` when it is missing or fails.
fn git(args: &[&str]) -> Option<String> {
    let output = Command::new("git").args(args).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.trim().to_owned())
}
