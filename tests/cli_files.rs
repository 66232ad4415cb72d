//! Files that give no more or take no more: pipes, limits of size, full disks, names that no file may have.
#![cfg(unix)]

mod support;

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use support::{Run, names, program, quad, quad_glb, run};

/// Longest that a run without a frame may take on two slow cores.
const PATIENCE: Duration = Duration::from_secs(20);

fn small(command: &mut Command) -> &mut Command {
    command.args(["--headless", "--size", "64x36", "--vpls", "200", "--technique", "direct"])
}

/// One sentence on stderr with this word, and this exit code.
fn complains(run: &Run, code: i32, word: &str) {
    assert_eq!(run.code, Some(code), "{}", run.stderr);
    assert!(run.stderr.starts_with("error: ") && run.stderr.lines().count() == 1, "{}", run.stderr);
    assert!(run.stderr.contains(word), "no `{word}` in {}", run.stderr);
}

/// The program by way of another command.
fn through(outer: &str, args: &[&str]) -> Command {
    let whole = program();
    let mut command = Command::new(outer);
    command.args(args).arg(whole.get_program());
    for (name, value) in whole.get_envs() {
        match value {
            Some(value) => command.env(name, value),
            None => command.env_remove(name),
        };
    }
    command
}

/// The program under a limit of so many blocks of 512 or 1,024 bytes for each file that it writes.
fn limited(blocks: u32) -> Command {
    through("sh", &["-c", &format!("ulimit -f {blocks}; exec \"$0\" \"$@\"")])
}

#[test]
fn a_limit_of_size_leaves_nothing_half_written() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("a.exr");
    std::fs::write(&out, "old").unwrap();
    let mut command = limited(4);
    small(&mut command).arg("--output").arg(&out);
    let full = run(command);
    complains(&full, 1, "a.exr: cannot be written");
    assert!(!full.stderr.contains(".gridlight-"), "{}", full.stderr);
    assert_eq!((names(folder.path()), std::fs::read(&out).unwrap()), (vec!["a.exr".to_owned()], b"old".to_vec()));
    // Of the files of a dump, a few arrays and each picture fit or do not.
    for blocks in [0, 1, 4, 16, 64] {
        let mut command = limited(blocks);
        small(&mut command).arg("--dump").arg(folder.path().join("dump"));
        is_about_dump(&run(command), folder.path());
        assert_eq!(names(folder.path()), ["a.exr"], "{blocks} blocks");
    }
}

/// A dump that cannot be written is named as it was asked for, not as the temporary folder.
fn is_about_dump(run: &Run, folder: &Path) {
    complains(run, 1, &format!("error: {}", folder.join("dump").display()));
    assert!(run.stderr.contains("cannot be written") && !run.stderr.contains(".gridlight-"), "{}", run.stderr);
}

/// File systems of a few sizes, of which none holds the dump.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_nothing_of_a_dump() {
    let folder = tempfile::tempdir().unwrap();
    for size_kib in [8, 64, 256, 700] {
        // Mounted for this process alone, where users may do that.
        let mount = format!("mount -t tmpfs -o size={size_kib}k none . && cd \"$PWD\" && touch mounted || exit 99");
        let script = format!("{mount}; \"$0\" \"$@\"; code=$?; ls -A >&3; exit $code");
        let list = folder.path().with_extension("list");
        let script = format!("exec 3>'{}'; {script}", list.display());
        let mut command = through("unshare", &["--map-root-user", "--mount", "sh", "-c", &script]);
        command.current_dir(folder.path());
        let run = run({
            small(&mut command).arg("--dump").arg(folder.path().join("dump"));
            command
        });
        let left = std::fs::read_to_string(&list).unwrap_or_default();
        let _ = std::fs::remove_file(&list);
        if !left.starts_with("mounted") {
            println!("skipped: no file system can be mounted here: {}", run.stderr);
            return;
        }
        is_about_dump(&run, folder.path());
        assert_eq!(left, "mounted\n", "{size_kib} KiB");
    }
}

#[test]
fn what_stdout_cannot_take_is_told() {
    let Ok(full) = File::options().write(true).open("/dev/full") else {
        println!("skipped: there is no /dev/full");
        return;
    };
    let told = |arguments: &[&str]| {
        let mut command = program();
        command.args(arguments).stdout(Stdio::from(full.try_clone().unwrap())).stderr(Stdio::piped());
        let output = command.spawn().unwrap().wait_with_output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        complains(&Run { code: output.status.code(), stdout: String::new(), stderr, time: PATIENCE }, 1, "stdout");
    };
    told(&["--help"]);
    told(&["--list-gpus"]);
    told(&["--headless", "--size", "32x18", "--technique", "direct"]);
}

#[test]
fn names_that_no_file_may_have_are_refused_first() {
    let folder = tempfile::tempdir().unwrap();
    let long = "x".repeat(300);
    let cases = [
        ("--output", format!("{long}.exr"), 1, "too long"),
        ("--output", format!("{long}/a.exr"), 1, "too long"),
        ("--timings", format!("{long}.json"), 1, "too long"),
        ("--dump", long, 1, "too long"),
        ("--output", "picture".to_owned(), 2, ".exr or .png"),
        ("--output", ".exr".to_owned(), 2, ".exr or .png"),
        ("--output", String::new(), 2, "--output"),
        ("--timings", "times".to_owned(), 2, ".json or .csv"),
    ];
    for (option, name, code, word) in cases {
        let mut command = program();
        small(&mut command).current_dir(folder.path()).args(["--frames", "4000000000", option, &name]);
        let run = run(command);
        complains(&run, code, word);
        assert!(run.time < PATIENCE, "{option} {name}: {:?}", run.time);
    }
    assert!(names(folder.path()).is_empty());
}

/// A scene by a relative path through folders with spaces and umlauts, and its buffer by a URI that encodes them.
#[test]
fn names_may_have_spaces_and_umlauts() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("räume 2/flügel süd");
    std::fs::create_dir_all(place.join("größe")).unwrap();
    let (mut document, bin) = quad();
    document["buffers"][0]["uri"] = "gr%C3%B6%C3%9Fe/w%C3%A4nde%201.bin".into();
    std::fs::write(place.join("größe/wände 1.bin"), bin).unwrap();
    std::fs::write(place.join("szene 1.gltf"), document.to_string()).unwrap();
    let mut command = program();
    small(&mut command)
        .current_dir(folder.path().join("räume 2"))
        .arg("flügel süd/szene 1.gltf")
        .args(["-o", "bild ä.exr"]);
    let run = run(command);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(folder.path().join("räume 2/bild ä.exr").is_file());
}

/// A pipe in the file system.
fn pipe(folder: &Path) -> PathBuf {
    let path = folder.join("scene.glb");
    assert!(Command::new("mkfifo").arg(&path).status().unwrap().success());
    path
}

fn start(mut command: Command) -> Child {
    command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

#[test]
fn a_scene_may_come_through_a_pipe() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, out) = (pipe(folder.path()), folder.path().join("a.exr"));
    let mut command = program();
    small(&mut command).args(["--environment", "none", "--output"]).arg(&out).arg(&scene);
    let child = start(command);
    std::fs::write(&scene, quad_glb(|_, _| ())).unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(out.exists());
}

#[test]
fn a_silent_pipe_does_not_hold_the_program() {
    let folder = tempfile::tempdir().unwrap();
    let scene = pipe(folder.path());
    let mut command = program();
    small(&mut command).arg("--output").arg(folder.path().join("a.exr")).arg(&scene);
    let (began, child) = (Instant::now(), start(command));
    // Until the device is open a signal ends the program at once.
    std::thread::sleep(Duration::from_secs(3));
    assert!(Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(130), "{stderr}");
    assert!(stderr.contains("interrupted while") && stderr.lines().count() == 1, "{stderr}");
    assert!(began.elapsed() < PATIENCE);
    assert_eq!(names(folder.path()), ["scene.glb"]);
}

#[test]
fn what_is_no_file_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let scene = pipe(folder.path());
    for arguments in [vec!["/dev/zero"], vec!["--settings", "/dev/zero"], vec!["--settings", "/"]] {
        let mut command = program();
        complains(
            &run({
                small(&mut command).args(&arguments);
                command
            }),
            1,
            "it is ",
        );
    }
    let environment = folder.path().join("sky.exr");
    std::fs::rename(scene, &environment).unwrap();
    let mut command = program();
    small(&mut command).arg("--environment").arg(&environment);
    complains(&run(command), 1, "sky.exr: the environment cannot be read: it is not a regular file");
}
