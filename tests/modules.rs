//! Modules import each other in one direction only: the rooms of `src` from the layers below, the modules of `src/gpu`
//! without circles.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The rooms of `src`, from the bottom to the top. A room imports what stands in layers below its own.
const LAYERS: &[&[&str]] = &[
    &["color", "error", "progress", "random"],
    &["camera", "files", "graph", "interrupt", "shared"],
    &["environment"],
    &["compare", "light_grid", "light_paths", "scene", "settings", "shader"],
    &["micro_buffers", "points"],
    &["cpu", "gpu", "views"],
    &["uploaded_scene"],
    &["job"],
    &["passes"],
    &["dump", "scene_mover"],
    &["techniques"],
    &["cli", "frame"],
    &["renderer"],
    &["report"],
    &["app"],
];

/// Source of each module of a folder by name; `mod` is its root.
type Sources = BTreeMap<String, String>;

fn sources(folder: &str) -> Sources {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    files
        .filter(|path| path.extension().is_some_and(|extension| extension == "rs"))
        .map(|path| {
            let text = std::fs::read_to_string(&path).unwrap();
            (path.file_stem().unwrap().to_str().unwrap().to_owned(), text)
        })
        .collect()
}

fn identifier(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
    &text[..end]
}

/// The first names of a path, or of the group of paths that `text` starts with.
fn heads(text: &str) -> Vec<&str> {
    let Some(group) = text.strip_prefix('{') else { return vec![identifier(text)] };
    let mut heads = Vec::new();
    let (mut depth, mut start) = (0, 0);
    for (at, c) in group.char_indices() {
        match c {
            ',' | '}' if depth == 0 => {
                heads.push(identifier(group[start..at].trim_start()));
                start = at + 1;
                if c == '}' {
                    break;
                }
            }
            '{' => depth += 1,
            '}' => depth -= 1,
            _ => {}
        }
    }
    heads
}

/// The lines that are neither comments nor tests.
fn code(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod ").next().unwrap();
    let lines = text.lines().filter(|line| !line.trim_start().starts_with("//"));
    lines.flat_map(|line| [line, "\n"]).collect()
}

/// Modules that a module of `crate::gpu` names outside its tests. `exported` says which module the names at the root
/// come from.
fn imports(text: &str, modules: &BTreeSet<&str>, exported: &BTreeMap<&str, &str>) -> BTreeSet<String> {
    let lines = code(text);
    let paths = ["super::", "crate::gpu::"].iter().flat_map(|prefix| lines.split(prefix).skip(1));
    let module_of = |name| modules.get(name).or_else(|| exported.get(name)).map(|module| (*module).to_owned());
    paths.flat_map(heads).filter_map(module_of).collect()
}

/// The text of a room, a file or a folder of them, without its tests.
fn room_text(path: &Path) -> String {
    if path.is_file() {
        let text = std::fs::read_to_string(path).unwrap();
        return code(&text);
    }
    let inside = std::fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path());
    inside
        .filter(|path| !path.file_stem().unwrap().to_str().unwrap().ends_with("tests"))
        .map(|p| room_text(&p))
        .collect()
}

/// The rooms of `src` with their text.
fn rooms() -> Sources {
    let entries = std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("src")).unwrap();
    let mut rooms = Sources::new();
    for path in entries.map(|entry| entry.unwrap().path()) {
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        if !["lib", "main", "bin"].contains(&name.as_str()) {
            *rooms.entry(name).or_default() += &room_text(&path);
        }
    }
    rooms
}

/// What each room imports against the order of the layers, and rooms that stand in none.
fn against_the_layers(rooms: &Sources) -> Vec<String> {
    let layer = |room: &str| LAYERS.iter().position(|layer| layer.contains(&room));
    let mut found = Vec::new();
    for (room, text) in rooms {
        let Some(own) = layer(room) else {
            found.push(format!("{room} is in no layer"));
            continue;
        };
        let imported: BTreeSet<&str> = text.split("crate::").skip(1).flat_map(heads).collect();
        let above =
            imported.into_iter().filter(|other| other != room && layer(other).is_some_and(|other| other >= own));
        found.extend(above.map(|other| format!("{room} imports {other}")));
    }
    found
}

/// Which module each name that the root exports comes from.
fn exports(root: &str) -> BTreeMap<&str, &str> {
    let lines = root.split("pub use ").skip(1).filter_map(|line| line.split(';').next()?.split_once("::"));
    lines.flat_map(|(module, names)| heads(names).into_iter().map(move |name| (name, module))).collect()
}

/// The modules of a circle of imports, if there is one.
fn circle(sources: &Sources) -> Option<Vec<String>> {
    let modules: BTreeSet<&str> = sources.keys().map(String::as_str).filter(|name| *name != "mod").collect();
    let exported = exports(&sources["mod"]);
    let imported = |name: &str| imports(&sources[name], &modules, &exported);
    let mut edges: BTreeMap<&str, _> = modules.iter().map(|name| (*name, imported(name))).collect();
    // What imports nothing that is left is in no circle.
    while let Some(leaf) = edges.iter().find(|(_, to)| to.iter().all(|to| !edges.contains_key(to.as_str()))) {
        let leaf = *leaf.0;
        edges.remove(leaf);
    }
    let mut walk = vec![(*edges.keys().next()?).to_owned()];
    loop {
        let last = walk.last().unwrap();
        let next = edges[last.as_str()].iter().find(|to| edges.contains_key(to.as_str())).unwrap().clone();
        if let Some(start) = walk.iter().position(|name| *name == next) {
            return Some(walk.split_off(start));
        }
        walk.push(next);
    }
}

#[test]
fn no_modules_import_each_other_in_a_circle() {
    let sources = sources("src/gpu");
    assert!(sources.len() > 20, "only {} modules were found", sources.len());
    assert_eq!(circle(&sources), None);
}

#[test]
fn a_planted_circle_is_found() {
    for (module, line) in [
        ("device", "use super::pipeline::Pipelines;"),
        ("device", "use crate::gpu::{check, buffer::{self, Buffer}};"),
        ("device", "use super::Image;"),
        ("target", "fn f(_: &super::recorder::Recorder) {}"),
        ("instance", "use super::context::Gpu;"),
    ] {
        let mut sources = sources("src/gpu");
        sources.entry(module.to_owned()).and_modify(|text| *text = format!("{line}\n{text}"));
        let found = circle(&sources).unwrap_or_default();
        assert!(found.iter().any(|name| name == module), "after `{line}` in {module}: {found:?}");
    }
}

/// Folders of modules whose root is a file beside them.
fn roots_beside_their_folder(folder: &Path, found: &mut Vec<String>) {
    for path in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).filter(|path| path.is_dir()) {
        if path.with_extension("rs").exists() {
            found.push(path.display().to_string());
        }
        roots_beside_their_folder(&path, found);
    }
}

#[test]
fn the_root_of_a_folder_of_modules_is_its_mod_rs() {
    let mut found = Vec::new();
    roots_beside_their_folder(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut found);
    assert_eq!(found, [""; 0]);
}

#[test]
fn rooms_import_from_the_layers_below() {
    let rooms = rooms();
    assert!(rooms.len() > 20, "only {} rooms were found", rooms.len());
    assert_eq!(against_the_layers(&rooms), [""; 0]);
}

#[test]
fn a_planted_import_from_above_is_found() {
    for (room, line, sentence) in [
        ("settings", "use crate::report::to_json;", "settings imports report"),
        ("passes", "use crate::{Error, frame::{FrameOutputs, build}};", "passes imports frame"),
        ("scene", "fn f(_: &crate::settings::Settings) {}", "scene imports settings"),
        ("attic", "", "attic is in no layer"),
    ] {
        let mut rooms = rooms();
        *rooms.entry(room.to_owned()).or_default() += line;
        assert_eq!(against_the_layers(&rooms), [sentence]);
    }
}
