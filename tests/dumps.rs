//! Dumps through the whole program: complete, readable, comparable, and computed anew by an independent script.

mod support;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use gridlight::report::dump::array::Array;
use gridlight::report::dump::images::Picture;
use gridlight::report::dump::manifest::{FileEntry, Manifest};
use support::{Run, names, program, run, succeed};

const SMALL: &str = "--headless --size 48x27 --vpls 300 --quiet";
/// Nothing depends on the order in which threads run.
const EXACT: &str = "--reservoir exact";

fn args(options: &str) -> Vec<&str> {
    SMALL.split(' ').chain(options.split_whitespace()).collect()
}

/// Dumps a small frame under this name in `folder`.
fn dump(folder: &Path, name: &str, options: &str) -> PathBuf {
    let path = folder.join(name);
    let mut all = args(options);
    all.extend(["--dump", path.to_str().unwrap()]);
    succeed(&all);
    path
}

/// A dump of [`EXACT`] frames that tests only read; it stays in the build folder.
fn exact_dump() -> &'static Path {
    static DUMP: OnceLock<PathBuf> = OnceLock::new();
    DUMP.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
        let _ = std::fs::remove_dir_all(folder.join("exact-dump"));
        dump(folder, "exact-dump", EXACT)
    })
}

fn diff(a: &Path, b: &Path, options: &[&str]) -> Run {
    let mut command = program();
    command.arg("diff-dumps").arg(a).arg(b).args(options);
    run(command)
}

/// One sentence on stderr with these words, and this exit code.
fn complains(found: &Run, code: i32, words: &[&str]) {
    assert_eq!(found.code, Some(code), "{}", found.stderr);
    assert_eq!(found.stderr.lines().count(), 1, "{}", found.stderr);
    for word in words {
        assert!(found.stderr.contains(word), "no `{word}` in {}", found.stderr);
    }
}

/// Names of the resources in the frame graph, from `--print-graph`.
fn graph_resources(options: &str) -> BTreeSet<String> {
    let mut all = args(options);
    all.push("--print-graph");
    let dot = succeed(&all).stdout;
    // The scene's parts are dumped on their own.
    let resources = dot.lines().filter(|line| line.contains("shape=ellipse") && !line.contains("imported"));
    let labels = resources.filter_map(|line| line.split_once("label=\""));
    let found: BTreeSet<String> =
        labels.map(|(_, label)| label.split(['\\', '"']).next().unwrap().to_owned()).collect();
    assert!(found.contains("frame_data") && found.len() > 9, "{options}: {found:?}");
    found
}

/// Reads the file, which must be what its entry says.
fn check_file(folder: &Path, file: &FileEntry) {
    let path = folder.join(&file.file);
    if file.kind == "image" {
        let picture = Picture::read(&path).unwrap();
        assert_eq!(file.shape, [u64::from(picture.height_px), u64::from(picture.width_px)], "{path:?}");
        let sorted: BTreeSet<_> = file.channels.iter().cloned().collect();
        assert_eq!(sorted, picture.channels.iter().map(|(name, _)| name.clone()).collect(), "{path:?}");
        assert_eq!(file.dtype, picture.scalar.type_string(), "{path:?}");
    } else {
        let array = Array::read(&path).unwrap();
        assert_eq!((&array.shape, array.dtype_json()), (&file.shape, file.dtype.clone()), "{path:?}");
    }
    assert!(file.resource_bytes > 0 && !file.units.is_empty() && file.meaning.ends_with('.'), "{path:?}");
}

fn check_dump(options: &str) {
    let folder = tempfile::tempdir().unwrap();
    let path = dump(folder.path(), "dump", &format!("{options} --validation"));
    let manifest = Manifest::read(&path).unwrap();
    let dumped: BTreeSet<_> = manifest.files.iter().map(|f| f.resource.clone()).collect();
    for resource in graph_resources(options) {
        assert!(dumped.contains(&resource), "{options}: {resource} is not in the dump");
    }
    for file in &manifest.files {
        check_file(&path, file);
        let of_history = file.resource.starts_with("previous_");
        let start = if of_history { "history" } else { "scene" };
        assert_eq!(file.pass_index.map_or(start, |index| &manifest.passes[index]), file.pass);
    }
    assert!(manifest.files.iter().any(|f| f.resource == "picture" && f.shape == [27, 48]));
    // Nothing but the manifest and its files.
    let folders: BTreeSet<_> = manifest.files.iter().map(|f| f.file.split('/').next().unwrap().to_owned()).collect();
    let expected: Vec<_> =
        folders.into_iter().chain(["manifest.json".to_owned()]).collect::<BTreeSet<_>>().into_iter().collect();
    assert_eq!(names(&path), expected);
}

#[test]
fn a_dump_has_every_resource_in_its_shape() {
    check_dump("");
}

#[test]
fn interleaved_frames_are_dumped() {
    check_dump("--interleave 2 --reservoir lock --filter none");
}

#[test]
fn frames_with_history_are_dumped() {
    check_dump("--temporal shadows --antilag tiles --frames 2 --vpl-seeds fresh");
    check_dump("--temporal shadows --temporal-rounds 3 --frames 2 --inspect 3,4");
    check_dump("--temporal indirect --interleave 2 --frames 2");
    check_dump("--taa on --temporal shadows --frames 2");
    check_dump("--grid-update check --vpl-seeds rolling --frames 2");
}

#[test]
fn a_history_that_differs_is_found_before_all_passes() {
    let folder = tempfile::tempdir().unwrap();
    let options = "--temporal shadows --taa on --frames 2";
    let [a, b] = ["a", "b"].map(|name| dump(folder.path(), name, options));
    assert_eq!(diff(&a, &b, &[]).code, Some(0));
    for image in ["previous_temporal_shadowed", "previous_antialiased"] {
        let path = b.join(format!("history/{image}.exr"));
        let whole = std::fs::read(&path).unwrap();
        let mut picture = Picture::read(&path).unwrap();
        let texel: &mut [u8; 4] = picture.channels[0].1.first_chunk_mut().unwrap();
        *texel = (f32::from_le_bytes(*texel) + 0.25).to_le_bytes();
        picture.write(&path).unwrap();
        let found = diff(&a, &b, &[]);
        complains(&found, 3, &["first in the history"]);
        let last = found.stdout.lines().last().unwrap();
        assert!(last.starts_with("the frames start from another history: 1 of ") && last.contains(image), "{last}");
        std::fs::write(&path, whole).unwrap();
    }
    // A first frame has none.
    let first = dump(folder.path(), "first", "--temporal shadows --frames 1 --warmup 0");
    assert!(!first.join("history").exists());
}

#[test]
fn scattered_levels_and_original_lights_are_dumped() {
    check_dump("--build scatter --first-level 0 --shadow-points deviation --environment 1,2,3");
}

#[test]
fn references_means_and_views_are_dumped() {
    check_dump("--technique brute-force");
    check_dump("--technique path-trace --samples 2 --accumulate 2");
    check_dump("--view shadow-ratio --interleave 2");
    check_dump("--view level-weights");
}

/// The dumped frame is the last of the mean, and the picture is the mean with it.
#[test]
fn a_mean_ends_with_the_dumped_frame() {
    let folder = tempfile::tempdir().unwrap();
    let (plain, dumped) = (folder.path().join("plain.exr"), folder.path().join("dumped.exr"));
    let mean = format!("{EXACT} --accumulate 3 --output");
    succeed(&args(&format!("{mean} {}", plain.display())));
    let path = dump(folder.path(), "dump", &format!("{mean} {}", dumped.display()));
    let [a, b] = [&plain, &dumped].map(|path| Picture::read(path).unwrap());
    assert_eq!(a, b);
    assert_eq!(Manifest::read(&path).unwrap().frame["accumulated_frame"], 2);
}

#[test]
fn direct_light_alone_is_dumped() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("dump");
    succeed(&["--headless", "--size", "16x9", "--technique", "direct", "--quiet", "--dump", path.to_str().unwrap()]);
    let manifest = Manifest::read(&path).unwrap();
    manifest.files.iter().for_each(|file| check_file(&path, file));
    // No pass adds to it, so that the one that clears it shows it.
    assert!(manifest.files.iter().any(|f| f.pass == "frame_setup" && f.resource == "ray_count"));
}

#[test]
fn equal_runs_have_equal_dumps() {
    let folder = tempfile::tempdir().unwrap();
    let a = exact_dump();
    let b = dump(folder.path(), "b", &format!("{EXACT} --frames 2 --warmup 1"));
    let found = diff(a, &b, &[]);
    assert_eq!((found.code, found.stderr.as_str()), (Some(0), ""), "{}", found.stdout);
    let last = found.stdout.lines().last().unwrap();
    assert!(last.starts_with("the dumps agree bit for bit"), "{last}");
}

/// Two dumps of different seeds.
#[test]
fn the_first_pass_that_differs_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let a = exact_dump();
    let b = dump(folder.path(), "b", &format!("{EXACT} --seed 2"));
    complains(&diff(a, &b, &[]), 2, &["different settings", "seed (1, 2)", "--ignore-settings"]);
    let found = diff(a, &b, &["--ignore-settings"]);
    complains(&found, 3, &["first in pass vpl_trace"]);
    let last = found.stdout.lines().last().unwrap();
    assert!(last.starts_with("the first pass that differs is vpl_trace: "), "{last}");
    assert!(found.stdout.lines().any(|l| l.contains("frame_data") && l.contains("follows the settings")));
}

#[test]
fn a_planted_value_is_found_in_its_pass() {
    let folder = tempfile::tempdir().unwrap();
    let a = exact_dump();
    let b = dump(folder.path(), "b", EXACT);
    let manifest = Manifest::read(&b).unwrap();
    let file =
        manifest.files.iter().find(|f| (f.pass.as_str(), f.resource.as_str()) == ("merge", "merged_lights")).unwrap();
    let path = b.join(&file.file);
    let mut array = Array::read(&path).unwrap();
    // The luminance of light 3, a little brighter.
    let at = 3 * array.element_bytes() + 12;
    let value = f32::from_le_bytes(array.bytes[at..at + 4].try_into().unwrap());
    array.bytes[at..at + 4].copy_from_slice(&(value * 1.002).to_le_bytes());
    array.write(&path).unwrap();
    let found = diff(a, &b, &[]);
    complains(&found, 3, &["first in pass merge"]);
    let last = found.stdout.lines().last().unwrap();
    assert!(
        last.contains("merge: 1 of ")
            && last.contains("of merged_lights differ")
            && last.contains("(relative 2.00e-3)"),
        "{last}"
    );
    assert!(last.ends_with(&format!("1 of {} files differ", manifest.files.len())), "{last}");
    assert_eq!(diff(a, &b, &["--tolerance", "0.01"]).code, Some(0));
    complains(&diff(a, &b, &["--tolerance", "1e-4"]), 3, &["pass merge"]);

    // Damage to the files.
    let whole = std::fs::read(&path).unwrap();
    std::fs::write(&path, &whole[..whole.len() - 1]).unwrap();
    complains(&diff(a, &b, &[]), 1, &["merged_lights.npy", "is damaged"]);
    std::fs::remove_file(&path).unwrap();
    complains(&diff(a, &b, &[]), 1, &["merged_lights.npy", "cannot be read"]);
    std::fs::write(&path, &whole).unwrap();
    let exr = b.join(&manifest.files.iter().find(|f| f.resource == "gbuffer_depth").unwrap().file);
    let image = std::fs::read(&exr).unwrap();
    std::fs::write(&exr, &image[..image.len() / 2]).unwrap();
    complains(&diff(a, &b, &[]), 1, &["gbuffer_depth.exr", "OpenEXR"]);
}

#[test]
fn dumps_that_are_none() {
    let folder = tempfile::tempdir().unwrap();
    let empty = folder.path();
    complains(&diff(empty, empty, &[]), 1, &["manifest.json", "this is no dump"]);
    std::fs::write(empty.join("manifest.json"), "{\"schema\": \"gridlight-timings/1\"}").unwrap();
    complains(&diff(empty, empty, &[]), 1, &["manifest.json", "gridlight-timings/1"]);
    std::fs::write(empty.join("manifest.json"), "{\"schema\": \"gridlight-dump/1\"}").unwrap();
    complains(&diff(empty, empty, &[]), 1, &["manifest.json", "is damaged"]);
    std::fs::write(empty.join("manifest.json"), "{").unwrap();
    complains(&diff(empty, empty, &[]), 1, &["manifest.json", "is not JSON"]);
    complains(&diff(empty, empty, &["--tolerance", "-1"]), 2, &["tolerance", "-1"]);
}

#[test]
fn a_folder_in_use_is_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let used = folder.path().join("used");
    std::fs::create_dir(&used).unwrap();
    std::fs::write(used.join("mine"), "mine").unwrap();
    let try_at = |path: &Path| {
        let mut command = program();
        command.args(args("")).arg("--dump").arg(path);
        run(command)
    };
    complains(&try_at(&used), 2, &["used", "not empty"]);
    assert_eq!(names(&used), ["mine"]);
    complains(&try_at(&used.join("mine")), 1, &["mine", "not a folder"]);
    complains(&try_at(&folder.path().join("no/dump")), 1, &["no/dump", "there is no folder"]);
    assert_eq!(names(folder.path()), ["used"]);
    // An empty folder is as good as none.
    std::fs::remove_file(used.join("mine")).unwrap();
    assert_eq!(try_at(&used).code, Some(0));
    assert!(names(&used).contains(&"manifest.json".to_owned()));
    assert_eq!(names(folder.path()), ["used"]);
}

/// A Python that has NumPy.
fn python() -> Option<&'static str> {
    ["python3", "/usr/bin/python3"].into_iter().find(|python| {
        let found = Command::new(python).args(["-c", "import numpy"]).output();
        found.is_ok_and(|output| output.status.success())
    })
}

/// The script that computes a dump anew, with its options.
fn recompute(python: &str, dump: &Path, options: &[&str]) -> Run {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tools/recompute_dump.py");
    let mut command = Command::new(python);
    command.arg(script).arg(dump).args(options);
    run(command)
}

#[test]
fn an_independent_script_computes_the_same() {
    let Some(python) = python() else {
        println!("skipped: there is no python3 with numpy");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    for (name, options) in [
        ("plain", "--reservoir exact --environment sky --environment-turn 20"),
        ("mean", "--accumulate 2 --direct off"),
        ("interleaved", "--interleave 2 --reservoir lock --alpha 2"),
        ("volumes", "--lighting volumes --reservoir exact --interleave 4"),
        ("scattered", "--build scatter --first-level 0 --shadow-samples 0"),
        ("originals", "--first-level 0"),
        ("anchored", "--vpl-seeds fresh"),
    ] {
        let path = dump(folder.path(), name, options);
        let found = recompute(python, &path, &["--pixels", "100"]);
        assert_eq!((found.code, found.stderr.as_str()), (Some(0), ""), "{name}\n{}", found.stdout);
        let stages = found.stdout.lines().filter(|line| line.contains(" pass ")).count();
        assert_eq!(stages + 1, found.stdout.lines().count(), "{name}\n{}", found.stdout);
        assert!(stages >= 9, "{name}\n{}", found.stdout);
    }
    let found = recompute(python, &folder.path().join("plain"), &["--pixels", "60", "--self-test"]);
    assert_eq!(found.code, Some(0), "{}{}", found.stdout, found.stderr);
    assert!(found.stdout.ends_with("every planted fault was noticed\n"), "{}", found.stdout);
    let found = recompute(python, &folder.path().join("plain"), &["--plant", "merge"]);
    assert_eq!(found.code, Some(3), "{}{}", found.stdout, found.stderr);
    let found = recompute(python, folder.path(), &[]);
    complains(&found, 1, &["manifest.json cannot be read"]);
}
