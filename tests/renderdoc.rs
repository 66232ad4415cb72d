//! `--renderdoc-frame` against a library that stands for RenderDoc's, and without any.
#![cfg(target_os = "linux")]

mod support;

use std::path::Path;
use std::process::Command;

use support::{Run, program, run};

/// Compiles the stand-in into `folder`.
fn fake_renderdoc(folder: &Path) {
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/support/fake_renderdoc.c");
    let mut compiler = Command::new("cc");
    compiler.args(["-shared", "-fPIC", "-w", "-o"]).arg(folder.join("librenderdoc.so")).arg(source);
    assert!(compiler.status().unwrap().success());
}

/// A run of four frames in `folder`, where the library may be.
fn render(folder: &Path, options: &str, fails: bool) -> Run {
    let mut command = program();
    command.args("--headless --size 32x18 --technique direct --frames 3 --warmup 1".split(' '));
    command.args(options.split(' ')).current_dir(folder);
    command.env("LD_LIBRARY_PATH", folder).env("FAKE_RENDERDOC_LOG", folder.join("log"));
    if fails {
        command.env("FAKE_RENDERDOC_FAILS", "1");
    }
    run(command)
}

fn log(folder: &Path) -> String {
    std::fs::read_to_string(folder.join("log")).unwrap_or_default()
}

#[test]
fn one_frame_is_captured() {
    let folder = tempfile::tempdir().unwrap();
    fake_renderdoc(folder.path());
    for frame in ["0", "3"] {
        let _ = std::fs::remove_file(folder.path().join("log"));
        let run = render(folder.path(), &format!("--renderdoc-frame {frame}"), false);
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        assert_eq!(log(folder.path()), "no overlay\nstart\nend\n");
        assert!(run.stderr.contains(&format!("captured frame {frame} in gridlight_frame.rdc")), "{}", run.stderr);
        assert!(folder.path().join("gridlight_frame.rdc").exists());
    }
}

#[cfg(feature = "window")]
#[test]
fn one_frame_of_a_window_is_captured() {
    let Some(display) = support::xvfb::Xvfb::start(320, 200) else {
        println!("skipped: there is no Xvfb (Debian: apt install xvfb)");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    fake_renderdoc(folder.path());
    // A window renders when something changes.
    let script = "at 1 look 3 0\nat 2 look 3 0\nat 3 look 3 0\nat 8 quit\n";
    std::fs::write(folder.path().join("s.txt"), script).unwrap();
    let mut command = program();
    display.show(&mut command).current_dir(folder.path());
    command.args("--size 64x36 --render-scale 1 --technique direct --script s.txt --renderdoc-frame 2".split(' '));
    command.env("LD_LIBRARY_PATH", folder.path()).env("FAKE_RENDERDOC_LOG", folder.path().join("log"));
    let run = run(command);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert_eq!(log(folder.path()), "no overlay\nstart\nend\n");
    assert!(run.stderr.contains("captured frame 2 in gridlight_frame.rdc"), "{}", run.stderr);
}

#[test]
fn a_capture_that_fails_is_said() {
    let folder = tempfile::tempdir().unwrap();
    fake_renderdoc(folder.path());
    let run = render(folder.path(), "--renderdoc-frame 1", true);
    assert_eq!(run.code, Some(1), "{}", run.stderr);
    assert!(run.stderr.contains("RenderDoc made no capture of frame 1"), "{}", run.stderr);
}

#[test]
fn without_the_library_one_sentence_says_so() {
    let folder = tempfile::tempdir().unwrap();
    // Not a library: it hides one that is installed.
    std::fs::write(folder.path().join("librenderdoc.so"), "no library").unwrap();
    let run = render(folder.path(), "--renderdoc-frame 1", false);
    assert_eq!((run.code, run.stderr.lines().count()), (Some(2), 1), "{}", run.stderr);
    assert!(run.stderr.contains("--renderdoc-frame needs RenderDoc's library (librenderdoc.so)"), "{}", run.stderr);
    let run = render(folder.path(), "--renderdoc-frame 4", false);
    assert_eq!(run.code, Some(2));
    assert!(run.stderr.contains("renderdoc-frame 4 is never reached: the run has 4 frame(s)"), "{}", run.stderr);
}
