//! Puts the abbreviated commit into `GRIDLIGHT_COMMIT`, or `unknown` outside a checkout.

use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let commit = commit();
    if commit.is_some() {
        watch_head();
    }
    println!("cargo::rustc-env=GRIDLIGHT_COMMIT={}", commit.as_deref().unwrap_or("unknown"));
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
