//! The window on a virtual display while it moves, at rest, and while something long is rendered: what it reaches and that it
//! answers. Where there is no Xvfb these tests say so and skip. How fast it is is printed and not asserted.
#![cfg(feature = "window")]

mod support;

use std::path::Path;
use std::process::{Child, Command};
use std::time::{Duration, Instant};

use support::xvfb::Xvfb;
use support::{Run, program, run};

/// Longest that anything here may take on two slow cores.
const PATIENCE: Duration = Duration::from_secs(120);
/// A whole frame of brute force with these takes many minutes.
const ENDLESS: &str = "--technique brute-force --vpls 100000 --size 320x180";

fn display() -> Option<Xvfb> {
    let display = Xvfb::start(640, 400);
    if display.is_none() {
        println!("skipped: there is no Xvfb (Debian: apt install xvfb)");
    }
    display
}

/// The program with a script, its files in `folder`.
fn with_script(display: &Xvfb, folder: &Path, script: &str, options: &str) -> Command {
    let file = folder.join("s.txt");
    std::fs::write(&file, script).unwrap();
    let mut command = program();
    display.show(&mut command).current_dir(folder).args(["-vv", "--validation", "--script", file.to_str().unwrap()]);
    command.args(options.split_whitespace());
    command
}

fn assert_clean(run: &Run) {
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(!run.stderr.contains("validation:"), "{}", run.stderr);
    assert!(run.stderr.contains("device memory: 0 allocations leaked"), "{}", run.stderr);
}

/// What the log says of the frames that have completed: quality, and how many are in the mean.
fn frames(log: &str) -> Vec<(String, u32)> {
    let frame = |line: &str| {
        let (_, rest) = line.split_once("frame ")?;
        let (_, rest) = rest.split_once(": ")?;
        let (quality, rest) = rest.split_once(", ")?;
        Some((quality.to_owned(), rest.strip_suffix(" accumulated")?.parse().ok()?))
    };
    log.lines().filter_map(frame).collect()
}

/// Ends a program whatever happens.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn wait_for(what: &str, mut is_there: impl FnMut() -> bool) {
    let start = Instant::now();
    while !is_there() {
        assert!(start.elapsed() < PATIENCE, "{what}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// From the first picture in steps to all pixels and the limit of the mean, and not beyond; then again after a move.
#[test]
fn a_window_at_rest_becomes_whole() {
    let Some(display) = display() else { return };
    let folder = tempfile::tempdir().unwrap();
    let script = "at 134 render whole.png\nat 135 key w 2\nat 138 quit\n";
    // Larger than the picture of a window that moves, and cheap.
    let options = "--size 256x144 --technique direct --camera court";
    let start = Instant::now();
    let run = run(with_script(&display, folder.path(), script, options));
    assert_clean(&run);
    let frames = frames(&run.stderr);
    println!("{} frames in {:.1} s", frames.len(), start.elapsed().as_secs_f64());
    let first = |quality: &str| frames.iter().position(|frame| frame.0 == quality).unwrap_or(usize::MAX);
    assert!(first("Moving") < first("Full") && first("Full") < frames.len(), "{frames:?}");
    let most = frames.iter().map(|frame| frame.1).max().unwrap();
    assert_eq!(most, 128, "{frames:?}");
    let ends = frames.windows(2).filter(|pair| pair[0].1 == 128).map(|pair| pair[1].0.as_str());
    assert!(ends.clone().all(|quality| quality == "Moving") && ends.count() == 1, "idle until the move: {frames:?}");
    let whole = image::open(folder.path().join("whole.png")).unwrap();
    assert_eq!((whole.width(), whole.height()), (256, 144));
}

/// Frames per second while the camera flies, and how long after that all pixels are there, and then all samples that the settings
/// ask for: printed, in a window of the size in the environment (`GRIDLIGHT_FLIGHT_SIZE=1280x720`) or a small one.
#[test]
fn flying_and_coming_to_rest() {
    const FLIGHT_FRAMES: u32 = 24;
    let size = std::env::var("GRIDLIGHT_FLIGHT_SIZE").unwrap_or_else(|_| "320x180".to_owned());
    let (width, height) = size.split_once('x').expect("a size such as 1280x720");
    let Some(display) = Xvfb::start(width.parse().unwrap(), height.parse().unwrap()) else { return };
    let folder = tempfile::tempdir().unwrap();
    // From the second picture on, when everything is compiled.
    let script = format!("at 2 key w {FLIGHT_FRAMES}\n");
    let mut command = with_script(&display, folder.path(), &script, &format!("--size {size} --camera court"));
    let log = folder.path().join("log");
    let started = Instant::now();
    let _running = Running(command.stderr(std::fs::File::create(&log).unwrap()).spawn().unwrap());
    let log = || std::fs::read_to_string(&log).unwrap();
    // From the first mention of one thing to the first of another after it.
    let between = |from: &str, to: &str| -> Option<String> {
        let text = log();
        let (_, rest) = text.split_once(from)?;
        Some(rest.split_once(to)?.0.to_owned())
    };
    wait_for("there is no picture", || !frames(&log()).is_empty());
    let first = started.elapsed();
    wait_for("the flight does not begin", || log().contains("Press(KeyW)"));
    let begun = Instant::now();
    wait_for("the flight does not end", || between("Press(KeyW)", "Release(KeyW)").is_some());
    let landed = Instant::now();
    let flown = frames(&between("Press(KeyW)", "Release(KeyW)").unwrap());
    let moving = flown.iter().filter(|frame| frame.0 == "Moving").count();
    let after = |count: u32| {
        wait_for("the picture does not become whole", || {
            log()
                .split_once("Release(KeyW)")
                .is_some_and(|(_, rest)| frames(rest).contains(&("Full".to_owned(), count)))
        });
        landed.elapsed().as_secs_f64()
    };
    let (whole, sampled) = (after(1), after(4));
    println!(
        "{size}: first picture after {:.1} s, {:.1} frames/s in flight, all pixels {whole:.1} s and all samples {sampled:.1} s \
         after it",
        first.as_secs_f64(),
        moving as f64 / (landed - begun).as_secs_f64()
    );
    assert!(moving > 0, "no frame is of a moving camera");
    assert!(!log().contains("validation:"), "{}", log());
}

/// What the lights need is measured while the window goes on: settings may change again meanwhile, and the last ones count.
#[test]
fn settings_change_while_lights_are_measured() {
    let Some(display) = display() else { return };
    let folder = tempfile::tempdir().unwrap();
    // The device refuses so many lights, which is known only once they have been measured.
    let script = "at 1s set vpls 60000\nat 1.05s set vpls 30000\nat 4s set vpls 500000000\nat 25s set vpls 20000\n\
                  at 25s set alpha 0.5\nat 27s render last\nat 28s quit\n";
    let run = run(with_script(&display, folder.path(), script, "--size 64x36 --render-scale 1 --camera court"));
    assert_clean(&run);
    assert!(run.stderr.contains("--vpls 500000000 does not fit this device"), "{}", run.stderr);
    let saved = gridlight::settings::Settings::read(&folder.path().join("last.toml")).unwrap();
    assert_eq!((saved.many_lights.vpls, saved.lgh.alpha), (20_000, 0.5));
}

/// What is shown, and the picture of the settings, are saved while the mean goes on for as long as it likes.
#[test]
fn pictures_are_saved_before_the_mean_ends() {
    let Some(display) = display() else { return };
    let folder = tempfile::tempdir().unwrap();
    let script = "at 2s screenshot shown.exr\nat 2s render whole.exr\n";
    let options = "--size 160x90 --camera court --vpls 2000 --accumulate 1000000";
    let _running = Running(with_script(&display, folder.path(), script, options).spawn().unwrap());
    for picture in ["shown.exr", "whole.exr"] {
        wait_for(&format!("{picture} is not saved"), || folder.path().join(picture).exists());
        let (width, height, _) = gridlight::files::pictures::read_exr(folder.path().join(picture)).unwrap();
        assert!((1..=160).contains(&width) && (1..=90).contains(&height), "{picture}: {width}x{height}");
    }
}

/// The time that a process has had on any core, in seconds.
#[cfg(target_os = "linux")]
fn processor_seconds(id: u32) -> f64 {
    let stat = std::fs::read_to_string(format!("/proc/{id}/stat")).unwrap();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap().split_whitespace().collect();
    (fields[11].parse::<f64>().unwrap() + fields[12].parse::<f64>().unwrap()) / 100.0
}

#[cfg(target_os = "linux")]
#[test]
fn a_finished_window_idles() {
    let Some(display) = display() else { return };
    let folder = tempfile::tempdir().unwrap();
    let done = folder.path().join("done.toml");
    let script = "at 4 save-settings done.toml\n";
    let options = "--size 64x36 --technique direct --camera court --render-scale 1 --accumulate 3";
    let running = Running(with_script(&display, folder.path(), script, options).spawn().unwrap());
    wait_for("the script does not end", || done.exists());
    let idle = || {
        let before = processor_seconds(running.0.id());
        std::thread::sleep(Duration::from_secs(2));
        processor_seconds(running.0.id()) - before
    };
    // The note of the keys is still there at first.
    let spent: Vec<f64> = (0..5).map(|_| idle()).take_while(|spent| *spent > 0.1).collect();
    println!("processor seconds in 2 s each: {spent:?}");
    assert!(spent.len() < 5, "it never idles: {spent:?}");
}

/// Brute force of many minutes: its first picture is the hierarchy's, then it shows what it has, and it ends when the window
/// is told to, in the midst of a frame.
#[cfg(unix)]
#[test]
fn brute_force_shows_what_it_has_and_ends_at_once() {
    let Some(display) = display() else { return };
    let folder = tempfile::tempdir().unwrap();
    // The second frame is the first that brute force has rendered, be it a part.
    let mut command = with_script(&display, folder.path(), "at 2 save-settings part.toml\n", ENDLESS);
    command.stderr(std::fs::File::create(folder.path().join("log")).unwrap());
    let mut running = Running(command.spawn().unwrap());
    wait_for("brute force shows nothing", || folder.path().join("part.toml").exists());
    std::thread::sleep(Duration::from_millis(500));
    let asked = Instant::now();
    let id = running.0.id().to_string();
    assert!(Command::new("kill").args(["-TERM", &id]).status().unwrap().success());
    wait_for("the window does not close", || running.0.try_wait().unwrap().is_some());
    println!("closed {:.2} s after it was asked to", asked.elapsed().as_secs_f64());
    let log = std::fs::read_to_string(folder.path().join("log")).unwrap();
    let frames = frames(&log);
    assert_eq!(frames[0].0, "Moving", "{frames:?}");
    assert!(frames[1..].iter().any(|(quality, whole)| quality == "Full" && *whole == 0), "{frames:?}");
    assert!(!log.contains("validation:"), "{log}");
}

/// The panel is drawn while a frame goes on that has not shown anything yet.
#[test]
fn the_panel_does_not_wait() {
    let Some(display) = display() else { return };
    let folder = tempfile::tempdir().unwrap();
    let script = "at 6s save-settings before.toml\nat 7s panel\n";
    let _running = Running(with_script(&display, folder.path(), script, ENDLESS).spawn().unwrap());
    let (width, height) = (320, 180);
    let panel = |screen: &[u8]| -> Vec<u8> {
        // Near its right edge, where nothing else is drawn.
        (20..160).flat_map(|y| screen[3 * (width * y + 300)..3 * (width * y + 318)].to_vec()).collect()
    };
    wait_for("the script does not begin", || folder.path().join("before.toml").exists());
    let before = panel(&display.corner(width, height));
    let asked = Instant::now() + Duration::from_secs(1);
    wait_for("the panel is not drawn", || {
        let now = panel(&display.corner(width, height));
        let different = now.iter().zip(&before).filter(|(a, b)| a.abs_diff(**b) > 8).count();
        different > now.len() / 2
    });
    println!("the panel is there {:.2} s after it was asked for", Instant::now().duration_since(asked).as_secs_f64());
}
