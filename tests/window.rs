//! The window on a virtual display. Where there is no Xvfb these tests say so and skip.
#![cfg(feature = "window")]

mod support;

use std::path::Path;
use std::process::Child;
use std::time::{Duration, Instant};

use gridlight::files::pictures::write_exr;
use gridlight::settings::{EnvironmentSource, Settings};
use support::golden::{self, SIZE};
use support::xvfb::Xvfb;
use support::{Run, program, run, succeed};

/// Longest that a run may take on two slow cores.
const PATIENCE: Duration = Duration::from_secs(120);
/// Largest difference of a value on the screen and in the screenshot: they are rounded twice where the driver encodes.
const ROUNDING: u8 = 3;

/// The built-in scene as a file.
const COURT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/courtyard.glb");

fn display() -> Option<Xvfb> {
    let display = Xvfb::start(800, 600);
    if display.is_none() {
        println!("skipped: there is no Xvfb (Debian: apt install xvfb)");
    }
    display
}

fn write(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

/// Runs the program with a script under validation, and with a surface that is lost once.
fn run_script(display: &Xvfb, script: &str, options: &str) -> Run {
    let mut command = program();
    display.show(&mut command).args(["-v", "--validation", "--script", script]).args(options.split_whitespace());
    command.env("GRIDLIGHT_LOSE_SURFACE", "3");
    let run = run(command);
    assert_eq!(run.stderr.matches("surface was lost").count(), 1, "{}", run.stderr);
    run
}

/// Nothing was reported, nothing left behind.
fn assert_clean(run: &Run) {
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(!run.stderr.contains("validation:"), "{}", run.stderr);
    assert!(run.stderr.contains("device memory: 0 allocations leaked"), "{}", run.stderr);
}

/// Sizes that a user drags a window through, tiny and empty ones among them.
fn hundred_sizes() -> Vec<(u32, u32)> {
    let edge = |i: u32, step: u32| match (i * step) % 11 {
        0 => 1,
        1 => 2,
        n => 13 * n,
    };
    (0..100).map(|i| if i % 25 == 7 { (0, 0) } else { (edge(i, 3), edge(i, 7)) }).collect()
}

#[test]
fn resized_a_hundred_times() {
    let Some(display) = display() else { return };
    let folder = tempfile::tempdir().unwrap();
    let mut script = String::new();
    for (i, (width, height)) in hundred_sizes().into_iter().enumerate() {
        script += &format!("at {} resize {width}x{height}\n", 2 + i);
    }
    script += "at 103 resize 160x90\nat 110 quit\n";
    let script = write(folder.path(), "s.txt", &script);
    let run = run_script(&display, &script, "--size 160x90 --render-scale 0.5 --vpls 300 --shadow-samples 1");
    assert_clean(&run);
    let swapchains = run.stderr.matches("swapchain:").count();
    assert!(swapchains > 60, "the window had {swapchains} sizes:\n{}", run.stderr);
}

/// What frames take over from those before, through other sizes, moments, cameras and techniques.
#[test]
fn antialiased_whatever_comes_between() {
    let Some(display) = display() else { return };
    let folder = tempfile::tempdir().unwrap();
    let script = "at 4 look 20 -5
at 6 key w 2
at 8 resize 100x60
at 11 time 3
at 13 time 0.5
at 15 set technique direct
at 17 set taa off
at 18 resize 64x40
at 19 set taa on
at 21 set technique path-trace
at 22 set view normal
at 24 set view final
at 26 camera 1
at 28 pause
at 30 quit
";
    let script = write(folder.path(), "s.txt", script);
    let options =
        "--size 96x54 --render-scale 1 --taa on --temporal shadows --animation object --vpls 500 --shadow-samples 1";
    let run = run_script(&display, &script, options);
    assert_clean(&run);
    assert!(run.stderr.contains("path-trace is a reference, which frames before would only blur"), "{}", run.stderr);
}

/// Some drivers call every swapchain of a size suboptimal.
#[test]
fn a_swapchain_that_stays_suboptimal_is_made_anew_once_for_each_size() {
    let Some(display) = display() else { return };
    let folder = tempfile::tempdir().unwrap();
    let script = write(folder.path(), "s.txt", "at 12 resize 120x80\nat 24 quit\n");
    let mut command = program();
    display.show(&mut command).args(["-v", "--validation", "--script", &script]);
    command.args(["--size", "96x54", "--render-scale", "1", "--technique", "direct"]).env("GRIDLIGHT_SUBOPTIMAL", "1");
    let run = run(command);
    assert_clean(&run);
    for size in ["96x54", "120x80"] {
        let made = run.stderr.lines().filter(|line| line.contains("swapchain:") && line.contains(size)).count();
        assert_eq!(made, 2, "swapchains of {size}, the first one and the one that was tried:\n{}", run.stderr);
    }
}

/// Everything else that a user does: the panel, minimising, other techniques and settings, a scene that is dropped and
/// one that cannot be read, the sun, the camera, screenshots.
#[test]
fn used_in_every_way() {
    let Some(display) = display() else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let bad = write(folder.path(), "bad.glb", "this is no scene");
    let script = format!(
        "# every action
at 2 panel
at 4 key w 2
at 4 look 20 -5
at 6 key right 2
at 8 set technique direct
at 10 set technique brute-force
at 12 set technique lgh
at 14 set view light-count
at 16 set view final
at 17 set alpha 2
at 18 set interleave 2
at 20 set vpls 0
at 22 minimise
at 24 restore
at 26 drop {bad}
at 28 drop {}
at 30 set exposure 4
at 30 set interleave 1
at 30 set alpha 1
at 30 set shadow-samples 16
at 30 camera 1
at 31 set accumulate 4
at 38 set accumulate 1
at 40 screenshot {}
at 41 set vpl-importance none
at 41 look 30 -10
at 41 set sun 300,40
at 46 screenshot {}
at 47 save-settings {}
at 48 load-settings {}
at 48 panel
at 48 pause
at 49 step
at 49 fullscreen
at 50 swap
at 51 key c
at 51 inspect 0.5 0.5
at 53 set technique path-trace
at 53 set accumulate 3
at 57 key x
at 59 divider 0.25
at 60 set view level-weights
at 62 set view final
at 63 set vpls 500
at 65 inspect
at 66 key i
at 67 drop {court}
at 69 resize 100x60
at 71 resize 0x0
at 72 resize 160x90
at 73 screenshot {split}
at 74 split
at 76 quit
",
        COURT,
        file("lgh.png"),
        file("all"),
        file("saved.toml"),
        file("saved.toml"),
        court = COURT,
        split = file("split"),
    );
    let script = write(folder.path(), "s.txt", &script);
    let run = run_script(&display, &script, "--size 160x90 --render-scale 1 --vpls 2000");
    assert_clean(&run);
    assert!(run.stderr.contains("vpls must be at least 1, not 0"), "{}", run.stderr);
    assert!(run.stderr.contains("bad.glb: "), "{}", run.stderr);
    let picture = golden::load(&folder.path().join("lgh.png")).unwrap();
    golden::compare(&picture, &golden::golden("arcade-lgh")).unwrap();
    let both = ["split.exr", "split.png", "split.toml", "split-left.exr", "split-left.png", "split-left.toml"];
    for name in ["all.exr", "all.png", "all.toml", "saved.toml"].iter().chain(&both) {
        assert!(folder.path().join(name).exists(), "{name} is missing");
    }
    let sides = ["split", "split-left"].map(|name| golden::load(&folder.path().join(name).with_extension("png")));
    assert_ne!(sides[0].as_ref().unwrap(), sides[1].as_ref().unwrap());
    the_settings_give_the_picture(folder.path());
}

/// Images that are dropped become the environment, and one that cannot be read leaves the one before; a sky follows the sun.
#[test]
fn environments_come_and_go() {
    let Some(display) = display() else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let texels: Vec<f32> = (0..3 * 8 * 4).map(|i| i as f32 / 96.0).collect();
    let mut image = std::io::Cursor::new(Vec::new());
    write_exr(&mut image, 8, 4, &texels, "").unwrap();
    std::fs::write(file("image.exr"), image.into_inner()).unwrap();
    let bad = write(folder.path(), "bad.exr", "this is no image");
    let script = format!(
        "at 2 drop {image}
at 3 camera 1
at 4 set environment-turn 90
at 5 set environment-scale 2
at 6 drop {bad}
at 8 save-settings {kept}
at 9 set environment sky
at 11 key right 3
at 18 set environment-turn -30
at 22 set environment 1,0.5,0.25
at 24 split
at 25 set environment none
at 28 save-settings {last}
at 30 quit
",
        image = file("image.exr"),
        kept = file("kept.toml"),
        last = file("last.toml"),
    );
    let script = write(folder.path(), "s.txt", &script);
    let run = run_script(&display, &script, "--size 96x54 --render-scale 1 --vpls 500 --shadow-samples 1");
    assert_clean(&run);
    assert!(run.stderr.contains("bad.exr: the environment cannot be read"), "{}", run.stderr);
    let [kept, last] = ["kept.toml", "last.toml"].map(|name| Settings::read(&folder.path().join(name)).unwrap());
    assert_eq!(kept.environment.source, Some(EnvironmentSource::File(file("image.exr").into())));
    assert_eq!((kept.environment.scale, kept.environment.turn_deg), (2.0, 90.0));
    // Camera and sun have stayed where they were while the scene was lit anew.
    assert_eq!((kept.scene.camera.is_some(), kept.scene.camera), (true, last.scene.camera));
    assert!(kept.scene.sun.is_none() && last.scene.sun.is_some());
    assert_eq!(last.environment.source, Some(EnvironmentSource::None));
}

/// A run without a window, with the settings beside a screenshot of a flown camera, gives that screenshot; with light paths
/// that start anywhere, for a window chooses starts by the camera that it had when the lights were measured.
fn the_settings_give_the_picture(folder: &Path) {
    let path = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    succeed(&["--headless", "--quiet", "--settings", &path("all.toml"), "--output", &path("again.png")]);
    let [shown, again] = ["all.png", "again.png"].map(|name| golden::load(&folder.join(name)).unwrap());
    let different =
        |a: &[u8], b: &[u8]| a.iter().zip(b).filter(|(a, b)| a.abs_diff(**b) > 2).count() as f64 / a.len() as f64;
    let share = different(&shown, &again);
    assert!(share < 1e-3, "{share} of the values differ");
    // The frame before it was seen from elsewhere.
    assert!(different(&golden::load(&folder.join("lgh.png")).unwrap(), &again) > 0.1);
}

/// Waits until a program has written a file.
fn wait_for(file: &Path) {
    let start = Instant::now();
    while !file.exists() {
        assert!(start.elapsed() < PATIENCE, "there is no {}", file.display());
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// The screen as soon as it is as wanted, or what is on it when it has not been for long.
fn screen_when(display: &Xvfb, is_wanted: impl Fn(&[u8]) -> bool) -> Vec<u8> {
    let start = Instant::now();
    loop {
        let screen = display.corner(SIZE.0 as usize, SIZE.1 as usize);
        if is_wanted(&screen) || start.elapsed() > PATIENCE / 4 {
            return screen;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// What is on the screen left and right of the divider is what the two sides' screenshots hold.
#[test]
fn a_split_view_shows_both_sides() {
    let Some(display) = display() else { return };
    let folder = tempfile::tempdir().unwrap();
    let done = folder.path().join("done.toml");
    let script = format!(
        "at 0 set exposure 1\nat 1 split\nat 2 divider 0.7\nat 2 set view albedo\nat 6 screenshot {}\nat 7 \
         save-settings {}\n",
        folder.path().join("s").display(),
        done.display()
    );
    let script = write(folder.path(), "s.txt", &script);
    let mut command = program();
    display.show(&mut command).args(["--script", &script]);
    command.args("--size 160x90 --render-scale 1 --technique direct --camera court".split(' '));
    let _running = Running(command.spawn().unwrap());
    wait_for(&done);
    let [right, left] = ["s.png", "s-left.png"].map(|name| golden::load(&folder.path().join(name)).unwrap());
    golden::compare(&left, &golden::golden("court-direct")).unwrap();
    // Below what is written over the sides, once the note at the bottom is gone; left and right of the divider at 112.
    let strip = |picture: &[u8], columns: std::ops::Range<usize>| -> Vec<u8> {
        let row = |y: usize| picture[3 * (SIZE.0 as usize * y + columns.start)..][..3 * columns.len()].to_vec();
        (65..88).flat_map(row).collect()
    };
    let compare = |screen: &[u8], left: &[u8], right: &[u8]| {
        let most = |a: Vec<u8>, b: Vec<u8>| a.iter().zip(&b).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(255);
        let left = most(strip(screen, 2..100), strip(left, 2..100));
        left.max(most(strip(screen, 124..158), strip(right, 124..158))) <= ROUNDING
    };
    let screen = screen_when(&display, |screen| compare(screen, &left, &right));
    assert!(compare(&screen, &left, &right), "the screen shows something else");
    assert!(!compare(&screen, &right, &left), "the sides are told apart");
}

/// Ends a program whatever happens.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Why the screen does not show the picture, if it does not. Only the upper half: notes may lie below.
fn compare_screen(screen: &[u8], picture: &[u8]) -> Result<(), String> {
    let half = 3 * (SIZE.0 * (SIZE.1 / 2)) as usize;
    let most = screen[..half].iter().zip(picture).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(255);
    if most <= ROUNDING { Ok(()) } else { Err(format!("screen and screenshot differ by {most} of 255")) }
}

/// Shows the built-in scene and compares the screen with the screenshot, which is compared with a golden.
fn the_screen_shows_the_picture(format: &str) -> Option<(Vec<u8>, Vec<u8>)> {
    let display = display()?;
    let folder = tempfile::tempdir().unwrap();
    let png = folder.path().join("a.png");
    let script = write(folder.path(), "s.txt", &format!("at 4 screenshot {}\n", png.display()));
    let mut command = program();
    display.show(&mut command).env("GRIDLIGHT_SURFACE_FORMAT", format).args(["--script", &script]);
    command.args(
        "--size 160x90 --render-scale 1 --technique direct --camera court --exposure 1 --tone-map reinhard".split(' '),
    );
    let _running = Running(command.spawn().unwrap());
    wait_for(&png);
    let picture = golden::load(&png).unwrap();
    golden::compare(&picture, &golden::golden("court-direct")).unwrap();
    let screen = screen_when(&display, |screen| compare_screen(screen, &picture).is_ok());
    compare_screen(&screen, &picture).unwrap();
    Some((screen, picture))
}

#[test]
fn the_screen_shows_the_picture_as_it_is() {
    let Some((screen, picture)) = the_screen_shows_the_picture("linear") else { return };
    // Planted faults: upside down, and encoded twice.
    let flipped: Vec<u8> = screen.chunks_exact(3 * SIZE.0 as usize).rev().flatten().copied().collect();
    assert!(compare_screen(&flipped, &picture).is_err());
    let encoded: Vec<u8> = screen.iter().map(|v| (255.0 * (f32::from(*v) / 255.0).powf(1.0 / 2.2)) as u8).collect();
    assert!(compare_screen(&encoded, &picture).is_err());
}

#[test]
fn the_screen_shows_the_picture_where_the_driver_encodes() {
    the_screen_shows_the_picture("srgb");
}

/// What a run that cannot open a window says; it has one line.
fn refused(options: &[&str], display: &str) -> String {
    let mut command = program();
    command.args(options).env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET").env("DISPLAY", display);
    let run = run(command);
    assert_eq!(run.code, Some(2), "{}", run.stderr);
    assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
    run.stderr
}

#[test]
fn without_a_display_one_sentence_points_to_headless() {
    for display in ["", ":4095"] {
        let sentence = refused(&[], display);
        assert!(sentence.contains("no display") && sentence.contains("--headless"), "{sentence}");
    }
}

#[test]
fn a_wrong_script_is_named_with_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let script = write(folder.path(), "wrong.txt", "at 1 panel\nat 2 dance\n");
    let sentence = refused(&["--script", &script], "");
    assert!(sentence.contains("wrong.txt, line 2: there is no action `dance`"), "{sentence}");
}
