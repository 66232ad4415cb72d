//! What a run finds around it: threads, folders of its own, names that are no files. The picture is the same, to the byte.
#![cfg(unix)]

mod support;

use std::path::Path;
use std::process::Command;

use support::{names, program, quad_glb, run};

fn small(scene: &Path, out: &Path) -> Command {
    let mut command = program();
    command.arg(scene).args(["--headless", "--size", "64x36", "--vpls", "500", "--environment", "none"]);
    command.arg("--output").arg(out);
    command
}

/// A scene, and the picture that a plain run makes of it.
fn scene(folder: &Path) -> (std::path::PathBuf, Vec<u8>) {
    let path = folder.join("scene.glb");
    std::fs::write(&path, quad_glb(|_, _| ())).unwrap();
    let plain = folder.join("plain.exr");
    let run = run(small(&path, &plain));
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    (path, std::fs::read(plain).unwrap())
}

/// lavapipe takes the number of its threads from this variable; other drivers do not know it.
#[test]
fn the_number_of_threads_does_not_show() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, plain) = scene(folder.path());
    for [of_driver, own] in [["1", "1"], ["3", "2"], ["0", "8"]] {
        let out = folder.path().join("a.exr");
        let mut command = small(&scene, &out);
        command.env("LP_NUM_THREADS", of_driver).env("RAYON_NUM_THREADS", own);
        let run = run(command);
        assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""), "{of_driver} threads");
        assert!(std::fs::read(&out).unwrap() == plain, "{of_driver} threads");
    }
}

#[test]
fn folders_of_the_user_may_be_missing_or_closed() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, plain) = scene(folder.path());
    let file = folder.path().join("file");
    std::fs::write(&file, "no folder").unwrap();
    let before = names(folder.path());
    let file = file.to_str().unwrap();
    for (home, cache) in [
        (None, None),
        (Some("/nonexistent"), None),
        (Some("/nonexistent"), Some(file)),
        (Some(file), None),
        (Some(""), Some("")),
        (Some("relative"), Some("also/relative")),
    ] {
        let out = folder.path().join("a.exr");
        let mut command = small(&scene, &out);
        command.current_dir(folder.path());
        for (name, value) in [("HOME", home), ("XDG_CACHE_HOME", cache), ("XDG_RUNTIME_DIR", None), ("TMPDIR", None)] {
            match value {
                Some(value) => command.env(name, value),
                None => command.env_remove(name),
            };
        }
        let run = run(command);
        // The driver may say that it has no cache of its own.
        let own = run.stderr.lines().filter(|line| line.starts_with("warn: ") || line.starts_with("error: "));
        assert_eq!((run.code, own.count()), (Some(0), 0), "{home:?} {cache:?}: {}", run.stderr);
        assert!(std::fs::read(&out).unwrap() == plain, "{home:?} {cache:?}");
        std::fs::remove_file(out).unwrap();
        if home != Some("relative") {
            assert_eq!(names(folder.path()), before, "{home:?} {cache:?}");
        }
    }
}

#[test]
fn streams_are_no_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, _) = scene(folder.path());
    for name in ["/dev/stdout", "/dev/stderr", "/dev/null", "-", "/proc/self/fd/1"] {
        let run = run(small(&scene, Path::new(name)));
        assert_eq!((run.code, run.stderr.lines().count()), (Some(2), 1), "{name}: {}", run.stderr);
        assert!(run.stderr.contains(".exr or .png") && run.stdout.is_empty(), "{name}: {}", run.stderr);
    }
    let link = folder.path().join("link.png");
    std::os::unix::fs::symlink("/dev/stdout", &link).unwrap();
    let run = run(small(&scene, &link));
    assert_eq!(run.code, Some(1), "{}", run.stderr);
    assert!(run.stderr.contains("link.png: cannot be written: it is not a regular file"), "{}", run.stderr);
}
