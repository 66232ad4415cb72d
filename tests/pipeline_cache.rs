//! The pipelines kept between runs: files that are not used, instances at once, and the option that does without.

mod support;

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use support::{Run, names, program, run};

/// The program with a picture of this name, and the user's cache folder in `folder`. What Mesa keeps of its own stays in the
/// build folder, as in other tests.
fn render(folder: &Path, picture: &str) -> Command {
    let mut command = program();
    command.args(["--headless", "--size", "48x27", "--vpls", "300", "--quiet", "--output"]);
    command.arg(folder.join(picture)).env("XDG_CACHE_HOME", folder.join("cache"));
    command.env("MESA_SHADER_CACHE_DIR", Path::new(env!("CARGO_TARGET_TMPDIR")).join("cache"));
    command
}

/// The same with nothing but the pipelines that the program itself has kept.
fn render_without_mesa(folder: &Path, picture: &str) -> Command {
    let mut command = render(folder, picture);
    command.env("MESA_SHADER_CACHE_DISABLE", "true");
    command
}

/// The same with few pipelines, where it does not matter which.
fn render_direct(folder: &Path, picture: &str) -> Command {
    let mut command = render(folder, picture);
    command.args(["--technique", "direct"]);
    command
}

fn silent(run: &Run) {
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
}

/// The only file that is kept.
fn kept(folder: &Path) -> PathBuf {
    let files = names(&folder.join("cache/gridlight"));
    assert_eq!(files.len(), 1, "{files:?}");
    assert!(files[0].starts_with("pipelines-") && files[0].ends_with(".bin"), "{files:?}");
    folder.join("cache/gridlight").join(&files[0])
}

fn same_pictures(folder: &Path, a: &str, b: &str) {
    let bytes = |name: &str| std::fs::read(folder.join(name)).unwrap();
    assert!(bytes(a) == bytes(b), "{a} and {b} differ");
}

#[test]
fn pipelines_are_kept_and_change_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mut without = render(folder, "without.exr");
    without.arg("--no-pipeline-cache");
    silent(&run(without));
    assert!(!folder.join("cache").exists(), "--no-pipeline-cache writes nothing");

    silent(&run(render(folder, "first.exr")));
    let file = kept(folder);
    let good = std::fs::read(&file).unwrap();
    silent(&run(render_without_mesa(folder, "second.exr")));
    assert_eq!(kept(folder), file);

    silent(&run(render_direct(folder, "direct.exr")));
    // One bit of the data: the driver must not see it.
    let mut damaged = good.clone();
    *damaged.last_mut().unwrap() ^= 1;
    for bytes in [b"garbage".to_vec(), Vec::new(), good[..good.len() / 2].to_vec(), damaged] {
        std::fs::write(&file, &bytes).unwrap();
        silent(&run(render_direct(folder, "after.exr")));
        let replaced = std::fs::read(&file).unwrap();
        assert_eq!(replaced[..16], good[..16], "replaced by a good one");
        assert!(replaced != bytes);
        assert_eq!(kept(folder), file);
        same_pictures(folder, "direct.exr", "after.exr");
    }
    same_pictures(folder, "without.exr", "first.exr");
    same_pictures(folder, "first.exr", "second.exr");
}

#[test]
fn instances_at_once_leave_one_good_file() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let start = |picture| render(folder, picture).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let both: [Child; 2] = ["a.exr", "b.exr"].map(start);
    for child in both {
        let output = child.wait_with_output().unwrap();
        assert_eq!((output.status.code(), String::from_utf8_lossy(&output.stderr).as_ref()), (Some(0), ""));
    }
    let file = kept(folder);
    let good = std::fs::read(&file).unwrap();
    same_pictures(folder, "a.exr", "b.exr");
    silent(&run(render(folder, "c.exr")));
    assert_eq!(std::fs::read(file).unwrap()[..16], good[..16]);
    same_pictures(folder, "a.exr", "c.exr");
}

#[test]
fn a_cache_folder_that_cannot_be_made_is_no_error() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("cache")).unwrap();
    std::fs::write(folder.path().join("cache/gridlight"), "a file").unwrap();
    silent(&run(render_direct(folder.path(), "a.exr")));
}
