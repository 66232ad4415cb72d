//! Every reader of files against files that are wrong: it answers in time, in one sentence, without a panic, and without
//! more memory than the file is worth.
//!
//! Inputs are numbered, and each is the same in every run: `GRIDLIGHT_FUZZ_FIRST=N GRIDLIGHT_FUZZ_INPUTS=1` repeats one.
//! `GRIDLIGHT_FUZZ_INPUTS` is their number, 4,000 unless said; `GRIDLIGHT_FUZZ_TARGET` chooses one reader, and
//! `GRIDLIGHT_FUZZ_PATIENCE_S` is for machines that have other things to do. What fails is kept in the build folder. Files
//! that once failed, or that would if a reader believed them, are in `corpus/TARGET/`, and are tried first.

mod allocator;
mod bytes;
mod json;
mod mutate;
mod random;
mod seeds;
mod targets;

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{LazyLock, Mutex};
use std::time::{Duration, Instant};

use random::Random;
use seeds::Seed;
use targets::{TARGETS, Target};

/// Inputs of a run where nothing else is said: some seconds.
const INPUTS: u64 = 4000;
/// Longest that one input may take, in seconds.
const PATIENCE_S: u64 = 10;
/// Most memory that a file which is refused may take beyond four times its length.
const ALLOWANCE_BYTES: usize = 64 << 20;
/// The same of WebP: one colour is as short a file at any size, so that its length says nothing of its size.
const WEBP_ALLOWANCE_BYTES: usize = 2 << 30;
/// Longest message about a file, in characters, without its path. One that had to be cut is longer.
const LONGEST_MESSAGE: usize = 900;

/// Held by the test that measures: memory and panics are those of the whole process.
static ALONE: Mutex<()> = Mutex::new(());
/// What the last panic said, wherever it happened: a panic that is caught still writes on stderr.
static PANIC: Mutex<Option<String>> = Mutex::new(None);
/// When the first test began.
static START: LazyLock<Instant> = LazyLock::new(Instant::now);
/// Milliseconds since then at which the input in work began, plus 1; 0 between inputs.
static BEGAN_MS: AtomicU64 = AtomicU64::new(0);

fn setting(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).map_or(otherwise, |text| text.parse().unwrap_or_else(|_| panic!("{name} is no number")))
}

/// Ends the process when an input takes too long: a loop cannot be stopped otherwise.
fn watch(current: PathBuf) {
    let patience_s = setting("GRIDLIGHT_FUZZ_PATIENCE_S", PATIENCE_S);
    std::thread::spawn(move || {
        loop {
            std::thread::sleep(Duration::from_millis(200));
            let began = BEGAN_MS.load(Relaxed);
            if began > 0 && now_ms() - began > 1000 * patience_s {
                eprintln!("an input takes more than {patience_s} s: it is in {}", current.display());
                std::process::exit(1);
            }
        }
    });
}

/// Milliseconds since the start, plus 1.
fn now_ms() -> u64 {
    START.elapsed().as_millis() as u64 + 1
}

fn hear_panics() {
    let print = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if BEGAN_MS.load(Relaxed) == 0 {
            return print(panic);
        }
        // What a decoder fails at is caught, and the program prints nothing of it.
        if gridlight::files::guard::is_guarded() {
            return;
        }
        let mut heard = PANIC.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        heard.get_or_insert_with(|| format!("panicked {}", panic.to_string().replace('\n', " ")));
    }));
}

/// What is wrong with how a file is read, if anything; and whether it is accepted.
fn fault(target: &Target, path: &Path, length: usize) -> (Option<String>, bool) {
    BEGAN_MS.store(now_ms(), Relaxed);
    let (result, most_bytes) = allocator::measure(|| catch_unwind(AssertUnwindSafe(|| (target.read)(path))));
    BEGAN_MS.store(0, Relaxed);
    let panic = PANIC.lock().unwrap_or_else(std::sync::PoisonError::into_inner).take();
    let refused = match (&result, panic) {
        (_, Some(panic)) => return (Some(panic), false),
        (Err(_), None) => return (Some("panicked silently".to_owned()), false),
        (Ok(Ok(())), None) => return (None, true),
        (Ok(Err(refused)), None) => refused.to_string(),
    };
    let place = path.parent().unwrap_or(path).display().to_string();
    let words = refused.replace(&place, "");
    let is_webp = path.extension().is_some_and(|extension| extension == "webp");
    let allowance = if is_webp { WEBP_ALLOWANCE_BYTES } else { ALLOWANCE_BYTES };
    let found = if most_bytes > 4 * length + allowance {
        Some(format!("took {} MiB for a file that it refuses", most_bytes >> 20))
    } else if words.chars().count() > LONGEST_MESSAGE {
        Some("a message of more than a sentence".to_owned())
    } else {
        None
    };
    (found, false)
}

/// A fault without its numbers, so that many inputs with one cause are one.
fn kind(target: &Target, fault: &str) -> String {
    let words = fault.split(|c: char| c.is_ascii_digit()).collect::<Vec<_>>().join("");
    format!("{}: {}", target.name, words.chars().take(160).collect::<String>())
}

/// What was found: by kind, the first input and its fault, and how many there were.
#[derive(Default)]
struct Findings(BTreeMap<String, (String, u64)>);

impl Findings {
    fn add(&mut self, target: &Target, what: &str, fault: &str, seed: &Seed) {
        let (_, count) = self.0.entry(kind(target, fault)).or_insert_with(|| {
            let kept = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("fuzz-{}-{what}-{}", target.name, seed.0));
            std::fs::write(&kept, &seed.1).expect("the build folder can be written");
            let sentence = format!("{} {what}: {fault} ({})", target.name, kept.display());
            eprintln!("{sentence}");
            (sentence, 0)
        });
        *count += 1;
    }
}

/// Files that once failed.
fn corpus(target: &Target) -> Vec<Seed> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/corpus").join(target.name);
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|e| (e.file_name().to_string_lossy().into_owned(), std::fs::read(e.path()).unwrap())).collect()
}

/// The readers that are asked for.
fn chosen() -> Vec<&'static Target> {
    let name = std::env::var("GRIDLIGHT_FUZZ_TARGET").ok();
    let all: Vec<&Target> = TARGETS.iter().filter(|t| name.as_ref().is_none_or(|name| name == t.name)).collect();
    assert!(!all.is_empty(), "there is no reader {name:?}");
    all
}

#[test]
fn no_file_is_too_wrong() {
    let _alone = ALONE.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let folder = tempfile::tempdir().unwrap();
    watch(folder.path().to_owned());
    hear_panics();
    let mut findings = Findings::default();
    let targets = chosen();
    let seeds: Vec<Vec<Seed>> = targets.iter().map(|target| (target.seeds)()).collect();
    for (target, seeds) in targets.iter().zip(&seeds) {
        for seed in seeds.iter().chain(&corpus(target)) {
            let path = folder.path().join(&seed.0);
            std::fs::write(&path, &seed.1).unwrap();
            let (fault, accepted) = fault(target, &path, seed.1.len());
            let is_whole = seeds.contains(seed);
            let fault = fault.or_else(|| (is_whole && !accepted).then(|| "a whole file is refused".to_owned()));
            fault.inspect(|fault| findings.add(target, "seed", fault, seed));
        }
    }
    let turns: Vec<usize> = targets.iter().enumerate().flat_map(|(i, t)| std::iter::repeat_n(i, t.share)).collect();
    let (first, count) = (setting("GRIDLIGHT_FUZZ_FIRST", 0), setting("GRIDLIGHT_FUZZ_INPUTS", INPUTS));
    let mut accepted_of = vec![[0u64; 2]; targets.len()];
    for number in first..first + count {
        let mut random = Random::of_input(number);
        let i = *random.pick(&turns);
        let input = mutate::changed(random.pick(&seeds[i]), targets[i].shape, &mut random);
        let path = folder.path().join(&input.0);
        std::fs::write(&path, &input.1).unwrap();
        let (fault, accepted) = fault(targets[i], &path, input.1.len());
        accepted_of[i][usize::from(accepted)] += 1;
        fault.inspect(|fault| findings.add(targets[i], &number.to_string(), fault, &input));
        if number % 10_000 == 9999 {
            eprintln!(
                "{} inputs, {:.0} s, {} kinds of fault",
                number + 1 - first,
                START.elapsed().as_secs_f64(),
                findings.0.len()
            );
        }
    }
    for (target, [refused, accepted]) in targets.iter().zip(&accepted_of) {
        println!("{}: {refused} refused, {accepted} accepted", target.name);
        // Otherwise the changes no longer reach what is behind the first check.
        assert!(refused + accepted < 100 || (*refused > 0 && *accepted > 0), "all of {} are alike", target.name);
    }
    let list: Vec<String> = findings.0.into_values().map(|(first, count)| format!("{count}x {first}")).collect();
    assert!(list.is_empty(), "{} kinds of fault:\n{}", list.len(), list.join("\n"));
}

/// What must be noticed is noticed.
#[test]
fn planted_faults_are_noticed() {
    fn panics(_: &Path) -> gridlight::Result<()> {
        panic!("on purpose")
    }
    fn takes_much(path: &Path) -> gridlight::Result<()> {
        drop(std::hint::black_box(vec![1u8; 80 << 20]));
        Err(gridlight::Error::file(path, "no"))
    }
    fn talks(_: &Path) -> gridlight::Result<()> {
        Err(gridlight::Error::Failure("no ".repeat(500)))
    }
    fn is_right(path: &Path) -> gridlight::Result<()> {
        Err(gridlight::Error::file(path, "no"))
    }
    let _alone = ALONE.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    hear_panics();
    for (read, wanted) in [
        (panics as fn(&Path) -> gridlight::Result<()>, Some("panicked")),
        (takes_much, Some("took 80 MiB")),
        (talks, Some("more than a sentence")),
        (is_right, None),
    ] {
        let target = Target { read, ..TARGETS[0] };
        let (found, _) = fault(&target, Path::new("a/b"), 100);
        assert_eq!(found.is_some(), wanted.is_some(), "{found:?}");
        assert!(found.is_none_or(|found| wanted.is_some_and(|wanted| found.contains(wanted))));
    }
}
