//! Bad input through the whole program: one sentence, the right exit code, and nothing half-written.

mod support;

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::Command;
use std::time::Duration;

use serde_json::json;
use support::{Run, names, noise, program, quad, quad_glb, run, succeed};

/// A folder with an old picture, in which every run asks for a new one.
struct Place {
    folder: tempfile::TempDir,
}

const OLD: &[u8] = b"an old picture";

impl Place {
    fn new() -> Self {
        let place = Self { folder: tempfile::tempdir().unwrap() };
        std::fs::write(place.path("out.exr"), OLD).unwrap();
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        std::fs::write(self.path(name), bytes).unwrap();
        self.path(name)
    }

    /// The program, asked for a small picture over the old one and for new timings.
    fn command(&self) -> Command {
        let mut command = program();
        command.args(["--headless", "--size", "32x18", "--vpls", "200", "--environment", "none"]);
        command.arg("--output").arg(self.path("out.exr")).arg("--timings").arg(self.path("out.json"));
        command
    }

    /// Runs `command`, which must end with `code` and one sentence that has all `words`.
    fn check(&self, code: i32, words: &[&str], command: Command) -> Run {
        let before = names(self.folder.path());
        let what = format!("{command:?}");
        let run = run(command);
        assert_eq!(run.code, Some(code), "{what}\n{}", run.stderr);
        assert_eq!(run.stderr.lines().count(), 1, "{what}\n{}", run.stderr);
        assert!(run.stderr.starts_with("error: ") && run.stderr.ends_with('\n'), "{what}\n{}", run.stderr);
        for word in words {
            assert!(run.stderr.contains(word), "{what}: no `{word}` in {}", run.stderr);
        }
        assert_eq!(run.stdout, "", "{what}");
        assert_eq!(names(self.folder.path()), before, "{what}: files have come or gone");
        assert_eq!(std::fs::read(self.path("out.exr")).unwrap(), OLD, "{what}: the old picture has changed");
        run
    }

    fn options(&self, code: i32, words: &[&str], options: &str) {
        let mut command = self.command();
        command.args(options.split_whitespace());
        self.check(code, words, command);
    }

    /// A scene file with these bytes is refused, by name.
    fn scene(&self, name: &str, bytes: impl AsRef<[u8]>, words: &[&str]) {
        let path = self.write(name, bytes);
        let mut command = self.command();
        command.arg(&path);
        self.check(1, &[&[path.to_str().unwrap()], words].concat(), command);
    }

    /// A scene file with these bytes renders; gives the picture.
    fn renders(&self, name: &str, bytes: impl AsRef<[u8]>) -> Vec<f32> {
        let (path, picture) = (self.write(name, bytes), self.path("rendered.exr"));
        let mut command = self.command();
        command.arg("--output").arg(&picture).arg(path);
        let run = run(command);
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        gridlight::files::pictures::read_exr(picture).unwrap().2
    }
}

#[test]
fn scene_files_that_cannot_be_read() {
    let place = Place::new();
    let mut command = place.command();
    command.arg(place.path("gone.gltf"));
    place.check(1, &["gone.gltf", "cannot be read"], command);
    let mut command = place.command();
    command.arg(place.folder.path());
    place.check(1, &[place.folder.path().to_str().unwrap()], command);
    place.scene("house.OBJ", "v 0 0 0", &["Wavefront OBJ", "glTF"]);
    place.scene("house.usdz", "", &["USD", "glTF"]);
    place.scene("empty.glb", "", &[]);
    place.scene("empty.gltf", "", &["it is empty"]);
    place.scene("page.glb", "<!DOCTYPE html><title>404</title>", &["it is a web page"]);
    place.scene("pointer.glb", "version https://git-lfs.github.com/spec/v1\n", &["Git LFS"]);
    let wide: Vec<u8> = "{\"asset\": {}}".encode_utf16().flat_map(u16::to_le_bytes).collect();
    place.scene("wide.gltf", wide, &["UTF-16"]);
    place.scene("broken.gltf", r#"{"asset": {"version": "2.0"}, "meshes": ["#, &["JSON is broken"]);
    let whole = quad_glb(|_, _| ());
    for length in [3, 11, 12, 19, 60, whole.len() - 30, whole.len() - 1] {
        place.scene("cut.glb", &whole[..length], &[]);
    }
}

#[test]
fn random_bytes() {
    let place = Place::new();
    for seed in 0..4 {
        place.scene("noise.glb", noise(seed, 5000), &[]);
        place.scene("noise.gltf", noise(seed, 5000), &[]);
        place.scene("begins.glb", [b"glTF\x02\0\0\0", noise(seed, 3000).as_slice()].concat(), &[]);
    }
}

#[test]
fn scene_files_that_are_wrong() {
    let place = Place::new();
    place.scene("index.glb", quad_glb(|_, bin| bin[48] = 9), &["index 9", "4 vertices"]);
    place.scene("nan.glb", quad_glb(|_, bin| bin[..4].copy_from_slice(&f32::NAN.to_le_bytes())), &["not finite"]);
    place.scene("infinite.glb", quad_glb(|_, bin| bin[..4].copy_from_slice(&f32::INFINITY.to_le_bytes())), &[]);
    let lines = quad_glb(|document, _| document["meshes"][0]["primitives"][0]["mode"] = json!(1));
    place.renders_nothing("lines.glb", &lines);
    place.scene("nothing.glb", quad_glb(|document, _| document["nodes"][0] = json!({})), &["no triangles"]);
    let textured = quad_glb(|document, _| {
        document["images"] = json!([{"uri": "gone.png"}]);
        document["textures"] = json!([{"source": 0}]);
        document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": 0});
    });
    place.warns("texture.glb", &textured, &["gone.png", "No such file", "left out"]);
    place.write("gone.png", noise(1, 100));
    place.warns("texture.glb", &textured, &["gone.png", "unreadable", "left out"]);
    let (mut document, _) = quad();
    document["buffers"][0]["uri"] = json!("gone.bin");
    place.scene("buffer.gltf", document.to_string(), &["gone.bin", "No such file"]);
}

impl Place {
    /// The scene is rendered, and one warning says this.
    fn warns(&self, name: &str, bytes: &[u8], words: &[&str]) {
        let mut command = self.command();
        command.arg(self.write(name, bytes)).args(["--technique", "direct", "--environment", "1,1,1"]);
        command.arg("--output").arg(self.path("rendered.exr"));
        let run = run(command);
        assert_eq!((run.code, run.stderr.lines().count()), (Some(0), 1), "{}", run.stderr);
        assert!(words.iter().all(|word| run.stderr.contains(word)), "{}", run.stderr);
    }

    /// Points and lines are left out with a warning; what remains has no triangles.
    fn renders_nothing(&self, name: &str, bytes: &[u8]) {
        let mut command = self.command();
        command.arg(self.write(name, bytes)).arg("--quiet");
        self.check(1, &[name, "no triangles"], command);
    }
}

#[test]
fn a_scene_without_lights_has_a_sun() {
    let place = Place::new();
    let picture = place.renders("dark.glb", quad_glb(|_, _| ()));
    assert!(picture.iter().all(|v| v.is_finite()) && picture.iter().any(|v| *v > 0.1));
}

#[test]
fn scenes_that_hardly_reflect_or_are_hardly_hit_still_render() {
    let place = Place::new();
    let black = quad_glb(|document, _| {
        document["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!([0.0, 0.0, 0.0, 1.0]);
    });
    assert!(place.renders("black.glb", black).iter().all(|v| *v == 0.0));
    let far = quad_glb(|document, _| {
        document["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 1e6}]}});
        let light = json!({"translation": [0, 150, 0], "extensions": {"KHR_lights_punctual": {"light": 0}}});
        document["nodes"].as_array_mut().unwrap().push(light);
        document["scenes"][0]["nodes"] = json!([0, 1]);
    });
    let picture = place.renders("far.glb", far);
    assert!(picture.iter().all(|v| v.is_finite()) && picture.iter().any(|v| *v > 0.0));
}

#[test]
fn cameras() {
    let place = Place::new();
    place.options(2, &["--camera nowhere", "court", "arcade"], "--camera nowhere");
    place.options(2, &["--camera 7", "court", "arcade"], "--camera 7");
    let named = quad_glb(|document, _| {
        document["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}]);
        document["nodes"] = json!([{"mesh": 0}, {"camera": 0, "name": "a\nb\u{1b}[31m"}]);
        document["scenes"][0]["nodes"] = json!([0, 1]);
    });
    let mut command = place.command();
    command.arg(place.write("named.glb", named)).args(["--camera", "c\nd"]);
    let run = place.check(2, &["--camera c d", "a b"], command);
    assert!(!run.stderr.contains('\u{1b}'));
    // A scene with a lamp has no sun to place.
    let lamp = quad_glb(|document, _| {
        document["extensionsUsed"] = json!(["KHR_lights_punctual"]);
        document["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
        document["nodes"] = json!([{"mesh": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}]);
    });
    let mut command = place.command();
    command.arg(place.write("lamp.glb", lamp)).args(["--sun", "10,20"]);
    place.check(2, &["--sun needs a directional light"], command);
}

#[test]
fn sizes() {
    let place = Place::new();
    place.options(2, &["size 0x9"], "--size 0x9");
    place.options(2, &["size 9x0"], "--size 9x0");
    place.options(2, &["12", "WIDTHxHEIGHT"], "--size 12");
    place.options(2, &["99999999999x1"], "--size 99999999999x1");
    place.options(2, &["--size 200000x100", "limit of"], "--size 200000x100");
    place.options(2, &["--size 100x200000", "limit of"], "--size 100x200000 --technique direct");
}

/// Storage buffers of the devices tried end between 128 MiB and 4 GiB; 15000 x 15000 pixels need more than any.
#[test]
fn buffers_of_the_size_of_the_picture() {
    let place = Place::new();
    let storage_mib = limit(&succeed(&["--list-gpus"]).stdout);
    if storage_mib > 4096 {
        println!("skipped: this device's storage buffers hold {storage_mib} MiB");
        return;
    }
    let words = ["--size 15000x15000", "--shadow-samples 16", &format!("end at {storage_mib} MiB"), "would fit"];
    place.options(2, &words, "--size 15000x15000 --shadow-samples 16");
}

/// The storage buffer limit of the first device, in MiB.
fn limit(list: &str) -> u64 {
    let (_, rest) = list.split_once("storage buffer ").expect("the list has limits");
    rest.split(' ').next().unwrap().parse().unwrap()
}

#[test]
fn vpls_beyond_the_device_and_those_that_fit() {
    let place = Place::new();
    let mut command = place.command();
    command.args(["--vpls", "4294967295"]);
    let run = place.check(2, &["--vpls 4294967295", "MiB", "would fit"], command);
    let (_, fitting) = run.stderr.trim().rsplit_once("; ").unwrap();
    let fitting: u32 = fitting.trim_start_matches("about ").trim_end_matches(" would fit").parse().unwrap();
    assert!(fitting >= 1_000_000, "only {fitting} would fit");
    place.options(2, &["vpls must be at least 1"], "--vpls 0");
    place.options(2, &["--vpls"], "--vpls 99999999999999");
    place.options(2, &["--vpls"], "--vpls many");
}

#[test]
fn outputs_that_cannot_be_written_are_found_before_rendering() {
    let place = Place::new();
    std::fs::create_dir(place.path("folder.exr")).unwrap();
    let kept = place.write("kept.json", "kept");
    let mut permissions = std::fs::metadata(&kept).unwrap().permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(&kept, permissions).unwrap();
    let cases = [
        ("--output", "no/folder/a.exr", "there is no folder"),
        ("--output", "folder.exr", "it is a folder"),
        ("--output", "out.exr/a.exr", "cannot be written"),
        ("--timings", "no/folder/a.csv", "there is no folder"),
        ("--timings", "kept.json", "read-only"),
    ];
    for (option, name, reason) in cases {
        let path = place.path(name);
        let mut command = place.command();
        command.args(["--frames", "4000000000"]).arg(option).arg(&path);
        let run = place.check(1, &[path.to_str().unwrap(), reason], command);
        assert!(run.time < Duration::from_secs(5), "{option} {name} took {:?}", run.time);
    }
    assert_eq!(std::fs::read(kept).unwrap(), b"kept");
    place.options(2, &["a.jpg", ".exr or .png"], "--output a.jpg");
    place.options(2, &["a.txt", ".json or .csv"], "--timings a.txt");
}

#[test]
fn contradictions_and_unknown_options() {
    let place = Place::new();
    place.options(2, &["--frobnicate"], "--frobnicate");
    place.options(2, &["--verbose", "--quiet"], "-v --quiet");
    place.options(2, &["technique direct", "reservoir"], "--technique direct --reservoir race");
    place.options(2, &["bounces 0"], "--bounces 0");
    place.options(2, &["bounces must be from 0 to 64"], "--bounces 4294967295");
    place.options(2, &["shadow-from 5", "levels"], "--levels 4 --shadow-from 5");
    place.options(2, &["shadow-from 10", "top level"], "--shadow-from 10");
    place.options(2, &["size 2x2", "interleave 4"], "--size 2x2 --interleave 4");
    place.options(2, &["interleave must be 1, 2 or 4"], "--interleave 3");
    let rounds = "--temporal shadows --temporal-rounds 2";
    place.options(2, &["temporal-rounds 2", "--interleave 1"], &format!("{rounds} --interleave 2"));
    place.options(
        2,
        &["temporal-rounds 2", "light volumes", "--lighting gather"],
        &format!("{rounds} --lighting volumes"),
    );
    place.options(2, &["temporal-rounds 2", "--temporal shadows"], "--temporal indirect --temporal-rounds 2");
    place.options(2, &["temporal-rounds must be from 1 to 64"], "--temporal-rounds 65");
    let options = "--shadow-estimate corrected --shadow-points deviation";
    place.options(2, &["shadow-estimate corrected", "shadow-points descent"], options);
    place.options(2, &["--shadow-estimate", "exact"], "--shadow-estimate exact");
    place.options(2, &["--technique", "radiosity"], "--technique radiosity");
    place.options(2, &["alpha"], "--alpha nan");
    place.options(2, &["alpha"], "--alpha -1");
    place.options(2, &["clamp"], "--clamp inf");
    place.options(2, &["exposure"], "--exposure 0");
    place.options(2, &["frames"], "--frames 0");
    place.options(2, &["two.glb"], "one.glb two.glb");
    place.options(2, &["--script", "--output"], "--script steps.txt");
}

#[test]
fn settings_files() {
    let place = Place::new();
    let with = |name: &str, text: &str| {
        let path = place.write(name, text);
        let mut command = place.command();
        command.arg("--settings").arg(path);
        command
    };
    place.check(2, &["a.toml", "line 2", "sampels"], with("a.toml", "seed = 1\nsampels = 4\n"));
    place.check(2, &["a.json", "sampels"], with("a.json", r#"{"sampels": 4}"#));
    place.check(2, &["a.toml", "line 1"], with("a.toml", "seed = \"one\"\n"));
    place.check(1, &["a.toml", "not a TOML file"], with("a.toml", "seed = = 1\n"));
    place.check(1, &["a.json", "not a JSON file"], with("a.json", "{"));
    place.check(1, &["a.toml"], with("a.toml", "\0\u{1}"));
    place.check(2, &["interleave must be"], with("a.toml", "interleave = 3\n"));
    let mut command = place.command();
    command.arg("--settings").arg(place.path("gone.toml"));
    place.check(1, &["gone.toml", "settings file"], command);
    let mut command = place.command();
    command.arg("--settings").arg(place.write("noise.toml", noise(3, 1000)));
    place.check(1, &["noise.toml"], command);
}

#[test]
fn devices() {
    let place = Place::new();
    place.options(2, &["--gpu voodoo", "there are 0: "], "--gpu voodoo");
    place.options(2, &["--gpu 99"], "--gpu 99");
    let list = succeed(&["--list-gpus"]);
    for word in ["0: ", "Vulkan 1.", "suitable: ", "64-bit buffer atomics: ", "storage buffer "] {
        assert!(list.stdout.contains(word), "no `{word}` in {}", list.stdout);
    }
}

#[test]
fn no_driver() {
    let place = Place::new();
    for list in [false, true] {
        let mut command = if list { program() } else { place.command() };
        for variable in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"] {
            command.env(variable, place.path("no-driver.json"));
        }
        command.env_remove("VK_ADD_DRIVER_FILES");
        command.args(list.then_some("--list-gpus"));
        place.check(77, &["driver", "apt install", "mesa-vulkan-drivers"], command);
    }
}

/// A file that is no library stands in the loader's way.
#[cfg(target_os = "linux")]
#[test]
fn no_loader() {
    let place = Place::new();
    let libraries = tempfile::tempdir().unwrap();
    for name in ["libvulkan.so.1", "libvulkan.so"] {
        std::fs::write(libraries.path().join(name), "not a library").unwrap();
    }
    let mut command = place.command();
    command.env("LD_LIBRARY_PATH", libraries.path());
    place.check(77, &["loader", "apt install", "libvulkan1"], command);
}

#[test]
fn the_graph_is_printed_and_nothing_else_happens() {
    let place = Place::new();
    let before = names(place.folder.path());
    let args: Vec<OsString> = place.command().get_args().map(OsString::from).collect();
    let run = succeed(&[args.as_slice(), &["--print-graph".into()]].concat());
    assert!(run.stdout.starts_with("digraph frame {") && run.stdout.ends_with("}\n"));
    assert!(run.stdout.contains("label=\"light_gather\\n"));
    assert_eq!(names(place.folder.path()), before);
    assert_eq!(std::fs::read(place.path("out.exr")).unwrap(), OLD);
    place.options(2, &["size 0x9"], "--print-graph --size 0x9");
}
