//! Drivers that offer a portability subset of Vulkan: the loader's way of hiding them, and what they may lack.

mod support;

use std::path::{Path, PathBuf};

use support::{program, run, succeed};

/// Manifests of drivers that the loader would find by itself.
fn manifests() -> Vec<PathBuf> {
    let named = std::env::var_os("VK_DRIVER_FILES").or_else(|| std::env::var_os("VK_ICD_FILENAMES"));
    if let Some(named) = named {
        return std::env::split_paths(&named).collect();
    }
    let folders = ["/usr/share/vulkan/icd.d", "/etc/vulkan/icd.d", "/usr/local/share/vulkan/icd.d"];
    let entries = folders.into_iter().flat_map(std::fs::read_dir).flatten().flatten();
    entries.map(|entry| entry.path()).filter(|path| path.extension().is_some_and(|e| e == "json")).collect()
}

/// A manifest of the same driver that says it is a portability driver, which the loader hides from those that do not ask.
fn as_portability_driver(manifest: &Path) -> Option<String> {
    let text = std::fs::read_to_string(manifest).ok()?;
    let mut json: serde_json::Value = serde_json::from_str(&text).ok()?;
    let icd = json.get_mut("ICD")?.as_object_mut()?;
    let library = icd.get("library_path")?.as_str()?.to_owned();
    if library.starts_with('.') {
        let absolute = manifest.parent()?.join(library);
        icd.insert("library_path".to_owned(), absolute.to_str()?.into());
    }
    icd.insert("is_portability_driver".to_owned(), true.into());
    Some(json.to_string())
}

#[test]
fn portability_drivers_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let written = manifests().into_iter().filter_map(|path| {
        let text = as_portability_driver(&path)?;
        let copy = folder.path().join(path.file_name()?);
        std::fs::write(&copy, text).ok()?;
        Some(copy)
    });
    let copies = std::env::join_paths(written).unwrap();
    if copies.is_empty() {
        println!("skipped: no manifest of a driver was found");
        return;
    }
    let mut command = program();
    command.arg("--list-gpus").env_remove("VK_ICD_FILENAMES").env("VK_DRIVER_FILES", &copies);
    let found = run(command);
    assert_eq!(found.code, Some(0), "the loader hides a driver that is a portability driver: {}", found.stderr);
    let count = |list: &str| list.matches("suitable: ").count();
    assert_eq!(count(&found.stdout), count(&succeed(&["--list-gpus"]).stdout), "{}", found.stdout);
}

/// What a portability subset may lack, as names of Vulkan, ash and GLSL.
const LACKING: [&str; 17] = [
    "TRIANGLE_FAN",
    "PolygonMode::POINT",
    "CONSTANT_ALPHA",
    "CONSTANT_COLOR",
    "ComponentSwizzle",
    ".components(",
    "MUTABLE_FORMAT",
    "TYPE_2D_ARRAY_COMPATIBLE",
    "TYPE_2D_VIEW_COMPATIBLE",
    "mip_lod_bias",
    "compare_enable",
    "stencil_test_enable",
    "cmd_set_event",
    "create_event",
    "TESSELLATION_CONTROL",
    "interpolateAt",
    "sample_rate_shading",
];

/// Uses of what a subset may lack in a text: names, by line.
fn uses(text: &str) -> Vec<(usize, &'static str)> {
    let lines = text.lines().enumerate();
    lines
        .flat_map(|(line, text)| LACKING.into_iter().filter(|name| text.contains(name)).map(move |n| (line + 1, n)))
        .collect()
}

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if entry.is_dir() {
            files(&entry, found);
        } else if entry.extension().is_some_and(|e| e == "rs" || e == "glsl") {
            found.push(entry);
        }
    }
}

#[test]
fn nothing_is_used_that_a_portability_subset_may_lack() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut all = Vec::new();
    ["src/gpu", "src/passes", "shaders"].iter().for_each(|folder| files(&root.join(folder), &mut all));
    assert!(all.len() > 150, "{} files", all.len());
    for path in all {
        let found = uses(&std::fs::read_to_string(&path).unwrap());
        assert!(found.is_empty(), "{}: {found:?}", path.display());
    }
    assert_eq!(uses("a\n.topology(vk::PrimitiveTopology::TRIANGLE_FAN)"), [(2, "TRIANGLE_FAN")]);
}
